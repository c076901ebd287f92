//! Study: what accuracy costs in time.
//!
//! A [`Study`] first traces a reference by light paths, then solves the scene with every number of patches,
//! rays and every solver and order of a [`Grid`], and holds each answer's irradiance by face against the
//! reference. It goes on step by step with [`Study::advance`], so that whoever runs it can keep what is
//! there, stop, and resume another time.

mod conclusions;
mod constants;
mod front;
mod grid;
mod reference;
mod row;
mod runs;
mod trend;

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

pub use conclusions::{Conclusions, OrderTrend, Solving, Target, Turn};
use constants::{LAST_CELLS, REFERENCE_ALONE, REFERENCE_SHARE};
pub use grid::{Cell, Grid};
use reference::Enough;
pub use reference::{FaceError, ReferenceSide, StudyReference};
pub use row::{Reading, StudyRow, StudySolver};
pub use trend::{Slope, Trend};

use super::{MeasureError, Verdict};
use crate::parallel;
use crate::patches::{Basis, PatchSize, Patches, Tessellation};
use crate::progress::{Observer, Progress};
use crate::scene::Scene;
use crate::trace::Tracer;
use crate::transport::TransportError;

/// What to study, and for how long.
#[derive(Clone, Debug)]
pub struct StudyOptions<'a> {
    /// Wall-clock time for all of it. What does not fit is left out, the dearest first.
    pub time: Duration,
    /// Noise of the reference that is small enough, relative root mean square by face. Time falls as its
    /// square.
    pub noise: f64,
    /// What to try; `None` for [`Grid::for_scene`].
    pub grid: Option<Grid>,
    /// How light varies over a patch.
    pub basis: Basis,
    /// Number of the random sequences. The same seed gives the same errors, if the reference reaches `noise`
    /// in time or has as many paths as it had.
    pub seed: u64,
    /// The most bytes patches, operators and factors may each take.
    pub memory: u64,
    /// Where to report progress, as stages `reference` and `study`.
    pub progress: Progress<'a>,
}

impl Default for StudyOptions<'_> {
    /// 90 seconds, a noise of 0.05 %, a grid for the scene, constant elements, 4 GiB.
    fn default() -> Self {
        Self {
            time: Duration::from_secs(90),
            noise: 5e-4,
            grid: None,
            basis: Basis::Constant,
            seed: 0,
            memory: 4 << 30,
            progress: Progress::default(),
        }
    }
}

/// A study under way, or done.
#[derive(Debug)]
pub struct Study<'t, 's, 'o> {
    tracer: &'t Tracer<'s>,
    options: StudyOptions<'o>,
    /// Patches that are whole sides of faces.
    sides: Patches<'s>,
    grid: Grid,
    reference: Option<StudyReference>,
    /// Whether light paths of their own are held against it.
    paths_measured: bool,
    rows: Vec<StudyRow>,
    left_out: Vec<LeftOut>,
    /// Of cells that were measured now.
    verdicts: Vec<(Cell, Verdict)>,
    /// Rows that come from an earlier run.
    taken_over: usize,
}

/// A cell that was not measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// Which.
    pub cell: Cell,
    /// What it would have taken.
    pub wants: Want,
}

/// What there was not enough of.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Want {
    /// So many more seconds, about.
    Seconds(f64),
    /// Memory; what the library says of it.
    Memory(String),
}

