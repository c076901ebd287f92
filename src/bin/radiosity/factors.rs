//! Where form factors come from: traced now, or from a file.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use radiosity::output::{self, OutputError};
use radiosity::patches::{PatchError, PatchSize, Patches, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Feature, Scene};
use radiosity::trace::Tracer;
use radiosity::transport::{
    self, Forecast, FormFactors, Keep, LightOptions, Plan, Switches, TraceOptions, Work,
};

use crate::args::{AccuracyArgs, BasisArg, RunArgs, SolverArgs};
use crate::terminal::{Failure, Terminal};

/// How to get form factors.
#[derive(Debug, clap::Args)]
pub struct FactorsArgs {
    #[command(flatten)]
    accuracy: AccuracyArgs,

    /// How light varies over a patch
    #[arg(long, value_enum, default_value_t = BasisArg::Constant, help_heading = "Accuracy")]
    basis: BasisArg,

    #[arg(
        long,
        help = effects_help(),
        value_name = "LIST",
        default_value = "auto",
        allow_hyphen_values = true,
        help_heading = "Effects"
    )]
    effects: Switches,

    /// Write the form factors to a file, for --factors
    #[arg(long, value_name = "FILE", help_heading = "Accuracy")]
    save_factors: Option<PathBuf>,

    /// Take form factors from a file that --save-factors wrote for the same geometry; lamps, powers and
    /// reflectances may have changed
    #[arg(
        long,
        value_name = "FILE",
        help_heading = "Accuracy",
        conflicts_with_all = ["patches", "edge", "rays", "storage", "basis"]
    )]
    factors: Option<PathBuf>,
}

/// What --effects does, and all effects that there are.
fn effects_help() -> String {
    format!(
        "Which effects to simulate: auto for all that the scene calls for, or -effect to leave one out and +effect \
         to insist, separated by commas: {}",
        Switches::names()
    )
}

/// Refuses a file that could not be written; its folder must be there.
fn check_save(path: &Path) -> Result<(), OutputError> {
    output::check_file(path)?;
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(OutputError::Write { path: path.to_owned(), source: ErrorKind::NotFound.into() })
        }
        _ => Ok(()),
    }
}

/// Why a file of form factors is refused.
fn cannot_use(path: &Path, why: &dyn std::fmt::Display) -> String {
    format!("cannot use {}: {why}", path.display())
}

/// Numbers of patches and of rays that were chosen on the way to an accuracy, and are not among the options.
pub struct Chosen {
    pub patches: usize,
    pub rays: u32,
}

/// What else solving may be asked for.
pub struct Asked {
    pub pixels: usize,
    pub chosen: Option<Chosen>,
}

