//! Rays: the raw material of form factors, where each patch's rays land.
//!
//! Every patch sends N cosine-distributed rays; each that lands on j is worth F = 1/N there.

use rayon::prelude::*;

use super::lamp_columns::{LampShare, lamp_shares};
use crate::patches::Patches;
use crate::progress::{Cancelled, Progress};
use crate::trace::{Lamps, Tracer, sampling::Sequence};

/// A landing outside of the scene, or on a side that no light reaches.
pub(super) const AWAY: u32 = u32::MAX;

/// Where streams of random sequences for rays start.
const STREAM: u64 = 0;

/// Independent scramblings per row, by whose spread the noise of form factors is measured.
pub(super) const BATCHES: u32 = 8;

/// How many rays of each kind a patch sends; multiples of [`BATCHES`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RayCount {
    pub rays: u32,
    pub lamp_rays: u32,
}

/// Where the rays of every patch land.
#[derive(Clone, Debug)]
pub(super) struct Landings {
    pub count: RayCount,
    /// n rows of `count.rays` patch numbers, batch after batch.
    patches: Vec<u32>,
    /// Per patch: what is known of its form factors to lamps. Lamps themselves know only their rays.
    lamp_shares: Vec<Vec<LampShare>>,
    /// Which patches are lamps.
    pub is_lamp: Vec<bool>,
}

/// A row while slots are not yet numbered as patches.
struct Row {
    slot: u32,
    landings: Vec<u32>,
    lamp_shares: Vec<LampShare>,
}

impl Landings {
    /// Where the rays of a patch land, batch after batch; of lamps seen from elsewhere [`Landings::lamp_shares`] knows more.
    pub fn row(&self, patch: usize) -> &[u32] {
        let rays = self.count.rays as usize;
        &self.patches[patch * rays..(patch + 1) * rays]
    }

    /// The form factors from a patch to lamps, in parts.
    pub fn lamp_shares(&self, patch: usize) -> &[LampShare] {
        &self.lamp_shares[patch]
    }

    /// Traces the rays of every patch. A side that light turns out to reach after all becomes a patch, and its rays
    /// are traced too.
    pub fn trace(
        tracer: &Tracer,
        patches: &mut Patches,
        count: RayCount,
        seed: u64,
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        /// Rows between two reports of progress.
        const CHUNK: usize = 256;
        let lamps = Lamps::new(tracer);
        let mut rows: Vec<Row> = Vec::new();
        let mut slots: Vec<u32> = (0..patches.len()).map(|i| patches.slot_of_patch(i)).collect();
        while !slots.is_empty() {
            let first = rows.len();
            for chunk in slots.chunks(CHUNK) {
                progress.at("trace", rows.len() as f64 / patches.len() as f64)?;
                let trace = |&slot: &u32| trace_row(tracer, patches, &lamps, slot, count, seed);
                rows.par_extend(chunk.par_iter().map(trace));
            }
            slots = newly_reached(patches, &rows[first..]);
            patches.activate(&slots);
        }
        rows.sort_unstable_by_key(|row| row.slot);
        // Every slot with a row is a patch by now: the rows are in the order of patches.
        let number =
            |slot: u32| if slot == AWAY { AWAY } else { patches.patch_of_slot(slot).unwrap_or(AWAY) };
        let mut landings = vec![AWAY; rows.len() * count.rays as usize];
        landings.par_chunks_mut(count.rays as usize).zip(&mut rows).for_each(|(to, row)| {
            to.iter_mut().zip(&row.landings).for_each(|(to, &slot)| *to = number(slot));
            row.lamp_shares.iter_mut().for_each(|share| share.patch = number(share.patch));
            row.landings = Vec::new();
        });
        let is_lamp = (0..patches.len()).map(|i| {
            let place = patches.place(i);
            lamps.contains(place.face, place.side)
        });
        let is_lamp = is_lamp.collect();
        let lamp_shares = rows.into_iter().map(|row| row.lamp_shares).collect();
        progress.at("trace", 1.0)?;
        Ok(Self { count, patches: landings, lamp_shares, is_lamp })
    }
}

/// Traces what leaves one slot.
fn trace_row(
    tracer: &Tracer,
    patches: &Patches,
    lamps: &Lamps,
    slot: u32,
    count: RayCount,
    seed: u64,
) -> Row {
    let facet = patches.facet(tracer, slot);
    let mut landings = Vec::with_capacity(count.rays as usize);
    // Landings on lamps, with their batch.
    let mut on_lamps = Vec::new();
    for batch in 0..BATCHES {
        let sequence = Sequence::new(seed, STREAM + slot as u64, batch as u64);
        for ray in facet.rays(sequence, 0..count.rays / BATCHES) {
            let Some(hit) = tracer.closest_hit(&ray) else {
                landings.push(AWAY);
                continue;
            };
            let landing = patches.slot_at(hit.face as usize, hit.side, hit.barycentrics);
            landings.push(landing);
            if lamps.contains(hit.face as usize, hit.side) {
                on_lamps.push((landing, batch));
            }
        }
    }
    let place = patches.slot(slot);
    let lamp_shares = if lamps.is_empty() || lamps.contains(place.face, place.side) {
        Vec::new()
    } else {
        lamp_shares(tracer, patches, lamps, (slot, facet), on_lamps, (count, seed))
    };
    Row { slot, landings, lamp_shares }
}

/// The slots that are no patches yet and that the rays of patches that send out light landed on.
fn newly_reached(patches: &Patches, rows: &[Row]) -> Vec<u32> {
    let bright = rows.iter().filter(|row| patches.is_bright(row.slot));
    let landings = bright.flat_map(|row| &row.landings).copied();
    let mut found: Vec<u32> = landings.filter(|&s| s != AWAY && patches.patch_of_slot(s).is_none()).collect();
    found.sort_unstable();
    found.dedup();
    found
}
