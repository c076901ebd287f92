//! `radiosity study`: what accuracy costs in time.

use std::fs::File;
use std::path::Path;
use std::time::Duration;

use radiosity::measure::{Grid, LeftOut, MeasureError, Study, StudyOptions, Want};
use radiosity::output::{self, StudySummary};
use radiosity::patches::PatchError;
use radiosity::reference::PathError;
use radiosity::solve::SolveError;
use radiosity::trace::Tracer;
use radiosity::transport::TransportError;

use crate::args::{BasisArg, RunArgs, SceneArgs};
use crate::terminal::{Failure, Terminal};
use crate::values;
use crate::verdict::StrictArgs;

/// Show what accuracy costs in time: patches × rays × solver and order against a path-traced reference
///
/// Traces light paths first, to know the truth and its noise, then solves the scene with more and more
/// patches and rays, every solver, and several orders of the series. Writes study.csv (patches, rays, solver,
/// order, seconds, bytes, error, its standard error, …), study_reference.csv, study.svg (error against time),
/// knobs.svg (each knob alone) and study.md (which knob to turn at which accuracy). Tables are kept after
/// every setting: stopped by Ctrl-C, the same command goes on where it was.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,

    /// Time for all of it, as 90s, 5min or 1h; settings that do not fit are left out
    #[arg(
        long,
        value_name = "TIME",
        default_value = "90s",
        allow_hyphen_values = true,
        value_parser = values::duration,
        help_heading = "Study",
    )]
    time: Duration,

    /// Noise of the reference that is small enough, relative
    #[arg(
        long,
        value_name = "SHARE",
        default_value = "0.05%",
        allow_hyphen_values = true,
        value_parser = values::share,
        help_heading = "Study",
    )]
    noise: f64,

    /// Numbers of patches to try, with --rays [default: three or more, chosen for the scene and --time]
    #[arg(
        long,
        value_name = "N,N,…",
        value_delimiter = ',',
        allow_negative_numbers = true,
        value_parser = values::positive,
        requires = "rays",
        help_heading = "Study",
    )]
    patches: Vec<usize>,

    /// Rays per patch to try, with --patches
    #[arg(
        long,
        value_name = "N,N,…",
        value_delimiter = ',',
        allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(8..),
        requires = "patches",
        help_heading = "Study",
    )]
    rays: Vec<u32>,

    /// How light varies over a patch
    #[arg(long, value_enum, default_value_t = BasisArg::Constant, help_heading = "Study")]
    basis: BasisArg,

    #[command(flatten)]
    strict: StrictArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

const TABLE: &str = "study.csv";
const REFERENCE: &str = "study_reference.csv";

pub fn run(args: &Args, terminal: &Terminal) -> Result<(), Failure> {
    let progress = terminal.progress();
    progress.at("load", 0.0)?;
    let scene = args.scene.load()?;
    scene.require_light()?;
    terminal.warn_of(&scene);
    progress.at("build", 0.0)?;
    let tracer = Tracer::new(&scene);
    let options = StudyOptions {
        time: args.time,
        noise: args.noise,
        grid: args.grid(),
        basis: args.basis.basis(),
        seed: args.run.seed,
        memory: args.run.memory,
        progress,
    };
    let mut study = Study::new(&tracer, options)?;
    let folder = args.scene.folder(&scene);
    resume(&mut study, &folder, terminal);
    if study.taken_over() > 0 {
        terminal.say(format_args!(
            "{} rows of {} taken over",
            study.taken_over(),
            folder.join(TABLE).display()
        ))?;
    }
    loop {
        match study.advance() {
            Ok(true) => keep(&study, args)?,
            Ok(false) => break,
            Err(error) if is_stop(&error) && study.reference().is_some() => {
                let rows = study.rows().len();
                return Err(format!(
                    "stopped; the reference and {rows} rows are kept in {}, and the same command goes on from there",
                    folder.display()
                )
                .into());
            }
            Err(error) => return Err(error.into()),
        }
    }
    warn_of_time(&study, args, terminal);

    let Some(summary) = StudySummary::new(&study, terminal.stages()) else {
        return Err("the study has no reference".into());
    };
    progress.at("write", 0.0)?;
    let mut outputs = args.scene.outputs(&scene)?;
    outputs.file("study.svg", |file| output::write_study_plot(file, &summary))?;
    outputs.file("knobs.svg", |file| output::write_knobs_plot(file, &summary))?;
    outputs.file("study.md", |file| output::write_study_report(file, &summary))?;
    outputs.commit()?;
    if args.run.json {
        terminal.print(serde_json::to_string_pretty(&summary)?)?;
    }
    terminal.say(format_args!("wrote to {}", folder.display()))?;
    for (cell, verdict) in study.verdicts() {
        for reason in &verdict.reasons {
            let level = reason.level.name();
            terminal.warn(format_args!(
                "{level} answer with {} patches × {} rays: {reason}",
                cell.patches, cell.rays
            ));
        }
    }
    study.verdicts().iter().try_for_each(|(_, verdict)| args.strict.conclude(verdict))
}

