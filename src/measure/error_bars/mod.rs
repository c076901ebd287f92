//! Error bars: how wrong an answer may be, told from the answer itself, and where its error comes from.
//!
//! Nothing is traced anew. The batches of rays tell the noise of form factors and of light sampling; larger
//! patches, merged from those that there are, tell what the size of patches does; slack tells what rows of
//! form factors lack that could not be closed; the solver knows what it has left out. All but the last are
//! *estimated*: they rest on what errors usually do. The last is *guaranteed* for the operator at hand.
//!
//! Of a series that ended early, order k is held against order k: what later orders add is no error of the
//! mesh, nor noise, but truncation, a part of its own.

mod constants;
mod mesh;
mod noise;
mod slack;

use nalgebra::DMatrix;
use rayon::prelude::*;
use serde::Serialize;

use super::MeasureError;
use crate::patches::{FaceRow, Patches};
use crate::progress::Progress;
use crate::solve::{Certainty, Problem, Solution};
use constants::{COMMON, LEAST_OF_CHANGE, NOISE_IN_CHANGE, ROUNDING, STUDENT};
pub(super) use mesh::Insight;
use mesh::MeshError;
use noise::Noise;
pub(super) use noise::at_most as noise_at_most;
pub(super) use slack::at_most as slack_at_most;

/// One standard error of irradiance by patch and by face, and the budget of what it is made from.
#[derive(Clone, Debug)]
pub struct ErrorBars {
    /// One standard error of a patch's irradiance, n × c, W·m⁻².
    pub patches: DMatrix<f64>,
    /// The same of a face's irradiance, in the order of [`Patches::average_by_face`].
    pub faces: Vec<FaceRow>,
    /// What the error of faces is made from.
    pub budget: ErrorBudget,
}

/// How wrong irradiance by face is, as area-weighted relative root mean square over all channels, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorBudget {
    /// The error to be expected.
    pub relative_rms: f64,
    /// What it does not exceed in 95 cases of 100.
    pub upper95: f64,
    /// What both are relative to: root mean square irradiance, W·m⁻².
    pub irradiance: f64,
    /// What it is made from.
    pub parts: Vec<ErrorPart>,
    /// How much is told of the mesh error.
    #[serde(skip)]
    pub(super) insight: Insight,
    /// How many times more than expected the noise may be by how batches differ, in nineteen of twenty cases.
    #[serde(skip)]
    pub(super) scatter: f64,
}

/// One source of error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorPart {
    /// [`ErrorPart::MESH`], [`ErrorPart::RAYS`], [`ErrorPart::LAMPS`], [`ErrorPart::TRUNCATION`],
    /// [`ErrorPart::SOLVER`] or [`ErrorPart::STORAGE`], and [`ErrorPart::SLACK`] where there is any.
    pub name: &'static str,
    /// How large it is, in the norm of the budget. Of an answer without any light, 1 is all that it lacks.
    pub value: f64,
    /// Whether that is guaranteed.
    pub kind: Certainty,
}

impl ErrorPart {
    /// The size of patches.
    pub const MESH: &'static str = "mesh";
    /// The noise of form factors, by rays between surfaces.
    pub const RAYS: &'static str = "form factors";
    /// The noise of light sampling.
    pub const LAMPS: &'static str = "lamp sampling";
    /// Light that rows of form factors lack which could not be closed.
    pub const SLACK: &'static str = "slack";
    /// What orders add that a [truncated](crate::solve::Report::truncated) series left out; 0 for other
    /// answers, of which `solver` tells what they lack.
    pub const TRUNCATION: &'static str = "truncation";
    /// What the solver left; 0 for truncated answers.
    pub const SOLVER: &'static str = "solver";
    /// The rounding of stored form factors, amplified by what goes round.
    pub const STORAGE: &'static str = "storage";
}

impl ErrorBudget {
    /// The value of a part.
    pub fn part(&self, name: &str) -> f64 {
        self.parts.iter().find(|part| part.name == name).map_or(0.0, |part| part.value)
    }
}

