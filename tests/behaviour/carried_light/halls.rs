//! A hall with every kind of carrier and light: light paths find the same, and no energy is lost.

use glam::DVec3;
use radiosity::measure::Energy;
use radiosity::patches::{Basis, PatchSize};
use radiosity::reference::PathTracer;
use radiosity::scene::{Light, Material, Scene, Sky, SkyKind};
use radiosity::solve::{DirectOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, TraceOptions};

use super::{standard_errors, trace};
use crate::scenes::{BASES, cut, flipped, lit_quads, on_threads, paths, point, room};

/// A room with such walls, a thick window in its roof, a mirror and a block of brushed metal in it, all
/// coloured, and every kind of light around and within.
fn hall(wall: Material) -> Scene {
    let [left, bottom, front, right, top, back] = room([0.0; 3], [3.0; 3]);
    let roof = |x: [f64; 2], z: [f64; 2]| {
        [[x[0], 3.0, z[0]], [x[1], 3.0, z[0]], [x[1], 3.0, z[1]], [x[0], 3.0, z[1]]]
    };
    assert_eq!(top[0][1], 3.0);
    let mut quads = [left, bottom, front, right, back].map(|quad| (quad, 0)).to_vec();
    quads.extend([roof([0.0, 1.0], [0.0, 3.0]), roof([2.0, 3.0], [0.0, 3.0])].map(|quad| (quad, 0)));
    quads.extend([roof([1.0, 2.0], [0.0, 1.0]), roof([1.0, 2.0], [2.0, 3.0])].map(|quad| (quad, 0)));
    quads.extend(room([1.0, 3.01, 1.0], [2.0, 3.1, 2.0]).map(|quad| (flipped(quad), 1)));
    quads.push(([[0.01, 0.5, 0.5], [0.01, 2.5, 0.5], [0.01, 2.5, 2.5], [0.01, 0.5, 2.5]], 2));
    quads.extend(room([1.8, 0.0, 0.4], [2.4, 0.6, 1.0]).map(|quad| (flipped(quad), 3)));
    let spot = Light::Spot {
        position: DVec3::new(2.6, 2.0, 1.4),
        direction: DVec3::new(-1.0, -0.2, 0.1).normalize(),
        intensity: vec![3.0, 2.0],
        cone: 30.0,
        penumbra: 10.0,
    };
    let sun = Light::Sun {
        direction: DVec3::new(-0.3, -1.0, 0.1).normalize(),
        irradiance: vec![20.0, 15.0],
        diameter: 1.0,
    };
    lit_quads(
        &quads,
        vec![
            wall,
            Material::dielectric("glass", 1.5, &[0.95, 0.9]),
            Material::mirror("mirror", &[0.9, 0.6]),
            Material::conductor("metal", 0.4, &[0.8, 0.5]),
        ],
        vec![point([1.2, 1.0, 2.0], &[1.0, 0.7]), spot, sun],
        Some(Sky { kind: SkyKind::Overcast, up: DVec3::Y, zenith: vec![2.0, 3.0], ground: 0.3 }),
    )
}

#[test]
fn light_paths_and_photons_find_the_same_on_every_black_patch() {
    agree_on_black(hall(Material::diffuse("wall", &[0.0; 2])));
}

#[test]
fn light_paths_and_photons_find_the_same_under_coats() {
    agree_on_black(hall(Material::plastic("wall", (0.3, 1.5), &[0.0; 2])));
}

