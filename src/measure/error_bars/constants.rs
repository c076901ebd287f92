//! Constants of the error bars: how far errors may exceed what batches of rays and merged patches tell.
//!
//! Those called *fitted* or *measured* say on what, where the history tells. `examples/fit_constants` holds
//! those of [`FITTED`] against the errors of scenes that nothing else looks at, and says what would fit
//! these. What comes of them is tested in `tests/behaviour/error_bars.rs`: noise against answers with other
//! rays, and bounds against another renderer's answers.

/// Constants of error bars that are fitted to scenes; pure numbers.
#[derive(Clone, Copy, Debug)]
pub struct Fitted {
    /// How many times more than independent batches the parts of rays to lights without area differ.
    pub evenness: f64,
    /// How many times its estimate the mesh error does not exceed in nineteen of twenty cases.
    pub mesh_at_most: f64,
    /// The part of the relative mesh error of the whole scene that every patch and face has.
    pub common: f64,
}

/// Those in use.
pub const FITTED: Fitted = Fitted { evenness: EVENNESS, mesh_at_most: MESH_AT_MOST, common: COMMON };

/// Patches that are merged into one to tell the mesh error of constant elements; a number. Chosen: a face of
/// five by five patches becomes one of three by three.
pub(super) const MERGED: f64 = 5.0;

/// The same of linear elements; a number. Chosen: they are held against constant ones on the same patches.
pub(super) const MERGED_LINEAR: f64 = 1.0;

/// Patches merged into one that tell of the mesh error what they can; where fewer are, the bound on it is
/// wider. A number, fitted with [`MESH_AT_MOST`].
pub(super) const MERGED_ENOUGH: f64 = 3.0;

/// Mesh error of linear elements as a part of their difference from constant ones; a pure number. Chosen,
/// not fitted, as far as the history tells: they err about a third as much.
pub(super) const REMAINS_LINEAR: f64 = 0.4;

/// How many times its estimate the mesh error does not exceed in nineteen of twenty cases, of constant
/// elements and of linear ones; pure numbers. Fitted to rooms that no test looks at.
pub(super) const MESH_AT_MOST: f64 = 1.8;
pub(super) const MESH_AT_MOST_LINEAR: f64 = 1.6;

/// How many times larger the mesh error is where lamps shine by way of curved specular surfaces; a pure
/// number. Measured with other glass than tests have: light is gathered in spots smaller than patches.
pub(super) const FOCUSED: f64 = 2.0;

/// Specular surfaces whose normals are more than these are curved; a number. Chosen: a box of mirrors has
/// six.
pub(super) const FLAT_NORMALS: usize = 12;

/// Normals are rounded to this part of a unit, its inverse, before they are counted; a pure number. Chosen:
/// about a degree.
pub(super) const NORMAL_STEPS: f64 = 60.0;

/// How exactly changes are solved for, relative to them; a pure number. Chosen: an error bar need not be
/// known better.
pub(super) const CHANGE_TOLERANCE: f64 = 0.01;

/// The part of the relative mesh error of the whole scene that every patch and face has, since its own may
/// vanish by chance; a pure number. Fitted: more of it widens bars on large faces and helps few others.
pub(super) const COMMON: f64 = 0.3;

/// About how many clusters of patches the noise that is reflected on is solved for, and the fewest patches in
/// one; numbers. Chosen: what is reflected varies slowly.
pub(super) const CLUSTERS: f64 = 128.0;
pub(super) const FEWEST_PER_CLUSTER: f64 = 8.0;

/// How many times more than independent batches the parts of rays to lights without area differ: they are
/// stretches of one sequence, which lie more evenly together. A pure number. Measured with skies and spots.
pub(super) const EVENNESS: f64 = 1.5;

/// How many times what batches tell the noise does not exceed in nineteen of twenty cases, beside their
/// scatter; a pure number. Fitted to Cornell boxes and rooms that no test looks at.
pub(super) const NOISE_AT_MOST: f64 = 1.05;

/// What linear elements add to that where each batch has one ray; a pure number, and less in proportion where
/// it has more. Fitted to the same: what few rays make of three coefficients shows in all batches alike.
pub(super) const NOISE_AT_MOST_LINEAR: f64 = 6.0;

/// Student's t for 95 % of one side and 7 degrees of freedom, one less than there are batches; a pure number.
/// Mathematics, rounded; form factors between groups use the same quantile with more digits. Each keeps its
/// own, since bounds that are written out would differ in the fourth digit.
pub(super) const STUDENT: f64 = 1.895;

/// What holds in 95 cases of 100, as a multiple of one standard error; a pure number. The quantile of the
/// normal distribution, rounded.
pub const BOUND_95: f64 = 1.960;

/// How many times wider than one standard deviation by so few batches a bar is for [`BOUND_95`] of it to
/// hold in 95 cases of 100: two-sided Student's t for 7 and for 15 degrees of freedom, over the normal
/// quantile; pure numbers. Mathematics, rounded. The first is of patches' rays and light, in 8 batches, the
/// second of receivers' own rays, in 16.
pub(super) const EIGHT_BATCHES: f64 = 2.365 / BOUND_95;
pub(super) const SIXTEEN_BATCHES: f64 = 2.131 / BOUND_95;

/// The relative rounding of stored exchange areas; a pure number, by their format.
pub(super) const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

/// Rounding that may change irradiance by this part by the condition alone is looked at more closely; a pure
/// number. Chosen, not fitted: a tenth of what usual settings aim at.
pub(super) const NOTICEABLE: f64 = 1e-3;

/// Rows of form factors that together lack less than this part of their sum lack nothing; a pure number.
/// Chosen, not fitted.
pub(super) const CLOSED: f64 = 1e-9;

/// A row that lacks all but this part sees nothing; a pure number. Chosen, not fitted.
pub(super) const SEES_NOTHING: f64 = 1e-12;

/// How many times its estimate the error by slack is taken not to exceed; a pure number. Chosen, not fitted:
/// where the missing light lies is not known.
pub(super) const SLACK_AT_MOST: f64 = 2.0;

/// Objects with less than this part of all patches do not speak for the scene: they are seldom asked for. A
/// pure number; by the definition of what is told.
pub(super) const LEAST_PATCHES: f64 = 0.01;
