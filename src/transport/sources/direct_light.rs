//! Direct light: the irradiance that comes straight from lamps, for runs that leave interreflection out and
//! need no form factors.
//!
//! Points x on a patch are paired with points y drawn on lamps with density p, and H = E\[π Lₑ(y) V(x, y)
//! g(x, y)/p(y)\] with g the geometry term and V whether they see each other.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::lamp_flux::{LampFlux, LampRays};
use super::{LightOptions, LooksForLight, PARTS, Sources};
use crate::patches::{Basis, Patches};
use crate::progress::Cancelled;
use crate::scene::Scene;
use crate::trace::sampling::Stream;
use crate::trace::{Lamps, Tracer, geometry_term};
use crate::transport::exchange::Mass;
use crate::transport::form_factors::TraceOptions;

impl Sources {
    /// The same with what lamps send straight to patches among what lights bring: [`Sources::direct`] is then
    /// all light that has not been reflected. What comes by way of mirrors and glass is left out. Where the
    /// rest of the lamps' light goes, as many rays from lamps tell as there are pairs of points, at most 2¹⁹.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn with_lamps(
        mut self,
        tracer: &Tracer,
        patches: &Patches,
        basis: Basis,
        options: &LightOptions,
    ) -> Result<Self, Cancelled> {
        let trace = TraceOptions { lamp_rays: options.lamp_rays, ..Default::default() };
        let look = Look {
            tracer,
            patches,
            lamps: Lamps::all(tracer),
            pairs: trace.lamp_rays_of(patches.len()),
            seed: options.seed,
        };
        let channels = self.emitted.ncols();
        // Each eighth of the pairs by itself.
        let values = basis.coefficients() * channels;
        let moments = look.moments(basis, patches.len(), PARTS * values, options.progress)?;
        let mass = Mass::of_areas(basis, patches);
        let mut parts: Vec<DMatrix<f64>> = (0..PARTS)
            .map(|part| {
                let rows = moments.chunks_exact(values).skip(part).step_by(PARTS);
                let mut field =
                    DMatrix::from_row_iterator(self.emitted.nrows(), channels, rows.flatten().copied());
                mass.solve(&mut field, PI);
                field
            })
            .collect();
        let sums = Mass::of(basis, patches).sums().clone();
        let arrived: Vec<Vec<f64>> =
            parts.iter().map(|part| part.column_iter().map(|h| sums.dot(&h)).collect()).collect();
        let number = u64::from(look.pairs) * patches.len() as u64;
        let rays = LampRays { number, seed: options.seed };
        let emitted = basis.means(&self.emitted);
        self.lamps = Some(LampFlux::trace(tracer, patches, &emitted, &arrived, rays));
        let whole = parts.iter().fold(DMatrix::zeros(self.emitted.nrows(), channels), |sum, part| sum + part);
        parts.iter_mut().for_each(|part| *part = &*part * PARTS as f64 - &whole);
        self.direct = Some(self.direct.map_or_else(|| whole.clone(), |direct| direct + &whole));
        if self.spread.is_empty() {
            self.spread = parts;
        } else {
            self.spread.iter_mut().zip(parts).for_each(|(all, part)| *all += part);
        }
        Ok(self)
    }
}

/// All it takes to look for lamps from a patch.
struct Look<'a> {
    tracer: &'a Tracer<'a>,
    patches: &'a Patches<'a>,
    lamps: Lamps,
    pairs: u32,
    seed: u64,
}

impl LooksForLight for Look<'_> {
    /// Adds ∫ φ_a H/π dA over a patch to `moments`: for each eighth of the pairs a row of channels for each
    /// of the basis functions `phi`.
    fn add_moments<const N: usize>(
        &self,
        patch: usize,
        phi: impl Fn([f64; 2]) -> [f64; N],
        moments: &mut [f64],
    ) {
        let scene: &Scene = self.tracer.scene();
        let slot = self.patches.slot_of_patch(patch);
        let facet = self.patches.facet(self.tracer, slot);
        let view = self.lamps.view_over(&facet.corners, facet.normal);
        let worth = self.patches.normalised_areas()[patch] / f64::from(self.pairs);
        let (sequence, stretch) = Stream::DirectLight.stretch(self.seed, slot, 0, self.pairs);
        let first = stretch.start;
        for k in stretch {
            let part = (k - first) as usize * PARTS / self.pairs as usize;
            let [s, t, u, v] = sequence.point(k);
            // Draw a point on a lamp and one on the patch, and see whether they see each other.
            let Some(to) = self.lamps.sample(&view, [u, v]) else { return };
            let here = facet.target(to.point, [s, t]);
            let from = here.point;
            let g = geometry_term((from, facet.normal), (to.point, to.normal));
            if g == 0.0 || !self.tracer.unoccluded((from, facet.face), (to.point, to.face)) {
                continue;
            }
            // Add what it sends, by basis functions.
            let weight = facet.weight((to.point - from).normalize());
            let emission = &scene.material_of(to.face as usize).emission;
            let texture = scene.emission_texture(to.face as usize).map(|texture| texture.at(to.barycentrics));
            let weights = phi(here.barycentrics);
            let worth = worth * weight * g / (to.pdf * here.density);
            let of_part = &mut moments[part * N * emission.len()..][..N * emission.len()];
            for (row, phi) in of_part.chunks_exact_mut(emission.len()).zip(weights) {
                for (c, (sum, e)) in row.iter_mut().zip(emission).enumerate() {
                    *sum += worth * phi * e * texture.map_or(1.0, |texture| texture[c]);
                }
            }
        }
    }
}
