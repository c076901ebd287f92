//! Faces: irradiance by face, and how large fields over faces are beside it.

use nalgebra::DMatrix;

use crate::patches::{FaceRow, Patches};
use crate::scene::Side;

/// Irradiance by face, and sums over faces relative to it.
pub(super) struct Faces {
    pub irradiance: Vec<FaceRow>,
    /// Per patch, its face and side's row, and what part of that it is; nothing for some faces alone.
    place: Vec<(usize, f64)>,
}

impl Faces {
    pub fn new(patches: &Patches, irradiance: &DMatrix<f64>) -> Self {
        let irradiance = patches.average_by_face(irradiance);
        let mut place = vec![(0, 0.0); patches.len()];
        for (f, row) in irradiance.iter().enumerate() {
            let on_face = patches.patches_of(row.face, row.side);
            on_face.for_each(|i| place[i] = (f, patches.area(i) / row.area));
        }
        Self { irradiance, place }
    }

    /// Some of the rows by themselves.
    pub fn of_rows(&self, rows: &[usize]) -> Self {
        Self { irradiance: rows.iter().map(|&row| self.irradiance[row].clone()).collect(), place: Vec::new() }
    }

    /// Points that count alike, by their irradiance (m × c).
    pub fn of_points(irradiance: &DMatrix<f64>) -> Self {
        let mean = |i: usize| irradiance.row(i).iter().copied().collect();
        let row = |i: usize| FaceRow { face: i, side: Side::Front, area: 1.0, mean: mean(i) };
        Self { irradiance: (0..irradiance.nrows()).map(row).collect(), place: Vec::new() }
    }

    /// Averages a field over faces: a row per face and side.
    pub fn means(&self, field: &DMatrix<f64>) -> DMatrix<f64> {
        let mut means = DMatrix::zeros(self.irradiance.len(), field.ncols());
        for (mut mean, column) in means.column_iter_mut().zip(field.column_iter()) {
            column.iter().zip(&self.place).for_each(|(x, &(f, part))| mean[f] += part * x);
        }
        means
    }

    /// ΣA x over faces and channels.
    fn sum(&self, x: impl Fn(usize, usize) -> f64) -> f64 {
        let of_face =
            |(f, row): (usize, &FaceRow)| row.area * (0..row.mean.len()).map(|c| x(f, c)).sum::<f64>();
        self.irradiance.iter().enumerate().map(of_face).sum()
    }

    /// ΣA H².
    fn whole(&self) -> f64 {
        self.sum(|f, c| self.irradiance[f].mean[c].powi(2))
    }

    /// √(ΣA H² / ΣA).
    pub fn typical(&self) -> f64 {
        (self.whole() / self.sum(|_, _| 1.0).max(f64::MIN_POSITIVE)).sqrt()
    }

    /// √(ΣA x / ΣA H²); where there is no light at all, 1 of what is more than nothing.
    pub fn relative(&self, squared: impl Fn(usize, usize) -> f64) -> f64 {
        match (self.sum(squared), self.whole()) {
            (0.0, _) => 0.0,
            (_, 0.0) => 1.0,
            // What is known but for noise may come out below nothing.
            (part, whole) => (part.max(0.0) / whole).sqrt(),
        }
    }

    /// Per batch ΣA x² / ΣA H².
    pub fn squares(&self, batches: &[DMatrix<f64>]) -> Vec<f64> {
        batches.iter().map(|x| self.relative(|f, c| x[(f, c)].powi(2)).powi(2)).collect()
    }
}
