//! `radiosity form-factors`: form factors between faces, materials, objects or patches.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use clap::builder::TypedValueParser;
use radiosity::output::{self, FactorFormat, FactorTable};
use radiosity::patches::{GroupBy, Groups, Patches, Reach, Tessellation};
use radiosity::scene::Scene;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, Occlusion, TraceOptions};

use crate::args::{AccuracyArgs, RunArgs, SceneArgs};
use crate::terminal::{Failure, Terminal};

/// Form factors between faces, materials, objects or patches; needs no light
///
/// Every side of a face that sees another takes part, lit or not. F_ab is the fraction of what a sends out that lands on b; what
/// escapes is what a row lacks to 1.
///
/// The end of FILE says how they are written. .csv: from,to,form_factor,standard_error (by face also from_side and to_side);
/// by object and material every pair has a row, by face and patch those that exchange anything. .mtx: a Matrix Market matrix whose
/// comments name rows and columns. .npz: the NumPy arrays names, area (m²), form_factor, standard_error, escape and
/// escape_standard_error; by patch no standard errors, but centre, reflectance and emission.
#[derive(Debug, clap::Args)]
#[command(mut_arg("out", out_file))]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,

    /// What to take together [default: object if there are several, else material, else face]
    #[arg(long, value_enum)]
    by: Option<ByArg>,

    /// Which channel's form factors to write where mirrors, metals or glass are coloured: 1 for red, 2 for green, 3 for blue
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..))]
    channel: Option<u16>,

    #[command(flatten)]
    accuracy: AccuracyArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ByArg {
    /// Sides of faces
    Face,
    Material,
    Object,
    /// Nothing: the factors that the operator K is made of, without standard errors
    Patch,
}

/// The argument for the folder of other commands, for a file.
fn out_file(arg: clap::Arg) -> clap::Arg {
    let parser = clap::builder::PathBufValueParser::new()
        .try_map(|path: PathBuf| FactorFormat::of(&path).map(|_| path));
    arg.value_name("FILE")
        .help("File for the results: .csv, .mtx or .npz [default: out/<scene>/form_factors.csv]")
        .value_parser(parser)
}

impl Args {
    fn group_by(&self, scene: &Scene) -> GroupBy {
        match self.by {
            None => GroupBy::usual(scene),
            Some(ByArg::Face) => GroupBy::Face,
            Some(ByArg::Material) => GroupBy::Material,
            Some(ByArg::Object) => GroupBy::Object,
            Some(ByArg::Patch) => GroupBy::Patch,
        }
    }

    /// The channel that is written, from 0; says so where others differ.
    fn channel(
        &self,
        scene: &Scene,
        factors: Option<&FormFactors>,
        terminal: &Terminal,
    ) -> Result<usize, Failure> {
        let (asked, channels) = (self.channel.map_or(1, usize::from), scene.channels());
        // Where all channels agree, the one that is kept stands for red, green and blue.
        if asked > channels.max(3) {
            return Err(format!("--channel {asked}: the scene has channels 1 to {}", channels.max(3)).into());
        }
        let differ = factors.is_some_and(|factors| factors.exchanges().len() > 1);
        if differ && self.channel.is_none() {
            terminal.warn(
                "mirrors, metals or glass are coloured: the form factors are those of channel 1, red; --channel 2 or 3 writes others",
            );
        }
        Ok((asked - 1).min(channels - 1))
    }

    /// The file for the results; its folder is made if it is not there.
    fn file(&self, scene: &Scene) -> Result<PathBuf, Failure> {
        let usual = || Path::new("out").join(scene.name()).join("form_factors.csv");
        let file = self.scene.out.clone().unwrap_or_else(usual);
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(|e| {
                format!("cannot make the folder {}: {e}; choose another with --out", folder.display())
            })?;
        }
        Ok(file)
    }
}

pub fn run(args: &Args, terminal: &Terminal) -> Result<(), Failure> {
    let progress = terminal.progress();
    progress.at("load", 0.0)?;
    let scene = args.scene.load()?;
    terminal.warn_of(&scene);
    progress.at("build", 0.0)?;
    let tracer = Tracer::new(&scene);
    let options =
        Tessellation { reach: Reach::Everything, ..args.accuracy.tessellation(&args.run, progress) };
    let mut patches = Patches::new(&tracer, &options)?;

    let by = args.group_by(&scene);
    let keep = if by == GroupBy::Patch { Keep::Nothing } else { Keep::Rays };
    let occlusion = Occlusion::Always;
    let options =
        TraceOptions { lamp_rays: Some(0), keep, occlusion, ..args.accuracy.trace(&args.run, progress) };
    let factors = match patches.is_empty() {
        true => None,
        false => Some(FormFactors::trace(&tracer, &mut patches, &options)?),
    };
    if let Some(factors) = &factors {
        terminal.takes(factors.bytes());
    } else {
        terminal.warn("no face sees another: everything escapes");
    }
    let channel = args.channel(&scene, factors.as_ref(), terminal)?;
    let groups = Groups::new(&patches, by);
    let between = match &factors {
        Some(factors) if by != GroupBy::Patch => {
            factors.between_groups_in(channel, &patches, groups.of_patch(), progress)?
        }
        _ => Vec::new(),
    };
    let table = match &factors {
        Some(factors) if by == GroupBy::Patch => {
            FactorTable::between_patches(&patches, &groups, factors.exchange_of(channel))
        }
        _ => FactorTable::between_groups(&patches, &groups, &between),
    };
    progress.at("write", 0.0)?;
    let file = args.file(&scene)?;
    output::write_form_factors(&file, &table)?;
    report(args, &table, factors.as_ref(), &file, terminal)
}

