//! Moments: assembly for linear elements, S_(ia)(jb) = ½ (A_i E[φ_a φ_b] + A_j E[φ_a φ_b]) with φ_a where a
//! ray left i and φ_b where it landed on j, from the same rays as for constant ones.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::blocks::{Blocks, Findings};
use super::raw::{Leaving, Outcome, Raw, Selection, has_carriers};
use super::storage::{Storage, StorageKind};
use crate::patches::Patches;
use crate::transport::rows::{BATCHES, ESCAPED, Landing, Row, Rows, origins};

/// Sums up what the rows of all patches found.
pub fn assemble(selection: &Selection, kind: StorageKind, is_lamp: &[bool]) -> Raw {
    let &Selection { rows, patches, tone, left_out } = selection;
    let used = if left_out.is_some() { BATCHES - 1 } else { BATCHES };
    let rays = f64::from(rows.recipe.count.rays / BATCHES * used);
    let finder = Finder { rows, patches, tone, is_lamp, left_out, rays, used };
    let (found, leaving): (Vec<Findings>, Vec<[[f64; 3]; 3]>) =
        (0..patches.len()).into_par_iter().map(|i| finder.found_by(i)).unzip();
    let blocks = Blocks::new(patches.normalised_etendues(), rays, &found);
    drop(found);
    let coefficients = 3 * patches.len();
    let full = 4 * (coefficients as u64).pow(2);
    let storage = match kind {
        StorageKind::Sparse => Storage::Blocks(blocks),
        StorageKind::Auto if blocks.bytes() < full => Storage::Blocks(blocks),
        _ => Storage::Dense(dense(coefficients, &blocks)),
    };
    let leaving = Leaving::new(leaving.as_flattened(), has_carriers(patches));
    let is_lamp = is_lamp.iter().flat_map(|&lamp| [lamp; 3]).collect();
    Raw { storage, leaving, is_lamp }
}

struct Finder<'a> {
    rows: &'a Rows,
    patches: &'a Patches<'a>,
    tone: usize,
    is_lamp: &'a [bool],
    left_out: Option<u32>,
    /// Rays per patch that count.
    rays: f64,
    /// Batches that count.
    used: u32,
}

impl Finder<'_> {
    /// What patch i found, and what escapes from it, is absorbed by carriers or lost, by corner.
    fn found_by(&self, i: usize) -> (Findings, [[f64; 3]; 3]) {
        let area = self.patches.normalised_etendues()[i];
        let mut leaving = [[0.0; 3]; 3];
        let Some(row) = self.rows.of(self.patches.slot_of_patch(i)) else {
            leaving.iter_mut().for_each(|corner| corner[ESCAPED] = area / 3.0);
            return (Findings::default(), leaving);
        };
        let (mut landings, mut carried_to_lamps) = (Vec::new(), Vec::new());
        let batch_size = row.landings.len() / BATCHES as usize;
        let ends = row.ends(0..row.landings.len(), self.tone);
        let ends = ends.zip(&row.spots).zip(origins(row.slot, self.rows.recipe));
        for (k, ((end, &there), here)) in ends.enumerate() {
            if Some((k / batch_size) as u32) == self.left_out {
                continue;
            }
            match Outcome::of(end, self.patches) {
                Outcome::Left(kind) => {
                    let weights = here.weights();
                    (0..3).for_each(|a| leaving[a][kind] += area * weights[a] / self.rays);
                }
                Outcome::Met { patch, carried } => {
                    let landing = Landing { partner: patch, here, there };
                    if self.is_lamp[patch as usize] == self.is_lamp[i] {
                        landings.push(landing);
                    } else if carried && !self.is_lamp[i] {
                        carried_to_lamps.push(landing);
                    }
                }
            }
        }
        if !self.is_lamp[i] {
            let caustics = self.rows.caustics.of(row.slot, self.tone, self.left_out);
            carried_to_lamps.extend(caustics.filter_map(|caustic| {
                let partner = self.patches.patch_of_slot(caustic.lamp)?;
                let [here, there] = caustic.ends;
                Some(Landing { partner, here, there })
            }));
        }
        (Findings { landings, lamps: self.lamps_seen(row, area, &carried_to_lamps) }, leaving)
    }

    /// What light sampling, and rays by way of carriers, found of the patch's exchange with lamps.
    fn lamps_seen(&self, row: &Row, area: f64, carried: &[Landing]) -> Vec<(u32, [f64; 9])> {
        let worth = area * f64::from(BATCHES) / f64::from(self.used);
        let mut shares: Vec<_> = row.lamps.shares.iter().zip(&row.lamps.moments).collect();
        shares.retain(|(share, _)| Some(share.batch) != self.left_out);
        shares.sort_unstable_by_key(|(share, _)| (share.slot, share.batch));
        let sum = |run: &[(_, &[f32; 9])], entry: usize| -> f64 {
            worth * run.iter().map(|(_, moments)| f64::from(moments[entry])).sum::<f64>()
        };
        let runs = shares.chunk_by(|a, b| a.0.slot == b.0.slot);
        let straight = runs.filter_map(|run| {
            let patch = self.patches.patch_of_slot(run[0].0.slot)?;
            Some((patch, std::array::from_fn(|entry| sum(run, entry))))
        });
        let by_carriers = carried.iter().map(|landing| {
            let pair = [area, self.patches.normalised_etendues()[landing.partner as usize]];
            let worth = self.rows.caustics.worth(pair, self.rays, self.used);
            (landing.partner, landing.moments().map(|m| m * worth))
        });
        let mut lamps: Vec<(u32, [f64; 9])> = straight.chain(by_carriers).collect();
        lamps.sort_by_key(|lamp| lamp.0);
        let whole = |run: &[(u32, [f64; 9])]| {
            (run[0].0, std::array::from_fn(|entry| run.iter().map(|(_, moments)| moments[entry]).sum()))
        };
        lamps.chunk_by(|a, b| a.0 == b.0).map(whole).collect()
    }
}

fn dense(coefficients: usize, blocks: &Blocks) -> DMatrix<f32> {
    let mut m = DMatrix::zeros(coefficients, coefficients);
    let columns = m.as_mut_slice().par_chunks_mut(coefficients).enumerate();
    columns.for_each(|(k, column)| blocks.for_row(k, |l, value| column[l] = value as f32));
    m
}
