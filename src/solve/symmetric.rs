//! The symmetric form of the radiosity equation.
//!
//! With R = √ρ M^(−½), which is symmetric and works on each patch by itself, y = R S L solves (I − R S R) y =
//! R S E; then L = E + R y. The matrix is symmetric, unit-scaled whatever the areas, indifferent to ρ = 0,
//! and positive definite. For constant elements R is a diagonal, √(ρ/A).
//!
//! On the two sides of a sheet, which have one mass, ρ becomes the block P = (ρ_front τ; τ ρ_back). With its
//! eigenvalues in P = V Λ Vᵀ, the signs J of these and R = V |Λ|^½ M^(−½), R J Rᵀ is P M⁻¹, and y = J Rᵀ S L
//! solves
//!
//! (J − Rᵀ S R) y = Rᵀ S E; then L = E + R y.
//!
//! All |λ| ≤ 1, as rows of P sum to no more, and the eigenvalues of M^(−½) S M^(−½) lie between −1 and 1. So
//! the matrix is positive definite on the unknowns of J = 1 and negative definite on those of J = −1, which
//! are there where τ² > ρ_front ρ_back: *quasi-definite*, with factors L D Lᵀ in any order of the unknowns
//! (Vanderbei 1995). Where no λ is negative, J = I and all is as without sheets.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::turns::Turns;
use crate::patches::Basis;
use crate::transport::Transport;

/// R = √ρ M^(−½), or V |Λ|^½ M^(−½) on sheets.
#[derive(Debug)]
pub(super) struct Root {
    k: Transport,
    /// √(|λ| / M·1), N × c; λ is ρ but on sheets.
    scale: DMatrix<f64>,
    turns: Option<Turns>,
}

impl Root {
    pub fn new(k: &Transport) -> Self {
        let turns = k.sheets().map(|sheets| Turns::new(k.reflectance(), sheets));
        let mut scale = turns.as_ref().map_or_else(|| k.reflectance().clone(), Turns::sizes);
        for mut column in scale.column_iter_mut() {
            column.zip_apply(k.mass().sums(), |rho, sum| *rho = (*rho / sum).sqrt());
        }
        Self { k: k.clone(), scale, turns }
    }

    /// The operator whose root this is.
    pub fn operator(&self) -> &Transport {
        &self.k
    }

    /// R x.
    pub fn times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut product = self.scale.component_mul(x);
        product.column_iter_mut().for_each(|mut column| self.k.mass().inverse_root(column.as_mut_slice()));
        if let Some(turns) = &self.turns {
            turns.turn(&mut product);
        }
        product
    }

    /// Rᵀ x.
    pub fn transposed_times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut product = match &self.turns {
            None => self.scale.component_mul(x),
            Some(turns) => {
                let mut turned = x.clone();
                turns.turn_back(&mut turned);
                turned.component_mul(&self.scale)
            }
        };
        product.column_iter_mut().for_each(|mut column| self.k.mass().inverse_root(column.as_mut_slice()));
        product
    }

    /// x ← J x.
    pub fn sign(&self, x: &mut DMatrix<f64>) {
        if let Some(turns) = &self.turns {
            turns.sign(x);
        }
    }

    /// The diagonal of J in a channel, where not all of it is 1.
    pub fn signs(&self, channel: usize) -> Option<Vec<i8>> {
        self.turns.as_ref().and_then(|turns| turns.signs(channel))
    }

    /// Whether J = I in all channels, so that the matrix is positive definite.
    pub fn is_definite(&self) -> bool {
        self.turns.as_ref().is_none_or(Turns::are_definite)
    }

    /// What iterations on this form are called.
    pub fn method(&self) -> &'static str {
        if self.is_definite() { "cg" } else { "minres" }
    }

    /// The largest |λ| per channel.
    pub fn largest(&self) -> Vec<f64> {
        let largest = |sizes: &DMatrix<f64>| sizes.column_iter().map(|column| column.max()).collect();
        self.turns.as_ref().map_or_else(|| largest(self.k.reflectance()), |turns| largest(&turns.sizes()))
    }

    /// J − Rᵀ S R in one channel.
    pub fn matrix(&self, channel: usize) -> DMatrix<f64> {
        let (n, each) = (self.k.len(), self.k.basis().coefficients());
        // On sheets the scale comes after the turn.
        let scale = self.scale.column(channel);
        let plain = self.turns.as_ref().map(|turns| {
            let mut plain = scale.clone_owned();
            turns.paired().for_each(|i| plain[i] = 1.0 / self.k.mass().sums()[i].sqrt());
            plain
        });
        let s = plain.as_ref().map_or(scale, |plain| plain.column(0));
        let mut matrix = DMatrix::zeros(n, n);
        matrix.as_mut_slice().par_chunks_mut(each * n).enumerate().for_each(|(patch, columns)| {
            for (a, column) in columns.chunks_mut(n).enumerate() {
                let j = each * patch + a;
                self.k.exchange_of(channel).for_entries(j, |i, exchange| column[i] -= s[i] * exchange * s[j]);
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
        });
        if let Some(turns) = &self.turns {
            turns.turn_both_sides(&mut matrix, channel);
        }
        let signs = self.signs(channel);
        for i in 0..n {
            matrix[(i, i)] += signs.as_ref().map_or(1.0, |signs| f64::from(signs[i]));
        }
        matrix
    }
}
