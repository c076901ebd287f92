//! Field: the solution itself as red, green and blue, patch by patch or smoothed.

use glam::DVec3;
use nalgebra::DMatrix;

use super::super::{SmoothField, to_rgb};
use crate::patches::{Barycentrics, Basis, Patches};
use crate::trace::Tracer;

/// Radiance wherever there are patches.
pub(super) enum Field<'a, 's> {
    Flat(Elements<'a, 's>),
    Smooth(SmoothField),
}

impl<'a, 's> Field<'a, 's> {
    /// As it is over each patch.
    pub fn flat(patches: &'a Patches<'s>, radiance: &DMatrix<f64>) -> Self {
        Self::Flat(Elements::new(patches, radiance))
    }

    /// Continuous within each smooth surface.
    pub fn smooth(tracer: &Tracer, patches: &Patches, radiance: &DMatrix<f64>) -> Self {
        let flat: Vec<DVec3> = rgb_rows(radiance).collect();
        let field = DMatrix::from_fn(flat.len(), 3, |i, c| flat[i][c]);
        Self::Smooth(SmoothField::new(tracer, patches, &field))
    }

    pub fn at(&self, patch: usize, point: Barycentrics) -> DVec3 {
        match self {
            Self::Flat(elements) => elements.at(patch, point),
            Self::Smooth(field) => {
                let mut rgb = [0.0; 3];
                rgb.iter_mut().zip(field.at(patch, point)).for_each(|(x, value)| *x = value);
                rgb.into()
            }
        }
    }
}

/// Radiance as it was solved, which may jump from patch to patch.
pub(super) struct Elements<'a, 's> {
    patches: &'a Patches<'s>,
    basis: Basis,
    /// Per coefficient.
    rgb: Vec<DVec3>,
}

impl<'a, 's> Elements<'a, 's> {
    pub fn new(patches: &'a Patches<'s>, radiance: &DMatrix<f64>) -> Self {
        Self { patches, basis: Basis::of(patches, radiance), rgb: rgb_rows(radiance).collect() }
    }

    /// The radiance at a point of a patch, given as a point of the patch's face.
    #[inline]
    pub fn at(&self, patch: usize, point: Barycentrics) -> DVec3 {
        match self.basis {
            Basis::Constant => self.rgb[patch],
            Basis::Linear => {
                let [v, w] = self.patches.weights_in(self.patches.slot_of_patch(patch), point);
                self.rgb[3 * patch] * (1.0 - v - w)
                    + self.rgb[3 * patch + 1] * v
                    + self.rgb[3 * patch + 2] * w
            }
        }
    }
}

/// Each coefficient of the radiance as red, green and blue.
fn rgb_rows(radiance: &DMatrix<f64>) -> impl Iterator<Item = DVec3> {
    radiance.row_iter().map(|row| to_rgb(row.transpose().as_slice()).into())
}
