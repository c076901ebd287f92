//! Polygon: a face of more than three corners, divided into triangles that together have its shape.
//!
//! What is convex, or seen whole from its first corner, becomes the fan around that corner, as everywhere.
//! Any other polygon is divided by constrained Delaunay triangulation of its corners (`spade`), as they lie
//! in the coordinate plane that it faces most: inside is what its border winds around. Holes are written by
//! OBJ files as bridges, two edges that run to and fro between the outer border and the inner one; these wind
//! around nothing.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use spade::handles::{FixedVertexHandle, OUTER_FACE};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// Triangles that turn the other way by no more than this share of the polygon are rounding.
const ROUNDING: f64 = 1e-9;

/// A polygon in triangles.
#[derive(Debug, PartialEq)]
pub(super) struct Divided {
    /// Places of three corners each, turning as the polygon does.
    pub triangles: Vec<[usize; 3]>,
    /// How far a corner lies from the plane that fits best, as a share of the polygon's longest extent.
    pub bend: f64,
    /// Whether its border crosses itself: then the triangles are a fan, and may overlap.
    pub crosses: bool,
}

/// Divides the polygon with these corners, of which there are at least three.
pub(super) fn divide(corners: &[DVec3]) -> Divided {
    let fan = || (2..corners.len()).map(|k| [0, k - 1, k]).collect();
    if corners.len() == 3 {
        return Divided { triangles: fan(), bend: 0.0, crosses: false };
    }
    // Twice the area, along the normal of the plane that fits best (Newell).
    let from = corners[0];
    let around = corners.iter().zip(corners.iter().cycle().skip(1));
    let normal: DVec3 = around.map(|(&p, &q)| (p - from).cross(q - from)).sum();
    let flat = Flat::new(corners, normal);
    let bend = bend(corners, normal);
    let area = flat.area();
    let crosses_or = |triangles: Option<Vec<_>>| {
        let crosses = triangles.is_none();
        Divided { triangles: triangles.unwrap_or_else(fan), bend, crosses }
    };
    let parts = (2..corners.len()).map(|k| flat.signed([0, k - 1, k]));
    if parts.clone().all(|part| part >= -ROUNDING * area) && flat.turn_around_first() <= TAU + ROUNDING {
        return crosses_or(Some(fan()));
    }
    if !(area > 0.0 && parts.map(f64::abs).sum::<f64>().is_finite()) {
        return crosses_or(None);
    }
    crosses_or(flat.divided())
}

/// How far the farthest corner is from the plane through the middle with this normal, by the longest extent.
fn bend(corners: &[DVec3], normal: DVec3) -> f64 {
    let normal = normal.normalize_or_zero();
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let heights = corners.iter().map(|corner| (*corner - middle).dot(normal).abs());
    let bounds = corners.iter().fold((corners[0], corners[0]), |(low, high), &p| (low.min(p), high.max(p)));
    let extent = (bounds.1 - bounds.0).max_element();
    if extent > 0.0 { heights.fold(0.0, f64::max) / extent } else { 0.0 }
}

/// A polygon's corners in the coordinate plane that it faces most, where it turns counter-clockwise.
struct Flat(Vec<DVec2>);

impl Flat {
    /// Lengths become at most 1 and no digit is lost: an axis is left out, and the rest are multiplied by a
    /// power of two. What lay on a line does so still.
    fn new(corners: &[DVec3], normal: DVec3) -> Self {
        let size = normal.abs();
        let axis = (0..3).fold(0, |most, axis| if size[axis] > size[most] { axis } else { most });
        let [u, v] = match normal[axis] > 0.0 {
            true => [(axis + 1) % 3, (axis + 2) % 3],
            false => [(axis + 2) % 3, (axis + 1) % 3],
        };
        let largest = corners.iter().map(|p| p[u].abs().max(p[v].abs())).fold(0.0, f64::max);
        let scale = if largest > 0.0 { (-largest.log2().ceil()).exp2() } else { 1.0 };
        // Next to these lengths what is smaller is none, and too small for the triangulation.
        let place = |x: f64| if (x * scale).abs() < 1e-40 { 0.0 } else { x * scale };
        Self(corners.iter().map(|p| DVec2::new(place(p[u]), place(p[v]))).collect())
    }

    /// Twice the area of a triangle of corners, negative if it turns clockwise.
    fn signed(&self, [a, b, c]: [usize; 3]) -> f64 {
        (self.0[b] - self.0[a]).perp_dot(self.0[c] - self.0[a])
    }

    /// Twice the area that the border winds around.
    fn area(&self) -> f64 {
        (2..self.0.len()).map(|k| self.signed([0, k - 1, k])).sum()
    }

