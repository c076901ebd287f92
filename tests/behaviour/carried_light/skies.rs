//! Skies in mirrors and through glass: closed forms, and the same with shots and without.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::patches::{Basis, PatchSize};
use radiosity::scene::{Environment, Material, Pixels, Side, Sky, SkyKind};
use radiosity::trace::Tracer;
use radiosity::transport::{LightOptions, Shots, Sources};

use super::{carried, flux, standard_errors, trace};
use crate::scenes::{BASES, cut, facing, flipped, lit_quads, room, sky, square};

#[test]
fn a_plate_over_a_mirror_sees_the_sky_in_it_but_for_itself() {
    let scene = lit_quads(
        &[(flipped(square(0.6, 0.5)), 0), (square(0.0, 400.0), 1)],
        vec![Material::diffuse("plate", &[0.0]), Material::mirror("mirror", &[0.7])],
        Vec::new(),
        Some(sky(SkyKind::Constant, 3.0)),
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.2));
    let exact = 0.7 * 3.0 * PI * (1.0 - facing(1.2));
    for basis in BASES {
        let found = carried(&tracer, &patches, basis, 1024);
        let mean: f64 = (0..2).map(|face| flux(&patches, &found, face, Side::Front)).sum();
        assert!((mean / exact - 1.0).abs() < 3e-3, "{basis:?}: {mean} {exact}");
    }
}

#[test]
fn under_an_even_sky_a_closed_shell_of_clear_glass_is_as_if_it_were_not_there() {
    let outer = room([-1.0; 3], [1.0; 3]).map(|quad| (flipped(quad), 1));
    let inner = room([-0.8; 3], [0.8; 3]).map(|quad| (quad, 1));
    let quads: Vec<_> = std::iter::once((square(-0.2, 0.3), 0)).chain(outer).chain(inner).collect();
    let materials = vec![Material::diffuse("plate", &[0.5]), Material::dielectric("glass", 1.5, &[1.0])];
    let scene = lit_quads(&quads, materials.clone(), Vec::new(), Some(sky(SkyKind::Constant, 2.0)));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(16));
    let found = trace(&tracer, &patches, Basis::Constant, 4096).direct.unwrap();
    let mean = found.sum() / found.nrows() as f64;
    assert!((mean / (2.0 * PI) - 1.0).abs() < 5e-3, "{mean}");
}

/// A ball of facets around the origin.
fn ball(radius: f64) -> Vec<[[f64; 3]; 4]> {
    let (columns, rows) = (48, 24);
    let at = |i: usize, j: usize| {
        let (phi, theta) = (2.0 * PI * i as f64 / columns as f64, PI * j as f64 / rows as f64);
        [radius * theta.sin() * phi.sin(), radius * theta.cos(), radius * theta.sin() * phi.cos()]
    };
    let quad = |k: usize| {
        let (i, j) = (k % columns, k / columns);
        [at(i, j), at(i, j + 1), at((i + 1) % columns, j + 1), at((i + 1) % columns, j)]
    };
    (0..columns * rows).map(quad).collect()
}

#[test]
fn within_solid_glass_the_sky_is_as_bright_as_outside_by_the_square_of_the_index() {
    let glass = ball(1.0).into_iter().map(|quad| (quad, 1));
    let quads: Vec<_> = std::iter::once((square(0.0, 0.02), 0)).chain(glass).collect();
    let materials = vec![Material::diffuse("plate", &[0.5]), Material::dielectric("glass", 1.5, &[1.0])];
    let scene = lit_quads(&quads, materials, Vec::new(), Some(sky(SkyKind::Constant, 2.0)));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(4));
    let found = trace(&tracer, &patches, Basis::Constant, 1 << 14).direct.unwrap();
    let part = found.sum() / found.nrows() as f64 / (2.0 * PI);
    // No more is missing than what the surface reflects back to the plate.
    assert!((0.95..1.002).contains(&part), "{part}");
}