fn report(
    args: &Args,
    table: &FactorTable,
    factors: Option<&FormFactors>,
    file: &Path,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let (scene, groups, stages) = (table.patches().scene(), table.groups(), terminal.stages());
    let rays = factors.map_or(0, FormFactors::rays);
    let closure = factors.map(|factors| *factors.exchange().closure());
    if args.run.json {
        let group = |a: usize| {
            let (escape, standard_error) = table.escape(a);
            let group = &groups.all()[a];
            serde_json::json!({
                "name": group.name, "area": group.area,
                "escape": escape, "escape_standard_error": standard_error,
            })
        };
        let summary = serde_json::json!({
            "scene": scene.name(),
            "version": env!("CARGO_PKG_VERSION"),
            "seed": args.run.seed,
            "threads": rayon::current_num_threads(),
            "patches": table.patches().len(),
            "rays": rays,
            "by": groups.by().name(),
            "groups": (0..groups.len()).map(group).collect::<Vec<_>>(),
            "closure": closure,
            "file": file,
            "stages": stages,
            "warnings": scene.warnings(),
        });
        terminal.print(serde_json::to_string_pretty(&summary)?)?;
    }
    terminal.say(format_args!(
        "{}: {} patches, {rays} rays a patch, form factors between {} {}",
        scene.name(),
        table.patches().len(),
        groups.len(),
        match groups.by() {
            GroupBy::Patch => "patches",
            GroupBy::Face => "sides of faces",
            GroupBy::Material => "materials",
            GroupBy::Object => "objects",
        }
    ))?;
    if let Some(matrix) = matrix(table) {
        terminal.say(format_args!("\n{matrix}"))?;
    }
    let seconds: f64 = stages.iter().map(|s| s.seconds).sum();
    terminal.say(format_args!("wrote {} in {seconds:.2} s", file.display()))
}

/// Rows and columns of a matrix on the screen.
const MOST_GROUPS: usize = 12;

/// Letters across.
const WIDTH: usize = 100;

/// All form factors side by side, with standard errors if there is room for them; none if there are too many.
fn matrix(table: &FactorTable) -> Option<String> {
    let groups = table.groups().all();
    if groups.is_empty() || groups.len() > MOST_GROUPS {
        return None;
    }
    let mut names: Vec<String> = groups.iter().map(|group| group.name.clone()).collect();
    let mut rows: Vec<Vec<(f64, Option<f64>)>> = (0..groups.len()).map(|a| table.full_row(a)).collect();
    if (0..groups.len()).any(|a| table.escape(a).0 > 0.0) {
        names.push("(escape)".into());
        rows.iter_mut().enumerate().for_each(|(a, row)| row.push(table.escape(a)));
    }
    let with_error = |(value, error): (f64, Option<f64>)| match error {
        Some(error) if value > 0.0 => format!("{}±{}", digits(value), digits(error)),
        _ => plain((value, error)),
    };
    lay_out(&names, &rows, with_error).or_else(|| lay_out(&names, &rows, plain))
}

/// A form factor alone; a dot for none.
fn plain((value, _): (f64, Option<f64>)) -> String {
    if value > 0.0 { digits(value) } else { "·".into() }
}

/// Four digits, or for what would not show in them, one.
fn digits(x: f64) -> String {
    if x == 0.0 || x >= 5e-5 { format!("{x:.4}") } else { format!("{x:.0e}") }
}

/// Lines of cells under their columns' names, if they are not too wide.
fn lay_out(
    names: &[String],
    rows: &[Vec<(f64, Option<f64>)>],
    show: impl Fn((f64, Option<f64>)) -> String,
) -> Option<String> {
    let cells: Vec<Vec<String>> =
        rows.iter().map(|row| row.iter().map(|&cell| show(cell)).collect()).collect();
    let letters = |text: &String| text.chars().count();
    let first = names[..rows.len()].iter().map(letters).max()?.max("from".len());
    let widths: Vec<usize> = (0..names.len())
        .map(|b| cells.iter().map(|row| letters(&row[b])).max().unwrap_or(0).max(letters(&names[b])))
        .collect();
    if 2 + first + widths.iter().map(|width| width + 2).sum::<usize>() > WIDTH {
        return None;
    }
    let line = |name: &str, cells: &[String]| {
        let padded = cells.iter().zip(&widths).map(|(cell, &width)| format!("  {cell:>width$}"));
        format!("  {name:first$}{}\n", padded.collect::<String>())
    };
    let body = names.iter().zip(&cells).map(|(name, cells)| line(name, cells));
    Some(std::iter::once(line("from", names)).chain(body).collect())
}
