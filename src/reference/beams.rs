//! Beams: light from sources without area, as a walk looks for it from each of its places; the path tracer's
//! own way.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;

use super::near::near_faces;
use super::surroundings::Surroundings;
use crate::scene::{Environment, Light, Sky, SkyKind, SkyShares};
use crate::trace::sampling::{cosine_hemisphere, frame_around};
use crate::trace::{IN_PLANE, Interaction, Tracer};

/// All lights without area, and the sky.
#[derive(Debug)]
pub(super) struct Beams<'t> {
    tracer: &'t Tracer<'t>,
    /// Each with the faces near it, to which photons bring its light.
    lights: Vec<(Light, Vec<u32>)>,
    sky: Option<(SkyShares, Sky)>,
    environment: Option<(Arc<Environment>, Surroundings)>,
}

impl<'t> Beams<'t> {
    /// Those of a scene; none where it has none.
    pub fn new(tracer: &'t Tracer) -> Option<Self> {
        let scene = tracer.scene();
        let lights: Vec<_> = scene.lights().map(|light| (light.clone(), near_faces(tracer, light))).collect();
        let sky = scene.sky().map(|sky| (sky.shares(), sky.clone()));
        let environment = match scene.sky().map(|sky| &sky.kind) {
            Some(SkyKind::Environment(around)) => Some((around.clone(), Surroundings::new(around))),
            _ => None,
        };
        (!lights.is_empty() || sky.is_some()).then_some(Self { tracer, lights, sky, environment })
    }

    /// What the sky sends from a direction: a share of the radiance that is left in `radiance` (per channel);
    /// none where there is no sky.
    #[inline]
    pub fn sky_from(&self, towards: DVec3, radiance: &mut [f64]) -> Option<f64> {
        let (shares, sky) = self.sky.as_ref()?;
        let (share, tint) = shares.tinted(towards);
        for (c, (radiance, zenith)) in radiance.iter_mut().zip(&sky.zenith).enumerate() {
            *radiance = zenith * tint.map_or(1.0, |tint| tint[c]);
        }
        Some(share)
    }

    /// Calls `arrives(part, power)` for each part · power (per channel; `scratch` has as many values) of the
    /// irradiance at `place`, straight from lights and sky.
    #[inline]
    pub fn look(
        &self,
        place: &Interaction,
        [u, v, s, t]: [f64; 4],
        scratch: &mut [f64],
        mut arrives: impl FnMut(f64, &[f64]),
    ) {
        let tracer = self.tracer;
        // Dim the power by the glass it comes through.
        let mut look = |part: f64, direction: DVec3, distance: f64, power: &[f64]| {
            let part = part * place.weight(place.normal.dot(direction));
            scratch.copy_from_slice(power);
            if tracer.passes(&place.ray(direction), distance, scratch) {
                arrives(part, scratch);
            }
        };
        for (light, _) in self.lights.iter().filter(|(_, near)| !near.contains(&place.face)) {
            match light {
                Light::Point { position, intensity }
                | Light::Spot { position, intensity, .. }
                | Light::Ies { position, intensity, .. } => {
                    // Go back to metres: intensity · cos θ / r².
                    let between = tracer.frame().from_world(*position) - place.point;
                    let distance = between.length();
                    let direction = between / distance;
                    let metres = distance * tracer.frame().scale();
                    let part =
                        place.normal.dot(direction) * light.share_towards(-direction) / (metres * metres);
                    if place.normal.dot(between) > IN_PLANE && part > 0.0 && part.is_finite() {
                        look(part, direction, distance, intensity);
                    }
                }
                Light::Sun { direction, irradiance, diameter } => {
                    // Draw a direction from the disc, uniform in solid angle; the disc's radiance is E / (π
                    // sin²α).
                    let radius = (0.5 * diameter).to_radians();
                    let height = 1.0 - u * (1.0 - radius.cos());
                    let across = (1.0 - height * height).max(0.0).sqrt();
                    let (sine, cosine) = (v * TAU).sin_cos();
                    let towards =
                        frame_around(-*direction) * DVec3::new(across * cosine, across * sine, height);
                    // Its solid angle by its radiance per irradiance: 2π(1 − cos α) / (π sin²α).
                    let spread = 2.0 / (1.0 + radius.cos());
                    let part = place.normal.dot(towards) * spread;
                    if place.normal.dot(towards) > IN_PLANE {
                        look(part, towards, f64::INFINITY, irradiance);
                    }
                }
            }
        }
        if let Some((environment, surroundings)) = &self.environment {
            let (towards, worth) = surroundings.sample(environment, place.normal, [s, t]);
            let cosine = place.normal.dot(towards);
            let part = worth * cosine;
            let Some((_, sky)) = &self.sky else { return };
            if part > 0.0 {
                let mut colour = environment.from(towards);
                colour.iter_mut().zip(&sky.zenith).for_each(|(x, zenith)| *x *= zenith);
                look(part, towards, f64::INFINITY, &colour[..sky.zenith.len().min(3)]);
            }
        } else if let Some((shares, sky)) = &self.sky {
            let towards = frame_around(place.normal) * cosine_hemisphere([s, t]);
            let part = PI * shares.from(towards);
            if part > 0.0 {
                look(part, towards, f64::INFINITY, &sky.zenith);
            }
        }
    }
}
