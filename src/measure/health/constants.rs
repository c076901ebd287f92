//! Constants of the health reports: from where on a finding is told, and how many rays look for it. All are
//! chosen, not fitted.

use std::ops::Range;

/// The most faces that a finding names; a number.
pub(super) const MOST_FACES: usize = 10;

// Shape.

/// Extents of scenes that are plausible, m. Others are likely given in another unit.
pub(super) const PLAUSIBLE: Range<f64> = 0.02..300.0;

/// Longest edge over height from which on a face is a sliver, as meshing tools avoid, and a needle, which
/// arithmetic notices; pure numbers.
pub(super) const SLIVER: f64 = 1e3;
pub(super) const NEEDLE: f64 = 1e6;

// Gaps.

/// The widest crack, relative to the length of its edge; a pure number.
pub(super) const CRACK: f64 = 0.01;

/// How far from an edge a vertex may lie and still be on it: normalised lengths, and no more than this part
/// of the edge. Coordinates are often written with six digits.
pub(super) const ON_EDGE: f64 = 2e-6;
pub(super) const ON_EDGE_OF_LENGTH: f64 = 1e-3;

/// A vertex is within an edge if it is farther from its ends than so many times that; a pure number.
pub(super) const WITHIN_EDGE: f64 = 2.0;

/// A gap lies beside a face, not beyond its edge, if it points into the face by more than this cosine; a pure
/// number.
pub(super) const INTO_FACE: f64 = 0.5;

// Lamps.

/// Rays by which all lamps look, and the fewest and most from a side of a face; numbers.
pub(super) const LAMP_RAYS: usize = 1 << 15;
pub(super) const LAMP_RAYS_PER_SIDE: Range<usize> = 8..1024;

/// What is nearer than this part of the root of a lamp's area is right before it; a pure number.
pub(super) const NEAR_LAMP: f64 = 0.05;

// Leaks.

/// Bounces after which a path is given up; a number.
pub(super) const LEAK_BOUNCES: u32 = 64;

/// The part of light that escapes from which on a scene is open; a pure number.
pub(super) const OPEN: f64 = 0.1;

/// The part of light that escapes below which a narrow gap is an oversight; a pure number.
pub(super) const OVERSIGHT: f64 = 0.05;

/// The widest narrow gap, relative to the extent of the scene; a pure number.
pub(super) const NARROW: f64 = 0.01;

/// Escaping rays whose openings are measured; a number. A limit on time.
pub(super) const MEASURED: usize = 2000;

/// Axes along which an escaping ray is tilted, a number, and tangents of the angles, each twice the one
/// before.
pub(super) const TILT_AXES: usize = 4;
pub(super) const TILTS: [f64; 9] =
    [1.0 / 256.0, 1.0 / 128.0, 1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0, 0.125, 0.25, 0.5, 1.0];

// Placement.

/// Directions in which a place looks around; a number.
pub(super) const LOOKS: u32 = 64;

/// Directions that are drawn for each one that is looked along from a light, to find those in which it
/// shines; a number.
pub(super) const DRAWN_PER_LOOK: u32 = 8;

/// Points of a receiver that look around; a number.
pub(super) const RECEIVER_POINTS: usize = 16;

/// What is as large as this part of the longest side of the scene holds the scene and is no solid in it; a
/// pure number.
pub(super) const ROOM: f64 = 0.5;

// The operator.

/// What rounding may do to a sum of shares; a pure number.
pub(super) const ROUNDING: f64 = 1e-9;

/// Energy that may go missing before results show it, relative; a pure number.
pub(super) const TOLERABLE: f64 = 0.01;

/// Condition numbers up to which six digits of a solution are safe, and any; pure numbers.
pub(super) const WELL_CONDITIONED: f64 = 1e3;
pub(super) const ILL_CONDITIONED: f64 = 1e6;

/// What lies farther from the box around the scene than this part of its longest side, over it or elsewhere,
/// is no part of it; pure numbers. Chosen: what is measured in front of walls is nearer.
pub(super) const FAR_OVER: f64 = 10.0;
pub(super) const BESIDE: f64 = 0.1;

/// What lies no farther behind a face than this part of the scene's longest side is right behind it; a
/// pure number. Chosen: two centimetres in a room of four metres.
pub(super) const RIGHT_BEHIND: f64 = 0.005;
