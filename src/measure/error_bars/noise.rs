//! Noise: how far the answer would move if its rays were others.
//!
//! The batches of rays say by how much each would change the irradiance ε that the solved light causes. That
//! change is reflected on, δH = ε + πF ρ δH/π. What is reflected comes from all sides and varies slowly, so
//! that part is solved for between a few hundred clusters of patches.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::constants::{CLUSTERS, EVENNESS, FEWEST_PER_CLUSTER, NOISE_AT_MOST, NOISE_AT_MOST_LINEAR};
use crate::measure::MeasureError;
use crate::patches::{Basis, Patches};
use crate::solve::{DirectOptions, direct};
use crate::transport::{
    BATCHES, FormFactors, Merged, Reflection, Sources, Spread, Transport, variance_of_mean,
};

/// Samples of the noise in irradiance, by what it comes from; their mean over batches is zero.
pub(super) struct Noise {
    /// Of rays between surfaces: per batch n × c, W·m⁻².
    pub rays: Vec<DMatrix<f64>>,
    /// Of light sampling: per batch n × c, W·m⁻².
    pub lamps: Vec<DMatrix<f64>>,
}

impl Noise {
    /// Samples the noise in the irradiance of a solution with radiance L (n × c), averaged over patches.
    /// `by_patch` are the form factors with constant elements.
    pub fn of(
        patches: &Patches,
        factors: &FormFactors,
        by_patch: &FormFactors,
        sources: &Sources,
        radiance: &DMatrix<f64>,
    ) -> Result<Self, MeasureError> {
        let clusters = patches.clusters((patches.len() as f64 / CLUSTERS).max(FEWEST_PER_CLUSTER), None);
        let merged = by_patch.merged(&clusters.of_patch, clusters.count);
        let coarse = Merged { clusters: &clusters, factors: &merged };
        // What bright patches send is no matter of rows.
        let radiance = match &sources.bright {
            Some(bright) if radiance.amax() > 0.0 => &(radiance - factors.basis().means(&bright.radiance)),
            _ => radiance,
        };
        let mut spread = factors.spread(patches, radiance, by_patch, coarse)?;
        for (lamps, lights) in spread.lamps.iter_mut().zip(&sources.spread) {
            *lamps += factors.basis().means(lights) / EVENNESS;
        }
        let reflection = Reflection::of(patches);
        let k = Transport::new(&merged, reflection.merged(patches, &clusters))?;
        let solver = direct(&k, &DirectOptions::default())?;
        let reflected_on = |change: &mut DMatrix<f64>| {
            let smooth = solver.irradiance(&patches.average_by(&clusters, &reflection.reflect(change)));
            for (mut change, smooth) in change.column_iter_mut().zip(smooth.column_iter()) {
                change.iter_mut().zip(&clusters.of_patch).for_each(|(x, &cluster)| *x += smooth[cluster]);
            }
        };
        let Spread { rays, lamps } = &mut spread;
        rays.par_iter_mut().chain(lamps).for_each(reflected_on);
        Ok(Self { rays: spread.rays, lamps: spread.lamps })
    }
}

/// How many times more than the batches tell the noise of so many rays a patch may be, in nineteen of twenty
/// cases: of linear elements, three to a patch, what few rays make of them shows in all batches alike.
pub(in crate::measure) fn at_most(rays: u32, basis: Basis) -> f64 {
    match basis {
        Basis::Constant => NOISE_AT_MOST,
        Basis::Linear => NOISE_AT_MOST + NOISE_AT_MOST_LINEAR * f64::from(BATCHES) / f64::from(rays.max(1)),
    }
}

/// The variance of one value of the mean of batches whose own mean is zero.
pub(super) fn variance(batches: &[DMatrix<f64>], at: (usize, usize)) -> f64 {
    variance_of_mean(batches, |batch| batch[at])
}
