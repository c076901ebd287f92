//! Health: whether a mesh and its operator can be trusted, as findings, each with a measured value, a verdict
//! and a remedy.
//!
//! [`mesh_health`] looks at what was modelled, [`operator_health`] at what was made of it. Corners at exactly
//! the same position are one vertex here, whatever object they belong to; faces that were dropped count only
//! where they are the topic.

mod closed;
mod constants;
mod edges;
mod gaps;
mod lamps;
mod leaks;
mod operator;
mod overlaps;
mod placement;
mod shape;
mod winding;

use serde::Serialize;

use crate::patches::Patches;
use crate::trace::Tracer;
pub(super) use closed::ClosedSurfaces;
use edges::Edges;
pub use operator::operator_health;
pub use overlaps::{ObjectOverlap, overlaps};
pub use placement::odd_placement;
pub use winding::{FrontDoubt, front_doubts};

/// What a finding means for an answer; the later, the worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Grade {
    /// As it should be.
    Good,
    /// Does no harm by itself, but may not be what was meant.
    Note,
    /// Costs accuracy or time.
    Fair,
    /// The answer is wrong, or there is none.
    Bad,
}

impl Grade {
    /// `good`, `note`, `fair` or `bad`.
    pub fn name(self) -> &'static str {
        match self {
            Grade::Good => "good",
            Grade::Note => "note",
            Grade::Fair => "fair",
            Grade::Bad => "bad",
        }
    }
}

/// One property, measured and judged.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked at, such as `leaks`.
    pub name: &'static str,
    /// What it means.
    pub verdict: Grade,
    /// What was measured; not finite (`null` in JSON) where there is no such number.
    pub value: f64,
    /// Of what, or in which unit, where it has one. A share of 0 to 1 has a unit that starts with `of`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<&'static str>,
    /// How many places are concerned, where the value does not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Numbers of faces concerned, the worst first, at most [`Finding::MOST_FACES`].
    #[serde(rename = "where")]
    pub faces: Vec<usize>,
    /// What to do about it, where something may be done.
    pub remedy: Option<String>,
}

impl Finding {
    /// The most faces that a finding names.
    pub const MOST_FACES: usize = constants::MOST_FACES;

    /// A good finding; the rest is said by those that are not.
    fn good(name: &'static str, value: f64, unit: Option<&'static str>) -> Self {
        Self { name, verdict: Grade::Good, value, unit, count: None, faces: Vec::new(), remedy: None }
    }

    /// Judges, and says what to do.
    fn but(self, verdict: Grade, faces: impl IntoIterator<Item = usize>, remedy: impl Into<String>) -> Self {
        let faces = faces.into_iter().take(Self::MOST_FACES).collect();
        Self { verdict, faces, remedy: Some(remedy.into()), ..self }
    }
}

/// The health of a mesh: size, faces without area, duplicates, slivers, open and non-manifold edges, cracks,
/// T-junctions, overlaps, winding, lamps and leaks.
///
/// Rays find leaks and where lamps face, under the random sequence of number `seed`. Where nothing emits,
/// `patches` stand in for lamps: all sides that see something ([`crate::patches::Reach::Everything`]).
pub fn mesh_health(tracer: &Tracer, patches: &Patches, seed: u64) -> Vec<Finding> {
    let edges = Edges::new(tracer);
    let scene = tracer.scene();
    vec![
        shape::size(tracer),
        shape::zero_area(scene),
        shape::duplicates(scene),
        shape::slivers(tracer),
        edges.open(),
        edges.non_manifold(),
        gaps::cracks(&edges, tracer),
        gaps::t_junctions(&edges),
        overlaps::same_front(tracer),
        overlaps::back_to_back(tracer),
        edges.winding(),
        lamps::lamps(&edges, tracer, seed),
        leaks::leaks(tracer, patches, seed),
    ]
}
