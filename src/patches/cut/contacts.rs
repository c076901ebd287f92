//! Contacts: the lines along which other surfaces touch a face, pass through it, or end so near before it
//! that they shade it as if they touched it.
//!
//! Light changes by a step there, and a patch on both sides of such a line would mix what lies in the light
//! with what lies in the dark, or with what no light reaches at all, under the foot of a box. A line is an
//! edge of another face, seen along the normal, or where two faces intersect. Edges inside an outline count
//! only if they touch: the diagonal of a picture before a wall casts no shadow.

use glam::{DVec2, DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};

use crate::scene::FaceState;
use crate::scene::triangle;
use crate::trace::{Tracer, can_face};

/// What is as near as this to a face lies in its plane, normalised lengths: files often round to as much.
const TOUCH: f64 = 1e-6;

/// By how much boxes are widened before they are rounded to f32, normalised lengths.
const PAD: f64 = 1e-5;

/// A face whose height above the plane is this many times what it covers of it stands upright.
const UPRIGHT: f64 = 10.0;

/// Where something touches a face, as places of its [`Flat`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub ends: [DVec2; 2],
    /// Whether it lies in the face's plane; else it is near and casts a shadow here.
    pub touches: bool,
}

/// Other faces, by where they are.
pub(crate) struct Contacts<'t> {
    tracer: &'t Tracer<'t>,
    tree: Bvh2,
    /// Per place in the tree's order, its face.
    faces: Vec<u32>,
}

impl<'t> Contacts<'t> {
    pub fn new(tracer: &'t Tracer<'t>) -> Self {
        let all = tracer.scene().faces();
        let kept: Vec<u32> =
            (0..all.len() as u32).filter(|&f| all[f as usize].state == FaceState::Kept).collect();
        let boxes: Vec<Aabb> = kept.iter().map(|&f| box_around(tracer.corners(f as usize), PAD)).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::fastest_build(), &mut Default::default());
        let faces = tree.primitive_indices.iter().map(|&k| kept[k as usize]).collect();
        Self { tracer, tree, faces }
    }

    /// The lines along which other faces pass through a face, the longest first: one space ends there and
    /// another begins.
    pub fn crossings_on(&self, face: usize, flat: &Flat) -> Vec<[DVec2; 2]> {
        let others = self.faces_in(box_around(self.tracer.corners(face), PAD)).into_iter();
        let crossing = |other: usize| {
            let ends = crossing(&self.tracer.corners(other).map(|p| flat.place(p)))?;
            flat.clip(ends)
        };
        let mut lines: Vec<_> = others.filter(|&other| other != face).filter_map(crossing).collect();
        let length = |[p, q]: &[DVec2; 2]| p.distance_squared(*q);
        lines.sort_by(|a, b| length(b).total_cmp(&length(a)));
        lines
    }

    /// The lines along which other faces touch a face, or end at most `near` (normalised) before it; of these
    /// those longer than `shortest`.
    pub fn lines_on(&self, face: usize, flat: &Flat, near: f64, shortest: f64) -> Vec<Line> {
        let mut lines = Vec::new();
        let mut push = |ends: [DVec2; 2], touches: bool, counts: &dyn Fn() -> bool| {
            let ends = flat.clip(ends).filter(|[p, q]| touches || p.distance(*q) > shortest);
            lines.extend(ends.filter(|_| counts()).map(|ends| Line { ends, touches }));
        };
        let others = self.faces_in(box_around(self.tracer.corners(face), PAD + near));
        for other in others.into_iter().filter(|&other| other != face) {
            let at = self.tracer.corners(other).map(|p| flat.place(p));
            if flat.is_before(&at) {
                continue;
            }
            for k in 0..3 {
                let ends = [at[k], at[(k + 1) % 3]];
                let height = ends[0].z.abs().max(ends[1].z.abs());
                let touches = height <= TOUCH;
                if touches || (height <= near && !self.shines_on(other, flat)) {
                    push(ends.map(DVec3::truncate), touches, &|| self.is_outline(other, k, flat, touches));
                }
            }
        }
        lines
    }

    /// How many faces are at most `near` (normalised) from a face; counted up to about `most`.
    pub fn count_near(&self, face: usize, near: f64, most: usize) -> usize {
        let mut count = 0;
        self.tree.aabb_traverse(box_around(self.tracer.corners(face), PAD + near), |tree, node| {
            count += tree.nodes[node as usize].prim_count as usize;
            count < most
        });
        count
    }

    /// Whether a face is a lamp that is turned to the plane. From near by it is all that a patch below it
    /// would see, and form factors between two such surfaces do not close: patches that see other things
    /// beside it are better.
    fn shines_on(&self, face: usize, flat: &Flat) -> bool {
        let corners = self.tracer.corners(face).map(|p| flat.place(p));
        let front = triangle::normal(&corners);
        let [a, b, c] = corners;
        let middle = (a + b + c) / 3.0;
        let (below, normal) = (middle.with_z(0.0), DVec3::Z * middle.z.signum());
        self.tracer.scene().material_of(face).emits() && can_face((&[below], normal), (&corners, front))
    }

    /// Whether edge `k` of a face is one on which light changes: not a line within a surface, as seen along
    /// the normal of the plane, or as it touches the plane.
    fn is_outline(&self, face: usize, k: usize, flat: &Flat, touches: bool) -> bool {
        let corners = self.tracer.corners(face);
        let ends = [corners[k], corners[(k + 1) % 3]];
        let [p, q] = ends.map(|end| flat.place(end).truncate());
        // How far a corner is from the edge as seen in the plane, and how high it is.
        let reach = |corner: DVec3| {
            let place = flat.place(corner);
            ((q - p).perp_dot(place.truncate() - p) / p.distance(q), place.z)
        };
        let (mine, height) = reach(corners[(k + 2) % 3]);
        let continues = |(theirs, their_height): (f64, f64)| {
            let level = |across: f64, height: f64| match touches {
                true => height.abs() <= TOUCH,
                false => height.abs() < UPRIGHT * across.abs(),
            };
            mine * theirs < 0.0 && level(mine, height) && level(theirs, their_height)
        };
        let same = |a: DVec3, b: DVec3| a.distance_squared(b) <= TOUCH * TOUCH;
        let middle = [ends[0].midpoint(ends[1]); 3];
        !self.faces_in(box_around(&middle, PAD)).into_iter().filter(|&other| other != face).any(|other| {
            let others = self.tracer.corners(other);
            let shared = ends.iter().all(|&end| others.iter().any(|&corner| same(corner, end)));
            let third = others.iter().find(|&&corner| !ends.iter().any(|&end| same(corner, end)));
            shared && third.is_some_and(|&third| continues(reach(third)))
        })
    }

    /// The faces whose boxes meet this one, ascending.
    fn faces_in(&self, within: Aabb) -> Vec<usize> {
        let mut found = Vec::new();
        self.tree.aabb_traverse(within, |tree, node| {
            let node = &tree.nodes[node as usize];
            let (first, count) = (node.first_index as usize, node.prim_count as usize);
            found.extend(self.faces[first..first + count].iter().map(|&face| face as usize));
            true
        });
        found.sort_unstable();
        found
    }
}

