//! The CIE standard general sky (CIE S 011/E:2003, ISO 15469:2004): fifteen ways in which brightness is
//! spread, from overcast to cloudless.
//!
//! L = L_z f(χ) φ(Z) / (f(Z_s) φ(0)) at an angle χ from the sun and Z from the zenith, with φ(Z) = 1 + a
//! e^(b/cos Z) and f(χ) = 1 + c (e^(dχ) − e^(dπ/2)) + e cos²χ.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

/// a, b, c, d and e of each type (CIE S 011/E:2003, table 1).
const PARAMETERS: [[f64; 5]; 15] = [
    [4.0, -0.70, 0.0, -1.0, 0.0],
    [4.0, -0.70, 2.0, -1.5, 0.15],
    [1.1, -0.80, 0.0, -1.0, 0.0],
    [1.1, -0.80, 2.0, -1.5, 0.15],
    [0.0, -1.00, 0.0, -1.0, 0.0],
    [0.0, -1.00, 2.0, -1.5, 0.15],
    [0.0, -1.00, 5.0, -2.5, 0.30],
    [0.0, -1.00, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.30],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];

/// A sky of one of the fifteen types.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralSky {
    number: usize,
    sun: DVec3,
}

impl GeneralSky {
    /// How many types there are.
    pub const TYPES: usize = PARAMETERS.len();

    /// The sky of a type, 1 to 15, with the sun in this direction, a unit vector; none of other types.
    pub fn new(number: usize, sun: DVec3) -> Option<Self> {
        (1..=Self::TYPES).contains(&number).then_some(Self { number, sun })
    }

    /// Whether it matters where the sun is.
    pub fn depends_on_sun(&self) -> bool {
        let [_, _, c, _, e] = self.parameters();
        c != 0.0 || e != 0.0
    }

    /// Towards the sun, a unit vector.
    pub fn sun(&self) -> DVec3 {
        self.sun
    }

    fn parameters(&self) -> [f64; 5] {
        PARAMETERS[self.number - 1]
    }

    /// f(χ) φ(Z) in a direction above the horizon, at this sine of its elevation.
    #[inline]
    pub(super) fn relative(&self, towards: DVec3, height: f64) -> f64 {
        let [a, b, c, d, e] = self.parameters();
        let gradation = 1.0 + a * (b / height.max(1e-12)).exp();
        let cosine = towards.dot(self.sun).clamp(-1.0, 1.0);
        let scattering = 1.0 + c * ((d * cosine.acos()).exp() - (d * FRAC_PI_2).exp()) + e * cosine * cosine;
        gradation * scattering
    }
}
