//! Verdict: whether an answer can be relied on, and if not, why, where, and what to do.
//!
//! Every cause is judged by numbers that are computed anew from the answer: power is added up, the equation
//! is evaluated at the radiance found, rows of form factors are summed. Two thresholds are common to all
//! causes that lose or misplace power. They are relative to the power that is emitted, in the channel where
//! most is lost:
//!
//! - from 0.1 % on an answer is *doubtful*. That is a tenth of the 1 % by face that usual settings aim at:
//!   less than that is covered by the error bars, more is an error that they do not know of;
//! - from 5 % on it is *bad*: no error bar covers that, and the eye sees it.
//!
//! What should be exact but for rounding (energy terms, sums of rows) is doubtful from 1e-6 on: stored
//! exchange areas are rounded to 6e-8. Iterative solvers are allowed ten times their tolerance there.

mod constants;
mod light;
mod places;
mod rows;

use serde::Serialize;

use super::words::few;
use super::{Energy, ErrorBudget, GroupError};
use crate::patches::Patches;
use crate::scene::Scene;
use crate::solve::{Problem, Solution};
use crate::trace::Tracer;
use constants::{BAD, EXACT, FEW, TOLERANCES, WIDE};

/// How far an answer can be relied on; the later, the less.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Within its error bars.
    #[default]
    Good,
    /// Right as far as it goes: the solver stopped at its highest order or its last iteration, and light is
    /// missing.
    Truncated,
    /// Something is wrong that its error bars do not know of, or may be.
    Doubtful,
    /// It is wrong.
    Bad,
}

impl Level {
    /// `good`, `truncated`, `doubtful` or `bad`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Truncated => "truncated",
            Self::Doubtful => "doubtful",
            Self::Bad => "bad",
        }
    }

    /// By a share of the power that is lost or misplaced, of which `allowed` is no fault.
    fn of_share(share: f64, allowed: f64) -> Self {
        match share {
            share if share < allowed => Self::Good,
            share if share < BAD => Self::Doubtful,
            _ => Self::Bad,
        }
    }
}

/// What is wrong with an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// A number is infinite or none.
    NotFinite,
    /// No bound on the solver's error was found.
    Unbounded,
    /// Lamps or lights of the scene are not in the answer.
    MissingLamps,
    /// Energy terms do not add up.
    EnergyImbalance,
    /// The solver stopped at its highest order or its last iteration.
    Truncation,
    /// Radiance and irradiance do not satisfy the equation, though the solver ended by itself.
    Unsolved,
    /// Rows of form factors and what leaves do not sum to 1.
    Closure,
    /// Rows for which no balance exists: they lack a part of what they should send out.
    Slack,
    /// Rays left a closed surface from inside.
    Escape,
    /// Patches that no ray left or met.
    NoRays,
    /// Faces lie in the plane of others, with the same front. Their order is known, so this alone is only
    /// told.
    Overlap,
    /// The two directions between sides of faces disagree by more than their noise.
    Directions,
    /// The error bars are so wide that they tell little.
    Uncertain,
}

impl Cause {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "numbers that are not finite",
            Self::Unbounded => "no bound on the solver's error",
            Self::MissingLamps => "missing lamps",
            Self::EnergyImbalance => "energy imbalance",
            Self::Truncation => "truncation",
            Self::Unsolved => "unsolved equation",
            Self::Closure => "rows that do not close",
            Self::Slack => "slack",
            Self::Escape => "escape from a closed surface",
            Self::NoRays => "patches without rays",
            Self::Overlap => "overlapping faces",
            Self::Directions => "directions that disagree",
            Self::Uncertain => "wide error bars",
        }
    }

    /// What to do about it.
    fn remedy(self) -> &'static str {
        match self {
            Self::NotFinite => {
                "use --solver direct; if that does not help, `radiosity check` names faulty faces"
            }
            Self::Unbounded => "use --solver direct, or lower the highest reflectance",
            Self::MissingLamps => "uncover these lamps, or move them away from the faces in their plane",
            Self::EnergyImbalance => {
                "use --solver direct; if it stays, the form factors are damaged: trace them anew"
            }
            Self::Truncation => "raise --order, or use --solver cg or direct",
            Self::Unsolved => "lower --tolerance, or use --solver direct",
            Self::Closure => "trace the form factors anew, with more rays (--rays)",
            Self::Slack => {
                "remove doubled faces and unsealed pockets there (`radiosity check`), or trace more --rays"
            }
            Self::Escape => "weld vertices there and remove slivers (`radiosity check`)",
            Self::NoRays => {
                "remove slivers and doubled faces there (`radiosity check`), or trace more --rays"
            }
            Self::Overlap => {
                "the smaller surface is taken to be on top; move one out of the plane if another order is meant"
            }
            Self::Directions => "separate faces there that touch or overlap (`radiosity check`)",
            Self::Uncertain => "take more --patches or --rays, or set --accuracy: `error` says which helps",
        }
    }
}

/// One thing that is wrong with an answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reason {
    /// What follows from it.
    pub level: Level,
    /// What it is.
    pub cause: Cause,
    /// Numbers of the faces concerned, those with the most power first; empty where it has no place.
    pub faces: Vec<usize>,
    /// Names of their objects, in the same order, each once.
    pub objects: Vec<String>,
    /// The part of the emitted power that is concerned, or, of faces that are only known to overlap or
    /// disagree, of all light that arrives anywhere; in the channel where it is largest. None where that
    /// can't be told.
    pub power_share: Option<f64>,
    /// What to do about it.
    pub remedy: &'static str,
}

