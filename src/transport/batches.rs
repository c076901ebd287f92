//! Batches: what the spread between batches of rays tells of their mean.

use nalgebra::DMatrix;

/// The variance of a linear function of the mean of batches whose own mean is zero, in the square of its
/// unit; 0 where there are none.
pub(crate) fn variance_of_mean(batches: &[DMatrix<f64>], of: impl Fn(&DMatrix<f64>) -> f64) -> f64 {
    let count = batches.len() as f64;
    let squares: f64 = batches.iter().map(|batch| of(batch).powi(2)).sum();
    if batches.is_empty() { 0.0 } else { squares / (count * (count - 1.0)) }
}
