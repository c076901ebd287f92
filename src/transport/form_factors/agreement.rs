//! Agreement: whether both directions of a pair of face sides found the same exchange area.
//!
//! Side a finds S_ab by its own rays and side b finds S_ba by its own. On a sound mesh the two differ by
//! chance alone; where rays are lost or met twice in one direction they do not. This needs no closed form,
//! and holds through specular surfaces too.
//!
//! z = (S_ab − S_ba) / √(var S_ab + var S_ba), each variance that of counted rays, and no less than what the
//! other direction lets expect.

use std::collections::HashMap;

use rayon::prelude::*;

use super::constants::{DISAGREE, FEWEST_RAYS};
use crate::patches::{Patches, Slot};
use crate::scene::Side;
use crate::transport::rows::Rows;

/// Two face sides whose directions disagree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disagreement {
    /// The side that found more, and the other.
    pub sides: [(usize, Side); 2],
    /// By how many standard errors.
    pub z: f64,
}

/// What the rays of one side found of another.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    rays: u32,
    /// Exchange area, normalised.
    area: f64,
    /// Σ (worth of a ray)².
    squares: f64,
}

/// Patches by face sides.
struct FaceSides<'a> {
    rows: &'a Rows,
    patches: &'a Patches<'a>,
    /// Per patch its face side.
    of_patch: Vec<u32>,
    /// Per face side, and one more: its first patch.
    first_patch: Vec<usize>,
}

impl<'a> FaceSides<'a> {
    fn new(rows: &'a Rows, patches: &'a Patches<'a>) -> Self {
        let (mut of_patch, mut first_patch) = (Vec::with_capacity(patches.len()), Vec::new());
        let mut last = None;
        for i in 0..patches.len() {
            let Slot { face, side, .. } = patches.place(i);
            if last.replace((face, side)) != Some((face, side)) {
                first_patch.push(i);
            }
            of_patch.push(first_patch.len() as u32 - 1);
        }
        first_patch.push(patches.len());
        Self { rows, patches, of_patch, first_patch }
    }

    fn len(&self) -> usize {
        self.first_patch.len() - 1
    }

    /// What a side's rays found of the others, in the first channel; `found` is all zero before and after,
    /// and `touched` empty.
    fn look_from(&self, side: usize, found: &mut [Found], touched: &mut Vec<u32>) -> Vec<(u32, Found)> {
        for i in self.first_patch[side]..self.first_patch[side + 1] {
            let Some(row) = self.rows.of(self.patches.slot_of_patch(i)) else { continue };
            let worth = self.patches.normalised_etendues()[i] / row.landings.len() as f64;
            for end in row.ends(0..row.landings.len(), 0) {
                let Some(patch) = end.slot().and_then(|slot| self.patches.patch_of_slot(slot)) else {
                    continue;
                };
                let other = self.of_patch[patch as usize];
                let found = &mut found[other as usize];
                if found.rays == 0 {
                    touched.push(other);
                }
                found.rays += 1;
                found.area += worth;
                found.squares += worth * worth;
            }
        }
        touched.drain(..).map(|other| (other, std::mem::take(&mut found[other as usize]))).collect()
    }

    /// Calls `f` with each side and what its rays found.
    fn map<T: Send>(&self, f: impl Fn(usize, Vec<(u32, Found)>) -> Vec<T> + Sync) -> Vec<T> {
        let scratch = || (vec![Found::default(); self.len()], Vec::new());
        let of_side = |(found, touched): &mut (Vec<Found>, Vec<u32>), side: usize| {
            f(side, self.look_from(side, found, touched))
        };
        (0..self.len()).into_par_iter().map_init(scratch, of_side).flatten_iter().collect()
    }

    /// The mean worth of a ray of a side.
    fn worth(&self, side: usize) -> f64 {
        let patches = self.first_patch[side]..self.first_patch[side + 1];
        let count = patches.len() as f64;
        let etendue: f64 = patches.map(|i| self.patches.normalised_etendues()[i]).sum();
        etendue / (count * f64::from(self.rows.recipe.count.rays))
    }

    fn place(&self, side: usize) -> (usize, Side) {
        let Slot { face, side, .. } = self.patches.place(self.first_patch[side]);
        (face, side)
    }
}

/// The pairs of face sides whose directions differ by more than [`DISAGREE`] standard errors, the worst
/// first.
pub fn disagreements(rows: &Rows, patches: &Patches) -> Vec<Disagreement> {
    let sides = FaceSides::new(rows, patches);
    // Keep what enough rays found to disagree about; look up the other direction of the same pairs.
    let many = sides.map(|side, found| {
        let enough = found.into_iter().filter(|(_, found)| found.rays > FEWEST_RAYS);
        enough.map(|(other, found)| ([side as u32, other], found)).collect()
    });
    let many: HashMap<[u32; 2], Found> = many.into_iter().collect();
    let mut wanted: Vec<Vec<u32>> = vec![Vec::new(); sides.len()];
    for &[a, b] in many.keys().filter(|&&[a, b]| a != b && !many.contains_key(&[b, a])) {
        wanted[b as usize].push(a);
    }
    let few = sides.map(|side, found| {
        let wanted = found.into_iter().filter(|(other, _)| wanted[side].contains(other));
        wanted.map(|(other, found)| ([side as u32, other], found)).collect()
    });
    let few: HashMap<[u32; 2], Found> = few.into_iter().collect();
    let there = |pair: [u32; 2]| many.get(&pair).or_else(|| few.get(&pair)).copied().unwrap_or_default();
    let judge = |&[a, b]: &[u32; 2]| {
        let (one, other) = (there([a, b]), there([b, a]));
        let variance =
            |found: Found, back: Found, side: u32| found.squares.max(sides.worth(side as usize) * back.area);
        let z = (one.area - other.area) / (variance(one, other, a) + variance(other, one, b)).sqrt();
        (z > DISAGREE).then(|| Disagreement { sides: [a, b].map(|side| sides.place(side as usize)), z })
    };
    let mut found: Vec<Disagreement> = many.keys().filter(|[a, b]| a != b).filter_map(judge).collect();
    found.sort_by(|a, b| b.z.total_cmp(&a.z).then_with(|| a.sides.cmp(&b.sides)));
    found
}
