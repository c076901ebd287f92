//! Parts: the triangles into which contacts part a face before it is cut into patches.
//!
//! A patch lies on one side of a wall that stands on its face or on the other, or light would leak through:
//! lines along which other faces touch are drawn exactly, and the two sides of a thin wall are two lines.
//! Lines below what is near but does not touch cast shadows alone: those that run along others, or along the
//! face's border, are made one with them, and ends that lie near a line or another end are moved there. What
//! is left is triangulated with these lines as edges (constrained Delaunay triangulation, by `spade`). Where
//! that comes to nothing a face stays whole.
//!
//! The outlines of what covers a face in its own plane part it however small it is: a patch is covered or it
//! is not. So do the lines along which other faces pass through it.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};

use super::contacts::{Contacts, Flat, Line};
use super::fineness::Fineness;
use super::grid::cells_for;
use super::part::Part;
use super::surroundings::Surroundings;
use crate::patches::PatchError;
use crate::scene::{Side, triangle};
use crate::trace::Tracer;

/// How near before a face a surface may end to count as touching it, as a share of the patches' legs.
const NEAR: f64 = 0.25;

/// Lines and ends as near as this to one another are made one, as a share of the patches' legs.
const WELD: f64 = 0.05;

/// The same for the outlines of what covers a face, as a share of its longest side: rounding alone.
const EXACT_WELD: f64 = 1e-9;

/// Lines on one face, at most; and once more as many along which others pass through it.
const MOST_LINES: usize = 512;

/// Edges of outlines on one face, at most; beyond that the centre of a patch decides whether it is covered.
const MOST_OUTLINES: usize = 8192;

/// What all faces together may have, first for the scene and then as many more for each face: neighbours that
/// may cast shadows on them, and lines. No room comes near; but where every face lies before every other or
/// passes through it, work would grow with the square of their number or faster, and no cut could follow.
const NEIGHBOURS: [usize; 2] = [1 << 22, 64];
const LINES: [usize; 2] = [1 << 18, 16];

/// How often lines may cross each other, all faces together, and on one face at least and at most: a line
/// that would cross more is left out.
const MOST_CROSSINGS: usize = 1 << 19;
const MOST_CROSSINGS_ON_FACE: [usize; 2] = [64, 4096];

/// The least angle of parts of surroundings where lines allow it, degrees. Chosen: slivers from a house to
/// the horizon would be as narrow far away as at the house.
const LEAST_ANGLE: f64 = 20.0;

/// Triangles of less than this share of their face are rounding, no parts.
const DUST: f64 = 1e-13;

/// A face in parts.
#[derive(Clone, Debug)]
struct Parted {
    face: usize,
    /// Its longest side, normalised.
    longest: f64,
    /// Whether it is parted however small it is, for another face covers some of it or passes through it.
    is_always: bool,
    parts: Vec<Part>,
}

/// How the faces of a scene fall into parts, for patches of some size.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parts {
    /// The faces that contacts part, in order of faces.
    parted: Vec<Parted>,
    /// The faces whose parts are divided once more.
    surroundings: Option<Arc<Surroundings>>,
}

impl Parts {
    /// Whether a face is cut by its distance from all else.
    pub fn is_around(&self, face: usize, fineness: Fineness) -> bool {
        fineness.grows() && self.surroundings.as_ref().is_some_and(|all| all.has(face))
    }

    /// Whether contacts part no face.
    pub fn is_empty(&self) -> bool {
        self.parted.is_empty()
    }

    /// Every part of a face with these corners, and how long legs its patches may have. A face stays whole
    /// that is no larger than a patch and that no other covers or passes through.
    pub fn visit(
        &self,
        face: usize,
        corners: &[DVec3; 3],
        fineness: Fineness,
        each: &mut impl FnMut(&Part, f64),
    ) {
        let whole = [Part::whole(corners)];
        let place = self.parted.binary_search_by_key(&face, |parted| parted.face);
        let parted = place.ok().map(|place| &self.parted[place]);
        let parts = match parted.filter(|parted| parted.is_always || fineness.parts(parted.longest)) {
            Some(parted) => parted.parts.as_slice(),
            None => &whole,
        };
        let wide = self.surroundings.as_ref().filter(|_| self.is_around(face, fineness));
        for part in parts {
            match wide {
                Some(surroundings) => surroundings.divide(*part, fineness, each),
                None => each(part, fineness.edge),
            }
        }
    }

