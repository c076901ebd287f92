//! Sky sampler: directions in which a sky is bright and a surface looks, beside their density.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::environment::EnvironmentSampler;
use crate::scene::{Environment, Sky, SkyKind, SkyShares, triangle};
use crate::trace::apertures::{ApertureView, Apertures};
use crate::trace::sampling::{
    Discrete, DiscreteTable, SEQUENCE_END, cosine_hemisphere, cosine_hemisphere_pdf, frame_around,
    uniform_triangle,
};
use crate::trace::solid_angle::target;

/// Cells of equal solid angle by which brightness is known: rings from zenith to nadir, and parts of each.
const RINGS: usize = 64;
const PARTS: usize = 64;

/// A sky whose brightest cell is no more than so many times as bright as its mean, where it shines, is drawn
/// by the cosine alone; a ratio. Chosen, not fitted: by brightness a wall would lose all that shines on its
/// back.
const PEAKED: f64 = 3.0;

/// Draws directions into a sky.
#[derive(Clone, Debug)]
pub struct SkySampler {
    shares: SkyShares,
    zenith: Vec<f64>,
    /// From the sky's frame, whose third axis is up.
    frame: DMat3,
    brightness: Brightness,
}

/// By what a sky's bright directions are drawn.
#[derive(Clone, Debug)]
enum Brightness {
    /// All directions are much alike.
    Even,
    /// By chances of the cells.
    Cells(DiscreteTable),
    /// By a picture.
    Environment(Arc<Environment>, EnvironmentSampler),
}

/// A direction into the sky.
#[derive(Clone, Copy, Debug)]
pub struct SkyBeam {
    /// A unit vector.
    pub direction: DVec3,
    /// Share of the zenith's radiance · cos θ / density of the direction.
    pub weight: f64,
    /// By what the zenith's red, green and blue are to be multiplied too, where they differ; a single channel
    /// takes the first.
    pub tint: Option<[f64; 3]>,
}

impl SkyBeam {
    /// By what the zenith's radiance is to be multiplied in a channel.
    #[inline]
    pub fn tint(&self, channel: usize) -> f64 {
        self.tint.map_or(1.0, |tint| tint[channel])
    }
}

/// A sky as it is looked for from a flat surface.
#[derive(Clone, Debug)]
pub struct SkyView {
    apertures: ApertureView,
    normal: DVec3,
}

/// The part of directions that is drawn towards apertures, where there are any; a pure number. Chosen, not
/// fitted: where all comes through these the others are lost, and where nothing does these are. What is
/// behind an aperture seldom sees the sky otherwise.
const TO_APERTURES: f64 = 0.75;

/// The part of rays that is drawn from apertures to a triangle near them; a pure number. Chosen, not fitted.
const FROM_APERTURES: f64 = 0.5;

/// So many times as many rays go into the sky from triangles that small apertures near them light up in part;
/// a number. Chosen, not fitted: there are few of these.
const MORE_RAYS: u32 = 8;

impl SkyView {
    /// The sky as it is looked for from a flat surface with these corners, or this one point, and this
    /// normal.
    pub fn over(apertures: &Apertures, corners: &[DVec3], normal: DVec3) -> Self {
        Self { apertures: apertures.view(corners, normal), normal }
    }

    /// Rays to be drawn over a triangle, where others have so many.
    pub fn rays(&self, usual: u32) -> u32 {
        if self.apertures.is_near() { usual.saturating_mul(MORE_RAYS).min(SEQUENCE_END) } else { usual }
    }

    /// A point of a triangle of the surface, as weights of its second and third corner, drawn by four random
    /// numbers together with a direction in which light from the sky may reach it; and what it brings, on
    /// average over the triangle, where nothing hides it.
    #[inline]
    pub fn sample_over(
        &self,
        sky: &SkySampler,
        corners: &[DVec3; 3],
        [s, t, u, v]: [f64; 4],
    ) -> ([f64; 2], SkyBeam) {
        if !self.apertures.is_near() {
            let at = uniform_triangle([s, t]);
            return (at, self.sample(sky, triangle::point(corners, at), [u, v]));
        }
        let (at, direction) = if u < FROM_APERTURES {
            let from = self.apertures.point([u / FROM_APERTURES, v]);
            let to = target(from, corners, [s, t]);
            (to.barycentrics, (from - to.point).normalize_or(self.normal))
        } else {
            let at = uniform_triangle([s, t]);
            let square = [(u - FROM_APERTURES) / (1.0 - FROM_APERTURES), v];
            (at, self.draw(sky, triangle::point(corners, at), square))
        };
        let point = triangle::point(corners, at);
        let pdf = |cosine: f64| {
            let from_apertures = self.apertures.target_pdf(corners, point, direction);
            (1.0 - FROM_APERTURES) * self.pdf(sky, (point, direction), cosine)
                + FROM_APERTURES * from_apertures
        };
        (at, sky.beam(self.normal, direction, pdf))
    }

