//! `radiosity solve`: the main job.

use std::iter;

use radiosity::measure::{self, Answer, Energy, ErrorBars, GroupError, Undershoot, Verdict};
use radiosity::output::{self, Outputs, Photometry, Quantity, SeriesSummary, Summary};
use radiosity::parallel;
use radiosity::patches::Patches;
use radiosity::progress::Progress;
use radiosity::render::{self, Picture, RenderOptions, Shading, Surfaces};
use radiosity::scene::{Feature, Scene};
use radiosity::solve::{Amplification, NeumannOptions, Problem, Series, Solution, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{LightOptions, Plan, Received, Sources};

use crate::accuracy::{self, GoalArgs};
use crate::args::{RunArgs, SceneArgs, SolverArgs};
use crate::factors::{Asked, Chosen, FactorsArgs};
use crate::picture::{self, PictureArgs};
use crate::solve_report;
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
    let (scene, plan) = load(args, terminal)?;
    progress.at("build", 0.0)?;
    let tracer = &Tracer::new(&scene);
    args.factors.check_receivers(tracer, &args.run)?;
    measure::odd_placement(tracer, args.run.seed).iter().for_each(|odd| terminal.warn(odd));
    let (patches, factors, steps) = args.goal.obtain(&args.factors, tracer, &args.run, terminal)?;
    let chosen = (!steps.is_empty()).then(|| Chosen { patches: patches.len(), rays: factors.rays() });
    let asked = Asked { pixels: look.width * look.height, chosen };
    let plan = plan.foretold(&args.factors.forecast(tracer, &args.solver, asked, &args.run)?);
    let asked = args.factors.light(&args.run, progress);
    let light = match steps.is_empty() {
        true => asked,
        false => LightOptions { rays: factors.rays(), ..asked },
    };
    let problem = &Problem::new(tracer, &patches, &factors, &light)?;
    let job = Job { args, tracer, patches: &patches, problem };
    let Solved { solution, series, lamps } = &job.solve(progress)?;

    let received = job.receive(solution, &light)?;
    received.iter().filter_map(measure::unlit_points).for_each(|text| terminal.warn(text));
    let bars = ErrorBars::with_receivers(&patches, problem, solution, &received, progress)?;
    if let Some(tolerated) = args.goal.tolerated(&scene) {
        accuracy::missed_receivers(&received, &bars, tolerated).for_each(|text| terminal.warn(text));
    }
    let outcome = args.goal.outcome(&bars, &scene);
    let (energy, error, verdict) = job.judge(solution, &bars);
    let pictures = job.draw(solution, &look)?;
    picture::warn_if_black(&pictures.picture, solution.irradiance.amax(), terminal);

    progress.at("write", 0.0)?;
    let mut outputs = args.scene.outputs(&scene)?;
    // Tables have the means over patches.
    let means = &solution.means();
    job.write_tables(&mut outputs, means, &bars)?;
    let exposure = args.picture.exposure(&pictures.picture);
    outputs
        .file("mesh.ply", |file| output::write_ply(file, tracer, &patches, &solution.radiance, exposure))?;
    let of_receivers = job.write_receivers(&mut outputs, &received, &bars)?;
    let photometry = job.write_photometry(&mut outputs, (means, &bars), of_receivers)?;
    job.write_false_colours(&mut outputs, &pictures)?;
    job.write_lamps(&mut outputs, lamps)?;
    args.picture.write(&pictures.picture, &mut outputs)?;
    let summary = Summary {
        scene: scene.name().to_owned(),
        version: env!("CARGO_PKG_VERSION"),
        seed: args.run.seed,
        threads: parallel::threads(),
        patches: patches.len(),
        rays: factors.rays(),
        channels: scene.channels(),
        basis: problem.basis().name(),
        storage: factors.exchange().storage_name(),
        plan,
        stages: terminal.stages(),
        series: SeriesSummary::new(series, solution),
        solver: solution.report.clone(),
        energy: (&energy).into(),
        closure: *factors.exchange().closure(),
        photometry,
        undershoot: Undershoot::of(problem.operator().mass(), &solution.radiance),
        error,
        error_of_all: bars.budget,
        errors: bars.groups,
        steps,
        warnings: scene.warnings().to_vec(),
        verdict,
    };
    outcome.into_iter().try_for_each(|line| terminal.say(line))?;
    job.conclude(outputs, &summary, terminal)
}

