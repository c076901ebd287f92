//! Image: what a camera sees of a radiance field over patches.
//!
//! Each pixel is the mean of 4 rays, or of 16 where those 4 or the neighbouring pixels differ to the eye. The samples
//! are the first 4 or 16 points of a (0,2)-sequence, so that each quarter and each sixteenth of the pixel has its share.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::tone::to_rgb;
use super::{LampPart, OutputError, Picture, SmoothField};
use crate::patches::{Barycentrics, Patches};
use crate::progress::{Cancelled, Progress};
use crate::scene::{Camera, Side};
use crate::trace::{Hit, Ray, Tracer};

/// How radiance varies within a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// Not at all: the solution as it is.
    Flat,
    /// Linearly between its corners, see [`SmoothField`].
    Smooth,
}

/// Whether the edges of patches are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outlines {
    /// They are not.
    Hidden,
    /// As thin lines that darken the picture; they fade where patches are only a few pixels wide.
    Shown,
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
    /// Whether the edges of patches are drawn.
    pub outlines: Outlines,
    /// Where to report progress, as stage `render`.
    pub progress: Progress<'a>,
}

impl Default for RenderOptions<'_> {
    /// 800 × 600, smooth, without outlines.
    fn default() -> Self {
        Self {
            width: 800,
            height: 600,
            shading: Shading::Smooth,
            outlines: Outlines::Hidden,
            progress: Progress::default(),
        }
    }
}

impl RenderOptions<'_> {
    /// Makes sure that the picture is neither empty nor too large.
    ///
    /// # Errors
    /// `Size`.
    pub fn validate(&self) -> Result<(), OutputError> {
        let &Self { width, height, .. } = self;
        let fits = [width, height].iter().all(|length| (1..=LONGEST).contains(length));
        if fits && width * height <= LARGEST { Ok(()) } else { Err(OutputError::Size { width, height }) }
    }
}

/// Pictures wider or higher than this, or of more pixels, are refused.
const LONGEST: usize = 32768;
const LARGEST: usize = 1 << 27;

/// About so many pixels are rendered together, as a band of rows; 160 bytes each.
const BAND: usize = 1 << 19;

/// Samples of every pixel, and of those that need more.
const FEW: u32 = 4;
const MANY: u32 = 16;

/// Relative differences that call for more samples: among a pixel's samples, and to its neighbours.
const WITHIN: f64 = 0.04;
const BETWEEN: f64 = 0.12;