impl ErrorBars {
    /// Estimates the errors of a problem's solution by coefficients.
    ///
    /// # Errors
    /// `Transport(NoRays)` unless the rays of the form factors were kept; `Cancelled`.
    pub fn of(
        patches: &Patches,
        problem: &Problem,
        solution: &Solution,
        progress: Progress,
    ) -> Result<Self, MeasureError> {
        progress.at("solve", 0.0)?;
        let (factors, sources, basis) = (problem.factors(), problem.sources(), problem.basis());
        let [radiance, irradiance] =
            [&solution.radiance, &solution.irradiance].map(|field| basis.means(field));
        let of_linear = factors.by_patch();
        let by_patch = of_linear.as_ref().unwrap_or(factors);
        let report = &solution.report;
        let order = report.truncated.then_some(report.iterations);
        // Nothing that surfaces send out has arrived at order 0.
        let arriving = if order == Some(0) { 0.0 * &radiance } else { radiance.clone() };
        let noise = Noise::of(patches, factors, by_patch, sources, &arriving)?;
        progress.at("solve", 0.5)?;
        let known = mesh::Known { radiance: &radiance, irradiance: &irradiance, order };
        let MeshError { by_merging: change_by_patch, by_variation: varied_by_patch, insight } =
            mesh::mesh_error(patches, [factors, by_patch], sources, &known)?;
        let missing_by_patch = slack::missing(patches, by_patch, [&radiance, &irradiance])?;
        let faces = Faces::new(patches, &irradiance);
        let [rays, lamps] = [&noise.rays, &noise.lamps].map(|batches| faces.batches(batches));
        let change = faces.of(&change_by_patch);
        let varied = varied_by_patch.each_ref().map(|half| faces.of(half));
        let part = |name, value, kind| ErrorPart { name, value, kind };
        let noisy = |batches: &[DMatrix<f64>]| faces.relative(|f, c| noise::variance(batches, (f, c)));
        let (by_rays, by_lamps) = (noisy(&rays), noisy(&lamps));
        let by_noise = by_rays.hypot(by_lamps);
        // Some of the noise is in the change that merging makes.
        let change_by_merging = faces.relative(|f, c| change[(f, c)].powi(2));
        let less = change_by_merging.powi(2) - (NOISE_IN_CHANGE * by_noise).powi(2);
        let by_merging = less.max(LEAST_OF_CHANGE * change_by_merging.powi(2)).sqrt();
        let by_mesh = by_merging.hypot(faces.relative(|f, c| squared(&varied, (f, c))));
        let left_out = left_out(patches, &report.missing);
        let by_solver = faces.relative(|_, c| left_out[c].powi(2));
        let by_truncation = if report.truncated { by_solver } else { 0.0 };
        let missing = missing_by_patch.as_ref().map(|missing| faces.of(missing));
        let missed =
            |missing: &Option<DMatrix<f64>>, at: (usize, usize)| missing.as_ref().map_or(0.0, |m| m[at]);
        let by_slack = faces.relative(|f, c| missed(&missing, (f, c)).powi(2));
        let mut parts = vec![
            part(ErrorPart::MESH, by_mesh, Certainty::Estimated),
            part(ErrorPart::RAYS, by_rays, Certainty::Estimated),
            part(ErrorPart::LAMPS, by_lamps, Certainty::Estimated),
            part(ErrorPart::TRUNCATION, by_truncation, report.certainty),
            part(ErrorPart::SOLVER, if report.truncated { 0.0 } else { by_solver }, report.certainty),
            part(ErrorPart::STORAGE, ROUNDING * report.condition, report.certainty),
        ];
        if missing.is_some() {
            parts.push(part(ErrorPart::SLACK, by_slack, Certainty::Estimated));
        }
        // The two are independent, however alike they are in one batch or another.
        let squares: Vec<f64> =
            faces.squares(&rays).iter().zip(faces.squares(&lamps)).map(|(a, b)| a + b).collect();
        let scatter = scatter(&squares);
        let relative_rms = by_mesh.hypot(by_noise).hypot(by_slack) + by_truncation;
        let noise_at_most = scatter * noise_at_most(factors.rays(), basis);
        let sure = by_solver + ROUNDING * report.condition;
        let upper95 = (insight.at_most() * by_mesh).hypot(noise_at_most * by_noise)
            + slack_at_most(by_slack)
            + if sure.is_finite() || report.truncated { sure } else { 0.0 };
        // A patch or face has its own noise, what of the mesh error is seen on it, some of what all have,
        // what it may miss, and what is left out.
        let bar = |h: f64, variance: f64, by_mesh_here: f64, c: usize| {
            let left_out = if report.truncated { left_out[c] } else { 0.0 };
            (variance + by_mesh_here + (COMMON * by_mesh * h).powi(2) + left_out.powi(2)).sqrt()
        };
        let by_face = faces.irradiance.iter().enumerate().map(|(f, row)| {
            let variance = |c: usize| {
                let missed = missed(&missing, (f, c)).powi(2);
                noise::variance(&rays, (f, c)) + noise::variance(&lamps, (f, c)) + missed
            };
            let bar_of = |c: usize| bar(row.mean[c], variance(c), mesh_part(&change, &varied, (f, c)), c);
            FaceRow { mean: (0..row.mean.len()).map(bar_of).collect(), ..row.clone() }
        });
        let by_patch = DMatrix::from_fn(irradiance.nrows(), irradiance.ncols(), |i, c| {
            let variance = noise::variance(&noise.rays, (i, c)) + noise::variance(&noise.lamps, (i, c));
            let variance = variance + missed(&missing_by_patch, (i, c)).powi(2);
            bar(irradiance[(i, c)], variance, mesh_part(&change_by_patch, &varied_by_patch, (i, c)), c)
        });
        let budget =
            ErrorBudget { relative_rms, upper95, irradiance: faces.typical(), parts, insight, scatter };
        progress.at("solve", 1.0)?;
        Ok(Self { patches: by_patch, faces: by_face.collect(), budget })
    }
}

