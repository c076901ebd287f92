//! Balance: the positive diagonal D for which D T D closes, as far as scales up to D_max can.
//!
//! Wanted is D_i ((T D)_i + e_i) = a_i for every row: with x = ln D that is the stationary point of the
//! convex
//!
//! f(x) = ½ Σ T_ij exp(x_i + x_j) + Σ e_i exp(x_i) − Σ a_i x_i.
//!
//! Rows of real meshes (doubled faces, sealed pockets) may admit no such D. So f is minimised subject to
//! x_i ≤ ln D_max. Then every row that can close does, and the multiplier of an active bound is the row's
//! *slack* a_i − D_i ((T D)_i + e_i) ≥ 0, what it lacks (Karush–Kuhn–Tucker). A row that cannot close costs
//! its neighbours nothing else.
//!
//! The minimum is found by a projected Newton method (Bertsekas 1982): rows at the bound whose gradient
//! points outwards are held, the others take a Newton step by conjugate gradients (after Knight & Ruiz 2013),
//! and the line search follows the projected path. Alternate scaling of rows and columns would need thousands
//! of passes in a flat box; Newton needs about ten steps of a few passes.

use std::borrow::Cow;
use std::convert::Infallible;

use nalgebra::{DMatrix, DVector, DVectorView};

use super::storage::Storage;
use crate::progress::{Cancelled, Progress};
use crate::transport::symmetric_system::{SymmetricSystem, solve_symmetric};

/// How far rows are from summing to their patch's area, as the largest relative difference.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Closure {
    /// With the symmetric but unscaled matrix.
    pub before: f64,
    /// With the scaled one, slack included.
    pub after: f64,
    /// Passes over the matrix.
    pub iterations: usize,
    /// Σ slack / Σ area: the share of all rows together that nothing fills.
    pub slack: f64,
}

/// Rows are closed when they are off by less than this, relative to their area.
const CLOSED: f64 = 2e-14;

/// What is closed only to be closed once more, together with the rest, may be off by this.
const CLOSED_FOR_NOW: f64 = 1e-6;

/// Rows that are off by more than this at the end were not closed, and are lowered.
const NOT_CLOSED: f64 = 1e-12;

/// A row that lamps fill by more than this share has next to nothing else to share out.
pub const FLOODED: f64 = 0.95;

/// Passes over the matrix after which the search ends with what it has. Rows are then lowered to their
/// targets, and what they lack is slack: in meshes of many nooks some pairs of patches see next to nothing
/// but each other, and a few rows take thousands of passes to close to the last digit.
const MOST_PASSES: usize = 300;

/// How many of these what is closed only to be closed once more may take: lamps, and then all others.
const MOST_FOR_LAMPS: usize = 50;
const MOST_FOR_OTHERS: usize = 100;

/// Conjugate gradients of one Newton step.
const MOST_STEPS: usize = 200;

/// Within this distance of the bound, in ln D, a row that is pushed outwards moves onto it.
const NEAR_BOUND: f64 = 0.01;

/// D_max, the largest scale of a row, where there are at least so many rays a coefficient: how many times too
/// little rays may have found of what a row exchanges. With 16 rays, rooms need scales of 0.6 to 1.8 and a
/// box 500 times as wide as high needs 4.3; with fewer, some rows of linear elements are all but missed. A
/// larger bound would make what unclosable rows see fade more, in proportion to 1/D_max.
const MOST_SCALES: [(u32, f64); 3] = [(64, 4.0), (16, 8.0), (0, 64.0)];

/// D_max for so many rays a coefficient; `None` where exchange areas do not come from rays.
pub fn most_scale(rays: Option<u32>) -> f64 {
    let suits = |(least, _): &(u32, f64)| rays.is_none_or(|rays| rays >= *least);
    MOST_SCALES.into_iter().find(suits).map_or(MOST_SCALES[0].1, |(_, most)| most)
}

/// What rows are to sum to, N values each.
#[derive(Clone, Copy)]
pub struct RowSums<'a> {
    /// e, what ends elsewhere than in the matrix, unscaled.
    pub escape: &'a DVector<f64>,
    /// a, greater than 0.
    pub target: &'a DVector<f64>,
    /// D_max.
    pub most_scale: f64,
}

