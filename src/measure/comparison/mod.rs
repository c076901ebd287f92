//! Comparison: the matrix answer and every order of its series against the path-traced reference.

mod agreement;
mod constants;
mod difference;
mod faces;
mod mesh_error;
mod orders;

use nalgebra::DMatrix;

pub use agreement::{Agreement, AgreementTest};
pub use difference::{Difference, Worst};
pub use faces::RelativeRms;
pub use mesh_error::MeshError;
pub use orders::{OrderOptions, OrderRow};

use crate::patches::Patches;
use crate::reference::PathTraced;

/// An answer beside its path-traced reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Patch by patch.
    pub by_patch: Difference,
    /// Face by face: averages, which patches' own errors leave alone.
    pub by_face: Difference,
    /// How much the answer changes with patches half as long (twice, where half does not fit), by patch;
    /// relative root mean square.
    pub mesh_change: f64,
    /// What comes of it all.
    pub agreement: Agreement,
    /// What was looked at, and how each thing came out.
    pub reasons: Vec<AgreementTest>,
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
        let change = agreement::Change::new(patches, reference, mesh);
        let reasons = agreement::reasons(&of_patches, &by_patch, &by_face, &change);
        let agreement = Agreement::of(&reasons);
        Self { by_patch, by_face, mesh_change: change.by_patch, agreement, reasons }
    }

    /// The agreement, in a sentence about the test that decides it.
    pub fn verdict(&self) -> String {
        let explained = match self.agreement {
            Agreement::WithinNoise => return "agrees within noise".into(),
            Agreement::MeshExplains => "the mesh explains",
            Agreement::MeshTooCoarse => "the mesh is too coarse to explain",
            Agreement::NothingExplains => "nothing explains",
        };
        let decides = |test: &&AgreementTest| test.agreement == self.agreement;
        let (what, found, uncertainty) =
            self.reasons.iter().find(decides).map_or(("", 0.0, 0.0), |t| (t.what, t.found, t.uncertainty));
        let place = match what {
            "faces" => " by face",
            "mean" => " in its mean",
            "worst patch" => " of the typical irradiance at one patch",
            _ => "",
        };
        let [found, uncertainty] = [100.0 * found.abs(), 100.0 * uncertainty];
        format!("differs by {found:.2} % ± {uncertainty:.2} %{place}, which {explained}")
    }
}
