//! `radiosity solve`: the main job.

use std::iter;

use radiosity::measure::{self, Answer, Energy, ErrorBars, Undershoot, Verdict};
use radiosity::output::{self, EnergySummary, Photometry, Quantity, SeriesSummary, Summary};
use radiosity::patches::{Basis, Patches};
use radiosity::render::{self, RenderOptions, Shading, Surfaces};
use radiosity::scene::{Feature, Scene};
use radiosity::solve::{Amplification, NeumannOptions, Problem, Solution, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, ReceiverRows, Sources};

use crate::accuracy::{self, GoalArgs};
use crate::args::{RunArgs, SceneArgs, SolverArgs};
use crate::factors::FactorsArgs;
use crate::materials;
use crate::picture::{self, PictureArgs};
use crate::terminal::{Failure, Terminal};
use crate::verdict::{self, StrictArgs};

#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    goal: GoalArgs,
    #[command(flatten)]
    factors: FactorsArgs,
    #[command(flatten)]
    solver: SolverArgs,
    /// Also report in lm, lx and cd/m²: photometry.csv with flux, mean, lowest and highest illuminance and
    /// luminance and their uniformity by material, object, light and receiver; faces_photometric.csv and
    /// patches_photometric.csv; illuminance.png and luminance.png in false colours
    #[arg(long, help_heading = "Photometry")]
    photometric: bool,

    /// Also solve for the lamps of each material, and for all lights without area, by themselves, and write
    /// lamp_groups.csv
    #[arg(long, help_heading = "Solver")]
    lamp_groups: bool,

    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    strict: StrictArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

/// What the group of all lights without area and the sky is called.
const LIGHTS: &str = "lights without area";

