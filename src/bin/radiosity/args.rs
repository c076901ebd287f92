//! Arguments that several commands share, and what they mean to the library.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum};
use radiosity::output::{
    self, Exposure, Outlines, OutputError, Outputs, Picture, RenderOptions, Shading, Surfaces,
};
use radiosity::patches::{Basis, Outlook, PatchError, PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Camera, Loading, Scene, SceneError};
use radiosity::solve::{Method, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{LightOptions, Solving, StorageKind, TraceOptions};

use crate::factors::FactorsArgs;
use crate::terminal::{Failure, Terminal};

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
    /// Reads the scene, and makes sure that no result would overwrite a file of it.
    pub fn load(&self) -> Result<Scene, Failure> {
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
        std::fs::create_dir_all(&folder).map_err(|e| {
            format!("cannot make the folder {}: {e}; choose another with --out", folder.display())
        })?;
        Ok(Outputs::in_folder(folder).sparing(scene.inputs()))
    }
}

/// How finely to cut and trace.
#[derive(Debug, Args)]
#[command(next_help_heading = "Accuracy")]
pub struct AccuracyArgs {
    /// About how many patches (unknowns) to cut into
    #[arg(long, value_name = "N", default_value_t = 8000, value_parser = positive)]
    patches: usize,

    /// Longest leg of a patch, metres; instead of --patches
    #[arg(long, value_name = "METRES", conflicts_with = "patches", value_parser = positive_length)]
    edge: Option<f64>,

    /// Rays per patch [default: 512; from 16384 patches on fewer, but at least 64]
    #[arg(long, value_name = "N")]
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
    #[arg(long, value_name = "K", default_value_t = 1000)]
    pub order: usize,

    /// Part of the flux, and of the irradiance, that may be missing when iterations stop: the flux still on
    /// its way is at most T of what is emitted, and no irradiance is off by more than T of the root mean
    /// square over all surfaces, nor by more than 10 T of its own (of a thousandth of that mean, where it is
    /// darker). 0 runs the series up to --order, and conjugate gradients as far as rounding allows
    #[arg(long, value_name = "T", default_value = "1e-6", value_parser = tolerance)]
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

/// The scene's own camera, or one that sees into it.
pub fn camera(tracer: &Tracer, patches: &Patches) -> Camera {
    tracer.scene().camera().copied().unwrap_or_else(|| output::default_camera(tracer, patches))
}

/// Says so if nothing can be seen in a picture, and why; `most` is the highest irradiance of all.
pub fn warn_if_black(picture: &Picture, most: f64, terminal: &Terminal) {
    if picture.is_black() {
        terminal.warn(match most > 0.0 {
            true => {
                "the picture is black: the camera sees nothing that is lit; change [camera] in the scene's .toml, or remove it \
                 there to have one found"
            }
            false => {
                "the picture is black, for no light arrives anywhere: lamps shine from their fronts alone, where corners run \
                 counter-clockwise, and may face away; `radiosity check` names them"
            }
        });
    }
}

/// What the picture looks like.
#[derive(Debug, Args)]
#[command(next_help_heading = "Picture")]
pub struct PictureArgs {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = size)]
    size: (usize, usize),

    /// How radiance is found at a point
    #[arg(long, value_enum, default_value_t = ShadingArg::Smooth)]
    shading: ShadingArg,

    /// Random samples per pixel, for --shading gather and path; best a power of two
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    samples: u32,

    /// Draw the edges of patches
    #[arg(long)]
    outlines: bool,

    /// Brightness: radiance times this is the share of white [default: automatic]
    #[arg(long, value_name = "FACTOR", value_parser = positive_length)]
    exposure: Option<f64>,

    /// Also write image.exr, linear radiance
    #[arg(long)]
    exr: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ShadingArg {
    /// The patches as they were solved
    Flat,
    /// Interpolated across smooth surfaces
    Smooth,
    /// Gathered there from lamps and patches: sharp shadows, no patches to be seen; takes longer
    Gather,
    /// By light paths alone: the reference, without patches or form factors
    Path,
}

