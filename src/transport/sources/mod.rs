//! Sources: what the right-hand side E = Lₑ + ρH₀/π is made of: emitted radiance, and irradiance by lights
//! without area.

mod bright_light;
mod carried_light;
mod direct_light;
mod lamp_flux;
mod lights;
mod pairs;
mod receivers;

use std::f64::consts::PI;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::exchange::Mass;
use super::operator::Transport;
use super::rows::{BATCHES, Shots};
use crate::patches::{Basis, Patches};
use crate::progress::{Cancelled, Progress};
use crate::scene::triangle;
use crate::trace::{Lights, Tracer, sampling};
pub use bright_light::BrightLight;
pub use carried_light::CarriedLight;
use carried_light::Measured;
pub(crate) use lamp_flux::LampFlux;
use lights::Look;
pub use receivers::{Received, ReceiverNoise, ReceiverRows, check_receivers};
pub(crate) use receivers::{rays_of, receiver_bytes};

/// Patches between two reports of progress; a number. Chosen, not fitted.
const CHUNK: usize = 4096;

/// Rays or shots that one task takes, by which random sequences are divided without remainder; a number.
/// Chosen, not fitted. What a task finds is summed up before sums of tasks are: with another number the last
/// bits differ.
const TASK: u32 = 1024;

/// How the light that starts is looked for: that of lights without area, and of lamps where they are not
/// left to form factors.
#[derive(Clone, Copy, Debug)]
pub struct LightOptions<'a> {
    /// Rays per patch into the sky, 1 to 65536; a quarter as many go to each light. Time grows in proportion.
    pub rays: u32,
    /// Number of the random sequence. The same seed gives the same bits.
    pub seed: u64,
    /// Whether lights and the sky shoot rays at mirrors, metals and glass. Without, only what rays of patches
    /// find of the sky comes by way of these.
    pub caustics: Shots,
    /// Pairs of points per patch towards lamps, for scenes without interreflection, rounded up to a multiple
    /// of 8; `None` for half of the [usual rays](super::TraceOptions::usual_rays).
    pub lamp_rays: Option<u32>,
    /// Where to report progress, as stage `light`.
    pub progress: Progress<'a>,
}

impl Default for LightOptions<'_> {
    /// 512 rays.
    fn default() -> Self {
        Self { rays: 512, seed: 0, caustics: Shots::Shot, lamp_rays: None, progress: Progress::default() }
    }
}

/// The light that starts in a scene, by coefficients (N × c).
#[derive(Clone, Debug, PartialEq)]
pub struct Sources {
    /// Emitted radiance Lₑ, W·sr⁻¹·m⁻².
    pub emitted: DMatrix<f64>,
    /// Irradiance H₀ by lights without area and the sky, W·m⁻²; none where a scene has none.
    pub direct: Option<DMatrix<f64>>,
    /// By how much more H₀ each eighth of the rays towards lights, and of bright patches, would have found by
    /// itself: eight samples of its noise, N × c, W·m⁻². Those of the sky are made smaller, since they lie
    /// more evenly together than those of other lights. None where there are no such lights.
    pub spread: Vec<DMatrix<f64>>,
    /// What of H₀ comes by way of mirrors, metals and glass; none where a scene has none of these, or no such
    /// lights.
    pub carried: Option<CarriedLight>,
    /// What bright patches send straight to others, by points drawn on them; none where none are much
    /// brighter than most.
    pub bright: Option<BrightLight>,
    /// Where the light of lamps goes, if what arrives of it is a part of H₀; none where lamps are left to
    /// form factors.
    pub(crate) lamps: Option<LampFlux>,
}

