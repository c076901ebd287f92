//! Carried light: what lights without area and the sky bring by way of mirrors, metals and glass.
//!
//! Lights shoot rays at these carriers; each that they pass on to a patch brings it its flux. The sky is
//! found by shots too, and by the patch's own cosine-distributed rays that carriers pass on to the outside.
//! Both draw the same rays, counted by area across the ray and solid angle: with density a = N/(π M) of the
//! patch's, where π M is its étendue, and b of the shots each of either kind brings, with the radiance L, the
//! flux
//!
//! L / (a + b)
//!
//! (Veach & Guibas 1995, eq. 14). What goes straight through thin glass is no part of it: shadow rays know
//! that.

use std::f64::consts::PI;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{CHUNK, LightOptions, PARTS, TASK, fields, whole_and_more};
use crate::patches::{Basis, Patches};
use crate::progress::Cancelled;
use crate::scene::triangle;
use crate::trace::sampling::{SEQUENCE_END, Sequence, Stream, uniform_triangle};
use crate::trace::{Destination, Lights, RayHit, SkySampler, Targets, Tint, Tracer};
use crate::transport::exchange::Mass;
use crate::transport::rows::{RAYS_PER_SHOT, Shots};

/// Light by way of carriers.
#[derive(Clone, Debug, PartialEq)]
pub struct CarriedLight {
    /// Irradiance, a part of H₀, N × c, W·m⁻².
    pub irradiance: DMatrix<f64>,
    /// Flux that carriers absorbed on ways that end on patches, per channel, in W by `unit`.
    pub(crate) absorbed: Vec<f64>,
    /// Flux that was given up after too many carriers, the same.
    pub(crate) lost: Vec<f64>,
    /// The unit of area in which both were traced, m².
    pub(crate) unit: f64,
}

/// Carried light, and what tells its noise.
pub struct Measured {
    pub light: CarriedLight,
    /// By how much more irradiance each eighth of the rays found.
    pub more: Vec<DMatrix<f64>>,
}

impl CarriedLight {
    /// Finds it; nothing where nothing carries light.
    pub(crate) fn trace(
        tracer: &Tracer,
        patches: &Patches,
        basis: Basis,
        lights: &Lights,
        options: &LightOptions,
    ) -> Result<Option<Measured>, Cancelled> {
        let Some(targets) = Targets::new(tracer, lights) else { return Ok(None) };
        let rays = options.rays.div_ceil(RAYS_PER_SHOT).clamp(1, SEQUENCE_END);
        let senders = lights.len() + usize::from(lights.sky().is_some());
        let shots = match options.caustics {
            Shots::Shot => (patches.len() as u64 * u64::from(rays)).div_ceil((senders * PARTS) as u64).max(1),
            Shots::Skipped => 0,
        };
        let channels = tracer.scene().channels();
        let per_part = rays.div_ceil(PARTS as u32);
        let mut search = Search {
            tracer,
            patches,
            basis,
            targets,
            lights,
            options,
            per_part,
            shots,
            channels,
            moments: vec![0.0; PARTS * basis.coefficients() * channels * patches.len()],
            absorbed: vec![0.0; channels],
            lost: vec![0.0; channels],
        };
        if let Some(sky) = lights.sky() {
            search.look_into(sky)?;
            search.shoot_from(sky)?;
        }
        (0..lights.len()).try_for_each(|light| search.shoot(light))?;
        options.progress.at("light", 1.0)?;
        Ok(Some(search.finish()))
    }
}

/// All it takes to find carried light, and what was found of it.
struct Search<'a> {
    tracer: &'a Tracer<'a>,
    patches: &'a Patches<'a>,
    basis: Basis,
    targets: Targets,
    lights: &'a Lights,
    options: &'a LightOptions<'a>,
    /// Rays of a patch, and shots of a light, in each part.
    per_part: u32,
    shots: u64,
    channels: usize,
    /// ∫ φ_a H dA: for each patch a row of channels for each part and basis function.
    moments: Vec<f64>,
    absorbed: Vec<f64>,
    lost: Vec<f64>,
}

/// What shots of one task brought.
#[derive(Default)]
struct Found {
    /// Patches, and the weights of their second and third corner.
    places: Vec<(u32, [f64; 2])>,
    /// A value a channel for each place: flux that arrived there, and what carriers took of it.
    arrived: Vec<f64>,
    absorbed: Vec<f64>,
    /// Per channel.
    lost: Vec<f64>,
}

/// How a ray that met a carrier went on.
struct Course {
    end: Destination,
    /// Whether only thin glass stood in its way, and it went straight through.
    is_straight: bool,
}

