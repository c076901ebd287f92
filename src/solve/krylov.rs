//! Krylov iterations on the symmetric form of the radiosity equation: conjugate gradients (Hestenes & Stiefel
//! 1952) where it is positive definite, else MINRES.

use nalgebra::DMatrix;

use super::goals::Goals;
use super::symmetric::Root;
use super::{SolveError, minres};
use crate::progress::Progress;
use crate::transport::Transport;

/// The most passes over the matrix where none are asked for.
pub(super) const MOST: usize = 5000;

/// The radiance L = E + K L up to a residual that is this part of E in flux and in ‖·‖∞, without judging it.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn roughly(
    k: &Transport,
    e: &DMatrix<f64>,
    tolerance: f64,
    progress: Progress,
) -> Result<DMatrix<f64>, SolveError> {
    let iterations = MOST;
    let mut through = DMatrix::zeros(k.len(), k.channels());
    k.through(e, &mut through);
    let goals = Goals::relative(k, e, tolerance);
    let (reflected, _) = iterate(&Root::new(k), &through, goals, (iterations, progress))?;
    Ok(e + reflected)
}

/// Iterates on y until the residual of L = E + R y meets the goals, by conjugate gradients where the
/// symmetric form is positive definite and else by MINRES; answers R y, and the number of passes with that
/// for `through` = S E. They end, too, after so many passes.
pub(super) fn iterate(
    root: &Root,
    through: &DMatrix<f64>,
    goals: Goals,
    limits: (usize, Progress),
) -> Result<(DMatrix<f64>, usize), SolveError> {
    if root.is_definite() {
        conjugate(root, through, goals, limits)
    } else {
        minres::iterate(root, through, goals, limits)
    }
}

/// Conjugate gradients until the residual of L = E + R y meets the goals; answers R y and the number of passes, that for
/// `through` = S E among them.
fn conjugate(
    root: &Root,
    through: &DMatrix<f64>,
    goals: Goals,
    (iterations, progress): (usize, Progress),
) -> Result<(DMatrix<f64>, usize), SolveError> {
    let (n, channels) = through.shape();
    let mut r = root.transposed_times(through);
    // The residual of L is R r, for J = I.
    let mut goals = goals.starting_from(&root.times(&r));
    let mut through = DMatrix::zeros(n, channels);
    let mut passes = 1;
    let mut y = DMatrix::zeros(n, channels);
    let mut p = r.clone();
    let mut rr: Vec<f64> = r.column_iter().map(|column| column.norm_squared()).collect();
    while passes < iterations {
        let excesses = goals.excesses(&root.times(&r));
        if excesses.iter().all(|&excess| excess <= 1.0) {
            break;
        }
        goals.report(&excesses, progress)?;
        // q = (I − RᵀSR) p
        root.operator().through(&root.times(&p), &mut through);
        passes += 1;
        let q = &p - root.transposed_times(&through);
        let mut moved = false;
        for c in 0..channels {
            let curvature = p.column(c).dot(&q.column(c));
            if excesses[c] <= 1.0 || curvature <= 0.0 {
                continue;
            }
            moved = true;
            let alpha = rr[c] / curvature;
            y.column_mut(c).axpy(alpha, &p.column(c), 1.0);
            r.column_mut(c).axpy(-alpha, &q.column(c), 1.0);
            let next = r.column(c).norm_squared();
            let beta = next / rr[c];
            rr[c] = next;
            p.column_mut(c).axpy(1.0, &r.column(c), beta);
        }
        if !moved {
            break;
        }
    }
    Ok((root.times(&y), passes))
}