    /// Into how many cells a face with these corners is cut.
    pub fn cells(&self, face: usize, corners: &[DVec3; 3], fineness: Fineness) -> u64 {
        let mut cells = 0;
        self.visit(face, corners, fineness, &mut |part, legs| cells += cells_for(&part.corners, legs));
        cells
    }
}

/// Finds the parts of a scene's faces, for patches of any size.
///
/// What is near and what is the same depends on the size of patches only by its power of two, so that few
/// different answers are asked for while a size is sought.
pub(crate) struct Parting<'t> {
    tracer: &'t Tracer<'t>,
    contacts: Contacts<'t>,
    exact: ExactLines,
    surroundings: Option<Arc<Surroundings>>,
    known: HashMap<i32, Arc<Parts>>,
}

impl<'t> Parting<'t> {
    /// # Errors
    /// `TooManyOverlaps`.
    pub fn new(tracer: &'t Tracer<'t>) -> Result<Self, PatchError> {
        if let Some(face) = tracer.face_of_too_many_overlaps() {
            let scene = tracer.scene();
            let object = scene.objects()[scene.faces()[face].object as usize].clone();
            return Err(PatchError::TooManyOverlaps { face, object });
        }
        let contacts = Contacts::new(tracer);
        let exact = exact_lines(tracer, &contacts);
        let surroundings = Surroundings::find(tracer).map(Arc::new);
        Ok(Self { tracer, contacts, exact, surroundings, known: HashMap::new() })
    }

    /// The wide faces around everything else, if there are any.
    pub fn surroundings(&self) -> Option<&Arc<Surroundings>> {
        self.surroundings.as_ref()
    }

    /// The parts for patches of legs up to `edge` (normalised).
    pub fn at(&mut self, edge: f64) -> Arc<Parts> {
        let power = edge.log2().floor() as i32;
        let (tracer, contacts, exact) = (self.tracer, &self.contacts, &self.exact);
        let surroundings = self.surroundings.clone();
        let find = || {
            let edge = f64::from(power).exp2();
            let parted = Parted::find(tracer, contacts, exact, surroundings.as_deref(), edge);
            Arc::new(Parts { parted, surroundings })
        };
        self.known.entry(power).or_insert_with(find).clone()
    }
}

impl Parted {
    /// Parts every diffuse face that is longer than `edge`, is covered by another, or that another passes
    /// through.
    fn find(
        tracer: &Tracer,
        contacts: &Contacts,
        exact: &ExactLines,
        surroundings: Option<&Surroundings>,
        edge: f64,
    ) -> Vec<Self> {
        let faces = tracer.scene().faces().len();
        let lines = contact_lines(tracer, contacts, edge);
        let [least, most] = MOST_CROSSINGS_ON_FACE;
        let crossings = (MOST_CROSSINGS / faces.max(1)).clamp(least, most);
        let part = |face: usize| {
            let corners = tracer.corners(face);
            let longest = triangle::longest(corners);
            let exact = exact.get(&face).map_or(&[][..], Vec::as_slice);
            let [touching, near] = &lines[face];
            let is_graded = surroundings.is_some_and(|around| around.has(face));
            if exact.is_empty() && touching.is_empty() && near.is_empty() {
                return None;
            }
            let flat = Flat::new(corners, tracer.normal(face, Side::Front));
            let drawn = |weld: f64| {
                let mut welded = Welded::new(&flat.corners, weld, crossings);
                exact.iter().for_each(|&ends| welded.add(ends));
                let is_always = !welded.drawn().is_empty();
                welded.add_all(touching);
                welded.weld = WELD * edge;
                welded.add_all(near);
                (triangulate(&flat.corners, welded.drawn(), is_graded), is_always)
            };
            // Where rounding leaves no way to draw lines exactly, they are drawn as those of what is near
            // are.
            let (triangles, is_always) = match drawn(EXACT_WELD * longest) {
                (None, _) => drawn(WELD * edge.min(longest)),
                found => found,
            };
            let parts = triangles?.into_iter().map(|on_face| {
                let [a, b, c] = *corners;
                Part { on_face, corners: on_face.map(|w| a + (b - a) * w.x + (c - a) * w.y) }
            });
            Some(Parted { face, longest, is_always, parts: parts.collect() })
        };
        (0..faces).into_par_iter().filter_map(part).collect()
    }
}

