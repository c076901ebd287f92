//! Limits: after how many surfaces a ray is given up, and how far out the scene can reach.
//!
//! The caps end what need not end by itself, such as a ray between two parallel mirrors. They are chosen, not
//! fitted.

/// The most specular surfaces that a ray is followed over from one diffuse surface to the next, for form
/// factors, shadow rays through thin glass and camera rays; a number. What is still on its way then is lost.
pub(super) const MOST_CARRIERS: u32 = 256;

/// The same for light paths of the reference; a number. More than what it is to judge, so that what is lost
/// between the two shows.
pub(crate) const MOST_CARRIERS_OF_PATHS: u32 = 1000;

/// The same for camera rays that follow both reflection and refraction at every surface; a number.
pub(crate) const MOST_CARRIERS_OF_BRANCHES: u32 = 32;

/// The most surfaces that a straight line is followed through to find in which dielectric it starts; a
/// number.
pub(super) const MOST_CROSSED: u32 = 4096;

/// The most surfaces that a straight line is followed through to find whether it starts inside of something;
/// a number. Fewer than [`MOST_CROSSED`], as a limit on time: 64 lines from a place are counted, and for a
/// warning alone. In which dielectric a point lies is told by two or three lines, and changes the light.
pub(crate) const MOST_CROSSINGS: usize = 1000;

/// Rays from suns and skies start so far from what they aim at; normalised lengths. Chosen: points of the
/// cube [−1, 1]³, in which the scene lies, are at most √12 ≈ 3.46 apart.
pub(crate) const OUTSIDE: f64 = 4.0;
