//! Constants of the verdict: from where on something is wrong. All are chosen, not fitted.
//!
//! `tests/behaviour/verdict` holds that sound scenes stay below them and that each fault put in on purpose
//! comes out above.

/// The part of the emitted power from which on an answer is doubtful; a pure number. A tenth of the 1 % by
/// face that usual settings aim at: less is covered by error bars, more is an error that they do not know of.
pub(super) const DOUBTFUL: f64 = 1e-3;

/// The part of the emitted power from which on it is bad; a pure number. No error bar covers that, and the
/// eye sees it.
pub(super) const BAD: f64 = 0.05;

/// The bound on the error from which on an answer is doubtful though it may be within it; a pure number.
/// Nobody could work with it.
pub(super) const WIDE: f64 = 0.25;

/// What may be missing from a sum that is exact but for rounding, relative; a pure number. Stored exchange
/// areas are rounded to 6e-8.
pub(super) const EXACT: f64 = 1e-6;

/// Iterative solvers may leave so many times their tolerance; a pure number.
pub(super) const TOLERANCES: f64 = 10.0;

/// A patch of less irradiance than this part of the root mean square is dark: its error is relative to that.
/// A pure number.
pub(super) const DARK: f64 = 1e-3;

/// Noise of so many standard errors is no fault; a pure number. Chance exceeds it in one of 15 000 answers.
pub(super) const STANDARD_ERRORS: f64 = 4.0;

/// The most solid angles that are summed to find what is inside closed surfaces, patches with the most
/// escaping power first; a number. A limit on time.
pub(super) const MOST_ANGLES: usize = 250_000;

/// Faces that lack more than this part of what they exchange are named, however little power that is; a pure
/// number.
pub(super) const NOTABLE: f64 = 1e-3;

/// A row that lacks more than this part of its area has neither exchange nor escape; a pure number. 1 but for
/// rounding.
pub(super) const EMPTY: f64 = 1.0 - 1e-9;

/// Faces and objects that are named one by one, at most; a number.
pub(super) const FEW: usize = 3;