/// Holds light by way of carriers in a hall of black walls against light paths and photons.
fn agree_on_black(scene: Scene) {
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(200));
    let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(2_000_000)).unwrap();
    let sources = trace(&tracer, &patches, Basis::Constant, 2048);
    let (found, errors) = (sources.direct.as_ref().unwrap(), standard_errors(&sources));
    let (mut squares, mut values) = (0.0, 0.0);
    let mut whole = [[0.0; 2]; 2];
    for (i, c) in (0..patches.len()).flat_map(|i| [(i, 0), (i, 1)]) {
        let truth = traced.irradiance(i, c);
        let error = truth.standard_error.hypot(errors[(i, c)]);
        if error > 0.0 {
            squares += ((found[(i, c)] - truth.mean) / error).powi(2);
            values += 1.0;
        }
        whole[c][0] += patches.area(i) * found[(i, c)];
        whole[c][1] += patches.area(i) * truth.mean;
    }
    let inside = (0..patches.len()).filter(|&i| errors[(i, 0)] < 0.1 * found[(i, 0)]).count();
    assert!(inside > patches.len() / 2, "{inside} of {}", patches.len());
    assert!(squares / values < 2.0, "{}", squares / values);
    for [ours, theirs] in whole {
        assert!((ours / theirs - 1.0).abs() < 4e-3, "{ours} {theirs}");
    }
    // Where most comes by way of carriers, too.
    let brought = &sources.carried.as_ref().unwrap().irradiance;
    for c in 0..2 {
        let dim = (0..patches.len()).filter(|&i| brought[(i, c)] > 0.5 * found[(i, c)]);
        let (mut ours, mut theirs, mut variance) = (0.0, 0.0, 0.0);
        for i in dim {
            let truth = traced.irradiance(i, c);
            ours += patches.area(i) * found[(i, c)];
            theirs += patches.area(i) * truth.mean;
            variance += patches.area(i).powi(2) * (truth.standard_error.powi(2) + errors[(i, c)].powi(2));
        }
        assert!(ours > 0.01 * whole[c][0], "{ours} of {}", whole[c][0]);
        println!("{ours} {theirs} ± {}", variance.sqrt());
        assert!((ours - theirs).abs() < 4.0 * variance.sqrt(), "{ours} {theirs} ± {}", variance.sqrt());
    }
    // It matters: without what carriers bring the inside of the room would be much darker.
    assert!(brought.sum() > 0.02 * found.sum(), "{} {}", brought.sum(), found.sum());
}

#[test]
fn light_that_goes_on_is_the_same_by_photons_and_by_the_operator_and_no_energy_is_lost() {
    let scene = hall(Material::diffuse("wall", &[0.5; 2]));
    let tracer = Tracer::new(&scene);
    let mut patches = cut(&tracer, PatchSize::Count(1500));
    let options = TraceOptions { rays: Some(256), ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let light = LightOptions { rays: 1024, ..Default::default() };
    let problem = Problem::new(&tracer, &patches, &factors, &light).unwrap();
    let solution = problem.direct(&DirectOptions::default()).unwrap();
    let energy = Energy::of(&problem, &solution.radiance);
    assert!(energy.imbalance < 1e-9, "{energy:?}");
    // Some of it on the way from lights: with what surfaces send out alone less is absorbed.
    let of_surfaces = Energy::new(problem.operator(), problem.right_hand_side(), &solution.radiance);
    for (all, of_surfaces) in energy.carriers.iter().zip(&of_surfaces.carriers) {
        assert!(all > of_surfaces, "{energy:?} {of_surfaces:?}");
    }
    let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(400_000)).unwrap();
    for c in 0..2 {
        let (mut ours, mut theirs, mut variance) = (0.0, 0.0, 0.0);
        for i in 0..patches.len() {
            let truth = traced.irradiance(i, c);
            ours += patches.area(i) * solution.irradiance[(i, c)];
            theirs += patches.area(i) * truth.mean;
            variance += (patches.area(i) * truth.standard_error).powi(2);
        }
        assert!(
            (ours - theirs).abs() < 0.01 * theirs + 4.0 * variance.sqrt(),
            "{ours} {theirs} ± {}",
            variance.sqrt()
        );
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let scene = hall(Material::diffuse("wall", &[0.5; 2]));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(100));
    for basis in BASES {
        let [one, three] = [1, 3].map(|threads| on_threads(threads, || trace(&tracer, &patches, basis, 256)));
        assert_eq!(one, three);
        let constant = trace(&tracer, &patches, Basis::Constant, 256).carried.unwrap().irradiance;
        let means = basis.means(&one.carried.unwrap().irradiance);
        assert!((means - &constant).amax() < 1e-12 * constant.amax());
    }
}
