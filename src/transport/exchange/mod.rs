//! Exchange areas: S_ij = A_i F_ij = S_ji, symmetric and closed; in general S_(ia)(jb) = ∫∫ φ_a φ_b dF dA for
//! basis functions φ_a on patch i and φ_b on j, with one row per coefficient.
//!
//! Kept as D T D with T symmetric, dense or sparse, and a positive diagonal D in f64 that makes every row
//! sum to M·1 (a patch's area, or a third of it) together with what escapes and, where no D within bounds
//! closes a row, its slack. D_i·D_j·T_ij is the same number from both sides, so
//! reciprocity holds to the last bit.

mod assembly;
mod balance;
mod blocks;
mod mass;
mod merged;
mod moments;
mod polygons;
mod raw;
mod shrinkage;
mod storage;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sprs::CsMatI;

use crate::patches::Basis;
use crate::progress::{Cancelled, Progress};
use assembly::assemble;
pub use balance::Closure;
pub(super) use balance::FLOODED;
use balance::{Balanced, RowSums};
pub use blocks::Blocks;
pub(super) use blocks::MANY;
pub use mass::Mass;
use mass::shrink;
pub(super) use polygons::exact;
use raw::{Leaving, Raw};
pub(super) use raw::{Outcome, Selection};
pub use storage::{Storage, StorageKind};

/// Exchange areas between the N coefficients of patches, and what escapes from each.
#[derive(Clone, Debug)]
pub struct Exchange {
    storage: Storage,
    scale: DVector<f64>,
    ends: Ends,
    mass: Mass,
    closure: Closure,
    /// τ, by which what varies within patches was taken.
    shrinkage: f64,
}

/// What rows do not share out among patches, in the unit of the mass.
#[derive(Clone, Debug)]
pub(crate) struct Ends {
    /// What ends elsewhere than on patches, N values: it escapes, is absorbed by carriers or is lost.
    pub leaving: DVector<f64>,
    /// Which shares of it are absorbed by carriers and lost, N values each; none without carriers.
    pub in_carriers: Option<[DVector<f64>; 2]>,
    /// What rows that could not be closed lack, N values: (M·1)_i less Σ_j S_ij and what leaves.
    pub slack: DVector<f64>,
}

/// All of exchange areas but their mass.
pub(crate) struct ExchangeParts {
    pub storage: Storage,
    pub scale: DVector<f64>,
    pub ends: Ends,
    pub closure: Closure,
    pub shrinkage: f64,
}

impl Ends {
    /// What escapes.
    pub fn escape(&self, i: usize) -> f64 {
        match &self.in_carriers {
            Some([absorbed, lost]) => self.leaving[i] * (1.0 - absorbed[i] - lost[i]).max(0.0),
            None => self.leaving[i],
        }
    }

    /// What mirrors and glass absorb.
    pub fn absorbed(&self, i: usize) -> f64 {
        self.in_carriers.as_ref().map_or(0.0, |[absorbed, _]| self.leaving[i] * absorbed[i])
    }

    /// What is lost in paths that met so many mirrors and surfaces of glass that they were given up.
    pub fn lost(&self, i: usize) -> f64 {
        self.in_carriers.as_ref().map_or(0.0, |[_, lost]| self.leaving[i] * lost[i])
    }
}

impl Exchange {
    /// Balances raw exchange areas `storage` and escapes (N values), m², between coefficients of this mass;
    /// the areas of patches are the mass of constant elements.
    ///
    /// `lamps` (N flags) marks those whose entries are known better than the others' and are not to bear
    /// their noise. Rows that would have to be scaled by more than 4 keep [slack](Exchange::slack).
    ///
    /// # Errors
    /// `Cancelled`.
    ///
    /// # Panics
    /// If the dimensions differ or the matrix is not symmetric in shape.
    pub fn new(
        storage: Storage,
        escape: DVector<f64>,
        mass: impl Into<Mass>,
        lamps: &[bool],
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        let leaving = Leaving { all: escape, in_carriers: None };
        let raw = Raw { storage, leaving, is_lamp: lamps.to_vec() };
        Self::balanced(raw, mass.into().in_square_metres(), balance::most_scale(None), progress)
    }

