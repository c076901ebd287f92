//! Image: what a camera sees of a radiance field over patches.
//!
//! Where the field itself is shown, each pixel is the mean of 4 rays, or of 16 where those 4 or the
//! neighbouring pixels differ to the eye. The samples are the first 4 or 16 points of a (0,2)-sequence, so
//! that each quarter and each sixteenth of the pixel has its share. Where light is gathered or paths are
//! traced, each pixel takes as many points as asked for of an Owen-scrambled Sobol sequence.

mod field;
mod gather;
mod highlights;
mod lens;
mod numbers;
mod outlines;
mod painted;
mod reflections;
mod samples;

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::RenderError;
use super::limiter::limited;
use super::picture::Picture;
use super::tone::to_rgb;
use crate::patches::{Basis, Patches};
use crate::progress::{Cancelled, Progress};
use crate::reference::PathTracer;
use crate::scene::{Camera, Side, Sky, SkyShares};
use crate::trace::{Hit, Ray, Tracer};
use field::Field;
use gather::Gather;
use highlights::{Highlights, Views};
use lens::Lens;
use numbers::Numbers;
use outlines::dimming;
use painted::Painted;
use reflections::Chances;
use samples::{FEW, MANY, Samples, Seen, rough_pixels, stratified};

/// How radiance is found where a camera ray ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// It is the patch's at that point: the solution as it is, constant or linear.
    Flat,
    /// It is interpolated between the patch's corners, joined with those of its neighbours, see
    /// [`SmoothField`](super::SmoothField).
    Smooth,
    /// It is gathered there, from lamps and from the patches around, by [`RenderOptions::samples`] random
    /// rays: shadows are as sharp as the scene makes them, patches are not seen. Where everything is solved
    /// exactly this is exact in the mean; noise falls as samples rise. Surfaces are as flat as their faces.
    Gather,
    /// It is found by light paths of any length, [`RenderOptions::samples`] a pixel, without patches or form
    /// factors: the independent reference. The solution is not looked at.
    Path,
}

/// Whether the edges of patches are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outlines {
    /// They are not.
    Hidden,
    /// As thin lines that darken the picture; they fade where patches are only a few pixels wide.
    Shown,
}

/// What is shown of surfaces whose textures vary reflectance or emission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surfaces {
    /// The textures themselves, under the light that was solved for; for fields of radiance.
    Textured,
    /// The field as it is, with means over patches; for all other quantities. Gathered light and light paths
    /// always know textures.
    Averaged,
}

/// How to render.
#[derive(Clone, Copy, Debug)]
pub struct RenderOptions<'a> {
    /// Pixels across; 1 to 32768, time grows in proportion and memory by 28 bytes a pixel.
    pub width: usize,
    /// Pixels down; the same, and at most 2²⁷ in all.
    pub height: usize,
    /// How radiance varies within a patch.
    pub shading: Shading,
    /// Irradiance by lights without area and the sky by way of mirrors, metals and glass (N × c, W·m⁻²),
    /// which gathering can't find by itself: that of [`CarriedLight`](crate::transport::CarriedLight).
    pub carried: Option<&'a DMatrix<f64>>,
    /// Whether textures are shown.
    pub surfaces: Surfaces,
    /// Whether the edges of patches are drawn.
    pub outlines: Outlines,
    /// Random samples per pixel where light is gathered or paths are traced, 1 to 2²⁰; time grows in
    /// proportion, noise falls at least as their root. Powers of two are spread most evenly.
    pub samples: u32,
    /// Number of the random sequence.
    pub seed: u64,
    /// Where to report progress, as stage `render`.
    pub progress: Progress<'a>,
}

impl Default for RenderOptions<'_> {
    /// 800 × 600, smooth, with textures, without outlines; 64 samples where they are random.
    fn default() -> Self {
        Self {
            width: 800,
            height: 600,
            shading: Shading::Smooth,
            carried: None,
            surfaces: Surfaces::Textured,
            outlines: Outlines::Hidden,
            samples: 64,
            seed: 0,
            progress: Progress::default(),
        }
    }
}

