//! Lights without area on surfaces: all their light goes to the side in front.

use std::f64::consts::PI;

use glam::DVec3;
use radiosity::measure::Energy;
use radiosity::patches::Basis;
use radiosity::reference::PathTracer;
use radiosity::scene::{Light, Scene};
use radiosity::solve::Problem;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, Sources, TraceOptions};

use super::walls;
use crate::scenes::{BASES, cut_into, flipped, grey, lit_quads, paths, point};
use crate::scratch::Scratch;

/// The room with a light of 1 W·sr⁻¹.
fn room_with_light(position: [f64; 3]) -> Scene {
    lit_quads(&walls(), grey(0.5), vec![point(position, &[1.0])], None)
}

/// Places on the room's surfaces: within a wall, on its diagonal, on an edge, in a corner; and how many of
/// its twelve faces touch each.
const ON_SURFACES: [([f64; 3], usize); 5] = [
    ([0.0, 1.1, 1.3], 1),
    ([0.0, 1.25, 1.5], 2),
    ([1.1, 0.0, 0.0], 2),
    ([3.0, 2.5, 0.0], 4),
    ([1.5, 2.5, 1.5], 2),
];

#[test]
fn a_light_on_a_surface_sends_all_its_light_into_the_room() {
    for (position, _) in ON_SURFACES {
        let scene = room_with_light(position);
        let tracer = Tracer::new(&scene);
        let mut patches = cut_into(&tracer, 400);
        for basis in BASES {
            let options = TraceOptions { rays: Some(64), basis, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
            let solution = problem.solve(&Default::default()).unwrap();
            let energy = Energy::of(&problem, &solution.radiance);
            let off = [&energy.emitted, &energy.absorbed].map(|flux| flux[0] / (4.0 * PI) - 1.0);
            assert!(off.iter().all(|off| off.abs() < 1e-4), "{position:?} {basis:?}: {off:?}");
        }
    }
}

#[test]
fn a_spot_on_a_ceiling_sends_what_its_cone_holds_wherever_it_points() {
    for direction in [DVec3::NEG_Y, DVec3::new(0.6, -0.2, 0.1), DVec3::new(0.1, 0.2, 0.9)] {
        let (position, direction) = (DVec3::new(1.5, 2.5, 1.5), direction.normalize());
        let light = Light::Spot { position, direction, intensity: vec![1.0], cone: 80.0, penumbra: 20.0 };
        let flux = light.flux().unwrap()[0];
        let scene = lit_quads(&walls(), grey(0.5), vec![light], None);
        let tracer = Tracer::new(&scene);
        let patches = cut_into(&tracer, 400);
        for basis in BASES {
            let sources = Sources::trace(&tracer, &patches, basis, &LightOptions::default()).unwrap();
            let direct = basis.means(&sources.direct.unwrap());
            let arrived: f64 = (0..patches.len()).map(|i| patches.area(i) * direct[i]).sum();
            assert!((arrived / flux - 1.0).abs() < 1e-2, "{direction} {basis:?}: {arrived} {flux}");
        }
    }
}

#[test]
fn a_light_on_a_surface_is_named_with_its_face() {
    for (position, touched) in ON_SURFACES {
        let scene = room_with_light(position);
        let warnings = scene.warnings();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].contains("light 1 on face "), "{warnings:?}");
        let more = if touched > 1 { format!(" and {} more", touched - 1) } else { String::new() };
        assert!(warnings[0].ends_with(&format!("){more}")), "{position:?}: {warnings:?}");
        // It is in front, by a hair.
        let moved = scene.lights().next().and_then(Light::position).unwrap();
        let distance = moved.distance(DVec3::from(position));
        assert!((1e-6..1e-5).contains(&distance), "{distance}");
        assert!(moved.cmpgt(DVec3::ZERO).all() && moved.cmplt(DVec3::new(3.0, 2.5, 3.0)).all(), "{moved}");
    }
    let apart = room_with_light([0.001, 1.1, 1.3]);
    assert!(apart.warnings().is_empty());
    assert_eq!(apart.lights().next().and_then(Light::position), Some(DVec3::new(0.001, 1.1, 1.3)));
}

