//! Sources: what the right-hand side E = Lₑ + ρH₀/π is made of: emitted radiance, and irradiance by lights
//! without area.
//!
//! For each patch and light H₀ is the mean over the patch of what the light sends, times the share that
//! nothing hides. Where the mean of the geometry alone is known, the rays only have to tell that share,
//! weighted by what each would bring: so an unhidden point light is exact.

mod bright_light;
mod carried_light;
mod direct_light;
mod lamp_flux;
mod pairs;
mod receivers;

use std::borrow::Cow;
use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::exchange::Mass;
use super::operator::Transport;
use super::rows::{BATCHES, Shots};
use crate::patches::{Basis, Facet, Patches};
use crate::progress::{Cancelled, Progress};
use crate::scene::triangle;
use crate::trace::sampling::Stream;
use crate::trace::{Lights, Ray, SkyBeam, Through, Tracer, sampling};
pub use bright_light::BrightLight;
pub use carried_light::CarriedLight;
use carried_light::Measured;
pub(crate) use lamp_flux::LampFlux;
pub use receivers::{Received, ReceiverNoise, ReceiverRows};

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
    /// By how much more H₀ each eighth of the rays towards lights would have found by itself: eight samples
    /// of its noise, N × c, W·m⁻². Those of the sky are made smaller, since they lie more evenly together than
    /// those of other lights. None where there are no such lights.
    pub spread: Vec<DMatrix<f64>>,
    /// What of H₀ comes by way of mirrors, metals and glass; none where a scene has none of these, or no such
    /// lights.
    pub carried: Option<CarriedLight>,
    /// What bright patches send straight to others, by points drawn on them; none where none are much brighter
    /// than most.
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
        let mut fields = (0..=PARTS).map(|part| {
            let coefficients = moments.chunks_exact(each / (1 + PARTS)).skip(part).step_by(1 + PARTS);
            let mut field =
                DMatrix::from_row_iterator(emitted.nrows(), channels, coefficients.flatten().copied());
            mass.solve(&mut field, 1.0);
            field
        });
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
        match self.beside_the_operator() {
            Some(irradiance) => &self.emitted + k.reflect(&irradiance),
            None => self.emitted.clone(),
        }
    }

    /// The irradiance (N × c, W·m⁻²) that is no πFL: H₀, and what bright patches bring beside the operator;
    /// none where there is none.
    pub fn beside_the_operator(&self) -> Option<Cow<'_, DMatrix<f64>>> {
        let direct = self.direct.as_ref()?;
        Some(match &self.bright {
            Some(bright) => Cow::Owned(direct + &bright.correction),
            None => Cow::Borrowed(direct),
        })
    }

    /// Adds the noise that parts of some light (N × c each) tell to that of the rest; the sum of them.
    fn add_noise(&mut self, mut parts: Vec<DMatrix<f64>>) -> DMatrix<f64> {
        let whole: DMatrix<f64> = parts.iter().sum();
        parts.iter_mut().for_each(|part| *part = &*part * PARTS as f64 - &whole);
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

/// How many times more evenly than those of other lights the parts of rays into the sky lie together; a pure
/// number. Fitted to noise in rooms with windows and in yards, by `examples/fit_constants`.
const EVENNESS_OF_SKY: f64 = 2.0;

/// What rays towards one light find in one channel, part by part.
#[derive(Clone)]
struct Parts<const N: usize> {
    /// What they would bring if nothing stood in their way.
    whole: [f64; PARTS],
    /// What they do bring, by basis function.
    seen: [[f64; N]; PARTS],
}

impl<const N: usize> Default for Parts<N> {
    fn default() -> Self {
        Self { whole: [0.0; PARTS], seen: [[0.0; N]; PARTS] }
    }
}

impl<const N: usize> Parts<N> {
    #[inline]
    fn add(&mut self, part: usize, weight: f64, phi: [f64; N]) {
        self.seen[part].iter_mut().zip(phi).for_each(|(sum, phi)| *sum += weight * phi);
    }

    /// What all bring; then by how much more each part would bring in the place of all, over `evenness`. A
    /// part of more weight is not taken for one that sees more.
    fn sums(&self, evenness: f64) -> [[f64; N]; 1 + PARTS] {
        let all: [f64; N] = std::array::from_fn(|a| self.seen.iter().map(|seen| seen[a]).sum());
        let whole: f64 = self.whole.iter().sum();
        let parts = PARTS as f64 / evenness;
        let more = |part: usize, a: usize| {
            let share = if whole > 0.0 { self.whole[part] / whole } else { 0.0 };
            parts * (self.seen[part][a] - share * all[a])
        };
        std::array::from_fn(|k| if k == 0 { all } else { std::array::from_fn(|a| more(k - 1, a)) })
    }
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

/// All it takes to look for light from a patch.
struct Look<'a> {
    tracer: &'a Tracer<'a>,
    patches: &'a Patches<'a>,
    lights: Lights,
    rays: u32,
    seed: u64,
    channels: usize,
}

/// A patch and a light that it looks at.
struct LightLook<'a> {
    light: usize,
    slot: u32,
    facet: Facet<'a>,
    /// The light's mean density there, if known and asked for.
    mean: Option<f64>,
    /// Apertures through which the light may come.
    through: Through<'a>,
    rays: u32,
}

