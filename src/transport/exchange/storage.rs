//! Storage: a symmetric N × N matrix of non-negative numbers, dense or sparse, and its product with vectors.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sprs::CsMatI;

use super::blocks::{Blocks, shrunk_block};

/// A symmetric N × N matrix of non-negative numbers.
#[derive(Clone, Debug)]
pub enum Storage {
    /// Every entry.
    Dense(DMatrix<f32>),
    /// The entries that are not zero, by rows; both triangles.
    Sparse(CsMatI<f32, u32, usize>),
    /// By pairs of patches, for linear elements.
    Blocks(Blocks),
}

/// How to store exchange areas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StorageKind {
    /// Whichever is smaller.
    #[default]
    Auto,
    /// A full matrix: 4 N² bytes.
    Dense,
    /// What is not zero: 8 bytes an entry; for linear elements 8 bytes a ray and 40 bytes a pair of patches
    /// with several rays, all of it twice.
    Sparse,
}

impl Storage {
    /// A sparse matrix from its rows: column numbers, ascending, and values.
    pub fn sparse(rows: &[Vec<(u32, f32)>]) -> Self {
        let entries = rows.iter().map(Vec::len).sum();
        let (mut starts, mut indices, mut values) =
            (vec![0], Vec::with_capacity(entries), Vec::with_capacity(entries));
        for row in rows {
            indices.extend(row.iter().map(|entry| entry.0));
            values.extend(row.iter().map(|entry| entry.1));
            starts.push(indices.len());
        }
        Self::Sparse(CsMatI::new((rows.len(), rows.len()), starts, indices, values))
    }

    /// y ← T x.
    pub(crate) fn multiply(&self, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
        match self {
            Storage::Dense(m) => multiply_dense(m, x, y),
            Storage::Sparse(m) if x.ncols() == 1 => multiply_sparse::<1>(m, x, y),
            Storage::Sparse(m) => multiply_sparse::<4>(m, x, y),
            Storage::Blocks(m) if x.ncols() == 1 => m.multiply::<1>(x, y),
            Storage::Blocks(m) => m.multiply::<4>(x, y),
        }
    }

    /// T_ij.
    pub(crate) fn get(&self, i: usize, j: usize) -> f64 {
        match self {
            Storage::Dense(m) => f64::from(m[(i, j)]),
            Storage::Sparse(m) => m.get(i, j).map_or(0.0, |&value| f64::from(value)),
            Storage::Blocks(m) => m.get(i, j),
        }
    }

    /// T x for a single vector.
    pub(crate) fn times(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut y = DMatrix::zeros(x.len(), 1);
        self.multiply(&DMatrix::from_column_slice(x.len(), 1, x.as_slice()), &mut y);
        y.column(0).into_owned()
    }

    /// Multiplies every entry by `factor(i, j)`, which must be symmetric, and 1 between what are no lamps.
    pub(crate) fn scale_entries(&mut self, factor: impl Fn(usize, usize) -> f64 + Sync) {
        let scaled = |value: f32, i: usize, j: usize| (f64::from(value) * factor(i, j)) as f32;
        match self {
            Storage::Dense(m) => {
                let n = m.nrows();
                let columns = m.as_mut_slice().par_chunks_mut(n).enumerate();
                columns.for_each(|(i, column)| {
                    column.iter_mut().enumerate().for_each(|(j, value)| *value = scaled(*value, i, j));
                });
            }
            Storage::Sparse(m) => {
                for (i, mut row) in m.outer_iterator_mut().enumerate() {
                    row.iter_mut().for_each(|(j, value)| *value = scaled(*value, i, j));
                }
            }
            Storage::Blocks(m) => m.scale_blocks(factor),
        }
    }

    /// T_τ D T D T_τ with T_τ the shrinkage of each patch's three coefficients by τ.
    pub(crate) fn shrunk(self, scale: &DVector<f64>, tau: f64) -> Self {
        match self {
            Storage::Blocks(m) => Storage::Blocks(m.shrunk(scale, tau)),
            Storage::Dense(m) => Storage::Dense(shrunk_dense(m, scale, tau)),
            // Compressed rows are for constant elements, of which nothing varies.
            sparse @ Storage::Sparse(_) => sparse,
        }
    }