    /// The angle by which the border turns around the first corner.
    fn turn_around_first(&self) -> f64 {
        let from = |k: usize| self.0[k] - self.0[0];
        let angle = |k: usize| from(k - 1).perp_dot(from(k)).atan2(from(k - 1).dot(from(k)));
        (2..self.0.len()).map(angle).sum()
    }

    /// Triangles of all that the border winds around; none if it crosses itself.
    fn divided(&self) -> Option<Vec<[usize; 3]>> {
        let mut mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
        let mut corner_of: Vec<usize> = Vec::with_capacity(self.0.len());
        let mut handles: Vec<FixedVertexHandle> = Vec::with_capacity(self.0.len());
        for (corner, place) in self.0.iter().enumerate() {
            let point = Point2::new(place.x, place.y);
            let handle = match handles.last() {
                Some(&near) => mesh.insert_with_hint(point, near),
                None => mesh.insert(point),
            };
            handles.push(handle.ok()?);
            if mesh.num_vertices() > corner_of.len() {
                corner_of.push(corner);
            }
        }
        // How often the border runs along an edge this way, less how often that way.
        let mut runs: HashMap<[usize; 2], i32> = HashMap::new();
        for (k, &from) in handles.iter().enumerate() {
            let to = handles[(k + 1) % handles.len()];
            let edges = mesh.try_add_constraint(from, to);
            if edges.is_empty() && from != to {
                return None;
            }
            for edge in edges.into_iter().map(|edge| mesh.directed_edge(edge)) {
                let [a, b] = [edge.from(), edge.to()].map(|end| end.fix().index());
                *runs.entry([a, b]).or_default() += 1;
                *runs.entry([b, a]).or_default() -= 1;
            }
        }
        // From the outside in: across each edge the border winds as often more as it runs along it.
        let mut windings: Vec<Option<i32>> = vec![None; mesh.num_all_faces()];
        windings[OUTER_FACE.index()] = Some(0);
        let mut next: Vec<_> = mesh.convex_hull().map(|edge| edge.rev()).collect();
        while let Some(edge) = next.pop() {
            let (inside, outside) = (edge.face(), edge.rev().face());
            if windings[inside.fix().index()].is_some() {
                continue;
            }
            let ends = [edge.from(), edge.to()].map(|end| end.fix().index());
            let run = runs.get(&ends).copied().unwrap_or(0);
            windings[inside.fix().index()] = windings[outside.fix().index()].map(|winding| winding + run);
            next.extend([edge.next().rev(), edge.prev().rev()]);
        }
        let mut triangles = Vec::with_capacity(self.0.len() - 2);
        for face in mesh.inner_faces() {
            let [a, b, c] = face.vertices().map(|vertex| corner_of[vertex.fix().index()]);
            match windings[face.fix().index()]? {
                0 => {}
                winding if winding > 0 => triangles.push([a, b, c]),
                _ => triangles.push([a, c, b]),
            }
        }
        // Slivers that are rounding alone, where corners lie on a line but for it, are left out.
        let area = self.area();
        triangles.retain(|&triangle| self.signed(triangle).abs() > f64::EPSILON * area);
        triangles.sort_unstable();
        let sum: f64 = triangles.iter().map(|&triangle| self.signed(triangle)).sum();
        ((sum / area - 1.0).abs() < ROUNDING).then_some(triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::triangle;

    fn level(corners: &[[f64; 2]]) -> Vec<DVec3> {
        corners.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
    }

    /// The area along an axis.
    fn area(corners: &[DVec3], triangles: &[[usize; 3]]) -> DVec3 {
        let area_vector = |of: &[usize; 3]| triangle::across(&of.map(|k| corners[k])) / 2.0;
        triangles.iter().map(area_vector).sum()
    }

    /// The sum of sizes, which is more than that of [`area`] where triangles overlap.
    fn covered(corners: &[DVec3], triangles: &[[usize; 3]]) -> f64 {
        triangles.iter().map(|&triangle| area(corners, &[triangle]).length()).sum()
    }

    /// A point of a circle on a slanting plane.
    fn on_circle(turn: f64) -> DVec3 {
        DVec3::new((turn * TAU).cos(), 0.3 * (turn * TAU).cos(), (turn * TAU).sin())
    }

    fn turned(corners: &[DVec3], by: usize) -> Vec<DVec3> {
        corners.iter().cycle().skip(by).take(corners.len()).copied().collect()
    }

    /// An L, a wall with a doorway, a comb, a square with a square hole bridged to it, and one with two.
    fn concave() -> Vec<(Vec<DVec3>, f64)> {
        vec![
            (level(&[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]]), 3.0),
            (level(&[[0., 0.], [1., 0.], [1., 2.], [2., 2.], [2., 0.], [3., 0.], [3., 2.5], [0., 2.5]]), 5.5),
            (level(&[[0., 0.], [1., 3.], [2., 0.], [3., 3.], [4., 0.], [4., 4.], [0., 4.]]), 10.0),
            (
                level(&[
                    [0., 0.],
                    [4., 0.],
                    [4., 4.],
                    [0., 4.],
                    [0., 0.],
                    [1., 1.],
                    [1., 2.],
                    [2., 2.],
                    [2., 1.],
                    [1., 1.],
                ]),
                15.0,
            ),
            (
                level(&[
                    [0., 0.],
                    [1., 1.],
                    [1., 2.],
                    [2., 2.],
                    [2., 1.],
                    [1., 1.],
                    [0., 0.],
                    [6., 0.],
                    [6., 4.],
                    [5., 3.],
                    [5., 2.],
                    [4., 2.],
                    [4., 3.],
                    [5., 3.],
                    [6., 4.],
                    [0., 4.],
                ]),
                22.0,
            ),
        ]
    }

    #[test]
    fn polygons_keep_their_shape_from_whichever_corner_and_whichever_side() {
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.8, 2.1);
        for (k, (corners, wanted)) in concave().into_iter().enumerate() {
            for by in 0..corners.len() {
                let level = turned(&corners, by);
                let mut under = level.clone();
                under.reverse();
                let slanting = level.iter().map(|&p| turn * (p + 100.0)).collect();
                for corners in [level, under, slanting] {
                    let divided = divide(&corners);
                    let found = area(&corners, &divided.triangles).length();
                    let covered = covered(&corners, &divided.triangles);
                    assert!((found - wanted).abs() < 1e-9 * wanted, "{k} {by}: {found}");
                    assert!((covered - wanted).abs() < 1e-9 * wanted, "{k} {by}: {covered}");
                    assert!(!divided.crosses && divided.bend < 1e-9);
                }
            }
        }
    }

