//! Constants of the study: what it tries, how it shares out time, and what it makes of the rows.
//!
//! As far as the history tells, all are chosen, not fitted. `tests/behaviour/study.rs` holds that conclusions
//! repeat with another seed.

// What is tried.

/// Each value of a knob is so many times the one before; a number.
pub(super) const STEP: usize = 4;

/// Values of a knob that a trend can be told from; a number.
pub(super) const FEWEST_VALUES: usize = 3;

/// The fewest patches to begin with, in all and for each side of a face; numbers.
pub(super) const FIRST_PATCHES: usize = 128;
pub(super) const FIRST_PATCHES_PER_SIDE: usize = 2;

/// Rays per patch to begin with; a number.
pub(super) const FIRST_RAYS: usize = 16;

/// The most patches and rays per patch; numbers.
pub(super) const MOST_PATCHES: usize = 1 << 20;
pub(super) const MOST_RAYS: u32 = 1 << 14;

/// Orders at which the series is truncated.
pub(super) const ORDERS: [usize; 5] = [1, 2, 4, 8, 16];

/// A cell is measured so often that all its rays come to this number; a number.
pub(super) const RAYS_OF_REPEATS: usize = 1 << 21;

/// How often a cell is measured at least and at most; numbers. Never once, for the spread between answers is
/// part of what is measured.
pub(super) const REPEATS: [usize; 2] = [2, 24];

// Time.

/// About what one repeat of a cell takes on two cores: cutting a patch, s.
pub(super) const PATCH_SECONDS: f64 = 4e-6;

/// The same: a ray with its shadow rays, s.
pub(super) const RAY_SECONDS: f64 = 2.4e-7;

/// The same: all solvers together, for an entry of the matrix, s; and entries for each ray, a number.
pub(super) const ENTRY_SECONDS: f64 = 6e-8;
pub(super) const ENTRIES_PER_RAY: f64 = 1.5;

/// The last cells by which the time of the next is predicted, the slowest of them; a number.
pub(super) const LAST_CELLS: usize = 3;

/// The part of the time that the reference and light paths against it may take; a pure number.
pub(super) const REFERENCE_SHARE: f64 = 0.4;

/// The part of that for the reference alone; a pure number.
pub(super) const REFERENCE_ALONE: f64 = 0.85;

// Light paths.

/// Paths a side of a face that the reference begins with; a number.
pub(super) const FIRST_REFERENCE_PATHS: u64 = 256;

/// Paths a side of a face that are held against it to begin with, and by how much they grow; numbers.
pub(super) const FIRST_PATHS: u64 = 32;
pub(super) const PATHS_STEP: u64 = 4;

/// How many times fewer paths than the reference has are held against it at most; a number. They err five
/// times as much.
pub(super) const FEWER_PATHS: u64 = 24;

// What is told.

/// Standard errors by which an error stands out from the noise of the reference, and those that make a limit
/// where it does not; pure numbers.
pub(super) const RESOLVED: f64 = 2.0;
pub(super) const LIMIT: f64 = 3.0;

/// Times that differ by less than this factor are the same; a pure number. Clocks on a busy machine tell no
/// more.
pub(super) const SAME_TIME: f64 = 1.05;

/// Turning a knob helps as long as it lowers error by this factor at least for every factor of so much; pure
/// numbers.
pub(super) const HELPS: f64 = 1.2;
pub(super) const HELPS_PER: f64 = 4.0;

/// Errors that people ask for, relative; pure numbers.
pub(super) const ACCURACIES: [f64; 9] = [0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005];

/// Truncation stands apart from the rest of the error while all is more than so many times the rest; a pure
/// number.
pub(super) const TRUNCATION_APART: f64 = 2.0;

/// An order is high enough if the error exceeds that of the whole solution by no more than this factor; a
/// pure number.
pub(super) const ORDER_ENOUGH: f64 = 1.1;

/// A higher order is what helps where the error exceeds that of the whole solution by more than this factor,
/// and by so many standard errors beside; pure numbers.
pub(super) const ORDER_LACKS: f64 = 1.2;
pub(super) const ORDER_LACKS_ERRORS: f64 = 2.0;

/// Knobs whose gains differ by less than this factor are as good as each other; a pure number.
pub(super) const AS_GOOD: f64 = 1.5;

/// A gain, in per cent of error for a per cent of time, that is less than this is none; a pure number.
pub(super) const NO_GAIN: f64 = 0.05;

/// The least logarithm of a ratio of times by which a gain is divided; a pure number. So equal times divide
/// by no zero.
pub(super) const LEAST_LOG_TIME: f64 = 0.1;
