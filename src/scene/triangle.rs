//! Triangle: points, areas and normals of three corners.

use glam::DVec3;

/// The point with these weights of the second and third corner.
#[inline]
pub(crate) fn point(&[a, b, c]: &[DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
    a + (b - a) * u + (c - a) * v
}

/// Across the triangle, towards where its corners run counter-clockwise, and twice as long as its area.
#[inline]
pub(crate) fn across(&[a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

#[inline]
pub(crate) fn area(corners: &[DVec3; 3]) -> f64 {
    0.5 * across(corners).length()
}

/// The unit normal; zero where there is no area.
#[inline]
pub(crate) fn normal(corners: &[DVec3; 3]) -> DVec3 {
    across(corners).normalize_or_zero()
}