    /// A direction in which light from the sky may reach a point of the surface, and what it brings where
    /// nothing hides it.
    #[inline]
    pub fn sample(&self, sky: &SkySampler, point: DVec3, [u, v]: [f64; 2]) -> SkyBeam {
        if self.apertures.is_empty() {
            return sky.sample(self.normal, [u, v]);
        }
        let direction = self.draw(sky, point, [u, v]);
        sky.beam(self.normal, direction, |cosine| self.pdf(sky, (point, direction), cosine))
    }

    #[inline]
    fn draw(&self, sky: &SkySampler, point: DVec3, [u, v]: [f64; 2]) -> DVec3 {
        match u < TO_APERTURES {
            true => self.apertures.sample(point, [u / TO_APERTURES, v]),
            false => sky.draw(self.normal, [(u - TO_APERTURES) / (1.0 - TO_APERTURES), v]),
        }
    }

    /// Density of [`SkyView::draw`], per unit of solid angle.
    #[inline]
    fn pdf(&self, sky: &SkySampler, (point, direction): (DVec3, DVec3), cosine: f64) -> f64 {
        let by_sky = sky.pdf_of(cosine, direction);
        (1.0 - TO_APERTURES) * by_sky + TO_APERTURES * self.apertures.pdf(point, direction)
    }
}

impl SkySampler {
    /// Makes a sampler for a sky.
    pub fn new(sky: &Sky) -> Self {
        let shares = sky.shares();
        let frame = frame_around(sky.up);
        let share = |cell: usize| shares.from(frame * in_cell([cell / PARTS, cell % PARTS], [0.5; 2]));
        let brightness = match &sky.kind {
            SkyKind::Constant => Brightness::Even,
            SkyKind::Environment(environment) => {
                Brightness::Environment(environment.clone(), EnvironmentSampler::new(environment))
            }
            _ => Brightness::of_cells(&(0..RINGS * PARTS).map(share).collect::<Vec<_>>()),
        };
        Self { shares, zenith: sky.zenith.clone(), frame, brightness }
    }

    /// Radiance of the zenith per channel, by which shares are multiplied.
    pub fn zenith(&self) -> &[f64] {
        &self.zenith
    }

    /// Radiance that comes from a direction, as a share of the zenith's.
    pub fn share_from(&self, towards: DVec3) -> f64 {
        self.shares.from(towards)
    }

    /// What comes from a direction: its share of the zenith's radiance and its tint, as a beam of this
    /// weight.
    #[inline]
    pub fn from(&self, direction: DVec3) -> SkyBeam {
        let (weight, tint) = self.shares.tinted(direction);
        SkyBeam { direction, weight, tint }
    }

    /// A direction above a surface with this normal, and what it brings where nothing hides it.
    ///
    /// One half of the directions is drawn by the cosine, the other by the sky's brightness; the density is
    /// the mean of both.
    #[inline]
    pub fn sample(&self, normal: DVec3, square: [f64; 2]) -> SkyBeam {
        let direction = self.draw(normal, square);
        self.beam(normal, direction, |cosine| self.pdf_of(cosine, direction))
    }

    #[inline]
    fn draw(&self, normal: DVec3, [u, v]: [f64; 2]) -> DVec3 {
        let by_cosine = |square: [f64; 2]| frame_around(normal) * cosine_hemisphere(square);
        match &self.brightness {
            Brightness::Even => by_cosine([u, v]),
            _ if u < 0.5 => by_cosine([2.0 * u, v]),
            Brightness::Cells(cells) => {
                let (cell, fresh) = cells.draw([2.0 * u - 1.0, v]);
                self.frame * in_cell(cell, fresh)
            }
            Brightness::Environment(environment, sampler) => sampler.sample(environment, [2.0 * u - 1.0, v]),
        }
    }

    /// What a direction brings to a surface with this normal, drawn with a density by its cosine.
    #[inline]
    fn beam(&self, normal: DVec3, direction: DVec3, pdf: impl Fn(f64) -> f64) -> SkyBeam {
        let cosine = normal.dot(direction);
        if cosine <= 0.0 {
            return SkyBeam { direction, weight: 0.0, tint: None };
        }
        let (share, tint) = self.shares.tinted(direction);
        SkyBeam { direction, weight: share * cosine / pdf(cosine), tint }
    }

    /// Density of [`SkySampler::sample`], per unit of solid angle.
    #[inline]
    pub fn pdf(&self, normal: DVec3, direction: DVec3) -> f64 {
        self.pdf_of(normal.dot(direction), direction)
    }

