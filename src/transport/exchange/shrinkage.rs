//! Shrinkage: keeps noise from making light out of nothing.
//!
//! A bounce must not add energy: the eigenvalues of M^(−½) S M^(−½) lie between −1 and 1. For constant
//! elements S ≥ 0 and closed rows see to that. For linear ones they only do so with M·1 in the place of M,
//! which is four times M for what varies within patches; where rays are few, or patches wide beside the gap
//! to what they face, noise may carry eigenvalues over 1.
//!
//! With T = J/3 + τ (I − J/3) on every patch, which takes what varies within it by the factor τ, T S T is as
//! symmetric, non-negative and closed as S is. For τ = ½ it never exceeds M, since T diag(M·1) T = M; for τ =
//! 1 nothing is lost. So the largest τ between the two is taken that does; with enough rays it is 1.

use nalgebra::{DMatrix, DVector};

use super::mass::{Mass, shrink};
use super::storage::Storage;
use crate::progress::{Cancelled, Progress};
use crate::transport::lanczos::{ends_of_spectrum, uneven};

/// Eigenvalues may exceed 1 by so much.
const SLACK: f64 = 1e-7;

/// What varies is taken by no less than this factor.
const LEAST: f64 = 0.5;

/// The largest τ for which no eigenvalue of M^(−½) T S T M^(−½) is *estimated* to lie outside of ±1, and no
/// less than ½, for which that is *guaranteed*; S = D `storage` D.
pub fn needed(
    storage: &Storage,
    scale: &DVector<f64>,
    mass: &Mass,
    progress: Progress,
) -> Result<f64, Cancelled> {
    let sums = mass.sums();
    // What is the same everywhere keeps its eigenvalue whatever τ: leave it out.
    let even = sums.map(f64::sqrt).normalize();
    let mut start = DVector::from_iterator(mass.len(), uneven(mass.len()));
    start.axpy(-start.dot(&even), &even, 1.0);
    let start = DMatrix::from_column_slice(mass.len(), 1, start.as_slice());
    let mut tau = 1.0;
    while tau > LEAST {
        let half = |x: &mut DMatrix<f64>| {
            shrink(x.as_mut_slice(), tau);
            mass.inverse_root(x.as_mut_slice());
        };
        let ends = ends_of_spectrum(start.clone(), |x| {
            progress.at("balance", 0.99)?;
            let mut x = x.clone();
            half(&mut x);
            x.column_mut(0).zip_zip_apply(scale, sums, |x, scale, sum| *x *= scale / sum.sqrt());
            let mut y = DMatrix::zeros(x.nrows(), 1);
            storage.multiply(&x, &mut y);
            y.column_mut(0).zip_zip_apply(scale, sums, |y, scale, sum| *y *= scale / sum.sqrt());
            half(&mut y);
            Ok(y)
        })?;
        let [least, greatest] = ends[0];
        let most = greatest.max(-least);
        if most <= 1.0 + SLACK {
            break;
        }
        // What only varies would now fit.
        tau = (0.95 * tau / most.sqrt()).max(LEAST);
    }
    Ok(tau)
}
