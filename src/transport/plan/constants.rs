//! Constants of the forecast: what parts of a run cost, and how many of them there are.
//!
//! Those called *fitted* were fitted to timed runs on two cores of an AMD EPYC (Zen). The scenes of the first
//! of these runs are not recorded, and no script makes the fit again. What apertures, textures, contacts and
//! nooks take was fitted later, to the CPU time of the stages of three meshes of rooms of 300 to 21 000 faces
//! on a busy machine: it is known to a third or so. `tests/behaviour/plan.rs` holds numbers of patches, rays
//! and bytes against runs, but not seconds.

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

/// How many more it takes where every patch is a whole face, as in meshes of many nooks; a number. Fitted to
/// meshes of 300 to 21 000 faces, which took 80 to 210 in all.
pub(super) const BALANCING_NOOKS: f64 = 150.0;

/// Time beside a product for each value of its vectors, on one thread: in balancing, and in conjugate
/// gradients and the series, ns. Fitted to the same two.
pub(super) const BALANCING_VALUE: f64 = 180.0;
pub(super) const VALUE: f64 = 40.0;

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

/// Time to look for apertures, where there are sky or suns, for each face, ns. Fitted.
pub(super) const FACE_SEARCHED: f64 = 20_000.0;

/// Time of one thread for a pixel beside its rays, ns. Fitted.
pub(super) const PIXEL: f64 = 400.0;

/// Rays of a pixel; a number. Chosen, not fitted, as far as the history tells.
pub(super) const PIXEL_RAYS: f64 = 2.5;

/// How many times as many rays more a pixel takes where all of them see specular surfaces; a pure number.
/// Chosen, not fitted, as far as the history tells.
pub(super) const PIXEL_CARRIED: f64 = 20.0;

/// Rays by which a slot looks for light around it, in the coarse cut that comes first and in the one after
/// it; numbers. Counted in the code.
pub(super) const LOOKS: [f64; 2] = [4.0, 16.0];

/// Patches of the coarse cut where faces are fewer; a number. Counted in the code.
pub(super) const COARSE: f64 = 1000.0;

/// Looks of a slot at lamps, at lights without area and at the sky, at most; a number. Counted in the code.
pub(super) const SLOT_LOOKS: u32 = 32;

/// Rays that are shot in through each triangle of an aperture, and on all of the scene, from each sun and
/// from the sky, and rays from each light that has a place, for one cut; numbers. Counted in the code.
pub(super) const SHOT_THROUGH: f64 = 1024.0;
pub(super) const SHOT_ON_ALL: f64 = 65536.0;
pub(super) const SHOT_FROM_PLACE: f64 = 4096.0;

/// How many times as many points of a patch look at a light through apertures or in a narrow cone, and the
/// part of them that is drawn without regard to apertures, so that they cost a ray; pure numbers. Counted in
/// the code.
pub(super) const MORE_POINTS: f64 = 32.0;
pub(super) const POINTS_WITHOUT_APERTURES: f64 = 0.25;

/// Random patches, and slots, by which is told how sky and lights are looked for; numbers. Chosen: enough to
/// know the few patches that take eight times the rays to a third, and still quick.
pub(super) const EXPOSED: u32 = 1024;
pub(super) const SLOTS_EXPOSED: u32 = 512;

/// Time of one thread for a point that looks at a light and costs no ray, ns. Estimated, not fitted.
pub(super) const POINT: f64 = 60.0;

/// Time of one thread that a ray into the sky takes more where apertures are weighed: for itself, and for
/// each of the [`MOST_WEIGHED`] triangles of apertures that are weighed at most, ns. Fitted.
pub(super) const AIMED: [f64; 2] = [300.0, 60.0];
pub(super) const MOST_WEIGHED: f64 = 16.0;

/// Time of one thread to find out which apertures a slot sees, for each triangle of them, ns. Fitted.
pub(super) const APERTURE_SEEN: f64 = 30.0;

/// Time of one thread to find what touches a face, and to part it, for all sizes that are tried, ns. Fitted.
pub(super) const FACE_PARTED: f64 = 50_000.0;

/// Texels beyond which a patch is averaged on a coarser picture; a number. Counted in the code.
pub(super) const MOST_TEXELS: f64 = 16384.0;

/// Time of one thread for a texel that a patch covers in part, and for one that it covers wholly, ns. Fitted.
pub(super) const TEXEL: [f64; 2] = [450.0, 10.0];

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
