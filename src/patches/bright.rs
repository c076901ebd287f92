//! Bright parts of faces: where to look for light that comes from little, such as a sunlit spot, seen from a
//! point.
//!
//! Rays by the cosine find what is small seldom, and what it sends is noise. So points are drawn on bright
//! parts, too: each part chosen by what it would contribute if nothing stood in between, and the point by
//! solid angle. Parts are faces, divided in four again and again where the light that they send varies most.
//! Faces that emit are left to [`Lamps`].

use std::collections::BinaryHeap;

use glam::DVec3;
use nalgebra::DMatrix;

use super::{Barycentrics, Patches};
use crate::scene::{Side, triangle};
use crate::trace::sampling::Discrete;
use crate::trace::{
    Hit, IN_PLANE, Lamps, Tracer, can_face, form_factor_estimate, form_factor_to_triangle, towards_triangle,
    triangle_pdf,
};

/// The most parts. Chosen, not fitted: with more, a view takes as long as its rays.
const MOST: usize = 512;

/// Faces are divided until what varies within their parts is less than this part of all that is sent; a pure
/// number. Chosen, not fitted.
const UNEVEN: f64 = 0.02;

/// With no more parts than this, what each contributes is integrated and not estimated: few are large ones.
/// Chosen, not fitted.
const MOST_EXACT: usize = 64;

/// Parts are bright to a point that are so many times as bright as all is that it sees; a number. Chosen, not
/// fitted: where all is much the same, rays find it all.
const BRIGHT: f64 = 1.25;

const NONE: u32 = u32::MAX;

/// The faces from which most light comes, in parts.
#[derive(Clone, Debug)]
pub struct BrightParts {
    parts: Vec<Part>,
    /// Per face its front and back: a node, or [`NONE`].
    roots: Vec<[u32; 2]>,
    nodes: Vec<Node>,
}

/// A face, or a part of it, as it was divided.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Node {
    /// Into four nodes, of which this is the first: at the three corners, and in the middle.
    Divided(u32),
    /// Not further: a part.
    Part(u32),
}

/// A part of a face's side.
#[derive(Clone, Debug)]
struct Part {
    face: u32,
    corners: [DVec3; 3],
    /// Unit normal of the side.
    normal: DVec3,
    area: f64,
    /// Root mean square of the radiance that it sends out, averaged over channels: a part that is bright here
    /// and dark there makes more noise than its mean would.
    radiance: f64,
}

/// How bright parts look from a point: chances to be drawn.
#[derive(Clone, Debug, Default)]
pub struct BrightView(Discrete);

/// A point on a bright part.
#[derive(Clone, Copy, Debug)]
pub struct BrightPoint {
    /// The face on which it lies.
    pub face: u32,
    /// Towards it, a unit vector.
    pub direction: DVec3,
    /// Density with which it was drawn, per unit of solid angle.
    pub pdf: f64,
}

impl BrightView {
    /// Whether none is above the horizon.
    pub fn is_empty(&self) -> bool {
        self.0.total() == 0.0
    }
}

impl BrightParts {
    /// Those of patches that send out this radiance, n × c.
    ///
    /// # Panics
    /// If `radiance` has not n rows.
    pub fn new(tracer: &Tracer, patches: &Patches, radiance: &DMatrix<f64>, lamps: &Lamps) -> Self {
        let mut divided = Division::new(patches, radiance, lamps);
        while divided.divide_most_uneven() {}
        let mut bright = Self { parts: Vec::new(), roots: divided.roots, nodes: Vec::new() };
        bright.nodes = divided.nodes.iter().map(|_| Node::Part(NONE)).collect();
        for (node, piece) in divided.nodes.into_iter().enumerate() {
            bright.nodes[node] = match piece.children {
                Some(first) => Node::Divided(first),
                None if piece.power > 0.0 => {
                    bright.parts.push(Part::of(tracer, &piece));
                    Node::Part(bright.parts.len() as u32 - 1)
                }
                None => Node::Part(NONE),
            };
        }
        bright
    }

