//! `radiosity compare`: the matrix answers against light paths.

use std::time::Instant;

use radiosity::measure::{
    Agreement, AgreementTest, Answer, Comparison, Energy, MeshError, OrderOptions, OrderRow, Verdict,
};
use radiosity::output::{
    self, BouncePictures, ComparisonOptions, ComparisonSummary, DirectSummary, OrderSummary, OrdersPlot,
    Outputs,
};
use radiosity::parallel;
use radiosity::patches::Patches;
use radiosity::progress::Progress;
use radiosity::reference::{Budget, PathOptions, PathTracer};
use radiosity::render::{self, Picture, RenderError, RenderOptions, Shading};
use radiosity::scene::Scene;
use radiosity::solve::{Amplification, Certainty, Problem, Report, Solution, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::Keep;

use crate::args::{RunArgs, SceneArgs, SolverArgs};
use crate::factors::FactorsArgs;
use crate::terminal::{Failure, Terminal};
use crate::verdict::{self, StrictArgs};
use crate::{picture, values};

/// Compare the direct solution and every order of the series with a path-traced reference
///
/// The reference follows light paths on the surfaces themselves and knows its own standard error. Writes
/// comparison.json, comparison.csv (both irradiances of every patch, W/m²), comparison.png (matrix,
/// reference, difference), bounces.png (light bounce by bounce) and orders.svg (error against order).
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    factors: FactorsArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    reference: ReferenceArgs,
    #[command(flatten)]
    strict: StrictArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reference")]
struct ReferenceArgs {
    /// Trace paths until all patches together are known this well (relative standard error) [default: 2%,
    /// unless --seconds or --paths is given]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = values::share)]
    standard_error: Option<f64>,

    /// Trace paths for so many seconds at most
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = values::positive_length)]
    seconds: Option<f64>,

    /// Trace so many paths at most; every patch gets some
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = values::positive)]
    paths: Option<usize>,

    /// Width and height of each picture in pixels
    #[arg(
        long,
        value_name = "WxH",
        default_value = "400x300",
        allow_hyphen_values = true,
        value_parser = values::size,
    )]
    size: (usize, usize),

    /// Paths per pixel of the reference picture; best a power of two
    #[arg(
        long,
        value_name = "N",
        default_value_t = 64,
        allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(1..=1 << 20),
    )]
    samples: u32,
}

impl ReferenceArgs {
    /// What each picture looks like; refuses an impossible size before any work is done.
    fn look<'a>(&self, run: &RunArgs, progress: Progress<'a>) -> Result<RenderOptions<'a>, RenderError> {
        let (width, height) = self.size;
        let (samples, seed) = (self.samples, run.seed);
        let look = RenderOptions { width, height, samples, seed, progress, ..Default::default() };
        look.validate()?;
        Ok(look)
    }

    fn budget(&self) -> Budget {
        let &Self { standard_error, seconds, paths, .. } = self;
        let otherwise = if seconds.is_none() && paths.is_none() { Some(0.02) } else { None };
        Budget { standard_error: standard_error.or(otherwise), seconds, paths: paths.map(|n| n as u64) }
    }
}

/// What pictures show: a solution, and the problem's bounces up to the last.
struct Shown<'a> {
    problem: &'a Problem,
    solution: &'a Solution,
    last: usize,
}

/// The matrix answer, light paths, and bounces.
struct Pictures {
    matrix: Picture,
    traced: Picture,
    bounces: Vec<BouncePictures>,
}

impl Pictures {
    fn draw(
        tracer: &Tracer,
        patches: &Patches,
        Shown { problem, solution, last }: Shown,
        look: &RenderOptions,
    ) -> Result<Self, Failure> {
        let camera = picture::camera(tracer, patches);
        let picture = |shading| {
            render::picture(tracer, patches, &solution.radiance, &camera, &RenderOptions { shading, ..*look })
        };
        let [matrix, traced] = [picture(Shading::Smooth)?, picture(Shading::Path)?];
        let terms = problem.bounces(last);
        let bounces = BouncePictures::render(tracer, patches, &terms, &camera, look)?;
        Ok(Self { matrix, traced, bounces })
    }

    /// Writes them; `notes` stand under the two first.
    fn write(&self, outputs: &mut Outputs, notes: [&str; 2]) -> Result<(), Failure> {
        let Self { matrix, traced, bounces } = self;
        let panels = ComparisonOptions { notes, ..Default::default() };
        outputs.file("comparison.png", |file| output::write_comparison(file, matrix, traced, &panels))?;
        outputs.file("bounces.png", |file| output::write_bounces(file, bounces))?;
        Ok(())
    }
}

