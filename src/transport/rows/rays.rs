//! Rays: the raw material of form factors, where each patch's rays land.
//!
//! Every patch sends N cosine-distributed rays; each that lands on j is worth F = 1/N there. Rows name slots,
//! not patches: what was traced once stays good when other lamps or reflectances make other slots into
//! patches.

use std::ops::Range;

use rayon::prelude::*;

use super::caustics::Caustics;
use super::lamp_columns::{Look, Seen, look_at_lamps};
use super::landing::{End, Spot, end_of};
use super::recipe::{BATCHES, Recipe, RowOptions, Setting, Shots};
use super::tones::{Survivors, Tones};
use crate::patches::{Basis, Patches};
use crate::progress::{Cancelled, Progress};
use crate::scene::Side;
use crate::trace::sampling::{Sequence, Stream};
use crate::trace::{Lamps, Tracer, sampling};

/// Rows between two reports of progress.
const CHUNK: usize = 256;

/// The lamps that light sampling looks for, and their slots.
struct Goals {
    lamps: Lamps,
    /// Ascending, a range per lamp face.
    slots: Vec<Range<u32>>,
}

impl Goals {
    fn new(tracer: &Tracer, patches: &Patches, recipe: Recipe) -> Self {
        let lamps = Lamps::of_interest(tracer, recipe.count.lamp_rays);
        let slots = lamps.faces().map(|face| patches.slots_of(face as usize, Side::Front)).collect();
        Self { lamps, slots }
    }

    /// What lamps find of patches by way of carriers.
    fn caustics(&self, setting: &Setting, progress: Progress) -> Result<Caustics, Cancelled> {
        let slots = self.slots.iter().cloned().flatten();
        let slots: Vec<u32> = slots.filter(|&slot| setting.patches.is_wanted(slot)).collect();
        Caustics::trace(setting, &slots, |slot| self.contain(slot), progress)
    }

    fn contain(&self, slot: u32) -> bool {
        let after = self.slots.partition_point(|range| range.end <= slot);
        self.slots.get(after).is_some_and(|range| range.start <= slot)
    }
}

/// What left one slot.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub slot: u32,
    /// Where its rays ended, batch after batch.
    pub landings: Vec<End>,
    /// In which tones they did; nothing where there is but one.
    pub survivors: Vec<Survivors>,
    /// Where in these slots they landed; nothing for constant elements.
    pub spots: Vec<Spot>,
    /// What is known of its form factors to lamps. Lamps themselves know only their rays.
    pub lamps: Look,
}

impl Row {
    /// Where rays `first`, `first` + 1, … ended in a tone.
    #[inline]
    pub fn ends(&self, range: Range<usize>, tone: usize) -> impl Iterator<Item = End> {
        range.map(move |k| match self.survivors.get(k) {
            Some(survivors) if !survivors.contain(tone) => End::ABSORBED,
            _ => self.landings[k],
        })
    }
}

/// The rows of all slots that are or were patches, by slot.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    pub recipe: Recipe,
    pub tones: Tones,
    /// The faces that light sampling took as lamps.
    pub lamp_faces: Vec<u32>,
    rows: Vec<Row>,
    pub caustics: Caustics,
}

impl Rows {
    /// Puts rows together that were traced before.
    pub fn new(
        (recipe, tones): (Recipe, Tones),
        lamp_faces: Vec<u32>,
        mut rows: Vec<Row>,
        caustics: Caustics,
    ) -> Self {
        rows.sort_unstable_by_key(|row| row.slot);
        Self { recipe, tones, lamp_faces, rows, caustics }
    }

    /// All rows, by slot.
    pub fn all(&self) -> &[Row] {
        &self.rows
    }

    /// Whether a patch is the front of a face that light sampling took as a lamp.
    pub fn is_lamp(&self, patches: &Patches, i: usize) -> bool {
        let place = patches.place(i);
        place.side == Side::Front && self.lamp_faces.binary_search(&(place.face as u32)).is_ok()
    }

    /// The row of a slot that has one.
    pub fn of(&self, slot: u32) -> Option<&Row> {
        self.rows.binary_search_by_key(&slot, |row| row.slot).ok().map(|k| &self.rows[k])
    }

    /// Traces the rays of every patch. A side that light turns out to reach after all becomes a patch, and
    /// its rays are traced too.
    pub fn trace(tracer: &Tracer, patches: &mut Patches, options: RowOptions) -> Result<Self, Cancelled> {
        let RowOptions { recipe, tones, shots, progress } = options;
        let goals = Goals::new(tracer, patches, recipe);
        let setting = Setting { tracer, patches, recipe, tones: &tones };
        let caustics = match shots {
            Shots::Shot => goals.caustics(&setting, progress)?,
            Shots::Skipped => Caustics::default(),
        };
        let mut rows = Self::new((recipe, tones), goals.lamps.faces().collect(), Vec::new(), caustics);
        rows.complete(tracer, patches, &goals, progress)?;
        Ok(rows)
    }

    /// Makes rows that are good for other lamps or reflectances good for these: traces what is missing.
    pub fn adapt(
        &mut self,
        tracer: &Tracer,
        patches: &mut Patches,
        progress: Progress,
    ) -> Result<(), Cancelled> {
        let goals = Goals::new(tracer, patches, self.recipe);
        let known = self.rows.len();
        if !goals.lamps.faces().eq(self.lamp_faces.iter().copied()) {
            self.lamp_faces = goals.lamps.faces().collect();
            let setting = Setting { tracer, patches, recipe: self.recipe, tones: &self.tones };
            self.caustics = goals.caustics(&setting, progress)?;
            for (done, chunk) in self.rows.chunks_mut(CHUNK).enumerate() {
                progress.at("trace", (done * CHUNK) as f64 / known as f64)?;
                chunk.par_iter_mut().for_each(|row| look_for_lamps(&setting, &goals, row));
            }
        }
        self.complete(tracer, patches, &goals, progress)
    }

