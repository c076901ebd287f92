//! Apertures as a small surface sees them: directions towards them, beside their density.

use std::sync::Arc;

use glam::DVec3;

use super::{Apertures, Opening, SMALL};
use crate::scene::{distance_to, triangle};
use crate::trace::sampling::{Discrete, uniform_triangle};
use crate::trace::solid_angle::{surroundings, target_density, towards_triangle, triangle_pdf};
use crate::trace::{IN_PLANE, can_face, form_factor_estimate};

/// The most triangles of apertures that a surface looks at: those that matter most. Chosen, not fitted.
const MOST_SEEN: usize = 16;

/// Of those, the ones that matter less than this part of the most important are left to other samples.
/// Chosen, not fitted.
const LEAST_SEEN: f64 = 1e-3;

/// Apertures as seen from a surface.
#[derive(Clone, Debug)]
pub struct ApertureView {
    seen: Arc<[Opening]>,
    chances: Discrete,
    /// Whether one is so small and near to the surface that it lights up a part of it alone.
    is_near: bool,
}

impl Apertures {
    /// How they look from a flat surface with these corners, or this one point, and this normal.
    pub fn view(&self, corners: &[DVec3], normal: DVec3) -> ApertureView {
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
        let seen: Arc<[Opening]> = seen.into_iter().map(|(opening, _)| opening.clone()).collect();
        let near = |corners: &[DVec3; 3]| {
            let ((centre, reach), most) = (surroundings(corners), SMALL * triangle::area(corners));
            let is_near = |corners: &[DVec3; 3]| distance_to(centre, corners, reach) <= reach;
            seen.iter().any(|opening| opening.area < most && is_near(&opening.corners))
        };
        let is_near = corners.try_into().is_ok_and(near);
        ApertureView { seen, chances, is_near }
    }
}

impl ApertureView {
    /// Whether no aperture is above the horizon.
    pub fn is_empty(&self) -> bool {
        self.seen.is_empty()
    }

    /// Whether one is so small and near to the surface that it lights up a part of it alone.
    pub fn is_near(&self) -> bool {
        self.is_near
    }

    /// A point of an aperture, uniform over each of its triangles.
    #[inline]
    pub fn point(&self, [u, v]: [f64; 2]) -> DVec3 {
        let (k, fresh) = self.chances.draw(u);
        triangle::point(&self.seen[k].corners, uniform_triangle([fresh, v]))
    }

    /// Density of a ray that leads from a point of the triangle with these corners, where light from a [point
    /// of an aperture](ApertureView::point) is looked for, to that point: per unit of solid angle, and
    /// relative to a uniform one over the triangle.
    #[inline]
    pub fn target_pdf(&self, corners: &[DVec3; 3], point: DVec3, direction: DVec3) -> f64 {
        let pdf = |(k, opening): (usize, &Opening)| {
            let Some((distance, cosine)) = opening.met_along(point, direction) else { return 0.0 };
            let density = target_density(point + distance * direction, corners, point);
            self.chances.weight(k) * density * distance * distance / (cosine * opening.area)
        };
        self.seen.iter().enumerate().map(pdf).sum()
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
        let pdf = |(k, opening): (usize, &Opening)| self.chances.weight(k) * opening.pdf(point, direction);
        self.seen.iter().enumerate().map(pdf).sum()
    }
}

impl Opening {
    /// The distance at which a direction from a point inside meets it, and the cosine there.
    #[inline]
    fn met_along(&self, point: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let (height, cosine) = (self.normal.dot(point - self.corners[0]), -self.normal.dot(direction));
        if height <= IN_PLANE || cosine <= 0.0 {
            return None;
        }
        self.met_at(point, direction).map(|distance| (distance, cosine))
    }

    /// Density of a direction that is drawn towards it.
    #[inline]
    fn pdf(&self, point: DVec3, direction: DVec3) -> f64 {
        self.met_along(point, direction).map_or(0.0, |along| triangle_pdf(point, &self.corners, along))
    }
}