impl<'t, 's, 'o> Study<'t, 's, 'o> {
    /// Looks at the scene and chooses what to try.
    ///
    /// # Errors
    /// Those of cutting; `Transport` (`Dark`) where light reaches nothing.
    pub fn new(tracer: &'t Tracer<'s>, options: StudyOptions<'o>) -> Result<Self, MeasureError> {
        let whole = Tessellation {
            // No face of a normalised scene is as large as this.
            size: PatchSize::Edge(10.0 * tracer.frame().scale()),
            seed: options.seed,
            memory: options.memory,
            ..Tessellation::default()
        };
        let sides = Patches::new(tracer, &whole)?;
        if sides.is_empty() {
            return Err(TransportError::Dark.into());
        }
        let for_cells = options.time.mul_f64(1.0 - REFERENCE_SHARE);
        let grid = options.grid.clone().unwrap_or_else(|| Grid::for_scene(sides.len(), for_cells));
        Ok(Self {
            tracer,
            options,
            sides,
            grid,
            reference: None,
            paths_measured: false,
            rows: Vec::new(),
            left_out: Vec::new(),
            verdicts: Vec::new(),
            taken_over: 0,
        })
    }

    /// A number that tells whether errors belong together: of everything in the scene, the program's version,
    /// seed, basis, and threads, which times depend on.
    pub fn key(&self) -> u64 {
        let mut hash = Hasher(Xxh3::new());
        let StudyOptions { seed, basis, .. } = self.options;
        let threads = parallel::threads();
        let version = env!("CARGO_PKG_VERSION");
        // Writing to a hash does not fail.
        let _ = write!(hash, "{version} {seed} {} {threads} {:?}", basis.name(), self.tracer.scene());
        hash.0.digest()
    }

    /// Takes over what an earlier run with the same [`Study::key`] has measured.
    pub fn resume(&mut self, reference: StudyReference, rows: Vec<StudyRow>) {
        self.taken_over = rows.len();
        self.paths_measured = !rows.is_empty();
        self.rows = rows;
        self.reference = Some(reference);
    }

    /// Does the next step: the reference, then light paths against it, then a cell of the grid. False where
    /// nothing is left to do.
    ///
    /// # Errors
    /// Those of tracing and solving; `Cancelled`. What was measured before stays.
    pub fn advance(&mut self) -> Result<bool, MeasureError> {
        let Self { tracer, options, sides, .. } = self;
        let share = options.time.mul_f64(REFERENCE_SHARE);
        let Some(reference) = &self.reference else {
            let watch = Watch::new(options.progress, "reference", 0.0, share.as_secs_f64());
            let progress = Progress::to(&watch);
            // What is left of the share is for the paths that are held against it.
            let enough = Enough { time: share.mul_f64(REFERENCE_ALONE), noise: options.noise };
            let traced = StudyReference::trace(tracer, sides, enough, options.seed, progress)?;
            self.reference = Some(traced);
            return Ok(true);
        };
        if !self.paths_measured {
            let watch = Watch::new(options.progress, "reference", reference.seconds, share.as_secs_f64());
            let rows = runs::measure_paths(tracer, sides, reference, options, Progress::to(&watch))?;
            self.rows.extend(rows);
            self.paths_measured = true;
            return Ok(true);
        }
        while let Some(cell) = self.next_cell() {
            let predicted = self.predicted_seconds(cell);
            let first = self.rows.iter().all(|row| row.cell().is_none());
            if !first && self.spent() + predicted > options_time(&self.options) {
                self.left_out.push(LeftOut { cell, wants: Want::Seconds(predicted) });
                continue;
            }
            let watch = Watch::new(self.options.progress, "study", self.spent(), self.expected_seconds());
            match runs::measure_cell(self.tracer, cell, reference, &self.options, Progress::to(&watch)) {
                Ok((rows, verdict)) => {
                    self.rows.extend(rows);
                    self.verdicts.push((cell, verdict));
                }
                Err(error) if error.is_too_large() => {
                    self.left_out.push(LeftOut { cell, wants: Want::Memory(error.to_string()) });
                    continue;
                }
                Err(error) => return Err(error),
            }
            return Ok(true);
        }
        Ok(false)
    }

    /// The quickest cell that is neither measured nor left out.
    fn next_cell(&self) -> Option<Cell> {
        let measured = |cell: &Cell| self.rows.iter().any(|row| row.cell() == Some(*cell));
        let left_out = |cell: &Cell| self.left_out.iter().any(|left| left.cell == *cell);
        self.grid.cells().into_iter().find(|cell| !measured(cell) && !left_out(cell))
    }

