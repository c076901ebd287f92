//! Transport: form factors, exchange areas and the operator K = diag(ρ) F, or R F with [sheets](Reflection)
//! that let light through.
//!
//! [`FormFactors`] are geometry only: which fraction of what a patch sends out lands on each other patch.
//! [`Transport`] adds the reflectances and is the operator that the solvers invert. The two stay apart so
//! that other reflectances, lamps and lamp powers cost no rays.

mod batches;
mod exchange;
mod form_factors;
mod lanczos;
mod operator;
mod plan;
mod reflection;
mod rows;
mod sources;
mod symmetric_system;

pub(crate) use batches::variance_of_mean;
pub use exchange::{Blocks, Closure, Exchange, Mass, Storage, StorageKind};
pub use form_factors::{
    DISAGREE, Disagreement, FactorsFileError, FormFactors, GroupFactor, Keep, Merged, Occlusion, Reuse,
    Spread, TraceOptions, Unmet,
};
pub(crate) use lanczos::{ends_of_spectrum, uneven};
pub use operator::Transport;
pub(crate) use plan::is_quickly_factored;
pub use plan::{Cost, Effect, Forecast, Plan, Solving, StageCost, Switches, SwitchesError, Work};
pub use reflection::Reflection;
pub(crate) use rows::BATCHES;
pub use rows::Shots;
pub(crate) use sources::LampFlux;
pub use sources::{
    BrightLight, CarriedLight, LightOptions, Received, ReceiverNoise, ReceiverRows, Sources, check_receivers,
};
pub(crate) use symmetric_system::{SymmetricSystem, solve_symmetric};

use crate::patches::PatchError;
use crate::progress::Cancelled;

/// Why an operator could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransportError {
    /// The number of rays does not fit the random sequences.
    #[error("{rays} rays per patch: choose between {BATCHES} and {most}")]
    Rays {
        /// The wanted number.
        rays: u32,
        /// The greatest possible number.
        most: u32,
    },
    /// Light reaches nothing, so there is nothing to solve.
    #[error("no patch is reached by light; does a lamp's front face into the scene?")]
    Dark,
    /// The matrix would not fit.
    #[error(
        "form factors for {patches} patches would take {}, more than the {} allowed; raise --memory, or use fewer --patches or --rays",
        readable(*needed), readable(*limit)
    )]
    Memory {
        /// The number of patches.
        patches: usize,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// The rows of receivers would not fit.
    #[error(
        "{points} points of receivers would take {}, more than the {} allowed; give fewer `points` to receiver {largest}, or raise --memory",
        readable(*needed), readable(*limit)
    )]
    Receivers {
        /// The number of points of all receivers.
        points: usize,
        /// The receiver that has the most.
        largest: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// Light could never leave or be absorbed.
    #[error(
        "light is trapped: {} {} all light on and nothing seen from there absorbs or lets light out; lower a reflectance (Kd), or its sum with a transmittance, below 1 or open the scene",
        materials.join(", "),
        if materials.len() == 1 { "passes" } else { "pass" }
    )]
    Unsolvable {
        /// The materials of the closed set of patches that loses nothing.
        materials: Vec<String>,
    },
    /// Carriers treat more channels differently than a ray can tell apart.
    #[error(
        "mirrors, metals and glass have {tones} different colours over the channels; at most {most} are told apart"
    )]
    Tones {
        /// Channels that differ.
        tones: usize,
        /// The greatest possible number.
        most: usize,
    },
    /// The rays are needed and were not kept.
    #[error("the rays of these form factors were not kept; trace with `Keep::Rays`")]
    NoRays,
    /// A file of saved form factors can't be used.
    #[error(transparent)]
    File(#[from] FactorsFileError),
    /// A scene can't be cut as saved form factors ask.
    #[error(transparent)]
    Patches(#[from] PatchError),
    /// The observer asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A number of bytes, for people.
pub(crate) fn readable(bytes: u64) -> String {
    const UNITS: [(f64, &str); 4] = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let bytes = bytes as f64;
    let unit = UNITS.into_iter().find(|(size, _)| bytes >= *size);
    unit.map_or(format!("{bytes} bytes"), |(size, name)| format!("{:.1} {name}", bytes / size))
}
