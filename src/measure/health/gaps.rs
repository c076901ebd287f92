//! Gaps: open edges that were to meet. A *crack* runs between two open edges that nearly coincide; a
//! *T-junction* is a vertex in the middle of another face's open edge.

use glam::DVec3;
use rayon::prelude::*;

use super::constants::{CRACK, INTO_FACE, ON_EDGE, ON_EDGE_OF_LENGTH, WITHIN_EDGE};
use super::edges::{Edges, Use};
use super::{Finding, Grade};
use crate::trace::Tracer;

/// How wide the widest crack is, metres.
pub(super) fn cracks(edges: &Edges, tracer: &Tracer) -> Finding {
    let open = OpenEdges::new(edges);
    let mut cracks: Vec<(f64, usize)> = (0..open.edges.len())
        .into_par_iter()
        .filter_map(|k| {
            open.widest_crack(k).map(|width| (width * tracer.frame().scale(), open.edges[k].1.face))
        })
        .collect();
    cracks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let finding = Finding::good("cracks", cracks.first().map_or(0.0, |crack| crack.0), Some("m wide"));
    if cracks.is_empty() {
        return finding;
    }
    let remedy = "edges nearly meet along these faces: if they are meant to meet, weld the vertices (merge by distance), for \
                  light may pass between them";
    Finding { count: Some(cracks.len()), ..finding }.but(Grade::Note, faces_of(&cracks), remedy)
}

/// How many vertices lie within another face's open edge.
pub(super) fn t_junctions(edges: &Edges) -> Finding {
    let open = OpenEdges::new(edges);
    let found: Vec<(u32, usize)> = (0..open.edges.len())
        .into_par_iter()
        .flat_map_iter(|k| open.vertices_within(k).into_iter().map(move |v| (v, k)))
        .collect();
    let mut vertices: Vec<u32> = found.iter().map(|found| found.0).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let finding = Finding::good("T-junctions", vertices.len() as f64, Some("vertices"));
    if found.is_empty() {
        return finding;
    }
    let mut faces: Vec<usize> = found.iter().map(|&(_, k)| open.edges[k].1.face).collect();
    faces.dedup();
    finding.but(
        Grade::Note,
        faces,
        "these faces have corners of others along their edges: safe, but shading breaks there; split the long edges at the \
         corners if it shows",
    )
}

/// Faces in their order, each once.
fn faces_of(cracks: &[(f64, usize)]) -> Vec<usize> {
    let mut faces = Vec::new();
    for &(_, face) in cracks {
        if faces.len() < Finding::MOST_FACES && !faces.contains(&face) {
            faces.push(face);
        }
    }
    faces
}

/// The open edges, found by place.
struct OpenEdges<'e> {
    points: &'e [DVec3],
    edges: Vec<([u32; 2], Use)>,
    /// Per axis, the vertices at their ends, ascending along it.
    along: [Vec<u32>; 3],
    /// (vertex, edge), ascending.
    at_vertex: Vec<(u32, usize)>,
}

impl<'e> OpenEdges<'e> {
    fn new(edges: &'e Edges) -> Self {
        let points = edges.points.as_slice();
        let edges: Vec<_> = edges.alone().collect();
        let mut at_vertex: Vec<(u32, usize)> =
            edges.iter().enumerate().flat_map(|(k, (ends, _))| ends.map(|v| (v, k))).collect();
        at_vertex.sort_unstable();
        let mut vertices: Vec<u32> = at_vertex.iter().map(|x| x.0).collect();
        vertices.dedup();
        let along = [0, 1, 2].map(|axis| {
            let mut sorted = vertices.clone();
            sorted.sort_by(|&a, &b| points[a as usize][axis].total_cmp(&points[b as usize][axis]));
            sorted
        });
        Self { points, edges, along, at_vertex }
    }

    fn point(&self, vertex: u32) -> DVec3 {
        self.points[vertex as usize]
    }

    /// The vertices in a box.
    fn inside(&self, low: DVec3, high: DVec3) -> impl Iterator<Item = u32> {
        let slab = |axis: usize| {
            let sorted = &self.along[axis];
            let begin = sorted.partition_point(|&v| self.point(v)[axis] < low[axis]);
            let end = sorted.partition_point(|&v| self.point(v)[axis] <= high[axis]);
            &sorted[begin..end.max(begin)]
        };
        let [x, y, z] = [slab(0), slab(1), slab(2)];
        let least = [x, y, z].into_iter().min_by_key(|slab| slab.len()).unwrap_or(x);
        let is_inside = move |v: u32| self.point(v).cmpge(low).all() && self.point(v).cmple(high).all();
        least.iter().copied().filter(move |&v| is_inside(v))
    }

    /// The open edges at a vertex.
    fn at(&self, vertex: u32) -> impl Iterator<Item = usize> {
        let begin = self.at_vertex.partition_point(|x| x.0 < vertex);
        self.at_vertex[begin..].iter().take_while(move |x| x.0 == vertex).map(|x| x.1)
    }

    /// The vertices that lie strictly between the ends of an edge.
    fn vertices_within(&self, edge: usize) -> Vec<u32> {
        let (ends, _) = self.edges[edge];
        let [a, b] = ends.map(|v| self.point(v));
        let along = b - a;
        let off = ON_EDGE.min(ON_EDGE_OF_LENGTH * along.length());
        let (low, high) = (a.min(b) - off, a.max(b) + off);
        let lies_within = |&v: &u32| {
            let p = self.point(v) - a;
            let t = p.dot(along) / along.length_squared();
            let from_ends = t.min(1.0 - t) * along.length();
            !ends.contains(&v) && from_ends > WITHIN_EDGE * off && p.distance(along * t) <= off
        };
        self.inside(low, high).filter(lies_within).collect()
    }

    /// How wide the crack along an edge is, if one runs there.
    fn widest_crack(&self, edge: usize) -> Option<f64> {
        let ([a, b], _) = self.edges[edge];
        let reach = CRACK * self.point(a).distance(self.point(b));
        let near = |v: u32| self.inside(self.point(v) - reach, self.point(v) + reach);
        let others = near(a).flat_map(|c| self.at(c).map(move |other| (c, other)));
        let widths = others.filter_map(|(c, other)| {
            let ends = self.edges[other].0;
            let d = if ends[0] == c { ends[1] } else { ends[0] };
            let gaps = [self.point(c) - self.point(a), self.point(d) - self.point(b)];
            let widest = if gaps[0].length() >= gaps[1].length() { gaps[0] } else { gaps[1] };
            let runs_along = other != edge && widest.length() <= reach;
            (runs_along && self.parts(edge, widest) && self.parts(other, -widest)).then(|| widest.length())
        });
        widths.max_by(f64::total_cmp)
    }

    /// Whether a gap lies beyond the edge and not on the face that it bounds, as between the two long edges
    /// of a ribbon.
    fn parts(&self, edge: usize, gap: DVec3) -> bool {
        let ([a, b], only) = self.edges[edge];
        let along = (self.point(b) - self.point(a)).normalize_or_zero();
        let across = (self.point(only.apex) - self.point(a)).reject_from_normalized(along);
        gap.dot(across) <= INTO_FACE * gap.length() * across.length()
    }
}