pub fn run(args: &Args, terminal: &Terminal) -> Result<(), Failure> {
    let progress = terminal.progress();
    let look = args.picture.options(&args.run, progress)?;
    progress.at("load", 0.0)?;
    let (scene, plan) = args.factors.settle(args.scene.load()?, terminal)?;
    args.picture.refuse_to_leave_out(&scene, &args.factors)?;
    args.picture.warn_of_light_paths(&scene, terminal);
    let direct_only = scene.is_without(Feature::Interreflection);
    if args.lamp_groups && direct_only {
        return Err("--lamp-groups needs interreflection; leave one of the two out".into());
    }
    progress.at("build", 0.0)?;
    let tracer = Tracer::new(&scene);
    measure::odd_placement(&tracer, args.run.seed).iter().for_each(|odd| terminal.warn(odd));
    let (patches, factors, steps) = args.goal.obtain(&args.factors, &tracer, &args.run, terminal)?;
    // What was chosen on the way to an accuracy is not among the options.
    let chosen = (!steps.is_empty()).then(|| (patches.len(), factors.rays()));
    let plan = plan.foretold(&args.factors.forecast(&tracer, &args.solver, (&look, chosen), &args.run)?);
    let asked = args.factors.light(&args.run, progress);
    let light = match steps.is_empty() {
        true => asked,
        false => LightOptions { rays: factors.rays(), ..asked },
    };
    let problem = Problem::new(&tracer, &patches, &factors, &light)?;
    let groups = if args.lamp_groups { lamp_groups(&problem, &patches) } else { Vec::new() };
    progress.at("solve", 0.0)?;
    let amplification = Some(&Amplification::new(problem.operator(), Default::default())?);
    let options = SolveOptions { amplification, ..args.solver.options(&args.run, progress) };
    // All lamps together, then each group of lamps by itself: one factorization serves them all.
    let all: Vec<&Sources> = iter::once(problem.sources()).chain(groups.iter().map(|(_, s)| s)).collect();
    let mut solutions = problem.solve_each(&all, &options)?;
    let of_groups = solutions.split_off(1);
    let solution = &solutions[0];
    progress.at("series", 0.0)?;
    let (order, tolerance) = (args.solver.order, args.solver.tolerance);
    let series = problem.neumann(&NeumannOptions { order, tolerance, amplification, progress })?;

    let bars = ErrorBars::of(&patches, &problem, solution, progress)?;
    let energy = Energy::of(&problem, &solution.radiance);
    let verdict = Verdict::of(&Answer {
        tracer: &tracer,
        patches: &patches,
        problem: &problem,
        solution,
        energy: &energy,
        budget: Some(&bars.budget),
        tolerance,
    });

    let mut received = Vec::new();
    for receiver in scene.receivers() {
        let rows = ReceiverRows::trace(&tracer, &patches, problem.basis(), receiver, &light)?;
        received.push((
            receiver,
            rows.irradiance(if direct_only { &problem.sources().emitted } else { &solution.radiance }),
        ));
    }

    let camera = picture::camera(&tracer, &patches);
    let look = RenderOptions { carried: problem.carried(), ..look };
    let picture = render::picture(&tracer, &patches, &solution.radiance, &camera, &look)?;
    picture::warn_if_black(&picture, solution.irradiance.amax(), terminal);
    // Illuminance is shown from patches and corners, however light is.
    let shading = if look.shading == Shading::Flat { Shading::Flat } else { Shading::Smooth };
    let look = RenderOptions { shading, surfaces: Surfaces::Averaged, ..look };
    let false_colours = args.photometric.then(|| {
        let lux = output::luminous(&solution.irradiance, scene.efficacy());
        render::picture(&tracer, &patches, &lux, &camera, &look)
    });
    let false_colours = false_colours.transpose()?;
    progress.at("write", 0.0)?;
    let exposure = args.picture.exposure(&picture);
    let mut outputs = args.scene.outputs(&scene)?;
    // Tables have the means over patches.
    let means = solution.means();
    let (irradiance, radiance) = (&means.irradiance, &means.radiance);
    outputs.file("faces.csv", |file| output::write_faces(file, &patches, irradiance, radiance, &bars))?;
    outputs.file("patches.csv", |file| output::write_patches(file, &patches, irradiance, radiance, &bars))?;
    outputs
        .file("mesh.ply", |file| output::write_ply(file, &tracer, &patches, &solution.radiance, exposure))?;
    let received: Vec<_> = received.iter().map(|(receiver, h)| (*receiver, h)).collect();
    let efficacy = scene.efficacy();
    if !received.is_empty() {
        outputs.file("receivers.csv", |file| output::write_receivers(file, &received, efficacy))?;
    }
    let mut photometry: Vec<_> =
        received.iter().map(|(receiver, h)| Photometry::of_receiver(receiver, h, efficacy)).collect();
    if args.photometric {
        let mut rows = Photometry::of_surfaces(&patches, irradiance, radiance);
        rows.extend(Photometry::of_lights(&scene));
        photometry.splice(0..0, rows);
        outputs.file("photometry.csv", |file| output::write_photometry(file, &photometry))?;
        outputs.file("faces_photometric.csv", |file| {
            output::write_luminous_faces(file, &patches, irradiance, radiance)
        })?;
        outputs.file("patches_photometric.csv", |file| {
            output::write_luminous_patches(file, &patches, irradiance, radiance)
        })?;
        outputs.file("luminance.png", |file| {
            output::write_false_colours(file, &picture, Quantity::Luminance, efficacy)
        })?;
    }
    if let Some(picture) = &false_colours {
        outputs.file("illuminance.png", |file| {
            output::write_false_colours(file, picture, Quantity::Illuminance, 1.0)
        })?;
    }
    if args.lamp_groups {
        let of_groups: Vec<_> = of_groups.iter().map(Solution::means).collect();
        let lamps: Vec<_> = groups.iter().map(|(name, _)| name.as_str()).zip(&of_groups).collect();
        outputs.file("lamp_groups.csv", |file| output::write_lamp_groups(file, &patches, &lamps))?;
    }
    args.picture.write(&picture, &mut outputs)?;

    let summary = Summary {
        scene: scene.name().to_owned(),
        version: env!("CARGO_PKG_VERSION"),
        seed: args.run.seed,
        threads: rayon::current_num_threads(),
        patches: patches.len(),
        rays: factors.rays(),
        channels: scene.channels(),
        basis: problem.basis().name(),
        storage: factors.exchange().storage_name(),
        plan,
        stages: terminal.stages(),
        series: SeriesSummary::new(&series, solution),
        solver: solution.report.clone(),
        energy: (&energy).into(),
        closure: *factors.exchange().closure(),
        photometry,
        undershoot: Undershoot::of(problem.operator().mass(), &solution.radiance),
        error: bars.budget.clone(),
        steps,
        warnings: scene.warnings().to_vec(),
        verdict,
    };
    outputs.file("solution.json", |file| output::write_summary(file, &summary))?;
    let files = outputs.commit()?;
    if args.run.json {
        terminal.print(serde_json::to_string_pretty(&summary)?)?;
    }
    terminal.say(report(&summary, &scene, &factors))?;
    let folder = args.scene.folder(&scene);
    terminal.say(format_args!("\nwrote {} to {}", files.join(", "), folder.display()))?;
    verdict::warn(&summary.verdict, terminal);
    args.strict.conclude(&summary.verdict)
}

/// The lamps of each material by name, and all lights without area.
fn lamp_groups(problem: &Problem, patches: &Patches) -> Vec<(String, Sources)> {
    let basis = problem.basis();
    let mut groups: Vec<(String, Sources)> = patches
        .lamp_groups()
        .into_iter()
        .map(|group| (group.material, basis.coefficients_of(&group.emitted).into()))
        .collect();
    if problem.sources().direct.is_some() {
        groups.push((LIGHTS.to_owned(), problem.sources().without_emission()));
    }
    groups
}

