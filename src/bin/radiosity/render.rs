//! `radiosity render`: pictures.

use radiosity::measure::{Answer, Energy, Verdict};
use radiosity::render::{self, RenderOptions};
use radiosity::solve::Problem;
use radiosity::trace::Tracer;
use radiosity::transport::Keep;

use crate::args::{RunArgs, SceneArgs, SolverArgs};
use crate::factors::FactorsArgs;
use crate::picture::{self, PictureArgs};
use crate::terminal::{Failure, Terminal};
use crate::verdict::{self, StrictArgs};

#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    factors: FactorsArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    strict: StrictArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

pub fn run(args: &Args, terminal: &Terminal) -> Result<(), Failure> {
    let progress = terminal.progress();
    let look = args.picture.options(&args.run, progress)?;
    progress.at("load", 0.0)?;
    let (scene, _) = args.factors.settle(args.scene.load()?, terminal)?;
    args.picture.refuse_to_leave_out(&scene, &args.factors)?;
    args.picture.warn_of_light_paths(&scene, terminal);
    progress.at("build", 0.0)?;
    let tracer = Tracer::new(&scene);
    let (patches, factors) = args.factors.obtain(&tracer, &args.run, Keep::Nothing, terminal)?;
    let problem = Problem::new(&tracer, &patches, &factors, &args.factors.light(&args.run, progress))?;
    let solution = problem.solve(&args.solver.options(&args.run, progress))?;
    let energy = Energy::of(&problem, &solution.radiance);
    let verdict = Verdict::of(&Answer {
        tracer: &tracer,
        patches: &patches,
        problem: &problem,
        solution: &solution,
        energy: &energy,
        budget: None,
        tolerance: args.solver.tolerance,
    });
    let camera = picture::camera(&tracer, &patches);
    let look = RenderOptions { carried: problem.carried(), ..look };
    let picture = render::picture(&tracer, &patches, &solution.radiance, &camera, &look)?;
    picture::warn_if_black(&picture, solution.irradiance.amax(), terminal);
    progress.at("write", 0.0)?;
    let mut outputs = args.scene.outputs(&scene)?;
    args.picture.write(&picture, &mut outputs)?;
    let files = outputs.commit()?;
    let stages = terminal.stages();
    if args.run.json {
        let summary = serde_json::json!({ "scene": scene.name(), "files": files, "stages": stages, "verdict": verdict });
        terminal.print(serde_json::to_string_pretty(&summary)?)?;
    }
    let seconds: f64 = stages.iter().map(|s| s.seconds).sum();
    let folder = args.scene.folder(&scene);
    terminal.say(format_args!("wrote {} to {} in {seconds:.2} s", files.join(", "), folder.display()))?;
    verdict::warn(&verdict, terminal);
    args.strict.conclude(&verdict)
}
