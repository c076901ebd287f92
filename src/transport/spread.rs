//! Spread: by how much each batch of rays, taken by itself, would change the irradiance that a field of light causes.
//!
//! Rays come in independent batches, and exchange areas are the mean of what these found: S = (1/8) Σ_b S_b. So (S_b − S) L is a sample of the
//! noise in S L. It is taken from the rays themselves, without making S_b. To first order in the noise the scales D follow it: where
//! a batch's row sums are off by g, balancing puts them right by u with (A + S) u = −g. Of that system, as of what u does to other rows, only what
//! varies slowly from patch to patch has to be solved, and that is done between a few hundred clusters of patches.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::assembly::Outcome;
use super::exchange::Exchange;
use super::landing::Spot;
use super::rays::{Row, Rows, origins};
use super::recipe::BATCHES;
use super::{FormFactors, TransportError};
use crate::patches::{Basis, Clusters, Patches};
use crate::scene::Side;

/// Columns that are taken at a time: three of the field, and one of ones for row sums.
const LANES: usize = 4;
type Lanes = [f64; LANES];
const ONES: usize = LANES - 1;

/// What irradiance each batch of rays would change, had it been the only one.
#[derive(Clone, Debug)]
pub struct Spread {
    /// By rays between surfaces: per batch n × c, W·m⁻².
    pub rays: Vec<DMatrix<f64>>,
    /// By light sampling and by rays that reach lamps by way of mirrors and glass: per batch n × c, W·m⁻².
    pub lamps: Vec<DMatrix<f64>>,
}

impl FormFactors {
    /// By how much each batch of rays changes the irradiance π M⁻¹ S L that radiance L (N × c) causes, averaged over patches. `clusters` are a
    /// few hundred at most, and `merged` is what they exchange, [`FormFactors::merged`].
    ///
    /// # Errors
    /// `NoRays` unless the rays were kept, or there were none.
    ///
    /// # Panics
    /// If `radiance` has not N rows, or `merged` not one row a cluster.
    pub fn spread(
        &self,
        patches: &Patches,
        radiance: &DMatrix<f64>,
        clusters: &Clusters,
        merged: &FormFactors,
    ) -> Result<Spread, TransportError> {
        let zero = || vec![DMatrix::zeros(patches.len(), radiance.ncols()); BATCHES as usize];
        if self.rays() == 0 {
            // Without rays there is nothing that chance could change.
            return Ok(Spread { rays: zero(), lamps: zero() });
        }
        let rows = self.rows().ok_or(TransportError::NoRays)?;
        assert!(
            radiance.nrows() == self.exchange().len() && merged.exchange().len() == clusters.count,
            "N × c, and a row a cluster"
        );
        let is_lamp = |i: usize| {
            let place = patches.place(i);
            place.side == Side::Front && rows.lamp_faces.binary_search(&(place.face as u32)).is_ok()
        };
        let channels = radiance.ncols();
        let mut spread = Spread { rays: zero(), lamps: zero() };
        for (tone, (exchange, merged)) in self.exchanges().iter().zip(merged.exchanges()).enumerate() {
            let setting = Setting {
                exchange,
                rows,
                row_of: (0..patches.len()).map(|i| rows.of(patches.slot_of_patch(i))).collect(),
                patches,
                tone,
                is_lamp: (0..patches.len()).map(is_lamp).collect(),
                clusters,
                merged,
            };
            let own: Vec<usize> = (0..channels).filter(|&c| self.tone_of(c) == tone).collect();
            let radiance = radiance.select_columns(&own);
            for (few, first) in own.chunks(ONES).zip((0..).step_by(ONES)) {
                let [rays, lamps] = setting.changes(&radiance, first);
                for (all, some) in [(&mut spread.rays, rays), (&mut spread.lamps, lamps)] {
                    for (all, some) in all.iter_mut().zip(some) {
                        for (lane, &c) in few.iter().enumerate() {
                            all.column_mut(c)
                                .iter_mut()
                                .zip(&some)
                                .for_each(|(all, lanes)| *all = lanes[lane]);
                        }
                    }
                }
            }
        }
        Ok(spread)
    }
}

