//! Reference: irradiance of every side of every face by light paths, and how far answers are from it.
//!
//! Paths double until their noise is small enough or the time for them is up. A difference d from a reference
//! of standard error σ has E d² = (true difference)² + σ², so that ΣA(d² − σ²) is an unbiased estimate of
//! what is wrong with the answer alone.
//!
//! Sides on which no path finds light, such as those inside a solid that stands on a floor, are dark. What
//! patches astride the solid's edge leak onto them is told apart, as a share of all light, and is no part of
//! the error.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::constants::{FIRST_REFERENCE_PATHS, RESOLVED};
use crate::measure::MeasureError;
use crate::patches::{FaceRow, Patches};
use crate::progress::Progress;
use crate::reference::{Budget, PathOptions, PathTraced, PathTracer, ReferenceRow};
use crate::scene::Side;
use crate::trace::Tracer;

/// What answers are held against.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyReference {
    /// The sides of faces that light reaches, in order of face and side.
    pub sides: Vec<ReferenceSide>,
    /// Paths in all.
    pub paths: u64,
    /// Seconds that they took.
    pub seconds: f64,
}

/// Irradiance of one side of a face.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceSide {
    /// The face's number.
    pub face: usize,
    /// Front or back.
    #[serde(serialize_with = "by_name")]
    pub side: Side,
    /// The face's area, m².
    pub area: f64,
    /// Mean per channel, W·m⁻².
    pub mean: Vec<f64>,
    /// Its standard error per channel.
    pub standard_error: Vec<f64>,
    /// Of the standard errors.
    pub degrees_of_freedom: f64,
}

fn by_name<S: serde::Serializer>(side: &Side, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(side.name())
}

/// How far answers are from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceError {
    /// √(ΣA(d² − σ²) / ΣA(H² − σ²)) over all channels, answers and sides that are not dark; 0 where noise is
    /// all there is.
    pub error: f64,
    /// Its standard error, by the noise of the reference and the spread between answers.
    pub error_se: f64,
    /// ΣA d / ΣA H over the same.
    pub bias: f64,
    /// ΣA H of the answers on dark sides / ΣA H of the reference.
    pub leak: f64,
}

impl ReferenceSide {
    fn is_dark(&self) -> bool {
        self.mean.iter().all(|&mean| mean == 0.0)
    }
}

/// When a reference is good enough: at this noise, or, about, once the time is up.
pub(super) struct Enough {
    pub time: Duration,
    pub noise: f64,
}

impl StudyReference {
    /// Traces paths from `sides`, patches that are whole sides of faces, until there is enough.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(super) fn trace(
        tracer: &Tracer,
        sides: &Patches,
        Enough { time, noise }: Enough,
        seed: u64,
        progress: Progress,
    ) -> Result<Self, MeasureError> {
        let began = Instant::now();
        let paths = PathTracer::new(tracer);
        // Of very many sides even the first paths may take more than there is.
        let (first, seconds) = (FIRST_REFERENCE_PATHS * sides.len() as u64, time.as_secs_f64());
        let first = Budget { paths: Some(first), seconds: Some(seconds), ..Budget::default() };
        let mut options = PathOptions { budget: first, bounces: 0, seed, progress, ..PathOptions::default() };
        let mut estimate = paths.irradiance(sides, &options)?;
        // Doubling takes as long again as all that was done so far.
        while estimate.relative_standard_error() > noise && 2 * began.elapsed() < time {
            options.budget = Budget { paths: Some(estimate.paths()), ..Budget::default() };
            paths.refine(sides, &mut estimate, &options)?;
        }
        Ok(Self::of(sides, &estimate))
    }

    fn of(sides: &Patches, estimate: &PathTraced) -> Self {
        let side = |row: ReferenceRow| {
            let patches = sides.patches_of(row.face, row.side);
            ReferenceSide {
                area: patches.clone().map(|i| sides.area(i)).sum(),
                degrees_of_freedom: patches.map(|i| estimate.degrees_of_freedom(i)).sum(),
                face: row.face,
                side: row.side,
                mean: row.mean,
                standard_error: row.standard_error,
            }
        };
        let rows = estimate.by_face(sides);
        Self {
            sides: rows.into_iter().map(side).collect(),
            paths: estimate.paths(),
            seconds: estimate.seconds(),
        }
    }

    /// Its noise in the norm of errors: √(ΣA σ² / ΣA(H² − σ²)). No error far below it can be told.
    pub fn noise(&self) -> f64 {
        let noise: f64 =
            self.sides.iter().flat_map(|s| s.standard_error.iter().map(|e| s.area * e * e)).sum();
        relative_root(noise, self.whole())
    }

    /// Errors below this can't be told from nothing: two standard deviations of what noise alone makes of
    /// ΣA(d² − σ²).
    pub fn resolution(&self) -> f64 {
        let variance_of = |s: &ReferenceSide| {
            let own: f64 = s.standard_error.iter().map(|e| e * e).sum();
            2.0 * (s.area * own).powi(2) * (1.0 + 1.0 / s.degrees_of_freedom.max(1.0))
        };
        let variance: f64 = self.sides.iter().map(variance_of).sum();
        relative_root(RESOLVED * variance.sqrt(), self.whole())
    }

    /// ΣA(H² − σ²).
    fn whole(&self) -> f64 {
        let light = |s: &ReferenceSide| -> f64 {
            s.mean.iter().zip(&s.standard_error).map(|(m, e)| s.area * (m * m - e * e)).sum()
        };
        self.sides.iter().map(light).sum()
    }

    /// The error of several answers to the same question, each a row per side in order of face and side. A
    /// side that an answer lacks is dark there.
    ///
    /// # Panics
    /// If there is no answer.
    pub(super) fn error_of(&self, answers: &[Vec<FaceRow>]) -> FaceError {
        assert!(!answers.is_empty(), "an error is of at least one answer");
        let count = answers.len() as f64;
        let mut excess = vec![0.0; answers.len()];
        let (mut variance, mut difference, mut light, mut leak) = (0.0, 0.0, 0.0, 0.0);
        for side in &self.sides {
            let found: Vec<Option<&FaceRow>> = answers.iter().map(|answer| find(answer, side)).collect();
            if side.is_dark() {
                let found = found.iter().flatten().flat_map(|row| &row.mean);
                leak += side.area * found.sum::<f64>() / count;
                continue;
            }
            let (mut own, mut along) = (0.0, 0.0);
            for (c, (mean, error)) in side.mean.iter().zip(&side.standard_error).enumerate() {
                let mut sum = 0.0;
                for (excess, row) in excess.iter_mut().zip(&found) {
                    let d = row.map_or(0.0, |row| row.mean[c]) - mean;
                    *excess += side.area * (d * d - error * error);
                    sum += d / count;
                }
                own += error * error;
                // What the reference's noise does to d² goes with d, which all answers share in the mean.
                along += (sum * sum - error * error).max(0.0).sqrt() * error;
                difference += side.area * sum;
                light += side.area * mean;
            }
            variance += 2.0 * (side.area * own).powi(2) * (1.0 + 1.0 / side.degrees_of_freedom.max(1.0))
                + 4.0 * (side.area * along).powi(2);
        }
        let mean = excess.iter().sum::<f64>() / count;
        if answers.len() > 1 {
            let squares: f64 = excess.iter().map(|x| (x - mean).powi(2)).sum();
            variance += squares / (count - 1.0) / count;
        }
        let (sigma, whole) = (variance.sqrt(), self.whole());
        let root = |x: f64| relative_root(x, whole);
        FaceError {
            error: root(mean),
            error_se: 0.5 * (root(mean + sigma) - root(mean - sigma)),
            bias: if light > 0.0 { difference / light } else { 0.0 },
            leak: if light > 0.0 { leak / light } else { 0.0 },
        }
    }
}

