//! Receivers: rows without columns, the irradiance of points that are no patches.
//!
//! Each point sends cosine-distributed rays and looks straight at lamps, at apertures and at what is much
//! brighter than most; ways of drawing a direction are joined by heuristics (Veach & Guibas 1995, eq. 14 and
//! 16). Such rays find the sky by way of mirrors, metals and glass, too; what lights without area send
//! that way is caught as it crosses the cell around a point. What comes of it is a row of form factors to
//! patches, which any radiance on them turns into irradiance.
//!
//! Rays come in batches, each with a scrambling of its own, and their spread tells the noise.

mod crossings;
mod point;
mod size;

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::LightOptions;
use crate::patches::{Basis, BrightParts, Patches};
use crate::progress::Cancelled;
use crate::scene::Receiver;
use crate::trace::sampling::SEQUENCE_END;
use crate::trace::{Lamps, Lights, Tracer};
use crate::transport::rows::Tones;
use crate::transport::variance_of_mean;
use crossings::add_crossings;
use point::{Found, Gather, PLANES};
pub use size::check_receivers;
pub(crate) use size::receiver_bytes;

/// Points between two reports of progress.
const CHUNK: usize = 1024;

/// Batches of a point's rays; a number. Chosen, not fitted: the spread of so many is known to a fifth.
const BATCHES: u32 = 16;

/// The most rays of a point where there are few points, a number; and the part of all rays of patches that
/// those of receivers may come to then. Chosen, not fitted.
const MOST_RAYS: u32 = 8192;
const PART_OF_ALL: f64 = 0.25;

/// Form factors from the points of a receiver to patches, and what lights without area bring them.
#[derive(Clone, Debug)]
pub struct ReceiverRows {
    tones: Tones,
    /// Per point and tone: coefficients and form factors.
    rows: Vec<Vec<Vec<(u32, f64)>>>,
    /// H₀, m × c, W·m⁻².
    direct: DMatrix<f64>,
    noise: ReceiverNoise,
    rays: u32,
}

/// Samples of the noise of a receiver's own rays, under the radiance for which its rows were traced.
#[derive(Clone, Debug)]
pub struct ReceiverNoise {
    /// By how much more each batch of a point's rays finds by itself, m × c, W·m⁻².
    rays: Vec<DMatrix<f64>>,
    /// The same of light that crosses cells; none where there is none.
    crossings: Vec<DMatrix<f64>>,
}

impl ReceiverNoise {
    /// The variance of a linear function of the points' irradiance (m × c, W·m⁻²), in the square of its unit.
    pub fn variance(&self, of: impl Fn(&DMatrix<f64>) -> f64) -> f64 {
        variance_of_mean(&self.rays, &of) + variance_of_mean(&self.crossings, &of)
    }
}

/// What a receiver measures.
#[derive(Clone, Debug)]
pub struct Received<'a> {
    /// The receiver.
    pub receiver: &'a Receiver,
    /// Its rows.
    pub rows: ReceiverRows,
    /// Irradiance of its points, m × c, W·m⁻².
    pub irradiance: DMatrix<f64>,
}

impl<'a> Received<'a> {
    /// What a receiver measures where surfaces send out this radiance (N × c, W·sr⁻¹·m⁻²).
    ///
    /// # Errors
    /// `Cancelled`.
    ///
    /// # Panics
    /// If `radiance` is no field over the patches.
    pub fn trace(
        tracer: &Tracer,
        patches: &Patches,
        radiance: &DMatrix<f64>,
        receiver: &'a Receiver,
        options: &LightOptions,
    ) -> Result<Self, Cancelled> {
        let rows = ReceiverRows::trace(tracer, patches, radiance, receiver, options)?;
        let irradiance = rows.irradiance(radiance);
        Ok(Self { receiver, rows, irradiance })
    }
}

