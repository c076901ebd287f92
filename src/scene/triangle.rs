//! Triangle: points, areas and normals of three corners, and the weights of corners at a point.

use glam::DVec3;

/// The point with these weights of the second and third corner.
#[inline]
pub(crate) fn point(&[a, b, c]: &[DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
    a + (b - a) * u + (c - a) * v
}

/// The weights of the second and third corner at a point of the triangle's plane; not finite where there is
/// no area.
#[inline]
pub(crate) fn weights_at(corners: &[DVec3; 3], point: DVec3) -> [f64; 2] {
    let (&[a, b, c], across) = (corners, across(corners));
    let (to, squared) = (point - a, across.length_squared());
    [to.cross(c - a).dot(across) / squared, (b - a).cross(to).dot(across) / squared]
}

/// The weights of all three corners at the point with these of the second and third: 1 together, and what
/// linear functions that are 1 at one corner and 0 at the others have there.
#[inline]
pub(crate) fn weights([u, v]: [f64; 2]) -> [f64; 3] {
    [1.0 - u - v, u, v]
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

/// The square of the length of the longest edge.
#[inline]
pub(crate) fn longest_squared(&[a, b, c]: &[DVec3; 3]) -> f64 {
    (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared())
}

/// The length of the longest edge.
#[inline]
pub(crate) fn longest(corners: &[DVec3; 3]) -> f64 {
    longest_squared(corners).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges of 3, 4 and 5, away from the origin.
    const CORNERS: [DVec3; 3] =
        [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 2.0, 3.0), DVec3::new(1.0, 6.0, 3.0)];

    #[test]
    fn weights_of_corners_give_the_point() {
        for at in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.25, 0.5], [0.125, 0.125]] {
            let weights = weights(at);
            let mean: DVec3 = CORNERS.iter().zip(weights).map(|(&corner, weight)| weight * corner).sum();
            assert_eq!(mean, point(&CORNERS, at));
            assert_eq!(weights.iter().sum::<f64>(), 1.0);
        }
    }

    #[test]
    fn a_right_triangle_has_its_area_normal_and_longest_edge_from_any_corner() {
        let [a, b, c] = CORNERS;
        for corners in [[a, b, c], [b, c, a], [c, a, b]] {
            assert_eq!((area(&corners), longest_squared(&corners)), (6.0, 25.0));
            assert_eq!((across(&corners), normal(&corners)), (12.0 * DVec3::Z, DVec3::Z));
        }
        assert_eq!(normal(&[a, a, b]), DVec3::ZERO);
    }
}