/// All that the spread depends on.
struct Setting<'a> {
    exchange: &'a Exchange,
    rows: &'a Rows,
    row_of: Vec<Option<&'a Row>>,
    patches: &'a Patches<'a>,
    tone: usize,
    is_lamp: Vec<bool>,
    clusters: &'a Clusters,
    merged: &'a Exchange,
}

/// What S makes of the field, by patches.
struct Known {
    /// The field and ones, by coefficients; and the same times D.
    field: Vec<Lanes>,
    scaled: Vec<Lanes>,
    /// S times it, summed over each patch's coefficients; and the part of it that comes straight from lamps.
    all: Vec<Lanes>,
    from_lamps: Vec<Lanes>,
    /// Patches that lamps all but fill, whose lamp entries are scaled with the rest.
    flooded: Vec<bool>,
}

impl Setting<'_> {
    /// Per batch and patch the change of irradiance, by rays and by lamps, of three columns of the field.
    fn changes(&self, radiance: &DMatrix<f64>, first: usize) -> [Vec<Vec<Lanes>>; 2] {
        let known = self.known(radiance, first);
        // A batch to a thread: each scatters into sums of its own, in the order of the rays.
        let (mut rays, mut lamps): (Vec<_>, Vec<_>) = (0..BATCHES as usize)
            .into_par_iter()
            .map(|batch| match self.exchange.basis() {
                Basis::Constant => self.found_by::<1>(batch, &known, |_| [1.0]),
                Basis::Linear => self.found_by::<3>(batch, &known, Spot::weights),
            })
            .unzip();
        take_off_mean(&mut rays);
        take_off_mean(&mut lamps);
        self.take_off_excess(&mut lamps, &known);
        let balance = Balance::new(self, &known);
        [rays, lamps].map(|mut kind| {
            kind.par_iter_mut().for_each(|batch| {
                balance.put_right(batch);
                for (lanes, area) in batch.iter_mut().zip(self.patches.etendues()) {
                    lanes.iter_mut().for_each(|lane| *lane *= std::f64::consts::PI / area);
                }
            });
            kind
        })
    }

    fn known(&self, radiance: &DMatrix<f64>, first: usize) -> Known {
        let (_, scale) = self.exchange.raw();
        let channels = radiance.ncols().min(first + ONES) - first;
        let lane = |k: usize, c: usize| match c {
            ONES => 1.0,
            c if c < channels => radiance[(k, first + c)],
            _ => 0.0,
        };
        let field: Vec<Lanes> = (0..radiance.nrows()).map(|k| std::array::from_fn(|c| lane(k, c))).collect();
        let scaled = field.iter().zip(scale).map(|(lanes, d)| lanes.map(|x| d * x)).collect();
        let each = self.exchange.basis().coefficients();
        let times = |only_lamps: bool| -> Vec<Lanes> {
            let x = DMatrix::from_fn(field.len(), LANES, |k, c| {
                if only_lamps && !self.is_lamp[k / each] { 0.0 } else { field[k][c] }
            });
            let mut y = DMatrix::zeros(field.len(), LANES);
            self.exchange.apply(&x, &mut y);
            let of_patch = |i: usize| std::array::from_fn(|c| (0..each).map(|a| y[(each * i + a, c)]).sum());
            (0..self.patches.len()).map(of_patch).collect()
        };
        let (all, from_lamps) = (times(false), times(true));
        let fills = |i: usize| from_lamps[i][ONES] > super::balance::FLOODED * self.patches.etendues()[i];
        let flooded = (0..self.patches.len()).map(|i| !self.is_lamp[i] && fills(i)).collect();
        Known { field, scaled, all, from_lamps, flooded }
    }

    /// What one batch makes of S times the field, summed over each patch's coefficients: by rays, and by lamps.
    fn found_by<const K: usize>(
        &self,
        batch: usize,
        known: &Known,
        phi: impl Fn(Spot) -> [f64; K],
    ) -> (Vec<Lanes>, Vec<Lanes>) {
        let (_, scale) = self.exchange.raw();
        let areas = self.patches.etendues();
        let n = areas.len();
        let recipe = self.rows.recipe;
        let batch_size = (recipe.count.rays / BATCHES) as usize;
        let stretch = batch * batch_size..(batch + 1) * batch_size;
        let (mut rays, mut lamps) = (vec![[0.0; LANES]; n], vec![[0.0; LANES]; n]);
        // The field at a spot, and what a spot's share is scaled by.
        let at = |field: &[Lanes], i: usize, phi: &[f64; K]| -> Lanes {
            std::array::from_fn(|c| (0..K).map(|a| phi[a] * field[K * i + a][c]).sum())
        };
        let scale_at = |i: usize, phi: &[f64; K]| -> f64 { (0..K).map(|a| phi[a] * scale[K * i + a]).sum() };
        let add = |sum: &mut Lanes, worth: f64, x: &Lanes| {
            sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += worth * x);
        };
        for (i, row) in self.row_of.iter().enumerate() {
            let Some(row) = row else { continue };
            let spots = |k: usize| row.spots.get(k).copied().unwrap_or_default();
            let mut starts = (K > 1).then(|| origins(row.slot, recipe).skip(stretch.start));
            for (end, k) in row.ends(stretch.clone(), self.tone).zip(stretch.clone()) {
                let here = phi(starts.as_mut().and_then(Iterator::next).unwrap_or_default());
                match Outcome::of(end, self.patches) {
                    Outcome::Left(_) => {
                        rays[i][ONES] += scale_at(i, &here) * areas[i] / batch_size as f64;
                    }
                    Outcome::Met { patch, carried } => {
                        let (j, there) = (patch as usize, phi(spots(k)));
                        if self.is_lamp[j] == self.is_lamp[i] {
                            let worth = areas[i] * areas[j] / (areas[i] + areas[j]) / batch_size as f64;
                            add(&mut rays[i], worth * scale_at(i, &here), &at(&known.scaled, j, &there));
                            add(&mut rays[j], worth * scale_at(j, &there), &at(&known.scaled, i, &here));
                        } else if carried && !self.is_lamp[i] {
                            self.add_lamp(
                                &mut lamps,
                                (i, j),
                                self.carried_worth(i, j),
                                known,
                                &[(here, there, 1.0)],
                            );
                        }
                    }
                }
            }
            if self.is_lamp[i] {
                continue;
            }
            let caustics = self.rows.caustics.of(row.slot, self.tone, None);
            for caustic in caustics.filter(|c| usize::from(c.batch) == batch) {
                if let Some(j) = self.patches.patch_of_slot(caustic.lamp) {
                    let [here, there] = caustic.ends.map(&phi);
                    let j = j as usize;
                    self.add_lamp(&mut lamps, (i, j), self.carried_worth(i, j), known, &[(here, there, 1.0)]);
                }
            }
            let shares =
                row.lamps.shares.iter().enumerate().filter(|(_, share)| share.batch as usize == batch);
            for (k, share) in shares {
                let Some(j) = self.patches.patch_of_slot(share.slot) else { continue };
                let worth = areas[i] * f64::from(BATCHES);
                // All moments of a pair as so many spots, each in one corner.
                if let Some(moments) = row.lamps.moments.get(k).filter(|_| K > 1) {
                    let corner =
                        |a: usize| -> [f64; K] { std::array::from_fn(|b| f64::from(u8::from(a == b))) };
                    let parts: [_; 9] =
                        std::array::from_fn(|m| (corner(m / 3), corner(m % 3), f64::from(moments[m])));
                    self.add_lamp(&mut lamps, (i, j as usize), worth, known, &parts);
                } else {
                    let part = ([1.0; K], [1.0; K], f64::from(share.share));
                    self.add_lamp(&mut lamps, (i, j as usize), worth, known, &[part]);
                }
            }
        }
        (rays, lamps)
    }

    /// What a ray by way of carriers between a receiver and a lamp patch is worth to its batch.
    fn carried_worth(&self, i: usize, j: usize) -> f64 {
        let areas = self.patches.etendues();
        let rays = f64::from(self.rows.recipe.count.rays);
        f64::from(BATCHES) * self.rows.caustics.worth([areas[i], areas[j]], rays, BATCHES)
    }

    /// Adds what receiver i and lamp patch j exchange: pairs of weights of their coefficients, with the share of `worth` that is theirs. Such
    /// entries have the lamp's scale alone, unless lamps fill the receiver.
    fn add_lamp<const K: usize>(
        &self,
        lamps: &mut [Lanes],
        (i, j): (usize, usize),
        worth: f64,
        known: &Known,
        parts: &[([f64; K], [f64; K], f64)],
    ) {
        let (_, scale) = self.exchange.raw();
        for (here, there, share) in parts.iter().filter(|part| part.2 != 0.0) {
            for a in (0..K).filter(|&a| here[a] != 0.0) {
                let own = if known.flooded[i] { scale[K * i + a] } else { 1.0 };
                for b in (0..K).filter(|&b| there[b] != 0.0) {
                    let worth = worth * share * here[a] * there[b] * own * scale[K * j + b];
                    let add = |sums: &mut Lanes, field: &Lanes| {
                        sums.iter_mut().zip(field).for_each(|(sum, x)| *sum += worth * x);
                    };
                    add(&mut lamps[i], &known.field[K * j + b]);
                    add(&mut lamps[j], &known.field[K * i + a]);
                }
            }
        }
    }

    /// Takes off what pairs of points found too much only because too many of them were bright.
    fn take_off_excess(&self, lamps: &mut [Vec<Lanes>], known: &Known) {
        let excess = |i: usize, batch: usize| {
            self.row_of[i].filter(|_| !self.is_lamp[i]).map_or(0.0, |row| f64::from(row.lamps.excess[batch]))
        };
        for (batch, sums) in lamps.iter_mut().enumerate() {
            for (i, sum) in sums.iter_mut().enumerate() {
                let excess = excess(i, batch);
                sum.iter_mut().zip(&known.from_lamps[i]).for_each(|(sum, x)| *sum -= excess * x);
            }
        }
        let each = self.exchange.basis().coefficients();
        for j in (0..self.is_lamp.len()).filter(|&j| self.is_lamp[j]) {
            for b in 0..each {
                self.exchange.for_row(each * j + b, |k, area| {
                    for (batch, sums) in lamps.iter_mut().enumerate() {
                        let excess = area * excess(k / each, batch);
                        sums[j].iter_mut().zip(&known.field[k]).for_each(|(sum, x)| *sum -= excess * x);
                    }
                });
            }
        }
    }
}

