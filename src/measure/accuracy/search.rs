//! Search: one step after another, each an answer and how good it is.

use std::time::Instant;

use super::constants::{LEAST_MESH_POWER, MESH_POWER, MESH_POWERS, TELLING_RATIO};
use super::goal::{AccuracyStep, Goal, Setting, Tolerated};
use crate::measure::error_bars::{ErrorBars, ErrorBudget, ErrorPart};
use crate::measure::{Answer, Energy, Level, MeasureError, Verdict};
use crate::patches::{Cutter, PatchSize, Patches, Tessellation};
use crate::solve::{CgOptions, Problem};
use crate::trace::Tracer;
use crate::transport::{FormFactors, Keep, LightOptions, TraceOptions};

/// An answer and how good it is.
pub(super) struct Attempt<'s> {
    pub patches: Patches<'s>,
    pub factors: FormFactors,
    /// Of the object whose error is the largest, in the goal's terms.
    pub budget: ErrorBudget,
    /// How large that is.
    pub error: f64,
    pub verdict: Verdict,
}

impl Attempt<'_> {
    /// A better answer has less: first by its verdict, then by its error.
    pub fn rank(&self) -> (Level, f64) {
        (self.verdict.level, self.error)
    }
}

/// A search under way.
pub(super) struct Search<'a, 's> {
    pub tracer: &'a Tracer<'s>,
    pub cutter: Cutter<'a, 's>,
    pub goal: Goal,
    pub tessellation: &'a Tessellation<'a>,
    pub trace: &'a TraceOptions<'a>,
    pub began: Instant,
    pub steps: Vec<AccuracyStep>,
    /// Of every step, how many times more than expected noise may be by how its batches differ.
    pub scatter: Vec<f64>,
    /// What mesh error falls by: the edge to this power.
    pub power: f64,
    /// Numbers of patches to choose from, ascending.
    pub ladder: Vec<Rung>,
}

/// A setting, and the number of patches to ask for in the ladder.
#[derive(Clone, Copy)]
pub(super) struct Choice {
    pub rung: usize,
    pub setting: Setting,
}

/// A number of patches that can be asked for, and what a cut for it has: faces are cut in whole steps.
pub(super) struct Rung {
    pub asked: f64,
    pub patches: f64,
    /// Whether `patches` is what was seen or foretold, not only what was asked for.
    pub known: bool,
}

impl<'s> Search<'_, 's> {
    /// Cuts, traces and solves; where light reaches is taken from an earlier cut.
    pub fn step(
        &mut self,
        earlier: Option<&Patches<'s>>,
        Choice { rung, setting }: Choice,
    ) -> Result<Attempt<'s>, MeasureError> {
        let began = Instant::now();
        let count = self.ladder[rung].asked as usize;
        let mut patches = match earlier {
            Some(earlier) => self.cutter.resize(earlier, count, self.tessellation)?,
            None => {
                let size = PatchSize::Count(count);
                self.cutter.cut(&Tessellation { size, ..*self.tessellation })?
            }
        };
        let factors = FormFactors::trace(self.tracer, &mut patches, &self.options(setting.rays as u32))?;
        self.ladder[rung] = Rung { patches: patches.len() as f64, known: true, ..self.ladder[rung] };
        self.judge(began, patches, factors)
    }

    /// Traces more rays between the same patches.
    pub fn add_rays(&mut self, answer: Attempt<'s>, rays: u32) -> Result<Attempt<'s>, MeasureError> {
        let began = Instant::now();
        let Attempt { mut patches, factors, .. } = answer;
        // Random numbers that no step before has used.
        let seed = self.trace.seed ^ (1 + self.steps.len() as u64) << 40;
        let options = TraceOptions { seed, ..self.options(rays) };
        let factors = factors.with_more_rays(self.tracer, &mut patches, &options)?;
        self.judge(began, patches, factors)
    }

    fn options(&self, rays: u32) -> TraceOptions<'_> {
        TraceOptions { rays: Some(rays), keep: Keep::Rays, ..*self.trace }
    }

    /// Solves and takes down how good the answer is.
    fn judge(
        &mut self,
        began: Instant,
        patches: Patches<'s>,
        factors: FormFactors,
    ) -> Result<Attempt<'s>, MeasureError> {
        let progress = self.trace.progress;
        let (seed, caustics) = (self.trace.seed, self.trace.caustics);
        let light = LightOptions { rays: factors.rays(), seed, caustics, progress, ..Default::default() };
        let problem = Problem::new(self.tracer, &patches, &factors, &light)?;
        let options = CgOptions { progress, ..Default::default() };
        let solution = problem.conjugate_gradients(&options)?;
        let bars = ErrorBars::of(&patches, &problem, &solution, progress)?;
        let verdict = Verdict::of(&Answer {
            tracer: self.tracer,
            patches: &patches,
            problem: &problem,
            solution: &solution,
            energy: &Energy::of(&problem, &solution.radiance),
            budget: Some(&bars.budget),
            tolerance: options.tolerance,
        });
        let size = |budget: &ErrorBudget| match self.goal.error {
            Some(Tolerated::Irradiance(_)) => budget.upper95 * budget.irradiance,
            Some(Tolerated::Relative(_)) | None => budget.upper95,
        };
        let budget = bars.headline(size).budget;
        let error = size(&budget);
        let noise = budget.part(ErrorPart::RAYS).hypot(budget.part(ErrorPart::LAMPS));
        let step = AccuracyStep {
            patches: patches.len(),
            rays: factors.rays(),
            seconds: began.elapsed().as_secs_f64(),
            relative_rms: budget.relative_rms,
            upper95: budget.upper95,
            mesh: budget.part(ErrorPart::MESH),
            noise,
            verdict: verdict.level,
        };
        // Two cuts tell how mesh error falls.
        let earlier = self
            .steps
            .iter()
            .rev()
            .find(|s| step.patches as f64 > TELLING_RATIO * s.patches as f64 && s.mesh > 0.0);
        if let Some(s) = earlier {
            let power = 2.0 * (s.mesh / step.mesh).ln() / (step.patches as f64 / s.patches as f64).ln();
            let is_blind = power < LEAST_MESH_POWER;
            self.power = if is_blind { MESH_POWER } else { power.clamp(MESH_POWERS[0], MESH_POWERS[1]) };
        }
        self.steps.push(step);
        self.scatter.push(budget.scatter);
        Ok(Attempt { patches, factors, budget, error, verdict })
    }
}