/// Renders `radiance` (n × c, W·sr⁻¹·m⁻²) as `camera` sees it; where nothing is met, or no light comes, it is black.
///
/// The picture does not depend on the number of threads.
///
/// # Errors
/// `Size`, `Camera` or `Cancelled`.
///
/// # Panics
/// If `radiance` has not n rows.
pub fn render(
    tracer: &Tracer,
    patches: &Patches,
    radiance: &DMatrix<f64>,
    camera: &Camera,
    options: &RenderOptions,
) -> Result<Picture, OutputError> {
    assert_eq!(radiance.nrows(), patches.len(), "one row per patch");
    options.validate()?;
    if !camera.is_valid() {
        return Err(OutputError::Camera);
    }
    options.progress.at("render", 0.0)?;
    let view = View::new(tracer, patches, radiance, camera, options);
    Ok(view.picture(options, (BAND / options.width).max(1))?)
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

/// What one ray saw.
#[derive(Clone, Copy, Default)]
struct Seen {
    radiance: DVec3,
    is_lamp: bool,
    /// The factor by which an outline dims it.
    outline: f64,
}

/// What the rays of one pixel saw.
#[derive(Clone, Copy)]
struct Samples {
    count: u32,
    /// Sum over all samples.
    sum: DVec3,
    /// Sum over, and number of, those that met a lamp.
    lamp_sum: DVec3,
    lamps: u32,
    /// Sum, smallest and largest, channel by channel, as if there were no outlines: those need no more samples.
    plain: DVec3,
    low: DVec3,
    high: DVec3,
}

impl Default for Samples {
    fn default() -> Self {
        Self {
            count: 0,
            sum: DVec3::ZERO,
            lamp_sum: DVec3::ZERO,
            lamps: 0,
            plain: DVec3::ZERO,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        }
    }
}

impl Samples {
    fn add(&mut self, seen: Seen) {
        let radiance = seen.radiance * seen.outline;
        self.count += 1;
        self.sum += radiance;
        if seen.is_lamp {
            self.lamp_sum += radiance;
            self.lamps += 1;
        }
        self.plain += seen.radiance;
        self.low = self.low.min(seen.radiance);
        self.high = self.high.max(seen.radiance);
    }

    fn mean(&self) -> ([f32; 3], LampPart) {
        let count = self.count as f64;
        let part = LampPart {
            radiance: (self.lamp_sum / count).as_vec3().to_array(),
            share: self.lamps as f32 / self.count as f32,
        };
        ((self.sum / count).as_vec3().to_array(), part)
    }
}

/// The pixels that need more samples.
fn rough_pixels(pixels: &[Samples], width: usize) -> Vec<bool> {
    let means: Vec<DVec3> = pixels.iter().map(|p| p.plain / p.count as f64).collect();
    let is_rough = |k: usize| {
        let (x, below) = (k % width, k + width);
        let beside = [(x > 0).then(|| k - 1), (x + 1 < width).then_some(k + 1)];
        let above_below = [k.checked_sub(width), (below < pixels.len()).then_some(below)];
        let mut neighbours = beside.into_iter().chain(above_below).flatten();
        differ(pixels[k].low, pixels[k].high, WITHIN)
            || neighbours.any(|n| differ(means[k], means[n], BETWEEN))
    };
    (0..pixels.len()).into_par_iter().with_min_len(4096).map(is_rough).collect()
}

/// Whether two radiances differ by more than this share of the brighter one's brightest channel.
fn differ(a: DVec3, b: DVec3, share: f64) -> bool {
    (a - b).abs().max_element() > share * a.abs().max(b.abs()).max_element()
}

/// The camera in the normalised frame; a pixel's place to a direction.
struct Lens {
    origin: DVec3,
    /// Unit vectors right, up and forward.
    axes: [DVec3; 3],
    /// Middle of the picture, pixels.
    middle: DVec2,
    /// Size of a pixel on the plane at distance 1.
    pixel: f64,
}

impl Lens {
    fn new(tracer: &Tracer, camera: &Camera, width: usize, height: usize) -> Self {
        Self {
            origin: tracer.frame().from_world(camera.position),
            axes: camera.axes(),
            middle: 0.5 * DVec2::new(width as f64, height as f64),
            pixel: 2.0 * (0.5 * camera.fov.to_radians()).tan() / height as f64,
        }
    }

    /// The ray through a point of the picture (pixels, down from the top left corner).
    fn ray(&self, point: DVec2) -> Ray {
        let [right, up, forward] = self.axes;
        let at = (point - self.middle) * self.pixel;
        Ray {
            origin: self.origin,
            direction: (forward + right * at.x - up * at.y).normalize(),
            from: Ray::FREE,
        }
    }

    /// How far a point of the picture lies from the image of the line through p and q, pixels.
    fn distance_to_line(&self, point: DVec2, p: DVec3, q: DVec3) -> f64 {
        let [right, up, forward] = self.axes;
        // The line and the pinhole span a plane, which cuts the picture in the line's image.
        let normal = (p - self.origin).cross(q - self.origin);
        let (x, y) = (normal.dot(right), -normal.dot(up));
        let at = (point - self.middle) * self.pixel;
        (at.x * x + at.y * y + normal.dot(forward)).abs() / (x.hypot(y).max(1e-300) * self.pixel)
    }
}

/// Radiance of every patch as red, green and blue.
enum Light {
    Flat(Vec<DVec3>),
    Smooth(SmoothField),
}

impl Light {
    fn new(tracer: &Tracer, patches: &Patches, radiance: &DMatrix<f64>, shading: Shading) -> Self {
        let rgb = |i: usize| to_rgb(radiance.row(i).transpose().as_slice());
        let flat: Vec<[f64; 3]> = (0..patches.len()).map(rgb).collect();
        match shading {
            Shading::Flat => Self::Flat(flat.into_iter().map(DVec3::from).collect()),
            Shading::Smooth => {
                let field = DMatrix::from_fn(patches.len(), 3, |i, c| flat[i][c]);
                Self::Smooth(SmoothField::new(tracer, patches, &field))
            }
        }
    }

    fn at(&self, patch: usize, point: Barycentrics) -> DVec3 {
        match self {
            Self::Flat(rgb) => rgb[patch],
            Self::Smooth(field) => {
                let mut rgb = [0.0; 3];
                rgb.iter_mut().zip(field.at(patch, point)).for_each(|(x, value)| *x = value);
                rgb.into()
            }
        }
    }
}

/// All it takes to find a sample's radiance.
struct View<'a, 's> {
    tracer: &'a Tracer<'s>,
    patches: &'a Patches<'s>,
    lens: Lens,
    light: Light,
    outlines: Outlines,
}

impl<'a, 's> View<'a, 's> {
    fn new(
        tracer: &'a Tracer<'s>,
        patches: &'a Patches<'s>,
        radiance: &DMatrix<f64>,
        camera: &Camera,
        options: &RenderOptions,
    ) -> Self {
        Self {
            tracer,
            patches,
            lens: Lens::new(tracer, camera, options.width, options.height),
            light: Light::new(tracer, patches, radiance, options.shading),
            outlines: options.outlines,
        }
    }

    /// The picture, made in bands of so many rows.
    fn picture(&self, options: &RenderOptions, rows: usize) -> Result<Picture, Cancelled> {
        let &RenderOptions { width, height, progress, .. } = options;
        let (pixels, lamps) = (Vec::with_capacity(width * height), Vec::with_capacity(width * height));
        let mut picture = Picture { width, height, pixels, lamps };
        let rows_done = AtomicUsize::new(0);
        let row_done = || match rows_done.fetch_add(1, Ordering::Relaxed) + 1 {
            rows if rows % 16 == 0 => progress.at("render", (rows as f64 / (2 * height) as f64).min(1.0)),
            _ => Ok(()),
        };
        for start in (0..height).step_by(rows) {
            let end = (start + rows).min(height);
            // Take a few samples of every pixel, and of the rows above and below to compare them with.
            let (first, last) = (start.saturating_sub(1), (end + 1).min(height));
            let mut pixels = vec![Samples::default(); width * (last - first)];
            in_rows(&mut pixels, width, row_done, |pixel, x, y| self.sample(pixel, x, first + y, 0..FEW))?;
            // Take more where they differ.
            let rough = rough_pixels(&pixels, width);
            let band = &mut pixels[width * (start - first)..width * (end - first)];
            let rough = &rough[width * (start - first)..];
            in_rows(band, width, row_done, |pixel, x, y| {
                if rough[y * width + x] {
                    self.sample(pixel, x, start + y, FEW..MANY);
                }
            })?;
            for (pixel, lamp) in band.iter().map(Samples::mean) {
                picture.pixels.push(pixel);
                picture.lamps.push(lamp);
            }
        }
        Ok(picture)
    }

    /// Adds samples `range` of the pixel at (x, y).
    fn sample(&self, pixel: &mut Samples, x: usize, y: usize, range: std::ops::Range<u32>) {
        for k in range {
            let point = DVec2::new(x as f64, y as f64) + stratified(k);
            let hit = self.tracer.closest_hit(&self.lens.ray(point));
            pixel.add(hit.and_then(|hit| self.look(point, &hit)).unwrap_or_default());
        }
    }

    /// What a ray that ended at `hit` saw; none where no light comes.
    fn look(&self, point: DVec2, hit: &Hit) -> Option<Seen> {
        let face = hit.face as usize;
        let patch = self.patches.patch_at(face, hit.side, hit.barycentrics)?;
        Some(Seen {
            radiance: self.light.at(patch, hit.barycentrics),
            is_lamp: hit.side == Side::Front && self.tracer.scene().material_of(face).emits(),
            outline: self.outline(point, face, patch),
        })
    }

    /// The factor by which an outline dims a point of the picture.
    fn outline(&self, point: DVec2, face: usize, patch: usize) -> f64 {
        if self.outlines == Outlines::Hidden {
            return 1.0;
        }
        const DARKNESS: f64 = 0.6;
        let [a, b, c] = *self.tracer.corners(face);
        let corners = self.patches.corners(patch).map(|[u, v]| a + (b - a) * u + (c - a) * v);
        let distances =
            [0, 1, 2].map(|k| self.lens.distance_to_line(point, corners[k], corners[(k + 1) % 3]));
        // Half of a line of one pixel lies on this side of the edge; lines of tiny patches would leave nothing else.
        let covered = (1.0 - distances.into_iter().fold(f64::INFINITY, f64::min)).clamp(0.0, 1.0);
        let height: f64 = distances.iter().sum();
        1.0 - DARKNESS * covered * ((height - 2.0) / 8.0).clamp(0.0, 1.0)
    }
}

/// Point k < 16 of a (0,2)-sequence in the unit square (Kollig & Keller 2002), moved to the middle of its cell.
fn stratified(k: u32) -> DVec2 {
    let mut second = 0u32;
    let mut direction = 1u32 << 31;
    let mut bits = k;
    while bits != 0 {
        if bits & 1 == 1 {
            second ^= direction;
        }
        direction ^= direction >> 1;
        bits >>= 1;
    }
    let unit = |x: u32| x as f64 / 2f64.powi(32) + 1.0 / 32.0;
    DVec2::new(unit(k.reverse_bits()), unit(second))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{cut, quad, room, triangles};
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
    fn samples_fall_one_into_each_cell() {
        let cell = |n: f64, k: u32| (stratified(k) * n).floor().to_array().map(|x| x as i32);
        for (n, count) in [(2.0, FEW), (4.0, MANY)] {
            let mut cells: Vec<_> = (0..count).map(|k| cell(n, k)).collect();
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), count as usize);
        }
    }

    #[test]
    fn the_picture_of_a_furnace_is_constant() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.3, Reach::Light);
        let radiance = DMatrix::from_element(patches.len(), 1, 2.0);
        for shading in [Shading::Flat, Shading::Smooth] {
            let options = RenderOptions { shading, ..small() };
            let picture = render(&tracer, &patches, &radiance, &inside(), &options).unwrap();
            assert!(picture.pixels.iter().flatten().all(|x| (x - 2.0).abs() < 1e-6));
            let bytes = picture.to_srgb(picture.exposure());
            assert!(bytes.iter().all(|&b| b == bytes[0] && (180..230).contains(&b)));
        }
    }

    #[test]
    fn nothing_met_is_black_and_right_is_right() {
        // A wall that fills the right half of the picture, seen along -z with y up.
        let wall = quad([0.0, -9.0, 0.0], [9.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
        let lamp = Material::lamp("wall", &[0.0; 3], &[1.0, 2.0, 3.0]);
        let scene = triangles(&wall, &[0, 0], vec![lamp]);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 3.0, Reach::Light);
        let camera =
            Camera { position: DVec3::new(0.0, 0.0, 4.0), target: DVec3::ZERO, up: DVec3::Y, fov: 60.0 };
        let picture = render(&tracer, &patches, &patches.sources(), &camera, &small()).unwrap();
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
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| render(&tracer, &patches, &radiance, &inside(), &small()).unwrap())
        };
        assert_eq!(with(1), with(3));
    }

    #[test]
    fn bands_leave_no_seam() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.3, Reach::Light);
        let radiance = DMatrix::from_fn(patches.len(), 1, |i, _| (i % 7) as f64);
        let view = View::new(&tracer, &patches, &radiance, &inside(), &small());
        let whole = view.picture(&small(), 30).unwrap();
        for rows in [1, 7, 29] {
            assert_eq!(view.picture(&small(), rows).unwrap(), whole, "{rows}");
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
        let picture = render(&tracer, &patches, &radiance, &inside(), &options).unwrap();
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
    fn can_be_cancelled() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.5, Reach::Light);
        let options = RenderOptions { progress: Progress::to(&Stop), ..small() };
        let stopped = render(&tracer, &patches, &patches.sources(), &inside(), &options);
        assert!(matches!(stopped, Err(OutputError::Cancelled(_))));
    }

    #[test]
    fn refuses_impossible_sizes_and_cameras() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.5, Reach::Light);
        let sources = patches.sources();
        for (width, height) in [(0, 30), (40, 0), (40_000, 1), (usize::MAX, usize::MAX), (32768, 4097)] {
            let options = RenderOptions { width, height, ..small() };
            let refused = render(&tracer, &patches, &sources, &inside(), &options);
            assert!(matches!(refused, Err(OutputError::Size { .. })), "{width} x {height}");
        }
        let blind = Camera { fov: 0.0, ..inside() };
        let refused = render(&tracer, &patches, &sources, &blind, &small());
        assert!(matches!(refused, Err(OutputError::Camera)));
    }
}
