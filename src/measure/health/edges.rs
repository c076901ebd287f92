//! Edges: which faces meet where. An edge is a pair of vertices; sound surfaces use each twice, once in
//! either direction.

use std::collections::HashMap;

use glam::DVec3;

use super::{Finding, Grade, shape};
use crate::scene::Scene;
use crate::trace::Tracer;

/// A face's use of an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Use {
    pub face: usize,
    /// The face's vertex that is not on the edge.
    pub apex: u32,
    /// Whether the face runs it from the lower-numbered vertex to the other.
    pub upwards: bool,
}

/// The edges of all kept faces.
pub(super) struct Edges<'s> {
    pub scene: &'s Scene,
    /// Per vertex, normalised frame.
    pub points: Vec<DVec3>,
    /// Per edge: its two vertices, the lower number first, and the faces that use it.
    all: Vec<([u32; 2], Vec<Use>)>,
}

impl<'s> Edges<'s> {
    /// Makes one vertex of all corners at the same position and lists the edges between them.
    pub fn new(tracer: &Tracer<'s>) -> Self {
        let scene = tracer.scene();
        let mut vertices = HashMap::new();
        let mut points = Vec::new();
        let mut uses: Vec<([u32; 2], Use)> = Vec::new();
        for face in shape::kept(scene) {
            let (world, here) = (scene.corners(face), tracer.corners(face));
            let corners = [0, 1, 2].map(|k| {
                // Adding zero makes -0.0 and 0.0 the same position.
                let position = (world[k] + DVec3::ZERO).to_array().map(f64::to_bits);
                *vertices.entry(position).or_insert_with(|| {
                    points.push(here[k]);
                    points.len() as u32 - 1
                })
            });
            for k in 0..3 {
                let [from, to, apex] = [0, 1, 2].map(|turn| corners[(k + turn) % 3]);
                uses.push(([from.min(to), from.max(to)], Use { face, apex, upwards: from < to }));
            }
        }
        uses.sort_by_key(|(ends, _)| *ends);
        let runs = uses.chunk_by(|a, b| a.0 == b.0);
        let all = runs.map(|run| (run[0].0, run.iter().map(|edge| edge.1).collect())).collect();
        Self { scene, points, all }
    }

    /// The edges that one face alone uses.
    pub fn alone(&self) -> impl Iterator<Item = ([u32; 2], Use)> {
        self.all.iter().filter(|(_, uses)| uses.len() == 1).map(|(ends, uses)| (*ends, uses[0]))
    }

    /// The uses of edges that two faces share.
    pub fn shared(&self) -> impl Iterator<Item = [Use; 2]> {
        self.all.iter().filter_map(|(_, uses)| uses.as_slice().try_into().ok())
    }

    /// Pairs of faces that meet at an edge, two of them or more.
    pub fn pairs(&self) -> impl Iterator<Item = &[Use]> {
        self.all.iter().flat_map(|(_, uses)| uses.windows(2))
    }

    /// Faces at edges that not exactly two faces use.
    pub fn unpaired(&self) -> impl Iterator<Item = usize> {
        self.all
            .iter()
            .filter(|(_, uses)| uses.len() != 2)
            .flat_map(|(_, uses)| uses.iter().map(|edge| edge.face))
    }

    /// How many edges one face alone uses; they bound sheets and holes.
    pub fn open(&self) -> Finding {
        let count = self.alone().count();
        let finding = Finding::good("open edges", count as f64, Some("edges"));
        if count == 0 {
            return finding;
        }
        let rims = self.rims();
        let remedy = format!(
            "fine where a surface is meant to end, as sheets and windows do, and if no leak is found below; else close the {}",
            if rims.len() == 1 {
                "hole beside this face".into()
            } else {
                format!("holes: there are {} rims", rims.len())
            }
        );
        finding.but(Grade::Note, rims, remedy)
    }

    /// One face from each set of open edges that hang together, that with the most edges first.
    fn rims(&self) -> Vec<usize> {
        let mut groups = Groups::new(self.points.len());
        self.alone().for_each(|([a, b], _)| groups.join(a as usize, b as usize));
        let mut rims: HashMap<usize, (usize, usize)> = HashMap::new();
        for ([a, _], only) in self.alone() {
            rims.entry(groups.of(a as usize)).or_insert((0, only.face)).0 += 1;
        }
        let mut rims: Vec<(usize, usize)> = rims.into_values().collect();
        rims.sort_unstable_by_key(|&(edges, face)| (std::cmp::Reverse(edges), face));
        rims.into_iter().map(|(_, face)| face).collect()
    }

