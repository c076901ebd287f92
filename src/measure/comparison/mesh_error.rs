//! Mesh error: how the answer changes when patches are made half as long, and twice as long.
//!
//! Where error falls as the edge to some power p, halving the edge changes the answer by (1 − 2⁻ᵖ) of what is
//! wrong with it: the change is an *estimate* of mesh error. The noise of form factors is in it too, because
//! every cut has rays of its own.

use nalgebra::DMatrix;

use super::constants::{FEWEST_RAYS, TYPICAL_AREA};
use crate::measure::MeasureError;
use crate::patches::{Cutter, Patches, Tessellation};
use crate::progress::Progress;
use crate::solve::{CgOptions, Problem};
use crate::trace::Tracer;
use crate::transport::{FormFactors, LightOptions, Shots, TraceOptions};

/// The scene solved on a coarser and a finer cut.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshError {
    /// Irradiance with half the edge less that with the patches' own, averaged over these, n × c, W·m⁻²;
    /// `None` where half the edge does not fit into memory.
    pub finer: Option<DMatrix<f64>>,
    /// Irradiance with the patches' own edge less that with twice of it, n × c, W·m⁻².
    pub coarser: DMatrix<f64>,
}

impl MeshError {
    /// Solves the scene thrice over, with `factors` between `patches` and on two other cuts; `trace` as the
    /// form factors were traced.
    ///
    /// # Errors
    /// As tracing and solving.
    pub fn estimate(
        tracer: &Tracer,
        patches: &Patches,
        factors: &FormFactors,
        tessellation: &Tessellation,
        trace: &TraceOptions,
    ) -> Result<Self, MeasureError> {
        let own = irradiance(tracer, patches, factors, (trace.seed, trace.caustics))?;
        let mut cutter = Cutter::new(tracer)?;
        let typical = typical_edge(patches) / patches.edge();
        let mut on_cut = |scale: f64, rays: u32, apart: u64| -> Result<DMatrix<f64>, MeasureError> {
            let silent = Progress::default();
            // A seed of its own, so that noise does not cancel.
            let seed = trace.seed ^ apart;
            let options = Tessellation { seed, progress: silent, ..*tessellation };
            let mut cut = cutter.scale(patches, typical * scale, &options)?;
            let basis = factors.basis();
            // What was found without rays is held against what is found without them too.
            let rays = (factors.rays() > 0).then_some(rays);
            let options = TraceOptions { rays, seed, basis, progress: trace.progress, ..*trace };
            let factors = FormFactors::trace(tracer, &mut cut, &options)?;
            Ok(patches.resample(&cut, &irradiance(tracer, &cut, &factors, (seed, trace.caustics))?))
        };
        let rays = factors.rays().max(FEWEST_RAYS);
        let coarser = &own - on_cut(2.0, rays, 1 << 61)?;
        // Four patches in the place of one share its rays.
        let finer = match on_cut(0.5, (rays / 2).max(FEWEST_RAYS), 1 << 62) {
            Ok(finer) => Some(finer - own),
            Err(error) if error.is_too_large() => None,
            Err(error) => return Err(error),
        };
        Ok(Self { finer, coarser })
    }

    /// How much a patch may be off: what the finer cut changes, or else the coarser.
    pub fn change(&self) -> &DMatrix<f64> {
        self.finer.as_ref().unwrap_or(&self.coarser)
    }
}

fn irradiance(
    tracer: &Tracer,
    patches: &Patches,
    factors: &FormFactors,
    (seed, caustics): (u64, Shots),
) -> Result<DMatrix<f64>, MeasureError> {
    let light = LightOptions { seed, caustics, ..Default::default() };
    let problem = Problem::new(tracer, patches, factors, &light)?;
    Ok(problem.conjugate_gradients(&CgOptions::default())?.means().irradiance)
}

/// The leg of a right-angled patch such that smaller ones make up a quarter of all area, metres. By number,
/// the many small faces of furniture would decide how finely the walls are cut.
fn typical_edge(patches: &Patches) -> f64 {
    let mut areas: Vec<f64> = (0..patches.len()).map(|i| patches.area(i)).collect();
    areas.sort_by(f64::total_cmp);
    let quarter = TYPICAL_AREA * areas.iter().sum::<f64>();
    let mut sum = 0.0;
    let middle = areas.iter().find(|&&area| {
        sum += area;
        sum >= quarter
    });
    (2.0 * middle.unwrap_or(&0.0)).sqrt().min(patches.edge())
}