/// So many times as many points of a patch look at a light that may come through apertures: their edges are
/// seen on it. Chosen, not fitted: most such points miss the patch and cost no ray.
const MORE_POINTS: u32 = 32;

/// The part of points on a patch that is drawn where light comes through apertures, if it may; a pure number.
/// Chosen, not fitted.
const THROUGH_APERTURES: f64 = 0.75;

impl LightLook<'_> {
    /// A point of the patch on which light from a direction falls, and its density, relative to a uniform
    /// one; the direction is asked for only where it matters.
    fn point_under(&self, towards: impl Fn() -> DVec3, [s, t]: [f64; 2]) -> Option<([f64; 2], f64)> {
        let Facet { corners, normal, .. } = &self.facet;
        if self.through.is_empty() {
            return Some((sampling::uniform_triangle([s, t]), 1.0));
        }
        let towards = towards();
        let at = match s < THROUGH_APERTURES {
            true => self.through.sample(towards, corners, [s / THROUGH_APERTURES, t])?,
            false => sampling::uniform_triangle([(s - THROUGH_APERTURES) / (1.0 - THROUGH_APERTURES), t]),
        };
        let through = self.through.pdf(towards, triangle::point(corners, at), *normal);
        let density = 1.0 - THROUGH_APERTURES + THROUGH_APERTURES * through * triangle::area(corners);
        Some((at, density))
    }
}