/// Per face that is longer than `edge`, the lines of what touches it and of what is near, long ones first.
fn contact_lines(tracer: &Tracer, contacts: &Contacts, edge: f64) -> Vec<[Vec<Line>; 2]> {
    let faces = tracer.scene().faces().len();
    let is_long =
        |face: usize| tracer.scene().is_diffuse(face) && triangle::longest(tracer.corners(face)) > edge;
    let most = budget(NEIGHBOURS, faces);
    let count = |face: usize| if is_long(face) { contacts.count_near(face, NEAR * edge, most) } else { 0 };
    let neighbours: Vec<usize> = (0..faces).into_par_iter().map(count).collect();
    let most_neighbours = most_for_each(&neighbours, NEIGHBOURS);
    let lines_on = |face: usize| {
        if !is_long(face) {
            return Default::default();
        }
        let flat = Flat::new(tracer.corners(face), tracer.normal(face, Side::Front));
        let near = if neighbours[face] > most_neighbours { 0.0 } else { NEAR * edge };
        let lines = contacts.lines_on(face, &flat, near, WELD * edge);
        let (touching, near): (Vec<Line>, Vec<Line>) = lines.into_iter().partition(|line| line.touches);
        [touching, near].map(long_first)
    };
    let mut lines: Vec<[Vec<Line>; 2]> = (0..faces).into_par_iter().map(lines_on).collect();
    let counts: Vec<usize> = lines.iter().map(|[touching, near]| touching.len().max(near.len())).collect();
    let most = most_for_each(&counts, LINES);
    lines.as_flattened_mut().iter_mut().for_each(|lines| lines.truncate(most));
    lines
}

/// Lines that are drawn, long ones before short ones.
fn long_first(mut lines: Vec<Line>) -> Vec<Line> {
    let length = |line: &Line| line.ends[0].distance_squared(line.ends[1]);
    lines.sort_by(|a, b| length(b).total_cmp(&length(a)));
    lines.truncate(MOST_LINES);
    lines
}

/// What so many faces together may have.
fn budget([first, each]: [usize; 2], faces: usize) -> usize {
    first + each * faces
}

/// The most that each face may have of what all together have a budget for.
fn most_for_each(counts: &[usize], shared: [usize; 2]) -> usize {
    let most = budget(shared, counts.len());
    if counts.iter().sum::<usize>() <= most { usize::MAX } else { most / counts.len() }
}

/// Per face the lines that part it however small it is: outlines of what covers it, then those along which
/// others pass through it.
type ExactLines = HashMap<usize, Vec<[DVec2; 2]>>;

fn exact_lines(tracer: &Tracer, contacts: &Contacts) -> ExactLines {
    let faces = tracer.scene().faces().len();
    let lines_on = |face: usize| {
        if !tracer.scene().is_diffuse(face) {
            return Default::default();
        }
        let flat = Flat::new(tracer.corners(face), tracer.normal(face, Side::Front));
        let outlines = tracer.outlines_of_covers(face).into_iter().filter_map(|ends| flat.line(ends));
        let outlines: Vec<_> = outlines.take(MOST_OUTLINES).collect();
        let mut crossings = contacts.crossings_on(face, &flat);
        crossings.truncate(MOST_LINES);
        (outlines, crossings)
    };
    let lines: Vec<(Vec<_>, Vec<_>)> = (0..faces).into_par_iter().map(lines_on).collect();
    let counts: Vec<usize> = lines.iter().map(|(_, crossings)| crossings.len()).collect();
    let most = most_for_each(&counts, LINES);
    let all = lines.into_iter().map(|(mut lines, crossings)| {
        lines.extend(crossings.into_iter().take(most));
        lines
    });
    all.enumerate().filter(|(_, lines)| !lines.is_empty()).collect()
}

/// Lines on a face of which no two run along one another.
struct Welded {
    weld: f64,
    /// The three sides of the face, then the lines on it.
    lines: Vec<[DVec2; 2]>,
    /// How often they may still cross each other.
    crossings: usize,
}

impl Welded {
    fn new(corners: &[DVec2; 3], weld: f64, crossings: usize) -> Self {
        Self { weld, lines: [0, 1, 2].map(|k| [corners[k], corners[(k + 1) % 3]]).to_vec(), crossings }
    }

