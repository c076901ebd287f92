//! Spread: by how much each batch of rays, taken by itself, would change the irradiance that a field of light
//! causes.
//!
//! Rays come in independent batches, and exchange areas are the mean of what these found: S = (1/8) Σ_b S_b.
//! So (S_b − S) L is a sample of the noise in S L. It is taken from the rays themselves, without making S_b.
//! To first order in the noise the scales D follow it: where a batch's row sums are off by g, balancing puts
//! them right by u with (A + S) u = −g. Of that system, as of what u does to other rows, only what varies
//! slowly from patch to patch has to be solved, and that is done between a few hundred clusters of patches.
//! Scales of rows with slack are at their bound and stay there: u = 0.
//!
//! Linear elements are taken for constant ones with their means: what light does within a patch changes
//! little of the noise of the whole.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::FormFactors;
use super::constants::{HELD, LEAST_TARGET};
use crate::patches::{Clusters, Patches};
use crate::transport::TransportError;
use crate::transport::exchange::{Exchange, FLOODED, Outcome};
use crate::transport::rows::{BATCHES, Row, Rows};

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
    /// By how much each batch of rays changes the irradiance π M⁻¹ S L that radiance L, averaged over patches
    /// (n × c), causes on average. `by_patch` are these form factors with constant elements; `clusters` are a
    /// few hundred at most, and `merged` is what they exchange; see [`FormFactors::by_patch`] and
    /// [`FormFactors::merged`].
    ///
    /// # Errors
    /// `NoRays` unless the rays were kept, or there were none.
    ///
    /// # Panics
    /// If `radiance` or `by_patch` has not n rows, or `merged` not one row a cluster.
    pub fn spread(
        &self,
        patches: &Patches,
        radiance: &DMatrix<f64>,
        by_patch: &FormFactors,
        Merged { clusters, factors: merged }: Merged,
    ) -> Result<Spread, TransportError> {
        let n = patches.len();
        let zero = || vec![DMatrix::zeros(n, radiance.ncols()); BATCHES as usize];
        if self.rays() == 0 {
            // Without rays there is nothing that chance could change.
            return Ok(Spread { rays: zero(), lamps: zero() });
        }
        let rows = self.rows().ok_or(TransportError::NoRays)?;
        assert!(
            radiance.nrows() == n
                && by_patch.exchange().len() == n
                && merged.exchange().len() == clusters.count,
            "n × c, a row a patch, and a row a cluster"
        );
        let channels = radiance.ncols();
        let mut spread = Spread { rays: zero(), lamps: zero() };
        for (tone, exchange) in self.exchanges().iter().enumerate() {
            let of_tone = OfTone {
                tone,
                exchange,
                by_patch: &by_patch.exchanges()[tone],
                merged: &merged.exchanges()[tone],
            };
            let setting = Setting::new(rows, patches, clusters, of_tone);
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

/// A few hundred clusters of patches and what they exchange.
#[derive(Clone, Copy)]
pub struct Merged<'a> {
    /// The clusters.
    pub clusters: &'a Clusters,
    /// The form factors between them.
    pub factors: &'a FormFactors,
}

/// What is exchanged in a tone: by the elements at hand, by patch and by cluster.
struct OfTone<'a> {
    tone: usize,
    exchange: &'a Exchange,
    by_patch: &'a Exchange,
    merged: &'a Exchange,
}

/// All that the spread depends on.
struct Setting<'a> {
    rows: &'a Rows,
    tone: usize,
    row_of: Vec<Option<&'a Row>>,
    patches: &'a Patches<'a>,
    /// What balancing scaled each patch by; of linear elements the mean over the patch.
    scale: Vec<f64>,
    is_lamp: Vec<bool>,
    /// Lamp patches and all that each exchanges.
    lamps: Vec<(usize, Vec<(u32, f64)>)>,
    by_patch: &'a Exchange,
    clusters: &'a Clusters,
    merged: &'a Exchange,
}

/// What S makes of the field, by patches.
struct Known {
    /// The field and ones; and the same times D.
    field: Vec<Lanes>,
    scaled: Vec<Lanes>,
    /// S times it; and the part of it that comes straight from lamps.
    all: Vec<Lanes>,
    from_lamps: Vec<Lanes>,
    /// Patches that lamps all but fill, whose lamp entries are scaled with the rest.
    flooded: Vec<bool>,
}