#[test]
fn a_light_beside_a_surface_in_its_plane_neither_loses_light_nor_is_moved() {
    // In the plane of a table's top, but not on it.
    let table = [[0.2, 1.0, 0.2], [0.2, 1.0, 0.9], [0.9, 1.0, 0.9], [0.9, 1.0, 0.2]];
    let all: Vec<_> = walls().into_iter().chain([(table, 0)]).collect();
    let light = point([2.0, 1.0, 1.7], &[1.0]);
    let scene = lit_quads(&all, grey(0.5), vec![light.clone()], None);
    assert!(scene.warnings().is_empty() && scene.lights().eq([&light]));
    let tracer = Tracer::new(&scene);
    let patches = cut_into(&tracer, 400);
    let sources =
        Sources::trace(&tracer, &patches, Basis::Constant, &LightOptions::default()).unwrap().direct.unwrap();
    let flux: f64 = (0..patches.len()).map(|i| patches.area(i) * sources[i]).sum();
    assert!((flux / (4.0 * PI) - 1.0).abs() < 1e-6, "{flux}");
    let on_table = (0..patches.len()).filter(|&i| patches.place(i).face >= 12);
    assert!(on_table.map(|i| sources[i]).all(|h| h == 0.0));
}

#[test]
fn the_path_tracer_finds_the_spot_of_a_light_on_a_surface() {
    for (position, touched) in ON_SURFACES {
        let scene = room_with_light(position);
        let tracer = Tracer::new(&scene);
        let mut patches = cut_into(&tracer, 2000);
        let options = TraceOptions { rays: Some(256), ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
        let solution = problem.solve(&Default::default()).unwrap();
        let expected = patches.average_by_face(&solution.irradiance);
        let traced =
            PathTracer::new(&tracer).irradiance(&patches, &paths(200_000)).unwrap().by_face(&patches);
        let flux = |values: &dyn Fn(usize) -> f64| -> f64 {
            (0..expected.len()).map(|k| expected[k].area * values(k)).sum()
        };
        // All that arrives: Φ / (1 − ρ).
        let off = flux(&|k| traced[k].mean[0]) / (8.0 * PI) - 1.0;
        assert!(off.abs() < 5e-3, "{position:?}: {off}");
        // In edges and corners the spots light each other from nearer than patches tell.
        let mesh = if touched > 2 || position[1] == 0.0 { 0.15 } else { 0.03 };
        for (row, found) in expected.iter().zip(&traced) {
            let off = (found.mean[0] - row.mean[0]).abs();
            let most = mesh * row.mean[0] + 5.0 * found.standard_error[0];
            assert!(off < most, "{position:?} face {}: {} {}", row.face, found.mean[0], row.mean[0]);
        }
    }
}

#[test]
fn between_sheets_back_to_back_a_light_is_before_the_first() {
    let sheet = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]];
    for (first, sign) in [(sheet, 1.0), (flipped(sheet), -1.0)] {
        let both = [(first, 0), (flipped(first), 0)];
        let scene = lit_quads(&both, grey(0.5), vec![point([0.3, 0.0, 0.1], &[1.0])], None);
        let y = scene.lights().next().and_then(Light::position).unwrap().y;
        assert!(sign * y > 0.0, "{y}");
    }
}

#[test]
fn a_light_on_a_ceiling_is_told_of_with_its_settings() {
    let obj = "v -1 2 -1\nv 1 2 -1\nv 1 2 1\nv -1 2 1\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\n\
               o ceiling\nf 1 2 3 4\no floor\nf 5 6 7 8\n";
    let lights: String = (0..5)
        .map(|k| format!("[[light]]\nkind = \"point\"\nposition = [0.{k}, 2, 0.1]\nflux = 1\n"))
        .collect();
    let folder = Scratch::with(&[("room.obj", obj), ("room.toml", lights.as_str())]);
    let scene = Scene::load(folder.path("room.obj")).unwrap();
    let told: Vec<&String> = scene.warnings().iter().filter(|w| w.contains("in the plane")).collect();
    assert_eq!(told.len(), 1, "{:?}", scene.warnings());
    for words in ["5 lights", "light 1 on face ", "object ceiling", "and 2 more"] {
        assert!(told[0].contains(words), "{words}: {}", told[0]);
    }
    assert!(scene.lights().all(|light| light.position().is_some_and(|p| p.y < 2.0)));
}
