//! Measure: how good an answer is, and what it is made from.

mod comparison;
mod energy;
mod health;
mod path_tracer;

pub use comparison::{ReferenceRow, RelativeRms};
pub use energy::Energy;
pub use health::{Finding, Verdict, mesh_health, operator_health};
pub use path_tracer::{Budget, Estimate, PathError, PathOptions, PathTraced, PathTracer};
