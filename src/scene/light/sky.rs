//! Sky: light from all directions beyond the scene.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use std::sync::Arc;

use super::check_power;
use super::environment::Environment;
use super::general_sky::GeneralSky;
use crate::scene::photometry::luminance;
use crate::scene::spelled::spelled;

/// A sky around the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Sky {
    /// How brightness is spread.
    pub kind: SkyKind,
    /// Which way is up, a unit vector.
    pub up: DVec3,
    /// Radiance at the zenith, per channel, W·sr⁻¹·m⁻²; of an environment what its value of 1 means.
    pub zenith: Vec<f64>,
    /// Reflectance of the ground outside, 0 to 1: below the horizon the sky's own light comes back from it,
    /// evenly.
    pub ground: f64,
}

/// How brightness is spread over a sky.
#[derive(Clone, Debug, PartialEq)]
pub enum SkyKind {
    /// The same in all directions, below the horizon too.
    Constant,
    /// The CIE standard overcast sky (Moon & Spencer 1942): L = L_z (1 + 2 sin γ)/3 at elevation γ.
    Overcast,
    /// The CIE standard clear sky (Kittler 1967; CIE S 003): L = L_z f(χ)φ(Z) / (f(Z_s)φ(0)) at an angle χ
    /// from the sun and Z from the zenith, with f(χ) = 0.91 + 10 e^(−3χ) + 0.45 cos²χ and φ(Z) = 1 −
    /// e^(−0.32/cos Z). The sun itself is a light of its own.
    Clear {
        /// Towards the sun, a unit vector above the horizon.
        sun: DVec3,
    },
    /// One of the fifteen CIE standard general skies.
    General(GeneralSky),
    /// As a picture says, below the horizon too.
    Environment(Arc<Environment>),
}

/// Radiance of a sky by direction, as a share of the zenith's.
#[derive(Clone, Debug)]
pub struct SkyShares {
    kind: SkyKind,
    up: DVec3,
    /// What the formula gives at the zenith.
    zenith: f64,
    /// The share below the horizon.
    below: f64,
}

impl SkyShares {
    /// The share that comes from a direction, a unit vector that points into the sky; and by what red, green
    /// and blue of it are to be multiplied, where they differ. A single channel takes the first.
    #[inline]
    pub fn tinted(&self, towards: DVec3) -> (f64, Option<[f64; 3]>) {
        let SkyKind::Environment(environment) = &self.kind else { return (self.from(towards), None) };
        let colour = environment.from(towards);
        match luminance(&colour) {
            share if share > 0.0 => (share, Some(colour.map(|x| x / share))),
            _ => (0.0, None),
        }
    }

    /// The share that comes from a direction, a unit vector that points into the sky; of an environment its
    /// luminance.
    #[inline]
    pub fn from(&self, towards: DVec3) -> f64 {
        let height = towards.dot(self.up);
        match self.kind {
            SkyKind::Environment(ref environment) => luminance(&environment.from(towards)),
            SkyKind::Constant => 1.0,
            _ if height < 0.0 => self.below,
            SkyKind::Overcast => (1.0 + 2.0 * height) / 3.0,
            SkyKind::Clear { sun } => scattering(towards.dot(sun)) * gradation(height) / self.zenith,
            SkyKind::General(ref sky) => sky.relative(towards, height) / self.zenith,
        }
    }
}

/// f(χ) of a clear sky, by cos χ.
fn scattering(cosine: f64) -> f64 {
    0.91 + 10.0 * (-3.0 * cosine.clamp(-1.0, 1.0).acos()).exp() + 0.45 * cosine * cosine
}

/// φ(Z) of a clear sky, by cos Z.
fn gradation(height: f64) -> f64 {
    1.0 - (-0.32 / height.max(1e-12)).exp()
}

impl Sky {
    /// How its brightness is spread, ready to be asked many times.
    pub fn shares(&self) -> SkyShares {
        let Self { kind, up, .. } = self.clone();
        let zenith = match kind {
            SkyKind::Clear { sun } => scattering(sun.dot(up)) * gradation(1.0),
            SkyKind::General(sky) => sky.relative(up, 1.0),
            SkyKind::Constant | SkyKind::Overcast | SkyKind::Environment(_) => 1.0,
        };
        let below = match kind {
            SkyKind::Constant | SkyKind::Environment(_) => 1.0,
            _ if self.ground == 0.0 => 0.0,
            _ => self.ground * self.horizontal() / PI,
        };
        SkyShares { kind, up, zenith, below }
    }

    /// Irradiance of open horizontal ground by the sky above, for a zenith of radiance 1; sr. 7π/9 under an
    /// overcast sky: ∫ (1 + 2cos θ)/3 cos θ dω = (2π/3)(1/2 + 2/3).
    pub fn horizontal(&self) -> f64 {
        match self.kind {
            SkyKind::Environment(ref environment) => environment.horizontal(),
            SkyKind::Constant => PI,
            SkyKind::Overcast => 7.0 * PI / 9.0,
            SkyKind::Clear { .. } | SkyKind::General(_) => self.horizontal_by_steps(),
        }
    }

