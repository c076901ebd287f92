//! Constants of form factors: how many rays are usual, from where on rays are not needed or directions
//! disagree, and what bounds what few rays tell. Those called *chosen* are not fitted.

// Options.

/// Rays of all patches together where no number is asked for, and the fewest and most of a patch, which are
/// rounded up to a power of two; numbers. Chosen: a face that is cut into many patches averages their noise.
pub(super) const USUAL_RAYS: usize = 1 << 22;
pub(super) const USUAL_RAYS_OF_PATCH: [usize; 2] = [64, 512];

/// With more patches than this rays are quicker than all pairs; a number. Chosen, not fitted, as far as the
/// history tells.
pub(super) const MOST_EXACT: usize = 10_000;

// Agreement.

/// Beyond this many standard errors a pair of face sides is told to disagree; a pure number. Chosen between
/// what was measured: good scenes stay below 2.4, broken ones reach 38 and more.
pub const DISAGREE: f64 = 5.0;

/// With no more rays than this one way, and none the other, |z| stays within [`DISAGREE`]; a number. Follows
/// from that.
pub(super) const FEWEST_RAYS: u32 = (DISAGREE * DISAGREE) as u32;

// Groups.

/// Upper 95 % bound on the mean of a number that came out as 0, −ln 0.05 (Poisson); a pure number.
/// Mathematics.
pub(super) const NONE_SEEN: f64 = 2.995_732_273_553_991;

/// Up to so many rays their number bounds what they tell of, from more the batches; a number. Chosen, not
/// fitted.
pub(super) const FEW_SEEN: f64 = 64.0;

/// Student's t for 95 % of one side and 7 degrees of freedom, one less than there are batches; a pure number.
/// Mathematics. Error bars use the same quantile with three decimals: each keeps its own, since bounds that
/// are written out would differ in the fourth digit.
pub(super) const STUDENT: f64 = 1.894_578_605;

/// With more entries than this a list of them is summed up, so that it stays short; a number. Chosen, a limit
/// on memory. With another one the last bits differ.
pub(super) const MOST_LISTED: usize = 1 << 16;

// Soundness of files.

/// By how much a row may miss its patch's area, relative to that; a pure number. Chosen, far above rounding
/// and far below noise.
pub(super) const OPEN: f64 = 1e-9;

/// By how much xᵀSy and yᵀSx may differ, relative to their size; a pure number. Chosen: rounding alone.
pub(super) const UNEVEN: f64 = 1e-12;

/// More rays than this of a patch are refused; a number. Chosen, not fitted.
pub(super) const MOST_RAYS: u32 = 1 << 24;

// Spread.

/// A row whose slack is more than this part of its area is held at its bound; a pure number. Chosen: less is
/// rounding.
pub(super) const HELD: f64 = 1e-9;

/// The part of a patch's étendue that rays are taken to fill at least; a pure number. Chosen: what lamps
/// leave where they fill no more than [`FLOODED`](crate::transport::exchange::FLOODED), so that nothing less
/// is divided by.
pub(super) const LEAST_TARGET: f64 = 0.05;

// Variation.

/// Parts into which either leg of a patch is divided, so that it falls into the square of them; a number.
/// Chosen, not fitted, as far as the history tells.
pub(super) const CUTS: usize = 8;

/// Lamps nearer than so many radii of a patch light it unevenly; a pure number. Chosen, not fitted, as far as
/// the history tells.
pub(super) const NEAR_LAMP: f64 = 1.5;