/// The scene without what is switched off, and the plan for it.
fn load(args: &Args, terminal: &Terminal) -> Result<(Scene, Plan), Failure> {
    terminal.progress().at("load", 0.0)?;
    let (scene, plan) = args.factors.settle(args.scene.load()?, terminal)?;
    args.picture.refuse_to_leave_out(&scene, &args.factors)?;
    args.picture.warn_of_light_paths(&scene, terminal);
    if args.lamp_groups && scene.is_without(Feature::Interreflection) {
        return Err("--lamp-groups needs interreflection; leave one of the two out".into());
    }
    Ok((scene, plan))
}

/// What is solved, and how that was asked for.
struct Job<'a> {
    args: &'a Args,
    tracer: &'a Tracer<'a>,
    patches: &'a Patches<'a>,
    problem: &'a Problem,
}

/// The answers of both solvers.
struct Solved {
    solution: Solution,
    series: Series,
    /// For each group of lamps by itself, means over patches; none where they are not asked for.
    lamps: Vec<(String, Solution)>,
}

/// The picture, and illuminance as another.
struct Pictures {
    picture: Picture,
    illuminance: Option<Picture>,
}

impl Job<'_> {
    fn scene(&self) -> &Scene {
        self.tracer.scene()
    }

    /// Where the power goes, the error that speaks for the answer, and whether it can be relied on.
    fn judge(&self, solution: &Solution, bars: &ErrorBars) -> (Energy, GroupError, Verdict) {
        let energy = Energy::of(self.problem, &solution.radiance);
        let error = bars.headline(|budget| budget.upper95);
        let verdict = Verdict::of(&Answer {
            tracer: self.tracer,
            patches: self.patches,
            problem: self.problem,
            solution,
            energy: &energy,
            budget: Some(&bars.budget),
            tolerance: self.args.solver.tolerance,
        });
        let verdict = verdict.with_error(&error);
        (energy, error, verdict)
    }

    /// Writes `receivers.csv` where there are any; their photometry.
    fn write_receivers(
        &self,
        outputs: &mut Outputs,
        received: &[Received],
        bars: &ErrorBars,
    ) -> Result<Vec<Photometry>, Failure> {
        let efficacy = self.scene().efficacy();
        let received: Vec<_> = received.iter().zip(&bars.receivers).collect();
        if !received.is_empty() {
            outputs.file("receivers.csv", |file| output::write_receivers(file, &received, efficacy))?;
        }
        let photometry =
            received.iter().map(|(received, bars)| Photometry::of_receiver(received, bars, efficacy));
        Ok(photometry.collect())
    }

    /// Solves for all lamps together and for each group of lamps by itself, and sums the series.
    fn solve(&self, progress: Progress) -> Result<Solved, Failure> {
        let &Self { args, problem, .. } = self;
        let groups = if args.lamp_groups { self.lamp_groups() } else { Vec::new() };
        progress.at("solve", 0.0)?;
        let amplification = Some(&Amplification::new(problem.operator(), Default::default())?);
        let options = SolveOptions { amplification, ..args.solver.options(&args.run, progress) };
        // One factorization serves them all.
        let all: Vec<&Sources> =
            iter::once(problem.sources()).chain(groups.iter().map(|(_, sources)| sources)).collect();
        let mut solutions = problem.solve_each(&all, &options)?;
        let of_groups = solutions.split_off(1);
        progress.at("series", 0.0)?;
        let (order, tolerance) = (args.solver.order, args.solver.tolerance);
        let series = problem.neumann(&NeumannOptions { order, tolerance, amplification, progress })?;
        let names = groups.into_iter().map(|(name, _)| name);
        let lamps = names.zip(of_groups.iter().map(Solution::means)).collect();
        Ok(Solved { solution: solutions.remove(0), series, lamps })
    }

    /// The lamps of each material by name, and all lights without area.
    fn lamp_groups(&self) -> Vec<(String, Sources)> {
        let (basis, sources) = (self.problem.basis(), self.problem.sources());
        let groups = self.patches.lamp_groups().into_iter();
        let mut groups: Vec<(String, Sources)> =
            groups.map(|group| (group.material, basis.coefficients_of(&group.emitted).into())).collect();
        if sources.direct.is_some() {
            groups.push((LIGHTS.to_owned(), sources.without_emission()));
        }
        groups
    }

    /// What receivers measure, as well as was asked for.
    fn receive(&self, solution: &Solution, light: &LightOptions) -> Result<Vec<Received<'_>>, Failure> {
        // Without interreflection receivers see lamps alone.
        let direct_only = self.scene().is_without(Feature::Interreflection);
        let seen = if direct_only { &self.problem.sources().emitted } else { &solution.radiance };
        let tolerated = self.args.goal.tolerated(self.scene());
        Ok(measure::receive(self.tracer, self.patches, seen, light, tolerated)?)
    }

    fn draw(&self, solution: &Solution, look: &RenderOptions) -> Result<Pictures, Failure> {
        let &Self { tracer, patches, .. } = self;
        let camera = picture::camera(tracer, patches);
        let look = RenderOptions { carried: self.problem.carried(), ..*look };
        let picture = render::picture(tracer, patches, &solution.radiance, &camera, &look)?;
        // Illuminance is shown from patches and corners, however light is.
        let shading = if look.shading == Shading::Flat { Shading::Flat } else { Shading::Smooth };
        let look = RenderOptions { shading, surfaces: Surfaces::Averaged, ..look };
        let illuminance = self.args.photometric.then(|| {
            let lux = output::luminous(&solution.irradiance, self.scene().efficacy());
            render::picture(tracer, patches, &lux, &camera, &look)
        });
        Ok(Pictures { picture, illuminance: illuminance.transpose()? })
    }

    fn write_tables(
        &self,
        outputs: &mut Outputs,
        Solution { irradiance, radiance, .. }: &Solution,
        bars: &ErrorBars,
    ) -> Result<(), Failure> {
        let patches = self.patches;
        outputs.file("faces.csv", |file| output::write_faces(file, patches, irradiance, radiance, bars))?;
        outputs
            .file("patches.csv", |file| output::write_patches(file, patches, irradiance, radiance, bars))?;
        Ok(())
    }

    /// Where it is asked for, writes all in lumens; answers the rows for the summary.
    fn write_photometry(
        &self,
        outputs: &mut Outputs,
        (Solution { irradiance, radiance, .. }, bars): (&Solution, &ErrorBars),
        of_receivers: Vec<Photometry>,
    ) -> Result<Vec<Photometry>, Failure> {
        if !self.args.photometric {
            return Ok(of_receivers);
        }
        let patches = self.patches;
        let mut rows = Photometry::of_surfaces(patches, irradiance, radiance, bars);
        rows.extend(Photometry::of_lights(self.scene()));
        rows.extend(of_receivers);
        outputs.file("photometry.csv", |file| output::write_photometry(file, &rows))?;
        outputs.file("faces_photometric.csv", |file| {
            output::write_luminous_faces(file, patches, irradiance, radiance)
        })?;
        outputs.file("patches_photometric.csv", |file| {
            output::write_luminous_patches(file, patches, irradiance, radiance)
        })?;
        Ok(rows)
    }

    fn write_lamps(&self, outputs: &mut Outputs, lamps: &[(String, Solution)]) -> Result<(), Failure> {
        if self.args.lamp_groups {
            let lamps: Vec<_> = lamps.iter().map(|(name, solution)| (name.as_str(), solution)).collect();
            outputs.file("lamp_groups.csv", |file| output::write_lamp_groups(file, self.patches, &lamps))?;
        }
        Ok(())
    }

    fn write_false_colours(&self, outputs: &mut Outputs, pictures: &Pictures) -> Result<(), Failure> {
        let Pictures { picture, illuminance } = pictures;
        if let Some(illuminance) = illuminance {
            let efficacy = self.scene().efficacy();
            outputs.file("luminance.png", |file| {
                output::write_false_colours(file, picture, Quantity::Luminance, efficacy)
            })?;
            outputs.file("illuminance.png", |file| {
                output::write_false_colours(file, illuminance, Quantity::Illuminance, 1.0)
            })?;
        }
        Ok(())
    }

    /// Puts the files in their place and says how good the answer is.
    fn conclude(&self, mut outputs: Outputs, summary: &Summary, terminal: &Terminal) -> Result<(), Failure> {
        outputs.file("solution.json", |file| output::write_summary(file, summary))?;
        let scene = self.scene();
        let files = outputs.commit()?;
        if self.args.run.json {
            terminal.print(serde_json::to_string_pretty(summary)?)?;
        }
        terminal.say(solve_report::text(summary, scene, self.problem.factors()))?;
        let folder = self.args.scene.folder(scene);
        terminal.say(format_args!("\nwrote {} to {}", files.join(", "), folder.display()))?;
        verdict::warn(&summary.verdict, terminal);
        self.args.strict.conclude(&summary.verdict)
    }
}
