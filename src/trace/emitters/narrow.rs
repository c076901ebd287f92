//! Narrow: spots whose cones are hardly wider than what they shine on. Points there are drawn by directions
//! of the cone: of points all over a large triangle few would lie in the light.

use glam::DVec3;

use super::lights::{Lights, Place};
use crate::scene::{Light, triangle};
use crate::trace::IN_PLANE;
use crate::trace::sampling::uniform_cone;

/// A cone is narrow to a triangle that fills more than this part of it; a pure number. Chosen, not fitted.
const NARROW: f64 = 1.0 / 16.0;

/// A spot's cone.
#[derive(Clone, Copy, Debug)]
pub struct NarrowCone {
    position: DVec3,
    axis: DVec3,
    /// Solid angle, sr.
    pub angle: f64,
}

impl Lights {
    /// The cone of a spot that is narrow to a triangle of this [`Lights::mean_density`] and does not wholly
    /// cover it.
    pub fn narrow_cone(&self, light: usize, corners: &[DVec3; 3], mean: f64) -> Option<NarrowCone> {
        let (source @ Light::Spot { .. }, Place::At(position)) = self.light(light) else { return None };
        let (axis, angle) = source.cone();
        let is_narrow = mean * triangle::area(corners) > NARROW * angle;
        let is_lit = |corner: &DVec3| source.share_towards((corner - position).normalize_or_zero()) >= 1.0;
        (is_narrow && !corners.iter().all(is_lit)).then_some(NarrowCone { position, axis, angle })
    }
}

impl NarrowCone {
    /// Where a direction drawn evenly from the cone meets a triangle, as weights of its second and third
    /// corner, if it does.
    pub fn point(&self, corners: &[DVec3; 3], normal: DVec3, square: [f64; 2]) -> Option<[f64; 2]> {
        let direction = uniform_cone(self.axis, self.angle, square);
        let (height, cosine) = (normal.dot(self.position - corners[0]), -normal.dot(direction));
        if height <= IN_PLANE || cosine <= 0.0 {
            return None;
        }
        let at = triangle::weights_at(corners, self.position + direction * (height / cosine));
        triangle::weights(at).iter().all(|&weight| weight >= 0.0).then_some(at)
    }
}