    /// How many edges more than two faces share.
    pub fn non_manifold(&self) -> Finding {
        let crowded: Vec<usize> =
            self.all.iter().filter(|(_, uses)| uses.len() > 2).map(|(_, uses)| uses[0].face).collect();
        let finding = Finding::good("non-manifold edges", crowded.len() as f64, Some("edges"));
        if crowded.is_empty() {
            return finding;
        }
        let mut faces = crowded;
        faces.dedup();
        finding.but(
            Grade::Note,
            faces,
            "more than two faces meet there: fine where walls branch or solids touch; else look for faces inside the surface",
        )
    }

    /// How many faces have their front where their neighbours have their back.
    pub fn winding(&self) -> Finding {
        let against = self.against_neighbours();
        let breaks = self.shared().filter(|[one, other]| one.upwards == other.upwards).count();
        let finding = Finding::good("winding", against.len() as f64, Some("faces against their neighbours"));
        if breaks == 0 {
            return finding;
        }
        let remedy = "no harm to light that is reflected, for both sides reflect alike, but only fronts emit: where it matters, \
                      make the normals consistent";
        Finding { count: Some(breaks), ..finding }.but(Grade::Note, against, remedy)
    }

    /// Per object, whether two faces of it that share an edge with no other run it the same way: where one
    /// has its front the other has its back.
    pub fn broken_objects(&self) -> Vec<bool> {
        let object = |one: &Use| self.scene.faces()[one.face].object as usize;
        let mut broken = vec![false; self.scene.objects().len()];
        for [one, other] in self.shared() {
            broken[object(&one)] |= object(&one) == object(&other) && one.upwards == other.upwards;
        }
        broken
    }

    /// The faces to be flipped, the fewer in each connected surface, for the fronts to agree across shared
    /// edges.
    fn against_neighbours(&self) -> Vec<usize> {
        let mut against = Vec::new();
        for (surface, _) in self.oriented() {
            let (flipped, rest): (Vec<_>, Vec<_>) = surface.into_iter().partition(|&(_, turned)| turned);
            let fewer = if flipped.len() <= rest.len() { flipped } else { rest };
            against.extend(fewer.into_iter().map(|(face, _)| face));
        }
        against.sort_unstable();
        against
    }

    /// The surfaces connected by edges that two faces share: their faces, which of them have to be turned for
    /// all fronts to agree with the first's, and whether all do then.
    pub fn oriented(&self) -> Vec<(Vec<(usize, bool)>, bool)> {
        let mut next_to: HashMap<usize, Vec<(usize, bool)>> = HashMap::new();
        for [one, other] in self.shared() {
            let turned = one.upwards == other.upwards;
            next_to.entry(one.face).or_default().push((other.face, turned));
            next_to.entry(other.face).or_default().push((one.face, turned));
        }
        let mut orientation: Vec<Option<bool>> = vec![None; self.scene.faces().len()];
        let mut surfaces = Vec::new();
        for start in shape::kept(self.scene) {
            if orientation[start].is_some() {
                continue;
            }
            orientation[start] = Some(false);
            let mut surface = vec![(start, false)];
            let (mut at, mut agree) = (0, true);
            while at < surface.len() {
                let (face, own) = surface[at];
                for &(neighbour, turned) in next_to.get(&face).into_iter().flatten() {
                    let wanted = own ^ turned;
                    match orientation[neighbour] {
                        None => {
                            orientation[neighbour] = Some(wanted);
                            surface.push((neighbour, wanted));
                        }
                        Some(known) => agree &= known == wanted,
                    }
                }
                at += 1;
            }
            surfaces.push((surface, agree));
        }
        surfaces
    }
}

/// A partition of 0..n into sets that are joined one pair at a time (Tarjan 1975).
pub(super) struct Groups(Vec<usize>);

impl Groups {
    pub fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    /// The set of an element, as the number of one of its elements.
    pub fn of(&mut self, mut element: usize) -> usize {
        while self.0[element] != element {
            self.0[element] = self.0[self.0[element]];
            element = self.0[element];
        }
        element
    }

    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b);
    }
}
