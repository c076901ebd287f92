//! Accuracy: how much error is asked for, what was done for it, and how wrong the answer is.

use std::time::Duration;

use radiosity::measure::{
    self, AccuracyStep, Accurate, Ending, ErrorBars, ErrorBudget, ErrorPart, Goal, GroupError, Resource,
    Tolerated,
};
use radiosity::output::SeriesSummary;
use radiosity::patches::Patches;
use radiosity::scene::Scene;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, Received};

use crate::args::RunArgs;
use crate::factors::FactorsArgs;
use crate::terminal::{Failure, Terminal};
use crate::values;
use crate::verdict::phrase;

/// What to stop at.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Accuracy")]
pub struct GoalArgs {
    /// Choose patches and rays such that irradiance by face errs no more than this on any object, in 95
    /// cases of 100: 1%, or 0.2W/m2, or 5lx (relative, or absolute, root mean square over the object's
    /// faces; objects with less than a hundredth of all patches are left out), and at receivers
    #[arg(
        long,
        value_name = "ERROR",
        allow_hyphen_values = true,
        value_parser = wanted,
        conflicts_with_all = ["patches", "edge", "rays", "factors", "save_factors"]
    )]
    accuracy: Option<Wanted>,

    /// Choose patches and rays such that the whole run takes about so long, such as 10s, 2min or 1h; with
    /// --accuracy, at most so long
    #[arg(
        long,
        value_name = "TIME",
        allow_hyphen_values = true,
        value_parser = values::duration,
        conflicts_with_all = ["patches", "edge", "rays", "factors", "save_factors"]
    )]
    time: Option<Duration>,
}

/// An error in one of three units.
#[derive(Clone, Copy, Debug)]
enum Wanted {
    Share(f64),
    Irradiance(f64),
    Illuminance(f64),
}

impl GoalArgs {
    /// The error that was asked for.
    pub fn tolerated(&self, scene: &Scene) -> Option<Tolerated> {
        self.accuracy.map(|wanted| match wanted {
            Wanted::Share(share) => Tolerated::Relative(share),
            Wanted::Irradiance(h) => Tolerated::Irradiance(h),
            Wanted::Illuminance(lux) => Tolerated::Irradiance(lux / scene.efficacy()),
        })
    }

    /// What was reached of an error that was asked for in W/m² or lx, in that unit; of others percents tell.
    pub fn outcome(&self, bars: &ErrorBars, scene: &Scene) -> Option<String> {
        let (asked, unit, per_watt) = match self.accuracy? {
            Wanted::Share(_) => return None,
            Wanted::Irradiance(h) => (h, "W/m²", 1.0),
            Wanted::Illuminance(lux) => (lux, "lx", scene.efficacy()),
        };
        let size = |budget: &ErrorBudget| per_watt * budget.upper95 * budget.irradiance;
        let error = bars.headline(size);
        let reached = size(&error.budget);
        let reached = match reached.is_finite() {
            true => format!("± {} {unit}", two_digits(reached)),
            false => "unknown".into(),
        };
        Some(format!(
            "accuracy      {reached} {} (95 %), where it is the largest; asked for: {asked} {unit}\n",
            place(&error)
        ))
    }

    /// Cuts and traces as the goal asks for, if there is one; else as the other arguments do.
    pub fn obtain<'s>(
        &self,
        factors: &FactorsArgs,
        tracer: &Tracer<'s>,
        run: &RunArgs,
        terminal: &Terminal,
    ) -> Result<(Patches<'s>, FormFactors, Vec<AccuracyStep>), Failure> {
        if self.accuracy.is_none() && self.time.is_none() {
            let (patches, factors) = factors.obtain(tracer, run, Keep::Rays, terminal)?;
            return Ok((patches, factors, Vec::new()));
        }
        factors.refuse_to_leave_out(tracer.scene(), "--accuracy and --time follow all light")?;
        let error = self.tolerated(tracer.scene());
        let goal = Goal { error, seconds: self.time.map(|time| time.as_secs_f64()) };
        let (tessellation, trace) = factors.options(run, terminal.progress());
        let Accurate { patches, factors, steps, ending, verdict } =
            measure::reach(tracer, goal, &tessellation, &trace)?;
        terminal.takes(factors.exchange().bytes());
        terminal.say(told(&steps))?;
        match ending {
            Ending::Reached => {}
            Ending::Doubtful => terminal.warn(format_args!(
                "the accuracy that was asked for is not reached: the verdict on the best answer is {}",
                phrase(&verdict)
            )),
            Ending::Short { of, needed, seconds } => terminal.warn(shortfall(of, needed, seconds)),
        }
        Ok((patches, factors, steps))
    }
}

/// The receivers that are not known as well as was asked for, in words.
pub fn missed_receivers(
    received: &[Received],
    bars: &ErrorBars,
    tolerated: Tolerated,
) -> impl Iterator<Item = String> {
    let all = received.iter().zip(&bars.receivers);
    all.filter_map(move |(received, bars)| {
        let error = percent(measure::missed(bars, tolerated)?);
        Some(format!(
            "receiver {} is known to ± {error} % only, on the whole or at a point: less well than was asked for",
            received.receiver.name
        ))
    })
}