impl ReceiverRows {
    /// Traces the rows of a receiver's m points, at least `options.rays` rays each, and more where it has few
    /// points. Rays look for what is bright by `radiance` (N × c, W·sr⁻¹·m⁻²), and it is for this that their
    /// noise is told; but the rows hold for any.
    ///
    /// # Errors
    /// `Cancelled`.
    ///
    /// # Panics
    /// If `radiance` is no field over the patches.
    pub fn trace(
        tracer: &Tracer,
        patches: &Patches,
        radiance: &DMatrix<f64>,
        receiver: &Receiver,
        options: &LightOptions,
    ) -> Result<Self, Cancelled> {
        let points: Vec<DVec3> = receiver.points().map(|p| tracer.frame().from_world(p)).collect();
        let channels = tracer.scene().channels();
        let basis = Basis::of(patches, radiance);
        let lamps = Lamps::new(tracer);
        let gather = Gather {
            tracer,
            patches,
            basis,
            bright: BrightParts::new(tracer, patches, &basis.means(radiance), &lamps),
            lamps,
            lights: Lights::new(tracer),
            measure: receiver.measure,
            front: receiver.front(),
            maintenance: receiver.maintenance,
            rays: rays_of(points.len(), patches.len(), options.rays),
            seed: options.seed,
            tones: Tones::of(tracer.scene()),
            radiance,
        };
        let mut found: Vec<Found> = Vec::with_capacity(points.len());
        for (chunk, points) in points.chunks(CHUNK).enumerate() {
            options.progress.at("receive", found.len() as f64 / receiver.len() as f64)?;
            let work = points.par_iter().enumerate();
            found.par_extend(work.map(|(k, &point)| gather.at(point, (chunk * CHUNK + k) as u32)));
        }
        let batch = |b: usize| {
            let more = |i: usize, c: usize| {
                let of_channel = |b: usize| found[i].batches[b * channels + c];
                let mean = (0..BATCHES as usize).map(of_channel).sum::<f64>() / f64::from(BATCHES);
                of_channel(b) - mean
            };
            DMatrix::from_fn(points.len(), channels, more)
        };
        let rays = (0..BATCHES as usize).map(batch).collect();
        let mut direct = DMatrix::from_fn(points.len(), channels, |i, c| found[i].direct[c]);
        let crossings = match &gather.lights {
            Some(lights) => add_crossings(tracer, lights, receiver, options, &mut direct)?,
            None => Vec::new(),
        };
        options.progress.at("receive", 1.0)?;
        let rows = found.into_iter().map(|found| found.rows).collect();
        Ok(Self {
            tones: gather.tones,
            direct,
            rows,
            noise: ReceiverNoise { rays, crossings },
            rays: gather.rays,
        })
    }

    /// Irradiance H = H₀ + πFL of the points under radiance L (N × c), m × c, W·m⁻².
    ///
    /// # Panics
    /// If `radiance` has not the channels of the scene, or too few rows.
    pub fn irradiance(&self, radiance: &DMatrix<f64>) -> DMatrix<f64> {
        &self.direct + self.from_surfaces(radiance)
    }

    /// What of it comes from surfaces, πFL.
    ///
    /// # Panics
    /// As [`ReceiverRows::irradiance`].
    pub fn from_surfaces(&self, radiance: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.rows.len(), self.direct.ncols(), |i, c| {
            let tone = self.tones.of_channel(c);
            PI * self.rows[i][tone].iter().map(|&(j, f)| f * radiance[(j as usize, c)]).sum::<f64>()
        })
    }

    /// Rays of each point.
    pub fn rays(&self) -> u32 {
        self.rays
    }

    /// The noise of these rays.
    pub fn noise(&self) -> &ReceiverNoise {
        &self.noise
    }
}

/// Rays of each of so many points, where patches have so many each.
pub(crate) fn rays_of(points: usize, patches: usize, rays: u32) -> u32 {
    let affordable = PART_OF_ALL * patches as f64 * f64::from(rays) / points as f64;
    let most = MOST_RAYS.max(rays).min(BATCHES * SEQUENCE_END);
    rays.max(affordable.min(f64::from(most)) as u32)
        .clamp(BATCHES * PLANES, most)
        .next_multiple_of(BATCHES * PLANES)
}