/// Where a triangle passes through the plane, if it does.
fn crossing(at: &[DVec3; 3]) -> Option<[DVec2; 2]> {
    let heights = at.map(|p| p.z);
    let (low, high) = heights.iter().fold((0.0f64, 0.0f64), |(low, high), &z| (low.min(z), high.max(z)));
    if low >= -TOUCH || high <= TOUCH {
        return None;
    }
    let mut ends = (0..3).filter_map(|k| {
        let (p, q) = (at[k], at[(k + 1) % 3]);
        ((p.z < 0.0) != (q.z < 0.0)).then(|| p.lerp(q, p.z / (p.z - q.z)).truncate())
    });
    Some([ends.next()?, ends.next()?])
}

/// The box around a triangle, widened by `pad`, in f32.
pub(super) fn box_around(corners: &[DVec3; 3], pad: f64) -> Aabb {
    let [a, b, c] = *corners;
    let round = |p: DVec3| Vec3A::from(p.as_vec3());
    Aabb { min: round(a.min(b).min(c) - pad), max: round(a.max(b).max(c) + pad) }
}

/// A face laid flat: the first corner is the origin, the second lies on the first axis, and lengths are what
/// they are in space.
pub(crate) struct Flat {
    origin: DVec3,
    axes: [DVec3; 3],
    pub corners: [DVec2; 3],
}

impl Flat {
    /// Of a face's corners and unit normal.
    pub fn new(&[a, b, c]: &[DVec3; 3], normal: DVec3) -> Self {
        let first = (b - a).normalize_or_zero();
        let axes = [first, normal.cross(first), normal];
        let place = |p: DVec3| DVec2::new((p - a).dot(axes[0]), (p - a).dot(axes[1]));
        Self { origin: a, axes, corners: [DVec2::ZERO, place(b), place(c)] }
    }

    /// A point's place in the plane, and its height above it.
    pub fn place(&self, p: DVec3) -> DVec3 {
        DVec3::from(self.axes.map(|axis| (p - self.origin).dot(axis)))
    }