    /// Adds what of these lines does not run along others.
    fn add_all(&mut self, lines: &[Line]) {
        lines.iter().for_each(|line| self.add(line.ends));
    }

    /// The lines within the face.
    fn drawn(&self) -> &[[DVec2; 2]] {
        &self.lines[3..]
    }

    /// Adds what of a line does not run along the lines that are there.
    fn add(&mut self, [p, q]: [DVec2; 2]) {
        let mut rest = vec![[0.0, 1.0]];
        for &known in &self.lines {
            if let Some([from, to]) = along([p, q], known, self.weld) {
                let beside = |[start, end]: [f64; 2]| [[start, end.min(from)], [start.max(to), end]];
                rest = rest.into_iter().flat_map(beside).filter(|[start, end]| start < end).collect();
            }
        }
        for ends in rest.into_iter().map(|stretch| stretch.map(|at| p.lerp(q, at))) {
            // A stub that others leave is no longer than they are apart.
            if ends[0].distance(ends[1]) > 2.0 * self.weld {
                let ends = ends.map(|end| self.moved(end));
                let crossed = self.drawn().iter().filter(|&&known| crossing(ends, known).is_some()).count();
                if ends[0].distance(ends[1]) > self.weld && crossed <= self.crossings {
                    self.crossings -= crossed;
                    self.lines.push(ends);
                }
            }
        }
    }

    /// Moves an end to the nearest end, or else to the nearest line, if that is near enough; a line that is
    /// met is broken there.
    fn moved(&mut self, end: DVec2) -> DVec2 {
        let nearest = |places: &mut dyn Iterator<Item = (usize, DVec2)>| {
            let near = places.filter(|(_, place)| place.distance(end) <= self.weld);
            near.min_by(|a, b| a.1.distance(end).total_cmp(&b.1.distance(end)))
        };
        let mut ends = self.lines.iter().enumerate().flat_map(|(k, ends)| ends.map(|end| (k, end)));
        if let Some((_, place)) = nearest(&mut ends) {
            return place;
        }
        let foot = |&[a, b]: &[DVec2; 2]| {
            a.lerp(b, ((end - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0))
        };
        let mut feet = self.lines.iter().map(foot).enumerate();
        let Some((line, place)) = nearest(&mut feet) else { return end };
        let [a, b] = self.lines[line];
        if line >= 3 {
            self.lines[line] = [a, place];
            self.lines.push([place, b]);
        }
        place
    }
}

/// Where `line` runs along `known`, nearer than `weld` all the way: from and to which share of it.
fn along([p, q]: [DVec2; 2], known: [DVec2; 2], weld: f64) -> Option<[f64; 2]> {
    let length = p.distance(q);
    let place = |end: DVec2| (end - p).dot(q - p) / (length * length);
    let [start, end] = known.map(place);
    let [from, to] = [start.min(end).max(0.0), start.max(end).min(1.0)];
    let direction = (known[1] - known[0]).normalize();
    let apart = |at: f64| direction.perp_dot(p.lerp(q, at) - known[0]).abs();
    ((to - from) * length > weld && apart(from) <= weld && apart(to) <= weld).then_some([from, to])
}

/// Where two lines cross, as a share of either.
fn crossing([p, q]: [DVec2; 2], [a, b]: [DVec2; 2]) -> Option<[f64; 2]> {
    let across = (q - p).perp_dot(b - a);
    let shares = [(a - p).perp_dot(b - a), (a - p).perp_dot(q - p)].map(|x| x / across);
    shares.iter().all(|&at| at > 0.0 && at < 1.0).then_some(shares)
}

/// The pieces into which lines part each other; where two cross, all pieces end at the same point.
fn split_at_crossings(lines: &[[DVec2; 2]]) -> Vec<[DVec2; 2]> {
    let mut stops: Vec<Vec<(f64, DVec2)>> = lines.iter().map(|&[p, q]| vec![(0.0, p), (1.0, q)]).collect();
    for i in 0..lines.len() {
        for j in 0..i {
            if let Some([here, there]) = crossing(lines[i], lines[j]) {
                let [p, q] = lines[i];
                let place = p.lerp(q, here);
                stops[i].push((here, place));
                stops[j].push((there, place));
            }
        }
    }
    let mut pieces = Vec::with_capacity(lines.len());
    for stops in &mut stops {
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        pieces.extend(stops.windows(2).map(|pair| [pair[0].1, pair[1].1]));
    }
    pieces
}

/// The triangles of a face with these corners and these lines on it, as points of the face, none of them very
/// acute if they are to be graded; none if there are no lines, or no way.
fn triangulate(corners: &[DVec2; 3], lines: &[[DVec2; 2]], is_graded: bool) -> Option<Vec<[DVec2; 3]>> {
    if lines.is_empty() {
        return None;
    }
    let mut mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let to_point = |p: DVec2| Point2::new(p.x, p.y);
    for &corner in corners {
        mesh.insert(to_point(corner)).ok()?;
    }
    let insert = |p: DVec2| mesh.insert(to_point(p)).ok();
    let pieces = split_at_crossings(lines);
    let ends: Vec<_> = pieces.as_flattened().iter().copied().map(insert).collect::<Option<_>>()?;
    for pair in ends.chunks_exact(2).filter(|pair| pair[0] != pair[1]) {
        // What rounding makes cross another line after all is left out.
        mesh.try_add_constraint(pair[0], pair[1]);
    }
    if is_graded {
        mesh.refine(RefinementParameters::new().with_angle_limit(AngleLimit::from_deg(LEAST_ANGLE)));
    }
    let [a, b, c] = *corners;
    let inverse = DMat2::from_cols(b - a, c - a).inverse();
    let on_face = |p: Point2<f64>| {
        let place = DVec2::new(p.x, p.y);
        let exact =
            [(a, DVec2::ZERO), (b, DVec2::X), (c, DVec2::Y)].into_iter().find(|&(corner, _)| corner == place);
        exact.map_or_else(|| inverse * (place - a), |(_, weights)| weights)
    };
    let area = |[a, b, c]: &[DVec2; 3]| (b - a).perp_dot(c - a);
    let triangles = mesh.inner_faces().map(|face| face.positions().map(on_face));
    let triangles: Vec<[DVec2; 3]> = triangles.filter(|triangle| area(triangle) > DUST).collect();
    let whole: f64 = triangles.iter().map(area).sum();
    ((whole - 1.0).abs() < 1e-9).then_some(triangles)
}

#[cfg(test)]
mod tests {
    use super::super::subdivide::Cuts;
    use super::*;
    use crate::trace::sampling::{Stream, uniform_triangle};

