//! Exchange areas: S_ij = A_i F_ij = S_ji, symmetric and closed.
//!
//! Kept as D T D with T symmetric in f32, dense or sparse, and a positive diagonal D in f64 that makes every row
//! sum to its patch's area together with what escapes. D_i·D_j·T_ij is the same number from both sides, so reciprocity holds
//! to the last bit.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sprs::CsMatI;

use super::balance::{self, Closure};
use super::rays::{AWAY, BATCHES, Rows};
use crate::patches::Patches;
use crate::progress::{Cancelled, Progress};
use crate::scene::Side;

/// A symmetric n × n matrix of non-negative f32.
#[derive(Clone, Debug)]
pub enum Storage {
    /// Every entry.
    Dense(DMatrix<f32>),
    /// The entries that are not zero, by rows; both triangles.
    Sparse(CsMatI<f32, u32, usize>),
}

/// How to store exchange areas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StorageKind {
    /// Whichever is smaller.
    #[default]
    Auto,
    /// A full matrix: 4 n² bytes.
    Dense,
    /// Compressed rows: 8 bytes an entry.
    Sparse,
}

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
        let n = patches.len();
        let is_lamp: Vec<bool> = (0..n)
            .map(|i| {
                let place = patches.place(i);
                place.side == Side::Front && rows.lamp_faces.binary_search(&(place.face as u32)).is_ok()
            })
            .collect();
        let finder = Finder { rows, patches, is_lamp: &is_lamp, left_out };
        let (parts, escape): (Vec<Vec<Part>>, Vec<f64>) =
            (0..n).into_par_iter().map(|i| finder.found_by(i)).unzip();
        let storage = if kind.resolve(n, &parts) == StorageKind::Dense {
            Storage::Dense(dense(n, &parts))
        } else {
            Storage::Sparse(sparse(n, &parts))
        };
        drop(parts);
        let (escape, areas) = (DVector::from_vec(escape), DVector::from_row_slice(patches.areas()));
        Self::new(storage, escape, areas, &is_lamp, progress)
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

impl StorageKind {
    /// Dense or sparse for these counts.
    fn resolve(self, n: usize, parts: &[Vec<Part>]) -> Self {
        let entries: usize = parts.iter().map(Vec::len).sum();
        match self {
            // Most pairs are met from both sides or from one; between one and two entries a part.
            Self::Auto if 8 * 3 * entries / 2 < 4 * n * n => Self::Sparse,
            Self::Auto => Self::Dense,
            chosen => chosen,
        }
    }
}

/// What one patch found of its exchange area with another; the pair's exchange area is the sum of both findings.
type Part = (u32, f64);

/// Sums up rows into findings.
struct Finder<'a> {
    rows: &'a Rows,
    patches: &'a Patches<'a>,
    is_lamp: &'a [bool],
    left_out: Option<u32>,
}

impl Finder<'_> {
    /// What patch i found: its parts, ascending, and what escapes from it; a side without light is as good as outside.
    ///
    /// A landing of i on j is worth A_i/N. Its variance grows with A_i, so the two directions of a pair are averaged with
    /// weights A_j and A_i: each landing between i and j is then worth the same from either side. Of a lamp its receivers
    /// know more than it does itself: between the two, only what they found counts.
    fn found_by(&self, i: usize) -> (Vec<Part>, f64) {
        let areas = self.patches.areas();
        let Some(row) = self.rows.of(self.patches.slot_of_patch(i)) else {
            return (Vec::new(), areas[i]);
        };
        let batch_size = row.landings.len() / BATCHES as usize;
        let batches =
            row.landings.chunks(batch_size).zip(0..).filter(|&(_, batch)| Some(batch) != self.left_out);
        let number =
            |slot: u32| if slot == AWAY { AWAY } else { self.patches.patch_of_slot(slot).unwrap_or(AWAY) };
        let mut sorted: Vec<u32> =
            batches.flat_map(|(landings, _)| landings.iter().map(|&s| number(s))).collect();
        sorted.sort_unstable();
        let rays = sorted.len() as f64;
        let mut escape = 0.0;
        let mut parts: Vec<Part> = Vec::new();
        for run in sorted.chunk_by(|a, b| a == b) {
            let (patch, count) = (run[0], run.len() as f64);
            if patch == AWAY {
                escape = areas[i] * count / rays;
            } else if self.is_lamp[patch as usize] == self.is_lamp[i] {
                let j = patch as usize;
                parts.push((patch, areas[i] * areas[j] / (areas[i] + areas[j]) * count / rays));
            }
        }
        let used = if self.left_out.is_some() { BATCHES - 1 } else { BATCHES };
        let worth = areas[i] * BATCHES as f64 / used as f64;
        let mut of_lamps: Vec<_> =
            row.lamp_shares.iter().filter(|s| Some(s.batch) != self.left_out).collect();
        of_lamps.sort_unstable_by_key(|s| (s.slot, s.batch));
        for run in of_lamps.chunk_by(|a, b| a.slot == b.slot) {
            parts.push((number(run[0].slot), worth * run.iter().map(|s| f64::from(s.share)).sum::<f64>()));
        }
        parts.sort_unstable_by_key(|part| part.0);
        (parts, escape)
    }
}

