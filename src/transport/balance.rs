//! Balance: the positive diagonal D for which D T D closes.
//!
//! Wanted is D_i ((T D)_i + e_i) = a_i for every row: with x = ln D that is the stationary point of the convex
//!
//! f(x) = ½ Σ T_ij exp(x_i + x_j) + Σ e_i exp(x_i) − Σ a_i x_i,
//!
//! found by Newton's method, each step by conjugate gradients (after Knight & Ruiz 2013). Alternate scaling of rows and
//! columns would need thousands of passes in a flat box; Newton needs about ten steps of a few passes.

use nalgebra::DVector;

use super::storage::Storage;
use crate::progress::{Cancelled, Progress};

/// How far rows are from summing to their patch's area, as the largest relative difference.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Closure {
    /// With the symmetric but unscaled matrix.
    pub before: f64,
    /// With the scaled one.
    pub after: f64,
    /// Passes over the matrix.
    pub iterations: usize,
}

/// Rows are closed when they are off by less than this, relative to their area.
const CLOSED: f64 = 2e-14;

/// What is closed only to be closed once more, together with the rest, may be off by this.
const CLOSED_FOR_NOW: f64 = 1e-6;

/// A row that lamps fill by more than this share has next to nothing else to share out.
pub(super) const FLOODED: f64 = 0.95;

/// Passes over the matrix after which a scaling that has not been found is held not to exist.
const MOST_PASSES: usize = 2000;

/// One set of scales and how far it is from closing.
struct State {
    log_scale: DVector<f64>,
    scale: DVector<f64>,
    /// a_i − D_i ((T D)_i + e_i), what row i lacks.
    lack: DVector<f64>,
    /// The largest |lack| relative to the row's target.
    error: f64,
    /// f(x), the convex function that is least where all rows close.
    value: f64,
}

struct Problem<'a> {
    storage: &'a Storage,
    escape: &'a DVector<f64>,
    /// 1 for rows that take no part.
    target: DVector<f64>,
    /// 1 for rows that take part, 0 for the rest: their scale is 0.
    part: DVector<f64>,
    passes: usize,
}

impl Problem<'_> {
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
        let error = (0..n).map(|i| lack[i].abs() / self.target[i]).fold(0.0, f64::max);
        let value = 0.5 * sums.sum() + escape.sum() - self.target.dot(&log_scale);
        State { log_scale, scale, lack, error, value }
    }

    /// Solves H δ = lack with H = diag(a − lack) + D T D by conjugate gradients, preconditioned by its first term.
    fn newton_step(&mut self, at: &State) -> DVector<f64> {
        let diagonal = &self.target - &at.lack;
        let precondition = |r: &DVector<f64>| r.component_div(&diagonal);
        let (mut step, mut r) = (DVector::zeros(at.lack.len()), at.lack.clone());
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rz = r.dot(&z);
        // As precise as the step is worth: the nearer the goal the more, but no more than the goal asks for.
        let enough = rz * at.error.max(0.3 * CLOSED / at.error).clamp(1e-4, 0.1).powi(2);
        for _ in 0..200 {
            if rz <= enough || self.passes >= MOST_PASSES {
                break;
            }
            let h_p = diagonal.component_mul(&p) + self.scaled(&at.scale, &p);
            let alpha = rz / p.dot(&h_p);
            step.axpy(alpha, &p, 1.0);
            r.axpy(-alpha, &h_p, 1.0);
            z = precondition(&r);
            let next = r.dot(&z);
            p = &z + &p * (next / rz);
            rz = next;
        }
        step
    }
}

/// Balances with what light sampling knows of lamps left alone: finds D and changes the entries of lamps in `storage` such
/// that, scaled by D, they are what they were but for one common factor per lamp. Answers D.
///
/// First each lamp gets the factor that closes its own row. Then the other rows share out what lamps leave of them, so that the
/// noise of rays is corrected where it is. At last all rows are closed together, which moves nothing by more than some 10⁻⁶.
pub(super) fn balance_around_lamps(
    storage: &mut Storage,
    escape: &DVector<f64>,
    areas: &DVector<f64>,
    is_lamp: &[bool],
    progress: Progress,
) -> Result<(DVector<f64>, Closure), Cancelled> {
    let n = areas.len();
    let one = |yes: bool| f64::from(u8::from(yes));
    let lamps = DVector::from_iterator(n, is_lamp.iter().map(|&lamp| one(lamp)));
    let others = lamps.map(|lamp| 1.0 - lamp);
    let start = DVector::repeat(n, 1.0);
    let raw =
        Problem::new(storage, escape, areas.clone(), DVector::repeat(n, 1.0)).state(DVector::zeros(n)).error;

    let to_others = escape + storage.times(&others);
    let mut closing = Problem::new(storage, &to_others, areas.clone(), lamps.clone());
    let lamp_scale = closing.solve(&start, CLOSED_FOR_NOW, progress)?.scale;

    // Where lamps all but fill a row, lamps and rays are scaled alike.
    let from_lamps = storage.times(&lamp_scale);
    let flooded: Vec<bool> = (0..n).map(|i| from_lamps[i] > FLOODED * areas[i]).collect();
    let left_alone = |i: usize| !is_lamp[i] && !flooded[i];
    let target = DVector::from_fn(n, |i, _| areas[i] - if left_alone(i) { from_lamps[i] } else { 0.0 });
    let escape_and_lamps =
        DVector::from_fn(n, |i, _| escape[i] + if flooded[i] { from_lamps[i] } else { 0.0 });
    let mut sharing = Problem::new(storage, &escape_and_lamps, target, others);
    let other_scale = sharing.solve(&start, CLOSED_FOR_NOW, progress)?.scale;
    let passes = 4 + closing.passes + sharing.passes;

    storage.scale_entries(|i, j| match (is_lamp[i], is_lamp[j]) {
        (true, false) if left_alone(j) => 1.0 / other_scale[j],
        (false, true) if left_alone(i) => 1.0 / other_scale[i],
        _ => 1.0,
    });
    let (scale, closure) = balance(storage, escape, areas, &(lamp_scale + other_scale), progress)?;
    Ok((scale, Closure { before: raw, iterations: closure.iterations + passes, ..closure }))
}

