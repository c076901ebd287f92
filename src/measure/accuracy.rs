//! Accuracy: the cheapest cut and number of rays that are good enough, found by trying.
//!
//! A first answer is coarse and quick. Its budget tells how much of its error is mesh and how much is noise;
//! with what both are known to fall by as patches and rays grow, the setting that meets the goal in the least
//! time follows and is tried next. Each step tells better how this scene's errors fall. Where an answer
//! misses its goal by noise alone, its rays are kept and others are added to them.

use std::time::Instant;

use serde::Serialize;

use super::error_bars::{ErrorBars, ErrorBudget, ErrorPart, Insight, noise_at_most, slack_at_most};
use super::{Answer, Energy, Level, MeasureError, Verdict};
use crate::patches::{Basis, Cutter, PatchSize, Patches, Tessellation};
use crate::solve::{CgOptions, Problem};
use crate::trace::Tracer;
use crate::transport::{FormFactors, Keep, LightOptions, TraceOptions};

/// When an answer is good enough. With neither an error nor a time, the first is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// What the error of irradiance by face is not to exceed, 95 times of 100.
    pub error: Option<Tolerated>,
    /// Seconds within which steps are to end.
    pub seconds: Option<f64>,
}

/// How much error is good enough, as an area-weighted root mean square over faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerated {
    /// A share of the root mean square irradiance.
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
    /// The error to be expected.
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

/// The first step.
const FIRST: Setting = Setting { patches: 256.0, rays: 64.0 };

/// The fewest and most rays a patch.
const RAYS: [f64; 2] = [32.0, 4096.0];

/// A step is no more than so many times as dear as the one before: how errors fall is known only roughly
/// until it has been seen.
const LEAP: f64 = 25.0;

/// Steps aim a little below the goal, for what is foretold comes true only roughly; ...
const AIM: f64 = 0.95;

/// ... and one that follows a step which missed the goal takes at least so many times its work.
const GROWTH: f64 = 1.4;

/// The same of a step that only adds rays, whose effect is known better; and the fewest rays worth adding.
const GROWTH_IN_RAYS: f64 = 1.2;
const FEWEST_MORE: f64 = 16.0;

/// Where faces are cut into fewer patches than this on average, what light does within most of them is not
/// seen; an answer has to be found again on a cut so many times as fine before it is believed.
const CUT_ENOUGH: f64 = 3.0;
const FINER: f64 = 1.5;

/// Mesh error of so much of the noise is hidden by it.
const HIDDEN: f64 = 0.15;

/// The most steps.
const MOST_STEPS: usize = 10;

/// What a patch costs beside its rays, in rays.
const PATCH_IN_RAYS: f64 = 56.0;

/// Noise falls as the number of rays to this power: a little faster than chance, for rays are spread evenly.
const NOISE_POWER: f64 = 0.55;

/// How many patches can be merged into one on most cuts.
const USUALLY_MERGED: f64 = 3.0;

/// Mesh error falls as the edge to a power in this range; where two cuts tell of less than the least, the
/// coarser one was blind.
const MESH_POWERS: [f64; 2] = [1.0, 2.0];
const LEAST_POWER: f64 = 0.5;

/// What it is taken to be before two cuts have told.
const MESH_POWER: f64 = 1.4;

/// Numbers of patches to choose from: the first step's, and so many times more each.
const RUNGS: i32 = 80;
const RUNG: f64 = 1.189_207_115_002_721;

/// Part of the time that steps may take; the rest is for solving once more, for pictures and files.
const FOR_STEPS: f64 = 0.85;

/// A step that would better the answer by less than this factor is not worth its time.
const WORTHWHILE: f64 = 0.9;