/// What a ray or a pair of points between receiver i and lamp patch j is worth.
struct LampPair {
    i: usize,
    j: usize,
    worth: f64,
}

/// sum ← sum + worth · x.
#[inline]
fn add(sum: &mut Lanes, worth: f64, x: &Lanes) {
    sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += worth * x);
}

impl<'a> Setting<'a> {
    fn new(rows: &'a Rows, patches: &'a Patches<'a>, clusters: &'a Clusters, of_tone: OfTone<'a>) -> Self {
        let OfTone { tone, exchange, by_patch, merged } = of_tone;
        let n = patches.len();
        let each = exchange.basis().coefficients();
        let (_, scale) = exchange.raw();
        let scale = scale.as_slice().chunks(each).map(|of_patch| of_patch.iter().sum::<f64>() / each as f64);
        let is_lamp: Vec<bool> = (0..n).map(|i| rows.is_lamp(patches, i)).collect();
        let exchanged = |j: usize| {
            let mut all = Vec::new();
            by_patch.for_entries(j, |k, area| all.push((k as u32, area)));
            (j, all)
        };
        let lamps: Vec<usize> = (0..n).filter(|&j| is_lamp[j]).collect();
        Self {
            rows,
            tone,
            row_of: (0..n).map(|i| rows.of(patches.slot_of_patch(i))).collect(),
            patches,
            scale: scale.collect(),
            is_lamp,
            lamps: lamps.into_par_iter().map(exchanged).collect(),
            by_patch,
            clusters,
            merged,
        }
    }

    /// Per batch and patch the change of irradiance, by rays and by lamps, of three columns of the field.
    fn changes(&self, radiance: &DMatrix<f64>, first: usize) -> [Vec<Vec<Lanes>>; 2] {
        let known = self.known(radiance, first);
        // A batch to a thread: each scatters into sums of its own, in the order of the rays.
        let (mut rays, mut lamps): (Vec<_>, Vec<_>) =
            (0..BATCHES as usize).into_par_iter().map(|batch| self.found_by(batch, &known)).unzip();
        take_off_mean(&mut rays);
        take_off_mean(&mut lamps);
        self.take_off_excess(&mut lamps, &known);
        let balance = Balance::new(self, &known);
        let mut all = [rays, lamps];
        all.par_iter_mut().flatten().for_each(|batch| {
            balance.put_right(batch);
            for (lanes, area) in batch.iter_mut().zip(self.patches.normalised_etendues()) {
                lanes.iter_mut().for_each(|lane| *lane *= std::f64::consts::PI / area);
            }
        });
        all
    }

    fn known(&self, radiance: &DMatrix<f64>, first: usize) -> Known {
        let n = self.patches.len();
        let channels = radiance.ncols().min(first + ONES) - first;
        let lane = |i: usize, c: usize| match c {
            ONES => 1.0,
            c if c < channels => radiance[(i, first + c)],
            _ => 0.0,
        };
        let x = DMatrix::from_fn(n, LANES, lane);
        let mut y = DMatrix::zeros(n, LANES);
        self.by_patch.apply(&x, &mut y);
        let lanes_of =
            |m: &DMatrix<f64>| -> Vec<Lanes> { (0..n).map(|i| std::array::from_fn(|c| m[(i, c)])).collect() };
        let (field, all) = (lanes_of(&x), lanes_of(&y));
        let scaled = field.iter().zip(&self.scale).map(|(lanes, d)| lanes.map(|x| d * x)).collect();
        let mut from_lamps = vec![[0.0; LANES]; n];
        for (j, exchanged) in &self.lamps {
            exchanged.iter().for_each(|&(k, area)| add(&mut from_lamps[k as usize], area, &field[*j]));
        }
        let fills = |i: usize| from_lamps[i][ONES] > FLOODED * self.patches.normalised_etendues()[i];
        let flooded = (0..n).map(|i| !self.is_lamp[i] && fills(i)).collect();
        Known { field, scaled, all, from_lamps, flooded }
    }