impl FactorsArgs {
    /// How to cut and trace.
    pub fn options<'a>(&self, run: &RunArgs, progress: Progress<'a>) -> (Tessellation<'a>, TraceOptions<'a>) {
        let keep = if self.save_factors.is_some() { Keep::Rays } else { Keep::Nothing };
        let trace = TraceOptions { basis: self.basis.basis(), keep, ..self.accuracy.trace(run, progress) };
        (self.accuracy.tessellation(run, progress), self.effects.trace(trace))
    }

    /// How to look for lights without area.
    pub fn light<'a>(&self, run: &RunArgs, progress: Progress<'a>) -> LightOptions<'a> {
        self.effects.light(self.accuracy.light(run, progress))
    }

    /// The scene without what is switched off, and the plan for it; warns of what is lost.
    ///
    /// # Errors
    /// If there is no light left, or form factors in files are asked for that lack something.
    pub fn settle(&self, scene: Scene, terminal: &Terminal) -> Result<(Scene, Plan), Failure> {
        if let Some(path) = &self.save_factors {
            check_save(path)?;
        }
        let applied = self.effects.apply(scene);
        applied.0.require_light()?;
        self.settle_unlit(applied, terminal)
    }

    /// The same of a scene that may be without light, for commands that solve nothing.
    pub fn plan(&self, scene: Scene, terminal: &Terminal) -> Result<(Scene, Plan), Failure> {
        let applied = self.effects.apply(scene);
        if let Err(dark) = applied.0.require_light() {
            terminal.warn(format_args!("{dark}; this is what solving would take once something emits"));
        }
        self.settle_unlit(applied, terminal)
    }

    fn settle_unlit(
        &self,
        (scene, plan, told): (Scene, Plan, Vec<String>),
        terminal: &Terminal,
    ) -> Result<(Scene, Plan), Failure> {
        if let Some(path) = &self.save_factors {
            output::spare(path, scene.inputs())?;
        }
        terminal.warn_of(&scene);
        told.iter().for_each(|line| terminal.warn(line));
        let direct_only = scene.is_without(Feature::Interreflection);
        let from_file = self.factors.is_some() || self.save_factors.is_some();
        if from_file && (direct_only || self.effects.leave_out("caustics") || self.effects.leave_out("lamps"))
        {
            return Err(
                "files of form factors hold all that --effects would leave out; use one or the other".into(),
            );
        }
        Ok((scene, plan))
    }

    /// Refuses to leave out what `who` simulates in any case.
    pub fn refuse_to_leave_out(&self, scene: &Scene, who: &str) -> Result<(), Failure> {
        let kept = [(Feature::Interreflection, "interreflection"), (Feature::BackSides, "back-sides")];
        match kept.into_iter().find(|(feature, _)| scene.is_without(*feature)) {
            Some((_, name)) => Err(format!("{who}: it can't do --effects -{name}").into()),
            None => Ok(()),
        }
    }

    /// What solving with these options will probably cost.
    pub fn forecast(
        &self,
        tracer: &Tracer,
        solver: &SolverArgs,
        asked: Asked,
        run: &RunArgs,
    ) -> Result<Forecast, PatchError> {
        let quietly = Progress::default();
        let (mut tessellation, mut trace) = self.options(run, quietly);
        if let Some(Chosen { patches, rays }) = asked.chosen {
            tessellation.size = PatchSize::Count(patches);
            trace.rays = Some(rays);
        }
        let work = Work {
            tessellation: &tessellation,
            trace: &trace,
            light: &self.light(run, quietly),
            solving: solver.solving(),
            memory: run.memory,
            tolerance: solver.tolerance,
            order: solver.order,
            pixels: asked.pixels,
        };
        Forecast::new(tracer, &work)
    }

    /// Refuses receivers of more points than fit into memory.
    pub fn check_receivers(&self, tracer: &Tracer, run: &RunArgs) -> Result<(), Failure> {
        let scene = tracer.scene();
        if !scene.receivers().is_empty() {
            let patches = self.accuracy.wanted_patches(tracer)?;
            let light = self.light(run, Progress::default());
            transport::check_receivers(scene, patches, light.rays, run.memory)?;
        }
        Ok(())
    }

    /// Refuses more patches and rays than fit, as far as that is known before the scene is cut, or a file of
    /// form factors that cannot be read.
    pub fn check(&self, tracer: &Tracer, run: &RunArgs) -> Result<(), Failure> {
        if let Some(path) = &self.factors {
            File::open(path).map_err(|e| cannot_use(path, &e))?;
            return Ok(());
        }
        let (_, trace) = self.options(run, Progress::default());
        let wanted = self.accuracy.wanted_patches(tracer)?;
        if trace.without_rays(tracer, wanted).is_err() {
            trace.check(wanted)?;
        }
        Ok(())
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
        let (tessellation, trace) = self.options(run, progress);
        let keep = if trace.keep == Keep::Rays { Keep::Rays } else { keep };
        let (patches, factors) = match &self.factors {
            Some(path) => {
                let mut file = File::open(path).map_err(|e| cannot_use(path, &e))?;
                let loaded = FormFactors::load(&mut file, tracer, &tessellation, trace.storage, keep);
                let (patches, factors, reuse) = loaded.map_err(|e| cannot_use(path, &e))?;
                let balanced = if reuse.balanced { "" } else { ", balanced anew" };
                terminal.say(format_args!(
                    "form factors of {}: {} rows, {} traced now{balanced}",
                    path.display(),
                    reuse.held,
                    reuse.traced
                ))?;
                (patches, factors)
            }
            None if !tracer.scene().has_exchange() && self.save_factors.is_none() => {
                let patches = Patches::new(tracer, &tessellation)?;
                let factors = FormFactors::none(&patches, trace.basis);
                (patches, factors)
            }
            None => {
                self.check(tracer, run)?;
                let mut patches = Patches::new(tracer, &tessellation)?;
                // Where no rays are needed there are none to be kept.
                let keep = if trace.without_rays(tracer, patches.len()).is_ok() { trace.keep } else { keep };
                let factors = FormFactors::trace(tracer, &mut patches, &TraceOptions { keep, ..trace })?;
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
