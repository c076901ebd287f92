//! Light: a source without area, which lights surfaces and is none itself.

mod environment;
mod general_sky;
mod ies;
mod sky;

use std::f64::consts::{PI, TAU};

use std::sync::Arc;

use glam::DVec3;

use super::spelled::{listed, spelled};
use super::{FARTHEST, LARGEST, is_near};
pub use environment::Environment;
pub use general_sky::GeneralSky;
pub use ies::IntensityTable;
pub use sky::{Sky, SkyKind, SkyShares};

/// A light without area. Places and directions are those of the scene; every power has a value per channel.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Sends the same intensity in every direction.
    Point {
        /// Where, metres.
        position: DVec3,
        /// Radiant intensity, W·sr⁻¹.
        intensity: Vec<f64>,
    },
    /// Sends light into a cone, with an edge in which it falls smoothly to nothing.
    Spot {
        /// Where, metres.
        position: DVec3,
        /// The cone's axis, a unit vector.
        direction: DVec3,
        /// Radiant intensity within the cone, W·sr⁻¹.
        intensity: Vec<f64>,
        /// Angle between the axis and the end of all light, degrees, above 0 to 180.
        cone: f64,
        /// Angle over which intensity falls, inwards from the end of all light, degrees, 0 to `cone`.
        penumbra: f64,
    },
    /// A luminaire small beside its distance, which sends what its photometric file says in each direction.
    Ies {
        /// Where, metres.
        position: DVec3,
        /// Where the file's vertical angle 0 points, a unit vector; usually down.
        direction: DVec3,
        /// Where its horizontal angle 0 points: a unit vector at right angles to `direction`.
        c0: DVec3,
        /// Radiant intensity in the direction that the file says is brightest, W·sr⁻¹.
        intensity: Vec<f64>,
        /// Intensity by direction.
        table: Arc<IntensityTable>,
    },
    /// Comes from a disc infinitely far away, such as the sun.
    Sun {
        /// Which way its light travels, a unit vector.
        direction: DVec3,
        /// Irradiance of a surface that faces it, W·m⁻².
        irradiance: Vec<f64>,
        /// How wide the disc looks, degrees, 0 (for shadows without an edge) to below 180; the sun's is
        /// 0.533.
        diameter: f64,
    },
}

impl Light {
    /// Intensity or irradiance, per channel.
    pub fn power(&self) -> &[f64] {
        match self {
            Light::Point { intensity, .. } | Light::Spot { intensity, .. } | Light::Ies { intensity, .. } => {
                intensity
            }
            Light::Sun { irradiance, .. } => irradiance,
        }
    }

    /// Where it is, metres; none of a sun.
    pub fn position(&self) -> Option<DVec3> {
        match *self {
            Light::Point { position, .. } | Light::Spot { position, .. } | Light::Ies { position, .. } => {
                Some(position)
            }
            Light::Sun { .. } => None,
        }
    }

    pub(crate) fn position_mut(&mut self) -> Option<&mut DVec3> {
        match self {
            Light::Point { position, .. } | Light::Spot { position, .. } | Light::Ies { position, .. } => {
                Some(position)
            }
            Light::Sun { .. } => None,
        }
    }

    pub(crate) fn power_mut(&mut self) -> &mut Vec<f64> {
        match self {
            Light::Point { intensity, .. } | Light::Spot { intensity, .. } | Light::Ies { intensity, .. } => {
                intensity
            }
            Light::Sun { irradiance, .. } => irradiance,
        }
    }