/// Finds the cheapest answer that meets `goal`. The sizes and numbers of rays in the options are not used.
///
/// # Errors
/// As cutting, tracing and solving; `Memory` where not even the first step fits.
pub fn reach<'s>(
    tracer: &Tracer<'s>,
    goal: Goal,
    tessellation: &Tessellation,
    trace: &TraceOptions,
) -> Result<Accurate<'s>, MeasureError> {
    let began = Instant::now();
    let asked = |k: i32| FIRST.patches * RUNG.powi(k);
    let ladder = (0..RUNGS).map(|k| Rung { asked: asked(k), patches: asked(k), known: false }).collect();
    let mut search = Search {
        tracer,
        cutter: Cutter::new(tracer)?,
        goal,
        tessellation,
        trace,
        began,
        steps: Vec::new(),
        scatter: Vec::new(),
        power: MESH_POWER,
        ladder,
    };
    // Where faces alone are more patches than that, with fewer rays each.
    let patches = FIRST.patches.max(tracer.scene().faces().len() as f64);
    let rays = (FIRST.patches * FIRST.rays / patches).max(RAYS[0]);
    let mut best = search.step(None, Choice { rung: 0, setting: Setting { patches, rays } })?;
    let ending = loop {
        match search.next(&best) {
            Next::End(ending) => break ending,
            Next::MoreRays(rays) => best = search.add_rays(best, rays)?,
            Next::Step(choice) => {
                let answer = search.step(Some(&best.patches), choice)?;
                if answer.rank() < best.rank() {
                    best = answer;
                }
            }
        }
    };
    let Attempt { patches, factors, verdict, .. } = best;
    let ending = match ending {
        Ending::Reached if verdict.level > Level::Good => Ending::Doubtful,
        ending => ending,
    };
    Ok(Accurate { patches, factors, steps: search.steps, ending, verdict })
}

/// An answer and how good it is.
struct Attempt<'s> {
    patches: Patches<'s>,
    factors: FormFactors,
    budget: ErrorBudget,
    verdict: Verdict,
}

impl Attempt<'_> {
    /// A better answer has less: first by its verdict, then by its error.
    fn rank(&self) -> (Level, f64) {
        (self.verdict.level, self.budget.upper95)
    }
}

/// What to do next.
enum Next {
    /// Cut and trace anew.
    Step(Choice),
    /// Add so many rays to each patch.
    MoreRays(u32),
    End(Ending),
}

struct Search<'a, 's> {
    tracer: &'a Tracer<'s>,
    cutter: Cutter<'a, 's>,
    goal: Goal,
    tessellation: &'a Tessellation<'a>,
    trace: &'a TraceOptions<'a>,
    began: Instant,
    steps: Vec<AccuracyStep>,
    /// Of every step, how many times more than expected noise may be by how its batches differ.
    scatter: Vec<f64>,
    /// What mesh error falls by: the edge to this power.
    power: f64,
    /// Numbers of patches to choose from, ascending.
    ladder: Vec<Rung>,
}

/// A setting, and the number of patches to ask for in the ladder.
#[derive(Clone, Copy)]
struct Choice {
    rung: usize,
    setting: Setting,
}

/// A number of patches that can be asked for, and what a cut for it has: faces are cut in whole steps.
struct Rung {
    asked: f64,
    patches: f64,
    /// Whether `patches` is what was seen or foretold, not only what was asked for.
    known: bool,
}