impl RenderOptions<'_> {
    /// Makes sure that the picture is neither empty nor too large, and that its samples can be counted.
    ///
    /// # Errors
    /// `Size` or `Samples`.
    pub fn validate(&self) -> Result<(), RenderError> {
        let &Self { width, height, .. } = self;
        let fits = [width, height].iter().all(|length| (1..=LONGEST).contains(length));
        if !fits || width * height > LARGEST {
            return Err(RenderError::Size { width, height });
        }
        let samples = self.samples;
        if (1..=MOST_SAMPLES).contains(&samples) { Ok(()) } else { Err(RenderError::Samples { samples }) }
    }
}

/// Pictures wider or higher than this, or of more pixels, are refused.
const LONGEST: usize = 32768;
const LARGEST: usize = 1 << 27;

/// More random samples per pixel than this are refused.
const MOST_SAMPLES: u32 = 1 << 20;

/// About so many pixels are rendered together, as a band of rows; 160 bytes each.
const BAND: usize = 1 << 19;

/// Renders `radiance` (N × c, W·sr⁻¹·m⁻²) as `camera` sees it; where nothing is met there is sky, or black
/// where there is none; where no light comes it is black.
///
/// N is the number of patches n or, for linear elements, 3n. Where these fall below zero they are shown with
/// less of a tilt. The picture does not depend on the number of threads.
///
/// # Errors
/// `Size`, `Samples`, `Camera` or `Cancelled`.
///
/// # Panics
/// If `radiance` has neither n nor 3n rows.
pub fn picture(
    tracer: &Tracer,
    patches: &Patches,
    radiance: &DMatrix<f64>,
    camera: &Camera,
    options: &RenderOptions,
) -> Result<Picture, RenderError> {
    let radiance = limited(Basis::of(patches, radiance), radiance);
    options.validate()?;
    if !camera.is_valid() {
        return Err(RenderError::Camera);
    }
    options.progress.at("render", 0.0)?;
    let view = View::new(tracer, patches, &radiance, camera, options);
    Ok(view.picture((BAND / options.width).max(1))?)
}

/// Calls `work` with every pixel and its place, and `row_done` after each row; rows in parallel.
fn in_rows(
    pixels: &mut [Samples],
    width: usize,
    row_done: impl Fn() -> Result<(), Cancelled> + Sync,
    work: impl Fn(&mut Samples, usize, usize) + Sync,
) -> Result<(), Cancelled> {
    pixels.par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(x, pixel)| work(pixel, x, y));
        row_done()
    })
}

/// All it takes to find a pixel's samples.
struct View<'a, 's> {
    tracer: &'a Tracer<'s>,
    patches: &'a Patches<'s>,
    lens: Lens,
    sight: Sight<'a, 's>,
    highlights: Option<Highlights<'a, 's>>,
    sky: Option<SkyShares>,
    options: &'a RenderOptions<'a>,
}

/// What tells the radiance where a camera ray ends.
enum Sight<'a, 's> {
    /// The solution: the same at every look, so a few samples do where nothing changes.
    Field(Field<'a, 's>, Option<Painted<'a, 's>>),
    /// Light gathered there: random, so every pixel takes all its samples.
    Gather(Box<Gather<'a, 's>>),
    /// Light paths that start there: random too.
    Path(PathTracer<'a, 's>),
}

impl<'a, 's> View<'a, 's> {
    fn new(
        tracer: &'a Tracer<'s>,
        patches: &'a Patches<'s>,
        radiance: &DMatrix<f64>,
        camera: &Camera,
        options: &'a RenderOptions,
    ) -> Self {
        let field = |spread: &dyn Fn(&DMatrix<f64>) -> Field<'a, 's>| {
            let shown = options.surfaces == Surfaces::Textured;
            let painted = shown.then(|| Painted::new(patches, radiance, spread)).flatten();
            Sight::Field(spread(radiance), painted)
        };
        let sight = match options.shading {
            Shading::Flat => field(&|field: &DMatrix<f64>| Field::flat(patches, field)),
            Shading::Smooth => field(&|field: &DMatrix<f64>| Field::smooth(tracer, patches, field)),
            Shading::Gather => {
                Sight::Gather(Box::new(Gather::new(tracer, patches, radiance, options.carried)))
            }
            Shading::Path => Sight::Path(PathTracer::new(tracer)),
        };
        let lens = Lens::new(tracer, camera, options.width, options.height);
        let sky = tracer.scene().sky().map(Sky::shares);
        Self { tracer, patches, lens, sight, highlights: Highlights::new(tracer), sky, options }
    }

