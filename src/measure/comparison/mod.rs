//! Comparison: the matrix answer and every order of its series against the path-traced reference.

mod difference;
mod faces;
mod mesh_error;
mod orders;
mod reference;
mod verdict;

use nalgebra::DMatrix;

pub use difference::{Difference, Worst};
pub use faces::RelativeRms;
pub use mesh_error::MeshError;
pub use orders::{OrderOptions, OrderRow};
pub use reference::{ReferenceError, ReferenceRow};
pub use verdict::{Agreement, Reason};

use super::PathTraced;
use crate::patches::Patches;

/// An answer beside its path-traced reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Patch by patch.
    pub by_patch: Difference,
    /// Face by face: averages, which patches' own errors leave alone.
    pub by_face: Difference,
    /// How much the answer changes with patches half as long (twice, where half does not fit), by patch; relative root mean square.
    pub mesh_change: f64,
    /// What comes of it all.
    pub agreement: Agreement,
    /// What was looked at, and how each thing came out.
    pub reasons: Vec<Reason>,
}

impl Comparison {
    /// Compares irradiance (n × c, W·m⁻²) with a reference, in the knowledge of the mesh error.
    ///
    /// # Panics
    /// If the three do not belong to the same n patches.
    pub fn new(
        patches: &Patches,
        irradiance: &DMatrix<f64>,
        reference: &PathTraced,
        mesh: &MeshError,
    ) -> Self {
        let of_patches = difference::patches(irradiance, reference);
        let of_faces = difference::faces(patches, irradiance, reference);
        let (by_patch, by_face) = (Difference::over(&of_patches), Difference::over(&of_faces));
        let change = verdict::Change::new(patches, reference, mesh);
        let reasons = verdict::reasons(&of_patches, &by_patch, &by_face, &change);
        let agreement = Agreement::of(&reasons);
        Self { by_patch, by_face, mesh_change: change.by_patch, agreement, reasons }
    }

    /// The verdict, in a sentence.
    pub fn verdict(&self) -> String {
        let Difference { rms, uncertainty, .. } = self.by_patch;
        let differs = format!("differs by {:.2} % ± {:.2} %", 100.0 * rms, 100.0 * uncertainty);
        match self.agreement {
            Agreement::WithinNoise => "agrees within noise".into(),
            Agreement::MeshExplains => format!("{differs}, which the mesh explains"),
            Agreement::NothingExplains => format!("{differs}, which nothing explains"),
        }
    }
}
