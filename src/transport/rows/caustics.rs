//! Caustics: light shot from lamps through mirrors and glass.
//!
//! Between a patch i and a lamp patch j light sampling knows what is straight ahead; what goes by way of
//! carriers is known from rays that reach j from i, each worth A_i/N of S_ij. Where i is small or lies in the
//! focus of a lens these are few and noisy. So j shoots M rays of its own; each that reaches i by way of
//! carriers is worth A_j/M. The variance of either estimate is S_ij times the worth of one ray, so that with
//! weights inverse to it every ray of either kind counts
//!
//! 1 / (N/A_i + M/A_j).

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::landing::{Spot, end_of};
use super::recipe::{BATCHES, RAYS_PER_SHOT, Setting};
use super::tones::Survivors;
use crate::patches::Basis;
use crate::progress::{Cancelled, Progress};
use crate::trace::sampling::{self, Stream};

/// A ray from a lamp that reached a patch by way of carriers.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Caustic {
    /// The slot that it reached.
    pub receiver: u32,
    /// The lamp patch's slot.
    pub lamp: u32,
    pub batch: u16,
    /// The tones in which it did.
    pub survivors: Survivors,
    /// Where on the receiver and on the lamp patch it ends; of no account for constant elements.
    pub ends: [Spot; 2],
}

/// The rays from lamps that reached patches by way of carriers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Caustics {
    /// Rays M that each lamp patch sent; 0 where there is no lamp or no carrier.
    shots: u32,
    /// By receiver, then lamp.
    found: Vec<Caustic>,
}

impl Caustics {
    /// Whether they lead from slot to slot.
    pub fn are_of(&self, is_slot: impl Fn(u32) -> bool) -> bool {
        let is_sound =
            |one: &Caustic| is_slot(one.receiver) && is_slot(one.lamp) && u32::from(one.batch) < BATCHES;
        self.found.iter().all(is_sound)
            && self.found.is_sorted_by_key(|one| (one.receiver, one.lamp))
            && (self.shots > 0 || self.found.is_empty())
    }

    /// Shoots from all lamp slots; `is_lamp` tells of any slot whether it is one.
    pub fn trace(
        setting: &Setting,
        lamps: &[u32],
        is_lamp: impl Fn(u32) -> bool + Sync,
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        let &Setting { tracer, patches, recipe, .. } = setting;
        if lamps.is_empty() || !tracer.has_carriers() {
            return Ok(Self::default());
        }
        progress.at("trace", 0.0)?;
        let all = u64::from(recipe.count.rays) * patches.len() as u64 / u64::from(RAYS_PER_SHOT);
        let per_batch = all / lamps.len() as u64 / u64::from(BATCHES);
        let per_batch = per_batch.clamp(1, u64::from(sampling::SEQUENCE_END)) as u32;
        let shoot = |&lamp: &u32| {
            let facet = patches.facet(tracer, lamp);
            let mut found = Vec::new();
            for batch in 0..BATCHES as u16 {
                let (sequence, points) =
                    Stream::LampShots.stretch(recipe.seed, lamp, u64::from(batch), per_batch);
                for (ray, point) in facet.rays(sequence, points.clone()).zip(points) {
                    let (end, survivors, hit) = end_of(setting, &ray, (sequence, point));
                    let receiver = end.slot().filter(|&slot| end.is_carried() && !is_lamp(slot));
                    if let Some((receiver, hit)) = receiver.zip(hit) {
                        let ends = match recipe.basis {
                            Basis::Constant => [Spot::default(); 2],
                            Basis::Linear => {
                                let [s, t, ..] = sequence.point(point);
                                [
                                    patches.weights_in(receiver, hit.barycentrics),
                                    sampling::uniform_triangle([s, t]),
                                ]
                                .map(Spot::at)
                            }
                        };
                        found.push(Caustic { receiver, lamp, batch, survivors, ends });
                    }
                }
            }
            found
        };
        let mut found: Vec<Caustic> = lamps.par_iter().flat_map_iter(shoot).collect();
        found.sort_by_key(|caustic| (caustic.receiver, caustic.lamp));
        Ok(Self { shots: BATCHES * per_batch, found })
    }

    /// Puts together what was found before.
    pub fn from_parts(shots: u32, found: Vec<Caustic>) -> Self {
        Self { shots, found }
    }

    /// M, and everything found.
    pub fn parts(&self) -> (u32, &[Caustic]) {
        (self.shots, &self.found)
    }

    /// What was found of one receiver in a tone, less what was found by batch `left_out`.
    pub fn of(&self, receiver: u32, tone: usize, left_out: Option<u32>) -> impl Iterator<Item = &Caustic> {
        let start = self.found.partition_point(|caustic| caustic.receiver < receiver);
        let end = self.found.partition_point(|caustic| caustic.receiver <= receiver);
        let counts = move |caustic: &&Caustic| {
            Some(u32::from(caustic.batch)) != left_out && caustic.survivors.contain(tone)
        };
        self.found[start..end].iter().filter(counts)
    }

    /// What a ray of either kind between a receiver and a lamp patch is worth, by their areas: N of the
    /// receiver's `rays` and the lamp's M count, less those of batches that are left out.
    pub fn worth(&self, [receiver, lamp]: [f64; 2], rays: f64, batches: u32) -> f64 {
        let shots = f64::from(self.shots / BATCHES * batches);
        1.0 / (rays / receiver + shots / lamp)
    }
}