/// A matrix made to close.
pub struct Balanced {
    /// D, N values up to D_max.
    pub scale: DVector<f64>,
    /// a_i − D_i ((T D)_i + e_i) where a row could not be closed, else 0; N values ≥ 0.
    pub slack: DVector<f64>,
    pub closure: Closure,
}

/// One set of scales and how far it is from closing.
struct State {
    log_scale: DVector<f64>,
    scale: DVector<f64>,
    /// a_i − D_i ((T D)_i + e_i), what row i lacks: the negative gradient of f.
    lack: DVector<f64>,
    /// The largest |lack| relative to the row's target, but for rows at the bound that lack something.
    error: f64,
    /// f(x).
    value: f64,
}

struct Closing<'a> {
    storage: &'a Storage,
    escape: &'a DVector<f64>,
    /// 1 for rows that take no part.
    target: DVector<f64>,
    /// 1 for rows that take part, 0 for the rest: their scale is 0.
    part: DVector<f64>,
    /// ln D_max.
    bound: f64,
    passes: usize,
    /// How many passes there may be.
    most: usize,
}

impl<'a> Closing<'a> {
    fn new(storage: &'a Storage, sums: RowSums<'a>, part: DVector<f64>, most: usize) -> Self {
        let target = sums.target.zip_map(&part, |target, part| if part > 0.0 { target } else { 1.0 });
        Self { storage, escape: sums.escape, target, part, bound: sums.most_scale.ln(), passes: 0, most }
    }

    /// diag(d) T diag(d) x
    fn scaled(&mut self, d: &DVector<f64>, x: &DVector<f64>) -> DVector<f64> {
        self.passes += 1;
        self.storage.times(&x.component_mul(d)).component_mul(d)
    }

    fn state(&mut self, log_scale: DVector<f64>) -> State {
        let n = log_scale.len();
        let scale = log_scale.map(f64::exp).component_mul(&self.part);
        let sums = self.scaled(&scale, &DVector::repeat(n, 1.0));
        let escape = self.escape.component_mul(&scale);
        let lack = (&self.target - &sums - &escape).component_mul(&self.part);
        let off = |i: usize| {
            let is_held = lack[i] > 0.0 && log_scale[i] >= self.bound;
            if is_held { 0.0 } else { lack[i].abs() / self.target[i] }
        };
        let error = (0..n).map(off).fold(0.0, f64::max);
        let value = 0.5 * sums.sum() + escape.sum() - self.target.dot(&log_scale);
        State { log_scale, scale, lack, error, value }
    }

    /// Solves H δ = lack with H = diag(a − lack) + D T D by conjugate gradients, preconditioned by its first
    /// term, for all rows but those that go to the bound.
    fn newton_step(&mut self, at: &State) -> DVector<f64> {
        let sums = &self.target - &at.lack;
        // Hold rows that are pushed over the bound, and those that see nothing, which no scale can help.
        let is_held = |i: usize| {
            let near = at.log_scale[i] > self.bound - NEAR_BOUND.min(at.error);
            at.lack[i] > 0.0 && (near || sums[i] <= f64::EPSILON * self.target[i])
        };
        let held: Vec<bool> = (0..at.lack.len()).map(is_held).collect();
        let diagonal = sums.map_with_location(|i, _, sum| if held[i] { 1.0 } else { sum });
        let lack = DMatrix::from_fn(at.lack.len(), 1, |i, _| if held[i] { 0.0 } else { at.lack[i] });
        let mut system = Newton { problem: self, at, held, diagonal, steps: 0, first: None };
        let Ok(step) = solve_symmetric(&mut system, lack);
        let held = system.held;
        DVector::from_fn(held.len(), |i, _| if held[i] { self.bound - at.log_scale[i] } else { step[i] })
    }

    /// Goes from a first guess of D to the minimum of f but for a relative error of `enough`, or as near to
    /// it as can be.
    fn solve(&mut self, start: &DVector<f64>, enough: f64, progress: Progress) -> Result<State, Cancelled> {
        let mut now = self.state(start.map(|start| start.ln().min(self.bound)));
        while now.error > enough && self.passes < self.most {
            progress.at("balance", (now.error.ln() / enough.ln()).clamp(0.0, 0.99))?;
            let step = self.newton_step(&now);
            match self.advance(&now, &step) {
                Some(next) => now = next,
                None => break,
            }
        }
        Ok(now)
    }

