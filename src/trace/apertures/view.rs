//! Apertures as a small surface sees them: directions towards them, beside their density.

use glam::DVec3;

use super::{Apertures, Opening};
use crate::trace::sampling::Discrete;
use crate::trace::solid_angle::{towards_triangle, triangle_pdf};
use crate::trace::{IN_PLANE, can_face, form_factor_estimate};

/// The most triangles of apertures that a surface looks at: those that matter most. Chosen, not fitted.
const MOST_SEEN: usize = 16;

/// Of those, the ones that matter less than this part of the most important are left to other samples.
/// Chosen, not fitted.
const LEAST_SEEN: f64 = 1e-3;

/// Apertures as seen from a surface.
#[derive(Clone, Debug, Default)]
pub struct ApertureView<'a> {
    seen: Vec<&'a Opening>,
    chances: Discrete,
}

impl Apertures {
    /// How they look from a flat surface with these corners, or this one point, and this normal.
    pub fn view(&self, corners: &[DVec3], normal: DVec3) -> ApertureView<'_> {
        if self.is_empty() {
            return ApertureView::default();
        }
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let faces = |opening: &&Opening| can_face((corners, normal), (&opening.corners, opening.normal));
        let worth = |opening: &Opening| {
            let there = (&opening.corners, opening.normal, opening.area);
            opening.passing * form_factor_estimate((centre, normal), there)
        };
        let openings = self.openings().iter().filter(faces).map(|opening| (opening, worth(opening)));
        let mut seen: Vec<(&Opening, f64)> = openings.filter(|&(_, worth)| worth > 0.0).collect();
        seen.sort_by(|a, b| b.1.total_cmp(&a.1));
        seen.truncate(MOST_SEEN);
        let most = seen.first().map_or(0.0, |&(_, worth)| worth);
        seen.retain(|&(_, worth)| worth > LEAST_SEEN * most);
        let chances = Discrete::new(seen.iter().map(|&(_, worth)| worth)).normalised();
        ApertureView { seen: seen.into_iter().map(|(opening, _)| opening).collect(), chances }
    }
}

impl ApertureView<'_> {
    /// Whether no aperture is above the horizon.
    pub fn is_empty(&self) -> bool {
        self.seen.is_empty()
    }

    /// A direction from a point of the surface to an aperture.
    #[inline]
    pub fn sample(&self, point: DVec3, [u, v]: [f64; 2]) -> DVec3 {
        let (k, fresh) = self.chances.draw(u);
        towards_triangle(point, &self.seen[k].corners, [fresh, v])
    }

    /// Density of [`ApertureView::sample`], per unit of solid angle.
    #[inline]
    pub fn pdf(&self, point: DVec3, direction: DVec3) -> f64 {
        let pdf = |(k, opening): (usize, &&Opening)| self.chances.weight(k) * opening.pdf(point, direction);
        self.seen.iter().enumerate().map(pdf).sum()
    }
}

impl Opening {
    /// Density of a direction that is drawn towards it.
    #[inline]
    fn pdf(&self, point: DVec3, direction: DVec3) -> f64 {
        let [a, b, c] = self.corners.map(|corner| corner - point);
        let (height, cosine) = (-self.normal.dot(a), -self.normal.dot(direction));
        if height <= IN_PLANE || cosine <= 0.0 {
            return 0.0;
        }
        let turns = [a.cross(b), b.cross(c), c.cross(a)].map(|across| across.dot(direction));
        let is_met = turns.iter().all(|&turn| turn >= 0.0) || turns.iter().all(|&turn| turn <= 0.0);
        if !is_met {
            return 0.0;
        }
        triangle_pdf(point, &self.corners, (height / cosine, cosine))
    }
}
