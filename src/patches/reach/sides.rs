//! Sides: which slots light can reach, and so become patches.
//!
//! Reached is a flag per slot. Lamps are reached, and what lights without area and the sky shine on; from
//! every reached slot that reflects or emits, light goes on to what its rays meet and to what sees it, until
//! nothing new turns up; where a sheet lets light through, both of its sides are reached at once. What no
//! light reaches costs nothing and stays exactly zero.

use std::ops::Range;

use rayon::prelude::*;

use super::facing::seeing_sides;
use crate::patches::{Patches, Slot, Tessellation};
use crate::progress::Cancelled;
use crate::scene::{Feature, Side};
use crate::trace::sampling::Stream;
use crate::trace::{Arrival, Destination, Lamps, Lights, Ray, Tint, Tracer, geometry_term};

/// Which sides become patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Those that light from the scene's lamps, its lights without area and its sky reaches.
    Light,
    /// Whole sides of faces, lit or not, black or not: all but those that provably see nothing, because
    /// nothing lies in front of their plane. For form factors.
    Everything,
    /// The same of one side of all faces, and whole other sides that are met from there: for form factors of
    /// that side.
    OneSide(Side),
}

/// Rays by which a slot looks around.
pub(crate) const LOOK: u32 = 16;

/// Rays for a first impression.
pub(crate) const GLANCE: u32 = 4;

/// Looks straight at lamps, which are small and easily missed.
const LAMP_LOOKS: u32 = 32;

/// The same where light reaches other slots of the side: a slot at the edge of a shadow may see a small part
/// of a lamp, or a lamp from a small part of it.
const CLOSE_LOOKS: u32 = 256;

/// Looks of a slot: points of a random sequence.
#[derive(Clone)]
struct Looks {
    range: Range<u32>,
    seed: u64,
}

