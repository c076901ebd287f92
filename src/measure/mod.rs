//! Measure: how good an answer is.

mod comparison;
mod energy;

pub use comparison::{ReferenceRow, RelativeRms};
pub use energy::Energy;