    /// A face of each kind: well-shaped, needle, cap.
    fn faces() -> [[DVec2; 3]; 3] {
        [[(1.0, 0.0), (0.3, 0.8)], [(1.0, 0.0), (0.99, 0.01)], [(1.0, 0.0), (0.4, 0.02)]]
            .map(|[b, c]| [DVec2::ZERO, b.into(), c.into()])
    }

    fn on([a, b, c]: [DVec2; 3], [u, v]: [f64; 2]) -> DVec2 {
        a + (b - a) * u + (c - a) * v
    }

    /// Random points of a triangle.
    fn points(triangle: [DVec2; 3], seed: u64, count: u32) -> impl Iterator<Item = DVec2> {
        (0..count).map(move |k| {
            let [x, y, ..] = Stream::Callers.sequence(seed, 7, 0).point(k);
            on(triangle, uniform_triangle([x, y]))
        })
    }

    /// Lines between random points, some on the border, some twice, some almost twice, some from one point.
    fn scribbles(face: [DVec2; 3], seed: u64, count: u32) -> Vec<Line> {
        let all: Vec<DVec2> = points(face, seed, 2 * count).collect();
        let line = |(k, pair): (usize, &[DVec2])| {
            let (p, q) = (pair[0], pair[1]);
            let ends = match k % 5 {
                0 => [face[0].lerp(face[1], p.x), q],
                1 => [all[0], q],
                2 => [all[2 * k - 4], all[2 * k - 3]].map(|end| end + DVec2::new(1e-9, 3e-4)),
                3 => [all[2 * k - 6].lerp(all[2 * k - 5], 0.3), q],
                _ => [p, q],
            };
            Line { ends, touches: k % 2 == 0 }
        };
        all.chunks_exact(2).enumerate().map(line).collect()
    }

