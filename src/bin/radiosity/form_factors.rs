//! `radiosity form-factors`: form factors between faces, materials, objects or patches.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use clap::builder::TypedValueParser;
use radiosity::measure::{FrontDoubt, front_doubts};
use radiosity::output::{self, FactorEntry, FactorFormat, FactorTable, OutputError};
use radiosity::parallel;
use radiosity::patches::{GroupBy, Groups, Patches, Reach, Tessellation};
use radiosity::scene::{Scene, Side};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, Occlusion, TraceOptions};

use crate::args::{AccuracyArgs, RunArgs, SceneArgs};
use crate::terminal::{Failure, Terminal, first_few};

/// Form factors between faces, materials, objects or patches; needs no light
///
/// F_ab is the fraction of what one side of a sends out, over its whole area, that lands on one side of b.
/// Every side takes part, lit or not, that may see anything; light that lands on the back of b counts to `b
/// (back)`. With what escapes a row sums to 1; what mirrors, metals and glass absorb, and what rays that
/// could not be balanced lack, is missing from it.
///
/// A pair that no ray met has the form factor 0, and in upper95 what it may be at most (95 %): about 3 by the
/// number of rays. Only where upper95 is 0 too can the two provably not face each other.
///
/// The end of FILE says how they are written. .csv:
/// from,to,form_factor,standard_error,from_area,escape,escape_error,upper95 (by face also from_side and
/// to_side); by object and material every pair has a row, by face (of more than 64 sides) and patch those
/// that exchange anything. .mtx: a Matrix Market matrix whose comments name rows and columns. .npz: the NumPy
/// arrays names, area (m²), form_factor, standard_error, upper95, escape and escape_standard_error; by patch
/// no errors, but centre, reflectance and emission.
#[derive(Debug, clap::Args)]
#[command(mut_arg("out", out_file))]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,

    /// What to take together [default: object if there are several, else material, else face]
    #[arg(long, value_enum)]
    by: Option<ByArg>,

    /// Which sides form factors are from [default: by face and patch both; by object and material the front,
    /// and of objects whose faces are wound inconsistently, or whose fronts see nothing, both, with a
    /// warning]
    #[arg(long, value_enum)]
    sides: Option<SidesArg>,

    /// Which channel's form factors to write where mirrors, metals or glass are coloured: 1 for red, 2 for
    /// green, 3 for blue
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..))]
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

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum SidesArg {
    /// Counter-clockwise
    Front,
    Back,
    /// Each by itself: rows `sphere` and `sphere (back)`; backs that see nothing have none
    Both,
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

    /// Which sides become patches, and per object whether form factors are from its front and its back; says
    /// so if that is not clear.
    fn sides(&self, tracer: &Tracer, by: GroupBy, terminal: &Terminal) -> (Reach, Vec<[bool; 2]>) {
        let objects = tracer.scene().objects();
        let all = |sides: [bool; 2]| vec![sides; objects.len()];
        match (self.sides, by) {
            (Some(SidesArg::Front), _) => (Reach::OneSide(Side::Front), all([true, false])),
            (Some(SidesArg::Back), _) => (Reach::OneSide(Side::Back), all([false, true])),
            (Some(SidesArg::Both), _) | (None, GroupBy::Face | GroupBy::Patch) => {
                (Reach::Everything, all([true, true]))
            }
            (None, GroupBy::Material | GroupBy::Object) => {
                let doubts = front_doubts(tracer);
                warn_of_doubts(objects, &doubts, terminal);
                let is_clear = doubts.iter().all(Option::is_none);
                let reach = if is_clear { Reach::OneSide(Side::Front) } else { Reach::Everything };
                (reach, doubts.iter().map(|doubt| [true, doubt.is_some()]).collect())
            }
        }
    }

    /// The file for the results, if it can be written.
    fn file(&self, scene: &Scene) -> Result<PathBuf, Failure> {
        let usual = || Path::new("out").join(scene.name()).join("form_factors.csv");
        let file = self.scene.out.clone().unwrap_or_else(usual);
        output::spare(&file, scene.inputs())?;
        output::check_file(&file)?;
        Ok(file)
    }
}

/// Makes the folder of a file if it is not there.
fn make_folder_of(file: &Path) -> Result<(), OutputError> {
    let Some(folder) = file.parent() else { return Ok(()) };
    std::fs::create_dir_all(folder).map_err(|source| OutputError::Folder { path: folder.to_owned(), source })
}

/// Says so where rows could not be balanced: they lack something then, and are written as they are.
fn warn_of_missing(factors: &FormFactors, terminal: &Terminal) {
    /// What may be missing without a word.
    const ROUNDING: f64 = 1e-9;
    let worst = factors.exchanges().iter().map(|exchange| exchange.closure().after).fold(0.0, f64::max);
    if worst > ROUNDING {
        terminal.warn(format_args!(
            "form factors do not close: up to {worst:.0e} of what a patch sends out is missing from its row; trace \
             more rays (--rays)"
        ));
    }
}

/// Names objects whose front may not be the side that is meant.
fn warn_of_doubts(objects: &[String], doubts: &[Option<FrontDoubt>], terminal: &Terminal) {
    /// Objects that are named.
    const NAMED: usize = 5;
    let reasons = [
        (FrontDoubt::Mixed, "faces that share an edge are wound against each other; make normals consistent"),
        (FrontDoubt::Blind, "fronts see nothing, backs do; turn their faces if that is not meant"),
    ];
    for (reason, words) in reasons {
        let doubtful = objects.iter().zip(doubts).filter(|(_, doubt)| **doubt == Some(reason));
        let names: Vec<&str> = doubtful.map(|(name, _)| name.as_str()).collect();
        if !names.is_empty() {
            let named = first_few(&names, NAMED);
            terminal.warn(format_args!(
                "form factors are from both sides of {named}: {words}, or choose --sides"
            ));
        }
    }
}