    /// Whether one side of the face has a triangle beyond it, as seen along the normal.
    fn is_before(&self, places: &[DVec3; 3]) -> bool {
        (0..3).any(|k| {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % 3]);
            places.iter().all(|p| (b - a).perp_dot(p.truncate() - a) <= 0.0)
        })
    }

    /// The part of a line of the plane that lies within the face.
    pub fn line(&self, ends: [DVec3; 2]) -> Option<[DVec2; 2]> {
        self.clip(ends.map(|end| self.place(end).truncate()))
    }

    /// The part of a line that lies within the face.
    fn clip(&self, [p, q]: [DVec2; 2]) -> Option<[DVec2; 2]> {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for k in 0..3 {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % 3]);
            let inside = |point: DVec2| (b - a).perp_dot(point - a);
            let (start, end) = (inside(p), inside(q));
            if start < 0.0 && end < 0.0 {
                return None;
            }
            let at = start / (start - end);
            if start < 0.0 {
                from = from.max(at);
            } else if end < 0.0 {
                to = to.min(at);
            }
        }
        (from < to).then(|| [p.lerp(q, from), p.lerp(q, to)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Face, Material, Scene, SceneParts, Side};

    type Quad = [[f64; 3]; 4];

    /// A floor of 4 m and a roof.
    const FLOOR: [Quad; 2] = [
        [[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]],
        [[-2.0, -2.0, 4.0], [-2.0, 2.0, 4.0], [2.0, 2.0, 4.0], [2.0, -2.0, 4.0]],
    ];

    /// The number and the total length, metres, of the lines on the floor's two faces where more faces touch
    /// them.
    fn lines_on_floor(more: &[Quad], near: f64) -> (usize, f64) {
        let mut parts =
            SceneParts { materials: vec![Material::diffuse("grey", &[0.5])], ..Default::default() };
        parts.objects.push("all".into());
        for quad in FLOOR.iter().chain(more) {
            let first = parts.vertices.len() as u32;
            parts.vertices.extend(quad.map(DVec3::from));
            parts.faces.extend([[0, 1, 2], [0, 2, 3]].map(|corners| Face {
                vertices: corners.map(|k| first + k),
                normals: None,
                material: 0,
                object: 0,
                state: FaceState::Kept,
            }));
        }
        let scene = Scene::new(parts).unwrap();
        let tracer = Tracer::new(&scene);
        let (contacts, scale) = (Contacts::new(&tracer), tracer.frame().scale());
        let lines: [Vec<Line>; 2] = [0, 1].map(|face| {
            let flat = Flat::new(tracer.corners(face), tracer.normal(face, Side::Front));
            let crossings = contacts.crossings_on(face, &flat).into_iter();
            let crossings = crossings.map(|ends| Line { ends, touches: true });
            contacts.lines_on(face, &flat, near / scale, 0.001).into_iter().chain(crossings).collect()
        });
        let length = |line: &Line| scale * line.ends[0].distance(line.ends[1]);
        (lines.iter().flatten().count(), lines.iter().flatten().map(length).sum())
    }

    /// The upright sheet over a line on the floor, from one height to another.
    fn sheet([p, q]: [[f64; 2]; 2], [low, high]: [f64; 2]) -> Quad {
        [[p[0], p[1], low], [q[0], q[1], low], [q[0], q[1], high], [p[0], p[1], high]]
    }

    /// The square of 1 m above the floor's middle, its diagonal along the floor's.
    fn plate(height: f64) -> Quad {
        [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| [x, y, height])
    }

    #[test]
    fn a_face_is_touched_where_a_sheet_stands_on_it() {
        let line = [[0.5, -1.0], [1.5, -1.0]];
        let (count, length) = lines_on_floor(&[sheet(line, [0.0, 1.0])], 0.0);
        assert_eq!(count, 1);
        assert!((length - 1.0).abs() < 1e-6, "{length}");
        assert_eq!(lines_on_floor(&[sheet(line, [0.1, 1.0])], 0.0).0, 0, "it hangs");
    }

    #[test]
    fn a_face_is_touched_where_a_sheet_passes_through_it() {
        let (_, length) = lines_on_floor(&[sheet([[0.5, -1.0], [1.5, -1.0]], [-0.5, 1.0])], 0.0);
        assert!((length - 1.0).abs() < 1e-6, "{length}");
    }

    #[test]
    fn what_hangs_near_a_face_counts_by_its_outline() {
        // Every side lies on one of the floor's faces.
        let (count, length) = lines_on_floor(&[plate(0.1)], 0.11);
        assert_eq!(count, 4);
        assert!((length - 4.0).abs() < 1e-6, "{length}");
        assert_eq!(lines_on_floor(&[plate(0.1)], 0.09).0, 0);
    }

    #[test]
    fn the_foot_of_a_box_is_an_outline_with_or_without_a_bottom() {
        let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        let sides = [0, 1, 2, 3].map(|k| sheet([corners[k], corners[(k + 1) % 4]], [0.0, 1.0]));
        for (bottom, per_side) in [(&[][..], 1.0), (&[plate(0.0)], 2.0)] {
            let (_, length) = lines_on_floor(&[&sides[..], bottom].concat(), 0.0);
            assert!((length - 4.0 * per_side).abs() < 1e-6, "{length}");
        }
    }

    #[test]
    fn neighbours_do_not_touch() {
        // A wall along the floor's side, and more floor beyond another, divided elsewhere.
        let wall = sheet([[-2.0, 2.0], [2.0, 2.0]], [0.0, 4.0]);
        let tiles = [[-2.0, -0.5], [-0.5, 2.0]]
            .map(|[y0, y1]| [[2.0, y0], [2.5, y0], [2.5, y1], [2.0, y1]].map(|[x, y]| [x, y, 0.0]));
        let lines = lines_on_floor(&[wall, tiles[0], tiles[1]], 0.0);
        assert!(lines.1 <= 8.0 + 1e-6, "lines along the border are for others to drop: {lines:?}");
    }
}