fn take_off_mean(batches: &mut [Vec<Lanes>]) {
    for i in 0..batches[0].len() {
        for c in 0..LANES {
            let mean = batches.iter().map(|batch| batch[i][c]).sum::<f64>() / batches.len() as f64;
            batches.iter_mut().for_each(|batch| batch[i][c] -= mean);
        }
    }
}

/// How balancing answers to row sums that are off.
struct Balance<'a> {
    setting: &'a Setting<'a>,
    known: &'a Known,
    /// The field averaged over each patch.
    field: Vec<Lanes>,
    /// Per patch, what rays have to fill.
    target: Vec<f64>,
    /// Per cluster the same; and which clusters are lamps.
    cluster_target: DVector<f64>,
    /// What clusters that are no lamps exchange.
    between: DMatrix<f64>,
    /// (target + S)⁻¹ between clusters.
    solver: Option<nalgebra::Cholesky<f64, nalgebra::Dyn>>,
}

impl<'a> Balance<'a> {
    fn new(setting: &'a Setting<'a>, known: &'a Known) -> Self {
        let Setting { patches, is_lamp, clusters, merged, .. } = setting;
        let n = patches.len();
        let each = setting.exchange.basis().coefficients();
        let mean = |i: usize| {
            std::array::from_fn(|c| {
                (0..each).map(|a| known.field[each * i + a][c]).sum::<f64>() / each as f64
            })
        };
        let target: Vec<f64> = (0..n)
            .map(|i| {
                let lamps = if is_lamp[i] || known.flooded[i] { 0.0 } else { known.from_lamps[i][ONES] };
                (patches.etendues()[i] - lamps).max(0.05 * patches.etendues()[i])
            })
            .collect();
        let mut cluster_target = DVector::zeros(clusters.count);
        let mut lamp_cluster = vec![false; clusters.count];
        for i in 0..n {
            if is_lamp[i] {
                lamp_cluster[clusters.of_patch[i]] = true;
            } else {
                cluster_target[clusters.of_patch[i]] += target[i];
            }
        }
        let takes_part = |g: usize| !lamp_cluster[g];
        let mut between = DMatrix::zeros(clusters.count, clusters.count);
        for g in (0..clusters.count).filter(|&g| takes_part(g)) {
            merged.for_row(g, |h, area| {
                if takes_part(h) {
                    between[(h, g)] = area
                }
            });
        }
        cluster_target.iter_mut().filter(|target| **target == 0.0).for_each(|target| *target = 1.0);
        let solver = nalgebra::Cholesky::new(&between + DMatrix::from_diagonal(&cluster_target));
        let field = (0..n).map(mean).collect();
        Self { setting, known, field, target, cluster_target, between, solver }
    }

