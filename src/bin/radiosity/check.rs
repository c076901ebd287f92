//! `radiosity check`: the health of a mesh and of its operator.

use std::path::PathBuf;

use radiosity::measure::{Finding, Grade, mesh_health, operator_health};
use radiosity::patches::{Patches, Reach, Tessellation};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions};

use crate::args::{self, AccuracyArgs, RunArgs};
use crate::terminal::{Failure, Terminal};

/// The most rays a patch where none are asked for.
const RAYS: u32 = 128;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// OBJ file, or - for standard input; a .toml beside it may set camera, unit and materials [default: the
    /// built-in Cornell box]
    scene: Option<PathBuf>,

    /// Also read libraries, pictures and photometric files that lie outside of the scene's folder
    #[arg(long)]
    allow_outside: bool,

    #[command(flatten)]
    accuracy: AccuracyArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

/// Something is bad. Its findings are the message.
#[derive(Debug)]
pub struct Unhealthy;

impl std::fmt::Display for Unhealthy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the check found something bad")
    }
}

impl std::error::Error for Unhealthy {}

/// Fewer patches than where light is solved for.
pub fn fewer(patches: clap::Arg) -> clap::Arg {
    patches.default_value("2000")
}

/// Fewer rays than where light is solved for.
pub fn usual(rays: clap::Arg) -> clap::Arg {
    rays.help("Rays per patch [default: 128; from 65536 patches on 64]")
}

pub fn run(args: &Args, terminal: &Terminal) -> Result<(), Failure> {
    let progress = terminal.progress();
    progress.at("load", 0.0)?;
    let scene = args::load(args.scene.as_deref(), args.allow_outside)?;
    let reach = if scene.require_light().is_ok() { Reach::Light } else { Reach::Everything };
    progress.at("build", 0.0)?;
    let tracer = Tracer::new(&scene);
    let cut = Tessellation { reach, ..args.accuracy.tessellation(&args.run, progress) };
    let mut patches = Patches::new(&tracer, &cut)?;
    progress.at("check", 0.0)?;
    let mut findings = mesh_health(&tracer, &patches, args.run.seed);
    if !patches.is_empty() {
        let trace = args.accuracy.trace(&args.run, progress);
        let rays = trace.rays.unwrap_or(TraceOptions::usual_rays(patches.len()).min(RAYS));
        let trace = TraceOptions { rays: Some(rays), ..trace };
        let factors = FormFactors::trace(&tracer, &mut patches, &trace)?;
        progress.at("check", 0.5)?;
        findings.extend(operator_health(&factors, &patches, progress)?);
    }
    terminal.clear();
    let verdict = findings.iter().map(|finding| finding.verdict).max().unwrap_or(Grade::Good);
    if args.run.json {
        let all = serde_json::json!({ "scene": scene.name(), "verdict": verdict, "findings": findings });
        terminal.print(serde_json::to_string_pretty(&all)?)?;
    }
    let sides = if reach == Reach::Light { "where light reaches" } else { "on all sides" };
    let (faces, patches) = (scene.faces().len(), patches.len());
    let face_noun = if faces == 1 { "face" } else { "faces" };
    terminal.say(format_args!("{}: {faces} {face_noun}, {patches} patches {sides}\n", scene.name()))?;
    findings.iter().try_for_each(|finding| tell(finding, terminal))?;
    let worst: Vec<&str> =
        findings.iter().filter(|f| f.verdict == verdict && verdict != Grade::Good).map(|f| f.name).collect();
    let colon = if worst.is_empty() { "" } else { ": " };
    terminal.say(format_args!("\n{}{colon}{}", verdict.name(), worst.join(", ")))?;
    if verdict == Grade::Bad { Err(Unhealthy.into()) } else { Ok(()) }
}

/// Where values begin.
const INDENT: usize = 30;

/// Where lines end.
const WIDTH: usize = 110;

/// A line for the value, and below it what to do and where.
fn tell(finding: &Finding, terminal: &Terminal) -> Result<(), Failure> {
    let Finding { name, verdict, .. } = finding;
    let value = value(finding);
    terminal.say(format_args!("  {name:<20}  {:<4}  {value}", verdict.name()))?;
    let mut told = finding.remedy.clone().unwrap_or_default();
    if !finding.faces.is_empty() {
        let numbers: Vec<String> = finding.faces.iter().map(usize::to_string).collect();
        let and_more = if numbers.len() == Finding::MOST_FACES { ", …" } else { "" };
        let noun = if numbers.len() == 1 { "face" } else { "faces" };
        told += &format!(" ({noun} {}{and_more})", numbers.join(", "));
    }
    let mut line = String::new();
    for word in told.split_whitespace() {
        if INDENT + line.chars().count() + word.chars().count() >= WIDTH {
            terminal.say(format_args!("{:INDENT$}{}", "", line.trim_end()))?;
            line.clear();
        }
        line += word;
        line.push(' ');
    }
    if !line.is_empty() {
        terminal.say(format_args!("{:INDENT$}{}", "", line.trim_end()))?;
    }
    Ok(())
}

/// The measured value, as `3 edges` or `2.1 % of light escapes`.
fn value(finding: &Finding) -> String {
    let (value, unit) = (finding.value, finding.unit.unwrap_or_default());
    let number = match value {
        x if x.is_nan() => "not measured".to_owned(),
        x if !x.is_finite() => "unbounded".to_owned(),
        x if unit.starts_with("of ") => format!("{} %", short(100.0 * x)),
        x => short(x),
    };
    let text = match unit {
        "" => number,
        "at most" => format!("{unit} {number}"),
        _ if number == "1" => format!("1 {}", singular(unit)),
        _ => format!("{number} {unit}"),
    };
    match finding.count {
        Some(count) => format!("{text}, {count} in all"),
        None => text,
    }
}

/// The unit of one.
fn singular(unit: &str) -> String {
    match unit.split_once(' ') {
        Some(("faces", rest)) => format!("face {rest}"),
        _ if unit == "vertices" => "vertex".into(),
        _ => unit.strip_suffix('s').unwrap_or(unit).into(),
    }
}

/// Whole numbers as they are, others with three significant digits.
fn short(x: f64) -> String {
    let magnitude = if x == 0.0 { 0 } else { x.abs().log10().floor() as i32 };
    match magnitude {
        0.. if x.fract() == 0.0 && magnitude < 9 => format!("{x:.0}"),
        -3..=4 => format!("{x:.*}", (2 - magnitude).max(0) as usize),
        _ => format!("{x:.1e}"),
    }
}
