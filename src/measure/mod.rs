//! Measure: how good an answer is, and what it is made from.
//!
//! [`Comparison`] holds an answer against the independent witness, a [path tracer](crate::reference),
//! [`Study`] many answers, with what each took. [`Energy`] and the health reports need no witness: they look
//! at the answer itself.

mod accuracy;
mod comparison;
mod darkness;
mod energy;
mod error_bars;
mod health;
mod study;
mod undershoot;
mod verdict;
mod words;

use crate::patches::PatchError;
use crate::progress::Cancelled;
use crate::reference::PathError;
use crate::solve::SolveError;
use crate::transport::TransportError;
pub use accuracy::{
    AccuracyStep, Accurate, Ending, Goal, Resource, Setting, Tolerated, missed, reach, receive,
};
pub use comparison::{
    Agreement, AgreementTest, Comparison, Difference, MeshError, OrderOptions, OrderRow, RelativeRms, Worst,
};
pub use darkness::{DARK, Darkness, lit_points, unlit_points};
pub use energy::Energy;
pub use error_bars::{BOUND_95, ErrorBars, ErrorBudget, ErrorPart, FITTED, Fitted, GroupError, ReceiverBars};
pub use health::{
    Finding, FrontDoubt, Grade, ObjectOverlap, front_doubts, mesh_health, odd_placement, operator_health,
    overlaps,
};
pub use study::{
    Cell, Conclusions, FaceError, Grid, LeftOut, OrderTrend, Reading, ReferenceSide, Slope, Solving, Study,
    StudyOptions, StudyReference, StudyRow, StudySolver, Target, Trend, Turn, Want,
};
pub use undershoot::Undershoot;
pub use verdict::{Answer, Cause, Level, Reason, Verdict};

/// Why something could not be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// From tracing a reference.
    #[error(transparent)]
    Paths(#[from] PathError),
    /// From cutting the scene anew.
    #[error(transparent)]
    Patches(#[from] PatchError),
    /// From tracing form factors anew.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// From solving anew.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The observer asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl MeasureError {
    /// Whether a coarser cut would do: there are too many patches, or their matrix takes too much memory.
    pub(crate) fn is_too_large(&self) -> bool {
        matches!(
            self,
            Self::Patches(PatchError::TooMany { .. }) | Self::Transport(TransportError::Memory { .. })
        )
    }
}