    #[test]
    fn parts_tile_their_face_however_many_lines_cross_it() {
        let unit = [DVec2::ZERO, DVec2::X, DVec2::Y];
        for (face, seed) in faces().into_iter().flat_map(|face| (0..40).map(move |seed| (face, seed))) {
            let lines = scribbles(face, seed, [1, 3, 10, 50][seed as usize % 4]);
            // As lines of contacts are welded, and as those along which others pass through a face.
            let mut welded = Welded::new(&face, [0.003, 1e-9][seed as usize / 4 % 2], usize::MAX);
            welded.add_all(&long_first(lines));
            let Some(triangles) = triangulate(&face, welded.drawn(), false) else {
                // Exact lines on needles may leave no way; they are then welded.
                assert!(welded.drawn().is_empty() || welded.weld < 1e-6, "{face:?} {seed}");
                continue;
            };
            let total: f64 = triangles.iter().map(|&[a, b, c]| (b - a).perp_dot(c - a)).sum();
            assert!((total - 1.0).abs() < 1e-12, "{face:?} {seed}: {total}");
            let space = |weights: DVec2| on(face, weights.into()).extend(0.0);
            let parts: Vec<Part> =
                triangles.iter().map(|&t| Part { on_face: t, corners: t.map(space) }).collect();
            for edge in [0.3, 0.03] {
                let cuts = Cuts::new(1, |_, each| parts.iter().for_each(|part| each(part, edge)));
                let cells: u64 = parts.iter().map(|part| cells_for(&part.corners, edge)).sum();
                assert_eq!(u64::from(cuts.cells(0)), cells);
                let corners = |cell: u32| cuts.corners(0, cell).map(DVec2::from);
                let area = |[a, b, c]: [DVec2; 3]| (b - a).perp_dot(c - a);
                let total: f64 = (0..cuts.cells(0)).map(|cell| area(corners(cell))).sum();
                assert!((total - 1.0).abs() < 1e-12, "{face:?} {seed}: {total}");
                // Every point of the face lies in the cell that is found for it.
                for point in points(unit, seed + 100, 300) {
                    let [a, b, c] = corners(cuts.cell_at(0, point.into()));
                    let outside = |a: DVec2, b: DVec2| (a - b).perp_dot(point - b) / (a - b).length();
                    let farthest = outside(a, b).max(outside(b, c)).max(outside(c, a));
                    assert!(farthest < 1e-9, "{face:?} {seed}: {farthest}");
                }
            }
        }
    }

    #[test]
    fn a_tangle_of_lines_parts_a_face_no_further_than_it_may() {
        let face = faces()[0];
        let lines: Vec<DVec2> = points(face, 1, 800).collect();
        let mut welded = Welded::new(&face, 1e-9, 500);
        lines.chunks_exact(2).for_each(|ends| welded.add([ends[0], ends[1]]));
        let pieces = split_at_crossings(welded.drawn()).len();
        assert!((400..=400 + 2 * 500).contains(&pieces), "{pieces}");
    }

    #[test]
    fn lines_are_edges_of_parts() {
        let face = faces()[0];
        let ends = [DVec2::new(0.2, 0.1), DVec2::new(0.6, 0.2)];
        let triangles = triangulate(&face, &[ends], false).unwrap();
        let has = |triangle: &[DVec2; 3]| {
            let corners = triangle.map(|weights| on(face, weights.into()));
            ends.iter().all(|end| corners.iter().any(|corner| corner.distance(*end) < 1e-12))
        };
        assert_eq!(triangles.iter().filter(|triangle| has(triangle)).count(), 2, "one on each side");
    }

    #[test]
    fn lines_that_run_along_one_another_are_one() {
        let face = faces()[0];
        let line = |p: (f64, f64), q: (f64, f64)| Line { ends: [p.into(), q.into()], touches: true };
        let long = line((0.2, 0.1), (0.6, 0.2));
        for (others, count) in [
            (vec![line((0.6, 0.201), (0.2, 0.101))], 1),
            (vec![line((0.3, 0.125), (0.4, 0.15))], 1),
            (vec![line((0.1, 0.001), (0.8, 0.0))], 1),
            (vec![line((0.4, 0.15), (0.8, 0.25))], 2),
            (vec![line((0.3, 0.2), (0.5, 0.05))], 2),
            (vec![line((0.4, 0.3), (0.4, 0.151))], 3),
        ] {
            let mut welded = Welded::new(&face, 0.005, usize::MAX);
            welded.add_all(&long_first([vec![long], others.clone()].concat()));
            assert_eq!(welded.drawn().len(), count, "{others:?}: {:?}", welded.drawn());
        }
    }
}
