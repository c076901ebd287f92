//! Holes: what the faces of a plane leave open within the convex hull of all corners that lie in it.
//!
//! The corners are triangulated along the edges in the plane (`spade`), and a triangle is open if no opaque
//! face lies there. Edges that cross others are left out: then triangles may be part open, part covered.

use std::collections::HashMap;

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

/// Edges times corners that are compared in a plane; a number. Chosen, not fitted: some hundredth of a
/// second.
const MOST_LOOKS: usize = 1 << 22;

/// The holes of a plane, in triangles.
pub fn holes(tracer: &Tracer, plane: &Plane) -> Vec<[DVec3; 3]> {
    let frame = frame_around(plane.normal);
    let Some(drawing) = Drawing::of(tracer, plane, &frame) else { return Vec::new() };
    let Some(triangles) = drawing.divided().triangulated() else { return Vec::new() };
    let place = |p: DVec2| frame * DVec3::new(p.x, p.y, plane.height);
    let all = triangles.into_iter().map(|corners| corners.map(place));
    all.filter(|corners| is_wide(corners) && is_open(tracer, plane, corners)).collect()
}

/// The corners that lie in a plane, each once, and the edges between them.
#[derive(Default)]
struct Drawing {
    corners: Vec<DVec2>,
    edges: Vec<[usize; 2]>,
    /// Corners by place, in steps.
    places: HashMap<[i64; 2], usize>,
}

impl Drawing {
    /// What lies in a plane; none where that is too much.
    fn of(tracer: &Tracer, plane: &Plane, frame: &DMat3) -> Option<Self> {
        let scene = tracer.scene();
        let is_in_plane = |p: &DVec3| (plane.normal.dot(*p) - plane.height).abs() < STEP;
        let mut drawing = Self::default();
        for face in (0..scene.faces().len()).filter(|&f| scene.faces()[f].state == FaceState::Kept) {
            let places = tracer.corners(face).map(|corner| {
                let p = frame.transpose() * corner;
                is_in_plane(&corner).then(|| drawing.corner(DVec2::new(p.x, p.y)))
            });
            if drawing.corners.len() > MOST_CORNERS {
                return None;
            }
            let ends = [0, 1, 2].map(|k| [places[k], places[(k + 1) % 3]]);
            let between = ends.into_iter().filter_map(|[from, to]| Some([from?, to?]));
            drawing.edges.extend(between.filter(|[from, to]| from != to).map(|[a, b]| [a.min(b), a.max(b)]));
        }
        drawing.edges.sort_unstable();
        drawing.edges.dedup();
        Some(drawing)
    }

    /// The corner at a place, or the one that is there already but for rounding.
    fn corner(&mut self, at: DVec2) -> usize {
        let step = |x: f64| (x / STEP).round() as i64;
        let [x, y] = at.to_array().map(step);
        let near = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x + i, y + j]));
        let known = near.filter_map(|place| self.places.get(&place)).next();
        known.copied().unwrap_or_else(|| {
            self.corners.push(at);
            self.places.insert([x, y], self.corners.len() - 1);
            self.corners.len() - 1
        })
    }

    /// The same with edges divided at the corners that lie on them.
    fn divided(mut self) -> Self {
        if self.edges.len() * self.corners.len() > MOST_LOOKS {
            return self;
        }
        let parts = |&[from, to]: &[usize; 2]| {
            let (start, along) = (self.corners[from], self.corners[to] - self.corners[from]);
            let length = along.length();
            let place = |(k, &corner): (usize, &DVec2)| {
                let (at, off) =
                    ((corner - start).dot(along) / length, (corner - start).perp_dot(along) / length);
                (off.abs() < 2.0 * STEP && at > -STEP && at < length + STEP).then_some((at, k))
            };
            let mut on_it: Vec<(f64, usize)> = self.corners.iter().enumerate().filter_map(place).collect();
            on_it.sort_by(|a, b| a.0.total_cmp(&b.0));
            on_it.windows(2).map(|pair| [pair[0].1, pair[1].1]).collect::<Vec<_>>()
        };
        self.edges = self.edges.iter().flat_map(parts).collect();
        self
    }

    /// Triangles of the convex hull of all corners, along edges.
    fn triangulated(&self) -> Option<Vec<[DVec2; 3]>> {
        let mut mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
        let mut handles = Vec::with_capacity(self.corners.len());
        for corner in &self.corners {
            // What is smaller than rounding is none, and too small for the triangulation.
            let [x, y] = corner.to_array().map(|x| if x.abs() < f64::EPSILON { 0.0 } else { x });
            handles.push(mesh.insert(Point2::new(x, y)).ok()?);
        }
        for ends in &self.edges {
            let [from, to] = ends.map(|end| handles[end]);
            if from != to && mesh.can_add_constraint(from, to) {
                mesh.add_constraint(from, to);
            }
        }
        let corner = |p: Point2<f64>| DVec2::new(p.x, p.y);
        Some(mesh.inner_faces().map(|face| face.positions().map(corner)).collect())
    }
}

/// Whether a triangle is more than a line.
fn is_wide(corners: &[DVec3; 3]) -> bool {
    2.0 * triangle::area(corners) > THIN * triangle::longest(corners)
}

/// Whether no opaque face lies at the middle of a triangle of the plane.
fn is_open(tracer: &Tracer, plane: &Plane, corners: &[DVec3; 3]) -> bool {
    let middle = corners.iter().sum::<DVec3>() / 3.0;
    let ray = Ray { origin: middle + NEAR * plane.normal, direction: -plane.normal, from: Ray::FREE };
    tracer.passes(&ray, 2.0 * NEAR, &mut vec![1.0; tracer.scene().channels()])
}