fn find<'a>(answer: &'a [FaceRow], side: &ReferenceSide) -> Option<&'a FaceRow> {
    let at = answer.binary_search_by_key(&(side.face, side.side), |row| (row.face, row.side));
    at.ok().map(|at| &answer[at])
}

/// √(a / b), where less than nothing is nothing.
fn relative_root(a: f64, b: f64) -> f64 {
    if b > 0.0 { (a.max(0.0) / b).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(means: &[f64], error: f64) -> StudyReference {
        let side = |(face, &mean): (usize, &f64)| ReferenceSide {
            face,
            side: Side::Front,
            area: 2.0,
            mean: vec![mean],
            standard_error: vec![error],
            degrees_of_freedom: 1e6,
        };
        StudyReference { sides: means.iter().enumerate().map(side).collect(), paths: 1, seconds: 1.0 }
    }

    fn answer(means: &[f64]) -> Vec<FaceRow> {
        let row =
            |(face, &mean): (usize, &f64)| FaceRow { face, side: Side::Front, area: 2.0, mean: vec![mean] };
        means.iter().enumerate().map(row).collect()
    }

    #[test]
    fn noise_is_taken_off_and_its_uncertainty_is_told() {
        // Differences as large as the noise are all noise.
        let noisy = reference(&[1.0, 1.0, 1.0, 1.0], 0.1);
        let all_noise = noisy.error_of(&[answer(&[1.1, 0.9, 1.1, 0.9])]);
        assert!(all_noise.error < 1e-7, "rounding is all there is");
        assert!(all_noise.error_se > 0.02 && all_noise.bias.abs() < 1e-12);
        // Without noise the error is what it is.
        let sure = reference(&[1.0, 2.0], 0.0).error_of(&[answer(&[1.1, 1.8])]);
        assert!((sure.error - (0.05f64 / 5.0).sqrt()).abs() < 1e-12 && sure.error_se == 0.0);
        assert!((sure.bias + 0.1 / 3.0).abs() < 1e-12);
        assert!((noisy.noise() - (0.01f64 / 0.99).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn answers_that_differ_make_their_error_uncertain() {
        let sure = reference(&[1.0], 0.0);
        let error = sure.error_of(&[answer(&[1.1]), answer(&[1.3])]);
        assert!((error.error - 0.05f64.sqrt()).abs() < 1e-12, "the mean of the squares");
        // Excesses 0.01 and 0.09: their mean has a standard error of 0.04, and the root's slope is 1 / (2 ·
        // 0.224).
        assert!((error.error_se - 0.1).abs() < 0.01, "{error:?}");
    }

    #[test]
    fn light_on_dark_sides_is_a_leak_and_no_error() {
        let error = reference(&[1.0, 0.0], 0.0).error_of(&[answer(&[1.0, 0.02])]);
        assert_eq!((error.error, error.leak), (0.0, 0.02));
    }

    #[test]
    fn a_side_that_an_answer_lacks_is_dark_there() {
        let error = reference(&[1.0, 1.0], 0.0).error_of(&[answer(&[1.0])]);
        assert!((error.error - 0.5f64.sqrt()).abs() < 1e-12);
    }
}
