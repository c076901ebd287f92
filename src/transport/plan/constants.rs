//! Constants of the forecast: what parts of a run cost, and how many of them there are.
//!
//! Those called *fitted* were fitted to timed runs on two cores of an AMD EPYC (Zen). The scenes of these
//! runs are not recorded, and no script makes the fit again; `tests/behaviour/plan.rs` holds numbers of
//! patches, rays and bytes against runs, but not seconds.

/// Time of one thread for a ray through a scene of n faces, a + b log₂ n: [a, b], ns. Fitted.
pub(super) const RAY: [f64; 2] = [30.0, 47.0];

/// The same for a ray that only asks whether something is hidden: [a, b], ns. Fitted.
pub(super) const SHADOW_RAY: [f64; 2] = [40.0, 13.0];

/// Further specular surfaces that a ray meets once it has met one, on average; a number. Chosen, not fitted,
/// as far as the history tells.
pub(super) const CARRIERS_MET: f64 = 1.2;

/// Time of one thread to sort a landing into the matrix, ns. Fitted.
pub(super) const LANDING: f64 = 55.0;

/// Time of [`MEMORY_THREADS`] threads together for a byte of the matrix in one product: of one channel, and
/// of several, ns. Fitted.
pub(super) const BYTE: [f64; 2] = [0.055, 0.075];

/// More threads than these make no product quicker, since it is bound by memory; a number. Chosen: the
/// machine of the fit has no more.
pub(super) const MEMORY_THREADS: usize = 2;

/// Products that balancing takes, of a traced matrix and of exact form factors; a number. Fitted.
pub(super) const BALANCING: f64 = 45.0;
pub(super) const BALANCING_EXACT: f64 = 6.0;

/// Time of one thread for the exact exchange area of two patches, ns. Fitted.
pub(super) const PAIR: f64 = 80.0;

/// Time of error bars as a part of that of balancing; a pure number. Fitted.
pub(super) const ERRORS: f64 = 0.6;

/// Multiplications and additions of one thread while factoring, s⁻¹. Fitted.
pub(super) const FACTORING: f64 = 5e10;

/// Multiplications and additions of all factors that still count as quick; a number. Chosen to be a second or
/// two: two cores do some 10¹¹ a second, see [`FACTORING`].
pub(super) const QUICK: f64 = 1.2e11;

/// Products that solving takes once the matrix is factored; a number. Chosen, not fitted.
pub(super) const FACTORED_PRODUCTS: f64 = 4.0;

/// Products of conjugate gradients for each order of the series that has the same residual, and further ones
/// that bound the error; numbers. Rules of thumb, not fitted.
pub(super) const CG_PER_ORDER: f64 = 0.5;
pub(super) const CG_BOUND: f64 = 8.0;

/// Vectors (a value per coefficient and channel) that conjugate gradients and the series hold; a number.
/// Counted in the code, not fitted.
pub(super) const CG_VECTORS: f64 = 5.0;
pub(super) const SERIES_VECTORS: f64 = 3.0;

/// The part that light passes on at a surface is taken to lie within these when orders are counted; pure
/// numbers. Chosen, not fitted, so that the number of orders is finite and not 0.
pub(super) const PASSED_ON: [f64; 2] = [1e-3, 0.999];

/// The same for the tolerance, at least; a pure number. Chosen, not fitted.
pub(super) const LEAST_TOLERANCE: f64 = 1e-15;

/// Time to read a face, to build it into the tracer, and to write a patch, ns. Fitted.
pub(super) const FACE_READ: f64 = 1100.0;
pub(super) const FACE_BUILT: f64 = 430.0;
pub(super) const PATCH_WRITTEN: f64 = 5000.0;

/// Time of one thread for a pixel beside its rays, ns. Fitted.
pub(super) const PIXEL: f64 = 400.0;

/// Rays of a pixel; a number. Chosen, not fitted, as far as the history tells.
pub(super) const PIXEL_RAYS: f64 = 2.5;

/// How many times as many rays more a pixel takes where all of them see specular surfaces; a pure number.
/// Chosen, not fitted, as far as the history tells.
pub(super) const PIXEL_CARRIED: f64 = 20.0;

/// Rays by which a slot looks for light around it, on average; a number. Chosen, not fitted, as far as the
/// history tells.
pub(super) const LOOKS: f64 = 20.0;

/// Time that all channels beside the first add, as a part of that of solving; a pure number. Chosen, not
/// fitted, as far as the history tells.
pub(super) const OTHER_CHANNELS: f64 = 0.3;

/// Random points that tell how full the matrix is: those that look, the patches they look at, and the points
/// on specular surfaces; numbers. Chosen: with these the number of entries comes out within a tenth where
/// nothing hides anything and a third in furnished rooms, as `tests/behaviour/plan.rs` checks.
pub(super) const DENSITY_ROWS: u32 = 192;
pub(super) const DENSITY_COLUMNS: u32 = 768;
pub(super) const DENSITY_CARRIERS: u32 = 128;

/// The fastest fading of visibility that is looked for, per normalised length, and the halvings of that
/// interval; a number. Chosen, not fitted.
pub(super) const MOST_FADING: f64 = 64.0;
pub(super) const FADING_HALVINGS: u32 = 16;

// Bytes, counted by what the stored types hold.

/// Memory of a number of a field, a vector or factors, bytes.
pub(super) const NUMBER_BYTES: f64 = 8.0;

/// Memory of an entry of a full matrix, and of a sparse one with its column, bytes.
pub(super) const FULL_ENTRY_BYTES: f64 = 4.0;
pub(super) const SPARSE_ENTRY_BYTES: f64 = 8.0;

/// Memory of a sparse matrix for each patch that the rays of another find, by which it is held against a full
/// one, bytes: 1.5 entries, for most pairs are met from both sides or from one.
pub(super) const SPARSE_FOUND_BYTES: f64 = 12.0;

/// Memory of a ray's end, of constant elements and of linear ones, which keep the place in the patch too,
/// bytes.
pub(super) const LANDING_BYTES: f64 = 4.0;
pub(super) const LANDING_BYTES_LINEAR: f64 = 6.0;

/// Memory of pairs of linear elements: of a ray that is kept as it is, of the block of sums that stands for
/// many, and of a patch beside these, bytes.
pub(super) const PAIR_RAY_BYTES: f64 = 8.0;
pub(super) const PAIR_BLOCK_BYTES: f64 = 40.0;
pub(super) const PAIRED_PATCH_BYTES: f64 = 24.0;

/// Memory of a pixel, bytes: three numbers.
pub(super) const PIXEL_BYTES: f64 = 3.0 * NUMBER_BYTES;
