//! Basis: how a field varies over a patch, and so what the entries of a vector are.
//!
//! A field is Σ x_ia φ_a over the coefficients a of every patch i. Coefficients of a patch follow one
//! another, patches come in their order, and basis functions are non-negative and sum to 1: a field whose
//! coefficients are all 1 is 1 everywhere.

use nalgebra::DMatrix;

use crate::patches::Patches;

/// How a field varies over a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Basis {
    /// Not at all: one coefficient, the field's value.
    #[default]
    Constant,
    /// Linearly, and free to jump from patch to patch: three coefficients, the field's values at the patch's
    /// corners in the order of [`Patches::corners`](crate::patches::Patches::corners).
    Linear,
}

impl Basis {
    /// Number of coefficients a patch.
    pub fn coefficients(self) -> usize {
        match self {
            Self::Constant => 1,
            Self::Linear => 3,
        }
    }

    /// The basis of a field over n patches: a row each is constant, three rows are linear.
    ///
    /// # Panics
    /// If `field` has neither n nor 3n rows.
    pub fn of(patches: &Patches, field: &DMatrix<f64>) -> Self {
        let (n, rows) = (patches.len(), field.nrows());
        let fits = |basis: &Self| basis.coefficients() * n == rows;
        let basis = [Self::Constant, Self::Linear].into_iter().find(fits);
        basis.unwrap_or_else(|| panic!("{rows} rows are no field over {n} patches"))
    }

    /// `constant` or `linear`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
        }
    }

    /// The coefficients of a field that has one value per patch (n × c).
    pub fn coefficients_of(self, values: &DMatrix<f64>) -> DMatrix<f64> {
        let each = self.coefficients();
        DMatrix::from_fn(each * values.nrows(), values.ncols(), |k, c| values[(k / each, c)])
    }

    /// The mean over each patch (n × c) of a field given by its coefficients.
    ///
    /// # Panics
    /// If the number of rows is no multiple of the coefficients a patch.
    pub fn means(self, field: &DMatrix<f64>) -> DMatrix<f64> {
        let each = self.coefficients();
        assert_eq!(field.nrows() % each, 0, "{each} coefficients a patch");
        let mean = |i: usize, c: usize| field.view((each * i, c), (each, 1)).sum() / each as f64;
        DMatrix::from_fn(field.nrows() / each, field.ncols(), mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::{Patches, Tessellation};
    use crate::scene::Scene;
    use crate::trace::Tracer;

    #[test]
    fn the_number_of_rows_tells_the_basis() {
        let scene = Scene::cornell_box();
        let patches = Patches::new(&Tracer::new(&scene), &Tessellation::default()).unwrap();
        for basis in [Basis::Constant, Basis::Linear] {
            assert_eq!(Basis::of(&patches, &basis.coefficients_of(&patches.emitted_radiance())), basis);
        }
    }

    #[test]
    #[should_panic(expected = "no field over")]
    fn refuses_fields_of_other_patches() {
        let scene = Scene::cornell_box();
        let patches = Patches::new(&Tracer::new(&scene), &Tessellation::default()).unwrap();
        Basis::of(&patches, &DMatrix::zeros(2 * patches.len(), 3));
    }
}
