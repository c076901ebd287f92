//! Exchange areas: S_ij = A_i F_ij = S_ji, symmetric and closed.
//!
//! Kept as D T D with T symmetric in f32, dense or sparse, and a positive diagonal D in f64 that makes every row
//! sum to its patch's area together with what escapes. D_i·D_j·T_ij is the same number from both sides, so reciprocity holds
//! to the last bit.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::assembly::{Raw, assemble};
use super::balance::{self, Closure};
use super::rays::Rows;
use super::storage::{Storage, StorageKind};
use crate::patches::Patches;
use crate::progress::{Cancelled, Progress};

/// Exchange areas between n patches, and what escapes from each.
#[derive(Clone, Debug)]
pub struct Exchange {
    storage: Storage,
    scale: DVector<f64>,
    escape: DVector<f64>,
    areas: DVector<f64>,
    closure: Closure,
}

impl Exchange {
    /// Balances raw exchange areas `storage` and escapes (n values) between patches of these areas, any common unit.
    ///
    /// `lamps` (n flags) marks patches whose entries are known better than the others' and are not to bear their noise.
    ///
    /// # Errors
    /// `Cancelled`.
    ///
    /// # Panics
    /// If the dimensions differ or the matrix is not symmetric in shape.
    pub fn new(
        mut storage: Storage,
        mut escape: DVector<f64>,
        areas: DVector<f64>,
        lamps: &[bool],
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        let n = areas.len();
        let shape = match &storage {
            Storage::Dense(m) => m.shape(),
            Storage::Sparse(m) => m.shape(),
        };
        let consistent = shape == (n, n) && escape.len() == n && lamps.len() == n;
        assert!(consistent, "n areas, n escapes, n flags and an n × n matrix");
        let (scale, closure) = if lamps.contains(&true) {
            balance::balance_around_lamps(&mut storage, &escape, &areas, lamps, progress)?
        } else {
            balance::balance(&storage, &escape, &areas, &DVector::repeat(n, 1.0), progress)?
        };
        escape.component_mul_assign(&scale);
        Ok(Self { storage, scale, escape, areas, closure })
    }

    /// The ideal sphere, S = A Aᵀ / ΣA: every point sees every area alike. Closed forms are known for all its answers.
    pub fn ideal_sphere(areas: DVector<f64>) -> Self {
        let total = areas.sum();
        let dense = DMatrix::from_fn(areas.len(), areas.len(), |i, j| (areas[i] * areas[j] / total) as f32);
        let escape = DVector::zeros(areas.len());
        let lamps = vec![false; areas.len()];
        Self::new(Storage::Dense(dense), escape, areas, &lamps, Progress::default())
            .expect("a silent observer never cancels")
    }

    /// Turns the rows of patches into raw exchange areas and balances them; without batch `left_out`, if there is one.
    pub(super) fn from_rows(
        rows: &Rows,
        patches: &Patches,
        kind: StorageKind,
        left_out: Option<u32>,
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        let Raw { storage, escape, is_lamp } = assemble(rows, patches, kind, left_out);
        Self::new(storage, escape, DVector::from_row_slice(patches.areas()), &is_lamp, progress)
    }

    /// What was balanced before.
    pub(super) fn from_raw(
        storage: Storage,
        scale: DVector<f64>,
        escape: DVector<f64>,
        areas: DVector<f64>,
        closure: Closure,
    ) -> Self {
        Self { storage, scale, escape, areas, closure }
    }

    /// T and D.
    pub(super) fn raw(&self) -> (&Storage, &DVector<f64>) {
        (&self.storage, &self.scale)
    }

    /// Number of patches n.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there are no patches.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Areas A_i: the mass of constant elements.
    pub fn areas(&self) -> &DVector<f64> {
        &self.areas
    }

    /// S_ij.
    pub fn exchange_area(&self, i: usize, j: usize) -> f64 {
        let raw = match &self.storage {
            Storage::Dense(m) => m[(i, j)],
            Storage::Sparse(m) => m.get(i, j).copied().unwrap_or(0.0),
        };
        // The product of the scales first, and it commutes: the same bits for (i, j) and (j, i).
        (self.scale[i] * self.scale[j]) * raw as f64
    }

    /// Form factor F_ij = S_ij / A_i.
    pub fn form_factor(&self, i: usize, j: usize) -> f64 {
        self.exchange_area(i, j) / self.areas[i]
    }

    /// What escapes, S_i∞ = A_i F_i∞, n values.
    pub fn escape(&self) -> &DVector<f64> {
        &self.escape
    }

    /// How well rows close, before and after balancing.
    pub fn closure(&self) -> &Closure {
        &self.closure
    }

    /// Bytes that the matrix takes.
    pub fn bytes(&self) -> u64 {
        match &self.storage {
            Storage::Dense(m) => 4 * m.len() as u64,
            Storage::Sparse(m) => 8 * m.nnz() as u64 + 8 * m.rows() as u64,
        }
    }

    /// `dense` or `sparse`.
    pub fn storage_name(&self) -> &'static str {
        match self.storage {
            Storage::Dense(_) => "dense",
            Storage::Sparse(_) => "sparse",
        }
    }

    /// y ← S x for n × c matrices, overwriting y. The same bits whatever the number of threads.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn apply(&self, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
        assert!(x.nrows() == self.len() && x.shape() == y.shape(), "x and y are n × c");
        let mut scaled = x.clone();
        scaled.column_iter_mut().for_each(|mut column| column.component_mul_assign(&self.scale));
        self.storage.multiply(&scaled, y);
        y.column_iter_mut().for_each(|mut column| column.component_mul_assign(&self.scale));
    }

    /// Calls `f(j, S_ij)` for every entry of row i that is not zero.
    pub fn for_row(&self, i: usize, mut f: impl FnMut(usize, f64)) {
        let scale = self.scale[i];
        self.storage.for_row(i, |j, raw| f(j, (scale * self.scale[j]) * raw as f64));
    }

    /// The largest |S_ij − S_ji| / min(A_i, A_j), recomputed; 0 unless something is damaged.
    pub fn reciprocity_error(&self) -> f64 {
        let error_of = |i: usize| {
            let mut most = 0.0f64;
            self.for_row(i, |j, s| {
                let off = |other: f64| (s - other).abs() / self.areas[i].min(self.areas[j]);
                // A dense row may be read as a column, which is the same only if all is well.
                most = match &self.storage {
                    Storage::Dense(_) => most.max(off(self.exchange_area(i, j))),
                    Storage::Sparse(_) => most.max(off(self.exchange_area(j, i))),
                };
            });
            most
        };
        (0..self.len()).into_par_iter().map(error_of).reduce(|| 0.0, f64::max)
    }

    /// The largest |D_i (T D)_i + S_i∞ − A_i| / A_i, recomputed.
    pub fn closure_error(&self) -> f64 {
        let n = self.len();
        let mut sums = DMatrix::zeros(n, 1);
        self.apply(&DMatrix::repeat(n, 1, 1.0), &mut sums);
        (0..n).map(|i| (sums[i] + self.escape[i] - self.areas[i]).abs() / self.areas[i]).fold(0.0, f64::max)
    }
}
