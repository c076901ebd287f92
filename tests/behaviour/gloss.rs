//! Rough conductors, on the way between patches: a furnace, the smooth limit, the path tracer's own route,
//! pictures, saved form factors.

use std::io::Cursor;

use radiosity::patches::{PatchSize, Tessellation};
use radiosity::scene::{Material, Scene};
use radiosity::trace::Tracer;
use radiosity::transport::{
    FactorsFileError, FormFactors, Keep, Plan, StorageKind, TraceOptions, TransportError,
};

use crate::finishes::{
    Look, at_the_highlight, balanced, difference_in_a_room, furnace_with, in_the_furnace, lamp_over,
    light_paths_from_two, simulated,
};
use crate::scenes::{BASES, cut};

#[test]
fn a_furnace_stays_a_furnace_around_white_metal_of_any_roughness() {
    for roughness in [0.05, 0.4, 1.0] {
        let scene = furnace_with(Material::conductor("metal", roughness, &[1.0]));
        let tracer = Tracer::new(&scene);
        for basis in BASES {
            let mut patches = cut(&tracer, PatchSize::Count(300));
            let options = TraceOptions { rays: Some(256), basis, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let (solution, energy) = balanced(&patches, &factors);
            assert_eq!([energy.carriers[0], energy.escaped[0], energy.lost[0]], [0.0; 3], "{energy:?}");
            let off = solution.radiance.map(|l| (l - 2.0).abs()).max();
            assert!(off < 1e-9, "{roughness} {basis:?}: {off}");
        }
        // And by the path tracer's own route, which looks at lamps from the metal.
        let z = light_paths_from_two(&tracer, 100_000);
        assert!(z.abs() < 4.0, "{roughness}: {z}");
    }
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
    let camera = in_the_furnace();
    Look { tracer: &tracer, patches: &patches, radiance: &radiance, camera }.is_of(2.0);
}

#[test]
fn a_lamp_shines_in_rough_metal_as_bright_in_every_shading() {
    // A small lamp over a sheet of metal, seen by its highlight.
    let scene = lamp_over(Material::conductor("metal", 0.5, &[0.9]));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.5));
    let (radiance, camera) = (patches.emitted_radiance(), at_the_highlight());
    Look { tracer: &tracer, patches: &patches, radiance: &radiance, camera }.is_as_light_paths_show_it(0.5);
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
    assert_eq!(
        simulated(&plan),
        ["interreflection", "occlusion rays", "back sides", "lamps", "caustics", "gloss"]
    );
}
