//! The command-line program: translates arguments, calls the library, prints.

mod accuracy;
mod args;
mod check;
mod compare;
mod factors;
mod form_factors;
mod materials;
mod picture;
mod plan;
mod render;
mod solve;
mod solve_report;
mod study;
mod terminal;
mod values;
mod verdict;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use terminal::Terminal;

/// Diffuse global illumination as a matrix problem: L = (I − K)⁻¹E, directly and as the Neumann series
/// E + KE + K²E + …
///
/// Reads Wavefront OBJ/MTL scenes (Kd: reflectance, Ke: emitted radiance of the front side, metres), cuts
/// surfaces into patches, traces form factors between them and solves for the light on every patch.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true, subcommand_required = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Solve a scene: tables, a coloured mesh and a picture
    ///
    /// Writes solution.json (what was done, energy, residuals and bounds), faces.csv and patches.csv
    /// (irradiance in W/m², radiance in W/sr/m²), mesh.ply and image.png; all of them, or none. Receivers of
    /// the scene's .toml add receivers.csv, --photometric adds photometry.csv, faces_photometric.csv,
    /// patches_photometric.csv, illuminance.png and luminance.png.
    Solve(solve::Args),
    /// Make a picture of a scene
    ///
    /// Solves it as solve does, and writes image.png only.
    Render(render::Args),
    Compare(compare::Args),
    Plan(plan::Args),
    Study(study::Args),
    FormFactors(form_factors::Args),
    /// Look for what is wrong with a mesh: leaks, slivers, winding, lamps, closure, conditioning
    #[command(mut_arg("patches", check::fewer), mut_arg("rays", check::usual))]
    Check(check::Args),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let run = match &cli.command {
        Command::Solve(args) => &args.run,
        Command::Render(args) => &args.run,
        Command::Compare(args) => &args.run,
        Command::Plan(args) => &args.run,
        Command::Study(args) => &args.run,
        Command::FormFactors(args) => &args.run,
        Command::Check(args) => &args.run,
    };
    let terminal = Terminal::new(run.quiet, run.json);
    let done = run.set_up(&terminal).and_then(|()| match &cli.command {
        Command::Solve(args) => solve::run(args, &terminal),
        Command::Render(args) => render::run(args, &terminal),
        Command::Compare(args) => compare::run(args, &terminal),
        Command::Plan(args) => plan::run(args, &terminal),
        Command::Study(args) => study::run(args, &terminal),
        Command::FormFactors(args) => form_factors::run(args, &terminal),
        Command::Check(args) => check::run(args, &terminal),
    });
    terminal.clear();
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<check::Unhealthy>() => ExitCode::FAILURE,
        Err(error) => {
            if let Some(status) = terminal.stopped() {
                let said = error.to_string();
                let nothing = "stopped; nothing was written, and results of earlier runs are as they were";
                terminal.complain(if said.starts_with("stopped") { &said } else { nothing });
                return ExitCode::from(status);
            }
            terminal.complain(format_args!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}
