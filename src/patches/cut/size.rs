//! Size: how long the legs of patches may be for about so many patches.
//!
//! Surroundings are not counted at first: everything else is cut as if they were not there, and then they are
//! cut as finely as a share of so many patches allows.

use std::sync::Arc;

use super::fineness::Fineness;
use super::parts::{Parting, Parts};
use super::surroundings::Surroundings;
use crate::trace::Tracer;

/// The most slots, reached or not, for each patch that is wanted.
const DARK_PER_PATCH: f64 = 16.0;

/// Patches of the surroundings for each of the rest; a ratio. Chosen: a scene takes little longer for them,
/// and those next to a room are hardly larger than its own.
const AROUND: f64 = 1.0 / 6.0;

/// How many times as long the legs of the surroundings are as elsewhere, next to all else, at least and at
/// most; ratios. Chosen: beyond that there is one patch to a part.
const COARSER: [f64; 2] = [1.0, 64.0];

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

/// The edge (normalised) at which about `count` slots of faces are reached, and how many are, from the part
/// of each that is reached.
fn even_edge(tracer: &Tracer, count: usize, parting: &mut Parting, faces: &[(usize, f64)]) -> (f64, f64) {
    let whole: f64 = faces.iter().map(|&(_, share)| share).sum();
    let goal = if whole < count as f64 { count as f64 } else { whole + 0.5 * count as f64 };
    // Where light reaches but little, the rest must not be cut without end either.
    let most_slots = 2.0 * faces.len() as f64 + DARK_PER_PATCH * count as f64;
    let slots_at = |edge: f64, parts: &Parts| -> (f64, f64) {
        let sum = |(reached, all): (f64, f64), &(f, share): &(usize, f64)| {
            let cells = parts.cells(f, tracer.corners(f), Fineness::even(edge)) as f64;
            (reached + share * cells, all + 2.0 * cells)
        };
        faces.iter().fold((0.0, 0.0), sum)
    };
    let bisect = |mut fine: f64, mut coarse: f64, parts: &mut dyn FnMut(f64) -> Arc<Parts>| {
        // Bisect on a logarithmic scale; the count falls in steps as the edge grows.
        while coarse / fine > 1.001 {
            let edge = (fine * coarse).sqrt();
            let (reached, all) = slots_at(edge, &parts(edge));
            if reached > goal || all > most_slots { fine = edge } else { coarse = edge }
        }
        let [of_fine, of_coarse] = [fine, coarse].map(|edge| slots_at(edge, &parts(edge)));
        let off = |reached: f64| (reached / goal).ln().abs();
        if of_fine.1 <= most_slots && off(of_fine.0) < off(of_coarse.0) {
            (fine, of_fine.0)
        } else {
            (coarse, of_coarse.0)
        }
    };
    // Contacts only make more patches: without them the edge is a bound on what it is with them.
    let none = Arc::new(Parts::default());
    let (edge, reached) = bisect(1e-6, 4.0, &mut |_| none.clone());
    if parting.at(edge).is_empty() {
        return (edge, reached);
    }
    bisect(edge, 4.0f64.max(edge), &mut |edge| parting.at(edge))
}
