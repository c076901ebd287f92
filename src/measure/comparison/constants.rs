//! Constants of the comparison: how much of a difference noise and mesh may account for.
//!
//! All are chosen, not fitted. `tests/behaviour/comparison.rs` holds that a right solver is never called
//! wrong, whatever the seed, and that wrong ones are.

// What noise accounts for.

/// The chance of calling a right answer different, all looks together; a pure number.
pub(super) const LEVEL: f64 = 1e-3;

/// Standard errors that are taken off a difference before it is held against the mesh; a pure number.
pub(super) const SURE: f64 = 3.0;

/// How many standard errors of a single patch count as one, for its noise has long tails; a pure number.
pub(super) const ERRORS_OF_ONE: f64 = 2.0;

/// From so many degrees of freedom on, standard errors are trusted more and more; a number. Up to there the
/// spread of differences counts in full beside them, from there on in inverse proportion.
pub(super) const TRUSTED_FREEDOM: f64 = 20.0;

/// Where nothing is known to be noisy, differences below this part of the reference are rounding; a pure
/// number.
pub(super) const ROUNDING: f64 = 1e-9;

/// Values of a reference table whose standard error is this part of them or more are not compared; a pure
/// number.
pub(super) const TOO_NOISY: f64 = 0.2;

// What the mesh accounts for.

/// How many times the change that half the edge makes the mesh error may be; a pure number. Error that falls
/// as the root of the edge, as along edges of shadows, leaves 2.4 times its change.
pub(super) const REMAINS: f64 = 3.0;

/// The same for single patches, whose change is noisy; a pure number.
pub(super) const REMAINS_OF_ONE: f64 = 4.0;

/// The change that twice the edge makes counts for this part of it, where that is more than half the edge
/// makes of the mean, and in single patches beside it; a pure number. Error that falls as the edge changes
/// twice as much.
pub(super) const COARSER: f64 = 0.5;

/// So many times the average change of patches is always allowed for one, whose own may vanish by chance; a
/// pure number.
pub(super) const ALWAYS_OF_ONE: f64 = 6.0;

/// The same for the mean over all patches, before [`REMAINS`]; a pure number.
pub(super) const ALWAYS_OF_MEAN: f64 = 0.1;

/// The mesh explains no more than these parts of the root mean square and of the mean: an estimate that
/// allows more comes from a mesh that is too coarse for it. Pure numbers.
pub(super) const MOST_BY_MESH: f64 = 0.2;
pub(super) const MOST_OF_MEAN: f64 = 0.05;

// How the mesh error is found.

/// The fewest rays per patch on the other cuts; a number. Fewer would be mostly noise.
pub(super) const FEWEST_RAYS: u32 = 64;

/// The part of all area in patches smaller than the one by which the other cuts are sized; a pure number. By
/// number, the many small faces of furniture would decide how finely walls are cut.
pub(super) const TYPICAL_AREA: f64 = 0.25;
