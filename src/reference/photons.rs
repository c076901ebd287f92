//! Photons: light from points and suns by way of mirrors, metals and glass, and light that falls right beside
//! its source, followed forwards to where it lands and from there on.
//!
//! A photon of the first kind starts towards the ball around all carriers, and counts where a carrier is the
//! first thing it meets and turns it. One of the second kind starts in any direction, and counts where it
//! meets a face near its light straight. On every diffuse surface it brings its flux, and goes on with the
//! part ρ of it in a direction of density cos θ/π, or as its coat lets light out. Photons come in batches,
//! the points of one scrambled sequence, whose spread tells the standard error.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use super::PathOptions;
use super::near::near_faces;
use super::walk::{Beyond, CERTAIN, Met, Walker, largest};
use crate::patches::Patches;
use crate::progress::Cancelled;
use crate::scene::Light;
use crate::trace::sampling::{Sampler, Stream, frame_around, uniform_disc};
use crate::trace::{Frame, OUTSIDE, Ray, RayHit, Tracer};

/// Photons of each light in a batch.
const BATCH: u32 = 1024;

/// The fewest batches of a round.
const FEWEST: u64 = 16;

/// What photons brought so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Photons {
    pub batches: u32,
    /// Per patch, then bounce and channel as in a half: sum of batch means, and of their squares.
    pub sums: Vec<[f64; 2]>,
}

impl Photons {
    /// Mean, and its variance.
    pub fn moments(&self, value: usize) -> (f64, f64) {
        let n = f64::from(self.batches).max(1.0);
        let [sum, squares] = self.sums[value];
        let mean = sum / n;
        (mean, ((squares - sum * mean) / (n - 1.0).max(1.0)).max(0.0) / n)
    }
}

/// What throws photons.
#[derive(Debug)]
pub(super) struct Thrower {
    /// Each with the faces near it.
    lights: Vec<(Light, Vec<u32>)>,
    /// The ball around all carriers, if there are any.
    carriers: Option<Ball>,
}

/// A ball, normalised.
#[derive(Clone, Copy, Debug)]
struct Ball {
    centre: DVec3,
    radius: f64,
}

/// Where photons are thrown.
pub(super) struct Throw<'a> {
    pub walker: &'a Walker<'a, 'a>,
    pub patches: &'a Patches<'a>,
    pub options: &'a PathOptions<'a>,
}

/// Which photons of a light count.
#[derive(Clone, Copy)]
enum Aim<'a> {
    /// Those that a carrier turns, aimed at the ball around these.
    Carriers(Ball),
    /// Those that fall on these faces straight.
    Near(&'a [u32]),
}

impl Aim<'_> {
    /// Whether a photon that landed for the first time counts.
    fn counts(self, met: &Met) -> bool {
        match self {
            Self::Carriers(_) => !met.is_straight,
            Self::Near(faces) => met.is_straight && faces.contains(&met.hit.face),
        }
    }
}

impl Ball {
    fn around_carriers(tracer: &Tracer) -> Option<Self> {
        let faces = (0..tracer.scene().faces().len()).filter(|&face| tracer.may_go_on(face as u32));
        let corners: Vec<DVec3> = faces.flat_map(|face| *tracer.corners(face)).collect();
        let low = corners.iter().copied().reduce(DVec3::min)?;
        let high = corners.iter().copied().reduce(DVec3::max)?;
        let centre = 0.5 * (low + high);
        let radius = corners.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        Some(Self { centre, radius })
    }
}

impl Thrower {
    /// That of a scene; none where it has no such lights, or neither something that turns their light nor a
    /// face near one.
    pub fn new(tracer: &Tracer) -> Option<Self> {
        let lights: Vec<_> =
            tracer.scene().lights().map(|light| (light.clone(), near_faces(tracer, light))).collect();
        let carriers = Ball::around_carriers(tracer);
        let throws = carriers.map_or(lights.iter().any(|(_, near)| !near.is_empty()), |_| !lights.is_empty());
        throws.then_some(Self { lights, carriers })
    }