impl PictureArgs {
    /// Refuses an impossible size or number of samples before any work is done.
    pub fn options<'a>(
        &self,
        run: &RunArgs,
        progress: Progress<'a>,
    ) -> Result<RenderOptions<'a>, OutputError> {
        let shading = match self.shading {
            ShadingArg::Flat => Shading::Flat,
            ShadingArg::Smooth => Shading::Smooth,
            ShadingArg::Gather => Shading::Gather,
            ShadingArg::Path => Shading::Path,
        };
        let outlines = if self.outlines { Outlines::Shown } else { Outlines::Hidden };
        let (width, height) = self.size;
        let &Self { samples, .. } = self;
        let seed = run.seed;
        let surfaces = Surfaces::Textured;
        let options = RenderOptions {
            width,
            height,
            shading,
            surfaces,
            outlines,
            samples,
            seed,
            progress,
            ..Default::default()
        };
        options.validate()?;
        Ok(options)
    }

    /// Refuses to leave out what this way of shading simulates in any case.
    pub fn refuse_to_leave_out(&self, scene: &Scene, factors: &FactorsArgs) -> Result<(), Failure> {
        match self.shading {
            ShadingArg::Flat | ShadingArg::Smooth => Ok(()),
            ShadingArg::Gather | ShadingArg::Path => {
                factors.refuse_to_leave_out(scene, "--shading gather and path follow light themselves")
            }
        }
    }

    /// Says so where this way of shading lacks light that is solved for.
    pub fn warn_of_light_paths(&self, scene: &Scene, terminal: &Terminal) {
        let carries = (0..scene.faces().len()).any(|face| scene.is_carrier(face));
        if matches!(self.shading, ShadingArg::Path) && carries && scene.lights().next().is_some() {
            terminal.warn(
                "light paths that start at the camera do not find points, spots, luminaires and suns by way of mirrors, metals and glass: \
                 the picture lacks that light; --shading gather shows it",
            );
        }
    }

    pub fn exposure(&self, picture: &Picture) -> Exposure {
        self.exposure.map_or_else(|| picture.exposure(), |factor| Exposure { factor })
    }

    /// Adds `image.png`, and `image.exr` if wanted.
    pub fn write(&self, picture: &Picture, outputs: &mut Outputs) -> Result<(), OutputError> {
        outputs.file("image.png", |file| picture.write_png(file, self.exposure(picture)))?;
        if self.exr {
            outputs.file("image.exr", |file| picture.write_exr(file))?;
        }
        Ok(())
    }
}

/// How to run.
#[derive(Debug, Args)]
#[command(next_help_heading = "Run")]
pub struct RunArgs {
    /// Number of the random sequences; the same seed gives the same bits
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,

    /// Threads [default: one per core]
    #[arg(long, value_name = "T", value_parser = threads)]
    threads: Option<usize>,

    /// Memory that patches, the operator and the factors of the direct solver may each take
    #[arg(long, value_name = "SIZE", default_value = "4GiB", value_parser = memory)]
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

pub fn positive(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|&n| n > 0).ok_or_else(|| "must be a whole number above 0".into())
}

pub fn positive_length(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|x: &f64| x.is_finite() && *x > 0.0)
        .ok_or_else(|| "must be a number above 0".into())
}

/// Each takes a stack, and more than a few hundred help no machine.
const MOST_THREADS: usize = 1024;

fn threads(text: &str) -> Result<usize, String> {
    positive(text)
        .ok()
        .filter(|&n| n <= MOST_THREADS)
        .ok_or_else(|| format!("must be a whole number from 1 to {MOST_THREADS}"))
}

fn tolerance(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x| (0.0..1.0).contains(x)).ok_or_else(|| "must lie between 0 and 1".into())
}

pub fn size(text: &str) -> Result<(usize, usize), String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    parsed.filter(|&(w, h)| w > 0 && h > 0).ok_or_else(|| "write it as 800x600".into())
}

fn memory(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit: u64 = match &text[digits.len()..] {
        "" | "B" => 1,
        "KiB" => 1 << 10,
        "MiB" => 1 << 20,
        "GiB" => 1 << 30,
        "TiB" => 1 << 40,
        "kB" => 1_000,
        "MB" => 1_000_000,
        "GB" => 1_000_000_000,
        _ => return Err(MEMORY.into()),
    };
    let number: f64 = digits.parse().map_err(|_| MEMORY)?;
    let bytes = number * unit as f64;
    if bytes >= LEAST_MEMORY as f64 { Ok(bytes as u64) } else { Err(MEMORY.into()) }
}

/// With less than this nothing can be solved.
const LEAST_MEMORY: u64 = 16 << 20;

const MEMORY: &str =
    "write it as 4GiB or 500MB, at least 16MiB; units are B, kB, MB, GB, KiB, MiB, GiB and TiB";

/// A share of one, as 0.02 or 2%.
pub fn share(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let share = number.trim().parse().ok().map(|x: f64| x * unit);
    share.filter(|x| *x > 0.0 && *x < 1.0).ok_or_else(|| "write it as 2% or 0.02; between 0 and 1".into())
}

/// A time, as 90, 90s, 5min or 1h.
pub fn duration(text: &str) -> Result<Duration, String> {
    let units = [("min", 60.0), ("h", 3600.0), ("s", 1.0)];
    let with_unit = units.iter().find_map(|(unit, seconds)| Some((text.strip_suffix(unit)?, *seconds)));
    let (number, unit) = with_unit.unwrap_or((text, 1.0));
    let seconds = number.trim().parse().ok().map(|x: f64| x * unit);
    let sound = seconds.filter(|s| *s > 0.0 && *s <= 1e7);
    sound.map(Duration::from_secs_f64).ok_or_else(|| "write it as 90s, 5min or 1h; above 0".into())
}