#[test]
fn skies_of_every_kind_agree_with_and_without_shots() {
    // A box of mirrors over a ground, open to one side.
    let sides = room([-0.5, 0.3, -0.5], [0.5, 1.3, 0.5]).map(|quad| (quad, 1));
    let quads: Vec<_> = std::iter::once((square(0.0, 1.0), 0)).chain(sides[2..5].iter().copied()).collect();
    for kind in
        [SkyKind::Constant, SkyKind::Overcast, SkyKind::Clear { sun: DVec3::new(0.6, 0.7, 0.2).normalize() }]
    {
        let materials = vec![Material::diffuse("ground", &[0.5]), Material::mirror("mirror", &[0.9])];
        let scene = lit_quads(&quads, materials, Vec::new(), Some(sky(kind, 1.0)));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, PatchSize::Count(64));
        let [with, without] = [Shots::Shot, Shots::Skipped].map(|caustics| {
            let options = LightOptions { rays: 4096, caustics, ..Default::default() };
            Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap()
        });
        let flux = |field: &DMatrix<f64>| (0..patches.len()).map(|i| patches.area(i) * field[i]).sum::<f64>();
        let [(ours, error), (theirs, other)] = [&with, &without].map(|sources| {
            let squares: f64 = sources.spread.iter().map(|more| flux(more).powi(2)).sum();
            (flux(sources.direct.as_ref().unwrap()), (squares / 56.0).sqrt())
        });
        let (z, noise) = ((ours - theirs) / error.hypot(other), error.hypot(other) / theirs);
        assert!(z.abs() < 4.0 && noise < 0.01, "{ours} ± {error}, {theirs} ± {other}");
        let errors = [&with, &without].map(standard_errors);
        let [with, without] = [with, without].map(|sources| sources.carried.unwrap().irradiance);
        let mut squares = 0.0;
        for i in 0..patches.len() {
            let variance = errors[0][i].powi(2) + errors[1][i].powi(2);
            squares += (with[i] - without[i]).powi(2) / variance.max(1e-12) / patches.len() as f64;
        }
        assert!(squares < 2.0, "{squares}");
    }
}

#[test]
fn a_bright_spot_in_a_picture_of_the_sky_is_found_in_a_mirror() {
    // A sky of one bright texel and an even rest, over a wall that stands on a mirror.
    let (width, height) = (64, 32);
    let bright = (20, 6);
    let texel = |k: usize| if (k % width, k / width) == bright { [20000.0; 3] } else { [1.0; 3] };
    let pixels = Pixels::new(width, height, (0..width * height).map(texel).collect());
    let environment = Environment::new(pixels, DVec3::Y, 0.0);
    let sky =
        Sky { kind: SkyKind::Environment(environment.into()), up: DVec3::Y, zenith: vec![1.0], ground: 0.0 };
    let wall = [[1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [1.0, 2.0, 1.0], [1.0, 2.0, -1.0]];
    let scene = lit_quads(
        &[(wall, 0), (square(0.0, 1.0), 1)],
        vec![Material::diffuse("wall", &[0.0]), Material::mirror("mirror", &[0.8])],
        Vec::new(),
        Some(sky),
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(64));
    let of = |caustics: Shots, rays: u32| {
        let options = LightOptions { rays, caustics, ..Default::default() };
        let sources = Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap();
        let errors = standard_errors(&sources);
        (sources.carried.unwrap().irradiance, errors)
    };
    let (exact, _) = of(Shots::Skipped, 1 << 18);
    let (found, errors) = of(Shots::Shot, 1024);
    let off = (found.sum() / exact.sum() - 1.0).abs();
    assert!(off < 0.02, "{off}");
    // With much less noise than by as many rays of patches alone.
    let (_, noise) = of(Shots::Skipped, 1024);
    assert!(errors.norm() < 0.6 * noise.norm(), "{} {}", errors.norm(), noise.norm());
}
