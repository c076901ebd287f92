//! Rays: the rows of the form factor matrix, as the list of where each patch's rays land.

use rayon::prelude::*;

use crate::patches::Patches;
use crate::progress::{Cancelled, Progress};
use crate::trace::{Tracer, sampling::Sequence};

/// A landing outside of the scene, or on a side that no light reaches.
pub(super) const AWAY: u32 = u32::MAX;

/// The streams of random sequences for rows start here.
const STREAM: u64 = 0;

/// Independent scramblings per row, by whose spread the noise of form factors is measured.
pub(super) const BATCHES: u32 = 8;

/// Where the rays of every patch land: n rows of `per_patch` patch numbers, batch after batch.
#[derive(Clone, Debug)]
pub(super) struct Landings {
    pub per_patch: u32,
    pub patches: Vec<u32>,
}

impl Landings {
    pub fn row(&self, patch: usize) -> &[u32] {
        let per_patch = self.per_patch as usize;
        &self.patches[patch * per_patch..(patch + 1) * per_patch]
    }

    /// Traces the rays of every patch. A side that light turns out to reach after all becomes a patch, and its rays
    /// are traced too.
    pub fn trace(
        tracer: &Tracer,
        patches: &mut Patches,
        per_patch: u32,
        seed: u64,
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        /// Rows between two reports of progress.
        const CHUNK: usize = 256;
        let mut slots: Vec<u32> = (0..patches.len()).map(|i| patches.slot_of_patch(i)).collect();
        let mut landings: Vec<u32> = Vec::new();
        let mut order: Vec<u32> = Vec::new();
        while !slots.is_empty() {
            for chunk in slots.chunks(CHUNK) {
                progress.at("trace", order.len() as f64 / patches.len() as f64)?;
                let first = landings.len();
                landings.resize(first + chunk.len() * per_patch as usize, AWAY);
                landings[first..].par_chunks_mut(per_patch as usize).zip(chunk).for_each(|(row, &slot)| {
                    trace_row(tracer, patches, slot, seed, row);
                });
                order.extend(chunk);
            }
            let traced = &landings[landings.len() - slots.len() * per_patch as usize..];
            slots = newly_reached(patches, &slots, traced, per_patch);
            patches.activate(&slots);
        }
        // Put the rows in the order of patches, and name patches instead of slots.
        let mut row_of_patch = vec![0; patches.len()];
        for (row, &slot) in order.iter().enumerate() {
            row_of_patch[patches.patch_of_slot(slot).unwrap_or(AWAY) as usize] = row;
        }
        let mut sorted = vec![AWAY; landings.len()];
        sorted.par_chunks_mut(per_patch as usize).zip(&row_of_patch).for_each(|(sorted, &row)| {
            let traced = &landings[row * per_patch as usize..(row + 1) * per_patch as usize];
            for (to, &slot) in sorted.iter_mut().zip(traced) {
                *to = if slot == AWAY { AWAY } else { patches.patch_of_slot(slot).unwrap_or(AWAY) };
            }
        });
        progress.at("trace", 1.0)?;
        Ok(Self { per_patch, patches: sorted })
    }
}

/// Fills `row` with the slots on which rays from `slot` land.
fn trace_row(tracer: &Tracer, patches: &Patches, slot: u32, seed: u64, row: &mut [u32]) {
    let share = row.len() as u32 / BATCHES;
    for (batch, row) in row.chunks_mut(share as usize).enumerate() {
        let sequence = Sequence::new(seed, STREAM + slot as u64, batch as u64);
        for (landing, ray) in row.iter_mut().zip(patches.rays_from(tracer, slot, sequence, 0..share)) {
            *landing = match tracer.closest_hit(&ray) {
                Some(hit) => patches.slot_at(hit.face as usize, hit.side, hit.barycentrics),
                None => AWAY,
            };
        }
    }
}

/// The slots that are no patches yet and that the traced rays of patches that send out light landed on.
fn newly_reached(patches: &Patches, slots: &[u32], landings: &[u32], per_patch: u32) -> Vec<u32> {
    let mut found = Vec::new();
    for (&slot, row) in slots.iter().zip(landings.chunks(per_patch as usize)) {
        if patches.is_bright(slot) {
            found.extend(row.iter().filter(|&&s| s != AWAY && patches.patch_of_slot(s).is_none()));
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}
