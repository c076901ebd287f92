//! Solid angle: how much of all directions a triangle fills, and directions drawn towards it evenly.

use glam::DVec3;

use super::sampling::{uniform_spherical_triangle, uniform_triangle};
use crate::scene::triangle;

/// Triangles that fill less than this are drawn from by area, sr: in their angles rounding would show.
const TINY: f64 = 1e-6;

/// Solid angle that a triangle fills, seen from a point (Van Oosterom & Strackee 1983), sr.
pub fn solid_angle(point: DVec3, corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let [la, lb, lc] = [a.length(), b.length(), c.length()];
    let numerator = a.dot(b.cross(c)).abs();
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * numerator.atan2(denominator)
}

/// A direction from a point to a triangle with [`triangle_pdf`].
#[inline]
pub fn towards_triangle(point: DVec3, corners: &[DVec3; 3], square: [f64; 2]) -> DVec3 {
    if solid_angle(point, corners) < TINY {
        let at = triangle::point(corners, uniform_triangle(square));
        return (at - point).normalize_or(DVec3::Y);
    }
    uniform_spherical_triangle(corners.map(|corner| (corner - point).normalize_or(DVec3::Y)), square)
}

/// Density of [`towards_triangle`] in a direction that meets the triangle at this distance and with this
/// cosine to its normal, per unit of solid angle.
#[inline]
pub fn triangle_pdf(point: DVec3, corners: &[DVec3; 3], (distance, cosine): (f64, f64)) -> f64 {
    let angle = solid_angle(point, corners);
    if angle < TINY { distance * distance / (cosine * triangle::area(corners)) } else { 1.0 / angle }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn an_octant_fills_an_eighth_of_the_sphere() {
        assert!((solid_angle(DVec3::ZERO, &[DVec3::X, DVec3::Y, DVec3::Z]) - 0.5 * PI).abs() < 1e-15);
        let wide =
            [DVec3::new(100.0, -1e-3, 0.0), DVec3::new(-50.0, -1e-3, 87.0), DVec3::new(-50.0, -1e-3, -87.0)];
        assert!((solid_angle(DVec3::ZERO, &wide) / (2.0 * PI) - 1.0).abs() < 1e-4);
    }
}