    #[inline]
    fn pdf_of(&self, cosine: f64, direction: DVec3) -> f64 {
        let by_cosine = cosine_hemisphere_pdf(cosine);
        let by_brightness = match &self.brightness {
            Brightness::Even => return by_cosine,
            Brightness::Cells(cells) => {
                let cell = cell_of(self.frame.transpose() * direction);
                cells.weight(cell) * (RINGS * PARTS) as f64 / (4.0 * PI)
            }
            Brightness::Environment(environment, sampler) => sampler.pdf(environment, direction),
        };
        0.5 * (by_cosine + by_brightness)
    }
}

impl Brightness {
    /// By the brightness of cells, ring by ring.
    fn of_cells(cells: &[f64]) -> Self {
        let (sum, shining) = (cells.iter().sum::<f64>(), cells.iter().filter(|&&cell| cell > 0.0).count());
        if cells.iter().copied().fold(0.0, f64::max) * shining as f64 <= PEAKED * sum {
            return Self::Even;
        }
        let rings = cells.chunks(PARTS).map(|ring| Discrete::new(ring.iter().copied()));
        Self::Cells(DiscreteTable::new(rings.collect(), |_| 1.0))
    }
}

/// The ring and part of the cell that a direction lies in; the third axis is up.
fn cell_of(direction: DVec3) -> [usize; 2] {
    let place = |x: f64, count: usize| ((x * count as f64) as usize).min(count - 1);
    let ring = place(0.5 * (1.0 - direction.z), RINGS);
    let part = place(0.5 + direction.y.atan2(direction.x) / TAU, PARTS);
    [ring, part]
}

/// A direction within a cell, uniform in solid angle; the third axis is up.
fn in_cell([ring, part]: [usize; 2], [u, v]: [f64; 2]) -> DVec3 {
    let height = 1.0 - 2.0 * (ring as f64 + v) / RINGS as f64;
    let angle = ((part as f64 + u) / PARTS as f64 - 0.5) * TAU;
    let radius = (1.0 - height * height).max(0.0).sqrt();
    DVec3::new(radius * angle.cos(), radius * angle.sin(), height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::sampling::Stream;

    fn skies() -> [SkySampler; 3] {
        let sun = DVec3::new(0.5, 0.4, 0.1).normalize();
        [SkyKind::Constant, SkyKind::Overcast, SkyKind::Clear { sun }]
            .map(|kind| SkySampler::new(&Sky { kind, up: DVec3::Y, zenith: vec![1.0], ground: 0.2 }))
    }

    #[test]
    fn directions_are_drawn_with_their_density() {
        let normal = DVec3::new(0.6, 0.3, -0.2).normalize();
        for sky in skies() {
            let n = 1 << 15;
            let mut drawn = [0.0; 4];
            for k in 0..n {
                let [u, v, ..] = Stream::Callers.sequence(4, 1, 0).point(k);
                let SkyBeam { direction: d, weight, .. } = sky.sample(normal, [u, v]);
                let tests = [1.0, d.x, d.y * d.y, d.z];
                drawn.iter_mut().zip(tests).for_each(|(sum, f)| *sum += f * weight / f64::from(n));
            }
            // The same integrals of share · cos θ by the midpoint rule.
            let steps = 400;
            let mut integral = [0.0; 4];
            for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
                let height = (i as f64 + 0.5) / steps as f64;
                let angle = (j as f64 + 0.5) / steps as f64 * TAU;
                let radius = (1.0 - height * height).sqrt();
                let d = frame_around(normal) * DVec3::new(radius * angle.cos(), radius * angle.sin(), height);
                let value = sky.share_from(d) * height * TAU / f64::from(steps * steps);
                let tests = [1.0, d.x, d.y * d.y, d.z];
                integral.iter_mut().zip(tests).for_each(|(sum, f)| *sum += f * value);
            }
            for (a, b) in drawn.iter().zip(integral) {
                assert!((a - b).abs() < 2e-3 * integral[0], "{drawn:?} {integral:?}");
            }
        }
    }

    #[test]
    fn densities_integrate_to_one() {
        // Of what is drawn by brightness some falls below a surface's horizon.
        for sky in skies().into_iter().skip(1) {
            let steps = 512;
            let sum: f64 = (0..steps * steps)
                .map(|k| {
                    let height = 1.0 - 2.0 * ((k / steps) as f64 + 0.5) / steps as f64;
                    let angle = ((k % steps) as f64 + 0.5) / steps as f64 * TAU;
                    let radius = (1.0 - height * height).sqrt();
                    let d = DVec3::new(radius * angle.cos(), height, radius * angle.sin());
                    sky.pdf(DVec3::X, d) * 4.0 * PI / (steps * steps) as f64
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-3, "{sum}");
        }
    }
}
