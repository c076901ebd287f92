//! What the written estimates obey: reciprocity, closure, no bias, standard errors.

use radiosity::output::FactorEntry;
use radiosity::patches::{GroupBy, Groups, PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::Material;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, GroupFactor, Keep, TraceOptions};

use super::{grouped, open_cube_with_a_sheet, pairs, written};
use crate::scenes::{flipped, grey, quads, unit_square};

#[test]
fn form_factors_between_objects_are_reciprocal_and_close_with_escape() {
    grouped(&open_cube_with_a_sheet(), GroupBy::Object, |table| {
        let scratch = written(table, "f.csv");
        let pairs = pairs(&scratch.path("f.csv"));
        let area = |name: &str| table.groups().all().iter().find(|group| group.name == name).unwrap().area;
        assert!((area("quad 0") - 1.0).abs() < 1e-12 && (area("quad 5") - 0.24).abs() < 1e-12);
        for ((a, b), (form_factor, _)) in &pairs {
            let (there, back) = (area(a) * form_factor, area(b) * pairs[&(b.clone(), a.clone())].0);
            assert!((there - back).abs() <= 2e-8 * there, "{a} {b}: {there} {back}");
        }
        for (a, group) in table.groups().all().iter().enumerate() {
            let row = pairs.iter().filter(|((from, _), _)| *from == group.name);
            let sum: f64 = row.map(|(_, (form_factor, _))| form_factor).sum();
            let FactorEntry { form_factor: escape, standard_error, .. } = table.escape(a);
            assert!((sum + escape - 1.0).abs() < 1e-8, "{}: {sum} {escape}", group.name);
            assert!(standard_error.unwrap() > 0.0, "{}: {escape}", group.name);
            // The sheet's back faces away from what is missing.
            let open = group.name != "quad 5 (back)";
            assert!(escape > 0.02 || !open, "{}: the cube is open: {escape}", group.name);
        }
    });
}

#[test]
fn a_black_speck_and_what_it_sees_know_of_each_other() {
    // No ray of a few thousand from the plate finds the speck; those of the speck find the plate.
    let square = |s: f64, z: f64| [[0.0, 0.0, z], [s, 0.0, z], [s, s, z], [0.0, s, z]];
    let scene = quads(
        &[(square(1.0, 0.0), 0), (flipped(square(1e-3, 1.0)), 0)],
        vec![Material::diffuse("black", &[0.0])],
    );
    grouped(&scene, GroupBy::Object, |table| {
        let [plate, speck] = [0, 1].map(|a| &table.groups().all()[a]);
        assert!((plate.area - 1.0).abs() < 1e-9 && (speck.area - 1e-6).abs() < 1e-15);
        // Howell, C-13: from a point to a parallel unit square, one of whose corners lies below it.
        let exact = 2f64.sqrt().recip().atan() / (std::f64::consts::PI * 2f64.sqrt());
        let FactorEntry { form_factor, standard_error, .. } = table.full_row(1)[0];
        let z = (form_factor - exact) / standard_error.unwrap();
        assert!(z.abs() < 3.5, "{form_factor} for {exact}, z = {z}");
    });
}

#[test]
fn the_balancing_of_noisy_rays_leaves_no_bias() {
    // Many patches of few rays each: without correction the mean is 2 standard errors off.
    let floor = unit_square(0.0);
    let wall = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]];
    let scene = quads(&[(floor, 0), (wall, 0)], grey(0.5));
    let tracer = Tracer::new(&scene);
    const SEEDS: u64 = 20;
    let of_seed = |seed: u64| {
        let options = Tessellation {
            size: PatchSize::Count(4000),
            reach: Reach::Everything,
            seed,
            ..Default::default()
        };
        let mut patches = Patches::new(&tracer, &options).unwrap();
        let options = TraceOptions { rays: Some(64), seed, keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let groups = Groups::new(&patches, GroupBy::Object, |_, _| true);
        let all = factors.between_groups(&patches, groups.of_patch(), Progress::default()).unwrap();
        let GroupFactor { form_factor, standard_error, .. } =
            *all.iter().find(|f| f.from == 0 && f.to == Some(1)).unwrap();
        (form_factor - 0.200043776075403) / standard_error
    };
    let mean = (0..SEEDS).map(of_seed).sum::<f64>() / SEEDS as f64;
    // Student's t with 7 degrees of freedom has variance 7/5.
    assert!(mean.abs() < 3.5 * (1.4 / SEEDS as f64).sqrt(), "mean z {mean}");
}