fn dense(n: usize, parts: &[Vec<Part>]) -> DMatrix<f32> {
    let mut m = DMatrix::zeros(n, n);
    // Column i holds what i found.
    m.as_mut_slice().par_chunks_mut(n).zip(parts).for_each(|(column, parts): (&mut [f32], _)| {
        parts.iter().for_each(|&(j, part)| column[j as usize] = part as f32);
    });
    for j in 0..n {
        for i in 0..j {
            let both = m[(i, j)] + m[(j, i)];
            m[(i, j)] = both;
            m[(j, i)] = both;
        }
    }
    m
}

fn sparse(n: usize, parts: &[Vec<Part>]) -> CsMatI<f32, u32, usize> {
    // Gather, for each patch, what others found of it; ascending because patches come in order.
    let mut from: Vec<Vec<Part>> = vec![Vec::new(); n];
    for (i, parts) in parts.iter().enumerate() {
        parts.iter().for_each(|&(j, part)| from[j as usize].push((i as u32, part)));
    }
    let rows: Vec<Vec<(u32, f32)>> = (0..n)
        .into_par_iter()
        .map(|i| {
            let mut both: Vec<Part> = parts[i].iter().chain(&from[i]).copied().collect();
            both.sort_by_key(|part| part.0);
            // Sums of two f32 commute: both triangles get the same bits.
            both.chunk_by(|a, b| a.0 == b.0)
                .map(|pair| (pair[0].0, pair.iter().map(|part| part.1 as f32).sum()))
                .collect()
        })
        .collect();
    drop(from);
    let mut starts = vec![0];
    rows.iter().for_each(|row| starts.push(starts[starts.len() - 1] + row.len()));
    let indices = rows.iter().flatten().map(|&(j, _)| j).collect();
    let values = rows.iter().flatten().map(|&(_, value)| value).collect();
    CsMatI::new((n, n), starts, indices, values)
}

impl Storage {
    /// y ← T x.
    pub(super) fn multiply(&self, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
        match self {
            Storage::Dense(m) => multiply_dense(m, x, y),
            Storage::Sparse(m) if x.ncols() == 1 => multiply_sparse::<1>(m, x, y),
            Storage::Sparse(m) => multiply_sparse::<4>(m, x, y),
        }
    }

    /// Multiplies every entry by `factor(i, j)`, which must be symmetric.
    pub(super) fn scale_entries(&mut self, factor: impl Fn(usize, usize) -> f64 + Sync) {
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
        }
    }

    fn for_row(&self, i: usize, mut f: impl FnMut(usize, f32)) {
        match self {
            Storage::Dense(m) => {
                m.column(i).iter().enumerate().filter(|(_, v)| **v != 0.0).for_each(|(j, &v)| f(j, v))
            }
            Storage::Sparse(m) => {
                m.outer_view(i).iter().for_each(|row| row.iter().for_each(|(j, &v)| f(j, v)));
            }
        }
    }
}

/// Rows of T in turn, each against a stretch of every column of x while the stretch is at hand.
fn multiply_dense(m: &DMatrix<f32>, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
    const STRETCH: usize = 512;
    let (n, channels) = x.shape();
    let mut rows = vec![0.0; n * channels];
    rows.par_chunks_mut(channels).enumerate().for_each(|(i, sums)| {
        let mut wide = [0.0f64; STRETCH];
        for (k, stretch) in m.as_slice()[i * n..(i + 1) * n].chunks(STRETCH).enumerate() {
            wide.iter_mut().zip(stretch).for_each(|(wide, &narrow)| *wide = f64::from(narrow));
            for (c, sum) in sums.iter_mut().enumerate() {
                let first = c * n + k * STRETCH;
                *sum += dot(&wide[..stretch.len()], &x.as_slice()[first..first + stretch.len()]);
            }
        }
    });
    y.copy_from(&DMatrix::from_row_slice(n, channels, &rows));
}

/// A dot product in eight lanes, for the compiler to vectorise.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (chunks_a, chunks_b) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = chunks_a.remainder().iter().zip(chunks_b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in chunks_a.zip(chunks_b) {
        for k in 0..8 {
            lanes[k] += a[k] * b[k];
        }
    }
    lanes.iter().sum::<f64>() + tail
}

/// Rows of T in turn, `LANES` columns of x at a time, laid side by side so that an entry reads them in one go.
fn multiply_sparse<const LANES: usize>(m: &CsMatI<f32, u32, usize>, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
    let (n, channels) = x.shape();
    let starts = m.proper_indptr();
    let (indices, values) = (m.indices(), m.data());
    for first in (0..channels).step_by(LANES) {
        let used = LANES.min(channels - first);
        let lane = |i: usize, k: usize| if k < used { x[(i, first + k)] } else { 0.0 };
        let beside: Vec<[f64; LANES]> = (0..n).map(|i| std::array::from_fn(|k| lane(i, k))).collect();
        let sums: Vec<[f64; LANES]> = (0..n)
            .into_par_iter()
            .with_min_len(64)
            .map(|i| {
                let mut sum = [0.0; LANES];
                let range = starts[i]..starts[i + 1];
                for (&j, &value) in indices[range.clone()].iter().zip(&values[range]) {
                    let x = &beside[j as usize];
                    for k in 0..LANES {
                        sum[k] += f64::from(value) * x[k];
                    }
                }
                sum
            })
            .collect();
        for k in 0..used {
            y.column_mut(first + k).iter_mut().zip(&sums).for_each(|(y, sum)| *y = sum[k]);
        }
    }
}
