//! The Neumann series L = E + KE + K²E + …: light, bounce by bounce.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::stopping::{Answer, Rule, Run};
use super::{Amplification, Report, Solution, SolveError, check_finite};
use crate::patches::Basis;
use crate::progress::Progress;
use crate::transport::Transport;

/// Where to truncate the series.
#[derive(Clone, Copy, Debug)]
pub struct NeumannOptions<'a> {
    /// The highest order: the series ends with KᵏE for this k at the latest.
    pub order: usize,
    /// The part of the flux, and of the irradiance, that may be missing where it ends before, from order 1
    /// on: the [rule](super#tolerance) that all iterations share; 0 for an exact number of orders.
    pub tolerance: f64,
    /// What [`Amplification::new`] says of the operator, where that is known already.
    pub amplification: Option<&'a Amplification>,
    /// Where to report progress, as stage `series`.
    pub progress: Progress<'a>,
}

impl Default for NeumannOptions<'_> {
    /// A tolerance of 10⁻⁶, order 1000 at most.
    fn default() -> Self {
        Self { order: 1000, tolerance: 1e-6, amplification: None, progress: Progress::default() }
    }
}

/// What one order adds, and how far the sum then is from the end.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Bounce {
    /// k.
    pub order: usize,
    /// Radiant flux that KᵏE adds, π Σ A KᵏE per channel, W.
    pub flux: Vec<f64>,
    /// Relative residual of the sum up to here.
    pub residual: f64,
    /// The part of the flux that the next order adds, as in [`Report::remaining_flux`].
    pub remaining_flux: f64,
    /// Bound on the relative error of the sum up to here, as in [`Report::bound`].
    pub bound: f64,
}

/// A truncated series.
#[derive(Clone, Debug)]
pub struct Series {
    /// The sum up to the last order.
    pub solution: Solution,
    /// Every order, from 0.
    pub bounces: Vec<Bounce>,
}

impl Series {
    /// The order at which the series was truncated.
    pub fn order(&self) -> usize {
        self.bounces.len() - 1
    }
}

/// Sums the series until it fulfils the [rule](super#tolerance), from order 1 on, or the highest order is
/// reached; either is success, and [`Report::truncated`] tells which. With tolerance 0 it goes on to the
/// highest order, unless nothing at all is left to add.
///
/// The bound of order k is the smaller of q/(1−q)·‖L_k − L_{k−1}‖∞ with q = ‖K‖∞, and ‖r_k‖∞·max w
/// ([`Amplification`]); for linear elements it is the estimate of the latter alone.
///
/// # Errors
/// `NotFinite` or `Cancelled`.
///
/// # Panics
/// If `e` is not N × c.
pub fn neumann(k: &Transport, e: &DMatrix<f64>, options: &NeumannOptions) -> Result<Series, SolveError> {
    neumann_from(k, e, DMatrix::zeros(k.len(), k.channels()), options)
}

/// The same where order 0 is E + R H/π of an irradiance H (N × c) that is no zero: a part of E that only
/// order 1 brings is taken back by it.
pub(super) fn neumann_from(
    k: &Transport,
    e: &DMatrix<f64>,
    irradiance: DMatrix<f64>,
    options: &NeumannOptions,
) -> Result<Series, SolveError> {
    assert_eq!(e.shape(), (k.len(), k.channels()), "the right-hand side is N × c");
    check_finite(k, e)?;
    let amplification = Amplification::known_or_new(options.amplification, k, Progress::default())?;
    let rule = Rule::new(k, e, &amplification, options.tolerance);
    let norm = match k.basis() {
        Basis::Constant => k.norm(),
        // M⁻¹S has negative entries, and K·1 tells nothing of its norm.
        Basis::Linear => vec![f64::INFINITY; k.channels()],
    };
    let mass = k.mass();
    let flux = |l: &DMatrix<f64>| {
        l.column_iter().map(|column| PI * mass.sums().dot(&column) * mass.unit()).collect()
    };
    let mut answer = Answer::new(k, e, irradiance);
    let mut added = e + &answer.reflected;
    let mut bounces: Vec<Bounce> = Vec::new();
    let mut at_start = None;
    let mut step_before: Option<DMatrix<f64>> = None;
    let report = loop {
        // The step to the next order is the residual of this one.
        let order = bounces.len();
        let mut report = answer.judge(k, e, Run { name: "neumann", iterations: order }, &amplification);
        report.bound = report.bound.min(tail_bound(&norm, &added, &(e + &answer.reflected)));
        let Report { residual, remaining_flux, bound, .. } = report;
        bounces.push(Bounce { order, flux: flux(&added), residual, remaining_flux, bound });
        let step = answer.step();
        let excess = rule.excess_of(&answer, &step, step_before.as_ref());
        // The irradiance of order 0 is zero by definition; whoever asks for a tolerance wants to see what
        // arrives.
        let is_enough = if options.tolerance > 0.0 { excess <= 1.0 } else { answer.residual.amax() == 0.0 };
        if (is_enough && order > 0) || order >= options.order {
            report.truncated = excess > 1.0;
            break report;
        }
        let progress = progress_made(*at_start.get_or_insert(excess), excess);
        options.progress.at("series", progress.max(order as f64 / options.order as f64))?;
        added = answer.residual;
        step_before = Some(step);
        answer = Answer::new(k, e, answer.next);
    };
    options.progress.at("series", 1.0)?;
    let radiance = e + answer.reflected;
    check_finite(k, &radiance)?;
    Ok(Series {
        solution: Solution { radiance, irradiance: answer.irradiance, basis: k.basis(), report },
        bounces,
    })
}

/// The first terms of the series by themselves: E, KE, … up to bounce `last`, n × c each.
///
/// # Panics
/// If `e` is not n × c.
pub fn bounces(k: &Transport, e: &DMatrix<f64>, last: usize) -> Vec<DMatrix<f64>> {
    let next = |term: &DMatrix<f64>| Some(k.reflect(&k.irradiance(term)));
    std::iter::successors(Some(e.clone()), next).take(last + 1).collect()
}

/// q/(1−q)·‖L_k − L_{k−1}‖∞ / ‖L_k‖∞, the largest over channels; infinite where q = 1.
fn tail_bound(norm: &[f64], added: &DMatrix<f64>, sum: &DMatrix<f64>) -> f64 {
    let bound = |c: usize| match (added.column(c).amax(), norm[c]) {
        (0.0, _) => 0.0,
        (_, q) if q >= 1.0 => f64::INFINITY,
        (step, q) => q / (1.0 - q) * step / sum.column(c).amax(),
    };
    (0..norm.len()).map(bound).fold(0.0, f64::max)
}

/// How far what is missing has come from its first value to what is good enough, on a logarithmic scale.
fn progress_made(first: f64, now: f64) -> f64 {
    if first.is_finite() && first > 1.0 { ((first / now).ln() / first.ln()).clamp(0.0, 0.99) } else { 0.0 }
}
