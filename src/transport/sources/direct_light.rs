//! Direct light: the irradiance that comes straight from lamps, for runs that leave interreflection out and
//! need no form factors.

use super::lamp_flux::{LampFlux, LampRays};
use super::pairs::Pairs;
use super::{LightOptions, Sources};
use crate::patches::{Basis, Patches};
use crate::progress::Cancelled;
use crate::trace::sampling::Stream;
use crate::trace::{LampPoint, Lamps, Tracer};
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
        let scene = tracer.scene();
        let pairs = Pairs {
            tracer,
            patches,
            lamps: Lamps::all(tracer),
            radiance: |to: &LampPoint, radiance: &mut [f64]| {
                radiance.copy_from_slice(&scene.material_of(to.face as usize).emission);
                if let Some(texture) = scene.emission_texture(to.face as usize) {
                    let factors = texture.at(to.barycentrics);
                    radiance.iter_mut().zip(factors).for_each(|(radiance, factor)| *radiance *= factor);
                }
            },
            channels: self.emitted.ncols(),
            count: trace.lamp_rays_of(patches.len()),
            stream: Stream::DirectLight,
            seed: options.seed,
        };
        let parts = pairs.irradiance(basis, options.progress)?;
        let sums = Mass::of(basis, patches).sums().clone();
        let arrived: Vec<Vec<f64>> =
            parts.iter().map(|part| part.column_iter().map(|h| sums.dot(&h)).collect()).collect();
        let number = u64::from(pairs.count) * patches.len() as u64;
        let rays = LampRays { number, seed: options.seed };
        let emitted = basis.means(&self.emitted);
        self.lamps = Some(LampFlux::trace(tracer, patches, &emitted, &arrived, rays));
        let whole = self.add_noise(parts);
        self.direct = Some(self.direct.map_or_else(|| whole.clone(), |direct| direct + &whole));
        Ok(self)
    }
}