    /// Throws about as many photons as there were paths in a round.
    pub fn throw(&self, job: &Throw, photons: &mut Photons, paths: u64) -> Result<(), Cancelled> {
        let Throw { walker, patches, options } = job;
        let values = (options.bounces + 1) * walker.channels;
        photons.sums.resize(values * patches.len(), [0.0; 2]);
        let batches = (paths / (u64::from(BATCH) * self.lights.len() as u64)).max(FEWEST) as u32;
        let first = photons.batches;
        let mut done = 0;
        while done < batches {
            options.progress.at("reference", 0.999)?;
            let together = (batches - done).min(64);
            let range = first + done..first + done + together;
            let found: Vec<Vec<(usize, f64)>> =
                range.into_par_iter().map(|batch| self.batch(job, batch)).collect();
            for found in found {
                for run in found.chunk_by(|a, b| a.0 == b.0) {
                    let mean: f64 = run.iter().map(|(_, irradiance)| irradiance).sum();
                    let [sum, squares] = &mut photons.sums[run[0].0];
                    *sum += mean;
                    *squares += mean * mean;
                }
            }
            done += together;
        }
        photons.batches += batches;
        Ok(())
    }

    /// What the photons of one batch bring: values and their parts of the mean irradiance, by value.
    fn batch(&self, &Throw { walker, patches, options }: &Throw, batch: u32) -> Vec<(usize, f64)> {
        let channels = walker.channels;
        let values = (options.bounces + 1) * channels;
        let mut found = Vec::new();
        let mut weight = vec![0.0; 2 * channels];
        for (stream, light, aim) in self.sources() {
            let source = &self.lights[light as usize].0;
            let sequence = stream.sequence(options.seed, light, u64::from(batch));
            for point in 0..BATCH {
                let mut numbers = Sampler { sequence, point, set: 0 };
                let (ray, worth) = start(source, aim, walker.tracer.frame(), numbers.next());
                let (weight, scratch) = weight.split_at_mut(channels);
                let worth = worth / f64::from(BATCH);
                weight.iter_mut().zip(source.power()).for_each(|(w, power)| *w = worth * power);
                let arrives = |bounce: usize, met: &Met, flux: &[f64]| {
                    let place = patches.patch_at(met.hit.face as usize, met.hit.side, met.hit.barycentrics);
                    let Some(patch) = place else { return };
                    for (c, flux) in flux.iter().enumerate() {
                        let irradiance = flux / patches.etendue(patch);
                        found.push((patch * values + options.bounces * channels + c, irradiance));
                        if (1..=options.bounces).contains(&bounce) {
                            found.push((patch * values + (bounce - 1) * channels + c, irradiance));
                        }
                    }
                };
                let photon = Photon { ray, aim, longest: options.longest };
                photon.follow(walker, &mut numbers, [weight, scratch], arrives);
            }
        }
        found.sort_by_key(|&(value, _)| value);
        found
    }

    /// The lights by number, each with the stream of its random sequences and an aim.
    fn sources(&self) -> Vec<(Stream, u32, Aim<'_>)> {
        let mut sources = Vec::new();
        for (light, (_, near)) in (0..).zip(&self.lights) {
            if let Some(ball) = self.carriers {
                sources.push((Stream::Photons, light, Aim::Carriers(ball)));
            }
            if !near.is_empty() {
                sources.push((Stream::NearPhotons, light, Aim::Near(near)));
            }
        }
        sources
    }
}

