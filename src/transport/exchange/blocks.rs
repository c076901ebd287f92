//! Blocks: a symmetric matrix for linear elements, three rows a patch, made of what pairs of patches
//! exchange.
//!
//! Of pairs between which few rays went the rays are kept as they are, 8 bytes each: one is worth h φ_a(x)
//! φ_b(y), where h = A_i A_j / ((A_i + A_j) N) is the same for all rays between i and j. Of other pairs, and
//! of those with a lamp, the 3 × 3 block of sums is kept, 40 bytes. Every pair stands in the rows of both
//! patches, so that a product only gathers; all that is computed of it commutes in i and j, so that both get
//! the same bits.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::mass::shrink;
use crate::transport::rows::{Landing, Spot};

/// What i and j exchange by pairs of basis functions: entry 3a + b for φ_a on i and φ_b on j.
pub type Block = [f32; 9];

/// With so many rays a pair's block takes less than they do.
pub const MANY: usize = 5;

/// What a patch found of its exchange with others.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Its rays that landed on patches.
    pub landings: Vec<Landing>,
    /// What pairs of points tell of lamps, by lamp patch, ascending.
    pub lamps: Vec<(u32, [f64; 9])>,
}

/// A symmetric 3n × 3n matrix by pairs of patches.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    /// A_i / N, n values.
    pub(crate) worths: Vec<f64>,
    /// Per patch, and one more: its first block.
    pub(crate) block_starts: Vec<usize>,
    /// The other patch, ascending within a row.
    pub(crate) partners: Vec<u32>,
    pub(crate) blocks: Vec<Block>,
    /// Per patch, and one more: its first landing.
    pub(crate) landing_starts: Vec<usize>,
    /// By partner, ascending within a row; of the same partner in the order of [`in_order`].
    pub(crate) landings: Vec<Landing>,
}

/// One patch's share of [`Blocks`].
type Row = (Vec<(u32, Block)>, Vec<Landing>);

impl Blocks {
    /// Joins what n patches of these areas found by `rays` rays each.
    pub(crate) fn new(areas: &[f64], rays: f64, found: &[Findings]) -> Self {
        let n = areas.len();
        // Gather, for each patch, what others found of it.
        let mut told: Vec<Findings> = vec![Findings::default(); n];
        for (i, findings) in (0u32..).zip(found) {
            for landing in &findings.landings {
                told[landing.partner as usize].landings.push(landing.seen_from_there(i));
            }
            for &(j, block) in &findings.lamps {
                told[j as usize].lamps.push((i, transposed(block)));
            }
        }
        let worths: Vec<f64> = areas.iter().map(|area| area / rays).collect();
        let rows: Vec<Row> =
            (0..n).into_par_iter().map(|i| row(i as u32, &found[i], &told[i], &worths)).collect();
        drop(told);
        let (mut block_starts, mut landing_starts) = (vec![0], vec![0]);
        for (blocks, landings) in &rows {
            block_starts.push(block_starts[block_starts.len() - 1] + blocks.len());
            landing_starts.push(landing_starts[landing_starts.len() - 1] + landings.len());
        }
        let partners = rows.iter().flat_map(|row| row.0.iter().map(|block| block.0)).collect();
        let blocks = rows.iter().flat_map(|row| row.0.iter().map(|block| block.1)).collect();
        let landings = rows.iter().flat_map(|row| &row.1).copied().collect();
        Self { worths, block_starts, partners, blocks, landing_starts, landings }
    }

    /// Bytes that joining takes for so many patches, and that what comes out takes at most, where each found
    /// so many rays.
    pub(crate) fn bytes_for(patches: u64, rays: u64) -> u64 {
        let landings = 2 * patches * rays;
        let (all, joined) = (8 * landings, 40 * landings / MANY as u64);
        2 * all + joined.max(all)
    }

    /// Number of patches n.
    pub(crate) fn patches(&self) -> usize {
        self.worths.len()
    }

