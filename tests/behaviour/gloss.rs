//! Rough conductors, on the way between patches: a furnace, the smooth limit, the path tracer's own route,
//! pictures, saved form factors.

use std::io::Cursor;

use radiosity::measure::{Difference, Energy};
use radiosity::patches::{PatchSize, Tessellation};
use radiosity::reference::PathTracer;
use radiosity::render::{self, RenderOptions, Shading};
use radiosity::scene::{Camera, Material, Scene};
use radiosity::solve::{self, DirectOptions, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{
    FactorsFileError, FormFactors, Keep, Plan, StorageKind, TraceOptions, Transport, TransportError,
};

use crate::scenes::{BASES, cut, flipped, paths, quads, room};

/// A closed cube that glows and reflects half, with a block of this material in it, and a floor of it.
pub(crate) fn furnace_with(metal: Material) -> Scene {
    let mut walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    walls[1].1 = 1;
    let block = room([0.3, 0.35, 0.25], [0.7, 0.6, 0.65]).map(|quad| (flipped(quad), 1));
    quads(&[walls, block].concat(), vec![Material::lamp("wall", &[0.5], &[1.0]), metal])
}

#[test]
fn a_furnace_stays_a_furnace_around_white_metal_of_any_roughness() {
    for roughness in [0.05, 0.4, 1.0] {
        let scene = furnace_with(Material::conductor("metal", roughness, &[1.0]));
        let tracer = Tracer::new(&scene);
        for basis in BASES {
            let mut patches = cut(&tracer, PatchSize::Count(300));
            let options = TraceOptions { rays: Some(256), basis, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let k = Transport::of(&factors, &patches).unwrap();
            let e = basis.coefficients_of(&patches.emitted_radiance());
            let solution = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&e);
            let energy = Energy::new(&k, &e, &solution.radiance);
            assert!(energy.imbalance < 1e-9, "{energy:?}");
            assert_eq!([energy.carriers[0], energy.escaped[0], energy.lost[0]], [0.0; 3], "{energy:?}");
            let off = solution.radiance.map(|l| (l - 2.0).abs()).max();
            assert!(off < 1e-9, "{roughness} {basis:?}: {off}");
        }
        // And by the path tracer's own route, which looks at lamps from the metal.
        let patches = cut(&tracer, PatchSize::Count(100));
        let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(100_000)).unwrap();
        let sum = |f: &dyn Fn(usize) -> f64| (0..traced.len()).map(f).sum::<f64>();
        let mean = sum(&|i| traced.area(i) * (traced.irradiance(i, 0).mean - 2.0 * std::f64::consts::PI));
        let variance = sum(&|i| (traced.area(i) * traced.irradiance(i, 0).standard_error).powi(2));
        let z = mean / variance.sqrt();
        assert!(z.abs() < 4.0, "{roughness}: {z}");
    }
}

/// How far the matrix is from light paths in a room with a floor and a wall of this material, and a block of
/// it or of what the walls are.
pub(crate) fn difference_in_a_room(material: Material, is_of_block: bool) -> Difference {
    let mut walls = room([0.0; 3], [1.0, 0.8, 0.9]).map(|quad| (quad, 0));
    walls[1].1 = 1;
    walls[5].1 = 1;
    let lamp = [[0.3, 0.79, 0.2], [0.6, 0.79, 0.2], [0.6, 0.79, 0.4], [0.3, 0.79, 0.4]];
    let block = room([0.6, 0.0, 0.5], [0.8, 0.4, 0.7]).map(|quad| (flipped(quad), u32::from(is_of_block)));
    let faces = [&walls[..], &[(lamp, 2)], &block].concat();
    let materials =
        vec![Material::diffuse("wall", &[0.6]), material, Material::lamp("lamp", &[0.0], &[10.0])];
    let scene = quads(&faces, materials);
    let tracer = Tracer::new(&scene);
    let mut patches = cut(&tracer, PatchSize::Count(1500));
    let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap();
    let k = Transport::of(&factors, &patches).unwrap();
    let solution = solve::solve(&k, &patches.emitted_radiance(), &SolveOptions::default()).unwrap();
    let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(600_000)).unwrap();
    Difference::new(&solution.irradiance, &traced)
}

