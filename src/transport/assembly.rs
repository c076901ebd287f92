//! Assembly: from rows of rays to raw exchange areas.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sprs::CsMatI;

use super::moments;
use super::rays::{AWAY, Rows};
use super::recipe::BATCHES;
use super::storage::{Storage, StorageKind};
use crate::patches::{Basis, Patches};
use crate::scene::Side;

/// Raw exchange areas: symmetric, not yet balanced.
pub(super) struct Raw {
    pub storage: Storage,
    /// Per coefficient.
    pub escape: DVector<f64>,
    /// Which coefficients are those of lamps, known better than the rest.
    pub is_lamp: Vec<bool>,
}

/// Sums up what the rows of all patches found; without batch `left_out`, if there is one.
pub(super) fn assemble(rows: &Rows, patches: &Patches, kind: StorageKind, left_out: Option<u32>) -> Raw {
    let n = patches.len();
    let is_lamp = |i: usize| {
        let place = patches.place(i);
        place.side == Side::Front && rows.lamp_faces.binary_search(&(place.face as u32)).is_ok()
    };
    let is_lamp: Vec<bool> = (0..n).map(is_lamp).collect();
    if rows.recipe.basis == Basis::Linear {
        return moments::assemble(rows, patches, kind, left_out, &is_lamp);
    }
    let finder = Finder { rows, patches, is_lamp: &is_lamp, left_out };
    let (parts, escape): (Vec<Vec<Part>>, Vec<f64>) =
        (0..n).into_par_iter().map(|i| finder.found_by(i)).unzip();
    let storage = match kind.resolve(n, &parts) {
        StorageKind::Dense => Storage::Dense(dense(n, &parts)),
        _ => Storage::Sparse(sparse(n, &parts)),
    };
    Raw { storage, escape: DVector::from_vec(escape), is_lamp }
}

/// What one patch found of its exchange area with another; the pair's exchange area is the sum of both findings.
type Part = (u32, f64);

/// Sums up rows into findings.
struct Finder<'a> {
    rows: &'a Rows,
    patches: &'a Patches<'a>,
    is_lamp: &'a [bool],
    left_out: Option<u32>,
}

impl Finder<'_> {
    /// What patch i found: its parts, ascending, and what escapes from it; a side without light is as good as outside.
    ///
    /// A landing of i on j is worth A_i/N. Its variance grows with A_i, so the two directions of a pair are averaged with
    /// weights A_j and A_i: each landing between i and j is then worth the same from either side. Of a lamp its receivers
    /// know more than it does itself: between the two, only what they found counts.
    fn found_by(&self, i: usize) -> (Vec<Part>, f64) {
        let areas = self.patches.areas();
        let Some(row) = self.rows.of(self.patches.slot_of_patch(i)) else {
            return (Vec::new(), areas[i]);
        };
        let batch_size = row.landings.len() / BATCHES as usize;
        let batches =
            row.landings.chunks(batch_size).zip(0..).filter(|&(_, batch)| Some(batch) != self.left_out);
        let number =
            |slot: u32| if slot == AWAY { AWAY } else { self.patches.patch_of_slot(slot).unwrap_or(AWAY) };
        let mut sorted: Vec<u32> =
            batches.flat_map(|(landings, _)| landings.iter().map(|&s| number(s))).collect();
        sorted.sort_unstable();
        let rays = sorted.len() as f64;
        let mut escape = 0.0;
        let mut parts: Vec<Part> = Vec::new();
        for run in sorted.chunk_by(|a, b| a == b) {
            let (patch, count) = (run[0], run.len() as f64);
            if patch == AWAY {
                escape = areas[i] * count / rays;
            } else if self.is_lamp[patch as usize] == self.is_lamp[i] {
                let j = patch as usize;
                parts.push((patch, areas[i] * areas[j] / (areas[i] + areas[j]) * count / rays));
            }
        }
        let used = if self.left_out.is_some() { BATCHES - 1 } else { BATCHES };
        let worth = areas[i] * BATCHES as f64 / used as f64;
        let mut of_lamps: Vec<_> =
            row.lamp_shares.iter().filter(|s| Some(s.batch) != self.left_out).collect();
        of_lamps.sort_unstable_by_key(|s| (s.slot, s.batch));
        for run in of_lamps.chunk_by(|a, b| a.slot == b.slot) {
            parts.push((number(run[0].slot), worth * run.iter().map(|s| f64::from(s.share)).sum::<f64>()));
        }
        parts.sort_unstable_by_key(|part| part.0);
        (parts, escape)
    }
}

fn dense(n: usize, parts: &[Vec<Part>]) -> DMatrix<f32> {
    let mut m = DMatrix::zeros(n, n);
    // Column i holds what i found.
    m.as_mut_slice().par_chunks_mut(n).zip(parts).for_each(|(column, parts): (&mut [f32], _)| {
        parts.iter().for_each(|&(j, part)| column[j as usize] = part as f32);
    });
    for j in 0..n {
        for i in 0..j {
            let both = m[(i, j)] + m[(j, i)];
            m[(i, j)] = both;
            m[(j, i)] = both;
        }
    }
    m
}

fn sparse(n: usize, parts: &[Vec<Part>]) -> CsMatI<f32, u32, usize> {
    // Gather, for each patch, what others found of it; ascending because patches come in order.
    let mut from: Vec<Vec<Part>> = vec![Vec::new(); n];
    for (i, parts) in parts.iter().enumerate() {
        parts.iter().for_each(|&(j, part)| from[j as usize].push((i as u32, part)));
    }
    let rows: Vec<Vec<(u32, f32)>> = (0..n)
        .into_par_iter()
        .map(|i| {
            let mut both: Vec<Part> = parts[i].iter().chain(&from[i]).copied().collect();
            both.sort_by_key(|part| part.0);
            // Sums of two f32 commute: both triangles get the same bits.
            both.chunk_by(|a, b| a.0 == b.0)
                .map(|pair| (pair[0].0, pair.iter().map(|part| part.1 as f32).sum()))
                .collect()
        })
        .collect();
    drop(from);
    let mut starts = vec![0];
    rows.iter().for_each(|row| starts.push(starts[starts.len() - 1] + row.len()));
    let indices = rows.iter().flatten().map(|&(j, _)| j).collect();
    let values = rows.iter().flatten().map(|&(_, value)| value).collect();
    CsMatI::new((n, n), starts, indices, values)
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
