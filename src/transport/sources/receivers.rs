//! Receivers: rows without columns, the irradiance of points that are no patches.
//!
//! Each point sends cosine-distributed rays and looks straight at lamps; the two are joined by the balance
//! heuristic (Veach & Guibas 1995, eq. 14). Such rays find the sky by way of mirrors, metals and glass, too;
//! what lights without area send that way is caught as it crosses the cell around a point. What comes of it
//! is a row of form factors to patches, which any radiance on them turns into irradiance.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::LightOptions;
use super::crossings::add_crossings;
use crate::patches::{Basis, Patches};
use crate::progress::Cancelled;
use crate::scene::triangle;
use crate::scene::{Receiver, Side};
use crate::trace::sampling::{Stream, cosine_hemisphere, frame_around};
use crate::trace::{Destination, Interaction, Lamps, Lights, Ray, RayHit, Tint, Tracer, geometry_term};
use crate::transport::rows::Tones;

/// Points between two reports of progress.
const CHUNK: usize = 1024;

/// Form factors from the points of a receiver to patches, and what lights without area bring them.
#[derive(Clone, Debug)]
pub struct ReceiverRows {
    tones: Tones,
    /// Per point and tone: coefficients and form factors.
    rows: Vec<Vec<Vec<(u32, f64)>>>,
    /// H₀, m × c, W·m⁻².
    direct: DMatrix<f64>,
}

impl ReceiverRows {
    /// Traces the rows of a receiver's m points, `options.rays` rays each.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn trace(
        tracer: &Tracer,
        patches: &Patches,
        basis: Basis,
        receiver: &Receiver,
        options: &LightOptions,
    ) -> Result<Self, Cancelled> {
        let points: Vec<DVec3> = receiver.points().map(|p| tracer.frame().from_world(p)).collect();
        let channels = tracer.scene().channels();
        let gather = Gather {
            tracer,
            patches,
            basis,
            lamps: Lamps::new(tracer),
            lights: Lights::new(tracer),
            normal: receiver.normal(),
            rays: options.rays.clamp(1, crate::trace::sampling::SEQUENCE_END),
            seed: options.seed,
            tones: Tones::of(tracer.scene()),
        };
        let mut rows = Vec::with_capacity(points.len());
        let mut direct = vec![0.0; points.len() * channels];
        let chunks = points.chunks(CHUNK).zip(direct.chunks_mut(CHUNK * channels));
        for (chunk, (points, direct)) in chunks.enumerate() {
            options.progress.at("receive", rows.len() as f64 / receiver.len() as f64)?;
            let work = points.par_iter().zip(direct.par_chunks_mut(channels)).enumerate();
            let found = work.map(|(k, (&point, direct))| {
                let place = (chunk * CHUNK + k) as u32;
                gather.add_direct(point, place, direct);
                gather.row(point, place, direct)
            });
            rows.par_extend(found);
        }
        if let Some(lights) = &gather.lights {
            add_crossings(tracer, lights, receiver, options, &mut direct)?;
        }
        options.progress.at("receive", 1.0)?;
        let direct = DMatrix::from_row_slice(points.len(), channels, &direct);
        Ok(Self { tones: gather.tones, direct, rows })
    }

    /// Irradiance H = H₀ + πFL of the points under radiance L (N × c), m × c, W·m⁻².
    ///
    /// # Panics
    /// If `radiance` has not the channels of the scene, or too few rows.
    pub fn irradiance(&self, radiance: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.rows.len(), self.direct.ncols(), |i, c| {
            let tone = self.tones.of_channel(c);
            let around: f64 = self.rows[i][tone].iter().map(|&(j, f)| f * radiance[(j as usize, c)]).sum();
            self.direct[(i, c)] + PI * around
        })
    }
}

/// All it takes to trace the row of a point.
struct Gather<'a, 's> {
    tracer: &'a Tracer<'s>,
    patches: &'a Patches<'s>,
    basis: Basis,
    lamps: Lamps,
    lights: Option<Lights>,
    normal: DVec3,
    rays: u32,
    seed: u64,
    tones: Tones,
}

/// A point of a face's side.
#[derive(Clone, Copy)]
struct FacePoint {
    face: usize,
    side: Side,
    barycentrics: [f64; 2],
}