    /// Calls `f(j, T_ij)` for every entry of row i that is not zero.
    pub(crate) fn for_row(&self, i: usize, mut f: impl FnMut(usize, f64)) {
        match self {
            Storage::Dense(m) => {
                let entries = m.column(i).into_iter().enumerate();
                entries.filter(|(_, v)| **v != 0.0).for_each(|(j, &v)| f(j, f64::from(v)));
            }
            Storage::Sparse(m) => {
                m.outer_view(i).iter().for_each(|row| row.iter().for_each(|(j, &v)| f(j, f64::from(v))));
            }
            Storage::Blocks(m) => m.for_row(i, f),
        }
    }
}

fn shrunk_dense(mut m: DMatrix<f32>, scale: &DVector<f64>, tau: f64) -> DMatrix<f32> {
    for first in (0..m.ncols()).step_by(3) {
        for second in (first..m.ncols()).step_by(3) {
            let at = |entry: usize| (first + entry / 3, second + entry % 3);
            let block = std::array::from_fn(|entry| {
                let (k, l) = at(entry);
                (scale[k] * scale[l]) * f64::from(m[(k, l)])
            });
            for (entry, value) in shrunk_block(block, tau).into_iter().enumerate() {
                let (k, l) = at(entry);
                m[(k, l)] = value as f32;
                m[(l, k)] = value as f32;
            }
        }
    }
    m
}

/// Rows of T in turn, each against a stretch of every column of x while the stretch is at hand.
fn multiply_dense(m: &DMatrix<f32>, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
    const STRETCH: usize = 512;
    let (n, channels) = x.shape();
    let mut rows = vec![0.0; n * channels];
    rows.par_chunks_mut(channels).enumerate().for_each(|(i, sums)| {
        for (k, stretch) in m.as_slice()[i * n..(i + 1) * n].chunks(STRETCH).enumerate() {
            for (c, sum) in sums.iter_mut().enumerate() {
                let first = c * n + k * STRETCH;
                *sum += dot(stretch, &x.as_slice()[first..first + stretch.len()]);
            }
        }
    });
    y.copy_from(&DMatrix::from_row_slice(n, channels, &rows));
}

/// A dot product in eight lanes, for the compiler to vectorise.
fn dot(a: &[f32], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (chunks_a, chunks_b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = chunks_a.remainder().iter().zip(chunks_b.remainder());
    let tail: f64 = rest.map(|(&a, b)| f64::from(a) * b).sum();
    for (a, b) in chunks_a.zip(chunks_b) {
        for k in 0..8 {
            lanes[k] += f64::from(a[k]) * b[k];
        }
    }
    lanes.iter().sum::<f64>() + tail
}

/// Rows of T in turn, `LANES` columns of x at a time, laid side by side so that an entry reads them in one
/// go.
fn multiply_sparse<const LANES: usize>(m: &CsMatI<f32, u32, usize>, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
    let (n, channels) = x.shape();
    let starts = m.proper_indptr();
    for first in (0..channels).step_by(LANES) {
        let used = LANES.min(channels - first);
        let lane = |i: usize, k: usize| if k < used { x[(i, first + k)] } else { 0.0 };
        let beside: Vec<[f64; LANES]> = (0..n).map(|i| std::array::from_fn(|k| lane(i, k))).collect();
        let sums: Vec<[f64; LANES]> = (0..n)
            .into_par_iter()
            .with_min_len(64)
            .map(|i| {
                let range = starts[i]..starts[i + 1];
                sparse_dot(&m.indices()[range.clone()], &m.data()[range], &beside)
            })
            .collect();
        for k in 0..used {
            y.column_mut(first + k).iter_mut().zip(&sums).for_each(|(y, sum)| *y = sum[k]);
        }
    }
}

/// Σ values · x at the indices, for each lane of x. Four sums are under way at a time: a processor adds
/// faster than it can tell what comes out.
fn sparse_dot<const LANES: usize>(indices: &[u32], values: &[f32], x: &[[f64; LANES]]) -> [f64; LANES] {
    const WAYS: usize = 4;
    let mut sums = [[0.0; LANES]; WAYS];
    let (fours, values_of_fours) = (indices.chunks_exact(WAYS), values.chunks_exact(WAYS));
    let rest = fours.remainder().iter().zip(values_of_fours.remainder());
    for (indices, values) in fours.zip(values_of_fours) {
        for way in 0..WAYS {
            let (x, value) = (&x[indices[way] as usize], f64::from(values[way]));
            for k in 0..LANES {
                sums[way][k] += value * x[k];
            }
        }
    }
    for (&j, &value) in rest {
        for k in 0..LANES {
            sums[0][k] += f64::from(value) * x[j as usize][k];
        }
    }
    std::array::from_fn(|k| (sums[0][k] + sums[1][k]) + (sums[2][k] + sums[3][k]))
}
