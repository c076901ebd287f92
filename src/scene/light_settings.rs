//! Light settings: `[[light]]` and `[sky]` of a scene's `.toml`.
//!
//! A power is given in watts or in lumens, and the name of its key tells which: `intensity` (W/sr) or `luminous_intensity` (cd), `flux`
//! (W) or `luminous_flux` (lm), `irradiance` (W/m²) or `illuminance` (lx), `radiance` (W/sr/m²) or `luminance` (cd/m²). Those in watts are
//! one number or three; those in lumens are one number, whose colour is that of `colour`.

use glam::DVec3;
use serde::Deserialize;

use super::light::{SPHERE, spot_solid_angle};
use super::photometry::luminance;
use super::settings::Colour;
use super::{Light, Sky, SkyKind};

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum LightSettings {
    Point {
        position: [f64; 3],
        intensity: Option<Colour>,
        luminous_intensity: Option<f64>,
        flux: Option<Colour>,
        luminous_flux: Option<f64>,
        colour: Option<Colour>,
    },
    Spot {
        position: [f64; 3],
        target: Option<[f64; 3]>,
        direction: Option<[f64; 3]>,
        cone: f64,
        #[serde(default)]
        penumbra: f64,
        intensity: Option<Colour>,
        luminous_intensity: Option<f64>,
        flux: Option<Colour>,
        luminous_flux: Option<f64>,
        colour: Option<Colour>,
    },
    Sun {
        direction: [f64; 3],
        /// 0 if not given: a shadow without an edge.
        #[serde(default)]
        diameter: f64,
        irradiance: Option<Colour>,
        illuminance: Option<f64>,
        colour: Option<Colour>,
    },
}

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum SkySettings {
    Constant {
        radiance: Option<Colour>,
        luminance: Option<f64>,
        colour: Option<Colour>,
    },
    Overcast {
        #[serde(default = "super::settings::y_up")]
        up: [f64; 3],
        #[serde(default)]
        ground: f64,
        radiance: Option<Colour>,
        luminance: Option<f64>,
        irradiance: Option<Colour>,
        illuminance: Option<f64>,
        colour: Option<Colour>,
    },
    Clear {
        #[serde(default = "super::settings::y_up")]
        up: [f64; 3],
        sun: [f64; 3],
        #[serde(default)]
        ground: f64,
        radiance: Option<Colour>,
        luminance: Option<f64>,
        irradiance: Option<Colour>,
        illuminance: Option<f64>,
        colour: Option<Colour>,
    },
}

impl LightSettings {
    /// The light in metres and watts; `unit` in metres, `efficacy` in lm/W.
    pub fn light(&self, unit: f64, efficacy: f64) -> Result<Light, String> {
        let light = match self {
            Self::Point { position, intensity, luminous_intensity, flux, luminous_flux, colour } => {
                Light::Point {
                    position: DVec3::from(*position) * unit,
                    intensity: one_of(
                        &[
                            Amount::watts("intensity", intensity, 1.0),
                            Amount::lumens("luminous_intensity", *luminous_intensity, 1.0),
                            Amount::watts("flux", flux, SPHERE),
                            Amount::lumens("luminous_flux", *luminous_flux, SPHERE),
                        ],
                        colour.as_ref(),
                        efficacy,
                    )?,
                }
            }
            Self::Spot {
                position,
                target,
                direction,
                cone,
                penumbra,
                intensity,
                luminous_intensity,
                flux,
                luminous_flux,
                colour,
            } => {
                let aim = match (target, direction) {
                    (Some(target), None) => DVec3::from(*target) - DVec3::from(*position),
                    (None, Some(direction)) => DVec3::from(*direction),
                    _ => return Err("aim it by target or by direction, one of the two".into()),
                };
                let sent = spot_solid_angle(*cone, *penumbra);
                let intensity = one_of(
                    &[
                        Amount::watts("intensity", intensity, 1.0),
                        Amount::lumens("luminous_intensity", *luminous_intensity, 1.0),
                        Amount::watts("flux", flux, sent),
                        Amount::lumens("luminous_flux", *luminous_flux, sent),
                    ],
                    colour.as_ref(),
                    efficacy,
                )?;
                Light::Spot {
                    position: DVec3::from(*position) * unit,
                    direction: aim.normalize_or_zero(),
                    intensity,
                    cone: *cone,
                    penumbra: *penumbra,
                }
            }
            Self::Sun { direction, diameter, irradiance, illuminance, colour } => Light::Sun {
                direction: DVec3::from(*direction).normalize_or_zero(),
                diameter: *diameter,
                irradiance: one_of(
                    &[
                        Amount::watts("irradiance", irradiance, 1.0),
                        Amount::lumens("illuminance", *illuminance, 1.0),
                    ],
                    colour.as_ref(),
                    efficacy,
                )?,
            },
        };
        light.check(3)?;
        Ok(light)
    }
}

