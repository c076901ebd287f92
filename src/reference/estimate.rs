//! Estimate: means, standard errors and counts of what paths have found so far.
//!
//! Paths come in *batches*, the points of one scrambled sequence; batches are independent, and their means
//! are what standard errors are made of. The batches of a patch belong to two halves, and how many a half
//! gets is decided by what the first round of the *other* half has found: so what a patch happens to draw
//! never decides how often it is drawn again, which would bias its mean (Kirk & Arvo 1991). The estimate is
//! the plain mean of both halves.

use nalgebra::DMatrix;

use super::photons::Photons;
use super::table::ReferenceRow;
use crate::patches::{FaceRow, Patches};

/// Paths in a batch: the more the better they complement each other; where there are many patches, few, for
/// all of them want some.
fn batch_for(patches: usize) -> u32 {
    if patches <= 1 << 15 { 8 } else { 2 }
}

/// Irradiance of every patch by path tracing, in all and by bounce.
#[derive(Clone, Debug)]
pub struct PathTraced {
    pub(super) channels: usize,
    /// Paths in a batch.
    pub(super) batch: u32,
    /// Bounces that are kept apart.
    pub(super) bounces: usize,
    pub(super) halves: [Half; 2],
    /// What photons brought beside; none where none are needed.
    pub(super) photons: Option<Photons>,
    /// Patch areas, m².
    pub(super) areas: Vec<f64>,
    pub(super) paths: u64,
    pub(super) seconds: f64,
}

/// Half of the batches of every patch.
#[derive(Clone, Debug)]
pub(super) struct Half {
    /// Per patch.
    pub batches: Vec<u32>,
    /// Per patch, then bounce (the last is all bounces together), then channel: sum of batch means, and of
    /// their squares.
    pub sums: Vec<[f64; 2]>,
    /// Per patch: √A σ of the first round, by which the other half's paths are shared out; none before it.
    pub spread: Vec<f64>,
}

/// What a sum over many paths may lose by rounding, as a part of it: where all paths bring the same there is
/// no other error. Chosen: a hundred million paths lose some 1e-12.
const ROUNDING: f64 = 1e-12;

/// A mean with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Half {
    pub fn new(patches: usize, values: usize) -> Self {
        Self { batches: vec![0; patches], sums: vec![[0.0; 2]; patches * values], spread: Vec::new() }
    }

    /// Mean and variance of one value's batch means; variance 0 of fewer than two.
    fn moments(&self, patch: usize, value: usize, values: usize) -> (f64, f64) {
        let n = f64::from(self.batches[patch]);
        let [sum, squares] = self.sums[patch * values + value];
        let mean = sum / n.max(1.0);
        let variance = ((squares - sum * mean) / (n - 1.0).max(1.0)).max(0.0);
        (mean, variance)
    }

    /// (Σx)²/Σx² of a patch's batch means x from all bounces, the largest over channels: as many batches
    /// would have to bring light, and all alike, for the same relative noise.
    fn effective_batches(&self, patch: usize, total: usize, channels: usize) -> f64 {
        let first = patch * (total + channels) + total;
        let effective = |&[sum, squares]: &[f64; 2]| if squares > 0.0 { sum * sum / squares } else { 0.0 };
        self.sums[first..first + channels].iter().map(effective).fold(0.0, f64::max)
    }
}

impl PathTraced {
    pub(super) fn new(channels: usize, bounces: usize, areas: &[f64]) -> Self {
        let half = Half::new(areas.len(), (bounces + 1) * channels);
        let halves = [half.clone(), half];
        Self {
            channels,
            batch: batch_for(areas.len()),
            bounces,
            halves,
            photons: None,
            areas: areas.to_vec(),
            paths: 0,
            seconds: 0.0,
        }
    }

    /// Notes how much patches vary, once the first round is done.
    pub(super) fn note_spread(&mut self) {
        let (channels, total, values) =
            (self.channels, self.bounces * self.channels, (self.bounces + 1) * self.channels);
        for half in self.halves.iter_mut().filter(|half| half.spread.is_empty()) {
            let variance =
                |i: usize| (0..channels).map(|c| half.moments(i, total + c, values).1).sum::<f64>();
            half.spread =
                self.areas.iter().enumerate().map(|(i, area)| (area * variance(i)).sqrt()).collect();
        }
    }

    /// Number of patches n.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there are no patches.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Paths that were traced in all.
    pub fn paths(&self) -> u64 {
        self.paths
    }

