//! Size: how long the legs of patches may be for about so many patches.

use std::sync::Arc;

use super::parts::{Parting, Parts};
use crate::trace::Tracer;

/// The most slots, reached or not, for each patch that is wanted.
const DARK_PER_PATCH: f64 = 16.0;

/// The edge (normalised) at which about `count` slots are reached, and how many are at this edge, where
/// `share` tells which part of each face's sides is.
pub(crate) fn edge_for(
    tracer: &Tracer,
    count: usize,
    parting: &mut Parting,
    share: impl Fn(usize) -> [f64; 2],
) -> (f64, f64) {
    let faces: Vec<(usize, f64)> = (0..tracer.scene().faces().len())
        .filter(|&f| tracer.scene().is_diffuse(f))
        .map(|f| (f, share(f).iter().sum::<f64>()))
        .collect();
    let whole: f64 = faces.iter().map(|&(_, share)| share).sum();
    let goal = if whole < count as f64 { count as f64 } else { whole + 0.5 * count as f64 };
    // Where light reaches but little, the rest must not be cut without end either.
    let most_slots = 2.0 * faces.len() as f64 + DARK_PER_PATCH * count as f64;
    let slots_at = |edge: f64, parts: &Parts| -> (f64, f64) {
        let sum = |(reached, all): (f64, f64), &(f, share): &(usize, f64)| {
            let cells = parts.cells(f, tracer.corners(f), edge) as f64;
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