    /// Balances exchange areas and escapes that are known to rounding, in the unit of the mass.
    pub(crate) fn of_known(
        storage: Storage,
        escape: DVector<f64>,
        mass: Mass,
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        let is_lamp = vec![false; mass.len()];
        let raw = Raw { storage, leaving: Leaving { all: escape, in_carriers: None }, is_lamp };
        Self::balanced(raw, mass, balance::most_scale(None), progress)
    }

    /// Balances raw exchange areas by scales of at most `most_scale`.
    fn balanced(
        Raw { mut storage, leaving: Leaving { all: mut leaving, in_carriers }, is_lamp: lamps }: Raw,
        mass: Mass,
        most_scale: f64,
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        let n = mass.len();
        let shape = match &storage {
            Storage::Dense(m) => m.shape(),
            Storage::Sparse(m) => m.shape(),
            Storage::Blocks(m) => (3 * m.patches(), 3 * m.patches()),
        };
        let consistent = shape == (n, n) && leaving.len() == n && lamps.len() == n;
        assert!(consistent, "N sums of the mass, N escapes, N flags and an N × N matrix");
        let sums = RowSums { escape: &leaving, target: mass.sums(), most_scale };
        let Balanced { scale, slack, closure } = if lamps.contains(&true) {
            balance::balance_around_lamps(&mut storage, sums, &lamps, progress)?
        } else {
            balance::balance(&storage, sums, &DVector::repeat(n, 1.0), progress)?
        };
        leaving.component_mul_assign(&scale);
        let ends = Ends { leaving, in_carriers, slack };
        let balanced = Self { storage, scale, ends, mass, closure, shrinkage: 1.0 };
        match balanced.basis() {
            Basis::Constant => Ok(balanced),
            Basis::Linear => balanced.shrunk(most_scale, progress),
        }
    }

    /// Takes what varies within patches by the factor that keeps a bounce from adding energy.
    fn shrunk(self, most_scale: f64, progress: Progress) -> Result<Self, Cancelled> {
        let shrinkage = shrinkage::needed(&self.storage, &self.scale, &self.mass, progress)?;
        if shrinkage == 1.0 {
            return Ok(self);
        }
        let Self { storage, scale, mut ends, mass, closure: before, .. } = self;
        let storage = storage.shrunk(&scale, shrinkage);
        shrink(ends.leaving.as_mut_slice(), shrinkage);
        shrink(ends.slack.as_mut_slice(), shrinkage);
        // Rows close, or lack what they lack, as before but for rounding.
        let start = DVector::repeat(mass.len(), 1.0);
        let target = mass.sums() - &ends.slack;
        let sums = RowSums { escape: &ends.leaving, target: &target, most_scale };
        let Balanced { scale, slack, closure: after } = balance::balance(&storage, sums, &start, progress)?;
        ends.leaving.component_mul_assign(&scale);
        ends.slack += slack;
        let iterations = before.iterations + after.iterations;
        let slack = ends.slack.sum() / mass.sums().sum();
        let closure = Closure { iterations, after: after.after, slack, ..before };
        Ok(Self { storage, scale, ends, mass, closure, shrinkage })
    }

    /// The ideal sphere, S = A Aᵀ / ΣA: every point sees every area alike. Closed forms are known for all its
    /// answers.
    pub fn ideal_sphere(areas: DVector<f64>) -> Self {
        let total = areas.sum();
        let dense = DMatrix::from_fn(areas.len(), areas.len(), |i, j| (areas[i] * areas[j] / total) as f32);
        let escape = DVector::zeros(areas.len());
        let lamps = vec![false; areas.len()];
        Self::new(Storage::Dense(dense), escape, areas, &lamps, Progress::default())
            .expect("a silent observer never cancels")
    }

    /// Exchange areas as they are, `storage` and what escapes (N values) in m²; nothing makes them close.
    ///
    /// # Panics
    /// If the dimensions differ.
    pub fn unbalanced(storage: Storage, escape: DVector<f64>, mass: impl Into<Mass>) -> Self {
        let mass = mass.into().in_square_metres();
        assert_eq!(escape.len(), mass.len(), "one escape per coefficient");
        let closure = Closure { before: 0.0, after: 0.0, iterations: 0, slack: 0.0 };
        let scale = DVector::repeat(mass.len(), 1.0);
        let ends = Ends { leaving: escape, in_carriers: None, slack: DVector::zeros(mass.len()) };
        let as_is = Self { storage, scale, ends, mass, closure, shrinkage: 1.0 };
        let error = as_is.closure_error();
        Self { closure: Closure { before: error, after: error, ..closure }, ..as_is }
    }