impl Patches<'_> {
    /// Finds the reached slots and makes them patches.
    pub(crate) fn reach(
        &mut self,
        tracer: &Tracer,
        options: &Tessellation,
        rays: u32,
    ) -> Result<(), Cancelled> {
        let found = match options.reach {
            Reach::Light => self.lit(tracer, options, rays, |_| true)?,
            Reach::Everything => self.seeing(tracer, options, &Side::BOTH)?,
            Reach::OneSide(side) => {
                let mut found = self.seeing(tracer, options, &[side])?;
                found.extend(self.look(tracer, &found, rays, options.seed).concat());
                self.widen(found)
            }
        };
        self.activate(&found);
        Ok(())
    }

    /// Makes those slots patches that light reaches among `likely` ones, and what else it happens to meet: a
    /// glance will do where so much is known.
    pub(crate) fn reach_likely(
        &mut self,
        tracer: &Tracer,
        options: &Tessellation,
        likely: &[u32],
    ) -> Result<(), Cancelled> {
        let found = match options.reach {
            Reach::Light => {
                let mut is_likely = vec![false; self.slots()];
                likely.iter().for_each(|&slot| is_likely[slot as usize] = true);
                self.lit(tracer, options, GLANCE, |slot| is_likely[slot as usize])?
            }
            Reach::Everything | Reach::OneSide(_) => self.widen(likely.to_vec()),
        };
        self.activate(&found);
        Ok(())
    }

    /// The slots of all these sides of faces but of those that provably see nothing.
    fn seeing(&self, tracer: &Tracer, options: &Tessellation, sides: &[Side]) -> Result<Vec<u32>, Cancelled> {
        options.progress.at("patch", 0.3)?;
        let mut found = Vec::new();
        for (face, seeing) in seeing_sides(tracer).into_iter().enumerate() {
            let sees = |side: &&Side| seeing[usize::from(**side == Side::Back)];
            sides.iter().filter(sees).for_each(|&side| found.extend(self.slots_of(face, side)));
        }
        Ok(found)
    }

    /// What become patches once these slots are reached: they alone, or the whole sides on which they lie.
    pub(crate) fn widen(&self, mut slots: Vec<u32>) -> Vec<u32> {
        if self.reach != Reach::Light {
            let mut sides: Vec<(usize, Side)> = slots.into_iter().map(|slot| self.side_of(slot)).collect();
            sides.sort_unstable();
            sides.dedup();
            slots = sides.into_iter().flat_map(|(face, side)| self.slots_of(face, side)).collect();
        }
        slots
    }

    /// The slots that light from lamps reaches. Only those look for light themselves that `may_look`.
    fn lit(
        &self,
        tracer: &Tracer,
        options: &Tessellation,
        rays: u32,
        may_look: impl Fn(u32) -> bool,
    ) -> Result<Vec<u32>, Cancelled> {
        let slots = self.slots();
        let (lamps, lights) = (Lamps::new(tracer), Lights::new(tracer));
        let mut seen_by: Vec<Option<Vec<u32>>> = vec![None; slots];
        let [mut reached, mut looked_close] = [0, 1].map(|_| vec![false; slots]);
        let shone_on =
            lights.as_ref().map_or_else(Vec::new, |lights| self.shone_on(tracer, lights, options.seed));
        let starts = |&s: &u32| self.emits(s) || shone_on.get(s as usize).is_some_and(|&lit| lit);
        let mut wave: Vec<u32> = (0..slots as u32).filter(starts).collect();
        wave.iter().for_each(|&s| reached[s as usize] = true);
        loop {
            // Let the newest slots send light on.
            while !wave.is_empty() {
                self.go_through(&mut wave, &mut reached);
                options.progress.at("patch", 0.3)?;
                let looks = self.look(tracer, &wave, rays, options.seed);
                let mut next = Vec::new();
                for (slot, landings) in wave.iter().zip(looks) {
                    let bright = self.is_bright(*slot);
                    for &landing in landings.iter().filter(|_| bright) {
                        if !std::mem::replace(&mut reached[landing as usize], true) {
                            next.push(landing);
                        }
                    }
                }
                wave = next;
            }
            // Let the dark ones look for light; each looks around once and remembers.
            let dark: Vec<u32> = (0..slots as u32)
                .filter(|&s| !reached[s as usize] && may_look(s) && !self.is_covered(s))
                .collect();
            let unasked: Vec<u32> = dark.iter().copied().filter(|&s| seen_by[s as usize].is_none()).collect();
            options.progress.at("patch", 0.6)?;
            let looks = self.look(tracer, &unasked, rays, options.seed);
            let lamp_looks = self.look_at_lamps(
                tracer,
                &lamps,
                &unasked,
                Looks { range: 0..LAMP_LOOKS, seed: options.seed },
            );
            for ((slot, mut landings), on_lamps) in unasked.iter().zip(looks).zip(lamp_looks) {
                landings.extend(on_lamps);
                seen_by[*slot as usize] = Some(landings);
            }
            let sees_light = |slot: u32| {
                let mut landings = seen_by[slot as usize].iter().flatten();
                landings.any(|&landing| reached[landing as usize] && self.is_bright(landing))
            };
            wave = dark.iter().copied().filter(|&slot| sees_light(slot)).collect();
            if wave.is_empty() {
                let mut close = self.on_reached_sides(&dark, &reached);
                close.retain(|&slot| !looked_close[slot as usize]);
                close.iter().for_each(|&slot| looked_close[slot as usize] = true);
                let looks = Looks { range: LAMP_LOOKS..CLOSE_LOOKS, seed: options.seed };
                let on_lamps = self.look_at_lamps(tracer, &lamps, &close, looks.clone());
                let is_shone_on = |&(slot, on_lamp): &(u32, Option<u32>)| {
                    let sees = |lights: &Lights| self.is_shone_on(tracer, lights, slot, looks.clone());
                    on_lamp.is_some() || lights.as_ref().is_some_and(sees)
                };
                let found = close.into_par_iter().zip(on_lamps).filter(is_shone_on);
                wave = found.map(|(slot, _)| slot).collect();
            }
            if wave.is_empty() {
                break;
            }
            wave.iter().for_each(|&s| reached[s as usize] = true);
        }
        Ok((0..slots as u32).filter(|&s| reached[s as usize]).collect())
    }

    /// Of these slots, ascending, those on sides where others are reached.
    fn on_reached_sides(&self, slots: &[u32], reached: &[bool]) -> Vec<u32> {
        let of_sides = slots.chunk_by(|&a, &b| self.side_of(a) == self.side_of(b));
        let is_reached = |of_side: &&[u32]| {
            let (face, side) = self.side_of(of_side[0]);
            self.slots_of(face, side).any(|slot| reached[slot as usize])
        };
        of_sides.filter(is_reached).flatten().copied().collect()
    }

    /// The face and side on which a slot lies.
    fn side_of(&self, slot: u32) -> (usize, Side) {
        let Slot { face, side, .. } = self.slot(slot);
        (face, side)
    }

    /// Lets light through sheets: adds the other sides that it reaches now.
    fn go_through(&self, wave: &mut Vec<u32>, reached: &mut [bool]) {
        let across: Vec<u32> = wave.iter().filter_map(|&slot| self.across(slot)).collect();
        let new = across.into_iter().filter(|&slot| !std::mem::replace(&mut reached[slot as usize], true));
        wave.extend(new);
    }

    /// The slots on which a few rays from each of `slots` land, each once.
    fn look(&self, tracer: &Tracer, slots: &[u32], rays: u32, seed: u64) -> Vec<Vec<u32>> {
        let look_from = |&slot: &u32| {
            let sequence = Stream::Looks.sequence(seed, slot, 0);
            let rays = self.facet(tracer, slot).rays(sequence, 0..rays);
            let landing = |(ray, point): (Ray, u32)| {
                // By way of carriers too, and whatever their colour.
                let numbers = |k: u32| sequence.dimensions(point, k + 1);
                let passes = |colour: Tint, _: f64| colour.parts().any(|part| part > 0.0);
                match tracer.destination(&ray, numbers, passes) {
                    Destination::Diffuse { hit, .. } => {
                        Some(self.slot_at(hit.face as usize, hit.side, hit.barycentrics))
                    }
                    Destination::Away(_) | Destination::Absorbed | Destination::Lost => None,
                }
            };
            let mut landings: Vec<u32> = rays.zip(0..).filter_map(landing).collect();
            landings.sort_unstable();
            landings.dedup();
            landings
        };
        slots.par_iter().map(look_from).collect()
    }

    /// A slot on a lamp that each of `slots` sees, if it sees any by these looks.
    fn look_at_lamps(
        &self,
        tracer: &Tracer,
        lamps: &Lamps,
        slots: &[u32],
        Looks { range, seed }: Looks,
    ) -> Vec<Option<u32>> {
        let look_from = |&slot: &u32| {
            let facet = self.facet(tracer, slot);
            // From all of the slot: a lamp may lie below the horizon of its centre alone.
            let view = lamps.view_over(&facet.corners, facet.normal);
            let sequence = Stream::LampLooks.sequence(seed, slot, 0);
            range.clone().find_map(|k| {
                let [s, t, u, v] = sequence.point(k);
                let to = lamps.sample(&view, [u, v])?;
                let from = facet.target(to.point, [s, t]).point;
                let faces_it = geometry_term((from, facet.normal), (to.point, to.normal)) > 0.0;
                let sees_it = faces_it && tracer.unoccluded((from, facet.face), (to.point, to.face));
                sees_it.then(|| self.slot_at(to.face as usize, Side::Front, to.barycentrics))
            })
        };
        slots.par_iter().map(look_from).collect()
    }

    /// For each slot whether it sees a light without area or the sky.
    fn shone_on(&self, tracer: &Tracer, lights: &Lights, seed: u64) -> Vec<bool> {
        let is_lit = |slot: u32| {
            !tracer.is_carrier(self.slot(slot).face as u32)
                && !self.is_covered(slot)
                && self.is_shone_on(tracer, lights, slot, Looks { range: 0..LAMP_LOOKS, seed })
        };
        let mut lit: Vec<bool> = (0..self.slots() as u32).into_par_iter().map(is_lit).collect();
        self.shine_through(tracer, lights, seed, &mut lit);
        self.shine_by_carriers(tracer, lights, seed, &mut lit);
        lit.iter_mut().zip(0..).for_each(|(lit, slot)| *lit &= self.is_wanted(slot));
        lit
    }

    /// Whether light from a light without area or the sky arrives straight on a slot by one of these looks.
    fn is_shone_on(
        &self,
        tracer: &Tracer,
        lights: &Lights,
        slot: u32,
        Looks { mut range, seed }: Looks,
    ) -> bool {
        let facet = self.facet(tracer, slot);
        let sequence = Stream::LightLooks.sequence(seed, slot, 0);
        let [mut arrived, mut scratch] = [0, 1].map(|_| vec![0.0; self.scene.channels()]);
        let sky = lights.sky_over(tracer, &facet.corners, facet.normal);
        range.any(|k| {
            let [s, t, u, v] = sequence.point(k);
            arrived.fill(0.0);
            let here = Arrival { place: facet.interaction([s, t]), sky: sky.as_ref() };
            lights.add_irradiance(tracer, &here, || [u, v], [&mut arrived, &mut scratch]);
            arrived.iter().any(|&x| x > 0.0)
        })
    }

    /// Whether a slot may become a patch: what is covered may not, nor backs where they are left out.
    pub(crate) fn is_wanted(&self, slot: u32) -> bool {
        let has_side = !self.scene.is_without(Feature::BackSides) || self.slot(slot).side == Side::Front;
        has_side && !self.is_covered(slot)
    }

    fn emits(&self, slot: u32) -> bool {
        let place = self.slot(slot);
        place.side == Side::Front && self.scene.material_of(place.face).emits() && !self.is_covered(slot)
    }

    /// Which part of a face's front and back is reached.
    pub(crate) fn reached_share(&self, face: usize) -> [f64; 2] {
        let cells = self.cuts.cells(face).max(1) as f64;
        Side::BOTH.map(|side| self.patches_of(face, side).len() as f64 / cells)
    }
}
