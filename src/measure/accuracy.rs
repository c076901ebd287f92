//! Accuracy: the cheapest cut and number of rays that are good enough, found by trying.
//!
//! A first answer is coarse and quick. Its budget tells how much of its error is mesh and how much is noise; with what both are known to fall by as patches and rays
//! grow, the setting that meets the goal in the least time follows and is tried next. Each step tells better how this scene's errors fall. Where an answer
//! misses its goal by noise alone, its rays are kept and others are added to them.

use std::time::Instant;

use serde::Serialize;

use super::MeasureError;
use super::error_bars::{ErrorBars, ErrorBudget, ErrorPart, MESH_AT_MOST, noise_at_most};
use crate::patches::{Basis, PatchSize, Patches, Tessellation};
use crate::solve::{CgOptions, conjugate_gradients};
use crate::trace::Tracer;
use crate::transport::{FormFactors, Keep, LightOptions, Sources, TraceOptions, Transport};

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
}

/// How the search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// The goal is met; or, with a time alone, that time is used.
    Reached,
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
}

/// The first step.
const FIRST: Setting = Setting { patches: 1000.0, rays: 64.0 };

/// The fewest and most rays a patch.
const RAYS: [f64; 2] = [32.0, 4096.0];

/// A step is no more than so many times as dear as the one before: how errors fall is known only roughly until it has been seen.
const LEAP: f64 = 16.0;

/// Steps aim a little below the goal, for what is foretold comes true only roughly; ...
const AIM: f64 = 0.95;

/// ... and one that follows a step which missed the goal takes at least so many times its work.
const GROWTH: f64 = 1.4;

/// How far batches differ makes the bound on noise larger by about so much.
const NOISE_SPREAD: f64 = 1.08;

/// The most steps.
const MOST_STEPS: usize = 10;

/// What a patch costs beside its rays, in rays.
const PATCH_IN_RAYS: f64 = 40.0;

/// Noise falls as the number of rays to this power: a little faster than chance, for rays are spread evenly.
const NOISE_POWER: f64 = 0.55;

/// Mesh error falls as the edge to a power in this range.
const MESH_POWERS: [f64; 2] = [0.6, 2.0];

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
    let mut search = Search { tracer, goal, tessellation, trace, began, steps: Vec::new(), power: 1.0 };
    let mut best = search.step(FIRST)?;
    let ending = loop {
        match search.next(&best) {
            Next::End(ending) => break ending,
            Next::MoreRays(rays) => best = search.add_rays(best, rays)?,
            Next::Step(setting) => {
                let answer = search.step(setting)?;
                if answer.budget.upper95 < best.budget.upper95 {
                    best = answer;
                }
            }
        }
    };
    Ok(Accurate { patches: best.patches, factors: best.factors, steps: search.steps, ending })
}

/// An answer and how good it is.
struct Answer<'s> {
    patches: Patches<'s>,
    factors: FormFactors,
    budget: ErrorBudget,
}

/// What to do next.
enum Next {
    /// Cut and trace anew.
    Step(Setting),
    /// Add so many rays to each patch.
    MoreRays(u32),
    End(Ending),
}

struct Search<'a, 's> {
    tracer: &'a Tracer<'s>,
    goal: Goal,
    tessellation: &'a Tessellation<'a>,
    trace: &'a TraceOptions<'a>,
    began: Instant,
    steps: Vec<AccuracyStep>,
    /// What mesh error falls by: the edge to this power.
    power: f64,
}

