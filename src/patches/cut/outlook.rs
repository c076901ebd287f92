//! Outlook: how many patches a cut will give, and where, told before the scene is cut.
//!
//! A surface without a rim parts the inside from the outside, and light is taken to reach but one of the two.
//! Of any other surface it may reach both sides, and a few light paths tell how many of them it does. A side
//! that looks away from everything counts only where lights come from outside.

use std::collections::HashMap;

use glam::DVec3;

use super::fineness::Fineness;
use super::grid::cells_for;
use super::lit_share::lit_share;
use super::parts::Parting;
use super::size::fineness_for;
use crate::patches::{PatchError, PatchSize};
use crate::scene::{Feature, Side};
use crate::trace::Tracer;

/// Where less than this part of sides is lit, cuts find more of it as they get finer; a pure number. Chosen,
/// not fitted.
const PARTLY: f64 = 0.95;

/// How a scene will probably be cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlook {
    /// Per face and side, front first: how many patches.
    pub patches_of: Vec<[f64; 2]>,
    /// The triangles into which contacts part the faces that have patches, in order of faces: each is cut
    /// evenly.
    pub stretches: Vec<Stretch>,
    /// Per face and side: 1 for mirrors and glass, which have no patches.
    pub carriers: Vec<[f64; 2]>,
    /// How many of the patches light reaches only through sheets.
    pub through_sheets: f64,
    /// Cells of all faces, both sides counted: where light is looked for.
    pub slots: f64,
    /// How many times slots of that size look for light: finer ones find more of it where it reaches but a
    /// part of them, and then a cut for a number of patches is made once more.
    pub cuts: f64,
}

/// A part of a face that is cut into patches of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// The face.
    pub face: usize,
    /// Its corners, normalised frame.
    pub corners: [DVec3; 3],
    /// How many patches either side has, if light reaches it.
    pub cells: f64,
}

impl Outlook {
    /// Cuts by arithmetic.
    ///
    /// # Errors
    /// `TooManyOverlaps`.
    pub fn new(tracer: &Tracer, size: PatchSize) -> Result<Self, PatchError> {
        let (sides, through) = likely_sides(tracer);
        let mut parting = Parting::new(tracer)?;
        let fineness = match size {
            PatchSize::Edge(metres) => Fineness::even(metres / tracer.frame().scale()),
            PatchSize::Count(count) => fineness_for(tracer, count.max(1), &mut parting, |face| sides[face]).0,
        };
        let parts = parting.at(fineness.edge);
        let mut stretches = Vec::new();
        for face in (0..sides.len()).filter(|&face| tracer.scene().is_diffuse(face)) {
            parts.visit(face, tracer.corners(face), fineness, &mut |part, legs| {
                let cells = cells_for(&part.corners, legs) as f64;
                stretches.push(Stretch { face, corners: part.corners, cells });
            });
        }
        let mut cells = vec![0.0; sides.len()];
        stretches.iter().for_each(|stretch| cells[stretch.face] += stretch.cells);
        let patches_of = sides.iter().zip(&cells).map(|(sides, cells)| sides.map(|side| side * cells));
        let is_partly_lit = sides.iter().flatten().any(|&lit| lit > 0.0 && lit < PARTLY);
        let cuts = if is_partly_lit && matches!(size, PatchSize::Count(_)) { 2.0 } else { 1.0 };
        let carriers = (0..sides.len()).map(|face| [f64::from(u8::from(tracer.is_carrier(face as u32))); 2]);
        Ok(Self {
            patches_of: patches_of.collect(),
            stretches,
            carriers: carriers.collect(),
            through_sheets: through.into_iter().map(|face| cells[face]).sum(),
            slots: 2.0 * cells.iter().sum::<f64>(),
            cuts,
        })
    }

    /// Patches in all.
    pub fn patches(&self) -> f64 {
        self.patches_of.iter().flatten().sum()
    }
}

