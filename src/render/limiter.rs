//! Limiter: a field of linear elements made fit to be seen, x_a ← m + θ (x_a − m) with m the patch's mean.
//!
//! Beside a shadow's edge the straight line that fits a patch best may pass below zero at a corner, or come
//! near it: black spots where light only fades. Such a patch keeps its mean and is tilted less, by the
//! largest θ ≤ 1 at which no corner is darker than [`DARKEST`]; the scaling limiter of Zhang & Shu (2010)
//! with another floor. All others stay as they were solved.

use std::borrow::Cow;

use nalgebra::DMatrix;

use crate::patches::Basis;

/// The darkest that a corner is shown, as a share of its patch's mean. At a twentieth spots still look black,
/// at two fifths patches look flat.
const DARKEST: f64 = 0.2;

/// The field as it is shown, by coefficients (N × c). Constant elements are shown as they are.
pub(crate) fn limited(basis: Basis, field: &DMatrix<f64>) -> Cow<'_, DMatrix<f64>> {
    if basis == Basis::Constant {
        return Cow::Borrowed(field);
    }
    let mut limited = field.clone();
    for patch in limited.as_mut_slice().chunks_exact_mut(basis.coefficients()) {
        limit(patch);
    }
    Cow::Owned(limited)
}

/// Limits one patch in one channel.
fn limit(corners: &mut [f64]) {
    let mean = corners.iter().sum::<f64>() / corners.len() as f64;
    let lowest = corners.iter().copied().fold(f64::INFINITY, f64::min);
    if lowest >= DARKEST * mean {
        return;
    }
    // Light itself is not negative: what is dark on the whole is black.
    let mean = mean.max(0.0);
    let tilt = (1.0 - DARKEST) * mean / (mean - lowest);
    corners.iter_mut().for_each(|x| *x = (mean + tilt * (*x - mean)).max(0.0));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(corners: [f64; 3]) -> [f64; 3] {
        let field = DMatrix::from_column_slice(3, 1, &corners);
        let shown = limited(Basis::Linear, &field);
        [shown[0], shown[1], shown[2]]
    }

    #[test]
    fn patches_with_light_at_every_corner_stay_as_they_are() {
        for corners in [[1.0, 2.0, 3.0], [0.0; 3], [0.2, 1.0, 0.4], [7.0; 3]] {
            assert_eq!(shown(corners), corners);
        }
    }

    #[test]
    fn a_patch_below_zero_keeps_its_mean_and_has_light_everywhere() {
        for corners in [[-1.0, 2.0, 5.0], [-1.0, -1.0, 2.01], [0.0, 1.0, 1.0], [3.0, -1e-9, 0.2]] {
            let shown = shown(corners);
            let [before, after] = [corners, shown].map(|x| x.iter().sum::<f64>() / 3.0);
            let lowest = shown.into_iter().fold(f64::INFINITY, f64::min);
            assert!((after / before - 1.0).abs() < 1e-12, "{corners:?} {shown:?}");
            assert!((lowest / (DARKEST * before) - 1.0).abs() < 1e-12, "{corners:?} {shown:?}");
        }
    }

    #[test]
    fn a_patch_whose_mean_is_below_zero_is_black() {
        assert_eq!(shown([-1.0, 0.5, 0.2]), [0.0; 3]);
        assert_eq!(shown([-1.0; 3]), [0.0; 3]);
    }
}