/// The square of a change, told from two that share no noise.
fn squared([a, b]: &[DMatrix<f64>; 2], at: (usize, usize)) -> f64 {
    a[at] * b[at]
}

/// The square of what is seen of the mesh error in one place.
fn mesh_part(merging: &DMatrix<f64>, variation: &[DMatrix<f64>; 2], at: (usize, usize)) -> f64 {
    merging[at].powi(2) + squared(variation, at).max(0.0)
}

/// What a solver may have left out, per channel, as root mean square over area of what it may have over
/// étendue.
fn left_out(patches: &Patches, missing: &[f64]) -> Vec<f64> {
    let (areas, etendues) = (patches.normalised_areas(), patches.normalised_etendues());
    let sum = |values: &[f64]| values.iter().sum::<f64>();
    let most = areas.iter().zip(etendues).map(|(area, etendue)| area / etendue).fold(0.0, f64::max);
    let stretch = if areas.is_empty() { 0.0 } else { (most * sum(etendues) / sum(areas)).sqrt() };
    missing.iter().map(|missing| stretch * missing).collect()
}

/// How many times more than its mean over batches the noise may be, in nineteen of twenty cases, told from
/// the squared noise of each.
fn scatter(squares: &[f64]) -> f64 {
    let batches = squares.len() as f64;
    let mean = squares.iter().sum::<f64>() / batches;
    let spread = (squares.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (batches - 1.0)).sqrt();
    // What the answer's own noise may be is what one more batch may have, less by their number.
    let most = mean + STUDENT * spread * (1.0 + 1.0 / batches).sqrt();
    if mean > 0.0 { (most / mean).sqrt() } else { 1.0 }
}

/// Irradiance by face, and sums over faces relative to it.
struct Faces {
    irradiance: Vec<FaceRow>,
    /// Per patch, its face and side's row, and what part of that it is.
    place: Vec<(usize, f64)>,
}

impl Faces {
    fn new(patches: &Patches, irradiance: &DMatrix<f64>) -> Self {
        let irradiance = patches.average_by_face(irradiance);
        let mut place = vec![(0, 0.0); patches.len()];
        for (f, row) in irradiance.iter().enumerate() {
            let on_face = patches.patches_of(row.face, row.side);
            on_face.for_each(|i| place[i] = (f, patches.area(i) / row.area));
        }
        Self { irradiance, place }
    }

    /// Averages a field over faces: a row per face and side.
    fn of(&self, field: &DMatrix<f64>) -> DMatrix<f64> {
        let mut means = DMatrix::zeros(self.irradiance.len(), field.ncols());
        for (mut mean, column) in means.column_iter_mut().zip(field.column_iter()) {
            column.iter().zip(&self.place).for_each(|(x, &(f, part))| mean[f] += part * x);
        }
        means
    }

    fn batches(&self, batches: &[DMatrix<f64>]) -> Vec<DMatrix<f64>> {
        batches.par_iter().map(|field| self.of(field)).collect()
    }

    /// ΣA x over faces and channels.
    fn sum(&self, x: impl Fn(usize, usize) -> f64) -> f64 {
        let of_face =
            |(f, row): (usize, &FaceRow)| row.area * (0..row.mean.len()).map(|c| x(f, c)).sum::<f64>();
        self.irradiance.iter().enumerate().map(of_face).sum()
    }

    /// ΣA H².
    fn whole(&self) -> f64 {
        self.sum(|f, c| self.irradiance[f].mean[c].powi(2))
    }

    /// √(ΣA H² / ΣA).
    fn typical(&self) -> f64 {
        (self.whole() / self.sum(|_, _| 1.0).max(f64::MIN_POSITIVE)).sqrt()
    }

    /// √(ΣA x / ΣA H²); where there is no light at all, 1 of what is more than nothing.
    fn relative(&self, squared: impl Fn(usize, usize) -> f64) -> f64 {
        match (self.sum(squared), self.whole()) {
            (0.0, _) => 0.0,
            (_, 0.0) => 1.0,
            // What is known but for noise may come out below nothing.
            (part, whole) => (part.max(0.0) / whole).sqrt(),
        }
    }

    /// Per batch ΣA x² / ΣA H².
    fn squares(&self, batches: &[DMatrix<f64>]) -> Vec<f64> {
        batches.iter().map(|x| self.relative(|f, c| x[(f, c)].powi(2)).powi(2)).collect()
    }
}
