//! `radiosity plan`: what would be simulated, what not and why, and what it would cost.

use radiosity::solve::SolveError;
use radiosity::trace::Tracer;
use radiosity::transport::{Cost, Forecast};

use crate::args::{RunArgs, SceneArgs, SolverArgs};
use crate::factors::{Asked, FactorsArgs};
use crate::picture::PictureArgs;
use crate::terminal::{Failure, Terminal};

/// Tell what solve would simulate and what that would cost, without solving
///
/// Takes the options of solve. For every effect: whether the scene calls for it, why, and what it is
/// predicted to cost; that is what would be saved without it. A scene may be without light. Seconds are for a
/// machine like the one they were fitted on, two cores of an AMD EPYC. Patches where light reaches are told
/// from the shape of surfaces, and by a few rays how the sky and lights are looked for.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    factors: FactorsArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

pub fn run(args: &Args, terminal: &Terminal) -> Result<(), Failure> {
    let progress = terminal.progress();
    let look = args.picture.options(&args.run, progress)?;
    progress.at("load", 0.0)?;
    let (scene, plan) = args.factors.plan(args.scene.read()?, terminal)?;
    args.picture.refuse_to_leave_out(&scene, &args.factors)?;
    args.picture.warn_of_light_paths(&scene, terminal);
    progress.at("build", 0.0)?;
    let tracer = Tracer::new(&scene);
    if scene.has_exchange() {
        args.factors.check(&tracer, &args.run)?;
    }
    args.factors.check_receivers(&tracer, &args.run)?;
    let asked = Asked { pixels: look.width * look.height, chosen: None };
    let forecast = args.factors.forecast(&tracer, &args.solver, asked, &args.run)?;
    let plan = plan.foretold(&forecast);
    warn_of_factoring(&forecast, args.run.memory, terminal);
    let total = forecast.total();
    if args.run.json {
        let summary = serde_json::json!({
            "scene": scene.name(),
            "version": env!("CARGO_PKG_VERSION"),
            "threads": forecast.threads,
            "patches": forecast.patches,
            "rays": forecast.rays,
            "channels": scene.channels(),
            "plan": plan,
            "stages": forecast.stages,
            "total": total,
            "warnings": scene.warnings(),
        });
        terminal.print(serde_json::to_string_pretty(&summary)?)?;
    }
    let (faces, channels) = (scene.faces().len(), scene.channels());
    terminal.say(format_args!(
        "{}: {faces} faces, about {} patches, {} rays a patch, {channels} {}\n",
        scene.name(),
        forecast.patches,
        forecast.rays,
        if channels == 1 { "channel" } else { "channels" },
    ))?;
    terminal.say(format_args!(
        "  {:<16} {:<3} {}  why",
        "effect",
        "",
        columns(["rays", "seconds", "bytes"])
    ))?;
    for effect in &plan.effects {
        let on = if effect.on { "yes" } else { "no" };
        terminal.say(format_args!(
            "  {:<16} {on:<3} {}  {}",
            effect.effect,
            cost(effect.cost),
            effect.reason
        ))?;
    }
    terminal.say(format_args!("\n  {:<20} {}", "stage", columns(["rays", "seconds", "bytes"])))?;
    for stage in &forecast.stages {
        terminal.say(format_args!("  {:<20} {}", stage.name, cost(stage.cost)))?;
    }
    terminal.say(format_args!("  {:<20} {}", "all, held at once", cost(total)))?;
    terminal.say(format_args!(
        "\nPredicted for {} threads of a machine like the one this was fitted on (AMD EPYC), by a few rays from \
         here and there; else nothing was traced.",
        forecast.threads
    ))
}

/// Says so where the matrix of the direct solver would not fit, as solving would.
fn warn_of_factoring(forecast: &Forecast, limit: u64, terminal: &Terminal) {
    let factor = forecast.stages.iter().find(|stage| stage.name == "factor");
    let needed = factor.map_or(0, |stage| stage.cost.bytes);
    if needed > limit {
        terminal.warn(SolveError::Memory { n: forecast.patches, needed, limit });
    }
}

/// Three numbers under their names.
fn columns([rays, seconds, bytes]: [&str; 3]) -> String {
    format!("{rays:>10} {seconds:>9} {bytes:>10}")
}

/// What something costs; a dot for nothing.
fn cost(cost: Cost) -> String {
    let count = |n: u64, unit: &str| match n {
        0 => "·".to_owned(),
        1_000_000_000.. => format!("{:.1} G{unit}", n as f64 * 1e-9),
        1_000_000.. => format!("{:.1} M{unit}", n as f64 * 1e-6),
        1000.. => format!("{:.0} k{unit}", n as f64 * 1e-3),
        _ => format!("{n} {unit}"),
    };
    let seconds = match cost.seconds {
        0.0 => "·".to_owned(),
        s if s < 0.005 => "< 0.01".to_owned(),
        s => format!("{s:.2}"),
    };
    columns([count(cost.rays, "").trim_end(), &seconds, &count(cost.bytes, "B")])
}
