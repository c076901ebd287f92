//! Lamp columns: the form factors from a patch to lamps, by light sampling.
//!
//! M points y drawn on lamps are paired with points x on the patch, with density p; where the lamp is near, x
//! is drawn by the solid angle seen from y. A pair with geometry term g and emitted radiance Lₑ weighs w = Lₑ
//! g/p, whether or not its points see each other; the mean weight estimates what Lambert's formula gives
//! exactly, the unoccluded light U, averaged over the patch. So each pair on lamp patch j whose points do see
//! each other is worth
//!
//! (U / Σw) · g/p
//!
//! of the form factor to j; under a coat, times (1 − E)/(1 − Ē) of the angle. Where nothing is hidden or
//! coated the light of all lamps is exact. A ratio of two means is biased by some 1/M of their spread;
//! leaving out each batch of pairs in turn (Quenouille 1956) takes that off, to less than 0.1 % (the tests
//! measure it).
//!
//! Rays find lamps too, each hit worth 1/N. The two estimates are averaged with weights that are inverse to
//! their variances, as far as these can be told beforehand: F/N for rays, F²(1 + κ)/4M for light sampling,
//! with κ the relative variance of the weights.

use crate::patches::{Basis, Facet};
use crate::scene::Side;
use crate::trace::sampling::Stream;
use crate::trace::{Lamps, geometry_term};

use super::landing::Spot;
use super::recipe::{BATCHES, Recipe, Setting};

/// What a batch found of the form factor to a lamp patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampShare {
    /// The lamp patch's slot.
    pub slot: u32,
    pub batch: u32,
    /// Part of the form factor from the receiver to the lamp patch; all batches add up to the whole.
    pub share: f32,
}

/// What a patch saw of lamps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Look {
    /// By batch, then lamp patch.
    pub shares: Vec<LampShare>,
    /// Each share once more, split by pairs of basis functions, first the receiver's; nothing for constant
    /// elements.
    pub moments: Vec<[f32; 9]>,
    /// By how much more than an eighth of all weight fell to each batch, relative to that, as far as shares
    /// are taken from pairs: where the light of all lamps is known, so much more of a batch's share is
    /// chance.
    pub excess: [f32; BATCHES as usize],
}

/// A ray or pair that shows a lamp.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The lamp patch's slot.
    pub slot: u32,
    pub batch: u32,
    /// Where on the receiver and on the lamp patch it ends; of no account for constant elements.
    pub ends: [Spot; 2],
}

/// A pair whose points face each other.
struct Pair {
    seen: Seen,
    /// g/p.
    weight: f64,
    /// Which part of it arrives: none where it is hidden, and of what is not as much as a coat lets through.
    arriving: f64,
}