    /// Bytes that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        (40 * self.blocks.len() + 8 * self.landings.len() + 24 * self.worths.len()) as u64
    }

    /// y ← T x, `LANES` columns of x at a time, laid side by side.
    pub(crate) fn multiply<const LANES: usize>(&self, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
        let (n, channels) = (self.patches(), x.ncols());
        for first in (0..channels).step_by(LANES) {
            let used = LANES.min(channels - first);
            let lane = |i: usize, k: usize| if k < used { x[(i, first + k)] } else { 0.0 };
            let beside: Vec<Beside<LANES>> = (0..n)
                .map(|i| {
                    let corners = std::array::from_fn(|a| std::array::from_fn(|k| lane(3 * i + a, k)));
                    Beside::new(corners, self.worths[i])
                })
                .collect();
            let sums: Vec<[[f64; LANES]; 3]> =
                (0..n).into_par_iter().with_min_len(16).map(|i| self.times_row(i, &beside)).collect();
            for k in 0..used {
                let y = y.column_mut(first + k).into_iter();
                y.zip(sums.iter().flatten()).for_each(|(y, sum)| *y = sum[k]);
            }
        }
    }

    /// Three rows of T times x.
    fn times_row<const LANES: usize>(&self, i: usize, x: &[Beside<LANES>]) -> [[f64; LANES]; 3] {
        let mut sums = [[0.0; LANES]; 3];
        let range = self.block_starts[i]..self.block_starts[i + 1];
        for (&j, block) in self.partners[range.clone()].iter().zip(&self.blocks[range]) {
            let x = &x[j as usize].corners;
            for a in 0..3 {
                for b in 0..3 {
                    let value = f64::from(block[3 * a + b]);
                    for k in 0..LANES {
                        sums[a][k] += value * x[b][k];
                    }
                }
            }
        }
        // Sum up over rays the value of x where they end in the partner, plain and by both steps of where
        // they end here ...
        let (mut plain, mut by_u, mut by_v) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for landing in &self.landings[self.landing_starts[i]..self.landing_starts[i + 1]] {
            let x = &x[landing.partner as usize];
            let ([u, v], [here_u, here_v]) = (landing.there.steps(), landing.here.steps());
            let worth = worth_between(self.worths[i], x.worth);
            for k in 0..LANES {
                let value = worth * (x.origin[k] + u * x.slopes[0][k] + v * x.slopes[1][k]);
                plain[k] += value;
                by_u[k] += here_u * value;
                by_v[k] += here_v * value;
            }
        }
        // ... and share the sums out among the corners.
        for k in 0..LANES {
            let [a, b, c] = Spot::weights_of([by_u[k], by_v[k]], plain[k]);
            sums[0][k] += a;
            sums[1][k] += b;
            sums[2][k] += c;
        }
        sums
    }

    /// Multiplies every entry of every block by `factor(k, l)`, which must be symmetric, and 1 wherever no
    /// lamp is concerned.
    pub(crate) fn scale_blocks(&mut self, factor: impl Fn(usize, usize) -> f64 + Sync) {
        for i in 0..self.patches() {
            let range = self.block_starts[i]..self.block_starts[i + 1];
            for (&j, block) in self.partners[range.clone()].iter().zip(&mut self.blocks[range]) {
                for (entry, value) in block.iter_mut().enumerate() {
                    let factor = factor(3 * i + entry / 3, 3 * j as usize + entry % 3);
                    *value = (f64::from(*value) * factor) as f32;
                }
            }
        }
    }

    /// T_τ D T D T_τ with T_τ the shrinkage of each patch's three coefficients by τ.
    pub(crate) fn shrunk(self, scale: &DVector<f64>, tau: f64) -> Self {
        let n = self.patches();
        let row = |i: usize| -> Vec<(u32, Block)> {
            let mut row: Vec<(u32, [f64; 9])> = Vec::new();
            self.for_pairs(i, |j, block| row.push((j, block)));
            row.sort_unstable_by_key(|pair| pair.0);
            let scaled = |j: usize, block: [f64; 9]| -> [f64; 9] {
                std::array::from_fn(|e| (scale[3 * i + e / 3] * scale[3 * j + e % 3]) * block[e])
            };
            let shrunk = |(j, block): (u32, [f64; 9])| {
                let block = scaled(j as usize, block);
                // Always computed from the side of the lower number: the same bits for both.
                let shrunk = if (j as usize) < i {
                    transposed(shrunk_block(transposed(block), tau))
                } else {
                    shrunk_block(block, tau)
                };
                (j, shrunk.map(|x| x as f32))
            };
            row.into_iter().map(shrunk).collect()
        };
        let rows: Vec<Vec<(u32, Block)>> = (0..n).into_par_iter().map(row).collect();
        let mut block_starts = vec![0];
        rows.iter().for_each(|row| block_starts.push(block_starts[block_starts.len() - 1] + row.len()));
        let (partners, blocks) = rows.into_iter().flatten().unzip();
        let (landing_starts, landings) = (vec![0; n + 1], Vec::new());
        Self { worths: self.worths, block_starts, partners, blocks, landing_starts, landings }
    }

    /// Calls `f(j, block)` for every patch j that patch i exchanges anything with.
    fn for_pairs(&self, i: usize, mut f: impl FnMut(u32, [f64; 9])) {
        let range = self.block_starts[i]..self.block_starts[i + 1];
        for (&j, block) in self.partners[range.clone()].iter().zip(&self.blocks[range]) {
            f(j, block.map(f64::from));
        }
        let landings = &self.landings[self.landing_starts[i]..self.landing_starts[i + 1]];
        for pair in landings.chunk_by(|a, b| a.partner == b.partner) {
            let j = pair[0].partner;
            f(j, sum_of(pair, worth_between(self.worths[i], self.worths[j as usize])));
        }
    }

    /// Calls `f(l, T_kl)` for every entry of row k that is not zero.
    pub(crate) fn for_row(&self, k: usize, mut f: impl FnMut(usize, f64)) {
        let (i, a) = (k / 3, k % 3);
        self.for_pairs(i, |j, block| {
            let entries = (0..3).map(|b| (3 * j as usize + b, block[3 * a + b]));
            entries.filter(|entry| entry.1 != 0.0).for_each(|(l, value)| f(l, value));
        });
    }

    /// T_kl.
    pub(crate) fn get(&self, k: usize, l: usize) -> f64 {
        let (i, j, entry) = (k / 3, (l / 3) as u32, 3 * (k % 3) + l % 3);
        let first = self.block_starts[i];
        if let Ok(place) = self.partners[first..self.block_starts[i + 1]].binary_search(&j) {
            return f64::from(self.blocks[first + place][entry]);
        }
        let landings = &self.landings[self.landing_starts[i]..self.landing_starts[i + 1]];
        let start = landings.partition_point(|landing| landing.partner < j);
        let end = landings.partition_point(|landing| landing.partner <= j);
        sum_of(&landings[start..end], worth_between(self.worths[i], self.worths[j as usize]))[entry]
    }
}

