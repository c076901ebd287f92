//! Which side of a surface a light is on is geometry: however lamps are turned they light neither their own
//! backs nor their insides, and a light without area on a surface gives all its light to the side in front of
//! it.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use radiosity::measure::Energy;
use radiosity::patches::{Basis, FaceRow, PatchSize, Patches, Tessellation};
use radiosity::reference::{Budget, PathOptions, PathTracer};
use radiosity::scene::{Face, FaceState, Light, Material, Scene, SceneParts, Side};
use radiosity::solve::{self, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, Sources, TraceOptions, Transport};

use crate::scenes::{BASES, flipped, lit_quads, quads, room};
use crate::scratch::Scratch;

/// Radiance of lamps, W·sr⁻¹·m⁻².
const LAMP: f64 = 30.0;

/// Materials: grey walls of reflectance 0.5, lamps of 0.2.
fn materials() -> Vec<Material> {
    vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.2], &[LAMP])]
}

/// A closed room of 3 × 2.5 × 3 m, twelve faces.
fn walls() -> Vec<([[f64; 3]; 4], u32)> {
    room([0.0; 3], [3.0, 2.5, 3.0]).map(|quad| (quad, 0)).to_vec()
}

/// The walls, and triangles that emit.
fn room_with(lamps: &[[DVec3; 3]]) -> Scene {
    let scene = quads(&walls(), materials());
    let mut parts = SceneParts {
        name: "room with lamps".into(),
        vertices: scene.vertices().to_vec(),
        faces: scene.faces().to_vec(),
        materials: materials(),
        objects: vec!["all".into(); 6],
        ..Default::default()
    };
    for corners in lamps {
        let first = parts.vertices.len() as u32;
        parts.vertices.extend(corners);
        let vertices = [first, first + 1, first + 2];
        parts.faces.push(Face { vertices, normals: None, material: 1, object: 0, state: FaceState::Kept });
    }
    Scene::new(parts).unwrap()
}