    /// Adds to a batch's change what balancing does about it.
    fn put_right(&self, change: &mut [Lanes]) {
        let Setting { exchange, patches, is_lamp, clusters, .. } = self.setting;
        let areas = patches.etendues();
        let each = exchange.basis().coefficients();
        // Each lamp closes its own row, and with it changes its entries in all others ...
        let mut to_others = vec![[0.0; LANES]; change.len()];
        for j in (0..change.len()).filter(|&j| is_lamp[j]) {
            let u = -change[j][ONES] / areas[j];
            change[j].iter_mut().zip(&self.known.all[j]).for_each(|(change, x)| *change += u * x);
            for b in 0..each {
                exchange.for_row(each * j + b, |k, area| {
                    let to = &mut to_others[k / each];
                    to.iter_mut()
                        .zip(&self.known.field[each * j + b])
                        .for_each(|(to, x)| *to += u * area * x);
                });
            }
        }
        // ... then rays share out among them what is lacking.
        let mut lacking = DVector::zeros(clusters.count);
        for i in (0..change.len()).filter(|&i| !is_lamp[i]) {
            change[i].iter_mut().zip(&to_others[i]).for_each(|(change, to)| *change += to);
            lacking[clusters.of_patch[i]] -= change[i][ONES];
        }
        let Some(solver) = &self.solver else { return };
        let smooth = &self.between * solver.solve(&lacking);
        let mut moved = DMatrix::zeros(clusters.count, LANES);
        let mut scale = vec![0.0; change.len()];
        for i in (0..change.len()).filter(|&i| !is_lamp[i]) {
            let cluster = clusters.of_patch[i];
            scale[i] = -change[i][ONES] / self.target[i] - smooth[cluster] / self.cluster_target[cluster];
            for c in 0..LANES {
                moved[(cluster, c)] += scale[i] * areas[i] * self.field[i][c];
            }
        }
        let cluster_areas = self.setting.merged.areas();
        for g in 0..clusters.count {
            moved.row_mut(g).scale_mut(1.0 / cluster_areas[g]);
        }
        let arriving = &self.between * moved;
        for i in (0..change.len()).filter(|&i| !is_lamp[i]) {
            let cluster = clusters.of_patch[i];
            let part = areas[i] / cluster_areas[cluster];
            for c in 0..LANES {
                let by_rays = self.known.all[i][c]
                    - if self.known.flooded[i] { 0.0 } else { self.known.from_lamps[i][c] };
                change[i][c] += scale[i] * by_rays + part * arriving[(cluster, c)];
            }
        }
    }
}