    /// How they look from a point with a normal.
    pub fn view_from(&self, point: DVec3, normal: DVec3) -> BrightView {
        let is_exact = self.parts.len() <= MOST_EXACT;
        let light = |part: &Part| match is_exact {
            true => part.radiance * form_factor_to_triangle(point, normal, &part.turned()),
            false => part.estimate(point, normal),
        };
        let mut chances: Vec<f64> = self.parts.iter().map(light).collect();
        // What they send together is about their mean radiance over all directions, by the cosine.
        let mean: f64 = chances.iter().sum();
        let dim = self.parts.iter().map(|part| part.radiance <= BRIGHT * mean);
        chances.iter_mut().zip(dim).for_each(|(chance, is_dim)| *chance *= if is_dim { 0.0 } else { 1.0 });
        BrightView(Discrete::new(chances).normalised())
    }

    /// A point drawn on one of them; none where none is above the horizon.
    #[inline]
    pub fn sample(&self, view: &BrightView, point: DVec3, [u, v]: [f64; 2]) -> Option<BrightPoint> {
        if view.is_empty() {
            return None;
        }
        let (k, fresh) = view.0.draw(u);
        let part = &self.parts[k];
        let direction = towards_triangle(point, &part.corners, [fresh, v]);
        let (distance, cosine) = part.met_along(point, direction)?;
        let pdf = view.0.weight(k) * triangle_pdf(point, &part.corners, (distance, cosine));
        Some(BrightPoint { face: part.face, direction, pdf })
    }

    /// Density with which [`BrightParts::sample`] draws a direction that meets a face there, per unit of
    /// solid angle.
    #[inline]
    pub fn pdf(&self, view: &BrightView, point: DVec3, direction: DVec3, hit: &Hit) -> f64 {
        if view.is_empty() {
            return 0.0;
        }
        let mut node = self.roots[hit.face as usize][usize::from(hit.side == Side::Back)];
        let mut at = hit.barycentrics;
        while node != NONE {
            match self.nodes[node as usize] {
                Node::Divided(first) => {
                    let (child, within) = quarter(at);
                    (node, at) = (first + child as u32, within);
                }
                Node::Part(NONE) => return 0.0,
                Node::Part(k) => {
                    let part = &self.parts[k as usize];
                    let chance = view.0.weight(k as usize);
                    let along = part.met_along(point, direction);
                    return along.map_or(0.0, |along| chance * triangle_pdf(point, &part.corners, along));
                }
            }
        }
        0.0
    }
}

/// Which quarter of a triangle a point lies in, and where within that.
#[inline]
fn quarter([u, v]: Barycentrics) -> (usize, Barycentrics) {
    match () {
        _ if u >= 0.5 => (1, [2.0 * u - 1.0, 2.0 * v]),
        _ if v >= 0.5 => (2, [2.0 * u, 2.0 * v - 1.0]),
        _ if u + v <= 0.5 => (0, [2.0 * u, 2.0 * v]),
        _ => (3, [1.0 - 2.0 * u, 1.0 - 2.0 * v]),
    }
}

/// The corners of a triangle's quarters, as [`quarter`] counts them.
fn quarters([a, b, c]: [Barycentrics; 3]) -> [[Barycentrics; 3]; 4] {
    let middle = |p: Barycentrics, q: Barycentrics| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
}

impl Part {
    fn of(tracer: &Tracer, piece: &Piece) -> Self {
        let corners = piece.corners.map(|at| triangle::point(tracer.corners(piece.face), at));
        let area = triangle::area(&corners);
        let normal = tracer.normal(piece.face, piece.side);
        Self { face: piece.face as u32, corners, normal, area, radiance: piece.rms() }
    }

    /// Its corners in the order in which its front is the side that sends.
    fn turned(&self) -> [DVec3; 3] {
        let [a, b, c] = self.corners;
        if triangle::across(&self.corners).dot(self.normal) < 0.0 { [a, c, b] } else { [a, b, c] }
    }

