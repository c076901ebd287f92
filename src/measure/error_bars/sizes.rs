//! Sizes: how large each source of error is over all faces, and what budget and bars follow.

use nalgebra::DMatrix;

use super::constants::{COMMON, ROUNDING, STUDENT};
use super::faces::Faces;
use super::fields::Fields;
use super::mesh::Insight;
use super::{ErrorBudget, ErrorPart, noise, slack};
use crate::patches::Patches;
use crate::solve::{Certainty, Problem, Report};

/// Sources of error by face, as relative root mean squares over area and channels.
#[derive(Clone, Debug)]
pub(super) struct Sizes {
    mesh: f64,
    rays: f64,
    lamps: f64,
    /// None where all rows of form factors close.
    slack: Option<f64>,
    /// Rounding of stored form factors, as far as it was looked at.
    rounding: Option<f64>,
    /// What the solver left out.
    solver: f64,
    /// The same per channel, W·m⁻².
    left_out: Vec<f64>,
    /// Whether it left out orders of the series.
    is_truncated: bool,
    /// Root mean square irradiance, W·m⁻².
    irradiance: f64,
    /// How many times more than expected the noise may be by how batches differ, in nineteen of twenty cases.
    scatter: f64,
}

impl Sizes {
    /// Those of fields by face.
    pub fn of(faces: &Faces, fields: &Fields, patches: &Patches, report: &Report) -> Self {
        let noise = |batches: &[DMatrix<f64>]| faces.relative(|f, c| noise::variance(batches, (f, c)));
        let (rays, lamps) = (noise(&fields.rays), noise(&fields.lamps));
        // The two are independent, however alike they are in one batch or another.
        let squares = faces.squares(&fields.rays).into_iter().zip(faces.squares(&fields.lamps));
        let squares: Vec<f64> = squares.map(|(a, b)| a + b).collect();
        let left_out = left_out(patches, &report.missing);
        let is_short = fields.missing.is_some();
        Self {
            mesh: faces
                .relative(|f, c| fields.merging[(f, c)].powi(2))
                .hypot(faces.relative(|f, c| fields.varied_squared((f, c))))
                .hypot(faces.relative(|f, c| fields.unresolved[(f, c)].powi(2))),
            rays,
            lamps,
            slack: is_short.then(|| faces.relative(|f, c| fields.missing_squared((f, c)))),
            rounding: fields
                .rounding
                .as_ref()
                .map(|rounding| faces.relative(|f, c| rounding[(f, c)].powi(2))),
            solver: faces.relative(|_, c| left_out[c].powi(2)),
            left_out,
            is_truncated: report.truncated,
            irradiance: faces.typical(),
            scatter: scatter(&squares),
        }
    }

    /// The same with more noise and more mesh error, as relative root mean squares.
    pub fn with(self, noise: f64, mesh: f64) -> Self {
        Self { lamps: self.lamps.hypot(noise), mesh: self.mesh.hypot(mesh), ..self }
    }

    /// What the error is made from, and what follows of it.
    pub fn budget(&self, problem: &Problem, report: &Report, insight: Insight) -> ErrorBudget {
        let &Self { mesh, rays, lamps, solver, scatter, irradiance, .. } = self;
        let [truncation, solving] = if self.is_truncated { [solver, 0.0] } else { [0.0, solver] };
        let most = ROUNDING * report.condition;
        let (storage, stored) = match self.rounding {
            Some(rounding) if rounding < most => (rounding, Certainty::Estimated),
            _ => (most, report.certainty),
        };
        let part = |name, value, kind| ErrorPart { name, value, kind };
        let mut parts = vec![
            part(ErrorPart::MESH, mesh, Certainty::Estimated),
            part(ErrorPart::RAYS, rays, Certainty::Estimated),
            part(ErrorPart::LAMPS, lamps, Certainty::Estimated),
            part(ErrorPart::TRUNCATION, truncation, report.certainty),
            part(ErrorPart::SOLVER, solving, report.certainty),
            part(ErrorPart::STORAGE, storage, stored),
        ];
        parts.extend(self.slack.map(|slack| part(ErrorPart::SLACK, slack, Certainty::Estimated)));
        let slack = self.slack.unwrap_or(0.0);
        let noise = rays.hypot(lamps);
        let noise_at_most = scatter * noise::at_most(problem.factors().rays(), problem.basis());
        let sure = solver + storage;
        let upper95 = (insight.at_most() * mesh).hypot(noise_at_most * noise)
            + slack::at_most(slack)
            + if sure.is_finite() || self.is_truncated { sure } else { 0.0 };
        let relative_rms = mesh.hypot(noise).hypot(slack) + truncation;
        ErrorBudget { relative_rms, upper95, irradiance, parts, insight, scatter }
    }

    /// What of the mesh error all values have, as a part of irradiance.
    pub fn common(&self) -> f64 {
        COMMON * self.mesh
    }

    /// What a truncated series left out, per channel, W·m⁻²; nothing for other answers.
    pub fn left_out(&self) -> Option<&[f64]> {
        self.is_truncated.then_some(&self.left_out)
    }

    /// One standard error of a patch or face of irradiance `h`: its own noise, what of the mesh error is seen
    /// on it, some of what all have, what it may miss, and what is left out.
    pub fn bar(&self, h: f64, fields: &Fields, at: (usize, usize)) -> f64 {
        let left_out = self.left_out().map_or(0.0, |left_out| left_out[at.1]);
        let variance = fields.noise_squared(at) + fields.missing_squared(at);
        (variance + fields.mesh_squared(at) + (self.common() * h).powi(2) + left_out.powi(2)).sqrt()
    }
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
