//! Size: how long the legs of patches may be for about so many patches.
//!
//! Surroundings are not counted at first: everything else is cut as if they were not there, and then they are
//! cut as finely as a share of so many patches allows.

use std::sync::Arc;

use super::fineness::Fineness;
use super::parts::{Parting, Parts};
use super::surroundings::Surroundings;
use crate::scene::triangle;
use crate::trace::Tracer;

/// The most slots, reached or not, for each patch that is wanted.
const DARK_PER_PATCH: f64 = 16.0;

/// Patches of the surroundings for each of the rest; a ratio. Chosen: a scene takes little longer for them,
/// and those next to a room are hardly larger than its own.
const AROUND: f64 = 1.0 / 6.0;

/// How many times as long the legs of the surroundings are as elsewhere, next to all else, at least and at
/// most; ratios. Chosen: beyond that there is one patch to a part.
const COARSER: [f64; 2] = [1.0, 64.0];

/// Where the faces alone make more patches than this part of those wanted, one over this, so many times as
/// many may be made to cut the large ones; a ratio. Chosen: a mesh of 20 000 faces takes little longer.
const MANY_FACES: f64 = 1.5;

/// Between which legs edges are looked for; normalised. At the longest every face is whole but for its parts.
const FINEST: f64 = 1e-6;
const COARSEST: f64 = 4.0;

/// How fine a cut has about `count` reached slots, and how many it has, where `share` tells which part of
/// each face's sides is reached.
pub(crate) fn fineness_for(
    tracer: &Tracer,
    count: usize,
    parting: &mut Parting,
    share: impl Fn(usize) -> [f64; 2],
) -> (Fineness, f64) {
    let surroundings = parting.surroundings().filter(|around| count_apart(tracer, around)).cloned();
    let diffuse = (0..tracer.scene().faces().len()).filter(|&face| tracer.scene().is_diffuse(face));
    let shared = diffuse.map(|face| (face, share(face).iter().sum::<f64>()));
    let is_around = |face: usize| surroundings.as_ref().is_some_and(|around| around.has(face));
    let (around, faces): (Vec<_>, Vec<_>) = shared.partition(|&(face, _)| is_around(face));
    let (edge, reached) = even_edge(tracer, count, parting, &faces);
    if around.is_empty() {
        return (Fineness::even(edge), reached);
    }
    let parts = parting.at(edge);
    let slots = |coarser: f64| {
        let cells = |face| parts.cells(face, tracer.corners(face), Fineness::growing(edge, coarser)) as f64;
        around.iter().map(|&(face, share)| share * cells(face)).sum::<f64>()
    };
    let [mut coarser, mut coarsest] = COARSER;
    if slots(coarser) > AROUND * reached {
        while coarsest / coarser > 1.05 {
            let middle = (coarser * coarsest).sqrt();
            if slots(middle) > AROUND * reached { coarser = middle } else { coarsest = middle }
        }
        coarser = coarsest;
    }
    (Fineness::growing(edge, coarser), reached + slots(coarser))
}

/// Whether surroundings are cut by their distance alone: not where lights without area stand far from all
/// else, for then the light on them is what the scene is about.
fn count_apart(tracer: &Tracer, around: &Surroundings) -> bool {
    let mut places = tracer.scene().lights().filter_map(|light| light.position());
    !places.any(|place| around.is_beside(tracer.frame().from_world(place)))
}

/// The edge (normalised) for about `count` reached slots, and how many are reached, from the part of each
/// face that is. Where the faces of a mesh are themselves about as many, the large ones among them are cut
/// all the same, as finely as `count` patches would cut a mesh of few faces, for half as many patches more at
/// most.
fn even_edge(tracer: &Tracer, count: usize, parting: &mut Parting, faces: &[(usize, f64)]) -> (f64, f64) {
    let count = count as f64;
    let (edge, reached) = edge_for(tracer, count, count, parting, faces);
    let parts = parting.at(COARSEST);
    let whole = slots_at(tracer, COARSEST, &parts, faces).0;
    if MANY_FACES * whole <= count {
        return (edge, reached);
    }
    let area: f64 = faces.iter().map(|&(face, share)| share * triangle::area(tracer.corners(face))).sum();
    let as_of_few = (2.0 * area / count).sqrt();
    let (finest, most) = edge_for(tracer, MANY_FACES * whole, count, parting, faces);
    if finest >= edge.min(as_of_few) {
        return (finest, most);
    }
    let edge = edge.min(as_of_few);
    (edge, slots_at(tracer, edge, &parting.at(edge), faces).0)
}

/// How many slots of these faces are reached with legs up to `edge`, and how many there are, reached or not.
fn slots_at(tracer: &Tracer, edge: f64, parts: &Parts, faces: &[(usize, f64)]) -> (f64, f64) {
    faces.iter().fold((0.0, 0.0), |(reached, all), &(face, share)| {
        let cells = parts.cells(face, tracer.corners(face), Fineness::even(edge)) as f64;
        (reached + share * cells, all + 2.0 * cells)
    })
}

/// The edge at which about `goal` slots are reached, and how many are. Where light reaches but little, the
/// rest is not cut without end for it, but as `count` patches allow.
fn edge_for(
    tracer: &Tracer,
    goal: f64,
    count: f64,
    parting: &mut Parting,
    faces: &[(usize, f64)],
) -> (f64, f64) {
    let most_slots = 2.0 * faces.len() as f64 + DARK_PER_PATCH * count;
    let bisect = |mut fine: f64, mut coarse: f64, parts: &mut dyn FnMut(f64) -> Arc<Parts>| {
        // Bisect on a logarithmic scale; the count falls in steps as the edge grows.
        while coarse / fine > 1.001 {
            let edge = (fine * coarse).sqrt();
            let (reached, all) = slots_at(tracer, edge, &parts(edge), faces);
            if reached > goal || all > most_slots { fine = edge } else { coarse = edge }
        }
        let [of_fine, of_coarse] = [fine, coarse].map(|edge| slots_at(tracer, edge, &parts(edge), faces));
        let off = |reached: f64| (reached / goal).ln().abs();
        if of_fine.1 <= most_slots && off(of_fine.0) < off(of_coarse.0) {
            (fine, of_fine.0)
        } else {
            (coarse, of_coarse.0)
        }
    };
    // Contacts only make more patches: without them the edge is a bound on what it is with them.
    let none = Arc::new(Parts::default());
    let (edge, reached) = bisect(FINEST, COARSEST, &mut |_| none.clone());
    if parting.at(edge).is_empty() {
        return (edge, reached);
    }
    bisect(edge, COARSEST.max(edge), &mut |edge| parting.at(edge))
}