#[test]
fn the_matrix_agrees_with_light_paths_in_a_room_of_metal() {
    for roughness in [0.2, 0.6] {
        let difference = difference_in_a_room(Material::conductor("metal", roughness, &[0.8]), false);
        assert!(difference.bias.abs() < 0.003 + 3.0 * difference.bias_error, "{difference:?}");
        assert!(difference.rms < 0.04 + 2.0 * difference.uncertainty, "{difference:?}");
    }
}

#[test]
fn every_shading_shows_a_furnace_in_rough_metal_as_bright_as_the_furnace() {
    let scene = furnace_with(Material::conductor("metal", 0.5, &[1.0]));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.5));
    let radiance = patches.emitted_radiance() * 2.0;
    let camera = Camera {
        position: [0.15, 0.5, 0.5].into(),
        target: [0.5, 0.3, 0.4].into(),
        up: [0.0, 1.0, 0.0].into(),
        fov: 60.0,
    };
    for (shading, samples) in
        [(Shading::Flat, 4), (Shading::Smooth, 4), (Shading::Gather, 64), (Shading::Path, 64)]
    {
        let options = RenderOptions { width: 16, height: 12, shading, samples, ..Default::default() };
        let picture = render::picture(&tracer, &patches, &radiance, &camera, &options).unwrap();
        let mean = picture.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / 192.0;
        assert!((mean - 2.0).abs() < 0.02, "{shading:?}: {mean}");
    }
}

#[test]
fn a_lamp_shines_in_rough_metal_as_bright_in_every_shading() {
    // A small lamp over a sheet of metal, seen by its highlight.
    let sheet = [[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0]];
    let lamp = [[-0.1, 1.0, -0.1], [0.1, 1.0, -0.1], [0.1, 1.0, 0.1], [-0.1, 1.0, 0.1]];
    let materials = vec![Material::conductor("metal", 0.5, &[0.9]), Material::lamp("lamp", &[0.0], &[100.0])];
    let scene = quads(&[(sheet, 0), (lamp, 1)], materials);
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.5));
    let camera = Camera {
        position: [0.0, 1.0, 1.5].into(),
        target: [0.0, 0.0, 0.7].into(),
        up: [0.0, 1.0, 0.0].into(),
        fov: 30.0,
    };
    let seen = |shading, samples| {
        let options = RenderOptions { width: 16, height: 12, shading, samples, ..Default::default() };
        let picture =
            render::picture(&tracer, &patches, &patches.emitted_radiance(), &camera, &options).unwrap();
        picture.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / 192.0
    };
    let reference = seen(Shading::Path, 1024);
    assert!(reference > 0.5, "{reference}");
    for (shading, samples) in [(Shading::Flat, 1), (Shading::Smooth, 1), (Shading::Gather, 64)] {
        let mean = seen(shading, samples);
        assert!((mean / reference - 1.0).abs() < 0.02, "{shading:?}: {mean} {reference}");
    }
}

#[test]
fn saved_form_factors_know_how_rough_the_metal_was() {
    let scene = |roughness| furnace_with(Material::conductor("metal", roughness, &[0.8]));
    let (dull, bright) = (scene(0.5), scene(0.4));
    let tracer = Tracer::new(&dull);
    let mut patches = cut(&tracer, PatchSize::Count(100));
    let options = TraceOptions { rays: Some(8), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let mut file = Vec::new();
    factors.save(&patches, &mut file).unwrap();
    let read = |scene: &Scene| {
        let (mut file, options) = (Cursor::new(&file), Tessellation::default());
        FormFactors::load(&mut file, &Tracer::new(scene), &options, StorageKind::Auto, Keep::Nothing)
            .map(|_| ())
    };
    assert_eq!(read(&dull), Ok(()));
    assert_eq!(read(&bright).unwrap_err(), TransportError::File(FactorsFileError::OtherScene));
}

#[test]
fn the_plan_simulates_metal() {
    let plan = Plan::new(&furnace_with(Material::conductor("tin", 0.5, &[0.8])));
    let on: Vec<&str> = plan.effects.iter().filter(|e| e.on).map(|e| e.effect).collect();
    assert_eq!(on, ["interreflection", "occlusion rays", "back sides", "lamps", "caustics", "gloss"]);
}