/// A photon of a light: its ray, and its flux per unit of the light's power by the density of such rays, m².
fn start(light: &Light, aim: Aim, frame: &Frame, [u, v, s, t]: [f64; 4]) -> (Ray, f64) {
    // What is near fills half of all directions or more, in a ball around the light.
    let Ball { centre, radius } = match (aim, light.position()) {
        (Aim::Carriers(ball), _) => ball,
        (Aim::Near(_), position) => {
            Ball { centre: position.map_or(DVec3::ZERO, |p| frame.from_world(p)), radius: 1.0 }
        }
    };
    match light {
        Light::Point { position, .. } | Light::Spot { position, .. } | Light::Ies { position, .. } => {
            // Draw evenly from the narrower of two cones: around the ball, or that of the light.
            let origin = frame.from_world(*position);
            let between = centre - origin;
            let sine = radius / between.length();
            let mut axis = between.normalize_or(DVec3::Y);
            let mut height = if sine < 1.0 { 1.0 - (1.0 - sine * sine).sqrt() } else { 2.0 };
            if let Light::Spot { direction, cone, .. } = light {
                let own = 1.0 - cone.to_radians().cos();
                if own < height {
                    (axis, height) = (*direction, own);
                }
            }
            let along = 1.0 - u * height;
            let across = (1.0 - along * along).max(0.0).sqrt();
            let (sine, cosine) = (v * TAU).sin_cos();
            let direction = frame_around(axis) * DVec3::new(across * cosine, across * sine, along);
            let ray = Ray { origin, direction, from: Ray::FREE };
            (ray, TAU * height * light.share_towards(direction))
        }
        Light::Sun { direction, diameter, .. } => {
            // Draw a direction from the disc, and a point of a disc across it that hides the ball.
            let (ball, radius) = (radius, (0.5 * diameter).to_radians());
            let height = 1.0 - s * (1.0 - radius.cos());
            let across = (1.0 - height * height).max(0.0).sqrt();
            let (sine, cosine) = (t * TAU).sin_cos();
            let towards = frame_around(-*direction) * DVec3::new(across * cosine, across * sine, height);
            let [x, y] = uniform_disc([u, v]).map(|x| x * ball);
            let origin = centre + frame_around(towards) * DVec3::new(x, y, OUTSIDE);
            let metres = ball * frame.scale();
            let ray = Ray { origin, direction: -towards, from: Ray::FREE };
            (ray, PI * metres * metres * 2.0 / (1.0 + radius.cos()))
        }
    }
}

/// A photon on its way.
struct Photon<'a> {
    ray: Ray,
    aim: Aim<'a>,
    /// The most reflections.
    longest: Option<usize>,
}

impl Photon<'_> {
    /// Follows a photon to its end: calls `arrives(bounce, met, flux)` wherever it lands.
    fn follow(
        self,
        walker: &Walker,
        numbers: &mut Sampler,
        [weight, scratch]: [&mut [f64]; 2],
        mut arrives: impl FnMut(usize, &Met, &[f64]),
    ) {
        let Self { mut ray, aim, longest } = self;
        if largest(weight) <= 0.0 {
            return;
        }
        for bounce in 0.. {
            let Some(hit) = walker.tracer.closest_hit(&ray) else { return };
            let met = if walker.tracer.may_go_on(hit.face) {
                match walker.beyond_carriers(
                    RayHit { ray, hit },
                    numbers,
                    [&mut *weight, &mut *scratch],
                    |_, _, _| {},
                ) {
                    Beyond::Met(met) => met,
                    Beyond::Away { .. } | Beyond::Nowhere => return,
                }
            } else {
                Met { hit, direction: ray.direction, density: None, is_straight: true }
            };
            // All else is looked for from the other end.
            if bounce == 0 && !aim.counts(&met) {
                return;
            }
            arrives(bounce, &met, weight);
            if longest.is_some_and(|longest| bounce > longest) {
                return;
            }
            // Reflect, and let chance decide whether what is left is worth another step.
            let before = largest(weight);
            let [s, t, chance, way] = numbers.next();
            let place = walker.follow(&met.hit, way, weight);
            let survival = largest(weight) / before;
            if survival == 0.0 || (bounce >= CERTAIN && chance >= survival) {
                return;
            }
            if bounce >= CERTAIN {
                weight.iter_mut().for_each(|w| *w /= survival);
            }
            ray = place.ray(place.direction([s, t]));
        }
    }
}