    /// The picture, made in bands of so many rows.
    fn picture(&self, rows: usize) -> Result<Picture, Cancelled> {
        let &RenderOptions { width, height, progress, .. } = self.options;
        let (pixels, lamps) = (Vec::with_capacity(width * height), Vec::with_capacity(width * height));
        let mut picture = Picture { width, height, pixels, lamps };
        let passes = if matches!(self.sight, Sight::Field(..)) { 2 } else { 1 };
        let rows_done = AtomicUsize::new(0);
        let row_done = || {
            let rows = rows_done.fetch_add(1, Ordering::Relaxed) + 1;
            progress.at("render", (rows as f64 / (passes * height) as f64).min(1.0))
        };
        for start in (0..height).step_by(rows) {
            let band = start..(start + rows).min(height);
            let pixels = match self.sight {
                Sight::Field(..) => self.band_where_needed(band, row_done)?,
                Sight::Gather(_) | Sight::Path(_) => self.band(band, row_done)?,
            };
            for (pixel, lamp) in pixels.iter().map(Samples::mean) {
                picture.pixels.push(pixel);
                picture.lamps.push(lamp);
            }
        }
        Ok(picture)
    }

    /// These rows, with all samples in every pixel.
    fn band(
        &self,
        rows: Range<usize>,
        row_done: impl Fn() -> Result<(), Cancelled> + Sync,
    ) -> Result<Vec<Samples>, Cancelled> {
        let mut pixels = vec![Samples::default(); self.options.width * rows.len()];
        let samples = self.options.samples;
        in_rows(&mut pixels, self.options.width, row_done, |pixel, x, y| {
            self.sample(pixel, x, rows.start + y, 0..samples);
        })?;
        Ok(pixels)
    }

    /// These rows, with few samples in most pixels and many in some.
    fn band_where_needed(
        &self,
        rows: Range<usize>,
        row_done: impl Fn() -> Result<(), Cancelled> + Sync,
    ) -> Result<Vec<Samples>, Cancelled> {
        let &RenderOptions { width, height, .. } = self.options;
        // Take a few samples of every pixel, and of the rows above and below to compare them with.
        let (first, last) = (rows.start.saturating_sub(1), (rows.end + 1).min(height));
        let mut pixels = vec![Samples::default(); width * (last - first)];
        in_rows(&mut pixels, width, &row_done, |pixel, x, y| self.sample(pixel, x, first + y, 0..FEW))?;
        // Take more where they differ.
        let rough = rough_pixels(&pixels, width);
        let above = width * (rows.start - first);
        let mut band = pixels.split_off(above);
        band.truncate(width * rows.len());
        in_rows(&mut band, width, &row_done, |pixel, x, y| {
            if rough[above + y * width + x] {
                self.sample(pixel, x, rows.start + y, FEW..MANY);
            }
        })?;
        Ok(band)
    }