    /// The same by the midpoint rule.
    fn horizontal_by_steps(&self) -> f64 {
        const STEPS: usize = 256;
        let shares = Self { ground: 0.0, ..self.clone() }.shares();
        let across = self.up.any_orthonormal_vector();
        let along = self.up.cross(across);
        let cell = (FRAC_PI_2 / STEPS as f64) * (TAU / STEPS as f64);
        let at = |i: usize, j: usize| {
            let theta = (i as f64 + 0.5) / STEPS as f64 * FRAC_PI_2;
            let phi = (j as f64 + 0.5) / STEPS as f64 * TAU;
            let (sine, cosine) = theta.sin_cos();
            let towards = cosine * self.up + sine * (phi.cos() * across + phi.sin() * along);
            shares.from(towards) * cosine * sine * cell
        };
        (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| at(i, j))).sum()
    }

    /// Whether any light comes from it.
    pub fn shines(&self) -> bool {
        let dark = match &self.kind {
            SkyKind::Environment(environment) => environment.pixels().highest() == [0.0; 3],
            _ => false,
        };
        !dark && self.zenith.iter().any(|&x| x > 0.0)
    }

    /// Whether it has no colour of its own but that of the zenith.
    pub(crate) fn is_colourless(&self) -> bool {
        match &self.kind {
            SkyKind::Environment(environment) => environment.pixels().is_grey(),
            _ => true,
        }
    }

    /// What is wrong with it, if anything.
    pub(crate) fn check(&self, channels: usize) -> Result<(), String> {
        let is_unit = |v: DVec3| (v.length() - 1.0).abs() < 1e-9;
        if !is_unit(self.up) {
            return Err("up must be three finite numbers that are not all 0".into());
        }
        let sun = match self.kind {
            SkyKind::Clear { sun } => Some(sun),
            SkyKind::General(sky) => sky.depends_on_sun().then(|| sky.sun()),
            _ => None,
        };
        if sun.is_some_and(|sun| !(is_unit(sun) && sun.dot(self.up) >= 0.0)) {
            return Err("sun must point to the sun, and not below the horizon".into());
        }
        if matches!(self.kind, SkyKind::Environment(_)) && !matches!(channels, 1 | 3) {
            return Err("an environment has red, green and blue: materials must have 1 channel or 3".into());
        }
        if !(0.0..=1.0).contains(&self.ground) {
            let ground = spelled(self.ground);
            return Err(format!("ground {ground} is a reflectance and must lie between 0 and 1"));
        }
        check_power(&self.zenith, channels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(kind: SkyKind) -> Sky {
        Sky { kind, up: DVec3::Y, zenith: vec![1.0], ground: 0.2 }
    }

    #[test]
    fn the_zenith_has_the_radiance_of_the_zenith() {
        let sun = DVec3::new(0.3, 0.5, -0.2).normalize();
        for kind in [SkyKind::Constant, SkyKind::Overcast, SkyKind::Clear { sun }] {
            assert!((sky(kind.clone()).shares().from(DVec3::Y) - 1.0).abs() < 1e-12, "{kind:?}");
        }
        assert!(sky(SkyKind::Clear { sun }).shares().from(sun) > 3.0);
        assert!((sky(SkyKind::Overcast).shares().from(DVec3::X) - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn below_the_horizon_is_ground_lit_by_the_sky() {
        let overcast = sky(SkyKind::Overcast);
        assert!((overcast.shares().from(-DVec3::Y) - 0.2 * 7.0 / 9.0).abs() < 1e-12);
    }

    #[test]
    fn general_skies_are_the_simple_ones_where_these_are_of_a_type() {
        let sun = DVec3::new(0.3, 0.5, -0.2).normalize();
        let general = |number: usize| sky(SkyKind::General(GeneralSky::new(number, sun).unwrap()));
        let clear = sky(SkyKind::Clear { sun });
        for from in [DVec3::Y, DVec3::new(0.4, 0.2, 0.1).normalize(), DVec3::new(-0.9, 0.1, 0.3).normalize()]
        {
            assert!((general(12).shares().from(from) / clear.shares().from(from) - 1.0).abs() < 1e-3);
            assert!((general(5).shares().from(from) - 1.0).abs() < 1e-12, "an even one");
        }
        assert!((general(5).horizontal() / PI - 1.0).abs() < 1e-4);
        // An overcast sky is three times as bright at the zenith as at the horizon.
        let horizon = general(1).shares().from(DVec3::X + 1e-9 * DVec3::Y);
        assert!((horizon - 1.0 / (1.0 + 4.0 * (-0.7f64).exp())).abs() < 1e-6, "{horizon}");
        assert_eq!(GeneralSky::new(16, sun), None);
    }

    #[test]
    fn clear_skies_turn_with_up_and_sun() {
        let sun = DVec3::new(0.6, 0.8, 0.0);
        let upright = Sky { kind: SkyKind::Clear { sun }, ..sky(SkyKind::Constant) };
        let lying =
            Sky { kind: SkyKind::Clear { sun: DVec3::new(0.0, 0.6, 0.8) }, up: DVec3::Z, ..upright.clone() };
        let from = DVec3::new(-0.2, 0.4, 0.7).normalize();
        let turned = DVec3::new(from.z, from.x, from.y);
        assert!((upright.shares().from(from) - lying.shares().from(turned)).abs() < 1e-12);
        assert!((upright.horizontal() / lying.horizontal() - 1.0).abs() < 1e-6);
    }
}
