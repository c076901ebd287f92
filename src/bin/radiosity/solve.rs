//! `radiosity solve`: the main job.

use radiosity::measure::Energy;
use radiosity::output::{self, PlanEntry, SeriesSummary, Summary};
use radiosity::patches::Patches;
use radiosity::solve::{self, NeumannOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Plan, Transport};

use crate::args::{AccuracyArgs, Failure, PictureArgs, RunArgs, SceneArgs, SolverArgs};
use crate::terminal::Terminal;

#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    accuracy: AccuracyArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

pub fn run(args: &Args, terminal: &Terminal) -> Result<(), Failure> {
    let progress = terminal.progress();
    progress.at("load", 0.0)?;
    let scene = args.scene.load()?;
    scene.require_light()?;
    let plan = Plan::new(&scene);
    terminal.warn_of(&scene);

    progress.at("build", 0.0)?;
    let tracer = Tracer::new(&scene);
    let mut patches = Patches::new(&tracer, &args.accuracy.tessellation(&args.run, progress))?;
    let factors = FormFactors::trace(&tracer, &mut patches, &args.accuracy.trace(&args.run, progress))?;
    terminal.takes(factors.exchange().bytes());
    let k = Transport::of(&factors, &patches)?;
    let sources = patches.sources();
    let solution = solve::solve(&k, &sources, &args.solver.options(&args.run, progress))?;
    progress.at("series", 0.0)?;
    let (order, tolerance) = (args.solver.order, args.solver.tolerance);
    let series = solve::neumann(&k, &sources, &NeumannOptions { order, tolerance, progress })?;

    let camera = args.picture.camera(&tracer, &patches);
    let picture =
        output::render(&tracer, &patches, &solution.radiance, &camera, &args.picture.options(progress))?;
    progress.at("write", 0.0)?;
    let folder = args.scene.folder(&scene)?;
    let mut files = vec!["solution.json", "faces.csv", "patches.csv", "mesh.ply"];
    output::write_faces(&folder.join("faces.csv"), &patches, &solution.irradiance, &solution.radiance)?;
    output::write_patches(&folder.join("patches.csv"), &patches, &solution.irradiance, &solution.radiance)?;
    let exposure = args.picture.exposure(&picture);
    output::write_ply(folder.join("mesh.ply"), &tracer, &patches, &solution.radiance, exposure)?;
    files.extend(args.picture.save(&picture, &folder)?);

    let area_unit = tracer.frame().scale().powi(2);
    let energy = Energy::new(&k, &sources, &solution.radiance, area_unit);
    let summary = Summary {
        scene: scene.name().to_owned(),
        version: env!("CARGO_PKG_VERSION"),
        seed: args.run.seed,
        threads: rayon::current_num_threads(),
        patches: patches.len(),
        rays: factors.rays(),
        channels: scene.channels(),
        storage: factors.exchange().storage_name(),
        plan: plan.effects.iter().cloned().map(PlanEntry::from).collect(),
        stages: terminal.stages(),
        series: SeriesSummary::new(&series, &solution, area_unit),
        solver: solution.report.clone(),
        energy: (&energy).into(),
        closure: *factors.exchange().closure(),
        error: None,
        warnings: scene.warnings().to_vec(),
    };
    output::write_summary(&folder.join("solution.json"), &summary)?;
    if args.run.json {
        println!("{}", serde_json::to_string_pretty(&summary)?);
    }
    report(&summary, scene.faces().len(), factors.exchange().bytes(), terminal);
    terminal.say(format_args!("\nwrote {} to {}", files.join(", "), folder.display()));
    Ok(())
}

fn report(summary: &Summary, faces: usize, bytes: u64, terminal: &Terminal) {
    let Summary { solver, series, energy, closure, .. } = summary;
    let say = |line: std::fmt::Arguments| terminal.say(line);
    let channels =
        if summary.channels == 1 { "one channel".into() } else { format!("{} channels", summary.channels) };
    say(format_args!("{}: {faces} faces, {} patches, {channels}\n", summary.scene, summary.patches));
    say(format_args!(
        "form factors  {} rays a patch, {} {}; rows close to {:.0e}, from {:.0e} before balancing",
        summary.rays,
        megabytes(bytes),
        summary.storage,
        closure.after,
        closure.before
    ));
    say(format_args!(
        "solver        {}: residual {:.0e}, error at most {:.0e} of the brightest patch, condition at most {:.3}",
        solver.name, solver.residual, solver.bound, solver.condition
    ));
    say(format_args!(
        "series        order {}: residual {:.0e}, error at most {:.0e}; {:.0e} from {}",
        series.order, series.residual, series.bound, series.difference, solver.name
    ));
    say(format_args!(
        "energy        emitted {} W, absorbed {} W, escaped {} W; imbalance {:.0e}\n",
        triple(energy.emitted),
        triple(energy.absorbed),
        triple(energy.escaped),
        energy.imbalance
    ));
    say(format_args!("  order  flux it adds (W)            residual  error at most"));
    let last = series.order;
    for bounce in series.bounces.iter().filter(|b| b.order <= 5 || b.order % 10 == 0 || b.order == last) {
        let flux = triple(bounce.flux);
        say(format_args!("  {:>5}  {flux:26}   {:.1e}  {:.1e}", bounce.order, bounce.residual, bounce.bound));
    }
    let total: f64 = summary.stages.iter().map(|s| s.seconds).sum();
    let stages: Vec<String> = summary
        .stages
        .iter()
        .filter(|s| s.seconds >= 0.005)
        .map(|s| format!("{} {:.2}", s.name, s.seconds))
        .collect();
    say(format_args!("\n{total:.2} s on {} threads: {}", summary.threads, stages.join(", ")));
}

/// Three numbers, or one where all are the same.
fn triple([r, g, b]: [f64; 3]) -> String {
    if r == g && g == b { short(r) } else { format!("{} {} {}", short(r), short(g), short(b)) }
}

/// A number with four significant digits.
fn short(x: f64) -> String {
    let magnitude = if x == 0.0 { 0 } else { x.abs().log10().floor() as i32 };
    match magnitude {
        -3..=5 => format!("{x:.*}", (3 - magnitude).max(0) as usize),
        _ => format!("{x:.3e}"),
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}