/// Which sides of faces light probably reaches, from 0 to 1, front first; all of a scene's where that would
/// be none. And the faces of which it reaches one side through the other.
fn likely_sides(tracer: &Tracer) -> (Vec<[f64; 2]>, Vec<usize>) {
    let scene = tracer.scene();
    let from_outside = scene.sky().is_some() || scene.lights().next().is_some();
    let kept: Vec<usize> = (0..scene.faces().len()).filter(|&f| scene.is_diffuse(f)).collect();
    let (low, high) = kept
        .iter()
        .flat_map(|&f| tracer.corners(f))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let looks_at_something = |face: usize, side: Side| {
        let (normal, p) = (tracer.normal(face, side), tracer.corners(face)[0]);
        // The corner of the box around everything that lies farthest in front.
        let farthest = DVec3::select(normal.cmpgt(DVec3::ZERO), high, low);
        normal.dot(farthest - p) > 1e-9
    };
    let mut sides = vec![[0.0; 2]; scene.faces().len()];
    let (mut through, mut doubtful) = (Vec::new(), Vec::new());
    for (inside, face) in sides_of_surfaces(tracer, &kept).into_iter().zip(&kept) {
        for (k, side) in Side::BOTH.into_iter().enumerate() {
            let lit = inside.is_none_or(|inside| inside == side) && looks_at_something(*face, side);
            let lit = lit || (from_outside && inside.is_none());
            let lit = lit && (side == Side::Front || !scene.is_without(Feature::BackSides));
            sides[*face][k] = f64::from(u8::from(lit));
            if lit && inside.is_none() {
                doubtful.push((*face, side));
            }
        }
        // What comes through a sheet lights its other side.
        if scene.material_of(*face).transmittance().is_some() && sides[*face][0] != sides[*face][1] {
            sides[*face] = [1.0; 2];
            through.push(*face);
        }
    }
    let share = lit_share(tracer, &doubtful);
    doubtful.iter().for_each(|&(face, side)| {
        let k = usize::from(side == Side::Back);
        sides[face][k] *= share[k];
    });
    if sides.iter().flatten().all(|&side| side == 0.0) {
        kept.iter().for_each(|&face| sides[face] = [1.0; 2]);
    }
    (sides, through)
}

/// For each of these faces the side that light reaches, if the surface it belongs to has no rim: the inside
/// of the one that holds all others, the outside of these.
fn sides_of_surfaces(tracer: &Tracer, faces: &[usize]) -> Vec<Option<Side>> {
    // Join faces that share an edge, and count the faces at every edge.
    let mut group: Vec<usize> = (0..faces.len()).collect();
    let mut edges: HashMap<[[u64; 3]; 2], (usize, usize)> = HashMap::with_capacity(2 * faces.len());
    for (k, &face) in faces.iter().enumerate() {
        let corners = tracer.corners(face).map(|p| (p + DVec3::ZERO).to_array().map(f64::to_bits));
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let mut ends = [corners[a], corners[b]];
            ends.sort_unstable();
            let (first, count) = edges.entry(ends).or_insert((k, 0));
            *count += 1;
            let joined = [root(&mut group, *first), root(&mut group, k)];
            group[joined[0]] = joined[1];
        }
    }
    let group: Vec<usize> = (0..faces.len()).map(|k| root(&mut group, k)).collect();
    let mut has_rim = vec![false; faces.len()];
    edges.values().for_each(|&(first, count)| has_rim[group[first]] |= count != 2);
    // A positive volume has its fronts outside.
    let (mut volume, mut reach) = (vec![0.0; faces.len()], vec![0.0f64; faces.len()]);
    for (k, &face) in faces.iter().enumerate() {
        let [a, b, c] = *tracer.corners(face);
        volume[group[k]] += a.dot(b.cross(c));
        reach[group[k]] = [a, b, c].iter().fold(reach[group[k]], |most, p| most.max(p.abs().max_element()));
    }
    let farthest = reach.iter().copied().fold(0.0, f64::max);
    let side_of = |k: usize| {
        let g = group[k];
        let holds_all = reach[g] == farthest;
        let front_outside = volume[g] > 0.0;
        (!has_rim[g]).then_some(if holds_all != front_outside { Side::Front } else { Side::Back })
    };
    (0..faces.len()).map(side_of).collect()
}

/// The face that stands for all that `k` is joined to.
fn root(group: &mut [usize], mut k: usize) -> usize {
    while group[k] != k {
        group[k] = group[group[k]];
        k = group[k];
    }
    k
}
