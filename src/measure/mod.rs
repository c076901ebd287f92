//! Measure: how good an answer is.

mod energy;

pub use energy::Energy;
