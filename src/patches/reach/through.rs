//! Through: which slots sun and sky reach through apertures, and from outside of the scene, and which those
//! lights reach that have a place: what rays of their own find.

use glam::DVec3;
use rayon::prelude::*;

use crate::patches::Patches;
use crate::trace::sampling::{SEQUENCE_END, Stream, uniform_cone, uniform_disc};
use crate::trace::{Destination, Lights, OUTSIDE, Ray, Tint, Tracer};

/// Rays through each triangle of an aperture, from each sun and from the sky; a number. Chosen, not fitted.
const RAYS: u32 = 1024;

/// Rays from each light that has a place, a number. Chosen, not fitted: a narrow spot is wholly filled.
const FROM_A_PLACE: u32 = 4096;

/// Rays from each sun and from the sky on all of the scene; a number. Chosen, not fitted.
const FROM_OUTSIDE: u32 = SEQUENCE_END;

impl Patches<'_> {
    /// Marks the slots that rays of lights and of the sky land on.
    pub(crate) fn shine_through(&self, tracer: &Tracer, lights: &Lights, seed: u64, lit: &mut [bool]) {
        let apertures = tracer.apertures();
        let landing = |ray: Ray, numbers: &dyn Fn(u32) -> [f64; 4]| {
            let passes = |colour: Tint, _: f64| colour.parts().any(|part| part > 0.0);
            match tracer.destination(&ray, numbers, passes) {
                Destination::Diffuse { hit, .. } => {
                    Some(self.slot_at(hit.face as usize, hit.side, hit.barycentrics))
                }
                _ => None,
            }
        };
        let mut land = |count: u32, found: &(dyn Fn(u32) -> Option<u32> + Sync)| {
            let landings: Vec<u32> = (0..count).into_par_iter().filter_map(found).collect();
            landings.into_iter().for_each(|slot| lit[slot as usize] = true);
        };
        for (light, source) in self.scene.lights().enumerate() {
            let Some(position) = source.position() else { continue };
            let (origin, (axis, angle)) = (tracer.frame().from_world(position), source.cone());
            let sequence = Stream::PlacedRays.sequence(seed, light as u32, 0);
            land(FROM_A_PLACE, &|k| {
                let [u, v, ..] = sequence.point(k);
                let direction = uniform_cone(axis, angle, [u, v]);
                let ray = Ray { origin, direction, from: Ray::FREE };
                let numbers = |k2: u32| sequence.dimensions(k, k2 + 1);
                (source.share_towards(direction) > 0.0).then(|| landing(ray, &numbers)).flatten()
            });
        }
        let senders = (0..lights.len()).filter(|&light| lights.is_sun(light)).map(Some);
        let senders = senders.chain(lights.sky().map(|_| None));
        for (number, sun) in senders.enumerate() {
            // A way to the sun, or into the sky.
            let way = |square: [f64; 2], normal: DVec3| match sun {
                Some(sun) => Some(lights.beam(sun, DVec3::ZERO, square).direction),
                None => {
                    let beam = lights.sky()?.sample(normal, square);
                    (beam.weight > 0.0).then_some(beam.direction)
                }
            };
            for opening in 0..apertures.len() {
                let sequence = Stream::ReachingRays.sequence(seed, opening as u32, 2 * number as u64);
                land(RAYS, &|k| {
                    let [s, t, u, v] = sequence.point(k);
                    let (point, outwards) = apertures.point_of(opening, [s, t]);
                    let towards = way([u, v], outwards).filter(|towards| towards.dot(outwards) > 0.0)?;
                    let out = Ray { origin: point, direction: towards, from: Ray::FREE };
                    let mut left = vec![1.0; self.scene.channels()];
                    if !tracer.passes(&out, f64::INFINITY, &mut left) {
                        return None;
                    }
                    landing(Ray { direction: -towards, ..out }, &|k2| sequence.dimensions(k, k2 + 1))
                });
            }
            let sequence = Stream::ReachingRays.sequence(seed, 0, 2 * number as u64 + 1);
            land(FROM_OUTSIDE, &|k| {
                let [s, t, u, v] = sequence.point(k);
                let up = if k % 2 == 0 { DVec3::Y } else { DVec3::NEG_Y };
                let towards = way([u, v], up)?;
                // The scene lies in the cube [-1, 1]³.
                let [x, y] = uniform_disc([s, t]).map(|x| x * 3f64.sqrt());
                let frame = crate::trace::sampling::frame_around(towards);
                let origin = frame * DVec3::new(x, y, OUTSIDE);
                landing(Ray { origin, direction: -towards, from: Ray::FREE }, &|k2| {
                    sequence.dimensions(k, k2 + 1)
                })
            });
        }
    }
}
