//! Carried: which slots lights without area and the sky reach by way of mirrors, metals and glass.

use rayon::prelude::*;

use super::sides::LOOK;
use crate::patches::Patches;
use crate::trace::sampling::{SEQUENCE_END, Stream};
use crate::trace::{Destination, Lights, Targets, Tint, Tracer};

/// Shots from each light for every slot, and the fewest.
const SHOTS: u64 = 16;
const FEWEST: u64 = 1 << 16;

impl Patches<'_> {
    /// Marks the slots that are lit by way of carriers. What little is missed here counts as dark, unless
    /// light from other surfaces reaches it.
    pub(crate) fn shine_by_carriers(&self, tracer: &Tracer, lights: &Lights, seed: u64, lit: &mut [bool]) {
        let Some(targets) = Targets::new(tracer, lights) else { return };
        let passes = |colour: Tint, _: f64| colour.parts().any(|part| part > 0.0);
        // Look into the sky from slots that are dark so far.
        if let Some(sky) = lights.sky() {
            lit.par_iter_mut().enumerate().filter(|(_, lit)| !**lit).for_each(|(slot, lit)| {
                let facet = self.facet(tracer, slot as u32);
                if tracer.is_carrier(facet.face) {
                    return;
                }
                let sequence = Stream::SkyLooks.sequence(seed, slot as u32, 0);
                *lit = facet.rays(sequence, 0..LOOK).zip(0..).any(|(ray, point)| {
                    let numbers = |k: u32| sequence.dimensions(point, k + 1);
                    match tracer.destination(&ray, numbers, passes) {
                        Destination::Away(last) => sky.share_from(last.direction) > 0.0,
                        _ => false,
                    }
                });
            });
        }
        // Shoot from the lights.
        let shots = (SHOTS * lit.len() as u64).max(FEWEST);
        for light in 0..lights.len() {
            let landing = |shot: u64| {
                let (block, point) =
                    (shot / u64::from(SEQUENCE_END), (shot % u64::from(SEQUENCE_END)) as u32);
                let sequence = Stream::ReachingShots.sequence(seed, light as u32, block);
                let shot = targets.shot(tracer, lights, light, sequence.point(point))?;
                let numbers = |k: u32| sequence.dimensions(point, k + 1);
                match tracer.follow(shot.met, numbers, passes, |_, _, _| {}) {
                    Destination::Diffuse { hit, .. } => {
                        Some(self.slot_at(hit.face as usize, hit.side, hit.barycentrics))
                    }
                    _ => None,
                }
            };
            let landings: Vec<u32> = (0..shots).into_par_iter().filter_map(landing).collect();
            landings.into_iter().for_each(|slot| lit[slot as usize] = true);
        }
    }
}