    /// Goes along `step`, no further than the bound, as far as that helps; nothing if it does not.
    fn advance(&mut self, from: &State, step: &DVector<f64>) -> Option<State> {
        // exp() is trusted for factors up to e a step.
        let furthest = step.zip_map(&from.log_scale, |step, x| step.min(self.bound - x)).amax();
        let mut length = 1.0f64.min(1.0 / furthest.max(1e-300));
        for _ in 0..30 {
            let along = |x: f64, step: f64| (x + step * length).min(self.bound);
            let next = self.state(from.log_scale.zip_map(step, along));
            let slope = from.lack.dot(&(&next.log_scale - &from.log_scale));
            // Far from the goal f must fall by a part of its slope; near it f is all rounding and the error
            // itself must fall.
            let falls = next.value <= from.value - 1e-4 * slope;
            if next.value.is_finite() && (next.error < from.error || falls && from.error > 1e-6) {
                return Some(next);
            }
            length *= 0.5;
        }
        None
    }

    /// Lowers scales until no row exceeds its target, whatever they are: D_i ← D_i min(1, a_i / row_i).
    fn lowered(&mut self, at: &State) -> State {
        let log_scale = DVector::from_fn(at.lack.len(), |i, _| {
            let row = self.target[i] - at.lack[i];
            at.log_scale[i] + (self.target[i] / row).min(1.0).ln()
        });
        self.state(log_scale)
    }
}

/// The system of a Newton step, H δ = lack, for rows that are not held.
struct Newton<'a, 'p> {
    problem: &'a mut Closing<'p>,
    at: &'a State,
    held: Vec<bool>,
    /// The first term of H; 1 for rows that are held.
    diagonal: DVector<f64>,
    steps: usize,
    /// rᵀz at the start.
    first: Option<f64>,
}

impl SymmetricSystem for Newton<'_, '_> {
    type Error = Infallible;

    fn times(&mut self, p: &DMatrix<f64>) -> DMatrix<f64> {
        self.steps += 1;
        let p = DVector::from_column_slice(p.as_slice());
        let through = self.problem.scaled(&self.at.scale, &p);
        DMatrix::from_fn(p.len(), 1, |i, _| {
            self.diagonal[i] * p[i] + if self.held[i] { 0.0 } else { through[i] }
        })
    }

    fn goes_on(&mut self, _r: &DMatrix<f64>, rz: &[f64]) -> Result<Vec<bool>, Infallible> {
        // As precise as the step is worth: the nearer the goal the more, but no more than the goal asks for.
        let error = self.at.error;
        let precision = error.max(0.3 * CLOSED / error).clamp(1e-4, 0.1);
        let enough = *self.first.get_or_insert(rz[0]) * precision.powi(2);
        let may = self.steps < MOST_STEPS && self.problem.passes < self.problem.most;
        Ok(vec![rz[0] > enough && may])
    }

    fn preconditioned<'r>(&self, r: &'r DMatrix<f64>) -> Cow<'r, DMatrix<f64>> {
        Cow::Owned(r.map_with_location(|i, _, r| r / self.diagonal[i]))
    }

    fn least_curvature(&self, p: DVectorView<f64>) -> f64 {
        f64::EPSILON * p.component_mul(&p).dot(&self.diagonal)
    }

    /// f falls along p without end, until rows are at the bound.
    fn last_step(&self, p: DVectorView<f64>) -> f64 {
        1.0 / p.amax()
    }
}