/// The residual of the solution, as a part of --tolerance.
const SOLVED_BETTER: f64 = 1e-3;

/// The highest bounce that gets a picture of its own.
const LAST_PICTURE: usize = 4;

pub fn run(args: &Args, terminal: &Terminal) -> Result<(), Failure> {
    let progress = terminal.progress();
    let look = args.reference.look(&args.run, progress)?;
    progress.at("load", 0.0)?;
    let (scene, _) = args.factors.settle(args.scene.load()?, terminal)?;
    args.factors.refuse_to_leave_out(&scene, "the path-traced reference follows all light")?;

    progress.at("build", 0.0)?;
    let began = Instant::now();
    let tracer = Tracer::new(&scene);
    let (patches, factors) = args.factors.obtain(&tracer, &args.run, Keep::Nothing, terminal)?;
    let problem = Problem::new(&tracer, &patches, &factors, &args.factors.light(&args.run, progress))?;
    let before_solving = began.elapsed().as_secs_f64();
    progress.at("solve", 0.0)?;
    let amplification = Amplification::new(problem.operator(), Default::default())?;
    let options = args.solver.options(&args.run, progress);
    // The solution that orders are held against must be much better than the best of them.
    let tolerance = (SOLVED_BETTER * options.tolerance).max(1e-13);
    let options = SolveOptions { amplification: Some(&amplification), tolerance, ..options };
    let direct = problem.solve(&options)?;
    let direct_seconds = began.elapsed().as_secs_f64();
    let verdict = Verdict::of(&Answer {
        tracer: &tracer,
        patches: &patches,
        problem: &problem,
        solution: &direct,
        energy: &Energy::of(&problem, &direct.radiance),
        budget: None,
        tolerance,
    });

    let budget = args.reference.budget();
    let options = PathOptions { budget, seed: args.run.seed, progress, ..Default::default() };
    let reference = PathTracer::new(&tracer).irradiance(&patches, &options)?;
    progress.at("mesh", 0.0)?;
    let (tessellation, trace) = args.factors.options(&args.run, progress);
    let mesh = MeshError::estimate(&tracer, &patches, &factors, &tessellation, &trace)?;
    progress.at("series", 0.0)?;
    let limits = OrderOptions { tolerance: args.solver.tolerance, order: args.solver.order, progress };
    let orders = OrderRow::all(&problem, &direct.irradiance, &reference, &amplification, &limits)?;
    // Tables have the means over patches.
    let irradiance = &direct.means().irradiance;
    let comparison = Comparison::new(&patches, irradiance, &reference, &mesh);

    let last = LAST_PICTURE.min(orders.len().max(2) - 1);
    let pictures =
        Pictures::draw(&tracer, &patches, Shown { problem: &problem, solution: &direct, last }, &look)?;
    picture::warn_if_black(&pictures.matrix, direct.irradiance.amax(), terminal);

    progress.at("write", 0.0)?;
    let mut outputs = args.scene.outputs(&scene)?;
    outputs.file("comparison.csv", |file| {
        output::write_comparison_table(file, &patches, irradiance, &reference, &mesh)
    })?;
    let by_solver = format!("{} patches, {} solver, smooth shading", patches.len(), direct.report.name);
    pictures.write(&mut outputs, [&by_solver, &format!("{} paths a pixel", look.samples)])?;
    let plot = plot(&scene, &orders, &comparison, reference.relative_standard_error());
    outputs.file("orders.svg", |file| output::write_orders_plot(file, &plot))?;
    let summary = ComparisonSummary {
        scene: scene.name().to_owned(),
        version: env!("CARGO_PKG_VERSION"),
        seed: args.run.seed,
        threads: parallel::threads(),
        patches: patches.len(),
        rays: factors.rays(),
        basis: problem.basis().name(),
        orders: orders.iter().map(|row| OrderSummary::new(row, before_solving)).collect(),
        direct: DirectSummary::new(&comparison, direct_seconds),
        reference: (&reference).into(),
        stages: terminal.stages(),
        warnings: scene.warnings().to_vec(),
        verdict,
    };
    outputs.file("comparison.json", |file| output::write_comparison_summary(file, &summary))?;
    let files = outputs.commit()?;
    if args.run.json {
        terminal.print(serde_json::to_string_pretty(&summary)?)?;
    }
    terminal.say(report(&summary, scene.faces().len(), &direct.report))?;
    let folder = args.scene.folder(&scene);
    terminal.say(format_args!("\nwrote {} to {}", files.join(", "), folder.display()))?;
    verdict::warn(&summary.verdict, terminal);
    args.strict.conclude(&summary.verdict)
}

