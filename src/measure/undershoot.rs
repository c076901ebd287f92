//! Undershoot: how far a field of linear elements falls below zero, where light itself never does.
//!
//! Beside a shadow's edge the straight line that fits a patch best may pass below zero at a corner. The
//! patch's mean, and the energy balance, are not touched by that.

use nalgebra::DMatrix;
use serde::Serialize;

use crate::transport::Mass;

/// How far a field falls below zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Undershoot {
    /// Share of the area whose patches have a corner below zero in some channel.
    pub share: f64,
    /// The lowest value below zero, relative to the highest of its channel; the largest over channels.
    pub depth: f64,
}

impl Undershoot {
    /// Looks at a field (N × c) of basis functions of this mass.
    ///
    /// # Panics
    /// If `field` has not N rows.
    pub fn of(mass: &Mass, field: &DMatrix<f64>) -> Self {
        assert_eq!(field.nrows(), mass.len(), "one row per coefficient");
        let each = mass.basis().coefficients();
        let below = |i: usize| field.rows(each * i, each).iter().any(|&x| x < 0.0);
        let area = |i: usize| mass.sums().rows(each * i, each).sum();
        let low: f64 = (0..mass.len() / each).filter(|&i| below(i)).map(area).sum();
        let depth = |c: usize| match (field.column(c).min(), field.column(c).max()) {
            (least, most) if least < 0.0 && most > 0.0 => -least / most,
            _ => 0.0,
        };
        let share = if low > 0.0 { low / mass.sums().sum() } else { 0.0 };
        Self { share, depth: (0..field.ncols()).map(depth).fold(0.0, f64::max) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::Basis;

    #[test]
    fn depth_and_share_are_those_of_the_patches_below_zero() {
        let mass = Mass::new(Basis::Linear, &[1.0, 3.0]);
        let field = DMatrix::from_column_slice(6, 1, &[1.0, -0.5, 2.0, 1.0, 0.0, 4.0]);
        assert_eq!(Undershoot::of(&mass, &field), Undershoot { share: 0.25, depth: 0.125 });
        assert_eq!(Undershoot::of(&mass, &field.map(f64::abs)), Undershoot { share: 0.0, depth: 0.0 });
    }
}
