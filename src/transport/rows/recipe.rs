//! Recipe: how many rays of each kind a patch sends, and by which random sequences.

use super::tones::Tones;
use crate::patches::{Basis, Patches};
use crate::progress::Progress;
use crate::trace::Tracer;

/// Independent batches that the rays of a patch are split into, of rows and of light sampling alike; a
/// number. How far they differ tells the noise, with one degree of freedom less. Chosen, not fitted:
/// quantiles of Student's t elsewhere are those of 7 degrees of freedom, and saved form factors have as many
/// batches.
pub const BATCHES: u32 = 8;

/// Rays from patches for each one that lamps, lights without area and the sky shoot at specular surfaces, and
/// for each one by which a patch looks for the sky over them; a number. Chosen, not fitted.
pub const RAYS_PER_SHOT: u32 = 4;

/// How many rays of each kind a patch sends; multiples of [`BATCHES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayCount {
    pub rays: u32,
    pub lamp_rays: u32,
}

/// How rows are traced, and for which elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recipe {
    pub count: RayCount,
    pub seed: u64,
    pub basis: Basis,
}

/// Whether lamps and lights shoot light through mirrors and glass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shots {
    /// They do, where there are lamps and any of these.
    #[default]
    Shot,
    /// They do not: what comes that way is found by the rays of patches alone.
    Skipped,
}

/// How the rows of a scene are traced.
pub struct RowOptions<'a> {
    pub recipe: Recipe,
    pub tones: Tones,
    pub shots: Shots,
    pub progress: Progress<'a>,
}

/// What every ray of a row needs to know.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    pub tracer: &'a Tracer<'a>,
    pub patches: &'a Patches<'a>,
    pub recipe: Recipe,
    pub tones: &'a Tones,
}