    /// What a cell will take, by what those before took.
    fn predicted_seconds(&self, cell: Cell) -> f64 {
        let mut known: Vec<Cell> = self.rows.iter().filter_map(StudyRow::cell).collect();
        known.dedup();
        let slowness = |cell: &Cell| {
            let rows: Vec<StudyRow> =
                self.rows.iter().filter(|row| row.cell() == Some(*cell)).cloned().collect();
            row::spent(&rows) / cell.nominal_seconds()
        };
        let slowest = known.iter().rev().take(LAST_CELLS).map(slowness).fold(0.0, f64::max);
        cell.nominal_seconds() * if slowest > 0.0 { slowest } else { 1.0 }
    }

    /// Seconds spent so far, earlier runs' included.
    pub fn spent(&self) -> f64 {
        self.reference.as_ref().map_or(0.0, |reference| reference.seconds) + row::spent(&self.rows)
    }

    /// Seconds that all of it is going to take.
    fn expected_seconds(&self) -> f64 {
        let done = |cell: &Cell| self.rows.iter().any(|row| row.cell() == Some(*cell));
        let rest: f64 = self
            .grid
            .cells()
            .into_iter()
            .filter(|cell| !done(cell))
            .map(|cell| self.predicted_seconds(cell))
            .sum();
        (self.spent() + rest).min(options_time(&self.options))
    }

    /// About the [`StudyOptions::time`] in which the whole grid fits.
    pub fn seconds_for_all(&self) -> f64 {
        let wanted = |left: &LeftOut| match left.wants {
            Want::Seconds(seconds) => seconds,
            Want::Memory(_) => 0.0,
        };
        let left: f64 = self.left_out.iter().map(wanted).sum();
        let cells: Vec<StudyRow> = self.rows.iter().filter(|row| row.cell().is_some()).cloned().collect();
        // A reference that time has cut short takes its share of more time too.
        let with_reference = (row::spent(&cells) + left) / (1.0 - REFERENCE_SHARE);
        with_reference.max(self.spent() + left)
    }

    /// What answers are held against, once it is there.
    pub fn reference(&self) -> Option<&StudyReference> {
        self.reference.as_ref()
    }

    /// What was measured so far.
    pub fn rows(&self) -> &[StudyRow] {
        &self.rows
    }

    /// The scene that is studied.
    pub fn scene(&self) -> &'s Scene {
        self.tracer.scene()
    }

    /// What was asked for.
    pub fn options(&self) -> &StudyOptions<'o> {
        &self.options
    }

    /// What is tried.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What was left out for lack of time or memory.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// Whether the answers of the cells measured in this run can be relied on.
    pub fn verdicts(&self) -> &[(Cell, Verdict)] {
        &self.verdicts
    }

    /// Number of rows that come from an earlier run.
    pub fn taken_over(&self) -> usize {
        self.taken_over
    }
}

fn options_time(options: &StudyOptions) -> f64 {
    options.time.as_secs_f64()
}

/// Turns the progress of parts into that of the whole, by the clock.
struct Watch<'a> {
    whole: Progress<'a>,
    stage: &'static str,
    began: Instant,
    before: f64,
    expected: f64,
}

impl<'a> Watch<'a> {
    fn new(whole: Progress<'a>, stage: &'static str, before: f64, expected: f64) -> Self {
        Self { whole, stage, began: Instant::now(), before, expected }
    }
}

impl Observer for Watch<'_> {
    fn at(&self, _: &'static str, _: f64) -> ControlFlow<()> {
        let done = (self.before + self.began.elapsed().as_secs_f64()) / self.expected;
        match self.whole.at(self.stage, done.clamp(0.0, 0.99)) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    }
}

/// A hash that can be written to as text.
struct Hasher(Xxh3);

impl std::fmt::Write for Hasher {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}
