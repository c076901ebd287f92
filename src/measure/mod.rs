//! Measure: how good an answer is, and what it is made from.
//!
//! [`PathTracer`] is the independent witness; [`Comparison`] holds an answer against it, [`Study`] many
//! answers, with what each took. [`Energy`] and the health reports need no witness: they look at the answer
//! itself.

mod accuracy;
mod comparison;
mod energy;
mod error_bars;
mod health;
mod path_tracer;
mod study;
mod undershoot;
mod verdict;

use crate::patches::PatchError;
use crate::progress::Cancelled;
use crate::solve::SolveError;
use crate::transport::TransportError;
pub use accuracy::{AccuracyStep, Accurate, Ending, Goal, Resource, Setting, Tolerated, reach};
pub use comparison::{
    Agreement, AgreementTest, Comparison, Difference, MeshError, OrderOptions, OrderRow, ReferenceError,
    ReferenceRow, RelativeRms, Worst,
};
pub use energy::Energy;
pub use error_bars::{ErrorBars, ErrorBudget, ErrorPart};
pub use health::{
    Finding, FrontDoubt, Grade, ObjectOverlap, front_doubts, mesh_health, odd_placement, operator_health,
    overlaps,
};
pub use path_tracer::{Budget, Estimate, PathOptions, PathTraced, PathTracer};

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
    /// Nothing would end the work, or before it begins.
    #[error(
        "a path tracer needs a budget: a standard error, a time or a number of paths, each above 0 where it is given"
    )]
    Budget,
    /// From reading a table of references.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
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
