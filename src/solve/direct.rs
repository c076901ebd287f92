//! The direct solver: Cholesky factors of the symmetric form.
//!
//! With R = √ρ M^(−½), the matrix I − R S R is symmetric positive definite, has a unit scale whatever the
//! patch areas, and does not mind ρ = 0. Where sheets let through more than they reflect it is J − RᵀSR,
//! quasi-definite, with factors L D Lᵀ in the place of Cholesky's. It is factored once per distinct ρ;
//! channels with the same reflectances share their factor, unless coloured carriers make their exchange areas
//! differ.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt, llt};
use faer::{MatMut, MatRef, Par};
use nalgebra::DMatrix;

use super::stopping::{Answer, Run};
use super::symmetric::Root;
use super::{Amplification, Solution, SolveError};
use crate::patches::{Basis, Sheets};
use crate::progress::Progress;
use crate::transport::{Transport, is_quickly_factored};

/// Limits of the direct solver.
#[derive(Clone, Copy, Debug)]
pub struct DirectOptions<'a> {
    /// The most bytes the factors may take: 8 N² for each distinct ρ.
    pub memory: u64,
    /// Where to report progress, as stages `factor` and `solve`.
    pub progress: Progress<'a>,
}

impl Default for DirectOptions<'_> {
    /// 4 GiB.
    fn default() -> Self {
        Self { memory: 4 << 30, progress: Progress::default() }
    }
}

/// A factored operator, ready for any number of right-hand sides.
#[derive(Debug)]
pub struct Direct {
    root: Root,
    /// One per distinct ρ and τ.
    factors: Vec<Factor>,
    /// Which factor a channel uses.
    factor_of: Vec<usize>,
    amplification: Amplification,
}

/// Lower triangular factors of a symmetric matrix.
#[derive(Debug)]
enum Factor {
    /// L of L Lᵀ.
    Cholesky(DMatrix<f64>),
    /// L of L D Lᵀ, with D in the place of the ones on its diagonal.
    Signed(DMatrix<f64>),
}

/// How work is split inside a factorization. Fixed, so that the answer has the same bits on any number of
/// threads.
fn split() -> Par {
    Par::rayon(8)
}

/// Factors the operator.
///
/// # Errors
/// `Memory`, `Singular` or `Cancelled`.
pub fn direct(k: &Transport, options: &DirectOptions) -> Result<Direct, SolveError> {
    let n = k.len();
    let (factor_of, distinct) = distinct_channels(k);
    let needed = factor_bytes(k);
    if needed > options.memory {
        return Err(SolveError::Memory { n, needed, limit: options.memory });
    }
    let root = Root::new(k);
    let mut factors = Vec::new();
    for (done, &c) in distinct.iter().enumerate() {
        options.progress.at("factor", done as f64 / distinct.len() as f64)?;
        factors.push(factor(k, &root, c)?);
    }
    options.progress.at("factor", 1.0)?;
    let ones = DMatrix::repeat(n, k.channels(), 1.0);
    let amplification = match k.basis() {
        Basis::Constant => {
            let reflected = back_substitute(&root, &factors, &factor_of, &ones);
            Amplification::from_rough(k, ones + reflected)
        }
        Basis::Linear => Amplification::estimate(k, options.progress)?,
    };
    Ok(Direct { root, factors, factor_of, amplification })
}

impl Direct {
    /// Solves L = E + K L for one right-hand side E (N × c).
    ///
    /// # Panics
    /// If `e` is not N × c.
    pub fn solve(&self, e: &DMatrix<f64>) -> Solution {
        let k = self.root.operator();
        assert_eq!(e.shape(), (k.len(), k.channels()), "the right-hand side is N × c");
        let reflected = self.substitute(e);
        // Refine once: solve for what the residual says is left.
        let residual = k.reflect(&k.irradiance(&(e + &reflected))) - &reflected;
        let reflected = reflected + &residual + self.substitute(&residual);
        let answer = Answer::after(k, e, &reflected);
        let report = answer.judge(k, e, Run { name: "direct", iterations: 0 }, &self.amplification);
        Solution { radiance: e + answer.reflected, irradiance: answer.irradiance, basis: k.basis(), report }
    }

    /// The irradiance of L = E + K L, as exact as the factors are: neither refined nor judged, for answers
    /// that need not be.
    ///
    /// # Panics
    /// If `e` is not N × c.
    pub(crate) fn irradiance(&self, e: &DMatrix<f64>) -> DMatrix<f64> {
        let k = self.root.operator();
        assert_eq!(e.shape(), (k.len(), k.channels()), "the right-hand side is N × c");
        k.irradiance(&(e + self.substitute(e)))
    }

    /// R y of L = E + R y.
    fn substitute(&self, e: &DMatrix<f64>) -> DMatrix<f64> {
        back_substitute(&self.root, &self.factors, &self.factor_of, e)
    }