impl<'a> Problem<'a> {
    fn new(storage: &'a Storage, escape: &'a DVector<f64>, target: DVector<f64>, part: DVector<f64>) -> Self {
        let target = target.zip_map(&part, |target, part| if part > 0.0 { target } else { 1.0 });
        Self { storage, escape, target, part, passes: 0 }
    }

    /// Goes from a first guess of D to a D that closes all rows but for a relative error of `enough`, or as near to it as can be.
    fn solve(&mut self, start: &DVector<f64>, enough: f64, progress: Progress) -> Result<State, Cancelled> {
        let mut now = self.state(start.map(f64::ln));
        while now.error > enough && self.passes < MOST_PASSES {
            progress.at("balance", (now.error.ln() / enough.ln()).clamp(0.0, 0.99))?;
            let step = self.newton_step(&now);
            match advance(self, &now, &step) {
                Some(next) => now = next,
                None => break,
            }
        }
        Ok(now)
    }
}

/// Finds D from a first guess; where there is none, answers the best that was seen, made such that no row exceeds its target.
pub(super) fn balance(
    storage: &Storage,
    escape: &DVector<f64>,
    target: &DVector<f64>,
    start: &DVector<f64>,
    progress: Progress,
) -> Result<(DVector<f64>, Closure), Cancelled> {
    let mut problem = Problem::new(storage, escape, target.clone(), DVector::repeat(target.len(), 1.0));
    let before = problem.state(start.map(f64::ln)).error;
    let mut now = problem.solve(start, CLOSED, progress)?;
    let mut scale = now.scale;
    if now.error > 1e-9 {
        // No scaling exists, or none was found. Rows may lack something, but must not give out more than they get.
        let excess = (0..target.len()).map(|i| (target[i] - now.lack[i]) / target[i]).fold(1.0, f64::max);
        scale /= excess;
        now = problem.state(scale.map(f64::ln));
    }
    let closure = Closure { before, after: now.error, iterations: problem.passes };
    progress.at("balance", 1.0)?;
    Ok((scale, closure))
}

/// Goes along `step` as far as that helps; nothing if it does not.
fn advance(problem: &mut Problem, from: &State, step: &DVector<f64>) -> Option<State> {
    // exp() is trusted for factors up to e a step.
    let mut length = 1.0f64.min(1.0 / step.amax().max(1e-300));
    for _ in 0..30 {
        let next = problem.state(&from.log_scale + step * length);
        let slope = from.lack.dot(step) * length;
        // Far from the goal f must fall by a part of its slope; near it f is all rounding and the error itself must fall.
        let falls = next.value <= from.value - 1e-4 * slope;
        if next.value.is_finite() && (next.error < from.error || falls && from.error > 1e-6) {
            return Some(next);
        }
        length *= 0.5;
    }
    None
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    fn balance_dense(
        m: DMatrix<f64>,
        escape: &[f64],
        target: &[f64],
    ) -> (DMatrix<f64>, DVector<f64>, Closure) {
        let storage = Storage::Dense(m.map(|x| x as f32));
        let (escape, target) = (DVector::from_row_slice(escape), DVector::from_row_slice(target));
        let (d, closure) =
            balance(&storage, &escape, &target, &DVector::repeat(target.len(), 1.0), Progress::default())
                .unwrap();
        let scaled = DMatrix::from_fn(d.len(), d.len(), |i, j| d[i] * d[j] * f64::from(m[(i, j)] as f32));
        (scaled, d.component_mul(&escape), closure)
    }

    #[test]
    fn rows_close_to_their_targets() {
        let m = DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 2.0, 1.0, 0.0, 0.5, 2.0, 0.5, 0.0]);
        let target = [2.0, 1.5, 2.6];
        let (scaled, escape, closure) = balance_dense(m, &[0.1, 0.0, 0.4], &target);
        for i in 0..3 {
            assert!((scaled.row(i).sum() + escape[i] - target[i]).abs() < 1e-13 * target[i]);
        }
        assert!(closure.after < 1e-13 && closure.before > 0.1);
    }

    #[test]
    fn two_unequal_plates_close_by_what_escapes_between_them() {
        let m = DMatrix::from_row_slice(2, 2, &[0.0, 0.2, 0.2, 0.0]);
        let (scaled, escape, closure) = balance_dense(m, &[0.8, 1.8], &[1.0, 2.1]);
        assert!(closure.after < 1e-13);
        assert!((scaled[(0, 1)] + escape[0] - 1.0).abs() < 1e-13);
    }

    #[test]
    fn without_a_solution_the_error_is_told_and_no_row_exceeds_its_target() {
        let m = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 1.0, 0.0]);
        let (scaled, _, closure) = balance_dense(m, &[0.0, 0.0], &[1.0, 2.0]);
        assert!(closure.after > 0.1);
        assert!(scaled.row(0).sum() <= 1.0 + 1e-12 && scaled.row(1).sum() <= 2.0 + 1e-12);
    }
}