    /// Seconds that they took.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> u64 {
        let bytes = |half: &Half| 4 * half.batches.len() + 16 * half.sums.len() + 8 * half.spread.len();
        let photons = self.photons.as_ref().map_or(0, |photons| 16 * photons.sums.len());
        (self.halves.iter().map(bytes).sum::<usize>() + photons + 8 * self.areas.len()) as u64
    }

    /// The highest bounce that is kept apart.
    pub fn bounces(&self) -> usize {
        self.bounces
    }

    /// Area of a patch, m².
    pub fn area(&self, patch: usize) -> f64 {
        self.areas[patch]
    }

    /// Paths that were traced from a patch.
    pub fn paths_of(&self, patch: usize) -> u64 {
        let batches: u32 = self.halves.iter().map(|half| half.batches[patch]).sum();
        u64::from(batches) * u64::from(self.batch)
    }

    /// Degrees of freedom of a patch's standard errors: half of what normal batch means would have, for these
    /// are skewed, and chance makes a small standard error of a few of them more easily.
    ///
    /// Without photons only as many batches count as bring light in effect, (Σx)²/Σx² of their means x (Kish
    /// 1965): where one path in thousands finds the light of a patch, what was found by few tells neither its
    /// mean nor its standard error.
    pub fn degrees_of_freedom(&self, patch: usize) -> f64 {
        let batches = |half: &Half| match self.photons {
            Some(_) => f64::from(half.batches[patch]),
            None => half.effective_batches(patch, self.bounces * self.channels, self.channels),
        };
        0.5 * self.halves.iter().map(|half| (batches(half) - 1.0).max(0.0)).sum::<f64>()
    }

    /// Irradiance H of a patch, W·m⁻².
    pub fn irradiance(&self, patch: usize, channel: usize) -> Estimate {
        self.estimate(patch, self.bounces * self.channels + channel)
    }

    /// The part of a patch's irradiance that, reflected, is bounce k of its radiance: ρ/π times it estimates
    /// KᵏE. For k from 1 to [`PathTraced::bounces`], W·m⁻².
    ///
    /// # Panics
    /// If bounce k is not kept apart.
    pub fn irradiance_by_bounce(&self, k: usize, patch: usize, channel: usize) -> Estimate {
        assert!((1..=self.bounces).contains(&k), "bounces 1 to {} are kept apart", self.bounces);
        self.estimate(patch, (k - 1) * self.channels + channel)
    }

    fn estimate(&self, patch: usize, value: usize) -> Estimate {
        let values = (self.bounces + 1) * self.channels;
        let moments = |half: &Half| {
            let (mean, variance) = half.moments(patch, value, values);
            (mean, variance / f64::from(half.batches[patch].max(1)))
        };
        let [(a, error_a), (b, error_b)] = [moments(&self.halves[0]), moments(&self.halves[1])];
        let (thrown, error) =
            self.photons.as_ref().map_or((0.0, 0.0), |photons| photons.moments(patch * values + value));
        let mean = 0.5 * (a + b) + thrown;
        let rounding = ROUNDING * mean;
        Estimate { mean, standard_error: (0.25 * (error_a + error_b) + error + rounding * rounding).sqrt() }
    }

    /// Irradiance H of every patch, n × c, W·m⁻².
    pub fn means(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.len(), self.channels, |i, c| self.irradiance(i, c).mean)
    }

    /// Standard errors of [`PathTraced::means`], n × c, W·m⁻².
    pub fn standard_errors(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.len(), self.channels, |i, c| self.irradiance(i, c).standard_error)
    }

    /// The standard error of all patches together: √(ΣA se² / ΣA H²) over all channels; 0 where no light
    /// arrives at all.
    pub fn relative_standard_error(&self) -> f64 {
        let (mut noise, mut whole) = (0.0, 0.0);
        for (i, area) in self.areas.iter().enumerate() {
            for c in 0..self.channels {
                let Estimate { mean, standard_error } = self.irradiance(i, c);
                noise += area * standard_error.powi(2);
                whole += area * (mean * mean - standard_error.powi(2));
            }
        }
        match (noise, whole) {
            (0.0, _) => 0.0,
            (_, whole) if whole <= 0.0 => f64::INFINITY,
            _ => (noise / whole).sqrt(),
        }
    }

    /// Irradiance of faces, weighted by area as [`Patches::average_by_face`] does: a row per face and side
    /// that has patches.
    ///
    /// # Panics
    /// If `patches` are not those that paths were traced from.
    pub fn by_face(&self, patches: &Patches) -> Vec<ReferenceRow> {
        assert_eq!(patches.len(), self.len(), "the patches that paths were traced from");
        let means = patches.average_by_face(&self.means());
        let row = |face: FaceRow| {
            let variance = |c: usize| -> f64 {
                let patches = patches.patches_of(face.face, face.side);
                patches.map(|i| (self.areas[i] * self.irradiance(i, c).standard_error).powi(2)).sum()
            };
            let standard_error = (0..self.channels).map(|c| variance(c).sqrt() / face.area).collect();
            ReferenceRow { face: face.face, side: face.side, mean: face.mean, standard_error }
        };
        means.into_iter().map(row).collect()
    }
}
