//! Glass in water, and surfaces inside glass: Snell's law between solids, a furnace, apparent depth, light
//! paths.

use std::f64::consts::PI;

use glam::DVec3;
use radiosity::measure::{Difference, Energy};
use radiosity::patches::PatchSize;
use radiosity::progress::Progress;
use radiosity::reference::PathTracer;
use radiosity::scene::{Material, Scene};
use radiosity::solve::{self, SolveOptions};
use radiosity::trace::{Hit, Ray, Scattered, Tracer};
use radiosity::transport::{FormFactors, Keep, TraceOptions, Transport};

use crate::finishes::balanced;
use crate::scenes::{BASES, Quad, cut, flipped, paths, quads, room};

const WATER: f64 = 1.33;
const GLASS: f64 = 1.5;

fn block(half: f64, material: u32) -> [([[f64; 3]; 4], u32); 6] {
    room([-half; 3], [half; 3]).map(|quad| (flipped(quad), material))
}

/// A block of the second material in a block of the first, in either order of the file.
fn nested(outer: f64, inner: f64, inner_first: bool) -> Scene {
    let materials =
        vec![Material::dielectric("outer", outer, &[1.0]), Material::dielectric("inner", inner, &[1.0])];
    let (outer, inner) = (block(1.0, 0), block(0.5, 1));
    quads(&if inner_first { [inner, outer] } else { [outer, inner] }.concat(), materials)
}

/// The ways on from where a ray meets the scene next.
fn met<'s>(tracer: &Tracer<'s>, ray: &Ray) -> (Hit, Scattered<'s>, Option<Scattered<'s>>) {
    let hit = tracer.closest_hit(ray).expect("something is met");
    let (first, second) = tracer.ways_on(ray, &hit);
    (hit, first, second)
}

#[test]
fn glass_in_water_bends_light_by_the_ratio_of_their_indices() {
    for inner_first in [false, true] {
        let scene = nested(WATER, GLASS, inner_first);
        let tracer = Tracer::new(&scene);
        // Down through the tops of both, out at the bottoms.
        let start = Ray {
            origin: DVec3::new(-0.8, 1.5, 0.1),
            direction: DVec3::new(0.6, -0.8, 0.0),
            from: Ray::FREE,
        };
        let sine = |way: &Option<Scattered>| way.expect("refracted").ray.direction.x;
        let (_, _, in_water) = met(&tracer, &start);
        assert!((sine(&in_water) - 0.6 / WATER).abs() < 1e-12, "{in_water:?}");
        let (_, _, in_glass) = met(&tracer, &in_water.unwrap().ray);
        assert!((sine(&in_glass) - 0.6 / GLASS).abs() < 1e-12, "{in_glass:?}");
        let (_, _, in_water) = met(&tracer, &in_glass.unwrap().ray);
        assert!((sine(&in_water) - 0.6 / WATER).abs() < 1e-12, "{in_water:?}");
        let (_, _, outside) = met(&tracer, &in_water.unwrap().ray);
        assert!((sine(&outside) - 0.6).abs() < 1e-12, "{outside:?}");
    }
}

#[test]
fn glass_under_water_reflects_all_beyond_the_angle_of_both() {
    let scene = nested(WATER, GLASS, false);
    let tracer = Tracer::new(&scene);
    for (sine, passes) in [(WATER / GLASS - 1e-3, true), (WATER / GLASS + 1e-3, false)] {
        let direction = DVec3::new(sine, (1.0 - sine * sine).sqrt(), 0.0);
        let ray = Ray { origin: DVec3::new(-0.3, 0.3, 0.1), direction, from: Ray::FREE };
        let (_, first, second) = met(&tracer, &ray);
        assert_eq!((second.is_some(), first.share < 1.0), (passes, passes), "{sine}");
    }
}