/// A table of steps.
fn told(steps: &[AccuracyStep]) -> String {
    let mut text = String::from("  step  patches  rays  seconds   error up to   (mesh, noise)\n");
    for (k, step) in steps.iter().enumerate() {
        let [upper, mesh, noise] = [step.upper95, step.mesh, step.noise].map(percent);
        text += &format!(
            "  {:>4}  {:>7}  {:>4}  {:>7.2}  {upper:>10} %   ({mesh} %, {noise} %)\n",
            k + 1,
            step.patches,
            step.rays,
            step.seconds
        );
    }
    text
}

fn shortfall(of: Resource, needed: measure::Setting, seconds: f64) -> String {
    let what = match of {
        Resource::Time => "the time was too short for the accuracy that was asked for",
        Resource::Memory => "the memory is too small for the accuracy that was asked for",
        Resource::Effect => "the accuracy that was asked for was not reached in so many steps",
    };
    if seconds.is_finite() {
        format!(
            "{what}; this is the best answer there is. It would take about {:.0} patches with {:.0} rays each, {}",
            needed.patches,
            needed.rays,
            duration(seconds)
        )
    } else {
        format!(
            "{what}; this is the best answer there is, and no number of patches and rays within reach would do"
        )
    }
}

/// How wrong the answer is, and what would help: the line that matters. `seconds` is what the answer took,
/// and `series` what is known of a truncated one.
pub fn error_line(error: &GroupError, seconds: f64, series: &SeriesSummary) -> String {
    let budget = &error.budget;
    let noise = budget.part(ErrorPart::RAYS).hypot(budget.part(ErrorPart::LAMPS));
    let mesh = budget.part(ErrorPart::MESH);
    let truncation = budget.part(ErrorPart::TRUNCATION);
    // With four times the patches each face has four times the rays too.
    let slack = budget.part(ErrorPart::SLACK);
    let rounding = budget.part(ErrorPart::SOLVER) + budget.part(ErrorPart::STORAGE);
    let remedy = if rounding > mesh.max(noise).max(truncation).max(slack) {
        "mostly rounding, amplified where next to nothing absorbs; lower the highest reflectance".into()
    } else if slack > mesh.max(noise).max(truncation) {
        "mostly slack; `radiosity check` says where".into()
    } else if truncation > mesh.max(noise) {
        truncated(truncation / mesh.hypot(noise).max(WELL), budget.irradiance, series)
    } else if mesh > noise {
        format!("mostly mesh; 4 × the patches would about halve it, in {}", duration(4.0 * seconds))
    } else {
        format!("mostly noise; 4 × the rays would about halve it, in {}", duration(4.0 * seconds))
    };
    let place = place(error);
    if budget.upper95.is_finite() {
        format!("± {} % {place} (95 %), {remedy}", percent(budget.upper95))
    } else {
        format!("{place} unknown, {remedy}")
    }
}

/// Where an error is.
fn place(error: &GroupError) -> String {
    match error.kind {
        GroupError::ALL => "by face".to_owned(),
        GroupError::RECEIVER => format!("at receiver {}", error.name),
        kind => format!("by face on {kind} {}", error.name),
    }
}

/// Truncation is well below other errors at this part of the answer where there are none.
const WELL: f64 = 1e-3;

/// What a truncated series lacks, and how many orders would make it so many times less.
fn truncated(excess: f64, irradiance: f64, series: &SeriesSummary) -> String {
    let order = series.order;
    let remaining = |order: usize| series.bounces.get(order).map_or(1.0, |bounce| bounce.remaining_flux);
    // Each order passes on about the same part of what arrives.
    let passed_on = if order == 0 { remaining(0) } else { remaining(order) / remaining(order - 1) };
    let more = (excess.max(1.0).ln() / -passed_on.clamp(0.01, 0.999).ln()).ceil().max(1.0);
    let remedy = if more.is_finite() {
        format!("--order {} would do, or --solver auto", order as f64 + more)
    } else {
        "use --solver auto".into()
    };
    if irradiance == 0.0 {
        format!("no light has arrived yet at order {order}; {remedy}")
    } else {
        let left = percent(series.remaining_flux);
        format!("mostly truncation at order {order}, with {left} % of the flux still on its way; {remedy}")
    }
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

/// A share in percent with two digits.
pub fn percent(share: f64) -> String {
    two_digits(100.0 * share)
}

fn two_digits(x: f64) -> String {
    let digits = if x > 0.0 { (1.0 - x.log10().floor()).clamp(0.0, 6.0) as usize } else { 0 };
    format!("{x:.digits$}")
}

fn wanted(text: &str) -> Result<Wanted, String> {
    let absolute =
        |unit: &str| text.strip_suffix(unit).and_then(|number| values::positive_length(number.trim()).ok());
    if let Some(h) = absolute("W/m2").or_else(|| absolute("W/m²")) {
        Ok(Wanted::Irradiance(h))
    } else if let Some(lux) = absolute("lx") {
        Ok(Wanted::Illuminance(lux))
    } else {
        values::share(text)
            .map(Wanted::Share)
            .map_err(|_| "write it as 1%, 0.01, 0.2W/m2 or 5lx; above 0".into())
    }
}
