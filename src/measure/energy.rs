//! Energy: where the emitted power goes.

use std::f64::consts::PI;

use nalgebra::DMatrix;
use serde::Serialize;

use crate::transport::{Sources, Transport};

/// Radiant flux Φ by where it comes from and goes to, per channel, W; every term computed on its own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Energy {
    /// π Σ A Lₑ, and what lights without area send to surfaces: Σ A H₀, and what carriers keep of it on its way.
    pub emitted: Vec<f64>,
    /// Σ (1 − ρ − τ) A H with H recomputed from L.
    pub absorbed: Vec<f64>,
    /// π Σ A L F_i∞, what leaves the scene.
    pub escaped: Vec<f64>,
    /// What mirrors and glass absorb: π Σ A L times the share that ends there, and of what lights without area send to surfaces by way of them.
    pub carriers: Vec<f64>,
    /// What paths lose that are cut short.
    pub lost: Vec<f64>,
    /// π Σ L·slack, what rows of form factors lack that could not be closed; see
    /// [`Exchange::slack`](crate::transport::Exchange::slack).
    pub slack: Vec<f64>,
    /// (emitted − the rest) / emitted, the largest absolute value over channels.
    pub imbalance: f64,
}

impl Energy {
    /// Accounts for emitted radiance `e` and radiance `l` (N × c) under operator `k`; `unit` is the operator's unit of area in m².
    ///
    /// # Panics
    /// If `e` or `l` is not N × c.
    pub fn new(k: &Transport, e: &DMatrix<f64>, l: &DMatrix<f64>, unit: f64) -> Self {
        Self::of(k, &e.clone().into(), l, unit)
    }

    /// Accounts for direct light alone: irradiance `direct` (N × c) by the lamps of `sources` and its lights without area, on surfaces of
    /// the reflectances of `k`. What they reflect or let through is cut short and counts as lost; what lamps send out that reaches nothing has escaped,
    /// and is told by what is left of the rest.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn of_direct_light(k: &Transport, sources: &Sources, direct: &DMatrix<f64>, unit: f64) -> Self {
        let mass = k.mass();
        let of = |values: &DMatrix<f64>| -> Vec<f64> {
            values.column_iter().map(|column| unit * mass.sums().dot(&column)).collect()
        };
        let reflected = of(&direct.component_mul(&k.passed_on()));
        let arrived = of(direct);
        let [carriers, given_up] = kept(sources, k.channels(), unit);
        let emitted: Vec<f64> = sources.flux(mass).into_iter().map(|flux| unit * flux).collect();
        let of_channels = |of: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..k.channels()).map(of).collect() };
        Self {
            absorbed: of_channels(&|c| arrived[c] - reflected[c]),
            escaped: of_channels(&|c| emitted[c] - arrived[c] - carriers[c] - given_up[c]),
            lost: of_channels(&|c| reflected[c] + given_up[c]),
            carriers,
            slack: vec![0.0; k.channels()],
            imbalance: 0.0,
            emitted,
        }
    }

    /// The same with lights without area.
    ///
    /// # Panics
    /// If the sources or `l` are not N × c.
    pub fn of(k: &Transport, sources: &Sources, l: &DMatrix<f64>, unit: f64) -> Self {
        let channels = k.channels();
        let mut irradiance = k.irradiance(l);
        if let Some(direct) = &sources.direct {
            irradiance += direct;
        }
        let area = k.mass().sums();
        let weigh = |value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..channels).map(|c| unit * (0..k.len()).map(|i| value(i, c)).sum::<f64>()).collect()
        };
        let emitted: Vec<f64> = sources.flux(k.mass()).into_iter().map(|flux| unit * flux).collect();
        let passed_on = k.passed_on();
        let absorbed = weigh(&|i, c| (1.0 - passed_on[(i, c)]) * area[i] * irradiance[(i, c)]);
        let escaped = weigh(&|i, c| PI * k.exchange_of(c).escape(i) * l[(i, c)]);
        let mut carriers = weigh(&|i, c| PI * k.exchange_of(c).absorbed(i) * l[(i, c)]);
        let mut lost = weigh(&|i, c| PI * k.exchange_of(c).lost(i) * l[(i, c)]);
        for (sum, kept) in [&mut carriers, &mut lost].into_iter().zip(kept(sources, channels, unit)) {
            sum.iter_mut().zip(kept).for_each(|(sum, kept)| *sum += kept);
        }
        let slack = weigh(&|i, c| PI * k.exchange_of(c).slack()[i] * l[(i, c)]);
        let off = |c: usize| match emitted[c] {
            0.0 => 0.0,
            emitted => {
                let found = absorbed[c] + escaped[c] + carriers[c] + lost[c] + slack[c];
                ((emitted - found) / emitted).abs()
            }
        };
        let imbalance = (0..channels).map(off).fold(0.0, f64::max);
        Self { emitted, absorbed, escaped, carriers, lost, slack, imbalance }
    }
}

/// What carriers absorb, and what is given up, on the way from lights without area; per channel.
fn kept(sources: &Sources, channels: usize, unit: f64) -> [Vec<f64>; 2] {
    match &sources.carried {
        Some(carried) => {
            [&carried.absorbed, &carried.lost].map(|flux| flux.iter().map(|flux| unit * flux).collect())
        }
        None => [vec![0.0; channels], vec![0.0; channels]],
    }
}