    /// The distance at which a direction from a point meets its plane, and the cosine there.
    #[inline]
    fn met_along(&self, point: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let (height, cosine) = (self.normal.dot(point - self.corners[0]), -self.normal.dot(direction));
        (height > IN_PLANE && cosine > 0.0).then(|| (height / cosine, cosine))
    }

    /// What it may contribute at a point with a normal, roughly, and more rather than less.
    fn estimate(&self, point: DVec3, normal: DVec3) -> f64 {
        if !can_face((&[point], normal), (&self.corners, self.normal)) {
            return 0.0;
        }
        self.radiance * form_factor_estimate((point, normal), (&self.corners, self.normal, self.area))
    }
}

/// Faces on their way to being divided.
struct Division {
    roots: Vec<[u32; 2]>,
    nodes: Vec<Piece>,
    /// Pieces by how uneven they are, as whole multiples of the least unevenness that counts.
    uneven: BinaryHeap<(u64, u32)>,
    least: f64,
    parts: usize,
}

/// A part of a face's side, and the patches whose centres lie in it.
struct Piece {
    face: usize,
    side: Side,
    /// On the face.
    corners: [Barycentrics; 3],
    members: Vec<Member>,
    /// Area times radiance, normalised.
    power: f64,
    children: Option<u32>,
}

#[derive(Clone, Copy)]
struct Member {
    /// Of the centre, within the piece.
    at: Barycentrics,
    area: f64,
    radiance: f64,
}

impl Piece {
    /// √(Σ A L² / Σ A).
    fn rms(&self) -> f64 {
        let area: f64 = self.members.iter().map(|member| member.area).sum();
        let squares: f64 =
            self.members.iter().map(|member| member.area * member.radiance * member.radiance).sum();
        (squares / area).sqrt()
    }

    /// Σ A |L − mean L|.
    fn unevenness(&self) -> f64 {
        let area: f64 = self.members.iter().map(|member| member.area).sum();
        let mean = self.power / area;
        self.members.iter().map(|member| member.area * (member.radiance - mean).abs()).sum()
    }
}

impl Division {
    /// Whole faces.
    fn new(patches: &Patches, radiance: &DMatrix<f64>, lamps: &Lamps) -> Self {
        assert_eq!(radiance.nrows(), patches.len(), "one row per patch");
        let areas = patches.normalised_areas();
        let sides = (0..patches.scene().faces().len()).flat_map(|face| Side::BOTH.map(|side| (face, side)));
        let piece = |(face, side): (usize, Side)| {
            let member = |i: usize| {
                let [a, b, c] = patches.corners(i);
                let at = [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0);
                Member { at, area: areas[i], radiance: radiance.row(i).mean() }
            };
            let members: Vec<Member> = patches.patches_of(face, side).map(member).collect();
            let power = members.iter().map(|member| member.area * member.radiance).sum();
            Piece {
                face,
                side,
                corners: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
                members,
                power,
                children: None,
            }
        };
        let sides = sides.filter(|&(face, side)| !lamps.contains(face, side));
        let mut pieces: Vec<Piece> = sides.map(piece).filter(|piece| piece.power > 0.0).collect();
        let whole: f64 = pieces.iter().map(|piece| piece.power).sum();
        pieces.sort_by(|a, b| b.power.total_cmp(&a.power));
        pieces.truncate(MOST);
        let roots = vec![[NONE; 2]; patches.scene().faces().len()];
        let least = UNEVEN * whole / MOST as f64;
        let mut division =
            Self { roots, nodes: Vec::new(), uneven: BinaryHeap::new(), least, parts: pieces.len() };
        for piece in pieces {
            division.roots[piece.face][usize::from(piece.side == Side::Back)] = division.nodes.len() as u32;
            division.add(piece);
        }
        division
    }

    fn add(&mut self, piece: Piece) {
        if piece.members.len() > 1 {
            self.uneven.push(((piece.unevenness() / self.least) as u64, self.nodes.len() as u32));
        }
        self.nodes.push(piece);
    }