impl Reason {
    fn new(cause: Cause, level: Level, power_share: Option<f64>, faces: Vec<usize>, scene: &Scene) -> Self {
        let mut objects: Vec<String> = Vec::new();
        for &face in &faces {
            let name = scene.faces().get(face).and_then(|face| scene.objects().get(face.object as usize));
            if let Some(name) = name.filter(|name| !objects.contains(name)) {
                objects.push(name.clone());
            }
        }
        let power_share = power_share.filter(|share| share.is_finite());
        Self { level, cause, faces, objects, power_share, remedy: cause.remedy() }
    }
}

impl std::fmt::Display for Reason {
    /// In a line: `slack: 0.32 % of the power, at faces 3, 4, 5 and 12 more of pocket and lid; …`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.cause.name())?;
        if let Some(share) = self.power_share {
            let whole = match self.cause {
                Cause::Overlap | Cause::Directions => "light",
                _ => "power",
            };
            write!(f, ": {} of the {whole}", places::percent(share))?;
        }
        let numbers: Vec<String> = self.faces.iter().map(usize::to_string).collect();
        if !numbers.is_empty() {
            let noun = if numbers.len() == 1 { "face" } else { "faces" };
            let comma = if self.power_share.is_some() { "," } else { ":" };
            write!(f, "{comma} at {noun} {}", few(&numbers, FEW))?;
        }
        if !self.objects.is_empty() {
            write!(f, " of {}", few(&self.objects, FEW))?;
        }
        write!(f, "; {}", self.remedy)
    }
}

/// What is to be judged.
#[derive(Clone, Copy)]
pub struct Answer<'a> {
    /// The scene, as it was traced.
    pub tracer: &'a Tracer<'a>,
    /// The cut.
    pub patches: &'a Patches<'a>,
    /// The operator and the light that starts.
    pub problem: &'a Problem,
    /// Radiance and irradiance, by coefficients.
    pub solution: &'a Solution,
    /// Where the power goes.
    pub energy: &'a Energy,
    /// How wrong irradiance is said to be, if that is known.
    pub budget: Option<&'a ErrorBudget>,
    /// The [tolerance](crate::solve#tolerance) that iterations were to meet.
    pub tolerance: f64,
}

impl Answer<'_> {
    /// What a number that is exact but for rounding and the solver's tolerance may be off by.
    fn exact(&self) -> f64 {
        if self.solution.report.name == "direct" { EXACT } else { EXACT.max(TOLERANCES * self.tolerance) }
    }

    /// Whether light goes on from surface to surface, so that rows of form factors matter.
    fn has_rows(&self) -> bool {
        self.tracer.scene().has_exchange()
    }
}

/// Whether an answer can be relied on.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Verdict {
    /// The worst level of all reasons.
    pub level: Level,
    /// What is wrong, the worst first; a good answer has none but those that do no harm.
    pub reasons: Vec<Reason>,
}

impl Verdict {
    /// Judges an answer.
    ///
    /// It costs three products with the matrix, and, where rays escape, up to a quarter of a million solid
    /// angles.
    pub fn of(answer: &Answer) -> Self {
        let mut reasons = light::not_finite(answer);
        // Nothing can be added up where numbers are missing.
        if reasons.iter().all(|reason| reason.level < Level::Bad) {
            reasons.extend(light::missing_lamps(answer));
            let rows = if answer.has_rows() { rows::judge(answer) } else { Default::default() };
            let residual = light::Residual::of(answer);
            reasons.extend(light::unsolved(answer, &residual));
            reasons.extend(light::imbalance(answer, residual.share + rows.open));
            reasons.extend(rows.reasons);
            reasons.extend(light::overlaps(answer));
            reasons.extend(light::directions(answer));
        }
        Self::from_reasons(reasons)
    }

    /// The worst of some reasons decides.
    fn from_reasons(mut reasons: Vec<Reason>) -> Self {
        reasons.sort_by_key(|reason| std::cmp::Reverse(reason.level));
        let level = reasons.first().map_or(Level::Good, |reason| reason.level);
        Self { level, reasons }
    }

    /// The same, doubtful where the error of what speaks for the answer may be so large that nobody could
    /// work with it, unless it has been said that it is not known or that orders are missing.
    pub fn with_error(mut self, error: &GroupError) -> Self {
        let is_named =
            |reason: &Reason| matches!(reason.cause, Cause::NotFinite | Cause::Unbounded | Cause::Truncation);
        if error.budget.upper95 > WIDE && !self.reasons.iter().any(is_named) {
            let (level, cause) = (Level::Doubtful, Cause::Uncertain);
            let (faces, objects) = (Vec::new(), Vec::new());
            let remedy = cause.remedy();
            self.reasons.push(Reason { level, cause, faces, objects, power_share: None, remedy });
        }
        Self::from_reasons(self.reasons)
    }

    /// Names of the causes, in one phrase.
    pub fn causes(&self) -> String {
        let names: Vec<&str> = self.reasons.iter().map(|reason| reason.cause.name()).collect();
        names.join(", ")
    }
}
