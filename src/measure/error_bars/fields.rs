//! Fields: what each source of error does to irradiance, patch by patch or face by face.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::constants::{CHANGE_TOLERANCE, EIGHT_BATCHES, NOTICEABLE, ROUNDING};
use super::mesh::{Insight, Known, MeshError, mesh_error, unresolved};
use super::noise::{self, Noise};
use super::slack;
use crate::measure::MeasureError;
use crate::patches::Patches;
use crate::progress::Progress;
use crate::solve::{Problem, Solution, roughly};
use crate::transport::{Reflection, Transport, variance_of_mean};

/// What each source of error does to irradiance, W·m⁻²: a row per patch, or per face and side, and a column
/// per channel.
#[derive(Clone, Debug)]
pub(super) struct Fields {
    /// The noise of form factors, by batches of rays.
    pub rays: Vec<DMatrix<f64>>,
    /// That of light sampling.
    pub lamps: Vec<DMatrix<f64>>,
    /// What merging patches changes, as far as that is left as error.
    pub merging: DMatrix<f64>,
    /// What light that varies within patches near lamps changes, as either half of the rays has it.
    pub variation: [DMatrix<f64>; 2],
    /// What larger patches nearby may be unlike where a patch sees them.
    pub unresolved: DMatrix<f64>,
    /// What rows of form factors lack that could not be closed; none where all close.
    pub missing: Option<DMatrix<f64>>,
    /// The most that the rounding of stored form factors changes; none where it is little by the condition
    /// alone.
    pub rounding: Option<DMatrix<f64>>,
}

impl Fields {
    /// Those of a solution by patches, and how much is told of the mesh error.
    pub fn of(
        patches: &Patches,
        problem: &Problem,
        solution: &Solution,
        progress: Progress,
    ) -> Result<(Self, Insight), MeasureError> {
        let (factors, sources, basis) = (problem.factors(), problem.sources(), problem.basis());
        let [radiance, irradiance] =
            [&solution.radiance, &solution.irradiance].map(|field| basis.means(field));
        let of_linear = factors.by_patch();
        let by_patch = of_linear.as_ref().unwrap_or(factors);
        let report = &solution.report;
        let order = report.truncated.then_some(report.iterations);
        // Nothing that surfaces send out has arrived at order 0.
        let arriving = if order == Some(0) { 0.0 * &radiance } else { radiance.clone() };
        let Noise { rays, lamps } = Noise::of(patches, factors, by_patch, sources, &arriving)?;
        progress.at("solve", 0.5)?;
        let k = Transport::new(by_patch, Reflection::of(patches))?;
        let known = Known { radiance: &radiance, irradiance: &irradiance, order };
        let MeshError { by_merging, by_variation: variation, insight } =
            mesh_error(patches, (factors, &k), sources, &known)?;
        let merging = insight.remains(1.0) * by_merging;
        let unresolved = unresolved(patches, by_patch, &arriving);
        let missing = slack::missing(patches, &k, [&radiance, &irradiance])?;
        let rounding = rounding(&k, &radiance, report.condition)?;
        Ok((Self { rays, lamps, merging, variation, unresolved, missing, rounding }, insight))
    }

    /// The same after a linear map, such as means over faces.
    pub fn map(&self, map: impl Fn(&DMatrix<f64>) -> DMatrix<f64> + Sync) -> Self {
        let all = |batches: &[DMatrix<f64>]| batches.par_iter().map(&map).collect();
        Self {
            rays: all(&self.rays),
            lamps: all(&self.lamps),
            merging: map(&self.merging),
            variation: self.variation.each_ref().map(&map),
            unresolved: map(&self.unresolved),
            missing: self.missing.as_ref().map(&map),
            rounding: self.rounding.as_ref().map(&map),
        }
    }

    /// The same where row k is a mean over patches of which merging changes so many times less.
    pub fn averaged(mut self, less: impl Fn(usize) -> f64) -> Self {
        self.merging.row_iter_mut().enumerate().for_each(|(k, mut row)| row /= less(k));
        self
    }

    /// The square of the error of a linear function of irradiance, as far as these tell it, where merging
    /// changes it so many times less than one value.
    pub fn squared(&self, of: impl Fn(&DMatrix<f64>) -> f64, less: f64) -> f64 {
        let noise = variance_of_mean(&self.rays, &of) + variance_of_mean(&self.lamps, &of);
        let [a, b] = self.variation.each_ref().map(&of);
        let missing = self.missing.as_ref().map_or(0.0, &of);
        let mesh = (of(&self.merging) / less).powi(2) + (a * b).max(0.0) + of(&self.unresolved).powi(2);
        EIGHT_BATCHES.powi(2) * noise + mesh + missing * missing
    }

    /// The square of the error of one value by noise.
    pub fn noise_squared(&self, at: (usize, usize)) -> f64 {
        EIGHT_BATCHES.powi(2) * (noise::variance(&self.rays, at) + noise::variance(&self.lamps, at))
    }

    /// The square of what variation changes in one value, told from two halves that share no noise; it may
    /// come out below nothing.
    pub fn varied_squared(&self, at: (usize, usize)) -> f64 {
        let [a, b] = &self.variation;
        a[at] * b[at]
    }

    /// The square of what is seen of the mesh error in one value.
    pub fn mesh_squared(&self, at: (usize, usize)) -> f64 {
        self.merging[at].powi(2) + self.varied_squared(at).max(0.0) + self.unresolved[at].powi(2)
    }

    /// The square of what one value may miss.
    pub fn missing_squared(&self, at: (usize, usize)) -> f64 {
        self.missing.as_ref().map_or(0.0, |missing| missing[at]).powi(2)
    }
}

/// The most that rounding each form factor by the same part changes irradiance (n × c, W·m⁻²): to first
/// order that part of what arrives from surfaces, of what that becomes by reflection once more, and so on.
/// Where next to nothing absorbs the condition is large, but often little light is there; none where it is
/// small.
fn rounding(
    k: &Transport,
    radiance: &DMatrix<f64>,
    condition: f64,
) -> Result<Option<DMatrix<f64>>, MeasureError> {
    if ROUNDING * condition < NOTICEABLE {
        return Ok(None);
    }
    let arriving = k.irradiance(radiance);
    let reflected = roughly(k, &k.reflect(&arriving), CHANGE_TOLERANCE, Progress::default())?;
    Ok(Some(ROUNDING * (arriving + k.irradiance(&reflected))))
}