impl<'s> Search<'_, 's> {
    /// Cuts, traces and solves.
    fn step(&mut self, setting: Setting) -> Result<Answer<'s>, MeasureError> {
        let began = Instant::now();
        let size = PatchSize::Count(setting.patches.round() as usize);
        let mut patches = Patches::new(self.tracer, &Tessellation { size, ..*self.tessellation })?;
        let factors = FormFactors::trace(self.tracer, &mut patches, &self.options(setting.rays as u32))?;
        self.judge(began, patches, factors)
    }

    /// Traces more rays between the same patches.
    fn add_rays(&mut self, answer: Answer<'s>, rays: u32) -> Result<Answer<'s>, MeasureError> {
        let began = Instant::now();
        let Answer { mut patches, factors, .. } = answer;
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
    ) -> Result<Answer<'s>, MeasureError> {
        let progress = self.trace.progress;
        let k = Transport::of(&factors, &patches)?;
        let (seed, caustics) = (self.trace.seed, self.trace.caustics);
        let light = LightOptions { rays: factors.rays(), seed, caustics, progress };
        let sources = Sources::trace(self.tracer, &patches, factors.basis(), &light)?;
        let solution = conjugate_gradients(
            &k,
            &sources.right_hand_side(&k),
            &CgOptions { progress, ..Default::default() },
        )?;
        let budget = ErrorBars::of(&patches, &factors, &sources, &solution.under(&sources), progress)?.budget;
        let noise = budget.part(ErrorPart::RAYS).hypot(budget.part(ErrorPart::LAMPS));
        let step = AccuracyStep {
            patches: patches.len(),
            rays: factors.rays(),
            seconds: began.elapsed().as_secs_f64(),
            relative_rms: budget.relative_rms,
            upper95: budget.upper95,
            mesh: budget.part(ErrorPart::MESH),
            noise,
        };
        // Two cuts tell how mesh error falls.
        let earlier =
            self.steps.iter().rev().find(|s| step.patches as f64 > 1.5 * s.patches as f64 && s.mesh > 0.0);
        if let Some(s) = earlier {
            let power = 2.0 * (s.mesh / step.mesh).ln() / (step.patches as f64 / s.patches as f64).ln();
            self.power = power.clamp(MESH_POWERS[0], MESH_POWERS[1]);
        }
        self.steps.push(step);
        Ok(Answer { patches, factors, budget })
    }

    fn next(&self, best: &Answer) -> Next {
        let last = &self.steps[self.steps.len() - 1];
        let now = best.budget.upper95;
        let wanted = self.goal.error.map(|error| match error {
            Tolerated::Relative(share) => share,
            Tolerated::Irradiance(h) => h / best.budget.irradiance.max(f64::MIN_POSITIVE),
        });
        let all_time = self.goal.seconds.map_or(f64::INFINITY, |seconds| FOR_STEPS * seconds);
        let time_left = all_time - self.began.elapsed().as_secs_f64();
        if wanted.is_some_and(|wanted| now <= wanted) || wanted.is_none() && self.goal.seconds.is_none() {
            return Next::End(Ending::Reached);
        }
        let forecast = Forecast { from: *last, power: self.power, basis: best.factors.basis() };
        let fits = |setting: &Setting| {
            let options = TraceOptions { rays: Some(setting.rays as u32), ..*self.trace };
            options.check(setting.patches as usize).is_ok()
        };
        let grows = |s: &Setting| self.steps.len() == 1 || forecast.seconds(s) >= GROWTH * last.seconds;
        let cheapest =
            wanted.and_then(|wanted| forecast.cheapest(|s| grows(s) && forecast.upper95(s) <= AIM * wanted));
        // What is wanted may take more than there is: then as much of it as there is.
        let short = |of: Resource| match (wanted, cheapest) {
            (None, _) => Ending::Reached,
            (_, needed) => {
                let needed = needed.unwrap_or(Setting { patches: f64::INFINITY, rays: f64::INFINITY });
                Ending::Short { of, needed, seconds: forecast.seconds(&needed) }
            }
        };
        if self.steps.len() >= MOST_STEPS {
            return Next::End(short(Resource::Effect));
        }
        let affordable = |s: &Setting| fits(s) && forecast.seconds(s) <= time_left;
        let (setting, lacking) = match cheapest {
            Some(setting) if affordable(&setting) => (setting, None),
            _ => {
                let lacking =
                    if cheapest.is_some_and(|s| !fits(&s)) { Resource::Memory } else { Resource::Time };
                match forecast.best(affordable) {
                    Some(setting) => (setting, Some(lacking)),
                    None => return Next::End(short(lacking)),
                }
            }
        };
        let was_tried = |setting: &Setting| {
            let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.2;
            let same = |s: &AccuracyStep| {
                near(setting.patches, s.patches as f64) && near(setting.rays, f64::from(s.rays))
            };
            self.steps.iter().any(same)
        };
        if let Some(of) = lacking
            && (was_tried(&setting) || forecast.upper95(&setting) > WORTHWHILE * now)
        {
            return Next::End(short(of));
        }
        // Towards something far dearer, go half of the way first.
        let leap = forecast.seconds(&setting) / last.seconds;
        if leap > LEAP && self.steps.len() + 1 < MOST_STEPS {
            let part = leap.sqrt() / leap;
            return Next::Step(Setting {
                patches: (setting.patches * part).max(last.patches as f64),
                ..setting
            });
        }
        let same_cut = (0.8..1.25).contains(&(setting.patches / best.patches.len() as f64));
        let more = setting.rays - f64::from(best.factors.rays());
        if same_cut && more >= RAYS[0] && best.factors.basis() == Basis::Constant {
            return Next::MoreRays(more as u32);
        }
        Next::Step(setting)
    }
}

/// What other settings would cost and err, told from one that was tried.
struct Forecast {
    from: AccuracyStep,
    power: f64,
    basis: Basis,
}

impl Forecast {
    fn upper95(&self, s: &Setting) -> f64 {
        let patches = s.patches / self.from.patches as f64;
        let rays = patches * s.rays / f64::from(self.from.rays);
        let mesh = self.from.mesh * patches.powf(-0.5 * self.power);
        let noise = self.from.noise * rays.powf(-NOISE_POWER);
        // The bound on noise also holds its own uncertainty, which is a part of it.
        let at_most = NOISE_SPREAD * noise_at_most(s.rays as u32, self.basis);
        (MESH_AT_MOST * mesh).hypot(at_most * noise)
    }

    fn seconds(&self, s: &Setting) -> f64 {
        let work = |patches: f64, rays: f64| patches * (rays + PATCH_IN_RAYS);
        self.from.seconds * work(s.patches, s.rays)
            / work(self.from.patches as f64, f64::from(self.from.rays))
    }

    /// All settings worth a thought.
    fn settings(&self) -> impl Iterator<Item = Setting> {
        let patches = (-8..80).map(|k| self.from.patches as f64 * (0.25 * f64::from(k)).exp2());
        let rays = (0..).map(|k| RAYS[0] * (0.5 * f64::from(k)).exp2()).take_while(|&rays| rays <= RAYS[1]);
        let rays: Vec<f64> = rays.map(|rays| (rays / 8.0).round() * 8.0).collect();
        patches.flat_map(move |patches| rays.clone().into_iter().map(move |rays| Setting { patches, rays }))
    }

    /// The cheapest that is good enough.
    fn cheapest(&self, is_enough: impl Fn(&Setting) -> bool) -> Option<Setting> {
        self.settings().filter(is_enough).min_by(|a, b| self.seconds(a).total_cmp(&self.seconds(b)))
    }

    /// The best that can be had.
    fn best(&self, can_be_had: impl Fn(&Setting) -> bool) -> Option<Setting> {
        self.settings().filter(can_be_had).min_by(|a, b| self.upper95(a).total_cmp(&self.upper95(b)))
    }
}