    /// Divides the piece within which radiance varies most; whether there was one.
    fn divide_most_uneven(&mut self) -> bool {
        let Some((_, node)) = self.uneven.pop().filter(|&(uneven, _)| uneven > 0 && self.parts + 3 <= MOST)
        else {
            return false;
        };
        let first = self.nodes.len() as u32;
        let piece = &mut self.nodes[node as usize];
        piece.children = Some(first);
        let members = std::mem::take(&mut piece.members);
        let &mut Piece { face, side, corners, .. } = piece;
        let mut parts: [Vec<Member>; 4] = Default::default();
        for member in members {
            let (child, at) = quarter(member.at);
            parts[child].push(Member { at, ..member });
        }
        for (corners, members) in quarters(corners).into_iter().zip(parts) {
            let power = members.iter().map(|member| member.area * member.radiance).sum();
            self.add(Piece { face, side, corners, members, power, children: None });
        }
        self.parts += 3;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::Tessellation;
    use crate::scene::Scene;
    use crate::trace::Ray;
    use crate::trace::sampling::Stream;

    #[test]
    fn quarters_hold_the_points_that_are_counted_to_them() {
        let whole = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        for at in [[0.1, 0.1], [0.7, 0.2], [0.1, 0.8], [0.4, 0.4], [0.3, 0.3], [0.5, 0.0]] {
            let (child, [u, v]) = quarter(at);
            let [a, b, c] = quarters(whole)[child];
            for k in 0..2 {
                let back = a[k] * (1.0 - u - v) + b[k] * u + c[k] * v;
                assert!((back - at[k]).abs() < 1e-15, "{at:?} {child}");
            }
            assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0);
        }
    }

    #[test]
    fn what_bright_parts_send_is_found_with_the_density_that_is_told() {
        let scene = Scene::cornell_box();
        let tracer = Tracer::new(&scene);
        let patches = Patches::new(&tracer, &Tessellation::default()).unwrap();
        // A floor that is bright in one corner.
        let radiance = DMatrix::from_fn(patches.len(), 1, |i, _| {
            let p = tracer.frame().from_world(patches.centre(i));
            let is_floor = scene.objects()[scene.faces()[patches.place(i).face].object as usize] == "floor";
            if is_floor && p.x < 0.0 { 50.0 } else { 0.1 }
        });
        let bright = BrightParts::new(&tracer, &patches, &radiance, &Lamps::new(&tracer));
        let (point, normal) = (DVec3::new(0.1, 0.9, 0.2), DVec3::NEG_Y);
        let view = bright.view_from(point, normal);
        let radiance_at = |hit: &Hit| {
            let patch = patches.patch_at(hit.face as usize, hit.side, hit.barycentrics);
            patch.map_or(0.0, |patch| radiance[patch])
        };
        let (mut drawn, mut by_cosine) = (0.0, 0.0);
        let n = 1 << 14;
        for k in 0..n {
            let [u, v, x, y] = Stream::Callers.sequence(3, 0, 0).point(k);
            if let Some(to) = bright.sample(&view, point, [u, v]) {
                let ray = Ray { origin: point, direction: to.direction, from: Ray::FREE };
                let hit = tracer.closest_hit(&ray).unwrap();
                if hit.face == to.face {
                    let pdf = bright.pdf(&view, point, to.direction, &hit);
                    assert!((pdf / to.pdf - 1.0).abs() < 1e-6, "{pdf} {}", to.pdf);
                    let cosine = normal.dot(to.direction).max(0.0);
                    drawn += radiance_at(&hit) * cosine / to.pdf / f64::from(n);
                }
            }
            let frame = crate::trace::sampling::frame_around(normal);
            let direction = frame * crate::trace::sampling::cosine_hemisphere([x, y]);
            let ray = Ray { origin: point, direction, from: Ray::FREE };
            if let Some(hit) = tracer.closest_hit(&ray) {
                let seen = bright.pdf(&view, point, direction, &hit) > 0.0;
                by_cosine += if seen { radiance_at(&hit) * std::f64::consts::PI / f64::from(n) } else { 0.0 };
            }
        }
        assert!(drawn > 1.0 && (drawn / by_cosine - 1.0).abs() < 0.02, "{drawn} {by_cosine}");
    }
}
