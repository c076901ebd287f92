//! Krylov iterations on the symmetric form of the radiosity equation: conjugate gradients (Hestenes & Stiefel
//! 1952) where it is positive definite, else MINRES.

use nalgebra::DMatrix;

use super::goals::{Goals, Limits};
use super::symmetric::Root;
use super::{SolveError, minres};
use crate::progress::Progress;
use crate::transport::{SymmetricSystem, Transport, solve_symmetric};

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
    let mut through = DMatrix::zeros(k.len(), k.channels());
    k.through(e, &mut through);
    let goals = Goals::relative(k, e, tolerance);
    let (reflected, _) = iterate(&Root::new(k), &through, goals, Limits { passes: MOST, progress })?;
    Ok(e + reflected)
}

/// Iterates on y until the residual of L = E + R y meets the goals, by conjugate gradients where the
/// symmetric form is positive definite and else by MINRES; answers R y, and the number of passes with that
/// for `through` = S E. They end, too, at the limits.
pub(super) fn iterate(
    root: &Root,
    through: &DMatrix<f64>,
    goals: Goals,
    limits: Limits,
) -> Result<(DMatrix<f64>, usize), SolveError> {
    if root.is_definite() {
        let b = root.transposed_times(through);
        let goals = goals.starting_from(&root.times(&b));
        let through = DMatrix::zeros(through.nrows(), through.ncols());
        let mut system = Definite { root, goals, through, passes: 1, limits };
        let y = solve_symmetric(&mut system, b)?;
        Ok((root.times(&y), system.passes))
    } else {
        minres::iterate(root, through, goals, limits)
    }
}

/// Conjugate gradients on (I − RᵀSR) y = RᵀSE.
struct Definite<'a> {
    root: &'a Root,
    goals: Goals<'a>,
    through: DMatrix<f64>,
    passes: usize,
    limits: Limits<'a>,
}

impl SymmetricSystem for Definite<'_> {
    type Error = SolveError;

    fn times(&mut self, p: &DMatrix<f64>) -> DMatrix<f64> {
        self.root.operator().through(&self.root.times(p), &mut self.through);
        self.passes += 1;
        p - self.root.transposed_times(&self.through)
    }

    fn goes_on(&mut self, r: &DMatrix<f64>, _rz: &[f64]) -> Result<Vec<bool>, SolveError> {
        if self.passes >= self.limits.passes {
            return Ok(vec![false; r.ncols()]);
        }
        // The residual of L is R r, for J = I.
        let excesses = self.goals.excesses(&self.root.times(r));
        let goes_on: Vec<bool> = excesses.iter().map(|&excess| excess > 1.0).collect();
        if goes_on.contains(&true) {
            self.goals.report(&excesses, self.limits.progress)?;
        }
        Ok(goes_on)
    }
}
