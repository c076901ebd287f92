//! Field: the solution itself as red, green and blue, patch by patch or smoothed.

use glam::DVec3;
use nalgebra::DMatrix;

use super::super::{SmoothField, to_rgb};
use crate::patches::{Barycentrics, Patches};
use crate::trace::Tracer;

/// Radiance wherever there are patches.
pub(super) enum Field {
    Flat(Vec<DVec3>),
    Smooth(SmoothField),
}

impl Field {
    /// Constant over each patch.
    pub fn flat(radiance: &DMatrix<f64>) -> Self {
        Self::Flat(rgb_rows(radiance).collect())
    }

    /// Continuous within each smooth surface.
    pub fn smooth(tracer: &Tracer, patches: &Patches, radiance: &DMatrix<f64>) -> Self {
        let flat: Vec<DVec3> = rgb_rows(radiance).collect();
        let field = DMatrix::from_fn(patches.len(), 3, |i, c| flat[i][c]);
        Self::Smooth(SmoothField::new(tracer, patches, &field))
    }

    pub fn at(&self, patch: usize, point: Barycentrics) -> DVec3 {
        match self {
            Self::Flat(rgb) => rgb[patch],
            Self::Smooth(field) => {
                let mut rgb = [0.0; 3];
                rgb.iter_mut().zip(field.at(patch, point)).for_each(|(x, value)| *x = value);
                rgb.into()
            }
        }
    }
}

/// Each patch's radiance as red, green and blue.
pub(super) fn rgb_rows(radiance: &DMatrix<f64>) -> impl Iterator<Item = DVec3> {
    radiance.row_iter().map(|row| to_rgb(row.transpose().as_slice()).into())
}