/// The two triangles of a quad.
fn triangles([a, b, c, d]: [DVec3; 4]) -> [[DVec3; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// A rotation for every number.
fn rotation(k: u32) -> DQuat {
    let x = f64::from(k);
    DQuat::from_euler(glam::EulerRot::XYZ, 0.3 + 1.1 * x, 0.5 + 2.3 * x, 0.7 + 0.9 * x)
}

/// The box of half-width 0.2 m in the room's middle, turned, its fronts outside.
fn box_lamp(turn: DQuat) -> Vec<[DVec3; 3]> {
    let place = |p: [f64; 3]| turn * DVec3::from(p) + DVec3::new(1.5, 1.5, 1.5);
    let sides = room([-0.2; 3], [0.2; 3]).map(|quad| triangles(flipped(quad).map(place)));
    sides.concat()
}

/// A ball of radius 0.2 m in the room's middle: 16 × 8 quads, its fronts outside.
fn ball_lamp() -> Vec<[DVec3; 3]> {
    let point = |i: u32, j: u32| {
        let ((s, c), (t, u)) = ((f64::from(j) * PI / 8.0).sin_cos(), (f64::from(i) * TAU / 16.0).sin_cos());
        DVec3::new(1.5 + 0.2 * s * u, 1.5 + 0.2 * c, 1.5 - 0.2 * s * t)
    };
    let quad =
        |i: u32, j: u32| triangles([point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)]);
    let all = (0..8).flat_map(|j| (0..16).flat_map(move |i| quad(i, j)));
    all.filter(|[a, b, c]| (b - a).cross(c - a).length() > 1e-6).collect()
}

/// Irradiance by face; the energy must balance.
fn irradiance(scene: &Scene, basis: Basis, [rays, lamp_rays]: [u32; 2], seed: u64) -> Vec<FaceRow> {
    let tracer = Tracer::new(scene);
    let size = PatchSize::Count(600);
    let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
    let options =
        TraceOptions { rays: Some(rays), lamp_rays: Some(lamp_rays), basis, seed, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let k = Transport::of(&factors, &patches).unwrap();
    let e = basis.coefficients_of(&patches.emitted_radiance());
    let solution = solve::solve(&k, &e, &Default::default()).unwrap();
    let energy = Energy::new(&k, &e, &solution.radiance);
    assert!(energy.imbalance < 1e-9, "{energy:?}");
    patches.average_by_face(&basis.means(&solution.irradiance))
}

/// Mean irradiance of each face's side over seeds, with its standard error.
fn over_seeds(scene: &Scene, rays: [u32; 2], seeds: std::ops::Range<u64>) -> Vec<(FaceRow, f64)> {
    let all: Vec<Vec<FaceRow>> = seeds.map(|seed| irradiance(scene, Basis::Constant, rays, seed)).collect();
    let n = all.len() as f64;
    let row = |k: usize| {
        let values = all.iter().map(|rows| rows[k].mean[0]);
        let mean = values.clone().sum::<f64>() / n;
        let variance = values.map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (FaceRow { mean: vec![mean], ..all[0][k].clone() }, (variance / n).sqrt())
    };
    (0..all[0].len()).map(row).collect()
}

/// Irradiance of the sides of one kind on faces from number `first` on.
fn of_lamps(rows: &[FaceRow], first: usize, side: Side) -> Vec<f64> {
    rows.iter().filter(|row| row.face >= first && row.side == side).map(|row| row.mean[0]).collect()
}

#[test]
fn a_tilted_lamp_lights_the_room_and_not_its_own_back() {
    let scene = Scene::load(format!("{}/tests/data/tilted_lamp.obj", env!("CARGO_MANIFEST_DIR"))).unwrap();
    for basis in BASES {
        let rows = irradiance(&scene, basis, [512, 256], 0);
        let backs = of_lamps(&rows, 12, Side::Back);
        assert!(backs.len() == 2 && backs.iter().all(|h| (0.315..0.345).contains(h)), "{basis:?} {backs:?}");
        // The walls get as much as where lamps are found by rays alone.
        let rays = irradiance(&scene, basis, [4096, 0], 1);
        let on_walls = |rows: &[FaceRow]| -> f64 {
            rows.iter().filter(|row| row.face < 12).map(|row| row.area * row.mean[0]).sum()
        };
        let off = on_walls(&rows) / on_walls(&rays) - 1.0;
        assert!(off.abs() < 2e-3, "{basis:?} {off}");
    }
}

#[test]
fn no_lamp_lights_its_own_back_at_any_tilt() {
    for k in 0..24 {
        let turn = rotation(k);
        let place = |x: f64, z: f64| turn * DVec3::new(x, 0.0, z) + DVec3::new(1.5, 1.3, 1.5);
        let both = triangles([place(-0.3, -0.3), place(0.3, -0.3), place(0.3, 0.3), place(-0.3, 0.3)]);
        for lamps in [&both[..], &both[..1]] {
            let rows = irradiance(&room_with(lamps), Basis::Constant, [64, 64], 0);
            let emitted = PI * LAMP * 0.18 * lamps.len() as f64;
            // Light that is reflected by the walls: no more than a room of this reflectance has all over.
            let most = 1.2 * 0.5 / (1.0 - 0.5) * emitted / 48.0;
            let backs = of_lamps(&rows, 12, Side::Back);
            assert!(backs.iter().all(|&h| h < most), "turn {k}, {}: {backs:?} {most}", lamps.len());
        }
    }
}

#[test]
fn no_light_gets_into_a_sealed_lamp_however_it_is_turned() {
    for k in 0..12 {
        let rows = irradiance(&room_with(&box_lamp(rotation(k))), Basis::Constant, [64, 64], 0);
        assert_eq!(of_lamps(&rows, 12, Side::Front).len(), 12);
        let inside = of_lamps(&rows, 12, Side::Back);
        assert!(inside.is_empty(), "turn {k}: {inside:?}");
    }
    let rows = irradiance(&room_with(&ball_lamp()), Basis::Constant, [64, 64], 0);
    assert_eq!((of_lamps(&rows, 12, Side::Front).len(), of_lamps(&rows, 12, Side::Back).len()), (224, 0));
}

/// Means that differ by more than noise: Student's t with as many degrees of freedom is beyond this once in
/// 10⁵ cases.
fn assert_same(found: &[(FaceRow, f64)], expected: &[(FaceRow, f64)], what: &str) {
    const MOST: f64 = 6.0;
    assert_eq!(found.len(), expected.len(), "{what}");
    let mut squares = 0.0;
    for ((a, error_a), (b, error_b)) in found.iter().zip(expected) {
        assert_eq!((a.face, a.side), (b.face, b.side), "{what}");
        let z = (a.mean[0] - b.mean[0]) / error_a.hypot(*error_b);
        squares += z * z;
        assert!(z.abs() < MOST, "{what}: face {} {:?}: {} {}", a.face, a.side, a.mean[0], b.mean[0]);
    }
    let rms = (squares / found.len() as f64).sqrt();
    assert!(rms < 1.6, "{what}: root mean square of z {rms}");
}

#[test]
fn a_ball_of_lamps_gets_on_each_face_what_rays_alone_find() {
    let scene = room_with(&ball_lamp());
    let found = over_seeds(&scene, [128, 64], 0..12);
    let by_rays = over_seeds(&scene, [1024, 0], 100..112);
    assert_same(&found, &by_rays, "ball");
}

#[test]
fn irradiance_does_not_change_as_the_scene_is_turned() {
    let lamps = box_lamp(rotation(1));
    let level = over_seeds(&room_with(&lamps), [128, 128], 0..12);
    for k in [3, 4] {
        let scene = room_with(&lamps);
        let turned = SceneParts {
            name: "turned".into(),
            vertices: scene.vertices().iter().map(|&p| rotation(k) * p).collect(),
            faces: scene.faces().to_vec(),
            materials: materials(),
            objects: vec!["all".into(); 6],
            ..Default::default()
        };
        let turned = over_seeds(&Scene::new(turned).unwrap(), [128, 128], 50..62);
        assert_same(&turned, &level, &format!("turn {k}"));
    }
}

/// The room with a light of 1 W·sr⁻¹.
fn room_with_light(position: [f64; 3]) -> Scene {
    let light = Light::Point { position: position.into(), intensity: vec![1.0] };
    lit_quads(&walls(), vec![Material::diffuse("grey", &[0.5])], vec![light], None)
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
        let size = PatchSize::Count(400);
        let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
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
        let scene = lit_quads(&walls(), vec![Material::diffuse("grey", &[0.5])], vec![light], None);
        let tracer = Tracer::new(&scene);
        let size = PatchSize::Count(400);
        let patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
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
    let light = Light::Point { position: DVec3::new(2.0, 1.0, 1.7), intensity: vec![1.0] };
    let scene = lit_quads(&all, vec![Material::diffuse("grey", &[0.5])], vec![light.clone()], None);
    assert!(scene.warnings().is_empty() && scene.lights().eq([&light]));
    let tracer = Tracer::new(&scene);
    let size = PatchSize::Count(400);
    let patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
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
        let size = PatchSize::Count(2000);
        let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
        let options = TraceOptions { rays: Some(256), ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
        let solution = problem.solve(&Default::default()).unwrap();
        let expected = patches.average_by_face(&solution.irradiance);
        let budget = Budget { paths: Some(200_000), ..Default::default() };
        let options = PathOptions { budget, ..Default::default() };
        let traced = PathTracer::new(&tracer).irradiance(&patches, &options).unwrap().by_face(&patches);
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
    let light = || Light::Point { position: DVec3::new(0.3, 0.0, 0.1), intensity: vec![1.0] };
    for (first, sign) in [(sheet, 1.0), (flipped(sheet), -1.0)] {
        let both = [(first, 0), (flipped(first), 0)];
        let scene = lit_quads(&both, vec![Material::diffuse("grey", &[0.5])], vec![light()], None);
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

#[test]
fn whatever_is_in_part_in_front_of_a_lamp_is_lit_by_it_beside_other_lamps() {
    // A dim lamp that shines on the floor near by, and a tiny bright one whose plane cuts through patches of
    // all walls.
    let dim = [[0.4, 0.5, 0.4], [0.6, 0.5, 0.4], [0.6, 0.5, 0.6], [0.4, 0.5, 0.6]].map(DVec3::from_array);
    let at = DVec3::new(1.4, 1.3, 1.6);
    for turn in (0..4).map(rotation) {
        let corner = |[x, z]: [f64; 2]| at + turn * DVec3::new(1e-3 * x, 0.0, 1e-3 * z);
        let bright = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(corner);
        let normal = turn * DVec3::Y;
        let mut quads = walls();
        quads.extend([(dim.map(|p| p.to_array()), 1), (bright.map(|p| p.to_array()), 2)]);
        let materials = ["wall", "dim", "bright"].into_iter().zip([0.0, 3.0, 1e5]);
        let materials = materials.map(|(name, radiance)| Material::lamp(name, &[0.0], &[radiance])).collect();
        let scene = crate::scenes::quads(&quads, materials);
        let tracer = Tracer::new(&scene);
        let (mut in_front, mut missing) = (0, 0);
        for seed in 0..4 {
            let size = PatchSize::Edge(0.9);
            let patches = Patches::new(&tracer, &Tessellation { size, seed, ..Default::default() }).unwrap();
            let points =
                (0..30).flat_map(|i| (0..30 - i).map(move |j| [i, j].map(|k| (f64::from(k) + 0.3) / 30.0)));
            for (face, point) in (0..12).flat_map(|face| points.clone().map(move |point| (face, point))) {
                if normal.dot(patches.point(face, point) - at) > 0.25 {
                    in_front += 1;
                    missing += usize::from(patches.patch_at(face, Side::Front, point).is_none());
                }
            }
        }
        assert!(in_front > 1000 && missing == 0, "{missing} of {in_front}");
    }
}