impl Sources {
    /// Looks from every patch for the scene's lights without area; a scene without them costs no ray.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn trace(
        tracer: &Tracer,
        patches: &Patches,
        basis: Basis,
        options: &LightOptions,
    ) -> Result<Self, Cancelled> {
        let emitted = basis.coefficients_of(&patches.emitted_radiance());
        let Some(lights) = Lights::new(tracer) else { return Ok(emitted.into()) };
        let rays = options.rays.clamp(1, sampling::SEQUENCE_END);
        let channels = emitted.ncols();
        let look = Look { tracer, patches, lights, rays, seed: options.seed, channels };
        // All rays together, then each part of them by itself.
        let each = (1 + PARTS) * basis.coefficients() * channels;
        let moments = look.moments(basis, patches.len(), each, options.progress)?;
        let mass = Mass::of_areas(basis, patches);
        let mut fields = fields(&moments, 1 + PARTS, channels, (&mass, 1.0));
        let mut sources = Self { direct: fields.next(), spread: fields.collect(), ..emitted.into() };
        if let Some(Measured { light, more }) =
            CarriedLight::trace(tracer, patches, basis, &look.lights, options)?
        {
            sources.direct.iter_mut().for_each(|direct| *direct += &light.irradiance);
            sources.spread.iter_mut().zip(more).for_each(|(spread, more)| *spread += more);
            sources.carried = Some(light);
        }
        Ok(sources)
    }

    /// The same light without what surfaces emit: of lights without area and the sky alone.
    pub fn without_emission(&self) -> Self {
        Self { emitted: 0.0 * &self.emitted, ..self.clone() }
    }

    /// The right-hand side E = Lₑ + ρH₀/π, N × c, to which what [bright patches](BrightLight) bring beside
    /// the operator is added.
    ///
    /// # Panics
    /// If the operator is not of these coefficients.
    pub fn right_hand_side(&self, k: &Transport) -> DMatrix<f64> {
        if self.direct.is_none() {
            return self.emitted.clone();
        }
        let mut irradiance = DMatrix::zeros(self.emitted.nrows(), self.emitted.ncols());
        self.add_beside_the_operator(&mut irradiance);
        &self.emitted + k.reflect(&irradiance)
    }

    /// Adds the irradiance that is no πFL to that (N × c, W·m⁻²): what bright patches bring beside the
    /// operator, and H₀.
    ///
    /// # Panics
    /// If it is not of these coefficients.
    pub fn add_beside_the_operator(&self, irradiance: &mut DMatrix<f64>) {
        // In this order: what order 0 of a series takes back leaves nothing of itself.
        if let Some(bright) = &self.bright {
            *irradiance += &bright.correction;
        }
        if let Some(direct) = &self.direct {
            *irradiance += direct;
        }
    }

    /// The irradiance πFL (N × c, W·m⁻²) from which a series starts so that order 0 has H₀ alone: what bright
    /// patches bring beside the operator is taken back until order 1.
    pub(crate) fn at_order_0(&self) -> DMatrix<f64> {
        match &self.bright {
            Some(bright) => -&bright.correction,
            None => DMatrix::zeros(self.emitted.nrows(), self.emitted.ncols()),
        }
    }

    /// Adds the noise that parts of some light (N × c each) tell to that of the rest; the sum of them.
    fn add_noise(&mut self, parts: Vec<DMatrix<f64>>) -> DMatrix<f64> {
        let (whole, parts) = whole_and_more(parts);
        match self.spread.is_empty() {
            true => self.spread = parts,
            false => self.spread.iter_mut().zip(parts).for_each(|(all, part)| *all += part),
        }
        whole
    }

    /// The flux that starts, per channel, W: π Σ A Lₑ, Σ A H₀ by lights without area, and what carriers kept
    /// of the latter on its way.
    pub fn flux(&self, mass: &Mass) -> Vec<f64> {
        let kept = |c: usize| {
            let kept =
                |light: &CarriedLight| (light.absorbed[c] + light.lost[c]) * (light.unit / mass.unit());
            self.carried.as_ref().map_or(0.0, kept)
        };
        let by_lamps =
            |c: usize| self.lamps.as_ref().map_or(0.0, |lamps| lamps.arrived[c] * (lamps.unit / mass.unit()));
        let arrived = |c: usize| self.direct.as_ref().map_or(0.0, |h| mass.sums().dot(&h.column(c)));
        let direct = |c: usize| arrived(c) - by_lamps(c) + kept(c);
        let flux = |c: usize| mass.unit() * (PI * mass.sums().dot(&self.emitted.column(c)) + direct(c));
        (0..self.emitted.ncols()).map(flux).collect()
    }
}

impl From<DMatrix<f64>> for Sources {
    /// Emitted radiance (N × c) alone.
    fn from(emitted: DMatrix<f64>) -> Self {
        Self { emitted, direct: None, spread: Vec::new(), carried: None, bright: None, lamps: None }
    }
}

/// Parts of the rays by which their noise is told: as many as rows have batches, since error bars add the two
/// batch by batch.
pub(super) const PARTS: usize = BATCHES as usize;

/// Rays of the options for each one from a patch to a light; a number. Chosen, not fitted.
pub(in crate::transport) const RAYS_PER_LIGHT_RAY: u32 = 4;

/// The fields (N × c) of which moments are, patch by patch, so many parts one after another: f M⁻¹ of each.
fn fields<'m>(
    moments: &'m [f64],
    parts: usize,
    channels: usize,
    (mass, factor): (&'m Mass, f64),
) -> impl Iterator<Item = DMatrix<f64>> + 'm {
    let values = mass.basis().coefficients() * channels;
    (0..parts).map(move |part| {
        let rows = moments.chunks_exact(values).skip(part).step_by(parts);
        let mut field = DMatrix::from_row_iterator(mass.len(), channels, rows.flatten().copied());
        mass.solve(&mut field, factor);
        field
    })
}

/// What parts of some light come to, and by how much more each would bring in the place of all.
fn whole_and_more(mut parts: Vec<DMatrix<f64>>) -> (DMatrix<f64>, Vec<DMatrix<f64>>) {
    let whole: DMatrix<f64> = parts.iter().sum();
    parts.iter_mut().for_each(|part| *part = &*part * PARTS as f64 - &whole);
    (whole, parts)
}

/// What looks for light from a patch. A trait, since the way to do it is generic in the number of functions.
trait LooksForLight: Sync {
    /// Adds moments of what arrives on a patch to `moments`: rows of channels for each of the basis functions
    /// `phi`, which take the weights of the second and third corner.
    fn add_moments<const N: usize>(
        &self,
        patch: usize,
        phi: impl Fn([f64; 2]) -> [f64; N],
        moments: &mut [f64],
    );

    /// The moments of so many patches by the functions of a basis, `each` values a patch.
    fn moments(
        &self,
        basis: Basis,
        patches: usize,
        each: usize,
        progress: Progress,
    ) -> Result<Vec<f64>, Cancelled> {
        let mut moments = vec![0.0; each * patches];
        for (chunk, rows) in moments.chunks_mut(CHUNK * each).enumerate() {
            progress.at("light", (chunk * CHUNK) as f64 / patches as f64)?;
            rows.par_chunks_mut(each).enumerate().for_each(|(k, row)| match basis {
                Basis::Constant => self.add_moments(chunk * CHUNK + k, |_| [1.0], row),
                Basis::Linear => self.add_moments(chunk * CHUNK + k, triangle::weights, row),
            });
        }
        progress.at("light", 1.0)?;
        Ok(moments)
    }
}