    /// Adds samples `range` of the pixel at (x, y).
    fn sample(&self, pixel: &mut Samples, x: usize, y: usize, range: Range<u32>) {
        let corner = DVec2::new(x as f64, y as f64);
        let numbers = Numbers::of_pixel(self.options, x, y);
        let mut views = Views::default();
        let mut channels = vec![0.0; self.tracer.scene().channels()];
        let away = |ray: &Ray| self.sky_towards(ray.direction).unwrap_or_default();
        for k in range {
            // Dimension set 0 tells where in the pixel, those that follow what happens there.
            let (sequence, place) = numbers.of_sample(k);
            let anywhere = || corner + DVec2::from_slice(&sequence.dimensions(place, 0)[..2]);
            let seen = match &self.sight {
                Sight::Field(field, painted) => self.look(corner + stratified(k), |ray| {
                    let radiance = |hit: &Hit| {
                        let patch = self.lit_patch(hit)?;
                        let painted = painted.as_ref().and_then(|painted| painted.at(patch, hit));
                        Some(painted.unwrap_or_else(|| field.at(patch, hit.barycentrics)))
                    };
                    let pixel = (y * self.options.width + x) as u64;
                    let chances = Chances::new(self.options.seed, pixel, k);
                    let (tracer, highlights) = (self.tracer, self.highlights.as_ref());
                    let (away, radiance, views) = (&away, &radiance, &mut views);
                    reflections::Look { tracer, highlights, chances, views, away, radiance }.seen_along(ray)
                }),
                Sight::Gather(gather) => {
                    let mut look = gather::Look { sequence, point: place, set: 0, views: &mut views };
                    self.look(anywhere(), |ray| gather.seen_along(ray, &mut look, away))
                }
                Sight::Path(paths) => self.look(anywhere(), |ray| {
                    channels.fill(0.0);
                    let hit = paths.add_radiance(ray, sequence, place, &mut channels)?;
                    Some((hit, to_rgb(&channels).into()))
                }),
            };
            pixel.add(seen.unwrap_or_default());
        }
    }

    /// The patch where a ray ended; none where no light comes.
    fn lit_patch(&self, hit: &Hit) -> Option<usize> {
        self.patches.patch_at(hit.face as usize, hit.side, hit.barycentrics)
    }

    /// What a ray that leaves the scene sees of the sky.
    fn sky_behind(&self, ray: &Ray) -> Option<Seen> {
        let radiance =
            self.sky_towards(ray.direction).filter(|_| self.tracer.is_clear(ray, f64::INFINITY))?;
        Some(Seen { radiance, is_lamp: true, outline: 1.0 })
    }

    /// The radiance of the sky in a direction.
    fn sky_towards(&self, direction: DVec3) -> Option<DVec3> {
        let zenith: DVec3 = to_rgb(&self.tracer.scene().sky()?.zenith).into();
        let (share, tint) = self.sky.as_ref()?.tinted(direction);
        Some(zenith * share * tint.map_or(DVec3::ONE, DVec3::from))
    }