    /// `point`, `spot`, `ies` or `sun`.
    pub fn kind(&self) -> &'static str {
        match self {
            Light::Point { .. } => "point",
            Light::Spot { .. } => "spot",
            Light::Ies { .. } => "ies",
            Light::Sun { .. } => "sun",
        }
    }

    /// Radiant flux that it sends in all directions, per channel, W; none of a sun, which has no end.
    pub fn flux(&self) -> Option<Vec<f64>> {
        let directions = match self {
            Light::Point { .. } => SPHERE,
            Light::Spot { cone, penumbra, .. } => spot_solid_angle(*cone, *penumbra),
            Light::Ies { table, .. } => table.flux() / table.highest(),
            Light::Sun { .. } => return None,
        };
        Some(self.power().iter().map(|intensity| intensity * directions).collect())
    }

    /// Into which directions it shines: a cone's axis and solid angle, sr; all directions but of spots.
    pub(crate) fn cone(&self) -> (DVec3, f64) {
        match *self {
            Light::Spot { direction, cone, .. } => (direction, TAU * (1.0 - cone.to_radians().cos())),
            _ => (DVec3::Y, SPHERE),
        }
    }

    /// Whether any light comes from it.
    pub fn shines(&self) -> bool {
        self.power().iter().any(|&x| x > 0.0)
    }

    /// The share of [`Light::power`] that is sent in a direction, a unit vector; 1 for points and suns.
    #[inline]
    pub fn share_towards(&self, towards: DVec3) -> f64 {
        match *self {
            Light::Spot { direction, cone, penumbra, .. } => {
                edge(direction.angle_between(towards).to_degrees(), cone, penumbra)
            }
            Light::Ies { direction, c0, ref table, .. } => {
                // φ grows from C0 to its left as seen from behind, where the axis points away.
                let (along, ahead, left) =
                    (towards.dot(direction), towards.dot(c0), towards.dot(c0.cross(direction)));
                let vertical = along.clamp(-1.0, 1.0).acos().to_degrees();
                table.at(vertical, left.atan2(ahead).to_degrees()) / table.highest()
            }
            Light::Point { .. } | Light::Sun { .. } => 1.0,
        }
    }

    /// What is wrong with it, if anything.
    pub(crate) fn check(&self, channels: usize) -> Result<(), String> {
        let unit = |v: DVec3, what: &str| match (v.length() - 1.0).abs() < 1e-9 {
            true => Ok(()),
            false => Err(format!("{what} {v} is no direction; give three finite numbers that are not all 0")),
        };
        match *self {
            Light::Point { position, .. } | Light::Spot { position, .. } | Light::Ies { position, .. }
                if !is_near(position) =>
            {
                return Err(format!(
                    "position {} m must be finite, no coordinate beyond {FARTHEST:e} m",
                    listed(position.to_array())
                ));
            }
            Light::Spot { direction, cone, penumbra, .. } => {
                unit(direction, "direction")?;
                if !(cone > 0.0 && cone <= 180.0 && (0.0..=cone).contains(&penumbra)) {
                    return Err(format!(
                        "cone {} must lie above 0 and at most at 180 degrees, and penumbra {} between 0 and the cone",
                        spelled(cone),
                        spelled(penumbra)
                    ));
                }
            }
            Light::Sun { direction, diameter, .. } => {
                unit(direction, "direction")?;
                if !(0.0..180.0).contains(&diameter) {
                    let diameter = spelled(diameter);
                    return Err(format!("diameter {diameter} must lie between 0 and 180 degrees"));
                }
            }
            Light::Ies { direction, c0, .. } => {
                unit(direction, "direction")?;
                unit(c0, "up")?;
                if c0.dot(direction).abs() > 1e-9 {
                    return Err(format!("up {c0} must stand at right angles to direction {direction}"));
                }
            }
            Light::Point { .. } => {}
        }
        check_power(self.power(), channels)
    }
}

/// What is wrong with a power per channel, if anything.
pub(crate) fn check_power(power: &[f64], channels: usize) -> Result<(), String> {
    if power.len() != channels {
        return Err(format!("it must have {channels} channels, as materials have"));
    }
    match power.iter().find(|x| !(0.0..=LARGEST).contains(*x)) {
        Some(x) => Err(format!(
            "{}: how much light it sends must be at most {LARGEST:e}, and not negative",
            spelled(*x)
        )),
        None => Ok(()),
    }
}

/// 1 within the cone, 0 outside, and a smooth step (3t² − 2t³) in between; all angles in degrees.
fn edge(angle: f64, cone: f64, penumbra: f64) -> f64 {
    if angle >= cone {
        return 0.0;
    }
    let t = if penumbra > 0.0 { ((cone - angle) / penumbra).min(1.0) } else { 1.0 };
    t * t * (3.0 - 2.0 * t)
}

/// Solid angle of a cone with a soft edge, weighted by how much it sends: flux per unit of intensity, sr.
pub(crate) fn spot_solid_angle(cone: f64, penumbra: f64) -> f64 {
    /// Intervals of the midpoint rule over the edge.
    const STEPS: usize = 4096;
    let inner = TAU * (1.0 - (cone - penumbra).to_radians().cos());
    let width = penumbra / STEPS as f64;
    let ring = |k: usize| {
        let angle = cone - penumbra + (k as f64 + 0.5) * width;
        edge(angle, cone, penumbra) * TAU * angle.to_radians().sin() * width.to_radians()
    };
    inner + if penumbra > 0.0 { (0..STEPS).map(ring).sum::<f64>() } else { 0.0 }
}

/// All directions, sr.
pub(crate) const SPHERE: f64 = 4.0 * PI;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spot_of_all_directions_is_a_point() {
        assert!((spot_solid_angle(180.0, 0.0) - SPHERE).abs() < 1e-12);
        assert!((spot_solid_angle(60.0, 0.0) - PI).abs() < 1e-12);
    }

    #[test]
    fn a_soft_edge_sends_less_than_the_hard_cone_and_more_than_its_core() {
        let soft = spot_solid_angle(40.0, 10.0);
        assert!(soft < spot_solid_angle(40.0, 0.0) && soft > spot_solid_angle(30.0, 0.0));
        // Half of a narrow edge counts, to first order.
        let narrow = spot_solid_angle(40.0, 0.01);
        assert!((narrow / spot_solid_angle(39.995, 0.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_edge_of_a_spot_falls_from_one_to_nothing() {
        let samples: Vec<f64> = (0..=100).map(|k| edge(f64::from(k), 60.0, 20.0)).collect();
        assert!(samples.is_sorted_by(|a, b| a >= b));
        assert_eq!([samples[40], samples[50], samples[60]], [1.0, 0.5, 0.0]);
    }
}