impl<'s> Search<'_, 's> {
    /// Cuts, traces and solves; where light reaches is taken from an earlier cut.
    fn step(
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
    fn add_rays(&mut self, answer: Attempt<'s>, rays: u32) -> Result<Attempt<'s>, MeasureError> {
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
        let budget = ErrorBars::of(&patches, &problem, &solution, progress)?.budget;
        let verdict = Verdict::of(&Answer {
            tracer: self.tracer,
            patches: &patches,
            problem: &problem,
            solution: &solution,
            energy: &Energy::of(&problem, &solution.radiance),
            budget: Some(&budget),
            tolerance: options.tolerance,
        });
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
        let earlier =
            self.steps.iter().rev().find(|s| step.patches as f64 > 1.5 * s.patches as f64 && s.mesh > 0.0);
        if let Some(s) = earlier {
            let power = 2.0 * (s.mesh / step.mesh).ln() / (step.patches as f64 / s.patches as f64).ln();
            let is_blind = power < LEAST_POWER;
            self.power = if is_blind { MESH_POWER } else { power.clamp(MESH_POWERS[0], MESH_POWERS[1]) };
        }
        self.steps.push(step);
        self.scatter.push(budget.scatter);
        Ok(Attempt { patches, factors, budget, verdict })
    }

    /// What to do after the last step.
    fn next(&mut self, best: &Attempt<'s>) -> Next {
        let now = best.budget.upper95;
        let wanted = self.goal.error.map(|error| match error {
            Tolerated::Relative(share) => share,
            Tolerated::Irradiance(h) => h / best.budget.irradiance.max(f64::MIN_POSITIVE),
        });
        let is_met = wanted.is_none_or(|wanted| now <= wanted && best.patches.len() as f64 >= self.fewest());
        // Finer patches and more rays may cure a doubtful answer, but what two steps did not cure a third
        // will not.
        let tried = self.steps.iter().rev().take(2).filter(|step| step.verdict > Level::Good).count();
        let is_doubtful = best.verdict.level > Level::Good;
        if is_met && (!is_doubtful || tried == 2) && (wanted.is_some() || self.goal.seconds.is_none()) {
            return Next::End(Ending::Reached);
        }
        let all_time = self.goal.seconds.map_or(f64::INFINITY, |seconds| FOR_STEPS * seconds);
        let time_left = all_time - self.began.elapsed().as_secs_f64();
        let last = self.steps[self.steps.len() - 1];
        let known = (best.patches.len() as f64, f64::from(best.factors.rays()));
        let insight = best.budget.insight;
        let scatter = self.scatter.iter().sum::<f64>() / self.scatter.len() as f64;
        let slack = slack_at_most(best.budget.part(ErrorPart::SLACK));
        let forecast = Forecast { from: last, power: self.power, insight, scatter, slack, known };
        // Look how many patches the choice has before it is made.
        let (cheapest, choice, lacking) = loop {
            let (cheapest, choice, lacking) = self.choose(&forecast, wanted, time_left);
            let unknown = choice.or(cheapest).filter(|choice| !self.ladder[choice.rung].known);
            let Some(Choice { rung, .. }) = unknown else { break (cheapest, choice, lacking) };
            let rung = &mut self.ladder[rung];
            rung.patches = self.cutter.expected(&best.patches, rung.asked as usize) as f64;
            rung.known = true;
        };
        // What is wanted may take more than there is: then as much of it as there is.
        let short = |of: Resource| match (wanted, cheapest) {
            (None, _) => Ending::Reached,
            _ if is_met => Ending::Doubtful,
            (_, needed) => {
                let nothing = Setting { patches: f64::INFINITY, rays: f64::INFINITY };
                let needed = needed.map_or(nothing, |choice| choice.setting);
                Ending::Short { of, needed, seconds: forecast.seconds(&needed) }
            }
        };
        if self.steps.len() >= MOST_STEPS {
            return Next::End(short(Resource::Effect));
        }
        let Some(Choice { rung, setting }) = choice else {
            return Next::End(short(lacking.unwrap_or(Resource::Time)));
        };
        if let Some(of) = lacking
            && (self.was_tried(&setting) || forecast.upper95(&setting) > WORTHWHILE * now)
        {
            return Next::End(short(of));
        }
        // Towards something far dearer, go half of the way first.
        let leap = forecast.seconds(&setting) / last.seconds;
        if leap > LEAP && self.steps.len() + 1 < MOST_STEPS {
            let half = (setting.patches * leap.sqrt() / leap).max(last.patches as f64);
            let rung = self.ladder[..rung].iter().rposition(|rung| rung.patches <= half).unwrap_or(rung);
            return Next::Step(Choice { rung, setting });
        }
        match forecast.more_rays(&setting) {
            Some(more) => Next::MoreRays(more as u32),
            None => Next::Step(Choice { rung, setting }),
        }
    }

    /// The cheapest choice that is good enough; the one to make, which is the best that can be had where that
    /// is too dear; and what there is too little of, then.
    fn choose(
        &self,
        forecast: &Forecast,
        wanted: Option<f64>,
        time_left: f64,
    ) -> (Option<Choice>, Option<Choice>, Option<Resource>) {
        let fits = |setting: &Setting| {
            let options = TraceOptions { rays: Some(setting.rays as u32), ..*self.trace };
            options.check(setting.patches as usize).is_ok()
        };
        let affordable = |s: &Setting| fits(s) && forecast.seconds(s) <= time_left;
        let grows = |s: &Setting| {
            let growth = if forecast.more_rays(s).is_some() { GROWTH_IN_RAYS } else { GROWTH };
            self.steps.len() == 1 || forecast.seconds(s) >= growth * forecast.from.seconds
        };
        let least = |choices: &mut dyn Iterator<Item = Choice>, of: &dyn Fn(&Setting) -> f64| {
            choices.min_by(|a, b| of(&a.setting).total_cmp(&of(&b.setting)))
        };
        let cheapest = wanted.and_then(|wanted| {
            let is_enough = |s: &Setting| grows(s) && forecast.upper95(s) <= AIM * wanted;
            let mut enough = self.choices().filter(|choice| is_enough(&choice.setting));
            least(&mut enough, &|s| forecast.price(s))
        });
        match cheapest {
            Some(choice) if affordable(&choice.setting) => (cheapest, Some(choice), None),
            _ => {
                let too_large = cheapest.is_some_and(|choice| !fits(&choice.setting));
                let lacking = if too_large { Resource::Memory } else { Resource::Time };
                let mut possible = self.choices().filter(|choice| affordable(&choice.setting));
                (cheapest, least(&mut possible, &|s| forecast.upper95(s)), Some(lacking))
            }
        }
    }

    /// All that can be chosen: every number of patches that is believed, but no fewer than were tried last,
    /// with every number of rays.
    fn choices(&self) -> impl Iterator<Item = Choice> {
        let rays = (0..).map(|k| RAYS[0] * (0.25 * f64::from(k)).exp2()).take_while(|&rays| rays <= RAYS[1]);
        let rays: Vec<f64> = rays.map(|rays| (rays / 8.0).round() * 8.0).collect();
        let last = self.steps.last().map_or(0.0, |step| step.patches as f64);
        let fewest = self.fewest().max(0.98 * last);
        let rungs = self.ladder.iter().enumerate().filter(move |(_, rung)| rung.patches >= fewest);
        rungs.flat_map(move |(rung, &Rung { patches, .. })| {
            rays.clone().into_iter().map(move |rays| Choice { rung, setting: Setting { patches, rays } })
        })
    }

    /// The fewest patches of a cut that is believed.
    fn fewest(&self) -> f64 {
        let scene = self.tracer.scene();
        let faces = (0..scene.faces().len()).filter(|&face| scene.is_diffuse(face)).count();
        let first = self.steps.first().map_or(0.0, |step| step.patches as f64);
        (CUT_ENOUGH * faces as f64).min(FINER * first)
    }

    fn was_tried(&self, setting: &Setting) -> bool {
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.2;
        self.steps
            .iter()
            .any(|s| near(setting.patches, s.patches as f64) && near(setting.rays, s.rays.into()))
    }
}

/// What other settings would cost and err, told from one that was tried.
struct Forecast {
    from: AccuracyStep,
    power: f64,
    /// How much is told of the mesh error of the best answer.
    insight: Insight,
    /// How many times more than expected noise may be by how batches differ.
    scatter: f64,
    /// What slack adds to the error of the best answer, and will to that of others.
    slack: f64,
    /// Patches and rays of the best answer.
    known: (f64, f64),
}

impl Forecast {
    fn upper95(&self, s: &Setting) -> f64 {
        let patches = s.patches / self.from.patches as f64;
        let rays = patches * s.rays / f64::from(self.from.rays);
        let mesh = self.from.mesh.hypot(HIDDEN * self.from.noise) * patches.powf(-0.5 * self.power);
        let noise = self.from.noise * rays.powf(-NOISE_POWER);
        let at_most = self.scatter * noise_at_most(s.rays as u32, self.insight.basis);
        let mut insight = self.insight;
        if !self.is_same_cut(s) {
            insight.merged = insight.merged.max(USUALLY_MERGED);
        }
        (insight.at_most() * mesh).hypot(at_most * noise) + self.slack
    }

    /// What it takes from the start.
    fn seconds(&self, s: &Setting) -> f64 {
        self.from.seconds * work(s.patches, s.rays)
            / work(self.from.patches as f64, f64::from(self.from.rays))
    }

    /// What it takes with what is there.
    fn price(&self, s: &Setting) -> f64 {
        let rays = self.more_rays(s).unwrap_or(s.rays);
        self.seconds(s) * work(s.patches, rays) / work(s.patches, s.rays)
    }

    /// Whether it is the cut of the best answer.
    fn is_same_cut(&self, s: &Setting) -> bool {
        (s.patches / self.known.0 - 1.0).abs() < 0.02
    }

    /// How many rays the best answer lacks, where that is all it lacks.
    fn more_rays(&self, s: &Setting) -> Option<f64> {
        let more = s.rays - self.known.1;
        (self.is_same_cut(s) && more >= FEWEST_MORE && self.insight.basis == Basis::Constant).then_some(more)
    }
}

/// Seconds rise in proportion to this.
fn work(patches: f64, rays: f64) -> f64 {
    patches * (rays + PATCH_IN_RAYS)
}
