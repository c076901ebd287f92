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
mod faces;
mod fields;
mod groups;
mod mesh;
mod noise;
mod receivers;
mod sizes;
mod slack;

use nalgebra::DMatrix;
use serde::Serialize;

use super::MeasureError;
use crate::patches::{FaceRow, Patches};
use crate::progress::Progress;
use crate::scene::Feature;
use crate::solve::{Certainty, Problem, Solution};
use crate::transport::{Received, Reflection};
pub use constants::{BOUND_95, FITTED, Fitted};
use faces::Faces;
use fields::Fields;
pub use groups::GroupError;
use groups::{by_group, worst};
pub(super) use mesh::Insight;
pub(super) use noise::at_most as noise_at_most;
pub use receivers::ReceiverBars;
use sizes::Sizes;
pub(super) use slack::at_most as slack_at_most;

/// One standard error of irradiance by patch and by face, and the budget of what it is made from. Since eight
/// batches tell little of their own scatter it is so much wider than that, by Student's t, that 1.96 of it
/// hold in 95 cases of 100.
#[derive(Clone, Debug)]
pub struct ErrorBars {
    /// One standard error of a patch's irradiance, n × c, W·m⁻².
    pub patches: DMatrix<f64>,
    /// The same of a face's irradiance, in the order of [`Patches::average_by_face`].
    pub faces: Vec<FaceRow>,
    /// Of what each receiver measures.
    pub receivers: Vec<ReceiverBars>,
    /// What the error of all faces is made from.
    pub budget: ErrorBudget,
    /// The errors of objects, materials and receivers.
    pub groups: Vec<GroupError>,
    /// What each source of error does to patches, and how large it is by face.
    by_patch: Fields,
    sizes: Sizes,
    insight: Insight,
}

/// How wrong irradiance by face is, as area-weighted relative root mean square over all channels, and why; of
/// a receiver, over points and channels.
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
        Self::with_receivers(patches, problem, solution, &[], progress)
    }

    /// The same, and the errors of what receivers measure under the solution.
    ///
    /// # Errors
    /// As [`ErrorBars::of`].
    pub fn with_receivers(
        patches: &Patches,
        problem: &Problem,
        solution: &Solution,
        receivers: &[Received],
        progress: Progress,
    ) -> Result<Self, MeasureError> {
        progress.at("solve", 0.0)?;
        let (by_patch, insight) = Fields::of(patches, problem, solution, progress)?;
        let irradiance = problem.basis().means(&solution.irradiance);
        let faces = Faces::new(patches, &irradiance);
        let by_face = by_patch.map(|field| faces.means(field)).averaged(|f| {
            let row = &faces.irradiance[f];
            insight.less(patches.patches_of(row.face, row.side).len() as f64)
        });
        let sizes = Sizes::of(&faces, &by_face, patches, &solution.report);
        let budget = sizes.budget(problem, &solution.report, insight);
        let mut groups = by_group(patches, &faces, &by_face, |faces, fields| {
            Sizes::of(faces, fields, patches, &solution.report).budget(problem, &solution.report, insight)
        });
        let bars = |(f, row): (usize, &FaceRow)| FaceRow {
            mean: (0..row.mean.len()).map(|c| sizes.bar(row.mean[c], &by_face, (f, c))).collect(),
            ..row.clone()
        };
        let reflection = Reflection::of(patches);
        // Without interreflection no receiver sees what surfaces reflect.
        let sends = !patches.scene().is_without(Feature::Interreflection);
        let of_receiver = |received: &Received| {
            let arriving = |change: &DMatrix<f64>| {
                let part = if sends { 1.0 } else { 0.0 };
                let sent = problem.basis().coefficients_of(&(part * reflection.reflect(change)));
                received.rows.from_surfaces(&sent)
            };
            // Receivers see means over many patches.
            let sent = by_patch.map(arriving).averaged(|_| insight.less(f64::INFINITY));
            ReceiverBars::new(received, sent, sizes.common())
        };
        let bars_of_receivers: Vec<ReceiverBars> = receivers.iter().map(of_receiver).collect();
        groups.extend(receivers.iter().zip(&bars_of_receivers).map(|(received, bars)| {
            let budget = bars.budget(|faces, fields| Sizes::of(faces, fields, patches, &solution.report));
            GroupError {
                kind: GroupError::RECEIVER,
                name: received.receiver.name.clone(),
                patches: received.irradiance.nrows(),
                budget: budget.budget(problem, &solution.report, insight),
            }
        }));
        let (n, channels) = irradiance.shape();
        progress.at("solve", 1.0)?;
        Ok(Self {
            patches: DMatrix::from_fn(n, channels, |i, c| sizes.bar(irradiance[(i, c)], &by_patch, (i, c))),
            faces: faces.irradiance.iter().enumerate().map(bars).collect(),
            receivers: bars_of_receivers,
            budget,
            groups,
            by_patch,
            sizes,
            insight,
        })
    }

    /// One standard error of `mean`, the mean over patches of what `value` makes of the irradiance in their
    /// channels (W·m⁻²), such as illuminance; `over` has the patches, and what part of the mean each is.
    /// `value` must be linear.
    pub fn standard_error_of_mean(
        &self,
        mean: f64,
        over: &[(usize, f64)],
        value: impl Fn(&[f64]) -> f64,
    ) -> f64 {
        let at = |field: &DMatrix<f64>, i: usize| value(field.row(i).transpose().as_slice());
        let sum = |field: &DMatrix<f64>| over.iter().map(|&(i, part)| part * at(field, i)).sum::<f64>();
        let whole: f64 = over.iter().map(|&(_, part)| part).sum();
        let less = self.insight.less(over.len() as f64);
        let common = self.sizes.common() * mean;
        let left_out = self.sizes.left_out().map_or(0.0, |left_out| whole * value(left_out));
        (self.by_patch.squared(sum, less) + common * common + left_out * left_out).sqrt()
    }

    /// What speaks for the answer: the error of the object or receiver whose own is the largest by `size`, of
    /// those with more light than [darkness](super::DARK) that have a hundredth of all patches; of all faces
    /// where there are none, or where all are one object.
    pub fn headline(&self, size: impl Fn(&ErrorBudget) -> f64) -> GroupError {
        let patches = self.patches.nrows();
        let all = || GroupError {
            kind: GroupError::ALL,
            name: String::new(),
            patches,
            budget: self.budget.clone(),
        };
        let objects = self.groups.iter().filter(|group| group.kind == GroupError::OBJECT).count();
        let speaks = |group: &&GroupError| objects > 1 || group.kind != GroupError::OBJECT;
        worst(&self.groups, (patches, self.budget.irradiance), size)
            .filter(speaks)
            .cloned()
            .unwrap_or_else(all)
    }
}