    /// What one batch makes of S times the field: by rays, and by lamps.
    fn found_by(&self, batch: usize, known: &Known) -> (Vec<Lanes>, Vec<Lanes>) {
        let areas = self.patches.normalised_etendues();
        let batch_size = (self.rows.recipe.count.rays / BATCHES) as usize;
        let stretch = batch * batch_size..(batch + 1) * batch_size;
        let zero = vec![[0.0; LANES]; areas.len()];
        let (mut rays, mut lamps) = (zero.clone(), zero);
        for (i, row) in self.row_of.iter().enumerate() {
            let Some(row) = row else { continue };
            for end in row.ends(stretch.clone(), self.tone) {
                match Outcome::of(end, self.patches) {
                    Outcome::Left(_) => rays[i][ONES] += self.scale[i] * areas[i] / batch_size as f64,
                    Outcome::Met { patch, carried } => {
                        let j = patch as usize;
                        if self.is_lamp[j] == self.is_lamp[i] {
                            let worth = areas[i] * areas[j] / (areas[i] + areas[j]) / batch_size as f64;
                            add(&mut rays[i], worth * self.scale[i], &known.scaled[j]);
                            add(&mut rays[j], worth * self.scale[j], &known.scaled[i]);
                        } else if carried && !self.is_lamp[i] {
                            let worth = self.carried_worth(i, j);
                            self.add_lamp(&mut lamps, LampPair { i, j, worth }, known);
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
                    let (j, worth) = (j as usize, self.carried_worth(i, j as usize));
                    self.add_lamp(&mut lamps, LampPair { i, j, worth }, known);
                }
            }
            for share in row.lamps.shares.iter().filter(|share| share.batch as usize == batch) {
                if let Some(j) = self.patches.patch_of_slot(share.slot) {
                    let worth = areas[i] * f64::from(BATCHES) * f64::from(share.share);
                    self.add_lamp(&mut lamps, LampPair { i, j: j as usize, worth }, known);
                }
            }
        }
        (rays, lamps)
    }

    /// What a ray by way of carriers between a receiver and a lamp patch is worth to its batch.
    fn carried_worth(&self, i: usize, j: usize) -> f64 {
        let areas = self.patches.normalised_etendues();
        let rays = f64::from(self.rows.recipe.count.rays);
        f64::from(BATCHES) * self.rows.caustics.worth([areas[i], areas[j]], rays, BATCHES)
    }

    /// Adds what a receiver and a lamp patch exchange. Such entries have the lamp's scale alone, unless lamps
    /// fill the receiver.
    fn add_lamp(&self, lamps: &mut [Lanes], LampPair { i, j, worth }: LampPair, known: &Known) {
        let own = if known.flooded[i] { self.scale[i] } else { 1.0 };
        let worth = worth * own * self.scale[j];
        add(&mut lamps[i], worth, &known.field[j]);
        add(&mut lamps[j], worth, &known.field[i]);
    }

    /// Takes off what pairs of points found too much only because too many of them were bright.
    fn take_off_excess(&self, lamps: &mut [Vec<Lanes>], known: &Known) {
        let excess_of = |i: usize| match self.row_of[i] {
            Some(row) if !self.is_lamp[i] => row.lamps.excess.map(f64::from),
            _ => [0.0; BATCHES as usize],
        };
        let excess: Vec<_> = (0..self.is_lamp.len()).map(excess_of).collect();
        lamps.par_iter_mut().enumerate().for_each(|(batch, sums)| {
            for ((sum, excess), from_lamps) in sums.iter_mut().zip(&excess).zip(&known.from_lamps) {
                add(sum, -excess[batch], from_lamps);
            }
            for (j, exchanged) in &self.lamps {
                for &(k, area) in exchanged {
                    let k = k as usize;
                    add(&mut sums[*j], -area * excess[k][batch], &known.field[k]);
                }
            }
        });
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
    /// Per patch, what rays have to fill.
    target: Vec<f64>,
    /// Per patch, whether its scale follows what rays find; of lamps, whether theirs closes their own row.
    follows: Vec<bool>,
    /// Per cluster, what rays have to fill of rows that follow; 1 for lamps.
    cluster_target: DVector<f64>,
    /// Per cluster, the part of its area whose scale follows.
    following: DVector<f64>,
    /// What clusters that are no lamps exchange.
    between: DMatrix<f64>,
    /// (target + S)⁻¹ between what follows of clusters.
    solver: Option<nalgebra::Cholesky<f64, nalgebra::Dyn>>,
}

impl<'a> Balance<'a> {
    fn new(setting: &'a Setting<'a>, known: &'a Known) -> Self {
        let Setting { patches, is_lamp, clusters, merged, by_patch, .. } = setting;
        let n = patches.len();
        let target: Vec<f64> = (0..n)
            .map(|i| {
                let lamps = if is_lamp[i] || known.flooded[i] { 0.0 } else { known.from_lamps[i][ONES] };
                (patches.normalised_etendues()[i] - lamps)
                    .max(LEAST_TARGET * patches.normalised_etendues()[i])
            })
            .collect();
        let follows: Vec<bool> = patches
            .normalised_etendues()
            .iter()
            .zip(&by_patch.ends().slack)
            .map(|(a, slack)| *slack <= HELD * a)
            .collect();
        let mut cluster_target = DVector::zeros(clusters.count);
        let [mut following, mut areas] = [0, 0].map(|_| DVector::<f64>::zeros(clusters.count));
        let mut lamp_cluster = vec![false; clusters.count];
        for i in 0..n {
            areas[clusters.of_patch[i]] += patches.normalised_etendues()[i];
            if is_lamp[i] {
                lamp_cluster[clusters.of_patch[i]] = true;
            } else if follows[i] {
                cluster_target[clusters.of_patch[i]] += target[i];
                following[clusters.of_patch[i]] += patches.normalised_etendues()[i];
            }
        }
        let takes_part = |g: usize| !lamp_cluster[g];
        let mut between = DMatrix::zeros(clusters.count, clusters.count);
        for g in (0..clusters.count).filter(|&g| takes_part(g)) {
            merged.for_entries(g, |h, area| {
                if takes_part(h) {
                    between[(h, g)] = area
                }
            });
        }
        cluster_target.iter_mut().filter(|target| **target == 0.0).for_each(|target| *target = 1.0);
        following.component_div_assign(&areas);
        let part = |g: usize, h: usize| following[g] * following[h] * between[(g, h)];
        let system = DMatrix::from_fn(clusters.count, clusters.count, part);
        let solver = nalgebra::Cholesky::new(system + DMatrix::from_diagonal(&cluster_target));
        Self { setting, known, target, follows, cluster_target, following, between, solver }
    }

    /// Adds to a batch's change what balancing does about it.
    fn put_right(&self, change: &mut [Lanes]) {
        let Setting { patches, is_lamp, clusters, .. } = self.setting;
        let areas = patches.normalised_etendues();
        // Each lamp closes its own row, and with it changes its entries in all others ...
        let mut to_others = vec![[0.0; LANES]; change.len()];
        for (j, exchanged) in self.setting.lamps.iter().filter(|(j, _)| self.follows[*j]) {
            let u = -change[*j][ONES] / areas[*j];
            add(&mut change[*j], u, &self.known.all[*j]);
            for &(k, area) in exchanged {
                add(&mut to_others[k as usize], u * area, &self.known.field[*j]);
            }
        }
        // ... then rays share out among them what is lacking.
        let mut lacking = DVector::zeros(clusters.count);
        for i in (0..change.len()).filter(|&i| !is_lamp[i]) {
            change[i].iter_mut().zip(&to_others[i]).for_each(|(change, to)| *change += to);
            if self.follows[i] {
                lacking[clusters.of_patch[i]] -= change[i][ONES];
            }
        }
        let Some(solver) = &self.solver else { return };
        let smooth = &self.between * solver.solve(&lacking).component_mul(&self.following);
        let mut moved = DMatrix::zeros(clusters.count, LANES);
        let mut scale = vec![0.0; change.len()];
        for i in (0..change.len()).filter(|&i| !is_lamp[i] && self.follows[i]) {
            let cluster = clusters.of_patch[i];
            scale[i] = -change[i][ONES] / self.target[i] - smooth[cluster] / self.cluster_target[cluster];
            for c in 0..LANES {
                moved[(cluster, c)] += scale[i] * areas[i] * self.known.field[i][c];
            }
        }
        let cluster_areas = self.setting.merged.sums();
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
