//! Lights without area and skies by way of mirrors, metals and glass: closed forms, light paths, energy.

mod halls; // light paths, energy, the same bits
mod lights; // a point light and the sun: closed forms
mod showing; // receivers, pictures, scenes without carriers
mod skies; // closed forms, and with shots as without

use nalgebra::DMatrix;
use radiosity::patches::{Basis, Patches};
use radiosity::scene::Side;
use radiosity::trace::Tracer;
use radiosity::transport::{LightOptions, Sources};

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
