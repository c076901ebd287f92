//! Summary: `solution.json`, everything a script wants to know of a run.

use std::io::{self, Write};

use serde::Serialize;

use super::Photometry;
use crate::measure::{AccuracyStep, Energy, ErrorBudget, GroupError, Undershoot, Verdict};
use crate::render::to_rgb;
use crate::solve::{Report, Series, Solution};
use crate::transport::{Closure, Plan};

/// Writes `summary` as JSON.
///
/// # Errors
/// Those of `writer`.
pub fn write_summary(writer: &mut dyn Write, summary: &Summary) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *writer, summary)?;
    writeln!(writer)
}

/// The content of `solution.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The scene's name.
    pub scene: String,
    /// This program's version.
    pub version: &'static str,
    /// The seed of all random sequences.
    pub seed: u64,
    /// Number of threads.
    pub threads: usize,
    /// Number of patches (unknowns).
    pub patches: usize,
    /// Rays per patch.
    pub rays: u32,
    /// Number of channels that were solved.
    pub channels: usize,
    /// How light varies over a patch: `constant` or `linear`.
    pub basis: &'static str,
    /// How exchange areas are stored: `dense` or `sparse`.
    pub storage: &'static str,
    /// What the scene calls for, what was simulated and what it was predicted to cost.
    pub plan: Plan,
    /// Where time and memory went.
    pub stages: Vec<Stage>,
    /// The chosen solver's report.
    pub solver: Report,
    /// The series' report.
    pub series: SeriesSummary,
    /// Where the emitted power went, W.
    pub energy: EnergySummary,
    /// How well form factors close.
    pub closure: Closure,
    /// Photometry by material, object, light and receiver (m², lm, lx and cd/m²), where it was asked for or
    /// there are receivers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub photometry: Vec<Photometry>,
    /// How far radiance falls below zero within patches; not at all for constant elements.
    pub undershoot: Undershoot,
    /// How wrong irradiance is, and why, on the object or at the receiver where it is the most wrong.
    pub error: GroupError,
    /// How wrong irradiance by face is over all faces, and why.
    pub error_of_all: ErrorBudget,
    /// The same for every object, material and receiver by itself.
    pub errors: Vec<GroupError>,
    /// What each step towards an accuracy bought, where one was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<AccuracyStep>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Whether the answer can be relied on.
    pub verdict: Verdict,
}

/// A stage of the run.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// load, build, patch, trace, balance, light, errors, factor, solve, series, receive, render or write.
    pub name: &'static str,
    /// Wall-clock time.
    pub seconds: f64,
    /// Bytes that its result takes, 0 where that is next to nothing.
    pub bytes: u64,
}

/// The Neumann series in brief.
#[derive(Clone, Debug, Serialize)]
pub struct SeriesSummary {
    /// The order at which it was truncated.
    pub order: usize,
    /// ‖E − (I − K)L‖∞ / ‖E‖∞.
    pub residual: f64,
    /// The part of the flux that is still on its way, as in [`Report::remaining_flux`].
    pub remaining_flux: f64,
    /// Whether it ended at its highest order before it met the tolerance.
    pub truncated: bool,
    /// Bound on the relative error, as in [`Report::bound`].
    pub bound: f64,
    /// ‖L − L_solver‖∞ / ‖L_solver‖∞, how far the two solvers are apart.
    pub difference: f64,
    /// What each order adds.
    pub bounces: Vec<BounceSummary>,
}

/// One order of the series.
#[derive(Clone, Debug, Serialize)]
pub struct BounceSummary {
    /// k.
    pub order: usize,
    /// Radiant flux that KᵏE adds, W.
    pub flux: [f64; 3],
    /// Relative residual of the sum up to here.
    pub residual: f64,
    /// The part of the flux that the next order adds.
    pub remaining_flux: f64,
    /// Bound on the relative error of the sum up to here, as in [`Report::bound`].
    pub bound: f64,
}

impl SeriesSummary {
    /// Sums up a series beside another solver's solution.
    pub fn new(series: &Series, solution: &Solution) -> Self {
        let bounces = series.bounces.iter().map(|b| BounceSummary {
            order: b.order,
            flux: to_rgb(&b.flux),
            residual: b.residual,
            remaining_flux: b.remaining_flux,
            bound: b.bound,
        });
        let (l, report) = (&series.solution.radiance, &series.solution.report);
        // Where nothing shines or reflects, both are 0 and agree.
        let difference = match (l - &solution.radiance).amax() {
            0.0 => 0.0,
            difference => difference / solution.radiance.amax(),
        };
        Self {
            order: series.order(),
            residual: report.residual,
            remaining_flux: report.remaining_flux,
            truncated: report.truncated,
            bound: report.bound,
            difference,
            bounces: bounces.collect(),
        }
    }
}

/// [`Energy`] with three numbers a term, whatever the number of channels.
#[derive(Clone, Debug, Serialize)]
pub struct EnergySummary {
    /// What lamps emit and lights without area deliver.
    pub emitted: [f64; 3],
    /// What diffuse surfaces absorb.
    pub absorbed: [f64; 3],
    /// What leaves the scene.
    pub escaped: [f64; 3],
    /// What mirrors and glass absorb.
    pub carriers: [f64; 3],
    /// What paths lose that are cut short.
    pub lost: [f64; 3],
    /// What is missing because rows of form factors could not be closed.
    pub slack: [f64; 3],
    /// (emitted − the rest) / emitted, the largest over channels.
    pub imbalance: f64,
    /// One standard error of the imbalance; 0 where no term is estimated apart from the others.
    pub imbalance_error: f64,
}

impl From<&Energy> for EnergySummary {
    fn from(energy: &Energy) -> Self {
        Self {
            emitted: to_rgb(&energy.emitted),
            absorbed: to_rgb(&energy.absorbed),
            escaped: to_rgb(&energy.escaped),
            carriers: to_rgb(&energy.carriers),
            lost: to_rgb(&energy.lost),
            slack: to_rgb(&energy.slack),
            imbalance: energy.imbalance,
            imbalance_error: energy.imbalance_error,
        }
    }
}
