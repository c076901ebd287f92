//! Assembly: from rows of rays to raw exchange areas.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::moments;
use super::raw::{Leaving, Outcome, Raw, Selection, has_carriers};
use super::storage::{Storage, StorageKind};
use crate::patches::{Basis, Patches};
use crate::transport::rows::{BATCHES, ESCAPED, Rows};

/// Sums up what the rows of all patches found.
pub fn assemble(selection: &Selection, kind: StorageKind) -> Raw {
    let &Selection { rows, patches, tone, left_out } = selection;
    let n = patches.len();
    let is_lamp: Vec<bool> = (0..n).map(|i| rows.is_lamp(patches, i)).collect();
    if rows.recipe.basis == Basis::Linear {
        return moments::assemble(selection, kind, &is_lamp);
    }
    let finder = Finder { rows, patches, tone, is_lamp: &is_lamp, left_out };
    let (parts, leaving): (Vec<Vec<Part>>, Vec<[f64; 3]>) =
        (0..n).into_par_iter().map(|i| finder.found_by(i)).unzip();
    let storage = match kind.resolve(n, &parts) {
        StorageKind::Dense => Storage::Dense(dense(n, &parts)),
        _ => sparse(n, &parts),
    };
    Raw { storage, leaving: Leaving::new(&leaving, has_carriers(patches)), is_lamp }
}

/// What one patch found of its exchange area with another; the pair's exchange area is the sum of both
/// findings.
type Part = (u32, f32);

/// Sums up rows into findings.
struct Finder<'a> {
    rows: &'a Rows,
    patches: &'a Patches<'a>,
    tone: usize,
    is_lamp: &'a [bool],
    left_out: Option<u32>,
}

impl Finder<'_> {
    /// What patch i found: its parts, ascending, and what escapes from it, is absorbed by carriers or lost.
    ///
    /// A landing of i on j is worth A_i/N. Its variance grows with A_i, so the two directions of a pair are
    /// averaged with weights A_j and A_i: each landing between i and j is then worth the same from either
    /// side. Of a lamp its receivers know more than it does itself: between the two, only what they found
    /// counts, straight on by light sampling and by way of carriers by their rays.
    fn found_by(&self, i: usize) -> (Vec<Part>, [f64; 3]) {
        let areas = self.patches.normalised_etendues();
        let mut leaving = [0.0; 3];
        let Some(row) = self.rows.of(self.patches.slot_of_patch(i)) else {
            leaving[ESCAPED] = areas[i];
            return (Vec::new(), leaving);
        };
        let batch_size = row.landings.len() / BATCHES as usize;
        let batches = (0..BATCHES).filter(|&batch| Some(batch) != self.left_out);
        let batches = batches.map(|batch| batch as usize * batch_size..(batch as usize + 1) * batch_size);
        let (mut rays, mut left, mut carried_to_lamps) = (0.0, [0.0; 3], Vec::new());
        let mut sorted: Vec<u32> = Vec::with_capacity(row.landings.len());
        for end in batches.flat_map(|range| row.ends(range, self.tone)) {
            rays += 1.0;
            match Outcome::of(end, self.patches) {
                Outcome::Left(kind) => left[kind] += 1.0,
                Outcome::Met { patch, .. } if self.is_lamp[patch as usize] == self.is_lamp[i] => {
                    sorted.push(patch)
                }
                Outcome::Met { patch, carried } if carried && !self.is_lamp[i] => {
                    carried_to_lamps.push(patch)
                }
                Outcome::Met { .. } => {}
            }
        }
        sorted.sort_unstable();
        (0..3).for_each(|kind| leaving[kind] = areas[i] * left[kind] / rays);
        let mut parts: Vec<Part> = Vec::new();
        for run in sorted.chunk_by(|a, b| a == b) {
            let (patch, count) = (run[0], run.len() as f64);
            let j = patch as usize;
            parts.push((patch, (areas[i] * areas[j] / (areas[i] + areas[j]) * count / rays) as f32));
        }
        let used = if self.left_out.is_some() { BATCHES - 1 } else { BATCHES };
        let worth = areas[i] * BATCHES as f64 / used as f64;
        let mut of_lamps: Vec<_> =
            row.lamps.shares.iter().filter(|s| Some(s.batch) != self.left_out).collect();
        of_lamps.sort_unstable_by_key(|s| (s.slot, s.batch));
        let mut lamps: Vec<(u32, f64)> = Vec::new();
        for run in of_lamps.chunk_by(|a, b| a.slot == b.slot) {
            if let Some(patch) = self.patches.patch_of_slot(run[0].slot) {
                lamps.push((patch, worth * run.iter().map(|s| f64::from(s.share)).sum::<f64>()));
            }
        }
        let by_carriers = |patch: u32| {
            let pair = [areas[i], areas[patch as usize]];
            (patch, self.rows.caustics.worth(pair, rays, used))
        };
        lamps.extend(carried_to_lamps.into_iter().map(by_carriers));
        if !self.is_lamp[i] {
            let caustics = self.rows.caustics.of(row.slot, self.tone, self.left_out);
            lamps.extend(caustics.filter_map(|c| self.patches.patch_of_slot(c.lamp)).map(by_carriers));
        }
        lamps.sort_by_key(|part| part.0);
        let whole = |run: &[(u32, f64)]| (run[0].0, run.iter().map(|part| part.1).sum::<f64>() as f32);
        parts.extend(lamps.chunk_by(|a, b| a.0 == b.0).map(whole));
        parts.sort_unstable_by_key(|part| part.0);
        (parts, leaving)
    }
}

