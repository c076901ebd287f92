//! Turns: the eigenvectors of what sheets do, a rotation for each pair of coefficients.
//!
//! (ρ_front τ; τ ρ_back) = V Λ Vᵀ with V = (c −s; s c). The larger eigenvalue stands in the place of the
//! front and the lesser in that of the back: λ = m ± r with m = (ρ_front + ρ_back)/2, d = (ρ_front −
//! ρ_back)/2 and r = √(d² + τ²); (c, s) is (r + d, τ) or (τ, r − d), normalised.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::patches::Sheets;

/// Rotations for all pairs and channels.
#[derive(Debug)]
pub(super) struct Turns {
    pairs: Vec<[usize; 2]>,
    /// (c, s), pairs × channels.
    angles: DMatrix<[f64; 2]>,
    /// λ, N × channels; ρ where there is no sheet.
    eigenvalues: DMatrix<f64>,
}

impl Turns {
    /// Those of reflectances (N × c) and sheets by coefficients.
    pub fn new(reflectance: &DMatrix<f64>, sheets: &Sheets) -> Self {
        let Sheets { pairs, transmittance } = sheets;
        let mut eigenvalues = reflectance.clone();
        let angles = DMatrix::from_fn(pairs.len(), reflectance.ncols(), |p, c| {
            let [front, back] = pairs[p];
            let (block, tau) = ([reflectance[(front, c)], reflectance[(back, c)]], transmittance[(p, c)]);
            let (angle, [larger, lesser]) = diagonalised(block, tau);
            (eigenvalues[(front, c)], eigenvalues[(back, c)]) = (larger, lesser);
            angle
        });
        Self { pairs: pairs.clone(), angles, eigenvalues }
    }

    /// |λ|, N × c.
    pub fn sizes(&self) -> DMatrix<f64> {
        self.eigenvalues.abs()
    }

    /// The coefficients that are in a pair.
    pub fn paired(&self) -> impl Iterator<Item = usize> {
        self.pairs.iter().flatten().copied()
    }

    /// Whether no λ is negative.
    pub fn are_definite(&self) -> bool {
        self.eigenvalues.iter().all(|&lambda| lambda >= 0.0)
    }

    /// The signs J of λ in a channel, where not all are 1.
    pub fn signs(&self, channel: usize) -> Option<Vec<i8>> {
        let lambdas = self.eigenvalues.column(channel);
        let signs = || lambdas.iter().map(|&lambda| if lambda < 0.0 { -1 } else { 1 });
        signs().any(|sign| sign < 0).then(|| signs().collect())
    }

    /// x ← J x.
    pub fn sign(&self, x: &mut DMatrix<f64>) {
        x.zip_apply(&self.eigenvalues, |x, lambda| *x *= if lambda < 0.0 { -1.0 } else { 1.0 });
    }

    /// x ← V x.
    pub fn turn(&self, x: &mut DMatrix<f64>) {
        for (c, mut x) in x.column_iter_mut().enumerate() {
            for (&[front, back], [cosine, sine]) in self.pairs.iter().zip(&self.angles.column(c)) {
                let [a, b] = [x[front], x[back]];
                (x[front], x[back]) = (cosine * a - sine * b, sine * a + cosine * b);
            }
        }
    }

    /// x ← Vᵀ x.
    pub fn turn_back(&self, x: &mut DMatrix<f64>) {
        for (c, mut x) in x.column_iter_mut().enumerate() {
            self.turn_back_in(c, x.as_mut_slice());
        }
    }

    fn turn_back_in(&self, channel: usize, x: &mut [f64]) {
        for (&[front, back], [cosine, sine]) in self.pairs.iter().zip(&self.angles.column(channel)) {
            let [a, b] = [x[front], x[back]];
            (x[front], x[back]) = (cosine * a + sine * b, cosine * b - sine * a);
        }
    }

    /// A ← |Λ|^½ Vᵀ A V |Λ|^½ on the rows and columns of pairs, in a channel.
    pub fn turn_both_sides(&self, matrix: &mut DMatrix<f64>, channel: usize) {
        let n = matrix.nrows();
        let lambdas = self.eigenvalues.column(channel);
        let scale = |column: &mut [f64]| self.paired().for_each(|i| column[i] *= lambdas[i].abs().sqrt());
        // From the left, column by column ...
        matrix.as_mut_slice().par_chunks_mut(n).for_each(|column| {
            self.turn_back_in(channel, column);
            scale(column);
        });
        // ... and from the right, row by row; no column is in two pairs.
        for (&[front, back], &[cosine, sine]) in self.pairs.iter().zip(&self.angles.column(channel)) {
            let sizes = [front, back].map(|i| lambdas[i].abs().sqrt());
            for i in 0..n {
                let [a, b] = [matrix[(i, front)], matrix[(i, back)]];
                matrix[(i, front)] = sizes[0] * (cosine * a + sine * b);
                matrix[(i, back)] = sizes[1] * (cosine * b - sine * a);
            }
        }
    }
}

/// (c, s) and both eigenvalues, the larger first, of (a τ; τ b).
fn diagonalised([a, b]: [f64; 2], tau: f64) -> ([f64; 2], [f64; 2]) {
    let (middle, half) = (0.5 * (a + b), 0.5 * (a - b));
    let radius = half.hypot(tau);
    if radius == 0.0 {
        return ([1.0, 0.0], [a, b]);
    }
    let larger = middle + radius;
    // Of two forms for the eigenvector the one that adds takes no digits away; so it is with the lesser
    // eigenvalue.
    let (x, y) = if half >= 0.0 { (radius + half, tau) } else { (tau, radius - half) };
    let length = x.hypot(y);
    ([x / length, y / length], [larger, (a * b - tau * tau) / larger])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_and_vectors_make_the_block_again() {
        let blocks = [
            [0.5, 0.3, 0.25],
            [0.3, 0.5, 0.25],
            [0.0, 0.0, 0.8],
            [0.4, 0.4, 0.4],
            [0.7, 0.2, 0.0],
            [0.0, 0.9, 1e-9],
        ];
        for [a, b, tau] in blocks {
            let ([c, s], [larger, lesser]) = diagonalised([a, b], tau);
            let entry = |x: [f64; 2], y: [f64; 2]| larger * x[0] * y[0] + lesser * x[1] * y[1];
            let (front, back) = ([c, -s], [s, c]);
            for (made, given) in [(entry(front, front), a), (entry(back, back), b), (entry(front, back), tau)]
            {
                assert!((made - given).abs() < 1e-15, "{a} {b} {tau}: {made} for {given}");
            }
            assert!((c * c + s * s - 1.0).abs() < 1e-15 && larger >= lesser);
        }
    }
}
