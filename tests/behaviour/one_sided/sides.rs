//! A form factor is of one side, over all of its area.

use glam::DVec3;
use radiosity::output::FactorTable;
use radiosity::patches::{GroupBy, Groups, PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Material, Scene, SceneParts, Side};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, TraceOptions};

use super::{Effort, FRONTS, by_object, factor};
use crate::scenes::{flipped, grey, push_triangle, quads};

/// Spheres around the origin, of 128 faces each: radius, and whether fronts are outside.
fn spheres(all: &[(f64, bool)]) -> Scene {
    let mut parts = SceneParts { name: "spheres".into(), materials: grey(0.5), ..Default::default() };
    for (object, &(radius, outwards)) in all.iter().enumerate() {
        parts.objects.push(format!("sphere {object}"));
        let mut faces: Vec<[DVec3; 3]> = Vec::new();
        for signs in 0..8 {
            let sign = |k: u32| if (signs >> k) & 1 == 0 { 1.0 } else { -1.0 };
            let [x, y, z] = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
            faces.push(if sign(0) * sign(1) * sign(2) > 0.0 { [x, y, z] } else { [x, z, y] });
        }
        for _ in 0..2 {
            faces = faces
                .iter()
                .flat_map(|&[a, b, c]| {
                    let [p, q, r] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                    [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
                })
                .collect();
        }
        for [a, b, c] in faces {
            let corners = if outwards { [a, b, c] } else { [a, c, b] };
            push_triangle(&mut parts, corners.map(|p| p * radius), 0, object as u32);
        }
    }
    Scene::new(parts).unwrap()
}

#[test]
fn a_form_factor_is_of_one_side_over_its_whole_area() {
    // Similar polyhedra: F = 1 from the inner one, by the ratio of areas back.
    let scene = spheres(&[(1.0, true), (2.0, false)]);
    by_object(&scene, FRONTS, Effort { patches: 500, rays: 64, seed: 0 }, |table| {
        assert_eq!(table.groups().len(), 2, "backs that nothing reaches have no group");
        let known =
            [("sphere 0", "sphere 1", 1.0), ("sphere 1", "sphere 0", 0.25), ("sphere 1", "sphere 1", 0.75)];
        for (from, to, exact) in known {
            let found = factor(table, from, to);
            assert!((found.form_factor - exact).abs() < 1e-6, "{from} to {to}: {found:?}");
            let error = found.standard_error.unwrap();
            assert!(error > 1e-7 && error < 1e-3, "at least what a ray is worth: {found:?}");
        }
        let alone = factor(table, "sphere 0", "sphere 0");
        assert_eq!(
            (alone.form_factor, alone.upper95),
            (0.0, Some(0.0)),
            "a convex body provably sees nothing of itself"
        );
    });
}

#[test]
fn a_back_is_a_row_of_its_own() {
    let scene = spheres(&[(1.0, true), (2.0, false)]);
    by_object(&scene, Reach::Everything, Effort { patches: 800, rays: 64, seed: 0 }, |table| {
        let names: Vec<&str> = table.groups().all().iter().map(|group| group.name.as_str()).collect();
        assert_eq!(names, ["sphere 0", "sphere 0 (back)", "sphere 1"], "the outer back sees nothing");
        for (name, exact) in [("sphere 0", 1.0), ("sphere 1", 0.25)] {
            let other = if name == "sphere 0" { "sphere 1" } else { "sphere 0" };
            assert!((factor(table, name, other).form_factor - exact).abs() < 1e-6);
        }
        let inside = factor(table, "sphere 0 (back)", "sphere 0 (back)");
        assert!((inside.form_factor - 1.0).abs() < 1e-6, "{inside:?}");
    });
}

#[test]
fn faces_that_see_nothing_count_in_the_area() {
    // One of two floor tiles lies face down: the tiles' front is twice as large as what sees the ceiling.
    let tile = |x: f64| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0]];
    let ceiling = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
    let scene = quads(
        &[(tile(0.0), 0), (flipped(tile(5.0)), 0), (ceiling, 1)],
        vec![Material::diffuse("floor", &[0.5]), Material::diffuse("ceiling", &[0.5])],
    );
    let tracer = Tracer::new(&scene);
    let options = Tessellation { size: PatchSize::Count(300), reach: FRONTS, ..Default::default() };
    let mut patches = Patches::new(&tracer, &options).unwrap();
    let options =
        TraceOptions { rays: Some(256), lamp_rays: Some(0), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let groups = Groups::new(&patches, GroupBy::Material, |_, side| side == Side::Front);
    let between = factors.between_groups(&patches, groups.of_patch(), Progress::default()).unwrap();
    let table = FactorTable::between_groups(&patches, &groups, &between, 256);
    let found = factor(&table, "floor", "ceiling");
    assert!((table.groups().all()[0].area - 2.0).abs() < 1e-12);
    let z = (found.form_factor - 0.5 * 0.199824895698387) / found.standard_error.unwrap();
    assert!(z.abs() < 4.0, "{found:?}, z = {z}");
    let row: f64 = table.full_row(0).iter().map(|entry| entry.form_factor).sum();
    assert!((row + table.escape(0).form_factor - 1.0).abs() < 1e-9);
    let alone = quads(&[(tile(0.0), 0)], vec![Material::diffuse("floor", &[0.5])]);
    assert_eq!(radiosity::patches::seeing_sides(&Tracer::new(&alone)), [[false; 2]; 2]);
}