    /// Nothing is exchanged between patches of this mass: all of it leaves.
    pub(crate) fn none(mass: Mass) -> Self {
        let n = mass.len();
        let storage = Storage::Sparse(CsMatI::zero((n, n)));
        let ends = Ends { leaving: mass.sums().clone(), in_carriers: None, slack: DVector::zeros(n) };
        let closure = Closure { before: 0.0, after: 0.0, iterations: 0, slack: 0.0 };
        Self { storage, scale: DVector::repeat(n, 1.0), ends, mass, closure, shrinkage: 1.0 }
    }

    /// Turns the rows of patches into raw exchange areas and balances them.
    pub(crate) fn from_rows(
        selection: &Selection,
        kind: StorageKind,
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        let raw = assemble(selection, kind);
        let recipe = selection.rows.recipe;
        let rays = recipe.count.rays / recipe.basis.coefficients() as u32;
        let mass = Mass::of(recipe.basis, selection.patches);
        Self::balanced(raw, mass, balance::most_scale(Some(rays)), progress)
    }

    /// What was balanced before.
    pub(crate) fn from_parts(parts: ExchangeParts, mass: Mass) -> Self {
        let ExchangeParts { storage, scale, ends, closure, shrinkage } = parts;
        Self { storage, scale, ends, mass, closure, shrinkage }
    }

    /// T and D.
    pub(crate) fn raw(&self) -> (&Storage, &DVector<f64>) {
        (&self.storage, &self.scale)
    }

    /// Number of coefficients N: of patches, for constant elements.
    pub fn len(&self) -> usize {
        self.mass.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.mass.is_empty()
    }

    /// The mass M of the basis functions.
    pub fn mass(&self) -> &Mass {
        &self.mass
    }

    /// Which basis functions.
    pub fn basis(&self) -> Basis {
        self.mass.basis()
    }

    /// M·1, N values in its unit.
    pub(crate) fn sums(&self) -> &DVector<f64> {
        self.mass.sums()
    }

    /// S_ij in the unit of the mass.
    pub(crate) fn entry(&self, i: usize, j: usize) -> f64 {
        // The product of the scales first, and it commutes: the same bits for (i, j) and (j, i).
        (self.scale[i] * self.scale[j]) * self.storage.get(i, j)
    }

    /// S_ij / (M·1)_i, for constant elements the form factor F_ij = S_ij / A_i.
    pub fn form_factor(&self, i: usize, j: usize) -> f64 {
        self.entry(i, j) / self.sums()[i]
    }

    /// What rows do not share out among patches.
    pub(crate) fn ends(&self) -> &Ends {
        &self.ends
    }

    /// How well rows close, before and after balancing.
    pub fn closure(&self) -> &Closure {
        &self.closure
    }

    /// By which factor τ, ½ to 1, what varies within patches had to be taken for a bounce not to add energy;
    /// 1 with enough rays, and for constant elements.
    pub fn shrinkage(&self) -> f64 {
        self.shrinkage
    }

    /// Bytes that the matrix takes.
    pub fn bytes(&self) -> u64 {
        match &self.storage {
            Storage::Dense(m) => 4 * m.len() as u64,
            Storage::Sparse(m) => 8 * m.nnz() as u64 + 8 * m.rows() as u64,
            Storage::Blocks(m) => m.bytes(),
        }
    }

