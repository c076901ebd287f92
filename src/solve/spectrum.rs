//! Spectrum: the largest eigenvalue of R S R, estimated by Lanczos' method (1950).

use nalgebra::{DMatrix, DVector};

use super::SolveError;
use super::symmetric::Root;
use crate::progress::Progress;
use crate::transport::Transport;

/// Passes over the matrix. An eigenvalue at the end of the spectrum settles within some tens.
const STEPS: usize = 40;

/// The largest eigenvalue of R S R per channel, from below: *estimated*.
pub(super) fn largest_eigenvalue(k: &Transport, progress: Progress) -> Result<Vec<f64>, SolveError> {
    let root = Root::new(k);
    let (n, channels) = (k.len(), k.channels());
    // Start near what is even and lasts longest, but leave nothing out.
    let mut state = 1u64;
    let mut now = DMatrix::from_fn(n, channels, |i, _| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        k.mass().sums()[i].sqrt() * (0.5 + (state >> 11) as f64 / (1u64 << 53) as f64)
    });
    now.column_iter_mut().for_each(|mut column| {
        column.normalize_mut();
    });
    let mut before = DMatrix::zeros(n, channels);
    let mut through = DMatrix::zeros(n, channels);
    let mut diagonals: Vec<Vec<f64>> = vec![Vec::new(); channels];
    let mut beside: Vec<Vec<f64>> = vec![Vec::new(); channels];
    for step in 0..STEPS.min(n) {
        progress.at("solve", 0.0)?;
        k.exchange().apply(&root.times(&now), &mut through);
        let mut next = root.times(&through);
        for c in 0..channels {
            let diagonal = now.column(c).dot(&next.column(c));
            next.column_mut(c).axpy(-diagonal, &now.column(c), 1.0);
            if step > 0 {
                next.column_mut(c).axpy(-beside[c][step - 1], &before.column(c), 1.0);
            }
            let length = next.column(c).norm();
            diagonals[c].push(diagonal);
            beside[c].push(length);
            // A space that is exhausted is continued by zero, which adds eigenvalue 0.
            next.column_mut(c).scale_mut(if length > 1e-12 { 1.0 / length } else { 0.0 });
        }
        before = std::mem::replace(&mut now, next);
    }
    let largest = |c: usize| {
        let steps = diagonals[c].len();
        let matrix = DMatrix::from_fn(steps, steps, |i, j| match i.abs_diff(j) {
            0 => diagonals[c][i],
            1 => beside[c][i.min(j)],
            _ => 0.0,
        });
        let values: DVector<f64> = matrix.symmetric_eigenvalues();
        values.max().max(0.0)
    };
    Ok((0..channels).map(largest).collect())
}
