//! Lamps at any tilt light the room, and neither their own backs nor their insides.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use radiosity::measure::Energy;
use radiosity::patches::{Basis, FaceRow, PatchSize, Patches, Tessellation};
use radiosity::scene::{Material, Scene, SceneParts, Side};
use radiosity::solve;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions, Transport};

use super::walls;
use crate::scenes::{BASES, cut_into, flipped, load, moved, parts_of, push_triangle, quads, room};

/// Radiance of lamps, W·sr⁻¹·m⁻².
const LAMP: f64 = 30.0;

/// Materials: grey walls of reflectance 0.5, lamps of 0.2.
fn materials() -> Vec<Material> {
    vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.2], &[LAMP])]
}

/// The walls, and triangles that emit.
fn room_with(lamps: &[[DVec3; 3]]) -> Scene {
    let objects = vec!["all".into(); 6];
    let mut parts = SceneParts { objects, ..parts_of(&quads(&walls(), materials())) };
    for &corners in lamps {
        push_triangle(&mut parts, corners, 1, 0);
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
    let mut patches = cut_into(&tracer, 600);
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
    let scene = load("tests/data/tilted_lamp.obj");
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
        let turned = moved(&room_with(&lamps), |p| rotation(k) * p);
        let turned = over_seeds(&turned, [128, 128], 50..62);
        assert_same(&turned, &level, &format!("turn {k}"));
    }
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
