//! Measure: how good an answer is, and what it is made from.

mod comparison;
mod energy;
mod health;
mod undershoot;

pub use comparison::{ReferenceRow, RelativeRms};
pub use energy::Energy;
pub use health::{Finding, Verdict, mesh_health, operator_health};
pub use undershoot::Undershoot;