#[test]
fn glass_in_glass_is_not_there() {
    let scene = nested(GLASS, GLASS, false);
    let tracer = Tracer::new(&scene);
    let direction = DVec3::new(0.6, -0.8, 0.0);
    let ray = Ray { origin: DVec3::new(-0.3, 0.9, 0.1), direction, from: Ray::FREE };
    let (_, reflected, through) = met(&tracer, &ray);
    assert!(reflected.share < 1e-30 && (through.unwrap().ray.direction - direction).length() < 1e-12);
}

#[test]
fn a_hollow_block_of_glass_holds_air() {
    // The inner surface fronts towards the air that it surrounds.
    let hollow = room([-0.5; 3], [0.5; 3]).map(|quad| (quad, 0));
    let scene = quads(&[block(1.0, 0), hollow].concat(), vec![Material::dielectric("glass", GLASS, &[1.0])]);
    let tracer = Tracer::new(&scene);
    let ray = Ray { origin: DVec3::new(-0.4, 0.9, 0.1), direction: DVec3::NEG_Y, from: Ray::FREE };
    let slanted = Ray { direction: DVec3::new(0.3, -0.91f64.sqrt(), 0.0), ..ray };
    let (_, _, in_air) = met(&tracer, &slanted);
    assert!((in_air.unwrap().ray.direction.x - 0.3 * GLASS).abs() < 1e-12);
}

/// A closed cube that glows and reflects half, with these blocks in its middle.
fn furnace_around(blocks: &[([[f64; 3]; 4], u32)], materials: &[Material]) -> Scene {
    let walls = room([-2.0; 3], [2.0; 3]).map(|quad| (quad, 0));
    let materials = [&[Material::lamp("wall", &[0.5], &[1.0])], materials].concat();
    quads(&[&walls[..], blocks].concat(), materials)
}

