//! Study: the tables and the words of a study of accuracy against time.

mod table;
mod words;

use serde::Serialize;

use super::Stage;
use crate::measure::{Conclusions, Grid, LeftOut, Study, StudyRow};
use crate::parallel;

pub use table::{read_study, write_study_reference, write_study_table};
pub use words::write_study_report;

/// Everything that a study has found, for `--json`.
#[derive(Clone, Debug, Serialize)]
pub struct StudySummary {
    /// The scene's name.
    pub scene: String,
    /// This program's version.
    pub version: &'static str,
    /// The seed of all random sequences.
    pub seed: u64,
    /// Number of threads.
    pub threads: usize,
    /// How light varies over a patch: `constant` or `linear`.
    pub basis: &'static str,
    /// What was tried.
    pub grid: Grid,
    /// Paths of the reference.
    pub reference_paths: u64,
    /// Seconds that they took.
    pub reference_seconds: f64,
    /// Every way of solving, as in `study.csv`.
    pub rows: Vec<StudyRow>,
    /// How many of them were taken over from an earlier run.
    pub taken_over: usize,
    /// What was left out for lack of time or memory.
    pub left_out: Vec<LeftOut>,
    /// Seconds that this grid would take whole.
    pub seconds_for_all: f64,
    /// What the rows say.
    pub conclusions: Conclusions,
    /// Where the time of this run went.
    pub stages: Vec<Stage>,
}

impl StudySummary {
    /// Sums up a study; none before it has a reference.
    pub fn new(study: &Study, stages: Vec<Stage>) -> Option<Self> {
        let reference = study.reference()?;
        let scene = study.scene();
        Some(Self {
            scene: scene.name().to_owned(),
            version: env!("CARGO_PKG_VERSION"),
            seed: study.options().seed,
            threads: parallel::threads(),
            basis: study.options().basis.name(),
            grid: study.grid().clone(),
            reference_paths: reference.paths,
            reference_seconds: reference.seconds,
            rows: study.rows().to_vec(),
            taken_over: study.taken_over(),
            left_out: study.left_out().to_vec(),
            seconds_for_all: study.seconds_for_all(),
            conclusions: Conclusions::new(study.rows(), reference),
            stages,
        })
    }
}
