//! Lights: what lights without area and the sky bring straight to patches.
//!
//! For each patch and light H₀ is the mean over the patch of what the light sends, times the share that
//! nothing hides. Where the mean of the geometry alone is known, the rays only have to tell that share,
//! weighted by what each would bring: so an unhidden point light is exact.

use super::{LooksForLight, PARTS, RAYS_PER_LIGHT_RAY};
use crate::patches::{Facet, Patches};
use crate::scene::triangle;
use crate::trace::sampling::Stream;
use crate::trace::{Beam, Lights, NarrowCone, Ray, SkyBeam, Through, Tracer, sampling};

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

/// All it takes to look for light from a patch.
pub(super) struct Look<'a> {
    pub tracer: &'a Tracer<'a>,
    pub patches: &'a Patches<'a>,
    pub lights: Lights,
    pub rays: u32,
    pub seed: u64,
    pub channels: usize,
}

/// A patch and a light that it looks at.
struct LightLook<'a> {
    light: usize,
    slot: u32,
    facet: Facet<'a>,
    points: LitPoints<'a>,
    rays: u32,
}

/// How points of a patch are drawn that look at a light.
enum LitPoints<'a> {
    /// All over the patch.
    Anywhere,
    /// By solid angle, as seen from the light.
    Near,
    /// Where light comes through apertures, if it may.
    Through(Through<'a>),
    /// Where the light's cone meets the patch.
    InCone(NarrowCone),
}

impl LitPoints<'_> {
    /// Whether they are drawn for all patches at once, and most miss any one of them.
    fn are_shared(&self) -> bool {
        matches!(self, Self::Through(_) | Self::InCone(_))
    }
}

/// So many times as many points of a patch look at a light that may come through apertures, or has a narrow
/// cone: edges are seen on it. Chosen, not fitted: most such points miss the patch and cost no ray.
const MORE_POINTS: u32 = 32;

/// The part of points on a patch that is drawn where light comes through apertures, if it may; a pure number.
/// Chosen, not fitted.
const THROUGH_APERTURES: f64 = 0.75;

impl LightLook<'_> {
    /// A point of the patch by four random numbers, the beam from the light to it, and what that would bring
    /// if nothing stood in its way, as a part of the light's power.
    fn draw(&self, lights: &Lights, [s, t, u, v]: [f64; 4]) -> Option<([f64; 2], Beam, f64)> {
        let &Self { light, facet: Facet { ref corners, normal, .. }, .. } = self;
        let beam_to = |at: [f64; 2]| lights.beam(light, triangle::point(corners, at), [u, v]);
        let by_area = |at: [f64; 2], density: f64| {
            let beam = beam_to(at);
            Some((at, beam, beam.density * normal.dot(beam.direction) / density))
        };
        match &self.points {
            LitPoints::Anywhere => by_area(sampling::uniform_triangle([s, t]), 1.0),
            LitPoints::Near => {
                let at = lights.point_near(light, corners, normal, [s, t]);
                Some((at, beam_to(at), 1.0))
            }
            LitPoints::InCone(cone) => {
                let at = cone.point(corners, normal, [s, t])?;
                Some((at, beam_to(at), cone.angle / triangle::area(corners)))
            }
            LitPoints::Through(through) => {
                let towards = lights.beam(light, self.facet.centre(), [u, v]).direction;
                let at = match s < THROUGH_APERTURES {
                    true => through.sample(towards, corners, [s / THROUGH_APERTURES, t])?,
                    false => {
                        let s = (s - THROUGH_APERTURES) / (1.0 - THROUGH_APERTURES);
                        sampling::uniform_triangle([s, t])
                    }
                };
                let pdf = through.pdf(towards, triangle::point(corners, at), normal);
                let density = 1.0 - THROUGH_APERTURES + THROUGH_APERTURES * pdf * triangle::area(corners);
                by_area(at, density)
            }
        }
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
            let points = self.points(light, &facet, mean);
            let is_shared = points.are_shared();
            let more = if is_shared { MORE_POINTS } else { 1 };
            let rays =
                self.rays.div_ceil(RAYS_PER_LIGHT_RAY).saturating_mul(more).min(sampling::SEQUENCE_END);
            let mut seen = self.seen_of(&LightLook { light, slot, facet, points, rays }, &phi);
            let whole: f64 = seen[0].whole.iter().sum();
            // Scale to what is known of all rays together, but not points that are drawn unevenly.
            let scale = match mean.filter(|_| !is_shared) {
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
    /// How points of a patch are drawn that look at a light of this mean density there, if that is known.
    fn points(&self, light: usize, facet: &Facet, mean: Option<f64>) -> LitPoints<'_> {
        let &Facet { ref corners, normal, .. } = facet;
        let through = self.lights.sun_through(light, self.tracer, corners, normal);
        match mean {
            _ if !through.is_empty() => LitPoints::Through(through),
            None => LitPoints::Anywhere,
            Some(mean) => match self.lights.narrow_cone(light, corners, mean) {
                Some(cone) => LitPoints::InCone(cone),
                None if self.lights.is_near(light, corners, normal, mean) => LitPoints::Near,
                None => LitPoints::Anywhere,
            },
        }
    }

    /// What rays from a patch to a light find, each weighted by what it would bring if nothing stood in its
    /// way.
    fn seen_of<const N: usize>(&self, look: &LightLook, phi: impl Fn([f64; 2]) -> [f64; N]) -> Vec<Parts<N>> {
        let &LightLook { light, slot, facet, rays, ref points } = look;
        // Where points are shared each lights one patch.
        let (sequence, points) = match points {
            LitPoints::Through(_) => Stream::SunThrough.stretch(self.seed, 0, light as u64, rays),
            LitPoints::InCone(_) => Stream::Narrow.stretch(self.seed, 0, light as u64, rays),
            _ => Stream::Lights.stretch(self.seed, slot, light as u64, rays),
        };
        let mut seen = vec![Parts::<N>::default(); self.channels];
        // What thin glass leaves of a ray, per channel.
        let mut left = vec![1.0; self.channels];
        let first = points.start;
        for k in points {
            let Some((at, beam, weight)) = look.draw(&self.lights, sequence.point(k)) else { continue };
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