impl Gather<'_, '_> {
    /// The row of a point, for each tone; adds what its rays find of the sky by way of carriers to its direct
    /// light.
    fn row(&self, point: DVec3, place: u32, direct: &mut [f64]) -> Vec<Vec<(u32, f64)>> {
        let view = self.lamps.view_from(point, (&[point], self.normal));
        let frame = frame_around(self.normal);
        let rays = f64::from(self.rays);
        // Density of all samples on a lamp's point, per unit of normalised area: rays find it with density g,
        // lamp samples with p.
        let share = |g: f64, p: f64| g / (rays * (g + p));
        let mut rows = vec![Vec::new(); self.tones.len()];
        let mut colour = vec![1.0; self.tones.len()];
        let (sequence, points) = Stream::Receivers.stretch(self.seed, place, 0, self.rays);
        for k in points {
            let [x, y, u, v] = sequence.point(k);
            let direction = frame * cosine_hemisphere([x, y]);
            let ray = Ray { origin: point, direction, from: Ray::FREE };
            // By way of carriers too, dimmed in each tone.
            colour.fill(1.0);
            let numbers = |carrier: u32| sequence.dimensions(k, carrier + 1);
            let dims = |tint: Tint, _: f64| {
                colour.iter_mut().enumerate().for_each(|(tone, part)| *part *= self.tones.part(tone, tint));
                colour.iter().any(|&part| part > 0.0)
            };
            let mut is_straight = true;
            let end = match self.tracer.closest_hit(&ray) {
                None => Destination::Away(ray),
                Some(hit) if !self.tracer.may_go_on(hit.face) => Destination::Diffuse { hit, carried: false },
                Some(hit) => self.tracer.follow(RayHit { ray, hit }, numbers, dims, |before, hit, after| {
                    is_straight &= self.tracer.goes_straight(before, hit, after);
                }),
            };
            let sky = self.lights.as_ref().and_then(Lights::sky);
            if let (Destination::Away(last), Some(sky), false) = (end, sky, is_straight) {
                let beam = sky.from(last.direction);
                for (c, (sum, zenith)) in direct.iter_mut().zip(sky.zenith()).enumerate() {
                    let part = colour[self.tones.of_channel(c)];
                    *sum += PI * beam.weight * beam.tint(c) * zenith * part / rays;
                }
            }
            if let Destination::Diffuse { hit, carried } = end {
                let face = hit.face as usize;
                let weight = if carried {
                    1.0 / rays
                } else if self.lamps.contains(face, hit.side) {
                    let there = (point + direction * hit.distance, self.tracer.normal(face, hit.side));
                    let g = geometry_term((point, self.normal), there);
                    // What lamp samples can't face is left to rays.
                    if g > 0.0 { share(g, self.lamps.pdf(&view, face)) } else { 1.0 / rays }
                } else {
                    1.0 / rays
                };
                let place = FacePoint { face, side: hit.side, barycentrics: hit.barycentrics };
                for (row, part) in rows.iter_mut().zip(&colour) {
                    self.push(row, place, weight * part);
                }
            }
            let Some(lamp) = self.lamps.sample(&view, [u, v]) else { continue };
            let g = geometry_term((point, self.normal), (lamp.point, lamp.normal));
            if g > 0.0 && self.tracer.unoccluded((point, Ray::FREE), (lamp.point, lamp.face)) {
                let (face, barycentrics) = (lamp.face as usize, lamp.barycentrics);
                let place = FacePoint { face, side: Side::Front, barycentrics };
                for row in &mut rows {
                    self.push(row, place, share(g, lamp.pdf));
                }
            }
        }
        let summed = |mut row: Vec<(u32, f64)>| {
            row.sort_unstable_by_key(|&(j, _)| j);
            let sums = row.chunk_by(|a, b| a.0 == b.0);
            sums.map(|run| (run[0].0, run.iter().map(|&(_, f)| f).sum())).collect()
        };
        rows.into_iter().map(summed).collect()
    }

    /// Adds a form factor to where it belongs: the patch, or its corners.
    fn push(&self, row: &mut Vec<(u32, f64)>, place: FacePoint, weight: f64) {
        let FacePoint { face, side, barycentrics } = place;
        let Some(patch) = self.patches.patch_at(face, side, barycentrics) else { return };
        match self.basis {
            Basis::Constant => row.push((patch as u32, weight)),
            Basis::Linear => {
                let within = self.patches.weights_in(self.patches.slot_of_patch(patch), barycentrics);
                let corners = triangle::weights(within);
                row.extend((0..3).map(|a| (3 * patch as u32 + a, weight * corners[a as usize])));
            }
        }
    }

    fn add_direct(&self, point: DVec3, place: u32, direct: &mut [f64]) {
        let Some(lights) = &self.lights else { return };
        let mut scratch = vec![0.0; direct.len()];
        let (sequence, points) = Stream::ReceiverLights.stretch(self.seed, place, 0, self.rays);
        let place =
            Interaction { face: Ray::FREE, side: Side::Front, point, normal: self.normal, coat: None };
        let sky = lights.sky_over(self.tracer, &[point], self.normal);
        for k in points {
            let [u, v, s, t] = sequence.point(k);
            let mut numbers = [[u, v], [s, t]].into_iter().cycle();
            let mut random = || numbers.next().unwrap_or([u, v]);
            lights.add_irradiance(self.tracer, (&place, sky.as_ref()), &mut random, [direct, &mut scratch]);
        }
        direct.iter_mut().for_each(|h| *h /= f64::from(self.rays));
    }
}
