//! Solid angle: how much of all directions a triangle fills, and directions and points drawn by it.

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

/// A direction from a point to a triangle with [`triangle_pdf`]: uniform in solid angle to one that is near,
/// and to a point drawn by area on any other, which is as good and has no angles to work out.
#[inline]
pub fn towards_triangle(point: DVec3, corners: &[DVec3; 3], square: [f64; 2]) -> DVec3 {
    if !is_near(point, corners) || solid_angle(point, corners) < TINY {
        let at = triangle::point(corners, uniform_triangle(square));
        return (at - point).normalize_or(DVec3::Y);
    }
    uniform_spherical_triangle(corners.map(|corner| (corner - point).normalize_or(DVec3::Y)), square)
}

/// Density of [`towards_triangle`] in a direction that meets the triangle at this distance and with this
/// cosine to its normal, per unit of solid angle.
#[inline]
pub fn triangle_pdf(point: DVec3, corners: &[DVec3; 3], (distance, cosine): (f64, f64)) -> f64 {
    let by_area = || distance * distance / (cosine * triangle::area(corners));
    if !is_near(point, corners) {
        return by_area();
    }
    let angle = solid_angle(point, corners);
    if angle < TINY { by_area() } else { 1.0 / angle }
}

/// What is nearer than so many radii of a triangle lights it up unevenly, and sees it unevenly.
const NEAR: f64 = 3.0;

/// A point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    pub point: DVec3,
    /// Weights of the second and third corner.
    pub barycentrics: [f64; 2],
    /// Density with which it was drawn, relative to a uniform one.
    pub density: f64,
}

/// A triangle's centre, and the distance from it within which points light it up unevenly.
#[inline]
pub fn surroundings(corners: &[DVec3; 3]) -> (DVec3, f64) {
    let centre = corners.iter().sum::<DVec3>() / 3.0;
    let squared = corners.map(|corner| corner.distance_squared(centre));
    (centre, NEAR * squared.into_iter().fold(0.0, f64::max).sqrt())
}

#[inline]
fn is_near(from: DVec3, corners: &[DVec3; 3]) -> bool {
    let (centre, reach) = surroundings(corners);
    centre.distance_squared(from) <= reach * reach
}

/// Where on a triangle light from a point is looked for: drawn by solid angle where the point is near, so
/// that no part that it lights up is missed, and uniform over the triangle elsewhere.
#[inline]
pub fn target(from: DVec3, corners: &[DVec3; 3], square: [f64; 2]) -> Target {
    let uniform = || {
        let barycentrics = uniform_triangle(square);
        Target { point: triangle::point(corners, barycentrics), barycentrics, density: 1.0 }
    };
    if !is_near(from, corners) {
        return uniform();
    }
    let a = corners[0];
    let directions = corners.map(|corner| (corner - from).normalize_or_zero());
    let direction = uniform_spherical_triangle(directions, square);
    let across = triangle::across(corners);
    let (height, cosine) = (across.dot(a - from), across.dot(direction));
    let distance = height / cosine;
    let weights = triangle::weights_at(corners, from + distance * direction);
    // In the triangle's own plane there is no solid angle to draw from.
    let density = 0.5 * cosine.abs() / (distance * distance * solid_angle(from, corners));
    if !(density > 0.0 && density.is_finite() && weights.into_iter().all(f64::is_finite)) {
        return uniform();
    }
    let [u, v] = weights.map(|weight| weight.clamp(0.0, 1.0));
    let barycentrics = [u, v].map(|weight| weight / (u + v).max(1.0));
    Target { point: triangle::point(corners, barycentrics), barycentrics, density }
}

/// Density with which [`target`] draws a point of a triangle, relative to a uniform one.
#[inline]
pub fn target_density(from: DVec3, corners: &[DVec3; 3], point: DVec3) -> f64 {
    if !is_near(from, corners) {
        return 1.0;
    }
    let between = point - from;
    let squared = between.length_squared();
    let cosine = triangle::across(corners).dot(between).abs() / squared.sqrt();
    let density = 0.5 * cosine / (squared * solid_angle(from, corners));
    if density > 0.0 && density.is_finite() { density } else { 1.0 }
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
