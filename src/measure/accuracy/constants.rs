//! Constants of the search for accuracy: where it starts, what it expects, and when it goes on or gives up.
//!
//! None changes an answer with given patches and rays; they decide which are tried. As far as the history
//! tells, all are chosen, not fitted. That searches end as they should is tested in
//! `tests/behaviour/error_bars.rs`.

/// Patches and rays per patch of the first step; numbers. Chosen: coarse and quick.
pub(super) const FIRST_PATCHES: f64 = 256.0;
pub(super) const FIRST_RAYS: f64 = 64.0;

/// The fewest and most rays per patch that are tried; numbers. Chosen, not fitted.
pub(super) const RAYS_RANGE: [f64; 2] = [32.0, 4096.0];

/// Numbers of rays that are tried lie so far apart, as a logarithm to base 2; a pure number. Chosen, not
/// fitted: four to a doubling, as of patches.
pub(super) const RAYS_STEP: f64 = 0.25;

/// How many numbers of patches are tried, and the ratio of each to the one before: 2^¼; pure numbers. Chosen,
/// not fitted.
pub(super) const RUNGS: i32 = 80;
pub(super) const RUNG: f64 = 1.189_207_115_002_721;

/// No number of patches is tried that is less than this part of the last; a pure number. Chosen, a little
/// below 1 since faces are cut in whole steps.
pub(super) const LEAST_OF_LAST: f64 = 0.98;

/// The most steps; a number. Chosen, not fitted.
pub(super) const MOST_STEPS: usize = 10;

/// No step costs more than so many times the one before; a pure number. Chosen: how errors fall is known only
/// roughly until it has been seen.
pub(super) const MOST_COST_RATIO: f64 = 25.0;

/// After a step that missed the goal, the next costs at least so many times its work, or so many where it
/// only adds rays, whose effect is known better; pure numbers. Chosen, not fitted.
pub(super) const LEAST_COST_RATIO: f64 = 1.4;
pub(super) const LEAST_COST_RATIO_OF_RAYS: f64 = 1.2;

/// The fewest rays per patch that are worth adding; a number. Chosen, not fitted.
pub(super) const FEWEST_MORE_RAYS: f64 = 16.0;

/// Steps aim at this part of the goal, since predictions come true only roughly; a pure number. Chosen, not
/// fitted.
pub(super) const AIM: f64 = 0.95;

/// Where faces have fewer patches than this on average, what light does within most of them is not seen: an
/// answer is believed only once it was found again with so many times the patches of the first step. Pure
/// numbers. Chosen, not fitted.
pub(super) const PATCHES_PER_FACE: f64 = 3.0;
pub(super) const CONFIRMATION: f64 = 1.5;

/// So many answers in a row that are not good end the search, since one more would not be either; a number.
/// Chosen, not fitted.
pub(super) const MOST_DOUBTFUL: usize = 2;

/// A step that would leave more than this part of the error is not worth its time where the goal is out of
/// reach; a pure number. Chosen, not fitted.
pub(super) const WORTHWHILE: f64 = 0.9;

/// The part of the time that steps may take; the rest is for solving once more, for pictures and files. A
/// pure number. Chosen, not fitted.
pub(super) const TIME_FOR_STEPS: f64 = 0.85;

/// Settings whose numbers of patches and of rays differ by less than this part are the same; a pure number.
/// Chosen, not fitted.
pub(super) const SAME_SETTING: f64 = 0.2;

/// Cuts whose numbers of patches differ by less than this part are the same; a pure number. Chosen: less than
/// a rung.
pub(super) const SAME_CUT: f64 = 0.02;

/// What a patch costs beside its rays, in rays; a number. Chosen, not fitted, as far as the history
/// tells.
pub(super) const PATCH_IN_RAYS: f64 = 56.0;

/// Noise falls as the number of rays to minus this power; a pure number. Chosen, not fitted, as far as the
/// history tells: a little more than the ½ of independent rays, since rays are spread evenly. It is the only
/// exponent of noise that is no mathematics: elsewhere variances add, and independent light paths converge as
/// the root of their number.
pub(super) const NOISE_POWER: f64 = 0.55;

/// Mesh error of this part of the noise is hidden by it; a pure number. Chosen, not fitted, as far as the
/// history tells.
pub(super) const HIDDEN: f64 = 0.15;

/// Mesh error is taken to fall as the edge, the root of patches, to this power before two cuts have told; a
/// pure number. Chosen, not fitted, as far as the history tells.
pub(super) const MESH_POWER: f64 = 1.4;

/// The powers that two cuts can tell, and the least of them with which the coarser cut was not blind; pure
/// numbers. Chosen, not fitted.
pub(super) const MESH_POWERS: [f64; 2] = [1.0, 2.0];
pub(super) const LEAST_MESH_POWER: f64 = 0.5;

/// Two cuts tell that power where one has more than so many times the patches of the other; a pure number.
/// Chosen, not fitted.
pub(super) const TELLING_RATIO: f64 = 1.5;

/// How many patches can be merged into one on most cuts; a number. Chosen, not fitted, as far as the
/// history tells.
pub(super) const USUALLY_MERGED: f64 = 3.0;
