//! Triangle: watertight intersection of a ray with a triangle.
//!
//! Woop, Benthin & Wald 2013, *Watertight Ray/Triangle Intersection*, in f64: the triangle is moved into a
//! space where the ray runs along one axis; the three edge tests of neighbouring triangles then share their
//! arithmetic to the last bit, so that no ray slips between them.

use glam::DVec3;

/// A ray, prepared for many triangles: axis permutation and shear.
pub(super) struct Shear {
    axes: [usize; 3],
    origin: [f64; 4],
    shear: [f64; 3],
}

/// Three corners, each padded to four numbers: indices masked to 0..4 then need no check.
pub(super) type Corners = [[f64; 4]; 3];

/// Distance, weights of the second and third corner, and whether the front was met.
pub(super) struct Crossing {
    pub distance: f64,
    pub barycentrics: [f64; 2],
    pub front: bool,
}

impl Shear {
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let d = direction.to_array();
        let z = direction.abs().max_position();
        // Swapping two axes where the ray runs backwards keeps the winding.
        let (x, y) = if d[z] < 0.0 { ((z + 2) % 3, (z + 1) % 3) } else { ((z + 1) % 3, (z + 2) % 3) };
        let shear = [d[x] / d[z], d[y] / d[z], 1.0 / d[z]];
        Self { axes: [x, y, z], origin: padded(origin), shear }
    }

    /// Where the ray's line crosses the triangle, at any distance, behind the origin included.
    #[inline(always)]
    pub fn cross(&self, corners: &Corners) -> Option<Crossing> {
        let [x, y, z] = self.axes.map(|axis| axis & 3);
        let [sx, sy, sz] = self.shear;
        // Move the corners into the space where the ray starts at the origin and runs along z.
        let sheared = |p: &[f64; 4]| {
            let height = p[z] - self.origin[z];
            [p[x] - self.origin[x] - sx * height, p[y] - self.origin[y] - sy * height, height]
        };
        let (a, b, c) = (sheared(&corners[0]), sheared(&corners[1]), sheared(&corners[2]));
        // Tell on which side of each edge the ray passes.
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        // Weigh the corners' heights into the distance.
        let inverse = 1.0 / determinant;
        let distance = sz * (u * a[2] + v * b[2] + w * c[2]) * inverse;
        Some(Crossing { distance, barycentrics: [v * inverse, w * inverse], front: determinant > 0.0 })
    }
}

/// A point as four numbers.
pub(super) fn padded(p: DVec3) -> [f64; 4] {
    [p.x, p.y, p.z, 0.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: Corners = [[0.0; 4], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]];

    #[test]
    fn a_crossing_has_its_distance_barycentrics_and_side() {
        for (height, front) in [(2.0, true), (-2.0, false)] {
            let direction = DVec3::new(0.0, 0.0, -height).normalize();
            let crossing = Shear::new(DVec3::new(0.25, 0.5, height), direction).cross(&CORNERS).unwrap();
            assert_eq!(crossing.distance, 2.0);
            assert_eq!(crossing.barycentrics, [0.25, 0.5]);
            assert_eq!(crossing.front, front);
        }
    }

    #[test]
    fn a_ray_through_a_shared_edge_meets_one_of_its_two_triangles() {
        let other = [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]];
        for k in 1..2000 {
            let s = k as f64 / 2000.0;
            let on_edge = DVec3::new(1.0 - s, s, 0.0);
            let origin = DVec3::new(0.3, 0.9 - s, 1.7);
            let shear = Shear::new(origin, (on_edge - origin).normalize());
            assert!(shear.cross(&CORNERS).is_some() || shear.cross(&other).is_some());
        }
    }
}
