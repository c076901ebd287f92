//! Moments: assembly for linear elements, S_(ia)(jb) = ½ (A_i E[φ_a φ_b] + A_j E[φ_a φ_b]) with φ_a where a ray left i and φ_b where it
//! landed on j, from the same rays as for constant ones.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::assembly::Raw;
use super::blocks::{Blocks, Findings};
use super::landing::Landing;
use super::rays::{AWAY, Row, Rows, origins};
use super::recipe::BATCHES;
use super::storage::{Storage, StorageKind};
use crate::patches::Patches;

/// Sums up what the rows of all patches found; without batch `left_out`, if there is one.
pub(super) fn assemble(
    rows: &Rows,
    patches: &Patches,
    kind: StorageKind,
    left_out: Option<u32>,
    is_lamp: &[bool],
) -> Raw {
    let used = if left_out.is_some() { BATCHES - 1 } else { BATCHES };
    let rays = f64::from(rows.recipe.count.rays / BATCHES * used);
    let finder = Finder { rows, patches, is_lamp, left_out, rays, used };
    let (found, escape): (Vec<Findings>, Vec<[f64; 3]>) =
        (0..patches.len()).into_par_iter().map(|i| finder.found_by(i)).unzip();
    let blocks = Blocks::new(patches.areas(), rays, &found);
    drop(found);
    let coefficients = 3 * patches.len();
    let full = 4 * (coefficients as u64).pow(2);
    let storage = match kind {
        StorageKind::Sparse => Storage::Blocks(blocks),
        StorageKind::Auto if blocks.bytes() < full => Storage::Blocks(blocks),
        _ => Storage::Dense(dense(coefficients, &blocks)),
    };
    let escape = DVector::from_iterator(coefficients, escape.into_iter().flatten());
    let is_lamp = is_lamp.iter().flat_map(|&lamp| [lamp; 3]).collect();
    Raw { storage, escape, is_lamp }
}

struct Finder<'a> {
    rows: &'a Rows,
    patches: &'a Patches<'a>,
    is_lamp: &'a [bool],
    left_out: Option<u32>,
    /// Rays per patch that count.
    rays: f64,
    /// Batches that count.
    used: u32,
}

impl Finder<'_> {
    /// What patch i found, and what escapes from it by corner; a side without light is as good as outside.
    fn found_by(&self, i: usize) -> (Findings, [f64; 3]) {
        let area = self.patches.areas()[i];
        let Some(row) = self.rows.of(self.patches.slot_of_patch(i)) else {
            return (Findings::default(), [area / 3.0; 3]);
        };
        let number =
            |slot: u32| if slot == AWAY { AWAY } else { self.patches.patch_of_slot(slot).unwrap_or(AWAY) };
        let (mut landings, mut escape) = (Vec::new(), [0.0; 3]);
        let batch_size = row.landings.len() / BATCHES as usize;
        let ends = row.landings.iter().zip(&row.spots).zip(origins(row.slot, self.rows.recipe));
        for (k, ((&slot, &there), here)) in ends.enumerate() {
            if Some((k / batch_size) as u32) == self.left_out {
                continue;
            }
            let partner = number(slot);
            if partner == AWAY {
                let weights = here.weights();
                (0..3).for_each(|a| escape[a] += area * weights[a] / self.rays);
            } else if self.is_lamp[partner as usize] == self.is_lamp[i] {
                landings.push(Landing { partner, here, there });
            }
        }
        (Findings { landings, lamps: self.lamps_seen(row, area, number) }, escape)
    }

    /// What light sampling found of the patch's exchange with lamps.
    fn lamps_seen(&self, row: &Row, area: f64, number: impl Fn(u32) -> u32) -> Vec<(u32, [f64; 9])> {
        let worth = area * f64::from(BATCHES) / f64::from(self.used);
        let mut shares: Vec<_> = row.lamp_shares.iter().zip(&row.lamp_moments).collect();
        shares.retain(|(share, _)| Some(share.batch) != self.left_out);
        shares.sort_unstable_by_key(|(share, _)| (share.slot, share.batch));
        let sum = |run: &[(_, &[f32; 9])], entry: usize| -> f64 {
            worth * run.iter().map(|(_, moments)| f64::from(moments[entry])).sum::<f64>()
        };
        let runs = shares.chunk_by(|a, b| a.0.slot == b.0.slot);
        runs.map(|run| (number(run[0].0.slot), std::array::from_fn(|entry| sum(run, entry)))).collect()
    }
}

fn dense(coefficients: usize, blocks: &Blocks) -> DMatrix<f32> {
    let mut m = DMatrix::zeros(coefficients, coefficients);
    let columns = m.as_mut_slice().par_chunks_mut(coefficients).enumerate();
    columns.for_each(|(k, column)| blocks.for_row(k, |l, value| column[l] = value as f32));
    m
}