/// What the user wants to know, in a dozen lines.
fn report(summary: &Summary, scene: &Scene, factors: &FormFactors) -> String {
    let faces = scene.faces().len();
    let exchange = factors.exchange();
    let Summary { solver, series, energy, closure, .. } = summary;
    let channels =
        if summary.channels == 1 { "one channel".into() } else { format!("{} channels", summary.channels) };
    let (elements, bounds) = match exchange.basis() {
        Basis::Constant => ("", ["error at most", "of the brightest patch, condition at most"]),
        Basis::Linear => (", linear", ["error about", "of the root mean square, condition about"]),
    };
    let rays = match summary.rays {
        0 => "without rays".to_owned(),
        rays => format!("{rays} rays a patch"),
    };
    let mut lines = vec![
        format!("{}: {faces} faces, {} patches{elements}, {channels}\n", summary.scene, summary.patches),
        format!("materials     {}", materials::line(scene)),
        format!(
            "form factors  {rays}, {:.1} MB {}; rows close to {:.0e}, from {:.0e} before balancing",
            factors.bytes() as f64 / 1e6,
            summary.storage,
            closure.after,
            closure.before
        ),
        format!(
            "solver        {}: residual {:.0e}, {} {} {} {}",
            solver.name,
            solver.residual,
            bounds[0],
            known(solver.bound, |bound| format!("{bound:.0e}")),
            bounds[1],
            known(solver.condition, |condition| format!("{condition:.3}"))
        ),
        format!(
            "series        order {}: residual {:.0e}, {:.0e} of the flux left, {} {}; {:.0e} from {}",
            series.order,
            series.residual,
            series.remaining_flux,
            bounds[0],
            known(series.bound, |bound| format!("{bound:.0e}")),
            series.difference,
            solver.name
        ),
        format!(
            "energy        emitted {} W, absorbed {} W, escaped {} W{}; imbalance {:.0e}{}",
            triple(energy.emitted),
            triple(energy.absorbed),
            triple(energy.escaped),
            elsewhere(energy),
            energy.imbalance,
            if energy.imbalance_error > 0.0 {
                format!(" ± {:.0e}", energy.imbalance_error)
            } else {
                String::new()
            }
        ),
        format!("verdict       {}\n", verdict::phrase(&summary.verdict)),
        format!("  order  flux it adds (W)            residual  {}", bounds[0]),
    ];
    if summary.undershoot.share > 0.0 {
        let [share, depth] = [summary.undershoot.share, summary.undershoot.depth].map(|part| 100.0 * part);
        let line = format!(
            "undershoot    below zero at corners on {share:.1} % of the area, by {depth:.2} % of the brightest at most"
        );
        lines.insert(lines.len() - 3, line);
    }
    if !summary.photometry.is_empty() {
        lines.insert(lines.len() - 1, illuminances(&summary.photometry));
    }
    if exchange.shrinkage() < 1.0 {
        let kept = exchange.shrinkage();
        lines.insert(
            3,
            format!("shrinkage     what varies within patches by {kept:.3}, for rays are too few for more"),
        );
    }
    // What a better answer would cost does not depend on pictures and files.
    let stages = summary.stages.iter().filter(|s| !["load", "build", "render", "write"].contains(&s.name));
    let answering: f64 = stages.map(|stage| stage.seconds).sum();
    lines.insert(2, format!("error         {}", accuracy::error_line(&summary.error, answering, series)));
    let told = |order: usize| order <= 5 || order.is_multiple_of(10) || order == series.order;
    lines.extend(series.bounces.iter().filter(|bounce| told(bounce.order)).map(|bounce| {
        let flux = triple(bounce.flux);
        let bound = known(bounce.bound, |bound| format!("{bound:.1e}"));
        format!("  {:>5}  {flux:26}   {:.1e}  {bound}", bounce.order, bounce.residual)
    }));
    let seconds: f64 = summary.stages.iter().map(|stage| stage.seconds).sum();
    let long = summary.stages.iter().filter(|stage| stage.seconds >= 0.005);
    let stages: Vec<String> = long.map(|stage| format!("{} {:.2}", stage.name, stage.seconds)).collect();
    lines.push(format!("\n{seconds:.2} s on {} threads: {}", summary.threads, stages.join(", ")));
    lines.join("\n")
}

/// A bound, where there is one.
fn known(bound: f64, print: impl Fn(f64) -> String) -> String {
    if bound.is_finite() { print(bound) } else { "unknown".into() }
}

/// What ends in mirrors and glass, and what is missing, where anything does or is.
fn elsewhere(energy: &EnergySummary) -> String {
    let part = |name: &str, power: [f64; 3]| match power {
        [0.0, 0.0, 0.0] => String::new(),
        power => format!(", {name} {} W", triple(power)),
    };
    part("in carriers", energy.carriers) + &part("lost", energy.lost) + &part("slack", energy.slack)
}

/// A table of illuminances, lx.
fn illuminances(rows: &[Photometry]) -> String {
    let mut text = format!(
        "  {:<28} {:>10} {:>10} {:>10} {:>11}\n",
        "illuminance, lx", "mean", "minimum", "maximum", "uniformity"
    );
    for (row, lux) in rows.iter().filter_map(|row| Some((row, row.illuminance?))) {
        let name = format!("{} {}", row.kind, row.name);
        let [mean, minimum, maximum] = [lux.mean, lux.minimum, lux.maximum].map(short);
        text += &format!("  {name:<28} {mean:>10} {minimum:>10} {maximum:>10} {:>11.3}\n", lux.uniformity);
    }
    text
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
