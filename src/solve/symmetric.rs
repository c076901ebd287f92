//! The symmetric form of the radiosity equation.
//!
//! With R = √ρ M^(−½), which is symmetric and works on each patch by itself, y = R S L solves (I − R S R) y = R S E; then
//! L = E + R y. The matrix is symmetric, unit-scaled whatever the areas, indifferent to ρ = 0, and positive definite. For constant
//! elements R is a diagonal, √(ρ/A).

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::patches::Basis;
use crate::transport::Transport;

/// R = √ρ M^(−½).
#[derive(Debug)]
pub(super) struct Root<'k> {
    k: &'k Transport<'k>,
    /// √(ρ / M·1), N × c.
    scale: DMatrix<f64>,
}

impl<'k> Root<'k> {
    pub fn new(k: &'k Transport<'k>) -> Self {
        let mut scale = k.reflectance().clone();
        for mut column in scale.column_iter_mut() {
            column.zip_apply(k.mass().sums(), |rho, sum| *rho = (*rho / sum).sqrt());
        }
        Self { k, scale }
    }

    /// R x.
    pub fn times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut product = self.scale.component_mul(x);
        product.column_iter_mut().for_each(|mut column| self.k.mass().inverse_root(column.as_mut_slice()));
        product
    }

    /// I − R S R in one channel.
    pub fn matrix(&self, channel: usize) -> DMatrix<f64> {
        let (n, each, s) = (self.k.len(), self.k.basis().coefficients(), self.scale.column(channel));
        let mut matrix = DMatrix::zeros(n, n);
        matrix.as_mut_slice().par_chunks_mut(each * n).enumerate().for_each(|(patch, columns)| {
            for (a, column) in columns.chunks_mut(n).enumerate() {
                let j = each * patch + a;
                self.k.exchange_of(channel).for_row(j, |i, exchange| column[i] -= s[i] * exchange * s[j]);
                // From the left ...
                self.k.mass().inverse_root(column);
            }
            // ... and from the right.
            if self.k.basis() == Basis::Linear {
                let mut across = [0.0; 3];
                for i in 0..n {
                    (0..3).for_each(|a| across[a] = columns[a * n + i]);
                    self.k.mass().inverse_root(&mut across);
                    (0..3).for_each(|a| columns[a * n + i] = across[a]);
                }
            }
            (0..each).for_each(|a| columns[a * n + each * patch + a] += 1.0);
        });
        matrix
    }
}
