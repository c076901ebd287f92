//! Recipe: how many rays of each kind a patch sends, and by which random sequences.

use crate::patches::Basis;

/// Independent scramblings per row, by whose spread the noise of form factors is measured.
pub const BATCHES: u32 = 8;

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