    /// `dense` or `sparse`.
    pub fn storage_name(&self) -> &'static str {
        match self.storage {
            Storage::Dense(_) => "dense",
            Storage::Sparse(_) | Storage::Blocks(_) => "sparse",
        }
    }

    /// y ← S x for N × c matrices in the unit of the mass, overwriting y. The same bits whatever the number
    /// of threads.
    ///
    /// # Panics
    /// If the shapes differ.
    pub(crate) fn apply(&self, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
        assert!(x.nrows() == self.len() && x.shape() == y.shape(), "x and y are N × c");
        let mut scaled = x.clone();
        scaled.column_iter_mut().for_each(|mut column| column.component_mul_assign(&self.scale));
        self.storage.multiply(&scaled, y);
        y.column_iter_mut().for_each(|mut column| column.component_mul_assign(&self.scale));
    }

    /// Calls `f(j, S_ij)`, in the unit of the mass, for every entry of row i that is not zero.
    pub(crate) fn for_entries(&self, i: usize, mut f: impl FnMut(usize, f64)) {
        let scale = self.scale[i];
        self.storage.for_row(i, |j, raw| f(j, (scale * self.scale[j]) * raw));
    }

    /// The largest |S_ij − S_ji| relative to the lesser row sum M·1, recomputed; 0 unless something is
    /// damaged.
    pub fn reciprocity_error(&self) -> f64 {
        let error_of = |i: usize| {
            let mut most = 0.0f64;
            self.for_entries(i, |j, s| {
                let off = |other: f64| (s - other).abs() / self.sums()[i].min(self.sums()[j]);
                // A dense row may be read as a column, which is the same only if all is well.
                most = match &self.storage {
                    Storage::Dense(_) => most.max(off(self.entry(i, j))),
                    Storage::Sparse(_) | Storage::Blocks(_) => most.max(off(self.entry(j, i))),
                };
            });
            most
        };
        (0..self.len()).into_par_iter().map(error_of).reduce(|| 0.0, f64::max)
    }

    /// The largest |D_i (T D)_i + what leaves + slack_i − (M·1)_i| / (M·1)_i, recomputed.
    pub fn closure_error(&self) -> f64 {
        let n = self.len();
        let mut sums = DMatrix::zeros(n, 1);
        self.apply(&DMatrix::repeat(n, 1, 1.0), &mut sums);
        let off = |i: usize| sums[i] + self.ends.leaving[i] + self.ends.slack[i] - self.sums()[i];
        (0..n).map(|i| off(i).abs() / self.sums()[i]).fold(0.0, f64::max)
    }
}

/// In m².
impl Exchange {
    /// M·1, N values: areas A_i for constant elements, a third of them three times each for linear ones.
    pub fn areas(&self) -> DVector<f64> {
        self.mass.areas()
    }

    /// S_ij.
    pub fn exchange_area(&self, i: usize, j: usize) -> f64 {
        self.mass.unit() * self.entry(i, j)
    }

    /// Calls `f(j, S_ij)` for every entry of row i that is not zero.
    pub fn for_row(&self, i: usize, mut f: impl FnMut(usize, f64)) {
        self.for_entries(i, |j, entry| f(j, self.mass.unit() * entry));
    }

    /// S x for N × c matrices; the same bits whatever the number of threads.
    ///
    /// # Panics
    /// If `x` has not N rows.
    pub fn times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut product = DMatrix::zeros(x.nrows(), x.ncols());
        self.apply(x, &mut product);
        product * self.mass.unit()
    }

    /// What ends elsewhere than on patches, N values: it escapes, is absorbed by carriers or is lost.
    pub fn leaving(&self) -> DVector<f64> {
        &self.ends.leaving * self.mass.unit()
    }

    /// What rows lack that no scaling could close, as where faces coincide: (M·1)_i less Σ_j S_ij and what
    /// leaves. N values, 0 for rows that close. The light it stands for is missing from the answer.
    pub fn slack(&self) -> DVector<f64> {
        &self.ends.slack * self.mass.unit()
    }

    /// What escapes, ∫ φ_i F_i∞ dA; for constant elements S_i∞ = A_i F_i∞.
    pub fn escape(&self, i: usize) -> f64 {
        self.mass.unit() * self.ends.escape(i)
    }

    /// What mirrors and glass absorb, as [`Exchange::escape`].
    pub fn absorbed(&self, i: usize) -> f64 {
        self.mass.unit() * self.ends.absorbed(i)
    }

    /// What is lost in paths that met so many mirrors and surfaces of glass that they were given up, as
    /// [`Exchange::escape`].
    pub fn lost(&self, i: usize) -> f64 {
        self.mass.unit() * self.ends.lost(i)
    }
}