/// What a product needs of one patch: x there, in both ways.
struct Beside<const LANES: usize> {
    corners: [[f64; LANES]; 3],
    /// x at no steps from the first corner, and how it changes by a step.
    origin: [f64; LANES],
    slopes: [[f64; LANES]; 2],
    /// A / N.
    worth: f64,
}

impl<const LANES: usize> Beside<LANES> {
    fn new(corners: [[f64; LANES]; 3], worth: f64) -> Self {
        let at = Spot::weights_of([0.0; 2], 1.0);
        let origin = std::array::from_fn(|k| (0..3).map(|a| at[a] * corners[a][k]).sum());
        let slope = |a: usize| std::array::from_fn(|k| (corners[a][k] - corners[0][k]) / Spot::STEPS);
        Self { corners, origin, slopes: [slope(1), slope(2)], worth }
    }
}

/// h = A_i A_j / ((A_i + A_j) N) from A_i / N and A_j / N; 0 where neither has an area.
#[inline]
fn worth_between(one: f64, other: f64) -> f64 {
    if one + other > 0.0 { one * other / (one + other) } else { 0.0 }
}

/// T_τ B T_τ.
pub fn shrunk_block(mut block: [f64; 9], tau: f64) -> [f64; 9] {
    shrink(&mut block, tau);
    let mut turned = transposed(block);
    shrink(&mut turned, tau);
    transposed(turned)
}

fn transposed(block: [f64; 9]) -> [f64; 9] {
    std::array::from_fn(|entry| block[3 * (entry % 3) + entry / 3])
}

/// Joins what a patch found and what it is told by others.
fn row(i: u32, found: &Findings, told: &Findings, worths: &[f64]) -> Row {
    let all = in_order(i, &found.landings, &told.landings);
    let mut blocks: Vec<(u32, Block)> = Vec::new();
    let mut lone = Vec::new();
    for pair in all.chunk_by(|a, b| a.partner == b.partner) {
        let j = pair[0].partner;
        if pair.len() < MANY {
            lone.extend_from_slice(pair);
        } else {
            let block = sum_of(pair, worth_between(worths[i as usize], worths[j as usize]));
            blocks.push((j, block.map(|x| x as f32)));
        }
    }
    // Only one of two patches is a lamp where there is anything to tell of lamps, and no ray counts between
    // them.
    let of_lamps = found.lamps.iter().chain(&told.lamps);
    blocks.extend(of_lamps.map(|&(j, block)| (j, block.map(|x| x as f32))));
    blocks.sort_unstable_by_key(|block| block.0);
    (blocks, lone)
}

/// The rays between patch i and others, by partner; first those that the patch of lower number sent, each
/// patch's in the order in which it sent them.
fn in_order(i: u32, sent: &[Landing], received: &[Landing]) -> Vec<Landing> {
    let sent = sent.iter().map(|landing| (landing.partner, landing.partner < i, *landing));
    let received = received.iter().map(|landing| (landing.partner, i < landing.partner, *landing));
    let mut all: Vec<(u32, bool, Landing)> = sent.chain(received).collect();
    all.sort_by_key(|&(partner, second, _)| (partner, second));
    all.into_iter().map(|(_, _, landing)| landing).collect()
}

/// Σ h φ_a φ_b over rays, with h the worth of each.
fn sum_of(rays: &[Landing], worth: f64) -> [f64; 9] {
    let mut sums = [0.0; 9];
    for ray in rays {
        let (here, there) = (ray.here.weights(), ray.there.weights());
        for (entry, sum) in sums.iter_mut().enumerate() {
            *sum += here[entry / 3] * there[entry % 3];
        }
    }
    sums.map(|sum| worth * sum)
}