/// The form factors from the facet of `slot` to lamps. `hits` are the rays that landed on lamps.
pub fn look_at_lamps(
    &Setting { tracer, patches, recipe, .. }: &Setting,
    lamps: &Lamps,
    (slot, facet): (u32, Facet),
    hits: impl Iterator<Item = Seen>,
) -> Look {
    let Recipe { count, seed, basis } = recipe;
    let view = lamps.view_over(&facet.corners, facet.normal);
    // Draw the pairs, and see which are visible.
    let mut pairs = Vec::with_capacity(count.lamp_rays as usize);
    let mut bright = [0.0; BATCHES as usize];
    let (mut sum, mut squares) = (0.0, 0.0);
    for batch in 0..BATCHES {
        let pairs_now = count.lamp_rays / BATCHES;
        let (sequence, stretch) = Stream::LampPairs.stretch(seed, slot, batch as u64, pairs_now);
        for k in stretch {
            let [s, t, u, v] = sequence.point(k);
            let Some(to) = lamps.sample(&view, [u, v]) else { break };
            let here = facet.target(to.point, [s, t]);
            let from = here.point;
            let g = geometry_term((from, facet.normal), (to.point, to.normal));
            if g == 0.0 {
                continue;
            }
            let weight = g / (to.pdf * here.density);
            bright[batch as usize] += weight * to.brightness;
            sum += weight;
            squares += weight * weight;
            let slot = patches.slot_at(to.face as usize, Side::Front, to.barycentrics);
            let visible = tracer.unoccluded((from, facet.face), (to.point, to.face));
            let arriving = if visible { facet.weight((to.point - from).normalize()) } else { 0.0 };
            let ends = match basis {
                Basis::Constant => [Spot::default(); 2],
                Basis::Linear => [here.barycentrics, patches.weights_in(slot, to.barycentrics)].map(Spot::at),
            };
            pairs.push(Pair { seen: Seen { slot, batch, ends }, weight, arriving });
        }
    }
    // Scale the pairs to the unoccluded light, where that is known.
    let (m, n) = (count.lamp_rays as f64, count.rays as f64);
    // A lamp may be seen from between the points of Lambert's formula only: then the pairs have to do by
    // themselves.
    let known = view.unoccluded.filter(|&light| light > 0.0);
    let scales = known.map_or([1.0; BATCHES as usize], |light| batch_scales(light * m, &bright));
    // Weigh the two estimates against each other.
    let whole = scales.iter().sum::<f64>() / BATCHES as f64 * sum / m;
    let by_rays = whole / n;
    let by_pairs = if sum > 0.0 { 0.25 * whole * whole * squares / (sum * sum) } else { 1.0 };
    let trust = if sum > 0.0 { by_rays / (by_rays + by_pairs) } else { 0.0 };
    let worth = |p: &Pair| trust * scales[p.seen.batch as usize] * p.weight * p.arriving / m;
    let from_pairs = pairs.iter().filter(|p| p.arriving > 0.0).map(|p| (p.seen, worth(p)));
    // What rays find of a lamp that pairs never look at counts whole.
    let is_looked_at = |seen: &Seen| lamps.pdf(&view, patches.slot(seen.slot).face) > 0.0;
    let from_rays = hits.map(|seen| (seen, if is_looked_at(&seen) { (1.0 - trust) / n } else { 1.0 / n }));
    let (shares, moments) = merge(from_pairs.chain(from_rays), basis);
    let total: f64 = bright.iter().sum();
    let excess = match known {
        Some(_) if total > 0.0 => bright.map(|b| (trust * (b * BATCHES as f64 / total - 1.0)) as f32),
        _ => Default::default(),
    };
    Look { shares, moments, excess }
}

/// By what the pairs of each batch are multiplied, so that those of all batches together weigh `whole` and
/// visible ones among them estimate their part of it without bias of first order: the jackknife of whole·(Σ
/// visible / Σ all).
fn batch_scales(whole: f64, weights: &[f64; BATCHES as usize]) -> [f64; BATCHES as usize] {
    let total: f64 = weights.iter().sum();
    if total == 0.0 {
        return [1.0; BATCHES as usize];
    }
    let batches = BATCHES as f64;
    let all = whole / total;
    let without = weights.map(|w| whole * (batches - 1.0) / batches / (total - w));
    let sum: f64 = without.iter().sum();
    let scales = without.map(|own| batches * all - (sum - own));
    // Where a batch holds nearly all there is, the correction would be worse than the bias.
    if scales.iter().all(|&scale| scale > 0.0 && scale < 2.0 * all) {
        scales
    } else {
        [all; BATCHES as usize]
    }
}

/// Adds up what is worth so much of the same batch and lamp patch; batch after batch.
fn merge(parts: impl Iterator<Item = (Seen, f64)>, basis: Basis) -> (Vec<LampShare>, Vec<[f32; 9]>) {
    let mut parts: Vec<_> = parts.collect();
    parts.sort_by_key(|(seen, _)| (seen.batch, seen.slot));
    let same = |(a, _): &(Seen, f64), (b, _): &(Seen, f64)| (a.slot, a.batch) == (b.slot, b.batch);
    let share = |run: &[(Seen, f64)]| {
        let share = run.iter().map(|part| part.1).sum::<f64>() as f32;
        LampShare { slot: run[0].0.slot, batch: run[0].0.batch, share }
    };
    let shares = parts.chunk_by(same).map(share).collect();
    let moments = match basis {
        Basis::Constant => Vec::new(),
        Basis::Linear => parts.chunk_by(same).map(moments).collect(),
    };
    (shares, moments)
}

/// Σ w φ_a φ_b with a on the receiver and b on the lamp patch, at 3a + b.
fn moments(run: &[(Seen, f64)]) -> [f32; 9] {
    let mut sums = [0.0; 9];
    for (seen, worth) in run {
        let [here, there] = seen.ends.map(Spot::weights);
        sums.iter_mut()
            .enumerate()
            .for_each(|(entry, sum)| *sum += worth * here[entry / 3] * there[entry % 3]);
    }
    sums.map(|sum| sum as f32)
}