/// Balances with what light sampling knows of lamps left alone: finds D and changes the entries of lamps in
/// `storage` such that, scaled by D, they are what they were but for one common factor per lamp.
///
/// First each lamp gets the factor that closes its own row. Then the other rows share out what lamps leave of
/// them, so that the noise of rays is corrected where it is. At last all rows are closed together, which
/// moves nothing by more than some 10⁻⁶. Scales have the same bound in all three.
pub fn balance_around_lamps(
    storage: &mut Storage,
    sums: RowSums,
    is_lamp: &[bool],
    progress: Progress,
) -> Result<Balanced, Cancelled> {
    let RowSums { escape, target: areas, .. } = sums;
    let n = areas.len();
    let one = |yes: bool| f64::from(u8::from(yes));
    let lamps = DVector::from_iterator(n, is_lamp.iter().map(|&lamp| one(lamp)));
    let others = lamps.map(|lamp| 1.0 - lamp);
    let start = DVector::repeat(n, 1.0);
    let raw = Closing::new(storage, sums, start.clone(), 1).state(DVector::zeros(n)).error;

    let to_others = escape + storage.times(&others);
    let of_lamps = RowSums { escape: &to_others, ..sums };
    let mut closing = Closing::new(storage, of_lamps, lamps.clone(), MOST_FOR_LAMPS);
    let lamp_scale = closing.solve(&start, CLOSED_FOR_NOW, progress)?.scale;

    // Where lamps all but fill a row, lamps and rays are scaled alike.
    let from_lamps = storage.times(&lamp_scale);
    let flooded: Vec<bool> = (0..n).map(|i| from_lamps[i] > FLOODED * areas[i]).collect();
    let left_alone = |i: usize| !is_lamp[i] && !flooded[i];
    let target = DVector::from_fn(n, |i, _| areas[i] - if left_alone(i) { from_lamps[i] } else { 0.0 });
    let escape_and_lamps =
        DVector::from_fn(n, |i, _| escape[i] + if flooded[i] { from_lamps[i] } else { 0.0 });
    let of_others = RowSums { escape: &escape_and_lamps, target: &target, ..sums };
    let mut sharing = Closing::new(storage, of_others, others, MOST_FOR_OTHERS);
    let other_scale = sharing.solve(&start, CLOSED_FOR_NOW, progress)?.scale;
    let passes = 4 + closing.passes + sharing.passes;

    storage.scale_entries(|i, j| match (is_lamp[i], is_lamp[j]) {
        (true, false) if left_alone(j) => 1.0 / other_scale[j],
        (false, true) if left_alone(i) => 1.0 / other_scale[i],
        _ => 1.0,
    });
    let balanced = balance_within(
        storage,
        sums,
        &(lamp_scale + other_scale),
        MOST_PASSES.saturating_sub(passes),
        progress,
    )?;
    let closure =
        Closure { before: raw, iterations: balanced.closure.iterations + passes, ..balanced.closure };
    Ok(Balanced { closure, ..balanced })
}

/// Finds D from a first guess. Rows sum to their targets or to less, and then have slack.
pub fn balance(
    storage: &Storage,
    sums: RowSums,
    start: &DVector<f64>,
    progress: Progress,
) -> Result<Balanced, Cancelled> {
    balance_within(storage, sums, start, MOST_PASSES, progress)
}

