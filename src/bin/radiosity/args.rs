//! Arguments that several commands share, and what they mean to the library.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use radiosity::output::{self, OutputError, Outputs};
use radiosity::patches::{Basis, Outlook, PatchError, PatchSize, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Loading, Scene, SceneError};
use radiosity::solve::{Method, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{LightOptions, Solving, StorageKind, TraceOptions};

use crate::terminal::{Failure, Terminal};
use crate::values;

/// What to read and where to write.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// OBJ file, or - for standard input; a .toml beside it may set camera, unit, materials, lights and sky
    /// [default: the built-in Cornell box]
    pub scene: Option<PathBuf>,

    /// Also read libraries, pictures and photometric files that lie outside of the scene's folder
    #[arg(long)]
    allow_outside: bool,

    /// Folder for the results [default: out/<scene>]
    #[arg(short, long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

/// All files that commands write into the folder for the results.
const RESULTS: [&str; 23] = [
    "bounces.png",
    "comparison.csv",
    "comparison.json",
    "comparison.png",
    "faces.csv",
    "faces_photometric.csv",
    "illuminance.png",
    "image.exr",
    "image.png",
    "knobs.svg",
    "lamp_groups.csv",
    "luminance.png",
    "mesh.ply",
    "orders.svg",
    "patches.csv",
    "patches_photometric.csv",
    "photometry.csv",
    "receivers.csv",
    "study_reference.csv",
    "solution.json",
    "study.csv",
    "study.md",
    "study.svg",
];

/// Reads a scene: the built-in one, that on standard input, or that of a file.
pub fn load(scene: Option<&Path>, allow_outside: bool) -> Result<Scene, SceneError> {
    let options = Loading { allow_outside };
    match scene {
        Some(path) if path.as_os_str() == "-" => Scene::read(std::io::stdin().lock(), "", options),
        Some(path) => Scene::load_with(path, options),
        None => Ok(Scene::cornell_box()),
    }
}

impl SceneArgs {
    /// Reads the scene, and makes sure that results can be written, and that none would overwrite a file of
    /// it.
    pub fn load(&self) -> Result<Scene, Failure> {
        let scene = self.read()?;
        output::check_folder(&self.folder(&scene))?;
        Ok(scene)
    }

    /// The same for commands that write nothing into the folder.
    pub fn read(&self) -> Result<Scene, Failure> {
        let scene = load(self.scene.as_deref(), self.allow_outside)?;
        let folder = self.folder(&scene);
        RESULTS.iter().try_for_each(|name| output::spare(&folder.join(name), scene.inputs()))?;
        Ok(scene)
    }

    /// Where the results go.
    pub fn folder(&self, scene: &Scene) -> PathBuf {
        // The file's own name, whatever letters it is made of.
        let stem =
            self.scene.as_ref().and_then(|path| path.file_stem()).filter(|stem| stem.to_str().is_none());
        let usual = || Path::new("out").join(stem.unwrap_or(OsStr::new(scene.name())));
        self.out.clone().unwrap_or_else(usual)
    }

    /// Results to be written to a folder, which is made if it is not there.
    pub fn outputs(&self, scene: &Scene) -> Result<Outputs, Failure> {
        let folder = self.folder(scene);
        std::fs::create_dir_all(&folder)
            .map_err(|source| OutputError::Folder { path: folder.clone(), source })?;
        Ok(Outputs::in_folder(folder).sparing(scene.inputs()))
    }
}

/// How finely to cut and trace.
#[derive(Debug, Args)]
#[command(next_help_heading = "Accuracy")]
pub struct AccuracyArgs {
    /// About how many patches (unknowns) to cut into
    #[arg(
        long,
        value_name = "N",
        default_value_t = 8000,
        allow_negative_numbers = true,
        value_parser = values::positive,
    )]
    patches: usize,

    /// Longest leg of a patch, metres; instead of --patches
    #[arg(
        long,
        value_name = "METRES",
        conflicts_with = "patches",
        allow_negative_numbers = true,
        value_parser = values::positive_length,
    )]
    edge: Option<f64>,

    /// Rays per patch [default: 512; from 16384 patches on fewer, but at least 64]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = values::whole::<u32>)]
    rays: Option<u32>,

    /// How to store exchange areas
    #[arg(long, value_enum, default_value_t = StorageArg::Auto)]
    storage: StorageArg,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum StorageArg {
    /// Whichever is smaller
    Auto,
    /// A full matrix
    Dense,
    /// Compressed rows
    Sparse,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum BasisArg {
    /// One value
    Constant,
    /// Straight from corner to corner: less error with the same patches and rays, for thrice the unknowns
    Linear,
}

impl BasisArg {
    pub fn basis(self) -> Basis {
        match self {
            Self::Constant => Basis::Constant,
            Self::Linear => Basis::Linear,
        }
    }
}

impl AccuracyArgs {
    /// How many patches there will be at least, as far as that can be told before light is looked for.
    pub fn wanted_patches(&self, tracer: &Tracer) -> Result<usize, PatchError> {
        Ok(match self.edge {
            // Light may reach but one of two sides that it probably does.
            Some(metres) => (0.5 * Outlook::new(tracer, PatchSize::Edge(metres))?.patches()) as usize,
            None => self.patches,
        })
    }

    pub fn tessellation<'a>(&self, run: &RunArgs, progress: Progress<'a>) -> Tessellation<'a> {
        let size = match self.edge {
            Some(metres) => PatchSize::Edge(metres),
            None => PatchSize::Count(self.patches),
        };
        Tessellation { size, reach: Reach::Light, seed: run.seed, memory: run.memory, progress }
    }

    pub fn light<'a>(&self, run: &RunArgs, progress: Progress<'a>) -> LightOptions<'a> {
        let rays = self.rays.unwrap_or(LightOptions::default().rays);
        let lamp_rays = self.rays.map(|rays| rays / 2);
        LightOptions { rays, lamp_rays, seed: run.seed, progress, ..Default::default() }
    }

    pub fn trace<'a>(&self, run: &RunArgs, progress: Progress<'a>) -> TraceOptions<'a> {
        let storage = match self.storage {
            StorageArg::Auto => StorageKind::Auto,
            StorageArg::Dense => StorageKind::Dense,
            StorageArg::Sparse => StorageKind::Sparse,
        };
        TraceOptions {
            rays: self.rays,
            seed: run.seed,
            storage,
            memory: run.memory,
            progress,
            ..Default::default()
        }
    }
}

