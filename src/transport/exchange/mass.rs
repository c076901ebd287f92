//! Mass: the matrix M_(ia)(ib) = ∫ φ_a φ_b dA of the basis functions, one small block per patch.
//!
//! A for constant elements. For linear ones A/12 (J + I) with J the matrix of ones; its eigenvalues are A/3
//! (once, for what is constant) and A/12 (twice, for what varies), so that M⁻¹ = 3/A (4I − J) and M^(−½) =
//! √(12/A) (I − J/6). All of it follows from the basis and from M·1, the vector of A or of A/3.

use nalgebra::{DMatrix, DVector, DVectorView};

use crate::patches::{Basis, Patches};

/// The mass matrix of n patches' basis functions.
///
/// Inside the library it is kept in a unit of area of its own, that of the frame in which rays are traced;
/// so are the exchange areas that go with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Mass {
    basis: Basis,
    /// M·1, per coefficient.
    sums: DVector<f64>,
    /// The unit of area, m².
    unit: f64,
}

impl Mass {
    /// The mass of patches of these areas, m².
    pub fn new(basis: Basis, areas: &[f64]) -> Self {
        Self::in_units(basis, areas, 1.0)
    }

    /// The mass of a scene's patches, by étendue.
    pub(crate) fn of(basis: Basis, patches: &Patches) -> Self {
        Self::in_units(basis, patches.normalised_etendues(), patches.unit_of_area())
    }

    /// The mass of a scene's patches by area, for what arrives on them.
    pub(crate) fn of_areas(basis: Basis, patches: &Patches) -> Self {
        Self::in_units(basis, patches.normalised_areas(), patches.unit_of_area())
    }

    /// The mass of patches of areas in some unit of so many m².
    fn in_units(basis: Basis, areas: &[f64], unit: f64) -> Self {
        let each = basis.coefficients();
        let sums = DVector::from_fn(each * areas.len(), |k, _| areas[k / each] / each as f64);
        Self { basis, sums, unit }
    }

    /// The mass of constant elements on groups of patches, each of this area in the unit of this mass.
    pub(crate) fn of_groups(&self, areas: DVector<f64>) -> Self {
        Self { basis: Basis::Constant, sums: areas, unit: self.unit }
    }

    /// The same in m².
    pub(crate) fn in_square_metres(self) -> Self {
        Self { basis: self.basis, sums: self.sums * self.unit, unit: 1.0 }
    }

    /// M·1, m²: areas A for constant elements, a third of them three times each for linear ones.
    pub fn areas(&self) -> DVector<f64> {
        &self.sums * self.unit
    }

    /// Root mean square of a field over all patches: √(xᵀ M x / Σ M).
    ///
    /// # Panics
    /// If `x` has not N entries.
    pub fn root_mean_square(&self, x: DVectorView<f64>) -> f64 {
        (self.norm(x).powi(2) / self.sums.sum().max(f64::MIN_POSITIVE)).sqrt()
    }

    /// The unit of area, m².
    pub(crate) fn unit(&self) -> f64 {
        self.unit
    }

    /// Which basis functions.
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// M·1, the integral of every basis function, by which coefficients sum up to an integral; in its unit.
    pub(crate) fn sums(&self) -> &DVector<f64> {
        &self.sums
    }

    /// Number of coefficients N.
    pub fn len(&self) -> usize {
        self.sums.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sums.is_empty()
    }

    /// x ← f M⁻¹ x for N × c matrices, in its unit.
    ///
    /// # Panics
    /// If `x` has not N rows.
    pub(crate) fn solve(&self, x: &mut DMatrix<f64>, factor: f64) {
        for mut column in x.column_iter_mut() {
            if self.basis == Basis::Linear {
                for_each_triple(column.as_mut_slice(), |[a, b, c]| {
                    let sum = a + b + c;
                    [a, b, c].map(|x| 4.0 * x - sum)
                });
            }
            column.zip_apply(&self.sums, |x, sum| *x *= factor / sum);
        }
    }

