//! Conjugate gradients on the symmetric form of the radiosity equation (Hestenes & Stiefel 1952).
//!
//! With R = √ρ M^(−½), y = R S L solves (I − R S R) y = R S E, which is symmetric positive definite; then
//! L = E + R y. All channels go through the matrix in one pass. Sheets that let through more than they reflect make the form indefinite; there
//! MINRES takes its place, under the same options.

use nalgebra::DMatrix;

use super::symmetric::{self, Root, Target};
use super::{Amplification, Solution, SolveError, finish};
use crate::progress::Progress;
use crate::transport::Transport;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct CgOptions<'a> {
    /// Relative residual ‖E − (I − K)L‖∞ / ‖E‖∞ to reach.
    pub tolerance: f64,
    /// The most passes over the matrix.
    pub iterations: usize,
    /// What [`Amplification::new`] says of the operator, where that is known already.
    pub amplification: Option<&'a Amplification>,
    /// Where to report progress, as stage `solve`.
    pub progress: Progress<'a>,
}

impl Default for CgOptions<'_> {
    /// A residual of 10⁻⁶ within 5000 passes.
    fn default() -> Self {
        Self { tolerance: 1e-6, iterations: 5000, amplification: None, progress: Progress::default() }
    }
}

/// Solves L = E + K L by conjugate gradients, or by MINRES where sheets let through more than they reflect.
///
/// # Errors
/// `NotConverged`, with the best iterate, or `Cancelled`.
///
/// # Panics
/// If `e` is not N × c.
pub fn conjugate_gradients(
    k: &Transport,
    e: &DMatrix<f64>,
    options: &CgOptions,
) -> Result<Solution, SolveError> {
    let amplification = Amplification::known_or_new(options.amplification, k, options)?;
    let (radiance, iterations, name) = symmetric::iterate(k, e, options)?;
    let solution = finish(k, e, &radiance, (name, iterations), &amplification);
    options.progress.at("solve", 1.0)?;
    if solution.report.residual > options.tolerance {
        return Err(SolveError::NotConverged { best: Box::new(solution), tolerance: options.tolerance });
    }
    Ok(solution)
}

/// The radiance L = E + K L to a relative residual, without judging it.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn roughly(k: &Transport, e: &DMatrix<f64>, tolerance: f64) -> Result<DMatrix<f64>, SolveError> {
    Ok(symmetric::iterate(k, e, &CgOptions { tolerance, ..Default::default() })?.0)
}

/// Iterates until the residual of L = E + R y is small in every channel; answers L and the number of passes.
pub(super) fn iterate(
    root: &Root,
    k: &Transport,
    e: &DMatrix<f64>,
    options: &CgOptions,
) -> Result<(DMatrix<f64>, usize), SolveError> {
    let (n, channels) = e.shape();
    assert_eq!((n, channels), (k.len(), k.channels()), "the right-hand side is N × c");
    let mut target = Target::new(e, options.tolerance);
    let mut through = DMatrix::zeros(n, channels);
    k.through(e, &mut through);
    let mut passes = 1;
    let mut r = root.transposed_times(&through);
    let mut y = DMatrix::zeros(n, channels);
    let mut p = r.clone();
    let mut rr: Vec<f64> = r.column_iter().map(|column| column.norm_squared()).collect();
    while passes < options.iterations {
        // The residual of L is R r, for J = I.
        let offs: Vec<f64> = root.times(&r).column_iter().map(|column| column.amax()).collect();
        if target.is_reached(&offs) {
            break;
        }
        target.report(&offs, options.progress)?;
        // q = (I − RᵀSR) p
        k.through(&root.times(&p), &mut through);
        passes += 1;
        let q = &p - root.transposed_times(&through);
        for c in 0..channels {
            let curvature = p.column(c).dot(&q.column(c));
            if target.is_met(c, offs[c]) || curvature <= 0.0 {
                continue;
            }
            let alpha = rr[c] / curvature;
            y.column_mut(c).axpy(alpha, &p.column(c), 1.0);
            r.column_mut(c).axpy(-alpha, &q.column(c), 1.0);
            let next = r.column(c).norm_squared();
            let beta = next / rr[c];
            rr[c] = next;
            p.column_mut(c).axpy(1.0, &r.column(c), beta);
        }
    }
    Ok((e + root.times(&y), passes))
}