    /// Traces the rows of patches that have none, and of those that these reach, to the end.
    fn complete(
        &mut self,
        tracer: &Tracer,
        patches: &mut Patches,
        goals: &Goals,
        progress: Progress,
    ) -> Result<(), Cancelled> {
        // What known rows of bright patches land on is reached too.
        loop {
            let has_row = |&slot: &u32| self.of(slot).is_some();
            let active = (0..patches.len()).map(|i| patches.slot_of_patch(i));
            let (known, missing): (Vec<u32>, Vec<u32>) = active.partition(has_row);
            for (done, chunk) in missing.chunks(CHUNK).enumerate() {
                progress.at("trace", (known.len() + done * CHUNK) as f64 / patches.len() as f64)?;
                let setting = Setting { tracer, patches, recipe: self.recipe, tones: &self.tones };
                let traced = chunk.par_iter().map(|&slot| trace_row(&setting, goals, slot));
                self.rows.par_extend(traced);
            }
            self.rows.sort_unstable_by_key(|row| row.slot);
            let reached = newly_reached(patches, self);
            if reached.is_empty() {
                break;
            }
            patches.activate(&patches.widen(reached));
        }
        progress.at("trace", 1.0)
    }
}

/// Traces what leaves one slot.
fn trace_row(setting: &Setting, goals: &Goals, slot: u32) -> Row {
    let &Setting { tracer, patches, recipe, tones } = setting;
    let facet = patches.facet(tracer, slot);
    let mut landings = Vec::with_capacity(recipe.count.rays as usize);
    let (mut spots, mut survivors) = (Vec::new(), Vec::new());
    for (sequence, points) in stretches(slot, recipe) {
        for (ray, point) in facet.rays(sequence, points.clone()).zip(points) {
            let (end, alive, hit) = end_of(setting, &ray, (sequence, point));
            if tones.len() > 1 {
                survivors.push(alive);
            }
            if recipe.basis == Basis::Linear {
                let there = end.slot().zip(hit).map(|(slot, hit)| patches.weights_in(slot, hit.barycentrics));
                spots.push(there.map_or_else(Spot::default, Spot::at));
            }
            landings.push(end);
        }
    }
    let mut row = Row { slot, landings, survivors, spots, lamps: Look::default() };
    look_for_lamps(setting, goals, &mut row);
    row
}

/// The stretches of random sequences by which a slot sends its rays, one a batch.
fn stretches(slot: u32, Recipe { count, seed, .. }: Recipe) -> impl Iterator<Item = (Sequence, Range<u32>)> {
    let batches = 0..u64::from(BATCHES);
    batches.map(move |batch| Stream::Rays.stretch(seed, slot, batch, count.rays / BATCHES))
}

/// Where in their slot its rays start, in the order of its landings.
pub fn origins(slot: u32, recipe: Recipe) -> impl Iterator<Item = Spot> {
    let points = stretches(slot, recipe).flat_map(|(sequence, range)| range.map(move |k| sequence.point(k)));
    points.map(|[s, t, ..]| Spot::at(sampling::uniform_triangle([s, t])))
}

/// Fills in what a row knows of lamps.
fn look_for_lamps(setting: &Setting, goals: &Goals, row: &mut Row) {
    let &Setting { tracer, patches, recipe, .. } = setting;
    row.lamps = if goals.slots.is_empty() || goals.contain(row.slot) {
        Look::default()
    } else {
        // Light sampling sees what is straight ahead; hits by way of carriers are known from rays alone.
        let straight = |end: End| end.slot().filter(|&slot| !end.is_carried() && goals.contain(slot));
        let batch_size = (recipe.count.rays / BATCHES) as usize;
        let seen = |(k, &end): (usize, &End)| {
            let batch = (k / batch_size) as u32;
            straight(end).map(|slot| (k, Seen { slot, batch, ends: [Spot::default(); 2] }))
        };
        let mut hits: Vec<(usize, Seen)> = row.landings.iter().enumerate().filter_map(seen).collect();
        if recipe.basis == Basis::Linear {
            let origins: Vec<Spot> = origins(row.slot, recipe).collect();
            hits.iter_mut().for_each(|(k, seen)| seen.ends = [origins[*k], row.spots[*k]]);
        }
        let facet = patches.facet(tracer, row.slot);
        let hits = hits.into_iter().map(|(_, seen)| seen);
        look_at_lamps(setting, &goals.lamps, (row.slot, facet), hits)
    };
}

/// The slots that are no patches yet and that the rays of patches that send out light landed on.
fn newly_reached(patches: &Patches, rows: &Rows) -> Vec<u32> {
    let sends = |row: &&Row| patches.patch_of_slot(row.slot).is_some() && patches.is_bright(row.slot);
    let bright = rows.rows.par_iter().filter(sends);
    let mut found: Vec<u32> = bright
        .flat_map_iter(|row| &row.landings)
        .filter_map(|end| end.slot())
        .filter(|&slot| patches.patch_of_slot(slot).is_none() && patches.is_wanted(slot))
        .collect();
    let from_lamps = rows.caustics.parts().1.iter().map(|caustic| caustic.receiver);
    found.extend(from_lamps.filter(|&slot| patches.patch_of_slot(slot).is_none() && patches.is_wanted(slot)));
    found.sort_unstable();
    found.dedup();
    found
}