impl Search<'_> {
    /// Follows a ray over carriers; `left` is multiplied by what they leave of it, per channel.
    #[inline]
    fn follow(&self, met: RayHit, (sequence, point): (Sequence, u32), left: &mut [f64]) -> Course {
        let mut is_straight = true;
        let numbers = |k: u32| sequence.dimensions(point, k + 1);
        let dims = |tint: Tint, _: f64| {
            left.iter_mut().zip(tint.parts()).for_each(|(left, part)| *left *= part);
            left.iter().any(|&left| left > 0.0)
        };
        let end = self.tracer.follow(met, numbers, dims, |before, hit, after| {
            is_straight &= self.tracer.goes_straight(before, hit, after);
        });
        Course { end, is_straight }
    }

    /// Values of a patch: parts × basis functions × channels.
    fn per_patch(&self) -> usize {
        PARTS * self.basis.coefficients() * self.channels
    }

    /// Looks from every patch into the sky.
    fn look_into(&mut self, sky: &SkySampler) -> Result<(), Cancelled> {
        let (each, channels) = (self.per_patch(), self.channels);
        let mut moments = std::mem::take(&mut self.moments);
        let mut absorbed = vec![0.0; CHUNK * channels];
        for (chunk, rows) in moments.chunks_mut(CHUNK * each).enumerate() {
            self.options.progress.at("light", (chunk * CHUNK) as f64 / self.patches.len() as f64)?;
            absorbed.fill(0.0);
            let kept = absorbed.par_chunks_mut(channels);
            rows.par_chunks_mut(each).zip(kept).enumerate().for_each(|(k, (row, kept))| {
                self.look_from(chunk * CHUNK + k, sky, row, kept);
            });
            for kept in absorbed.chunks_exact(channels) {
                self.absorbed.iter_mut().zip(kept).for_each(|(sum, kept)| *sum += kept);
            }
        }
        self.moments = moments;
        Ok(())
    }

    /// Looks from one patch into the sky.
    fn look_from(&self, patch: usize, sky: &SkySampler, row: &mut [f64], kept: &mut [f64]) {
        let per_part = self.per_part;
        let slot = self.patches.slot_of_patch(patch);
        let facet = self.patches.facet(self.tracer, slot);
        let own = (per_part as usize * PARTS) as f64 / (PI * self.patches.normalised_etendues()[patch]);
        let mut left = vec![1.0; self.channels];
        let of_part = row.len() / PARTS;
        for (part, row) in row.chunks_exact_mut(of_part).enumerate() {
            let (sequence, points) =
                Stream::CarriedSky.stretch(self.options.seed, slot, part as u64, per_part);
            for (ray, point) in facet.rays(sequence, points.clone()).zip(points) {
                // Follow what meets a carrier to where it leaves the scene.
                let Some(hit) = self.tracer.closest_hit(&ray) else { continue };
                if !self.tracer.may_go_on(hit.face) {
                    continue;
                }
                left.fill(1.0);
                let Course { end: Destination::Away(last), is_straight: false } =
                    self.follow(RayHit { ray, hit }, (sequence, point), &mut left)
                else {
                    continue;
                };
                // Share its flux with the shots that could have come the other way.
                let shots = (self.shots * PARTS as u64) as f64;
                let density = shots * self.targets.sky_density(self.tracer, sky, last.from, last.direction);
                let flux = 1.0 / (own + density);
                let beam = sky.from(last.direction);
                let [s, t, ..] = sequence.point(point);
                let at = uniform_triangle([s, t]);
                for (c, (left, kept)) in left.iter_mut().zip(&mut *kept).enumerate() {
                    let flux = flux * beam.weight * beam.tint(c) * sky.zenith()[c];
                    *kept += flux * (1.0 - *left);
                    *left *= flux;
                }
                add(row, self.basis, at, &left);
            }
        }
    }

    /// Shoots from a light.
    fn shoot(&mut self, light: usize) -> Result<(), Cancelled> {
        let count = (self.shots * PARTS as u64) as f64;
        let power = self.lights.power(light).to_vec();
        let one = |search: &Self, random: [f64; 4], flux: &mut [f64]| {
            let shot = search.targets.shot(search.tracer, search.lights, light, random)?;
            flux.iter_mut().zip(&power).for_each(|(flux, power)| *flux = power * shot.worth / count);
            Some((shot.met, 0.0))
        };
        self.shoot_all((Stream::LightShots, light as u32), one)
    }

    /// Shoots from the sky.
    fn shoot_from(&mut self, sky: &SkySampler) -> Result<(), Cancelled> {
        let count = (self.shots * PARTS as u64) as f64;
        let one = |search: &Self, random: [f64; 4], flux: &mut [f64]| {
            let shot = search.targets.sky_shot(search.tracer, sky, random)?;
            let beam = sky.from(shot.beam.direction);
            let radiance =
                sky.zenith().iter().enumerate().map(|(c, zenith)| zenith * beam.tint(c) * beam.weight);
            flux.iter_mut().zip(radiance).for_each(|(flux, radiance)| *flux = radiance);
            Some((shot.met, shot.density * count))
        };
        self.shoot_all((Stream::SkyShots, 0), one)
    }

    /// Shoots all parts of the shots of a light: `one(self, random, flux)` gives a ray, the carrier that it
    /// meets and its flux per channel; or in the place of this radiance, and the density of such shots.
    fn shoot_all(
        &mut self,
        (stream, offset): (Stream, u32),
        one: impl Fn(&Self, [f64; 4], &mut [f64]) -> Option<(RayHit, f64)> + Sync,
    ) -> Result<(), Cancelled> {
        let (each, channels) = (self.per_patch(), self.channels);
        let of_part = each / PARTS;
        for part in 0..PARTS {
            self.options.progress.at("light", part as f64 / PARTS as f64)?;
            for block in 0..self.shots.div_ceil(u64::from(SEQUENCE_END)) {
                let begin = block * u64::from(SEQUENCE_END);
                let points = (self.shots - begin).min(u64::from(SEQUENCE_END)) as u32;
                let index = block * PARTS as u64 + part as u64;
                let sequence = stream.sequence(self.options.seed, offset, index);
                let task = |k: u32| self.task(sequence, k * TASK..points.min((k + 1) * TASK), &one);
                let found: Vec<Found> = (0..points.div_ceil(TASK)).into_par_iter().map(task).collect();
                // Sum up in a fixed order.
                for found in found {
                    let values =
                        found.arrived.chunks_exact(channels).zip(found.absorbed.chunks_exact(channels));
                    for (&(patch, at), (arrived, kept)) in found.places.iter().zip(values) {
                        let start = patch as usize * each + part * of_part;
                        add(&mut self.moments[start..start + of_part], self.basis, at, arrived);
                        self.absorbed.iter_mut().zip(kept).for_each(|(sum, kept)| *sum += kept);
                    }
                    self.lost.iter_mut().zip(&found.lost).for_each(|(sum, lost)| *sum += lost);
                }
            }
        }
        Ok(())
    }

    /// Follows some shots of a part.
    fn task(
        &self,
        sequence: Sequence,
        points: std::ops::Range<u32>,
        one: impl Fn(&Self, [f64; 4], &mut [f64]) -> Option<(RayHit, f64)>,
    ) -> Found {
        let mut found = Found { lost: vec![0.0; self.channels], ..Found::default() };
        let (mut flux, mut left) = (vec![0.0; self.channels], vec![1.0; self.channels]);
        for point in points {
            let Some((met, density)) = one(self, sequence.point(point), &mut flux) else { continue };
            left.fill(1.0);
            let course = self.follow(met, (sequence, point), &mut left);
            match course.end {
                Destination::Diffuse { hit, .. } if !course.is_straight => {
                    let place = self.patches.patch_at(hit.face as usize, hit.side, hit.barycentrics);
                    let Some(patch) = place else { continue };
                    // Share the flux of the sky with the patch's own rays.
                    if density > 0.0 {
                        let own = (self.per_part as usize * PARTS) as f64
                            / (PI * self.patches.normalised_etendues()[patch]);
                        flux.iter_mut().for_each(|flux| *flux /= own + density);
                    }
                    let slot = self.patches.slot_of_patch(patch);
                    let at = match self.basis {
                        Basis::Constant => [0.0; 2],
                        Basis::Linear => self.patches.weights_in(slot, hit.barycentrics),
                    };
                    found.places.push((patch as u32, at));
                    found.arrived.extend(flux.iter().zip(&left).map(|(flux, left)| flux * left));
                    found.absorbed.extend(flux.iter().zip(&left).map(|(flux, left)| flux * (1.0 - left)));
                }
                Destination::Lost if density == 0.0 => {
                    found.lost.iter_mut().zip(&flux).for_each(|(sum, flux)| *sum += flux);
                }
                _ => {}
            }
        }
        found
    }

    /// Makes irradiance of moments: of all parts, and by how much more each found.
    fn finish(self) -> Measured {
        let mass = Mass::of(self.basis, self.patches);
        let parts = fields(&self.moments, PARTS, self.channels, (&mass, 1.0)).collect();
        let (irradiance, more) = whole_and_more(parts);
        let light = CarriedLight { irradiance, absorbed: self.absorbed, lost: self.lost, unit: mass.unit() };
        Measured { light, more }
    }
}

/// Adds flux (per channel) at a point of a patch to its moments, a row of channels per basis function.
#[inline]
fn add(moments: &mut [f64], basis: Basis, at: [f64; 2], flux: &[f64]) {
    let mut add = |a: usize, phi: f64| {
        let row = &mut moments[a * flux.len()..][..flux.len()];
        row.iter_mut().zip(flux).for_each(|(sum, flux)| *sum += phi * flux);
    };
    match basis {
        Basis::Constant => add(0, 1.0),
        Basis::Linear => triangle::weights(at).into_iter().enumerate().for_each(|(a, phi)| add(a, phi)),
    }
}
