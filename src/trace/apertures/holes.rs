//! Holes: what the faces of a plane leave open within the convex hull of all corners that lie in it.
//!
//! The corners are triangulated along the edges in the plane (`spade`), and a triangle is open if no opaque
//! face lies there. Edges that cross others are left out: then triangles may be part open, part covered.

use glam::{DMat3, DVec2, DVec3};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::planes::{Plane, STEP};
use crate::scene::{FaceState, triangle};
use crate::trace::sampling::frame_around;
use crate::trace::{Ray, Tracer};

/// The most corners of a plane that is looked at; a number. Chosen, not fitted: terrains have more, and their
/// holes are no windows.
const MOST_CORNERS: usize = 1 << 14;

/// Triangles less high than this are rounding, normalised lengths.
const THIN: f64 = 1e-6;

/// Faces this near to a triangle's middle cover it, normalised lengths.
const NEAR: f64 = 1e-5;

/// The holes of a plane, in triangles.
pub fn holes(tracer: &Tracer, plane: &Plane) -> Vec<[DVec3; 3]> {
    let frame = frame_around(plane.normal);
    let Some((corners, edges)) = drawn(tracer, plane, &frame) else { return Vec::new() };
    let Some(triangles) = triangulated(&corners, &edges) else { return Vec::new() };
    let place = |p: DVec2| frame * DVec3::new(p.x, p.y, plane.height);
    let all = triangles.into_iter().map(|corners| corners.map(place));
    all.filter(|corners| is_wide(corners) && is_open(tracer, plane, corners)).collect()
}

/// The corners that lie in the plane, and the edges between them; none where there are too many.
fn drawn(tracer: &Tracer, plane: &Plane, frame: &DMat3) -> Option<(Vec<DVec2>, Vec<[usize; 2]>)> {
    let scene = tracer.scene();
    let is_in_plane = |p: &DVec3| (plane.normal.dot(*p) - plane.height).abs() < STEP;
    let (mut corners, mut edges) = (Vec::new(), Vec::new());
    for face in (0..scene.faces().len()).filter(|&f| scene.faces()[f].state == FaceState::Kept) {
        let of_face = tracer.corners(face);
        let inside = of_face.map(|p| is_in_plane(&p));
        let places = [0, 1, 2].map(|k| {
            inside[k].then(|| {
                let p = frame.transpose() * of_face[k];
                corners.push(DVec2::new(p.x, p.y));
                corners.len() - 1
            })
        });
        if corners.len() > MOST_CORNERS {
            return None;
        }
        let ends = [0, 1, 2].map(|k| [places[k], places[(k + 1) % 3]]);
        edges.extend(ends.into_iter().filter_map(|[from, to]| Some([from?, to?])));
    }
    Some((corners, edges))
}

/// Triangles of the convex hull of these points, along edges between them.
fn triangulated(points: &[DVec2], edges: &[[usize; 2]]) -> Option<Vec<[DVec2; 3]>> {
    let mut mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut handles = Vec::with_capacity(points.len());
    for point in points {
        // What is smaller is none, and too small for the triangulation; and what differs by rounding is one.
        let [x, y] = point.to_array().map(|x| (x * GRID).round() / GRID + 0.0);
        handles.push(mesh.insert(Point2::new(x, y)).ok()?);
    }
    for &[from, to] in edges {
        let (from, to) = (handles[from], handles[to]);
        if from != to && mesh.can_add_constraint(from, to) {
            mesh.add_constraint(from, to);
        }
    }
    let corner = |p: Point2<f64>| DVec2::new(p.x, p.y);
    Some(mesh.inner_faces().map(|face| face.positions().map(corner)).collect())
}

/// Points are moved to a grid this fine, per unit of normalised length.
const GRID: f64 = (1u64 << 30) as f64;

/// Whether a triangle is more than a line.
fn is_wide(corners: &[DVec3; 3]) -> bool {
    2.0 * triangle::area(corners) > THIN * triangle::longest_squared(corners).sqrt()
}

/// Whether no opaque face lies at the middle of a triangle of the plane.
fn is_open(tracer: &Tracer, plane: &Plane, corners: &[DVec3; 3]) -> bool {
    let middle = corners.iter().sum::<DVec3>() / 3.0;
    let ray = Ray { origin: middle + NEAR * plane.normal, direction: -plane.normal, from: Ray::FREE };
    tracer.passes(&ray, 2.0 * NEAR, &mut vec![1.0; tracer.scene().channels()])
}