impl Args {
    fn grid(&self) -> Option<Grid> {
        let [mut patches, mut rays] = [self.patches.clone(), self.rays.iter().map(|&n| n as usize).collect()];
        for values in [&mut patches, &mut rays] {
            values.sort();
            values.dedup();
        }
        let rays = rays.into_iter().map(|n| n as u32).collect();
        (!patches.is_empty()).then_some(Grid { patches, rays })
    }
}

/// Takes over what earlier runs have left in the folder.
fn resume(study: &mut Study, folder: &Path, terminal: &Terminal) {
    let open = |name: &str| File::open(folder.join(name)).ok();
    let Some((table, reference)) = open(TABLE).zip(open(REFERENCE)) else { return };
    match output::read_study(study, table, reference) {
        Some((reference, rows)) => study.resume(reference, rows),
        None => terminal.warn(format_args!(
            "{TABLE} and {REFERENCE} in {} are of another study, or damaged: all is measured anew",
            folder.display()
        )),
    }
}

/// Writes down what is known so far.
fn keep(study: &Study, args: &Args) -> Result<(), Failure> {
    let mut outputs = args.scene.outputs(study.scene())?;
    outputs.file(TABLE, |file| output::write_study_table(file, study))?;
    if let Some(reference) = study.reference() {
        outputs.file(REFERENCE, |file| output::write_study_reference(file, study, reference))?;
    }
    outputs.commit()?;
    Ok(())
}

/// Says what did not fit, and what would be needed.
fn warn_of_time(study: &Study, args: &Args, terminal: &Terminal) {
    let late = |left: &&LeftOut| matches!(left.wants, Want::Seconds(_));
    let late = study.left_out().iter().filter(late).count();
    let all = study.grid().cells().len();
    if late > 0 {
        let grid = study.grid();
        let list = |values: Vec<String>| values.join(",");
        terminal.warn(format_args!(
            "{} of {all} pairs of patches and rays fitted into {:.0} s; for all of them: --time {:.0}s --patches {} --rays {}",
            all - study.left_out().len(),
            args.time.as_secs_f64(),
            (1.1 * study.seconds_for_all()).ceil(),
            list(grid.patches.iter().map(usize::to_string).collect()),
            list(grid.rays.iter().map(u32::to_string).collect())
        ));
    }
    for left in study.left_out() {
        if let Want::Memory(message) = &left.wants {
            terminal.warn(format_args!(
                "{} patches × {} rays left out: {message}",
                left.cell.patches, left.cell.rays
            ));
        }
    }
}

/// Whether Ctrl-C is behind an error, wherever it was noticed.
fn is_stop(error: &MeasureError) -> bool {
    matches!(
        error,
        MeasureError::Cancelled(_)
            | MeasureError::Paths(PathError::Cancelled(_))
            | MeasureError::Patches(PatchError::Cancelled(_))
            | MeasureError::Transport(TransportError::Cancelled(_))
            | MeasureError::Solve(SolveError::Cancelled(_))
    )
}