    #[test]
    fn triangles_turn_as_their_polygon() {
        for (mut corners, wanted) in concave() {
            assert!((area(&corners, &divide(&corners).triangles).z - wanted).abs() < 1e-12);
            corners.reverse();
            assert!((area(&corners, &divide(&corners).triangles).z + wanted).abs() < 1e-12);
        }
    }

    #[test]
    fn convex_polygons_are_fans_with_corners_on_a_line_too() {
        let corners = level(&[[0., 0.], [1., 0.], [2., 0.], [2., 2.], [1., 2.], [0., 2.]]);
        let fan: Vec<[usize; 3]> = (2..6).map(|k| [0, k - 1, k]).collect();
        assert_eq!(divide(&corners).triangles, fan);
        let circle: Vec<DVec3> = (0..100).map(|k| on_circle(f64::from(k) / 100.0)).collect();
        assert_eq!(divide(&circle).triangles.len(), 98);
    }

    #[test]
    fn a_border_that_crosses_itself_is_found() {
        let bow = level(&[[0., 0.], [1., 1.], [1., 0.], [0., 2.]]);
        assert!(divide(&bow).crosses);
        let star: Vec<DVec3> = (0..5).map(|k| on_circle(f64::from(2 * k) / 5.0)).collect();
        assert!(divide(&star).crosses);
        // Twice around its first corner, farther and farther.
        let spiral = (0..17).map(|k| on_circle(f64::from(k) / 8.0) * (1.0 + 0.1 * f64::from(k)));
        let spiral: Vec<DVec3> = std::iter::once(DVec3::ZERO).chain(spiral).collect();
        assert!(divide(&spiral).crosses);
    }

    #[test]
    fn a_flat_polygon_has_no_bend_and_a_bent_one_has() {
        let mut corners = level(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
        assert_eq!(divide(&corners).bend, 0.0);
        corners[2].z = 0.4;
        let bend = divide(&corners).bend;
        assert!((0.05..0.15).contains(&bend), "{bend}");
        assert_eq!(divide(&corners).triangles.len(), 2);
    }

    #[test]
    fn polygons_of_many_corners_take_no_time() {
        // A gear: every other corner is farther in.
        let corners: Vec<DVec3> =
            (0..100_000).map(|k| on_circle(f64::from(k) / 1e5) * (1.0 - 0.1 * f64::from(k % 2))).collect();
        let divided = divide(&corners);
        assert!(!divided.crosses && divided.triangles.len() == corners.len() - 2);
    }
}
