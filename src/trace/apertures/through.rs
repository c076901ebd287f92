//! Light from one direction that reaches a flat surface through apertures, such as sun through a window: the
//! points of the surface that it lights, beside their density.

use glam::DVec3;

use super::{Apertures, Opening, SMALL};
use crate::scene::triangle;
use crate::trace::IN_PLANE;
use crate::trace::sampling::{Discrete, uniform_triangle};

/// The apertures through which light from a direction may reach a surface.
#[derive(Clone, Debug, Default)]
pub struct Through<'a> {
    seen: Vec<&'a Opening>,
    chances: Discrete,
}

impl Apertures {
    /// The small ones through which light from directions within a cone, given by its axis towards the light
    /// and the sine of its half angle, may reach a triangle with this normal.
    pub fn through(&self, (axis, sine): (DVec3, f64), corners: &[DVec3; 3], normal: DVec3) -> Through<'_> {
        if normal.dot(axis) <= IN_PLANE {
            return Through::default();
        }
        let (centre, radius) = circle(corners);
        let meets = |opening: &&Opening| {
            let (to, width) = circle(&opening.corners);
            let between = to - centre;
            let (along, rises) = (between.dot(axis), opening.normal.dot(axis) < 0.0);
            let apart = (between - along * axis).length();
            rises && along > -width && apart < radius + width + sine * along.abs()
        };
        let seen: Vec<&Opening> = self.openings().iter().filter(meets).collect();
        // What is lit through wide ones is lit as a whole, or not at all.
        if seen.iter().map(|opening| opening.area).sum::<f64>() > SMALL * triangle::area(corners) {
            return Through::default();
        }
        let width = |opening: &&Opening| -opening.area * opening.normal.dot(axis);
        let chances = Discrete::new(seen.iter().map(width)).normalised();
        Through { seen, chances }
    }
}

/// A circle around a triangle.
fn circle(corners: &[DVec3; 3]) -> (DVec3, f64) {
    let centre = corners.iter().sum::<DVec3>() / 3.0;
    (centre, corners.iter().map(|corner| corner.distance(centre)).fold(0.0, f64::max))
}

impl Through<'_> {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.chances.total() == 0.0
    }

    /// A point of the triangle, as weights of its second and third corner, on which light from a direction
    /// falls that comes through a point drawn on one of them; none where it falls beside the triangle.
    #[inline]
    pub fn sample(&self, towards: DVec3, corners: &[DVec3; 3], [u, v]: [f64; 2]) -> Option<[f64; 2]> {
        let (k, fresh) = self.chances.draw(u);
        let from = triangle::point(&self.seen[k].corners, uniform_triangle([fresh, v]));
        let across = triangle::across(corners);
        let distance = across.dot(from - corners[0]) / across.dot(towards);
        let [s, t] = triangle::weights_at(corners, from - distance * towards);
        (distance > 0.0 && s >= 0.0 && t >= 0.0 && s + t <= 1.0).then_some([s, t])
    }

    /// Density with which [`Through::sample`] draws a point of a triangle with this normal, per unit of
    /// normalised area.
    #[inline]
    pub fn pdf(&self, towards: DVec3, point: DVec3, normal: DVec3) -> f64 {
        let here = normal.dot(towards).abs();
        let pdf = |(k, opening): (usize, &&Opening)| {
            let there = -opening.normal.dot(towards);
            let is_met = there > 0.0 && opening.met_at(point, towards).is_some();
            if is_met { self.chances.weight(k) * here / (there * opening.area) } else { 0.0 }
        };
        self.seen.iter().enumerate().map(pdf).sum()
    }
}
