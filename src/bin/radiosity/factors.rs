//! Where form factors come from: traced now, or from a file.

use std::path::PathBuf;

use radiosity::output;
use radiosity::patches::{Patches, Tessellation};
use radiosity::progress::Progress;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, TraceOptions};

use crate::args::{AccuracyArgs, BasisArg, RunArgs};
use crate::terminal::{Failure, Terminal};

/// How to get form factors.
#[derive(Debug, clap::Args)]
pub struct FactorsArgs {
    #[command(flatten)]
    accuracy: AccuracyArgs,

    /// How light varies over a patch
    #[arg(long, value_enum, default_value_t = BasisArg::Constant, help_heading = "Accuracy")]
    basis: BasisArg,

    /// Write the form factors to a file, for --factors
    #[arg(long, value_name = "FILE", help_heading = "Accuracy")]
    save_factors: Option<PathBuf>,

    /// Take form factors from a file that --save-factors wrote for the same geometry; lamps, powers and reflectances may
    /// have changed
    #[arg(
        long,
        value_name = "FILE",
        help_heading = "Accuracy",
        conflicts_with_all = ["patches", "edge", "rays", "storage", "basis"]
    )]
    factors: Option<PathBuf>,
}

impl FactorsArgs {
    /// How to cut and trace.
    pub fn options<'a>(&self, run: &RunArgs, progress: Progress<'a>) -> (Tessellation<'a>, TraceOptions<'a>) {
        let trace = TraceOptions { basis: self.basis.basis(), ..self.accuracy.trace(run, progress) };
        (self.accuracy.tessellation(run, progress), trace)
    }

    /// How to look for lights without area.
    pub fn light<'a>(&self, run: &RunArgs, progress: Progress<'a>) -> LightOptions<'a> {
        self.accuracy.light(run, progress)
    }

    /// Cuts the scene and finds the form factors between its patches, with or without their rays.
    pub fn obtain<'s>(
        &self,
        tracer: &Tracer<'s>,
        run: &RunArgs,
        keep: Keep,
        terminal: &Terminal,
    ) -> Result<(Patches<'s>, FormFactors), Failure> {
        let progress = terminal.progress();
        let keep = if self.save_factors.is_some() { Keep::Rays } else { keep };
        let (tessellation, trace) = self.options(run, progress);
        let trace = TraceOptions { keep, ..trace };
        let (patches, factors) = match &self.factors {
            Some(path) => {
                let refused = |e: &dyn std::fmt::Display| format!("cannot use {}: {e}", path.display());
                let mut file = std::fs::File::open(path).map_err(|e| refused(&e))?;
                let loaded = FormFactors::load(&mut file, tracer, &tessellation, trace.storage, keep);
                let (patches, factors, reuse) = loaded.map_err(|e| refused(&e))?;
                let balanced = if reuse.balanced { "" } else { ", balanced anew" };
                terminal.say(format_args!(
                    "form factors of {}: {} rows, {} traced now{balanced}",
                    path.display(),
                    reuse.held,
                    reuse.traced
                ))?;
                (patches, factors)
            }
            None => {
                trace.check(self.accuracy.wanted_patches())?;
                let mut patches = Patches::new(tracer, &tessellation)?;
                let factors = FormFactors::trace(tracer, &mut patches, &trace)?;
                (patches, factors)
            }
        };
        terminal.takes(factors.bytes());
        if let Some(path) = &self.save_factors {
            progress.at("write", 0.0)?;
            output::replace(path, |file| factors.save(&patches, file))?;
        }
        Ok((patches, factors))
    }
}