    /// √(xᵀ M x), the root of the field's squared integral, in its unit.
    ///
    /// # Panics
    /// If `x` has not N entries.
    pub(crate) fn norm(&self, x: DVectorView<f64>) -> f64 {
        let squares = |k: usize| match self.basis {
            Basis::Constant => self.sums[k] * x[k] * x[k],
            Basis::Linear => {
                let triple = 3 * (k / 3);
                0.25 * self.sums[k] * x[k] * (x[k] + x[triple] + x[triple + 1] + x[triple + 2])
            }
        };
        (0..x.len()).map(squares).sum::<f64>().max(0.0).sqrt()
    }

    /// M^(−½) but for its scale 1/√(M·1): x ← √(M·1) M^(−½) x, for one column.
    pub(crate) fn inverse_root(&self, x: &mut [f64]) {
        if self.basis == Basis::Linear {
            for_each_triple(x, |[a, b, c]| {
                let sixth = (a + b + c) / 6.0;
                [a, b, c].map(|x| 2.0 * (x - sixth))
            });
        }
    }
}

impl From<DVector<f64>> for Mass {
    /// The mass of constant elements on patches of these areas, m².
    fn from(areas: DVector<f64>) -> Self {
        Self { basis: Basis::Constant, sums: areas, unit: 1.0 }
    }
}

/// Replaces the coefficients of every patch, three each.
fn for_each_triple(x: &mut [f64], f: impl Fn([f64; 3]) -> [f64; 3]) {
    for triple in x.chunks_exact_mut(3) {
        triple.copy_from_slice(&f([triple[0], triple[1], triple[2]]));
    }
}

/// x ← T x.
pub fn shrink(x: &mut [f64], tau: f64) {
    for triple in x.chunks_exact_mut(3) {
        let mean = (triple[0] + triple[1] + triple[2]) / 3.0;
        triple.iter_mut().for_each(|x| *x = mean + tau * (*x - mean));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::triangle;
    use crate::trace::sampling::{Stream, uniform_triangle};

    /// M of one patch of area 1 by sampling.
    fn sampled() -> DMatrix<f64> {
        let points = 1 << 14;
        let mut mass = DMatrix::zeros(3, 3);
        for k in 0..points {
            let [s, t, ..] = Stream::Callers.sequence(3, 1, 4).point(k);
            let phi = DVector::from_row_slice(&triangle::weights(uniform_triangle([s, t])));
            mass += &phi * phi.transpose() / points as f64;
        }
        mass
    }

    fn identity() -> DMatrix<f64> {
        DMatrix::identity(3, 3)
    }

    #[test]
    fn solving_inverts_the_integrals_of_products() {
        let mass = Mass::new(Basis::Linear, &[1.0]);
        let mut product = sampled();
        mass.solve(&mut product, 1.0);
        assert!((product - identity()).amax() < 1e-3);
        let mut sums = DMatrix::from_column_slice(3, 1, mass.sums().as_slice());
        mass.solve(&mut sums, 2.5);
        assert!((sums - DMatrix::repeat(3, 1, 2.5)).amax() < 1e-15);
    }

    #[test]
    fn the_inverse_root_squared_is_the_inverse() {
        let mass = Mass::new(Basis::Linear, &[0.7]);
        let (mut root, mut inverse) = (identity(), identity());
        for mut column in root.column_iter_mut() {
            mass.inverse_root(column.as_mut_slice());
            column /= mass.sums()[0].sqrt();
        }
        mass.solve(&mut inverse, 1.0);
        assert!((&root * &root - inverse).amax() < 1e-13);
        assert_eq!(root, root.transpose());
    }

    #[test]
    fn the_norm_is_the_root_of_the_integral_of_the_square() {
        let x = DVector::from_row_slice(&[1.0, -0.5, 2.0]);
        let integral = (x.transpose() * sampled() * &x)[0];
        let norm = Mass::new(Basis::Linear, &[1.0]).norm(x.as_view());
        assert!((norm - integral.sqrt()).abs() < 1e-4);
        assert_eq!(Mass::from(DVector::repeat(1, 4.0)).norm(DVector::repeat(1, -3.0).as_view()), 6.0);
    }
}
