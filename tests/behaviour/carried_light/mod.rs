//! Lights without area and skies by way of mirrors, metals and glass: closed forms, light paths, energy.

mod halls; // light paths, energy, the same bits
mod lights; // a point light and the sun: closed forms
mod showing; // receivers, pictures, scenes without carriers
mod skies; // closed forms, and with shots as without

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::scene::{Light, Side, Sky, SkyKind};
use radiosity::trace::Tracer;
use radiosity::transport::{LightOptions, Sources};

const BASES: [Basis; 2] = [Basis::Constant, Basis::Linear];

fn point(position: [f64; 3], intensity: &[f64]) -> Light {
    Light::Point { position: position.into(), intensity: intensity.to_vec() }
}

fn sun(direction: [f64; 3], irradiance: f64, diameter: f64) -> Light {
    Light::Sun { direction: DVec3::from(direction).normalize(), irradiance: vec![irradiance], diameter }
}

fn sky(kind: SkyKind, zenith: f64) -> Sky {
    Sky { kind, up: DVec3::Y, zenith: vec![zenith], ground: 0.0 }
}

/// A square of this half-width at this height, facing up.
fn square(y: f64, half: f64) -> [[f64; 3]; 4] {
    [[-half, y, -half], [-half, y, half], [half, y, half], [half, y, -half]]
}

fn cut<'s>(tracer: &Tracer<'s>, size: PatchSize) -> Patches<'s> {
    Patches::new(tracer, &Tessellation { size, ..Default::default() }).unwrap()
}

fn trace(tracer: &Tracer, patches: &Patches, basis: Basis, rays: u32) -> Sources {
    Sources::trace(tracer, patches, basis, &LightOptions { rays, ..Default::default() }).unwrap()
}

/// Irradiance by way of carriers, by means over patches.
fn carried(tracer: &Tracer, patches: &Patches, basis: Basis, rays: u32) -> DMatrix<f64> {
    basis.means(&trace(tracer, patches, basis, rays).carried.unwrap().irradiance)
}

/// Standard errors of H₀ of constant elements, by its eight parts.
fn standard_errors(sources: &Sources) -> DMatrix<f64> {
    let direct = sources.direct.as_ref().unwrap();
    let variance = |i: usize, c: usize| {
        sources.spread.iter().map(|more| more[(i, c)].powi(2)).sum::<f64>() / (8.0 * 7.0)
    };
    DMatrix::from_fn(direct.nrows(), direct.ncols(), |i, c| variance(i, c).sqrt())
}

/// Flux (W) that a face's side catches of an irradiance.
fn flux(patches: &Patches, field: &DMatrix<f64>, face: usize, side: Side) -> f64 {
    patches.patches_of(face, side).map(|i| patches.area(i) * field[i]).sum()
}
