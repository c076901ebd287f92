//! Pairs of points on patches and on what shines: the irradiance that comes straight from there.
//!
//! Points x on a patch are paired with points y drawn there with density p, and H = E\[π L(y) V(x, y)
//! g(x, y)/p(y)\] with g the geometry term and V whether they see each other.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::{LooksForLight, PARTS, fields};
use crate::patches::{Basis, Patches};
use crate::progress::{Cancelled, Progress};
use crate::trace::sampling::Stream;
use crate::trace::{LampPoint, Lamps, Tracer, geometry_term};
use crate::transport::exchange::Mass;

/// All it takes to look for what shines from a patch. `L` gives the radiance of a point there, per channel.
pub(super) struct Pairs<'a, L> {
    pub tracer: &'a Tracer<'a>,
    pub patches: &'a Patches<'a>,
    pub lamps: Lamps,
    pub radiance: L,
    pub channels: usize,
    /// Pairs per patch.
    pub count: u32,
    pub stream: Stream,
    pub seed: u64,
}

impl<L: Fn(&LampPoint, &mut [f64]) + Sync> Pairs<'_, L> {
    /// The irradiance (N × c, W·m⁻²) that each eighth of the pairs adds.
    pub fn irradiance(&self, basis: Basis, progress: Progress) -> Result<Vec<DMatrix<f64>>, Cancelled> {
        let values = basis.coefficients() * self.channels;
        let moments = self.moments(basis, self.patches.len(), PARTS * values, progress)?;
        let mass = Mass::of_areas(basis, self.patches);
        Ok(fields(&moments, PARTS, self.channels, (&mass, PI)).collect())
    }
}

impl<L: Fn(&LampPoint, &mut [f64]) + Sync> LooksForLight for Pairs<'_, L> {
    /// Adds ∫ φ_a H/π dA over a patch to `moments`: for each eighth of the pairs a row of channels for each
    /// of the basis functions `phi`.
    fn add_moments<const N: usize>(
        &self,
        patch: usize,
        phi: impl Fn([f64; 2]) -> [f64; N],
        moments: &mut [f64],
    ) {
        let slot = self.patches.slot_of_patch(patch);
        let facet = self.patches.facet(self.tracer, slot);
        let view = self.lamps.view_over(&facet.corners, facet.normal);
        let worth = self.patches.normalised_areas()[patch] / f64::from(self.count);
        let (sequence, stretch) = self.stream.stretch(self.seed, slot, 0, self.count);
        let first = stretch.start;
        let mut radiance = vec![0.0; self.channels];
        for k in stretch {
            let part = (k - first) as usize * PARTS / self.count as usize;
            let [s, t, u, v] = sequence.point(k);
            // Draw a point on what shines and one on the patch, and see whether they see each other.
            let Some(to) = self.lamps.sample(&view, [u, v]) else { return };
            let here = facet.target(to.point, [s, t]);
            let from = here.point;
            let g = geometry_term((from, facet.normal), (to.point, to.normal));
            if g == 0.0 || !self.tracer.unoccluded((from, facet.face), (to.point, to.face)) {
                continue;
            }
            // Add what it sends, by basis functions.
            let weight = facet.weight((to.point - from).normalize());
            (self.radiance)(&to, &mut radiance);
            let weights = phi(here.barycentrics);
            let worth = worth * weight * g / (to.pdf * here.density);
            let of_part = &mut moments[part * N * self.channels..][..N * self.channels];
            for (row, phi) in of_part.chunks_exact_mut(self.channels).zip(weights) {
                row.iter_mut().zip(&radiance).for_each(|(sum, radiance)| *sum += worth * phi * radiance);
            }
        }
    }
}
