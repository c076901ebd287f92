//! Mirrors and glass, on the way between patches: closed forms, another renderer, and the path tracer's own
//! route.

use std::io::Cursor;

use glam::DVec3;
use radiosity::measure::RelativeRms;
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::progress::Progress;
use radiosity::reference::ReferenceRow;
use radiosity::render::{self, RenderOptions, Shading};
use radiosity::scene::{Camera, Material, Scene};
use radiosity::solve::{self, SolveOptions};
use radiosity::trace::{Destination, Ray, Tracer};
use radiosity::transport::{
    FactorsFileError, FormFactors, Keep, Plan, StorageKind, TraceOptions, Transport, TransportError,
};

use crate::finishes::{balanced, light_paths_from_two};
use crate::scenes::{BASES, cut, facing, flipped, load, quads, reference, room, unit_square};
use crate::scratch::Scratch;

/// A closed cube that glows and reflects half, with a box of the second material in its middle.
fn furnace_around(inside: Material) -> Scene {
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let block = room([0.3, 0.35, 0.25], [0.7, 0.6, 0.65]).map(|quad| (flipped(quad), 1));
    quads(&[walls, block].concat(), vec![Material::lamp("wall", &[0.5], &[1.0]), inside])
}

#[test]
fn a_furnace_stays_a_furnace_around_mirrors_and_glass_that_absorb_nothing() {
    for inside in [Material::mirror("mirror", &[1.0]), Material::dielectric("glass", 1.5, &[1.0])] {
        let scene = furnace_around(inside);
        assert_eq!(scene.warnings(), [""; 0]);
        let tracer = Tracer::new(&scene);
        for basis in BASES {
            let mut patches = cut(&tracer, PatchSize::Count(300));
            let options = TraceOptions { rays: Some(256), basis, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let (solution, energy) = balanced(&patches, &factors);
            assert_eq!((energy.carriers[0], energy.escaped[0]), (0.0, 0.0), "{energy:?}");
            // What was given up on the way is all that can be missing.
            let lost = energy.lost[0] / energy.emitted[0];
            assert!(lost < 1e-3, "{lost}");
            let off = solution.radiance.map(|l| (l - 2.0).abs()).max();
            assert!(off < 1e-9 + 100.0 * lost, "{off} {lost}");
        }
        // And by the path tracer's own route.
        let z = light_paths_from_two(&tracer, 200_000);
        assert!(z.abs() < 4.0, "{z}");
    }
}

#[test]
fn a_plate_sees_its_image_in_a_mirror_as_far_behind_it() {
    // A unit square glows below a mirror of the same size at half the distance: it sees itself at distance 1,
    // dimmed once.
    let materials = vec![Material::lamp("plate", &[0.5], &[1.0]), Material::mirror("mirror", &[0.8])];
    let scene = quads(&[(unit_square(0.0), 0), (flipped(unit_square(0.5)), 1)], materials);
    let tracer = Tracer::new(&scene);
    for basis in BASES {
        let mut patches = cut(&tracer, PatchSize::Edge(0.2));
        let options = TraceOptions {
            rays: Some(512),
            lamp_rays: Some(0),
            basis,
            keep: Keep::Rays,
            ..Default::default()
        };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let groups = vec![0; patches.len()];
        let found = factors.between_groups(&patches, &groups, Progress::default()).unwrap();
        let own = found.iter().find(|f| f.to == Some(0)).unwrap();
        let z = (own.form_factor - 0.8 * facing(1.0)) / own.standard_error;
        assert!(z.abs() < 4.0 && own.standard_error < 0.01 * own.form_factor, "{own:?}");
        // The mirror keeps a fifth of what meets it.
        let exchange = factors.exchange();
        let absorbed: f64 = (0..exchange.len()).map(|i| exchange.absorbed(i)).sum();
        let area: f64 = exchange.areas().sum();
        let exact = 0.2 * facing(0.5);
        assert!((absorbed / area / exact - 1.0).abs() < 0.02, "{} {exact}", absorbed / area);
        assert!(exchange.closure_error() < 1e-9);
        assert_eq!(exchange.reciprocity_error(), 0.0);
    }
}

#[test]
fn a_patch_sees_itself_in_a_mirror_whatever_the_storage() {
    // Two patches so near to their images that each sees its own above all.
    let materials = vec![Material::lamp("plate", &[0.5], &[1.0]), Material::mirror("mirror", &[0.8])];
    let scene = quads(&[(unit_square(0.0), 0), (flipped(unit_square(0.1)), 1)], materials);
    let tracer = Tracer::new(&scene);
    for (basis, storage) in [
        (Basis::Constant, StorageKind::Dense),
        (Basis::Constant, StorageKind::Sparse),
        (Basis::Linear, StorageKind::Dense),
        (Basis::Linear, StorageKind::Sparse),
    ] {
        let mut patches = cut(&tracer, PatchSize::Edge(2.0));
        assert_eq!(patches.len(), 2);
        let options =
            TraceOptions { rays: Some(1 << 13), basis, storage, keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let found = factors.between_groups(&patches, &[0, 0], Progress::default()).unwrap();
        let own = found.iter().find(|f| f.to == Some(0)).unwrap();
        let z = (own.form_factor - 0.8 * facing(0.2)) / own.standard_error;
        assert!(z.abs() < 4.0 && own.standard_error < 0.01 * own.form_factor, "{storage:?} {own:?} {z}");
    }
}

#[test]
fn glass_as_thin_as_air_is_not_there() {
    let scene = furnace_around(Material::dielectric("air", 1.0, &[1.0]));
    let empty = furnace_around(Material::mirror("mirror", &[1.0]));
    let (with, mirrors) = (Tracer::new(&scene), Tracer::new(&empty));
    let mut met = 0;
    for k in 0..2000u32 {
        let angle = f64::from(k) * 2.399_963;
        let z = 1.0 - (f64::from(k) + 0.5) / 1000.0;
        let radius = (1.0 - z * z).sqrt();
        let direction = DVec3::new(radius * angle.cos(), radius * angle.sin(), z);
        let ray = Ray { origin: DVec3::new(-0.8, -0.7, -0.75), direction, from: Ray::FREE };
        met += u32::from(mirrors.closest_hit(&ray).is_some_and(|hit| mirrors.is_carrier(hit.face)));
        let end = with.destination(&ray, |_| [0.5; 4], |_, _| true);
        let Destination::Diffuse { hit, .. } = end else { panic!("{end:?}") };
        // The walls are where the unit cube's are, whatever stands between.
        let wall = (0..12u32).filter(|&f| f == hit.face).count();
        let straight = ray.origin + direction * distance_to_walls(ray.origin, direction);
        let [a, b, c] = *with.corners(hit.face as usize);
        let place = a + (b - a) * hit.barycentrics[0] + (c - a) * hit.barycentrics[1];
        assert!(wall == 1 && place.distance(straight) < 1e-9, "{place} {straight}");
    }
    assert!(met > 50, "{met} rays met the block");
}

/// How far it is from a point inside the cube [-1, 1]³ to its walls.
fn distance_to_walls(origin: DVec3, direction: DVec3) -> f64 {
    (0..3)
        .map(|axis| (direction[axis].signum() - origin[axis]) / direction[axis])
        .fold(f64::INFINITY, f64::min)
}

fn table(name: &str, scene: &Scene) -> Vec<ReferenceRow> {
    reference(name).into_iter().filter(|row| scene.is_diffuse(row.face)).collect()
}

/// Relative RMS error of irradiance on the faces of some object, or on all, at default settings.
fn error_against(name: &str, scene: &Scene, object: Option<&str>) -> f64 {
    let tracer = Tracer::new(scene);
    let mut patches = Patches::new(&tracer, &Tessellation::default()).unwrap();
    let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap();
    let k = Transport::of(&factors, &patches).unwrap();
    let solution = solve::solve(&k, &patches.emitted_radiance(), &SolveOptions::default()).unwrap();
    let of_object = |face: usize| {
        object.is_none_or(|object| scene.objects()[scene.faces()[face].object as usize] == object)
    };
    let mut reference = table(name, scene);
    reference.retain(|row| of_object(row.face));
    RelativeRms::of(&patches.average_by_face(&solution.irradiance), &reference).value
}

#[test]
fn irradiance_agrees_with_another_renderer_where_light_arrives_by_a_mirror() {
    let error = error_against("mirror_room", &load("tests/data/mirror_room.obj"), None);
    assert!(error < 0.015, "{error}");
}

#[test]
fn irradiance_agrees_with_another_renderer_on_a_floor_under_glass_balls() {
    let error = error_against("glass_balls", &load("meshes/glass_balls.obj"), Some("floor"));
    assert!(error < 0.03, "{error}");
}

#[test]
fn irradiance_agrees_with_another_renderer_where_rough_metals_of_any_colour_pass_light_on() {
    let error = error_against("glossy_floor", &load("meshes/glossy_floor.obj"), None);
    assert!(error < 0.008, "{error}");
}

#[test]
fn every_shading_shows_the_lamp_behind_the_camera_in_the_mirror_before_it() {
    let square = |z: f64| [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
    let lamp = Material::lamp("lamp", &[0.0; 3], &[2.0, 1.0, 0.5]);
    let mirror = Material::mirror("mirror", &[0.5, 0.6, 0.7]);
    let scene = quads(&[(square(0.0), 0), (flipped(square(2.0)), 1)], vec![lamp, mirror]);
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.5));
    let camera = Camera { position: DVec3::Z, target: DVec3::new(0.1, 0.0, 2.0), up: DVec3::Y, fov: 10.0 };
    for shading in [Shading::Flat, Shading::Smooth, Shading::Gather, Shading::Path] {
        let options = RenderOptions { width: 8, height: 6, shading, samples: 4, ..Default::default() };
        let picture =
            render::picture(&tracer, &patches, &patches.emitted_radiance(), &camera, &options).unwrap();
        for pixel in &picture.pixels {
            for (seen, shown) in pixel.iter().zip([1.0f32, 0.6, 0.35]) {
                assert!((seen - shown).abs() < 1e-5, "{shading:?}: {pixel:?}");
            }
        }
    }
}

#[test]
fn saved_form_factors_know_the_mirrors_they_were_traced_with() {
    let scene = load("meshes/mirror_room.obj");
    let tracer = Tracer::new(&scene);
    for basis in BASES {
        let mut patches = cut(&tracer, PatchSize::Count(300));
        let options = TraceOptions { rays: Some(64), basis, keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let mut file = Vec::new();
        factors.save(&patches, &mut file).unwrap();
        let load = |tracer: &Tracer| {
            let read = FormFactors::load(
                &mut Cursor::new(&file),
                tracer,
                &Tessellation::default(),
                StorageKind::Auto,
                Keep::Rays,
            );
            read.map(|(_, factors, reuse)| {
                let exchange = factors.exchange();
                let kept = (0..exchange.len()).map(|i| [exchange.absorbed(i), exchange.lost(i)]);
                (kept.collect::<Vec<_>>(), reuse.balanced)
            })
        };
        let exchange = factors.exchange();
        let kept: Vec<_> = (0..exchange.len()).map(|i| [exchange.absorbed(i), exchange.lost(i)]).collect();
        assert!(kept.iter().any(|kept| kept[0] > 0.0));
        assert_eq!(load(&tracer).unwrap(), (kept, true));
    }
    let scratch = Scratch::with(&[
        (
            "mirror_room.obj",
            &std::fs::read_to_string(format!("{}/meshes/mirror_room.obj", env!("CARGO_MANIFEST_DIR")))
                .unwrap(),
        ),
        (
            "mirror_room.mtl",
            &std::fs::read_to_string(format!("{}/meshes/mirror_room.mtl", env!("CARGO_MANIFEST_DIR")))
                .unwrap()
                .replace("Ks 0.95 0.95 0.95", "Ks 0.5 0.5 0.5"),
        ),
    ]);
    let dimmer = Scene::load(scratch.path("mirror_room.obj")).unwrap();
    let tracer_of_dimmer = Tracer::new(&dimmer);
    let mut patches = cut(&tracer, PatchSize::Count(300));
    let options = TraceOptions { rays: Some(8), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let mut file = Vec::new();
    factors.save(&patches, &mut file).unwrap();
    let read = FormFactors::load(
        &mut Cursor::new(&file),
        &tracer_of_dimmer,
        &Tessellation::default(),
        StorageKind::Auto,
        Keep::Nothing,
    );
    assert_eq!(read.map(|_| ()).unwrap_err(), TransportError::File(FactorsFileError::OtherScene));
}

#[test]
fn the_plan_simulates_what_mirrors_and_glass_call_for() {
    let on = |name: &str| -> Vec<&str> {
        let plan = Plan::new(&load(name));
        let carriers = ["mirror", "dielectric", "caustics"];
        plan.effects.iter().filter(|e| e.on && carriers.contains(&e.effect)).map(|e| e.effect).collect()
    };
    assert_eq!(on("meshes/mirror_room.obj"), ["mirror", "caustics"]);
    assert_eq!(on("meshes/glass_balls.obj"), ["dielectric", "caustics"]);
    assert_eq!(on("meshes/cornell_box.obj"), [""; 0]);
    // Coloured ones make channels differ.
    let colour = |ks: [f64; 3]| {
        let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
        let plan = Plan::new(&quads(&walls, vec![Material::mirror("gold", &ks)]));
        let effect = plan.effects.iter().find(|e| e.effect == "carrier colour").unwrap();
        (effect.on, effect.reason.contains("gold"))
    };
    assert_eq!(colour([0.9, 0.8, 0.3]), (true, true));
    assert_eq!(colour([0.9; 3]), (false, false));
}
