//! Pictures: what they look like, and from where.

use clap::{Args, ValueEnum};
use radiosity::output::{OutputError, Outputs};
use radiosity::patches::Patches;
use radiosity::progress::Progress;
use radiosity::render::{self, Exposure, Outlines, Picture, RenderError, RenderOptions, Shading, Surfaces};
use radiosity::scene::{Camera, Scene};
use radiosity::trace::Tracer;

use crate::args::RunArgs;
use crate::factors::FactorsArgs;
use crate::terminal::{Failure, Terminal};
use crate::values;

/// The scene's own camera, or one that sees into it.
pub fn camera(tracer: &Tracer, patches: &Patches) -> Camera {
    tracer.scene().camera().copied().unwrap_or_else(|| render::default_camera(tracer, patches))
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
    #[arg(
        long,
        value_name = "WxH",
        default_value = "800x600",
        allow_hyphen_values = true,
        value_parser = values::size,
    )]
    size: (usize, usize),

    /// How radiance is found at a point
    #[arg(long, value_enum, default_value_t = ShadingArg::Smooth)]
    shading: ShadingArg,

    /// Random samples per pixel, for --shading gather and path; best a power of two
    #[arg(
        long,
        value_name = "N",
        default_value_t = 64,
        allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(1..=1 << 20),
    )]
    samples: u32,

    /// Draw the edges of patches
    #[arg(long)]
    outlines: bool,

    /// Brightness: radiance times this is the share of white [default: automatic]
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, value_parser = values::positive_length)]
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
    ) -> Result<RenderOptions<'a>, RenderError> {
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