    /// What is seen at a point of the picture, if `meet` tells what the ray meets and the radiance that
    /// leaves there.
    fn look(&self, point: DVec2, meet: impl FnOnce(&Ray) -> Option<(Hit, DVec3)>) -> Option<Seen> {
        let ray = self.lens.ray(point);
        let Some((hit, radiance)) = meet(&ray) else { return self.sky_behind(&ray) };
        let face = hit.face as usize;
        let outlined = || self.patches.patch_at(face, hit.side, hit.barycentrics);
        let outline = match self.options.outlines {
            Outlines::Hidden => 1.0,
            Outlines::Shown => {
                outlined().map_or(1.0, |patch| dimming(self.tracer, self.patches, &self.lens, point, patch))
            }
        };
        let is_lamp = hit.side == Side::Front && self.tracer.scene().material_of(face).emits();
        Some(Seen { radiance, is_lamp, outline })
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{cut, quad, room, triangles};
    use super::*;
    use crate::patches::Reach;
    use crate::progress::Observer;
    use crate::scene::Material;
    use std::ops::ControlFlow;

    fn inside() -> Camera {
        Camera { position: DVec3::splat(0.4), target: DVec3::new(1.0, 0.6, 0.5), up: DVec3::Y, fov: 70.0 }
    }

    fn small<'a>() -> RenderOptions<'a> {
        RenderOptions { width: 40, height: 30, ..Default::default() }
    }

    #[test]
    fn the_picture_of_a_furnace_is_constant() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.3, Reach::Light);
        let radiance = DMatrix::from_element(patches.len(), 1, 2.0);
        for shading in [Shading::Flat, Shading::Smooth, Shading::Gather] {
            let options = RenderOptions { shading, ..small() };
            let picture = picture(&tracer, &patches, &radiance, &inside(), &options).unwrap();
            assert!(picture.pixels.iter().flatten().all(|x| (x - 2.0).abs() < 1e-6));
            let bytes = picture.to_srgb(picture.exposure());
            assert!(bytes.iter().all(|&b| b == bytes[0] && (180..230).contains(&b)));
        }
    }

    #[test]
    fn a_ray_that_meets_nothing_is_black_and_what_lies_to_the_right_is_seen_on_the_right() {
        // A wall that fills the right half of the picture, seen along -z with y up.
        let wall = quad([0.0, -9.0, 0.0], [9.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
        let lamp = Material::lamp("wall", &[0.0; 3], &[1.0, 2.0, 3.0]);
        let scene = triangles(&wall, &[0, 0], vec![lamp]);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 3.0, Reach::Light);
        let camera =
            Camera { position: DVec3::new(0.0, 0.0, 4.0), target: DVec3::ZERO, up: DVec3::Y, fov: 60.0 };
        let picture = picture(&tracer, &patches, &patches.emitted_radiance(), &camera, &small()).unwrap();
        for (k, pixel) in picture.pixels.iter().enumerate() {
            let lit = k % 40 >= 20;
            assert_eq!(*pixel, if lit { [1.0, 2.0, 3.0] } else { [0.0; 3] });
            assert_eq!(picture.lamps[k].share, if lit { 1.0 } else { 0.0 });
        }
    }

    #[test]
    fn the_picture_does_not_depend_on_the_number_of_threads() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.3, Reach::Light);
        let radiance = DMatrix::from_fn(patches.len(), 1, |i, _| (i % 7) as f64);
        for shading in [Shading::Smooth, Shading::Gather, Shading::Path] {
            let options = RenderOptions { shading, samples: 4, ..small() };
            let with = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| picture(&tracer, &patches, &radiance, &inside(), &options).unwrap())
            };
            assert_eq!(with(1), with(3));
        }
    }

    #[test]
    fn bands_leave_no_seam() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.3, Reach::Light);
        let radiance = DMatrix::from_fn(patches.len(), 1, |i, _| (i % 7) as f64);
        for shading in [Shading::Smooth, Shading::Gather, Shading::Path] {
            let options = RenderOptions { shading, samples: 2, ..small() };
            let view = View::new(&tracer, &patches, &radiance, &inside(), &options);
            let whole = view.picture(30).unwrap();
            for rows in [1, 7, 29] {
                assert_eq!(view.picture(rows).unwrap(), whole, "{rows}");
            }
        }
    }

    #[test]
    fn outlines_darken_edges_and_only_them() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.5, Reach::Light);
        let radiance = DMatrix::from_element(patches.len(), 1, 1.0);
        let options =
            RenderOptions { width: 200, height: 150, outlines: Outlines::Shown, ..Default::default() };
        let picture = picture(&tracer, &patches, &radiance, &inside(), &options).unwrap();
        let dark = picture.pixels.iter().filter(|p| p[0] < 0.99).count();
        assert!((200..10_000).contains(&dark), "{dark}");
        assert!(picture.pixels.iter().all(|p| p[0] > 0.3));
    }

    struct Stop;
    impl Observer for Stop {
        fn at(&self, _: &'static str, done: f64) -> ControlFlow<()> {
            if done > 0.3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    }

    #[test]
    fn a_picture_can_be_cancelled() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.5, Reach::Light);
        let options = RenderOptions { progress: Progress::to(&Stop), ..small() };
        let stopped = picture(&tracer, &patches, &patches.emitted_radiance(), &inside(), &options);
        assert!(matches!(stopped, Err(RenderError::Cancelled(_))));
    }

    #[test]
    fn refuses_impossible_sizes_and_cameras() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.5, Reach::Light);
        let sources = patches.emitted_radiance();
        for (width, height) in [(0, 30), (40, 0), (40_000, 1), (usize::MAX, usize::MAX), (32768, 4097)] {
            let options = RenderOptions { width, height, ..small() };
            let refused = picture(&tracer, &patches, &sources, &inside(), &options);
            assert!(matches!(refused, Err(RenderError::Size { .. })), "{width} x {height}");
        }
        let blind = Camera { fov: 0.0, ..inside() };
        let refused = picture(&tracer, &patches, &sources, &blind, &small());
        assert!(matches!(refused, Err(RenderError::Camera)));
    }
}
