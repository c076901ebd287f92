//! Symmetric systems, solved by conjugate gradients (Hestenes & Stiefel 1952), several right-hand sides in
//! the same passes.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVectorView};

/// A symmetric system A x = b, as the iteration sees it: N × C values, a column for each right-hand side.
pub(crate) trait SymmetricSystem {
    type Error;

    /// A p.
    fn times(&mut self, p: &DMatrix<f64>) -> DMatrix<f64>;

    /// Whether each column is to go on, by its residual r = b − A x and by rᵀz. The iteration ends when none
    /// is.
    fn goes_on(&mut self, r: &DMatrix<f64>, rz: &[f64]) -> Result<Vec<bool>, Self::Error>;

    /// z, the residual divided by what is like A and easy to divide by; here by 1.
    fn preconditioned<'r>(&self, r: &'r DMatrix<f64>) -> Cow<'r, DMatrix<f64>> {
        Cow::Borrowed(r)
    }

    /// Where pᵀAp is no more than this, A is not positive definite along p as far as can be told.
    fn least_curvature(&self, _p: DVectorView<f64>) -> f64 {
        0.0
    }

    /// How many times p a column goes on along such a p, before it ends there.
    fn last_step(&self, _p: DVectorView<f64>) -> f64 {
        0.0
    }
}

/// Solves by conjugate gradients from x = 0 on; answers x.
///
/// # Errors
/// Those of [`SymmetricSystem::goes_on`].
pub(crate) fn solve_symmetric<S: SymmetricSystem>(
    system: &mut S,
    b: DMatrix<f64>,
) -> Result<DMatrix<f64>, S::Error> {
    let (n, columns) = b.shape();
    let mut x = DMatrix::zeros(n, columns);
    let mut r = b;
    let mut p = system.preconditioned(&r).into_owned();
    let mut rz: Vec<f64> = (0..columns).map(|c| r.column(c).dot(&p.column(c))).collect();
    let mut has_ended = vec![false; columns];
    loop {
        let mut goes_on = system.goes_on(&r, &rz)?;
        goes_on.iter_mut().zip(&has_ended).for_each(|(goes_on, ended)| *goes_on &= !ended);
        if !goes_on.contains(&true) {
            return Ok(x);
        }
        let q = system.times(&p);
        for (c, goes_on) in goes_on.iter_mut().enumerate().filter(|(_, goes_on)| **goes_on) {
            let along = p.column(c);
            let curvature = along.dot(&q.column(c));
            *goes_on = curvature > system.least_curvature(along);
            has_ended[c] = !*goes_on;
            let length = if *goes_on { rz[c] / curvature } else { system.last_step(along) };
            x.column_mut(c).axpy(length, &along, 1.0);
            if *goes_on {
                r.column_mut(c).axpy(-length, &q.column(c), 1.0);
            }
        }
        if !goes_on.contains(&true) {
            return Ok(x);
        }
        // The next direction is A-conjugate to all before it.
        let z = system.preconditioned(&r);
        for c in (0..columns).filter(|&c| goes_on[c]) {
            let next = r.column(c).dot(&z.column(c));
            p.column_mut(c).axpy(1.0, &z.column(c), next / rz[c]);
            rz[c] = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    /// A dense matrix, the size of its diagonal as what is easy to divide by.
    struct Dense {
        matrix: DMatrix<f64>,
        passes: usize,
    }

    impl SymmetricSystem for Dense {
        type Error = Infallible;

        fn times(&mut self, p: &DMatrix<f64>) -> DMatrix<f64> {
            self.passes += 1;
            &self.matrix * p
        }

        fn goes_on(&mut self, _r: &DMatrix<f64>, rz: &[f64]) -> Result<Vec<bool>, Infallible> {
            Ok(rz.iter().map(|rz| *rz > 1e-24 && self.passes < 40).collect())
        }

        fn preconditioned<'r>(&self, r: &'r DMatrix<f64>) -> Cow<'r, DMatrix<f64>> {
            Cow::Owned(r.map_with_location(|i, _, r| r / self.matrix[(i, i)].abs()))
        }

        fn last_step(&self, _p: DVectorView<f64>) -> f64 {
            1.0
        }
    }

    #[test]
    fn systems_of_n_unknowns_are_solved_in_n_steps() {
        let n = 12;
        let uneven: Vec<f64> = crate::transport::uneven(n * n).collect();
        let root = DMatrix::from_column_slice(n, n, &uneven);
        let matrix: DMatrix<f64> = &root * root.transpose() + 5.0 * DMatrix::identity(n, n);
        let b = DMatrix::from_fn(n, 3, |i, c| (i as f64 - 3.0) * (c as f64 + 0.5));
        let mut system = Dense { matrix: matrix.clone(), passes: 0 };
        let Ok(x) = solve_symmetric(&mut system, b.clone());
        assert!(system.passes <= n + 1, "{}", system.passes);
        assert!((matrix * x - &b).amax() < 1e-10 * b.amax());
    }

    #[test]
    fn a_column_without_curvature_ends_after_its_last_step_and_leaves_others_alone() {
        let matrix = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![2.0, -1.0]));
        let b = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 3.0]);
        let Ok(x) = solve_symmetric(&mut Dense { matrix, passes: 0 }, b);
        // The second column's first direction is b, along which A curves downwards.
        assert_eq!(x, DMatrix::from_row_slice(2, 2, &[0.5, 0.0, 0.0, 3.0]));
    }
}
