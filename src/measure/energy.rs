//! Energy: where the emitted power goes.

use std::f64::consts::PI;

use nalgebra::DMatrix;
use serde::Serialize;

use crate::solve::Problem;
use crate::transport::{LampFlux, Sources, Transport};

/// Radiant flux Φ by where it comes from and goes to, per channel, W; every term computed on its own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Energy {
    /// π Σ A Lₑ, and what lights without area send to surfaces: Σ A H₀, and what carriers keep of it on its
    /// way.
    pub emitted: Vec<f64>,
    /// Σ (1 − ρ − τ) A H with H recomputed from L.
    pub absorbed: Vec<f64>,
    /// π Σ A L F_i∞, what leaves the scene.
    pub escaped: Vec<f64>,
    /// What mirrors and glass absorb: π Σ A L times the share that ends there, and of what lights without
    /// area send to surfaces by way of them.
    pub carriers: Vec<f64>,
    /// What paths lose that are cut short.
    pub lost: Vec<f64>,
    /// π Σ L·slack, what rows of form factors lack that could not be closed; see
    /// [`Exchange::slack`](crate::transport::Exchange::slack).
    pub slack: Vec<f64>,
    /// (emitted − the rest) / emitted, the largest absolute value over channels.
    pub imbalance: f64,
    /// One standard error of the imbalance where terms are estimated apart from each other, as for direct
    /// light alone; 0 where all follow from one operator and one radiance: then only rounding and the
    /// solver's residual are left.
    pub imbalance_error: f64,
}

impl Energy {
    /// Accounts for emitted radiance `e` and radiance `l` (N × c) under operator `k`.
    ///
    /// # Panics
    /// If `e` or `l` is not N × c.
    pub fn new(k: &Transport, e: &DMatrix<f64>, l: &DMatrix<f64>) -> Self {
        Self::under(k, &e.clone().into(), l)
    }

    /// Accounts for radiance `l` (N × c) as the answer to a problem.
    ///
    /// # Panics
    /// If `l` is not N × c.
    pub fn of(problem: &Problem, l: &DMatrix<f64>) -> Self {
        let (k, sources) = (problem.operator(), problem.sources());
        match &sources.lamps {
            Some(lamps) => Self::of_direct_light(k, sources, lamps),
            None => Self::under(k, sources, l),
        }
    }

    /// Accounts for direct light alone: the irradiance H₀ of `sources` on surfaces of the reflectances of
    /// `k`, and where the rest of the lamps' light goes ([`Sources::with_lamps`]). What surfaces reflect or
    /// let through, and what carriers pass on to them, is cut short and counts as lost.
    ///
    /// What arrives and what does not are estimated apart, by rays from either end. So the imbalance is Monte
    /// Carlo noise, of standard error `imbalance_error`; much more than that means that something is wrong.
    /// Of lights without area only what arrives is known, which adds nothing to the imbalance.
    fn of_direct_light(k: &Transport, sources: &Sources, lamps: &LampFlux) -> Self {
        let unit = k.mass().unit();
        let of_channels =
            |value: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..k.channels()).map(value).collect() };
        let (area, passed_on) = (k.mass().sums(), k.passed_on());
        let arrived = |i: usize, c: usize| sources.direct.as_ref().map_or(0.0, |h| area[i] * h[(i, c)]);
        let weigh = |part: &dyn Fn(f64) -> f64| {
            of_channels(&|c| {
                unit * (0..k.len()).map(|i| part(passed_on[(i, c)]) * arrived(i, c)).sum::<f64>()
            })
        };
        let [absorbed, reflected] = [weigh(&|passed_on| 1.0 - passed_on), weigh(&|passed_on| passed_on)];
        let [carriers, given_up] = kept(sources, k.channels());
        let mut energy = Self {
            emitted: sources.flux(k.mass()),
            absorbed,
            escaped: of_channels(&|c| lamps.unit * lamps.escaped[c]),
            carriers: of_channels(&|c| carriers[c] + lamps.unit * lamps.absorbed[c]),
            lost: of_channels(&|c| reflected[c] + given_up[c] + lamps.unit * lamps.lost[c]),
            slack: vec![0.0; k.channels()],
            imbalance: 0.0,
            imbalance_error: 0.0,
        };
        for c in (0..k.channels()).filter(|&c| energy.emitted[c] > 0.0) {
            let off = energy.imbalance_of(c);
            if off >= energy.imbalance {
                energy.imbalance = off;
                energy.imbalance_error = lamps.unit * lamps.standard_error[c] / energy.emitted[c];
            }
        }
        energy
    }

    /// |emitted − the rest| / emitted in a channel; 0 where nothing is emitted.
    fn imbalance_of(&self, c: usize) -> f64 {
        match self.emitted[c] {
            0.0 => 0.0,
            emitted => {
                let rest =
                    self.absorbed[c] + self.escaped[c] + self.carriers[c] + self.lost[c] + self.slack[c];
                ((emitted - rest) / emitted).abs()
            }
        }
    }

    /// Accounts for radiance `l` that lamps, lights without area and the sky cause.
    fn under(k: &Transport, sources: &Sources, l: &DMatrix<f64>) -> Self {
        let unit = k.mass().unit();
        let channels = k.channels();
        let mut irradiance = k.irradiance(l);
        sources.add_beside_the_operator(&mut irradiance);
        let area = k.mass().sums();
        let weigh = |value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..channels).map(|c| unit * (0..k.len()).map(|i| value(i, c)).sum::<f64>()).collect()
        };
        let emitted = sources.flux(k.mass());
        let passed_on = k.passed_on();
        let absorbed = weigh(&|i, c| (1.0 - passed_on[(i, c)]) * area[i] * irradiance[(i, c)]);
        let escaped = weigh(&|i, c| PI * k.exchange_of(c).ends().escape(i) * l[(i, c)]);
        let mut carriers = weigh(&|i, c| PI * k.exchange_of(c).ends().absorbed(i) * l[(i, c)]);
        let mut lost = weigh(&|i, c| PI * k.exchange_of(c).ends().lost(i) * l[(i, c)]);
        for (sum, kept) in [&mut carriers, &mut lost].into_iter().zip(kept(sources, channels)) {
            sum.iter_mut().zip(kept).for_each(|(sum, kept)| *sum += kept);
        }
        let slack = weigh(&|i, c| PI * k.exchange_of(c).ends().slack[i] * l[(i, c)]);
        let mut energy =
            Self { emitted, absorbed, escaped, carriers, lost, slack, imbalance: 0.0, imbalance_error: 0.0 };
        energy.imbalance = (0..channels).map(|c| energy.imbalance_of(c)).fold(0.0, f64::max);
        energy
    }
}

/// What carriers absorb, and what is given up, on the way from lights without area; per channel.
fn kept(sources: &Sources, channels: usize) -> [Vec<f64>; 2] {
    match &sources.carried {
        Some(carried) => [&carried.absorbed, &carried.lost]
            .map(|flux| flux.iter().map(|flux| carried.unit * flux).collect()),
        None => [vec![0.0; channels], vec![0.0; channels]],
    }
}
