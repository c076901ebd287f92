//! Goal: what a search for accuracy is asked for, and what it found.

use serde::Serialize;

use crate::measure::{Level, Verdict};
use crate::patches::Patches;
use crate::transport::FormFactors;

/// When an answer is good enough. With neither an error nor a time, the first is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// What the error of irradiance by face is not to exceed on any object that has a hundredth of all
    /// patches, 95 times of 100.
    pub error: Option<Tolerated>,
    /// Seconds within which steps are to end.
    pub seconds: Option<f64>,
}

/// How much error is good enough, as an area-weighted root mean square over the faces of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerated {
    /// A share of its root mean square irradiance.
    Relative(f64),
    /// W·m⁻².
    Irradiance(f64),
}

/// One answer on the way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AccuracyStep {
    /// Number of patches.
    pub patches: usize,
    /// Rays per patch.
    pub rays: u32,
    /// Wall-clock seconds it took.
    pub seconds: f64,
    /// The error to be expected on the object where it is the largest.
    pub relative_rms: f64,
    /// What it does not exceed in 95 cases of 100.
    pub upper95: f64,
    /// The part of the expected error that is mesh.
    pub mesh: f64,
    /// The part of it that is noise.
    pub noise: f64,
    /// Whether it can be relied on.
    pub verdict: Level,
}

/// How the search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// The goal is met, by a good answer; or, with a time alone, that time is used.
    Reached,
    /// The error bars meet the goal, or the time is used, but the verdict on the answer is not good: the bars
    /// do not know of what is wrong.
    Doubtful,
    /// There is not enough of something for it; what it would take is foretold.
    Short {
        /// What there is not enough of.
        of: Resource,
        /// What it would take.
        needed: Setting,
        /// Seconds that would take.
        seconds: f64,
    },
}

/// What accuracy is paid with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resource {
    /// Time.
    Time,
    /// Memory.
    Memory,
    /// What errors fall by as patches and rays grow: further steps would not help.
    Effect,
}

/// A number of patches, and of rays per patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Number of patches.
    pub patches: f64,
    /// Rays per patch.
    pub rays: f64,
}

/// The best answer that was found.
#[derive(Debug)]
pub struct Accurate<'s> {
    /// The cut.
    pub patches: Patches<'s>,
    /// Form factors, with their rays.
    pub factors: FormFactors,
    /// All steps, in order.
    pub steps: Vec<AccuracyStep>,
    /// Whether the goal is met.
    pub ending: Ending,
    /// Whether the answer can be relied on.
    pub verdict: Verdict,
}