pub fn run(args: &Args, terminal: &Terminal) -> Result<(), Failure> {
    let progress = terminal.progress();
    progress.at("load", 0.0)?;
    let scene = args.scene.read()?;
    terminal.warn_of(&scene);
    let file = args.file(&scene)?;
    progress.at("build", 0.0)?;
    let tracer = Tracer::new(&scene);
    let by = args.group_by(&scene);
    let (reach, from) = args.sides(&tracer, by, terminal);
    let options = Tessellation { reach, ..args.accuracy.tessellation(&args.run, progress) };
    let mut patches = Patches::new(&tracer, &options)?;

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
        warn_of_missing(factors, terminal);
    } else {
        terminal.warn("no face sees another: everything escapes");
    }
    let channel = args.channel(&scene, factors.as_ref(), terminal)?;
    let sends =
        |face: usize, side: Side| from[scene.faces()[face].object as usize][usize::from(side == Side::Back)];
    let groups = Groups::new(&patches, by, sends);
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
        _ => {
            let rays = factors.as_ref().map_or(0, FormFactors::rays);
            FactorTable::between_groups(&patches, &groups, &between, rays)
        }
    };
    progress.at("write", 0.0)?;
    make_folder_of(&file)?;
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
            let (group, escape) = (&groups.all()[a], table.escape(a));
            serde_json::json!({
                "name": group.name, "area": group.area, "side": group.side.name(),
                "escape": escape.form_factor, "escape_standard_error": escape.standard_error,
                "escape_upper95": escape.upper95,
            })
        };
        let summary = serde_json::json!({
            "scene": scene.name(),
            "version": env!("CARGO_PKG_VERSION"),
            "seed": args.run.seed,
            "threads": parallel::threads(),
            "patches": table.patches().len(),
            "rays": rays,
            "by": groups.by().name(),
            "groups": table.senders().map(group).collect::<Vec<_>>(),
            "closure": closure,
            "file": file,
            "stages": stages,
            "warnings": scene.warnings(),
        });
        terminal.print(serde_json::to_string_pretty(&summary)?)?;
    }
    terminal.say(format_args!(
        "{}: {} patches, {rays} rays a patch, form factors from {} to {} {}",
        scene.name(),
        table.patches().len(),
        table.senders().count(),
        table.receivers().count(),
        match groups.by() {
            GroupBy::Patch => "patches",
            GroupBy::Face => "sides of faces",
            GroupBy::Material => "sides of materials",
            GroupBy::Object => "sides of objects",
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
    let (senders, receivers): (Vec<usize>, Vec<usize>) =
        (table.senders().collect(), table.receivers().collect());
    if senders.is_empty() || receivers.len() > MOST_GROUPS {
        return None;
    }
    let name = |group: &usize| groups[*group].name.clone();
    let [names, mut columns] =
        [&senders, &receivers].map(|some| some.iter().map(name).collect::<Vec<String>>());
    let row = |&a: &usize| {
        let all = table.full_row(a);
        receivers.iter().map(|&b| all[b]).collect::<Vec<FactorEntry>>()
    };
    let mut rows: Vec<Vec<FactorEntry>> = senders.iter().map(row).collect();
    if senders.iter().any(|&a| table.escape(a).form_factor > 0.0) {
        columns.push("(escape)".into());
        rows.iter_mut().zip(&senders).for_each(|(row, &a)| row.push(table.escape(a)));
    }
    let with_error = |entry: FactorEntry| match entry.standard_error {
        Some(error) if entry.form_factor > 0.0 => format!("{}±{}", digits(entry.form_factor), digits(error)),
        _ => plain(entry),
    };
    let headed = (names.as_slice(), columns.as_slice());
    lay_out(headed, &rows, with_error).or_else(|| lay_out(headed, &rows, plain))
}

/// A form factor alone; what it is less than where no ray told of it, and a dot for none.
fn plain(FactorEntry { form_factor, upper95, .. }: FactorEntry) -> String {
    match upper95 {
        _ if form_factor > 0.0 => digits(form_factor),
        Some(bound) if bound > 0.0 => format!("<{}", digits(bound)),
        _ => "·".into(),
    }
}

/// Four digits, or for what would not show in them, one.
fn digits(x: f64) -> String {
    if x == 0.0 || x >= 5e-5 { format!("{x:.4}") } else { format!("{x:.0e}") }
}

/// Lines of cells under their columns' names, if they are not too wide.
fn lay_out(
    (names, columns): (&[String], &[String]),
    rows: &[Vec<FactorEntry>],
    show: impl Fn(FactorEntry) -> String,
) -> Option<String> {
    let cells: Vec<Vec<String>> =
        rows.iter().map(|row| row.iter().map(|&cell| show(cell)).collect()).collect();
    let letters = |text: &String| text.chars().count();
    let first = names.iter().map(letters).max()?.max("from".len());
    let widths: Vec<usize> = (0..columns.len())
        .map(|b| cells.iter().map(|row| letters(&row[b])).max().unwrap_or(0).max(letters(&columns[b])))
        .collect();
    if 2 + first + widths.iter().map(|width| width + 2).sum::<usize>() > WIDTH {
        return None;
    }
    let line = |name: &str, cells: &[String]| {
        let padded = cells.iter().zip(&widths).map(|(cell, &width)| format!("  {cell:>width$}"));
        format!("  {name:first$}{}\n", padded.collect::<String>())
    };
    let body = names.iter().zip(&cells).map(|(name, cells)| line(name, cells));
    Some(std::iter::once(line("from", columns)).chain(body).collect())
}