    /// Number of factorizations: one per distinct ρ.
    pub fn factorizations(&self) -> usize {
        self.factors.len()
    }
}

/// Whether the direct solver fits into `memory` and takes no more than a second or two.
pub(crate) fn is_quick(k: &Transport, memory: u64) -> bool {
    is_quickly_factored(k.len(), distinct_channels(k).1.len(), memory)
}

/// Bytes that the factors take.
pub(crate) fn factor_bytes(k: &Transport) -> u64 {
    8 * (k.len() as u64).pow(2) * distinct_channels(k).1.len() as u64
}

/// For each channel the index of its factor, and for each factor its first channel.
fn distinct_channels(k: &Transport) -> (Vec<usize>, Vec<usize>) {
    let reflectance = k.reflectance();
    let alike = |a: usize, b: usize| {
        let through = |sheets: &Sheets| sheets.transmittance.column(a) == sheets.transmittance.column(b);
        reflectance.column(a) == reflectance.column(b)
            && k.tone_of(a) == k.tone_of(b)
            && k.sheets().is_none_or(through)
    };
    let mut distinct: Vec<usize> = Vec::new();
    let factor_of = (0..reflectance.ncols())
        .map(|c| {
            distinct.iter().position(|&d| alike(d, c)).unwrap_or_else(|| {
                distinct.push(c);
                distinct.len() - 1
            })
        })
        .collect();
    (factor_of, distinct)
}

/// The factor of J − RᵀSR in one channel.
fn factor(k: &Transport, root: &Root, channel: usize) -> Result<Factor, SolveError> {
    let matrix = root.matrix(channel);
    let factor = match root.signs(channel) {
        None => cholesky(matrix).map(Factor::Cholesky),
        Some(signs) => signed(matrix, &signs).map(Factor::Signed),
    };
    factor.map_err(|index| SolveError::Singular { patch: index / k.basis().coefficients() })
}

/// L of a positive definite matrix L Lᵀ, or the row where it turns out not to be.
fn cholesky(mut matrix: DMatrix<f64>) -> Result<DMatrix<f64>, usize> {
    let n = matrix.nrows();
    let scratch = llt::factor::cholesky_in_place_scratch::<f64>(n, split(), Default::default());
    let result = llt::factor::cholesky_in_place(
        MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), n, n),
        Default::default(),
        split(),
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    );
    match result {
        Ok(_) => Ok(matrix),
        Err(llt::factor::LltError::NonPositivePivot { index }) => Err(index),
    }
}

/// L and D of a quasi-definite matrix L D Lᵀ with D of these signs, or the row where it turns out to have
/// others.
fn signed(mut matrix: DMatrix<f64>, signs: &[i8]) -> Result<DMatrix<f64>, usize> {
    let n = matrix.nrows();
    let scratch = ldlt::factor::cholesky_in_place_scratch::<f64>(n, split(), Default::default());
    let result = ldlt::factor::cholesky_in_place(
        MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), n, n),
        Default::default(),
        split(),
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    );
    match result {
        Ok(_) => {
            let is_right = |i: usize| matrix[(i, i)] * f64::from(signs[i]) > 0.0;
            (0..n).find(|&i| !is_right(i)).map_or(Ok(matrix), Err)
        }
        Err(ldlt::factor::LdltError::ZeroPivot { index }) => Err(index),
    }
}

/// R y of L = E + R y, with y from the factors of its channel.
fn back_substitute(root: &Root, factors: &[Factor], factor_of: &[usize], e: &DMatrix<f64>) -> DMatrix<f64> {
    let k = root.operator();
    let n = k.len();
    let mut y = DMatrix::zeros(n, e.ncols());
    k.through(e, &mut y);
    let mut y = root.transposed_times(&y);
    for (c, &f) in factor_of.iter().enumerate() {
        let mut column = y.column_mut(c);
        let y = MatMut::from_column_major_slice_mut(column.as_mut_slice(), n, 1);
        match &factors[f] {
            Factor::Cholesky(l) => {
                let scratch = llt::solve::solve_in_place_scratch::<f64>(n, 1, split());
                let stack = &mut MemBuffer::new(scratch);
                let l = MatRef::from_column_major_slice(l.as_slice(), n, n);
                llt::solve::solve_in_place(l, y, split(), MemStack::new(stack));
            }
            Factor::Signed(l) => {
                let scratch = ldlt::solve::solve_in_place_scratch::<f64>(n, 1, split());
                let stack = &mut MemBuffer::new(scratch);
                let l = MatRef::from_column_major_slice(l.as_slice(), n, n);
                ldlt::solve::solve_in_place(l, l.diagonal(), y, split(), MemStack::new(stack));
            }
        }
    }
    root.times(&y)
}
