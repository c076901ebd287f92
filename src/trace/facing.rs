//! Facing: which surfaces can send light to each other, by the heights of their corners over each other's
//! planes.
//!
//! A point in the plane of a surface neither sends it light nor receives any from it. On which side of the
//! plane rounding puts the point must not matter, so a height counts only above a threshold.

use glam::DVec3;

/// Points no higher than this over a plane lie in it or behind it, normalised lengths.
///
/// Coordinates of at most 1 are rounded to 10⁻¹⁶, and so are heights near the face that defines the plane.
/// Far away from a small face they are off by 10⁻¹⁶ · distance / size of the face, which is 10⁻¹² at 10⁴
/// times its size. Real gaps of this height are narrower than those that files can express.
pub const IN_PLANE: f64 = 1e-12;

/// Whether two flat surfaces, each given by its corners (or its one point) and the unit normal of the side in
/// question, can send light to each other: some corner of either lies in front of the other's plane.
#[inline]
pub fn can_face((here, normal): (&[DVec3], DVec3), (there, other): (&[DVec3], DVec3)) -> bool {
    rises_over(there, here[0], normal) && rises_over(here, there[0], other)
}

/// Whether one of the points lies in front of the plane through a point with a unit normal.
#[inline]
fn rises_over(points: &[DVec3], plane: DVec3, normal: DVec3) -> bool {
    points.iter().any(|&point| normal.dot(point - plane) > IN_PLANE)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::scene::triangle;

    const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn no_surface_faces_its_own_back_or_its_neighbours_in_its_plane() {
        let neighbour = [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        for k in 0..1000 {
            let turn = DMat3::from_rotation_y(f64::from(k)) * DMat3::from_rotation_x(0.7 * f64::from(k));
            let place = |p: DVec3| 0.3 * (turn * p) + DVec3::new(0.1, 0.5, 0.3);
            let [own, other] = [TRIANGLE, neighbour].map(|corners| corners.map(place));
            for there in [own, other] {
                for side in [1.0, -1.0] {
                    let here = side * triangle::normal(&own);
                    assert!(!can_face((&own, here), (&there, triangle::normal(&there))), "turn {k}");
                }
            }
        }
    }

    #[test]
    fn surfaces_face_each_other_where_a_part_of_either_lies_in_front_of_the_other() {
        let above = |height: f64| TRIANGLE.map(|p| p + height * DVec3::Z);
        let faces = |there: [DVec3; 3], other: DVec3| can_face((&TRIANGLE, DVec3::Z), (&there, other));
        assert!(faces(above(1e-9), DVec3::NEG_Z));
        assert!(!faces(above(1e-9), DVec3::Z), "it looks away");
        assert!(!faces(above(-1e-9), DVec3::NEG_Z), "it is behind");
        // A wall that passes through the floor's plane, half of the floor before it.
        let wall = [DVec3::new(0.5, -1.0, -1.0), DVec3::new(0.5, 2.0, -1.0), DVec3::new(0.5, 0.5, 1.0)];
        assert!(faces(wall, DVec3::X) && faces(wall, DVec3::NEG_X));
    }
}