/// How to solve.
#[derive(Debug, Args)]
#[command(next_help_heading = "Solver")]
pub struct SolverArgs {
    /// How to solve for the light; the Neumann series is summed in any case
    #[arg(long, value_enum, default_value_t = SolverArg::Auto)]
    solver: SolverArg,

    /// Highest order of the Neumann series
    #[arg(
        long,
        value_name = "K",
        default_value_t = 1000,
        allow_negative_numbers = true,
        value_parser = values::whole::<usize>,
    )]
    pub order: usize,

    /// Part of the flux, and of the irradiance, that may be missing when iterations stop: the flux still on
    /// its way is at most T of what is emitted, and no irradiance is off by more than T of the root mean
    /// square over all surfaces, nor by more than 10 T of its own (of a thousandth of that mean, where it is
    /// darker). 0 runs the series up to --order, and conjugate gradients as far as rounding allows
    #[arg(
        long,
        value_name = "T",
        default_value = "1e-6",
        allow_negative_numbers = true,
        value_parser = values::tolerance,
    )]
    pub tolerance: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum SolverArg {
    /// Direct where that takes a second or two, else conjugate gradients
    Auto,
    /// Cholesky factors
    Direct,
    /// The series, bounce by bounce
    Neumann,
    /// Conjugate gradients
    Cg,
}

impl SolverArgs {
    /// How the equation will be solved, as far as that is known before.
    pub fn solving(&self) -> Solving {
        match self.solver {
            SolverArg::Auto => Solving::Either,
            SolverArg::Direct => Solving::Factored,
            SolverArg::Neumann | SolverArg::Cg => Solving::Iterated,
        }
    }

    pub fn options<'a>(&self, run: &RunArgs, progress: Progress<'a>) -> SolveOptions<'a> {
        let method = match self.solver {
            SolverArg::Auto => Method::Auto,
            SolverArg::Direct => Method::Direct,
            SolverArg::Neumann => Method::Neumann,
            SolverArg::Cg => Method::ConjugateGradients,
        };
        SolveOptions {
            method,
            tolerance: self.tolerance,
            order: self.order,
            memory: run.memory,
            amplification: None,
            progress,
        }
    }
}

/// How to run.
#[derive(Debug, Args)]
#[command(next_help_heading = "Run")]
pub struct RunArgs {
    /// Number of the random sequences; the same seed gives the same bits
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0,
        allow_negative_numbers = true,
        value_parser = values::whole::<u64>,
    )]
    pub seed: u64,

    /// Threads [default: one per core]
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = values::threads)]
    threads: Option<usize>,

    /// Memory that patches, the operator and the factors of the direct solver may each take
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "4GiB",
        allow_hyphen_values = true,
        value_parser = values::memory,
    )]
    pub memory: u64,

    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,

    /// Print the summary as JSON on standard output, and nothing else there
    #[arg(long)]
    pub json: bool,
}

impl RunArgs {
    /// Starts the threads, and makes signals end the run at the next report of progress.
    pub fn set_up(&self, terminal: &Terminal) -> Result<(), Failure> {
        rayon::ThreadPoolBuilder::new().num_threads(self.threads.unwrap_or(0)).build_global()?;
        terminal.stop_on_signals()?;
        Ok(())
    }
}
