//! Rounds: how many paths each patch gets, and when to stop.
//!
//! A first round gives every patch the same few batches. Each later round at most doubles the paths and
//! shares them out so that the area-weighted sum of squared standard errors falls fastest: n ∝ √A σ (Neyman
//! 1934), with a floor for patches that have not yet seen how much they vary.

use super::estimate::{Half, PathTraced};

/// Batches that each half of every patch begins with.
const FIRST: u32 = 4;

/// The least a patch counts for when paths are shared out, as a part of the average patch.
const FLOOR: f64 = 0.3;

/// When to stop; whichever comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// The relative standard error of all patches together that is enough
    /// ([`PathTraced::relative_standard_error`]).
    pub standard_error: Option<f64>,
    /// Wall-clock time, seconds.
    pub seconds: Option<f64>,
    /// Number of paths. Every patch gets some, so that many patches may take more.
    pub paths: Option<u64>,
}

impl Budget {
    /// Whether anything ends the work, and all of it makes sense.
    pub(super) fn is_valid(&self) -> bool {
        let positive = |x: Option<f64>| x.is_none_or(|x| x.is_finite() && x > 0.0);
        let bounded = self.standard_error.is_some() || self.seconds.is_some() || self.paths.is_some();
        bounded && positive(self.standard_error) && positive(self.seconds) && self.paths != Some(0)
    }

    /// How many more paths are wanted, at the price so far; 0 when the work is done. `seconds` and `paths`
    /// are those of this call.
    pub(super) fn left(&self, estimate: &PathTraced, seconds: f64, paths: u64) -> f64 {
        /// The least worth starting a round for, as a part of the paths so far.
        const LEAST: f64 = 0.02;
        let all = estimate.paths as f64;
        let by_count = self.paths.map(|most| most.saturating_sub(paths) as f64);
        let by_time = self.seconds.map(|most| {
            let wanted = (most - seconds).max(0.0) / estimate.seconds.max(1e-9) * all;
            if wanted > LEAST * all { wanted } else { 0.0 }
        });
        let by_error = self.standard_error.map(|enough| match estimate.relative_standard_error() {
            now if now <= enough => 0.0,
            now => (((now / enough).powi(2) - 1.0) * all).max(LEAST * all),
        });
        [by_count, by_time, by_error].into_iter().flatten().fold(f64::INFINITY, f64::min)
    }
}

/// How many batches each half of every patch gets next.
pub(super) type Round = [Vec<u32>; 2];

/// The round to begin with.
pub(super) fn first_round(estimate: &PathTraced, budget: &Budget) -> Round {
    let n = estimate.len();
    let affordable = budget.paths.map(|paths| paths / (2 * u64::from(estimate.batch) * n.max(1) as u64));
    // Two batches are the fewest that have a spread. What time allows is not known yet.
    let allowed = affordable.unwrap_or(if budget.seconds.is_some() { 2 } else { FIRST.into() });
    let batches = allowed.clamp(2, FIRST.into()) as u32;
    [vec![batches; n], vec![batches; n]]
}

/// The round that follows when so many paths are left to be traced: at most as many again.
pub(super) fn next_round(estimate: &PathTraced, left: f64) -> Round {
    let left = left.min(estimate.paths as f64);
    let batches = (left / f64::from(2 * estimate.batch)).ceil();
    let [a, b] = &estimate.halves;
    [share_out(a, b, batches), share_out(b, a, batches)]
}

/// Shares `batches` out among the patches of half `own` by what `other` knows of their spread.
fn share_out(own: &Half, other: &Half, batches: f64) -> Vec<u32> {
    let mut worth = other.spread.clone();
    let mean = worth.iter().sum::<f64>() / worth.len().max(1) as f64;
    worth.iter_mut().for_each(|w| *w = if mean > 0.0 { w.max(FLOOR * mean) } else { 1.0 });
    // What each lacks of its share of all batches, scaled to what there is to give.
    let all = batches + own.batches.iter().map(|&n| f64::from(n)).sum::<f64>();
    let total: f64 = worth.iter().sum();
    let lack: Vec<f64> =
        worth.iter().zip(&own.batches).map(|(w, &n)| (all * w / total - f64::from(n)).max(0.0)).collect();
    let scale = batches / lack.iter().sum::<f64>().max(1e-300);
    // Round the running sum, so that the whole comes out right.
    let mut owed = 0.0f64;
    let mut given = 0.0f64;
    let round = |lack: f64| {
        owed += lack * scale;
        let now = (owed - given).round().max(0.0);
        given += now;
        now as u32
    };
    lack.into_iter().map(round).collect()
}
