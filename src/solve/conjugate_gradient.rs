//! Conjugate gradients on the symmetric form of the radiosity equation (Hestenes & Stiefel 1952).
//!
//! With R = √ρ M^(−½), y = R S L solves (I − R S R) y = R S E, which is symmetric positive definite; then L =
//! E + R y. All channels go through the matrix in one pass. Sheets that let through more than they reflect
//! make the form indefinite; there MINRES takes its place, under the same options.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::goals::Limits;
use super::stopping::{Answer, Rule, Run};
use super::symmetric::Root;
use super::{Amplification, Solution, SolveError, check_finite, krylov};
use crate::progress::Progress;
use crate::transport::Transport;

/// Refinement that leaves more than this part of what was too much makes no headway.
const STUCK: f64 = 0.5;

/// Passes that it takes to judge an answer.
const JUDGED: usize = 2;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct CgOptions<'a> {
    /// The part of the flux, and of the irradiance, that may be missing: the [rule](super#tolerance) that all
    /// iterations share. 0 asks for all that rounding leaves.
    pub tolerance: f64,
    /// The most passes over the matrix.
    pub iterations: usize,
    /// What [`Amplification::new`] says of the operator, where that is known already.
    pub amplification: Option<&'a Amplification>,
    /// Where to report progress, as stage `solve`.
    pub progress: Progress<'a>,
}

impl Default for CgOptions<'_> {
    /// A tolerance of 10⁻⁶ within 5000 passes.
    fn default() -> Self {
        Self { tolerance: 1e-6, iterations: krylov::MOST, amplification: None, progress: Progress::default() }
    }
}

/// Solves L = E + K L by conjugate gradients, or by MINRES where sheets let through more than they reflect.
///
/// Iterations go by a residual that they carry along. When it is small enough the true residual is computed
/// anew, and where that does not fulfil the rule yet, what is left is solved for in the same way.
///
/// # Errors
/// `NotConverged`, with the best iterate, `NotFinite`, or `Cancelled`.
///
/// # Panics
/// If `e` is not N × c.
pub fn conjugate_gradients(
    k: &Transport,
    e: &DMatrix<f64>,
    options: &CgOptions,
) -> Result<Solution, SolveError> {
    assert_eq!(e.shape(), (k.len(), k.channels()), "the right-hand side is N × c");
    check_finite(k, e)?;
    let &CgOptions { tolerance, iterations, progress, .. } = options;
    let amplification = Amplification::known_or_new(options.amplification, k, progress)?;
    let rule = Rule::new(k, e, &amplification, tolerance);
    let root = Root::new(k);
    let mut through = DMatrix::zeros(k.len(), k.channels());
    k.through(e, &mut through);
    let mut direct = through.clone();
    k.mass().solve(&mut direct, PI);
    let (reflected, mut passes) =
        krylov::iterate(&root, &through, rule.goals(&direct), Limits { passes: iterations, progress })?;
    let mut answer = Answer::after(k, e, &reflected);
    let mut excess = rule.excess(&answer);
    while excess > 1.0 && passes + JUDGED < iterations {
        k.through(&answer.residual, &mut through);
        let left = Limits { passes: iterations - passes - JUDGED, progress };
        let (more, taken) = krylov::iterate(&root, &through, rule.goals(&answer.irradiance), left)?;
        let reflected = &answer.reflected + &answer.residual + more;
        passes += taken + JUDGED;
        let refined = Answer::after(k, e, &reflected);
        let (before, now) = (excess, rule.excess(&refined));
        if now < before {
            (answer, excess) = (refined, now);
        }
        if now > STUCK * before {
            break;
        }
    }
    let has_converged = excess <= 1.0 || rule.is_rounding(&answer);
    let report = answer.judge(k, e, Run { name: root.method(), iterations: passes }, &amplification);
    let radiance = e + answer.reflected;
    let solution = Solution { radiance, irradiance: answer.irradiance, basis: k.basis(), report };
    progress.at("solve", 1.0)?;
    check_finite(k, &solution.radiance)?;
    if !has_converged {
        return Err(SolveError::NotConverged { best: Box::new(solution), tolerance });
    }
    Ok(solution)
}