#[test]
fn a_furnace_stays_a_furnace_around_glass_in_water_and_white_walls_in_it() {
    let blocks = [block(1.2, 1), block(0.8, 2), block(0.4, 3)].concat();
    let scene = furnace_around(
        &blocks,
        &[
            Material::dielectric("water", WATER, &[1.0]),
            Material::dielectric("glass", GLASS, &[1.0]),
            Material::diffuse("white", &[1.0]),
        ],
    );
    let tracer = Tracer::new(&scene);
    for basis in BASES {
        let mut patches = cut(&tracer, PatchSize::Count(300));
        let options = TraceOptions { rays: Some(256), basis, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        for (i, (area, etendue)) in patches.areas().iter().zip(patches.etendues()).enumerate() {
            let is_inside = scene.material_of(patches.place(i).face).name == "white";
            let expected = if is_inside { GLASS * GLASS } else { 1.0 };
            assert!((etendue / area - expected).abs() < 1e-12, "{i}");
        }
        let (solution, energy) = balanced(&patches, &factors);
        assert_eq!((energy.carriers[0], energy.escaped[0]), (0.0, 0.0), "{energy:?}");
        // What was given up on the way is all that can be missing.
        let lost = energy.lost[0] / energy.emitted[0];
        let off = solution.radiance.map(|l| (l - 2.0).abs()).max();
        assert!(lost < 1e-3 && off < 1e-9 + 100.0 * lost, "{off} {lost}");
        // What either of two patches finds of their exchange is the same in the mean.
        let before = factors.exchange().closure().before;
        assert!(before < 0.25, "{before}");
    }
}

#[test]
fn a_lamp_in_glass_is_seen_at_its_apparent_depth() {
    // Up through the surface of a slab: what was h away by d of glass is seen from h + d/n, dimmed by
    // Fresnel's part.
    let (depth, height) = (0.5, 1.0);
    let slab = room([-3.0, -1.0, -3.0], [3.0, 0.0, 3.0]).map(|quad| (flipped(quad), 0));
    // A black lining ends what the surface reflects inwards.
    let is_lid = |quad: &Quad| quad.iter().all(|corner| corner[1] == -0.01);
    let lining = room([-2.9, -0.9, -2.9], [2.9, -0.01, 2.9]).into_iter().filter(|quad| !is_lid(quad));
    let square = |r: f64, y: f64| [[-r, y, -r], [-r, y, r], [r, y, r], [r, y, -r]];
    let squares = [(square(0.05, -depth), 1), (flipped(square(0.1, height)), 2)];
    let faces: Vec<_> = slab.into_iter().chain(squares).chain(lining.map(|quad| (quad, 2))).collect();
    let materials = vec![
        Material::dielectric("glass", GLASS, &[1.0]),
        Material::lamp("lamp", &[0.0], &[100.0]),
        Material::diffuse("black", &[0.0]),
    ];
    let scene = quads(&faces, materials);
    let tracer = Tracer::new(&scene);
    let mut patches = cut(&tracer, PatchSize::Edge(10.0));
    let options = TraceOptions { rays: Some(1 << 19), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let face = |i: usize| patches.place(i).face;
    let side = |i: usize| patches.place(i).side.name() == "front";
    let group = |i: usize| match (face(i), side(i)) {
        (12 | 13, true) => 0,
        (14 | 15, true) => 1,
        _ => 2,
    };
    let groups: Vec<usize> = (0..patches.len()).map(group).collect();
    let found = factors.between_groups(&patches, &groups, Progress::default()).unwrap();
    let seen = found.iter().find(|f| f.from == 1 && f.to == Some(0)).unwrap();
    let passed = 1.0 - ((GLASS - 1.0) / (GLASS + 1.0)).powi(2);
    let exact = passed * 0.01 / (PI * (height + depth / GLASS).powi(2));
    // The squares are small beside their distance, but no points.
    let off = (seen.form_factor - exact).abs();
    assert!(seen.standard_error < 0.02 * exact, "{seen:?}");
    assert!(off < 4.0 * seen.standard_error + 0.01 * exact, "{seen:?} {exact}");
    // What arrives is what such a lamp sends, n² times as much as in air.
    let k = Transport::of(&factors, &patches).unwrap();
    let e = patches.emitted_radiance();
    let solution = solve::solve(&k, &e, &SolveOptions::default()).unwrap();
    let energy = Energy::new(&k, &e, &solution.radiance);
    assert!((energy.emitted[0] / (PI * 100.0 * 0.01 * GLASS * GLASS) - 1.0).abs() < 1e-9, "{energy:?}");
    assert!(energy.imbalance < 1e-9, "{energy:?}");
}

#[test]
fn the_matrix_agrees_with_light_paths_where_a_lamp_and_walls_are_in_glass_in_water() {
    let walls = room([-2.0; 3], [2.0; 3]).map(|quad| (quad, 0));
    let lamp = [[-0.3, 0.3, -0.3], [0.3, 0.3, -0.3], [0.3, 0.3, 0.3], [-0.3, 0.3, 0.3]];
    let floor = room([-0.5, -0.5, -0.5], [0.5, -0.3, 0.5]).map(|quad| (flipped(quad), 1));
    let faces = [&walls[..], &block(1.2, 2), &block(0.8, 3), &floor, &[(lamp, 4)]].concat();
    let materials = vec![
        Material::diffuse("wall", &[0.6]),
        Material::diffuse("floor", &[0.8]),
        Material::dielectric("water", WATER, &[1.0]),
        Material::dielectric("glass", GLASS, &[1.0]),
        Material::lamp("lamp", &[0.2], &[10.0]),
    ];
    let scene = quads(&faces, materials);
    let tracer = Tracer::new(&scene);
    let mut patches = cut(&tracer, PatchSize::Count(1000));
    let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap();
    let k = Transport::of(&factors, &patches).unwrap();
    let solution = solve::solve(&k, &patches.emitted_radiance(), &SolveOptions::default()).unwrap();
    let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(2_000_000)).unwrap();
    let difference = Difference::new(&solution.irradiance, &traced);
    assert!(difference.bias.abs() < 0.005 + 3.0 * difference.bias_error, "{difference:?}");
    assert!(difference.rms < 0.04 + 2.0 * difference.uncertainty, "{difference:?}");
}