impl LooksForLight for Look<'_> {
    /// Adds ∫ φ_a H₀ dA over a patch to `moments`, a row of channels for each of the basis functions `phi`;
    /// and after that, for each part of the rays, by how much more it finds.
    fn add_moments<const N: usize>(
        &self,
        patch: usize,
        phi: impl Fn([f64; 2]) -> [f64; N],
        moments: &mut [f64],
    ) {
        let slot = self.patches.slot_of_patch(patch);
        let facet = self.patches.facet(self.tracer, slot);
        let area = self.patches.normalised_areas()[patch];
        // What thin glass leaves of a ray, per channel.
        let mut left = vec![1.0; self.channels];
        let mut add = |seen: &[Parts<N>], evenness: f64, scale: f64, power: &[f64]| {
            for (c, seen) in seen.iter().enumerate() {
                for (row, sum) in
                    moments.chunks_exact_mut(self.channels).zip(seen.sums(evenness).as_flattened())
                {
                    row[c] += area * scale * sum * power[c];
                }
            }
        };
        for light in 0..self.lights.len() {
            let mean = self.lights.mean_density(light, &facet.corners, facet.normal);
            if mean == Some(0.0) {
                continue;
            }
            let through = self.lights.sun_through(light, self.tracer, &facet.corners, facet.normal);
            // Points that are drawn unevenly are not to be scaled.
            let mean = mean.filter(|_| through.is_empty());
            let more = if through.is_empty() { 1 } else { MORE_POINTS };
            let rays =
                self.rays.div_ceil(RAYS_PER_LIGHT_RAY).saturating_mul(more).min(sampling::SEQUENCE_END);
            let mut seen = self.seen_of(&LightLook { light, slot, facet, mean, through, rays }, &phi);
            let whole: f64 = seen[0].whole.iter().sum();
            // Scale to what is known of all rays together.
            let scale = match mean {
                Some(mean) if whole > 0.0 => mean / whole,
                Some(_) => 0.0,
                None => {
                    seen.iter_mut().for_each(|seen| seen.whole = [1.0; PARTS]);
                    1.0 / f64::from(rays)
                }
            };
            add(&seen, 1.0, scale, self.lights.power(light));
        }
        let view = self.lights.sky_over(self.tracer, &facet.corners, facet.normal);
        if let (Some(view), Some(sky)) = (view, self.lights.sky()) {
            let rays = view.rays(self.rays);
            let (sequence, points) = Stream::Sky.stretch(self.seed, slot, u64::from(rays != self.rays), rays);
            let even = Parts::<N> { whole: [1.0; PARTS], ..Default::default() };
            let mut seen = vec![even; self.channels];
            let first = points.start;
            for k in points {
                let (at, beam) = view.sample_over(sky, &facet.corners, sequence.point(k));
                let SkyBeam { direction, weight, tint } = beam;
                let origin = triangle::point(&facet.corners, at);
                let ray = Ray { origin, direction, from: facet.face };
                left.fill(1.0);
                if weight > 0.0 && self.tracer.passes(&ray, f64::INFINITY, &mut left) {
                    let part = ((k - first) as usize * PARTS) / rays as usize;
                    let weight = weight * facet.weight(direction);
                    for (c, (seen, left)) in seen.iter_mut().zip(&left).enumerate() {
                        let tint = tint.map_or(1.0, |tint| tint[c]);
                        seen.add(part, weight * tint * left, phi(at));
                    }
                }
            }
            add(&seen, EVENNESS_OF_SKY, 1.0 / f64::from(rays), sky.zenith());
        }
    }
}

impl Look<'_> {
    /// What rays from a patch to a light find, each weighted by what it would bring if nothing stood in its
    /// way.
    fn seen_of<const N: usize>(&self, look: &LightLook, phi: impl Fn([f64; 2]) -> [f64; N]) -> Vec<Parts<N>> {
        let &LightLook { light, slot, facet, mean, rays, .. } = look;
        let (sequence, points) = match look.through.is_empty() {
            true => Stream::Lights.stretch(self.seed, slot, light as u64, rays),
            // All patches look through the same points of apertures: so each of these lights one patch.
            false => Stream::SunThrough.stretch(self.seed, 0, light as u64, rays),
        };
        let mut seen = vec![Parts::<N>::default(); self.channels];
        // What thin glass leaves of a ray, per channel.
        let mut left = vec![1.0; self.channels];
        let is_near = mean.is_some_and(|mean| self.lights.is_near(light, &facet.corners, facet.normal, mean));
        let first = points.start;
        for k in points {
            let [s, t, u, v] = sequence.point(k);
            // Draw a point by solid angle, by area, or through an aperture.
            let (at, beam, weight) = if is_near {
                let at = self.lights.point_near(light, &facet.corners, facet.normal, [s, t]);
                (at, self.lights.beam(light, triangle::point(&facet.corners, at), [u, v]), 1.0)
            } else {
                let towards = || self.lights.beam(light, facet.centre(), [u, v]).direction;
                let Some((at, density)) = look.point_under(towards, [s, t]) else { continue };
                let beam = self.lights.beam(light, triangle::point(&facet.corners, at), [u, v]);
                (at, beam, beam.density * facet.normal.dot(beam.direction) / density)
            };
            let point = triangle::point(&facet.corners, at);
            if !(weight > 0.0 && weight.is_finite()) {
                continue;
            }
            let part = ((k - first) as usize * PARTS) / rays as usize;
            seen.iter_mut().for_each(|seen| seen.whole[part] += weight);
            left.fill(1.0);
            let coated = facet.weight(beam.direction);
            let ray = Ray { origin: point, direction: beam.direction, from: facet.face };
            if beam.share > 0.0 && self.tracer.passes(&ray, beam.distance, &mut left) {
                for (seen, left) in seen.iter_mut().zip(&left) {
                    seen.add(part, weight * coated * beam.share * left, phi(at));
                }
            }
        }
        seen
    }
}