impl SkySettings {
    /// The sky in watts; `efficacy` in lm/W.
    pub fn sky(&self, efficacy: f64) -> Result<Sky, String> {
        let (mut sky, [radiance, irradiance], [luminance, illuminance], colour) = match self {
            Self::Constant { radiance, luminance, colour } => {
                let sky = Sky { kind: SkyKind::Constant, up: DVec3::Y, zenith: vec![0.0; 3], ground: 0.0 };
                (sky, [radiance, &None], [luminance, &None], colour)
            }
            Self::Overcast { up, ground, radiance, luminance, irradiance, illuminance, colour } => {
                let up = DVec3::from(*up).normalize_or_zero();
                let sky = Sky { kind: SkyKind::Overcast, up, zenith: vec![0.0; 3], ground: *ground };
                (sky, [radiance, irradiance], [luminance, illuminance], colour)
            }
            Self::Clear { up, sun, ground, radiance, luminance, irradiance, illuminance, colour } => {
                let up = DVec3::from(*up).normalize_or_zero();
                let kind = SkyKind::Clear { sun: DVec3::from(*sun).normalize_or_zero() };
                let sky = Sky { kind, up, zenith: vec![0.0; 3], ground: *ground };
                (sky, [radiance, irradiance], [luminance, illuminance], colour)
            }
        };
        sky.check(3)?;
        let horizontal = sky.horizontal();
        let mut amounts =
            vec![Amount::watts("radiance", radiance, 1.0), Amount::lumens("luminance", *luminance, 1.0)];
        if sky.kind != SkyKind::Constant {
            amounts.push(Amount::watts("irradiance", irradiance, horizontal));
            amounts.push(Amount::lumens("illuminance", *illuminance, horizontal));
        }
        sky.zenith = one_of(&amounts, colour.as_ref(), efficacy)?;
        sky.check(3)?;
        Ok(sky)
    }
}

/// A power as it may be given: its key, its value, and how much of it goes with one unit of what is wanted.
struct Amount<'a> {
    key: &'static str,
    value: Option<Value<'a>>,
    per_unit: f64,
}

enum Value<'a> {
    Watts(&'a Colour),
    Lumens(f64),
}

impl<'a> Amount<'a> {
    fn watts(key: &'static str, value: &'a Option<Colour>, per_unit: f64) -> Self {
        Self { key, value: value.as_ref().map(Value::Watts), per_unit }
    }

    fn lumens(key: &'static str, value: Option<f64>, per_unit: f64) -> Self {
        Self { key, value: value.map(Value::Lumens), per_unit }
    }
}

/// The one amount that is given, in watts per channel.
fn one_of(amounts: &[Amount], colour: Option<&Colour>, efficacy: f64) -> Result<Vec<f64>, String> {
    let keys: Vec<&str> = amounts.iter().map(|amount| amount.key).collect();
    let mut given = amounts.iter().filter_map(|amount| Some((amount, amount.value.as_ref()?)));
    let (Some((amount, value)), None) = (given.next(), given.next()) else {
        return Err(format!("say how much light it sends by one of {}", keys.join(", ")));
    };
    match value {
        Value::Watts(_) if colour.is_some() => {
            Err(format!("{} has a colour of its own: give it as [r, g, b] and leave out colour", amount.key))
        }
        Value::Watts(watts) => Ok(watts.channels().iter().map(|x| x / amount.per_unit).collect()),
        Value::Lumens(lumens) => {
            let colour = colour.map_or(vec![1.0; 3], Colour::channels);
            let whole = luminance(&colour);
            if !(whole > 0.0 && whole.is_finite() && colour.iter().all(|&x| x >= 0.0)) {
                return Err("colour must not be negative or black".into());
            }
            Ok(colour.iter().map(|x| x / whole * lumens / efficacy / amount.per_unit).collect())
        }
    }
}