fn plot(scene: &Scene, orders: &[OrderRow], comparison: &Comparison, noise_floor: f64) -> OrdersPlot {
    let column = |value: fn(&OrderRow) -> f64| orders.iter().map(value).collect();
    OrdersPlot {
        orders: orders.iter().map(|row| row.order).collect(),
        vs_direct: column(|row| row.vs_direct),
        vs_reference: column(|row| row.vs_reference.rms),
        uncertainty: column(|row| row.vs_reference.uncertainty),
        bound: column(|row| row.bound),
        direct_vs_reference: comparison.by_patch.rms,
        noise_floor,
        title: format!("{}: error of the Neumann series, irradiance by patch", scene.name()),
    }
}

/// What the user wants to know, in a screenful.
fn report(summary: &ComparisonSummary, faces: usize, solver: &Report) -> String {
    let ComparisonSummary { direct, reference, orders, .. } = summary;
    let certainty = match solver.certainty {
        Certainty::Guaranteed => "guaranteed",
        Certainty::Estimated => "estimated",
    };
    let mut lines = vec![
        format!(
            "{}: {faces} faces, {} patches, {} rays a patch\n",
            summary.scene, summary.patches, summary.rays
        ),
        format!(
            "reference     {} paths in {:.1} s; standard error of a patch {}",
            millions(reference.paths),
            reference.seconds,
            percent(reference.standard_error)
        ),
        format!("mesh          patches half as long change the answer by {}\n", percent(direct.mesh_error)),
        columns(["order", "from direct", certainty, "from reference", "mean", "worst patch", "seconds"]),
    ];
    let is_told = |order: usize| order <= 5 || order.is_multiple_of(10) || order + 1 == orders.len();
    lines.extend(orders.iter().filter(|o| is_told(o.order)).map(|o| {
        columns([
            &o.order.to_string(),
            &format!("{:.0e}", o.vs_direct),
            &o.bound.map_or("none yet".into(), |bound| format!("{bound:.0e}")),
            &uncertain(o.vs_reference, o.uncertainty),
            &signed_percent(o.bias),
            &signed_percent(o.worst),
            &format!("{:.2}", o.seconds),
        ])
    }));
    lines.push(columns([
        solver.name,
        "",
        "",
        &uncertain(direct.vs_reference, direct.uncertainty),
        &signed_percent(direct.bias),
        &signed_percent(direct.worst),
        &format!("{:.2}", direct.seconds),
    ]));
    lines.push(format!("\nThe matrix answer {}.", direct.verdict));
    let decision = direct.reasons.iter().map(|test| test.agreement).max();
    lines.extend(direct.reasons.iter().map(|test| told(test, decision)));
    lines.push(format!("\nverdict       {}", verdict::phrase(&summary.verdict)));
    lines.join("\n")
}

/// One test of the comparison: its numbers, and where it decides, what follows.
fn told(test: &AgreementTest, decision: Option<Agreement>) -> String {
    let found = match test.what {
        "mean" | "worst patch" => signed_percent(test.found),
        _ => percent(test.found),
    };
    let (chance, mesh) = (percent(test.chance), percent(test.mesh));
    let follows = match test.agreement {
        agreement if decision != Some(agreement) => "",
        Agreement::WithinNoise => "",
        Agreement::MeshExplains => ": more than noise, no more than mesh error",
        Agreement::MeshTooCoarse => ": more than noise; use more --patches to know the mesh error",
        Agreement::NothingExplains => ": something is wrong",
    };
    format!(
        "  {:<12} {found:>8} ± {:<8} chance by noise {chance}, mesh error up to {mesh}{follows}",
        test.what,
        percent(test.uncertainty)
    )
}

/// A line of the table.
fn columns([order, direct, bound, reference, mean, worst, seconds]: [&str; 7]) -> String {
    format!("  {order:>6}  {direct:>11}  {bound:>10}  {reference:>17}  {mean:>8}  {worst:>11}  {seconds:>7}")
}

fn uncertain(share: f64, error: f64) -> String {
    format!("{} ± {}", percent(share), percent(error))
}

fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        x if x >= 100.0 => format!("{:.0} %", 100.0 * share),
        x if x >= 10.0 => format!("{:.1} %", 100.0 * share),
        _ => format!("{:.2} %", 100.0 * share),
    }
}

fn signed_percent(share: f64) -> String {
    if share > 0.0 { format!("+{}", percent(share)) } else { percent(share) }
}

fn millions(count: u64) -> String {
    match count {
        1_000_000.. => format!("{:.1} million", count as f64 / 1e6),
        _ => count.to_string(),
    }
}