fn balance_within(
    storage: &Storage,
    sums: RowSums,
    start: &DVector<f64>,
    most: usize,
    progress: Progress,
) -> Result<Balanced, Cancelled> {
    let mut problem = Closing::new(storage, sums, DVector::repeat(sums.target.len(), 1.0), most);
    let before = problem.state(start.map(f64::ln)).error;
    let mut now = problem.solve(start, CLOSED, progress)?;
    let was_closed = now.error <= NOT_CLOSED;
    if !was_closed {
        now = problem.lowered(&now);
    }
    let slack =
        now.lack.zip_map(
            &now.log_scale,
            |lack, x| {
                if x >= problem.bound || !was_closed { lack.max(0.0) } else { 0.0 }
            },
        );
    let off = (&now.lack - &slack).zip_map(sums.target, |off, target| off.abs() / target).amax();
    let share = slack.sum() / sums.target.sum();
    let closure = Closure { before, after: off, iterations: problem.passes, slack: share };
    progress.at("balance", 1.0)?;
    Ok(Balanced { scale: now.scale, slack, closure })
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use sprs::{CsMatI, TriMatI};

    use super::*;

    const MOST: f64 = MOST_SCALES[0].1;

    /// T as stored, what it was balanced to, and e.
    struct Case {
        storage: Storage,
        escape: DVector<f64>,
        target: DVector<f64>,
    }

    impl Case {
        fn dense(rows: &[f64], escape: &[f64], target: &[f64]) -> Self {
            let n = target.len();
            let storage = Storage::Dense(DMatrix::from_row_slice(n, n, rows).map(|x| x as f32));
            Self { storage, escape: DVector::from_row_slice(escape), target: DVector::from_row_slice(target) }
        }

        fn sums(&self) -> RowSums<'_> {
            RowSums { escape: &self.escape, target: &self.target, most_scale: MOST }
        }

        fn balanced(&self) -> Balanced {
            let start = DVector::repeat(self.target.len(), 1.0);
            balance(&self.storage, self.sums(), &start, Progress::default()).unwrap()
        }

        /// D_i ((T D)_i + e_i)
        fn rows(&self, scale: &DVector<f64>) -> DVector<f64> {
            (self.storage.times(scale) + &self.escape).component_mul(scale)
        }

        /// Asserts the conditions of Karush, Kuhn and Tucker: rows below the bound close, rows at it lack
        /// nothing negative, and that is their slack.
        fn assert_optimal(&self, balanced: &Balanced) {
            let lack = &self.target - self.rows(&balanced.scale);
            for i in 0..lack.len() {
                let (scale, slack, least) = (balanced.scale[i], balanced.slack[i], 1e-12 * self.target[i]);
                assert!(scale <= MOST * (1.0 + 1e-15), "row {i}: scale {scale}");
                assert!((lack[i] - slack).abs() <= least, "row {i} lacks {}, slack {slack}", lack[i]);
                assert!(slack >= 0.0 && (slack == 0.0 || scale >= MOST * (1.0 - 1e-15)), "row {i}: {slack}");
            }
            assert!(balanced.closure.after < 1e-12, "{:?}", balanced.closure);
        }
    }

    #[test]
    fn rows_close_to_their_targets() {
        let case =
            Case::dense(&[0.0, 1.0, 2.0, 1.0, 0.0, 0.5, 2.0, 0.5, 0.0], &[0.1, 0.0, 0.4], &[2.0, 1.5, 2.6]);
        let balanced = case.balanced();
        case.assert_optimal(&balanced);
        assert!(balanced.closure.before > 0.1 && balanced.slack.amax() == 0.0);
    }

    #[test]
    fn two_unequal_plates_close_by_what_escapes_between_them() {
        let case = Case::dense(&[0.0, 0.2, 0.2, 0.0], &[0.8, 1.8], &[1.0, 2.1]);
        let balanced = case.balanced();
        case.assert_optimal(&balanced);
        assert_eq!(balanced.slack.amax(), 0.0);
    }

    #[test]
    fn what_one_row_sends_cannot_fill_a_larger_one_which_keeps_slack() {
        let case = Case::dense(&[0.0, 1.0, 1.0, 0.0], &[0.0, 0.0], &[1.0, 2.0]);
        let balanced = case.balanced();
        case.assert_optimal(&balanced);
        assert!((balanced.slack[1] - 1.0).abs() < 1e-12 && balanced.slack[0] == 0.0, "{}", balanced.slack);
        assert!((balanced.closure.slack - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_row_that_sees_nothing_is_all_slack() {
        let case = Case::dense(&[1.2, 0.0, 0.0, 0.0], &[0.0, 0.0], &[1.0, 2.0]);
        let balanced = case.balanced();
        assert_eq!(balanced.slack[1], 2.0);
        assert!((balanced.scale[0].powi(2) * f64::from(1.2f32) - 1.0).abs() < 1e-13);
    }

    /// A block that can be closed, and beside it rows that cannot.
    fn beside_an_unclosable_pair(block: &Case) -> Case {
        let (n, inner) = (block.target.len() + 2, block.target.len());
        let entry = |i: usize, j: usize| match (i < inner, j < inner) {
            (true, true) => block.storage.get(i, j) as f32,
            (false, false) if i != j => 1.0,
            _ => 0.0,
        };
        let extended =
            |of: &DVector<f64>, more: [f64; 2]| DVector::from_iterator(n, of.iter().copied().chain(more));
        Case {
            storage: Storage::Dense(DMatrix::from_fn(n, n, entry)),
            escape: extended(&block.escape, [0.0, 0.0]),
            target: extended(&block.target, [1.0, 2.0]),
        }
    }

    #[test]
    fn rows_that_cannot_close_leave_those_that_can_as_they_are_alone() {
        let block =
            Case::dense(&[0.0, 1.0, 2.0, 1.0, 0.0, 0.5, 2.0, 0.5, 0.0], &[0.1, 0.0, 0.4], &[2.0, 1.5, 2.6]);
        let both = beside_an_unclosable_pair(&block);
        let (alone, beside) = (block.balanced(), both.balanced());
        both.assert_optimal(&beside);
        for i in 0..3 {
            assert!((beside.scale[i] / alone.scale[i] - 1.0).abs() < 1e-12, "row {i}");
            assert_eq!(beside.slack[i], 0.0);
        }
        assert!((beside.slack[4] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rows_that_cannot_close_leave_those_that_can_alone_around_lamps_too() {
        // The first row is a lamp's.
        let block =
            Case::dense(&[0.0, 1.0, 2.0, 1.0, 0.0, 0.5, 2.0, 0.5, 0.0], &[0.1, 0.3, 0.4], &[2.8, 1.9, 2.9]);
        let both = beside_an_unclosable_pair(&block);
        let balanced = |case: &Case| {
            let mut storage = case.storage.clone();
            let is_lamp: Vec<bool> = (0..case.target.len()).map(|i| i == 0).collect();
            let balanced =
                balance_around_lamps(&mut storage, case.sums(), &is_lamp, Progress::default()).unwrap();
            let (escape, target) = (case.escape.clone(), case.target.clone());
            Case { storage, escape, target }.assert_optimal(&balanced);
            balanced
        };
        let (alone, beside) = (balanced(&block), balanced(&both));
        for i in 0..3 {
            // Scales without lamps are found to some 10⁻⁶ only.
            assert!((beside.scale[i] / alone.scale[i] - 1.0).abs() < 1e-5, "row {i}");
        }
        assert!((beside.slack[4] - 1.0).abs() < 1e-12 && beside.slack.rows(0, 4).amax() == 0.0);
    }

    /// Numbers of 0 to 1 by a linear congruential generator (Knuth's MMIX).
    fn numbers(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    /// A sparse symmetric matrix of `n` rows that find `each` others and as many find, with targets of 0.5 to
    /// 1.5 times what they find. Every tenth row finds far too little.
    fn random(seed: u64, n: usize, each: usize) -> Case {
        let mut number = numbers(seed);
        let mut entries = TriMatI::<f32, u32>::new((n, n));
        for i in 0..n {
            for _ in 0..each {
                let j = (number() * n as f64) as usize;
                let worth = (if [i, j].iter().any(|k: &usize| k.is_multiple_of(10)) { 0.02 } else { 1.0 }
                    * number()) as f32;
                entries.add_triplet(i, j, worth);
                entries.add_triplet(j, i, worth);
            }
        }
        let matrix: CsMatI<f32, u32, usize> = entries.to_csr();
        let storage = Storage::Sparse(matrix);
        let sums = storage.times(&DVector::repeat(n, 1.0));
        let target = DVector::from_fn(n, |i, _| match i % 10 {
            0 => 4.0,
            _ => (0.5 + number()) * sums[i].max(0.1),
        });
        let escape = DVector::from_fn(n, |i, _| if i % 3 == 0 { 0.1 * sums[i] } else { 0.0 });
        Case { storage, escape, target }
    }

    #[test]
    fn the_conditions_of_a_bounded_minimum_hold_on_random_matrices() {
        for seed in 0..6 {
            let case = random(seed, 200, 4);
            let balanced = case.balanced();
            case.assert_optimal(&balanced);
            let short = balanced.slack.iter().filter(|slack| **slack > 0.0).count();
            assert!((5..100).contains(&short), "{short} rows with slack");
            assert!(balanced.closure.iterations < 300, "{:?}", balanced.closure);
        }
    }

    #[test]
    fn a_search_that_is_cut_short_leaves_no_row_above_its_target() {
        let case = random(1, 200, 4);
        let mut problem = Closing::new(&case.storage, case.sums(), DVector::repeat(200, 1.0), MOST_PASSES);
        let first = problem.state(DVector::zeros(200));
        let lowered = problem.lowered(&first);
        assert!(first.lack.min() < -0.1);
        assert!(lowered.lack.iter().zip(&case.target).all(|(lack, target)| *lack >= -1e-15 * target));
        assert!(lowered.scale.iter().zip(&first.scale).all(|(lower, first)| lower <= first));
    }
}