fn dense(n: usize, parts: &[Vec<Part>]) -> DMatrix<f32> {
    let mut m = DMatrix::zeros(n, n);
    // Column i holds what i found.
    m.as_mut_slice().par_chunks_mut(n).zip(parts).for_each(|(column, parts): (&mut [f32], _)| {
        parts.iter().for_each(|&(j, part)| column[j as usize] = part);
    });
    // A patch that sees itself, as in a mirror, found both directions of that pair.
    for j in 0..n {
        for i in 0..=j {
            let both = m[(i, j)] + m[(j, i)];
            m[(i, j)] = both;
            m[(j, i)] = both;
        }
    }
    m
}

fn sparse(n: usize, parts: &[Vec<Part>]) -> Storage {
    let told = told_by_others(n, parts);
    let rows: Vec<Vec<Part>> = parts.par_iter().zip(told).map(|(own, told)| joined(own, &told)).collect();
    Storage::sparse(&rows)
}

/// What others found of each patch; ascending because patches come in order.
fn told_by_others(n: usize, parts: &[Vec<Part>]) -> Vec<Vec<Part>> {
    /// Patches that are told at a time: the ends of so many lists stay at hand.
    const TOGETHER: usize = 512;
    let of_some = |first: usize| {
        let end = n.min(first + TOGETHER);
        let mut told = vec![Vec::new(); end - first];
        for (i, parts) in (0u32..).zip(parts) {
            let start = parts.partition_point(|part| (part.0 as usize) < first);
            for &(j, part) in parts[start..].iter().take_while(|part| (part.0 as usize) < end) {
                told[j as usize - first].push((i, part));
            }
        }
        told
    };
    (0..n.div_ceil(TOGETHER)).into_par_iter().flat_map_iter(|k| of_some(k * TOGETHER)).collect()
}

/// A row from both findings of its pairs. Sums of two f32 commute: both triangles get the same bits.
fn joined(own: &[Part], told: &[Part]) -> Vec<Part> {
    let mut row = Vec::with_capacity(own.len() + told.len());
    let mut told = told.iter().copied().peekable();
    for &(j, part) in own {
        row.extend(std::iter::from_fn(|| told.next_if(|other| other.0 < j)));
        let other = told.next_if(|other| other.0 == j).map_or(0.0, |other| other.1);
        row.push((j, part + other));
    }
    row.extend(told);
    row
}

impl StorageKind {
    /// Dense or sparse for these counts.
    fn resolve(self, n: usize, parts: &[Vec<Part>]) -> Self {
        let entries: usize = parts.iter().map(Vec::len).sum();
        match self {
            // Most pairs are met from both sides or from one; between one and two entries a part.
            Self::Auto if 8 * 3 * entries / 2 < 4 * n * n => Self::Sparse,
            Self::Auto => Self::Dense,
            chosen => chosen,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dense_and_sparse_hold_the_same_also_of_what_a_patch_exchanges_with_itself() {
        let parts = [vec![(0, 0.25), (1, 0.5)], vec![(0, 0.125), (2, 2.0)], vec![(2, 0.75)]];
        let (dense, Storage::Sparse(sparse)) = (dense(3, &parts), sparse(3, &parts)) else {
            panic!("sparse")
        };
        let expected = [[0.5, 0.625, 0.0], [0.625, 0.0, 2.0], [0.0, 2.0, 1.5]];
        for (i, row) in expected.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                assert_eq!(dense[(i, j)], value, "dense ({i}, {j})");
                assert_eq!(sparse.get(i, j).copied().unwrap_or(0.0), value, "sparse ({i}, {j})");
            }
        }
    }
}
