//! Light settings: `[[light]]` and `[sky]` of a scene's `.toml`.
//!
//! A power is given in watts or in lumens, and the name of its key tells which: `intensity` (W/sr) or
//! `luminous_intensity` (cd), `flux` (W) or `luminous_flux` (lm), `irradiance` (W/m²) or `illuminance` (lx),
//! `radiance` (W/sr/m²) or `luminance` (cd/m²). Those in watts are one number or three; those in lumens are
//! one number, whose colour is that of `colour`. Luminaires and environments bring their light in a file,
//! which `scale` and the like multiply.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use serde::Deserialize;

use super::beside::Beside;
use super::colour::Colour;
use super::picture_file;
use super::text::decode;
use crate::scene::light::{
    Environment, GeneralSky, IntensityTable, SPHERE, Sky, SkyKind, check_power, spot_solid_angle,
};
use crate::scene::photometry::luminance;
use crate::scene::{Light, Pixels};

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(crate) enum LightSettings {
    Point {
        position: [f64; 3],
        intensity: Option<Colour>,
        luminous_intensity: Option<f64>,
        flux: Option<Colour>,
        luminous_flux: Option<f64>,
        #[serde(alias = "color")]
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
        #[serde(alias = "color")]
        colour: Option<Colour>,
    },
    Ies {
        file: PathBuf,
        position: [f64; 3],
        target: Option<[f64; 3]>,
        direction: Option<[f64; 3]>,
        up: Option<[f64; 3]>,
        scale: Option<f64>,
        luminous_flux: Option<f64>,
        #[serde(alias = "color")]
        colour: Option<Colour>,
    },
    Sun {
        direction: [f64; 3],
        /// 0 if not given: a shadow without an edge.
        #[serde(default)]
        diameter: f64,
        irradiance: Option<Colour>,
        illuminance: Option<f64>,
        #[serde(alias = "color")]
        colour: Option<Colour>,
    },
}

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(crate) enum SkySettings {
    Constant {
        #[serde(default = "y_up")]
        up: [f64; 3],
        /// If not given the sky shines from below, too.
        ground: Option<f64>,
        radiance: Option<Colour>,
        luminance: Option<f64>,
        irradiance: Option<Colour>,
        illuminance: Option<f64>,
        #[serde(alias = "color")]
        colour: Option<Colour>,
    },
    Overcast {
        #[serde(default = "y_up")]
        up: [f64; 3],
        #[serde(default)]
        ground: f64,
        radiance: Option<Colour>,
        luminance: Option<f64>,
        irradiance: Option<Colour>,
        illuminance: Option<f64>,
        #[serde(alias = "color")]
        colour: Option<Colour>,
    },
    /// One of the CIE standard general skies, or 16 for the traditional overcast one.
    Cie {
        r#type: usize,
        #[serde(default = "y_up")]
        up: [f64; 3],
        sun: Option<[f64; 3]>,
        #[serde(default)]
        ground: f64,
        radiance: Option<Colour>,
        luminance: Option<f64>,
        irradiance: Option<Colour>,
        illuminance: Option<f64>,
        #[serde(alias = "color")]
        colour: Option<Colour>,
    },
    Environment {
        file: PathBuf,
        #[serde(default = "y_up")]
        up: [f64; 3],
        /// Degrees.
        #[serde(default)]
        turn: f64,
        scale: Option<f64>,
        luminance: Option<f64>,
        irradiance: Option<f64>,
        illuminance: Option<f64>,
    },
    Clear {
        #[serde(default = "y_up")]
        up: [f64; 3],
        sun: [f64; 3],
        #[serde(default)]
        ground: f64,
        radiance: Option<Colour>,
        luminance: Option<f64>,
        irradiance: Option<Colour>,
        illuminance: Option<f64>,
        #[serde(alias = "color")]
        colour: Option<Colour>,
    },
}

/// What settings are read with.
pub(super) struct World<'a> {
    /// Metres.
    pub unit: f64,
    /// Lumens per watt.
    pub efficacy: f64,
    /// A unit vector.
    pub up: DVec3,
    /// Where files lie.
    pub beside: &'a Beside,
    pub warnings: &'a mut Vec<String>,
}

impl LightSettings {
    /// The light in metres and watts.
    pub fn light(&self, world: &mut World) -> Result<Light, String> {
        let (unit, efficacy) = (world.unit, world.efficacy);
        let light = match self {
            Self::Point { position, intensity, luminous_intensity, flux, luminous_flux, colour } => {
                let amounts = by_intensity([intensity, flux], [*luminous_intensity, *luminous_flux], SPHERE);
                let intensity = one_of(&amounts, colour.as_ref(), efficacy)?;
                Light::Point { position: DVec3::from(*position) * unit, intensity }
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
                let direction = aim(position, target, direction)?;
                let sent = spot_solid_angle(*cone, *penumbra);
                let amounts = by_intensity([intensity, flux], [*luminous_intensity, *luminous_flux], sent);
                Light::Spot {
                    position: DVec3::from(*position) * unit,
                    direction,
                    intensity: one_of(&amounts, colour.as_ref(), efficacy)?,
                    cone: *cone,
                    penumbra: *penumbra,
                }
            }
            Self::Ies { file, position, target, direction, up: c0, scale, luminous_flux, colour } => {
                let direction = aim(position, target, direction)?;
                let table = intensity_table(file, world)?;
                let from_down = direction.dot(-world.up).clamp(-1.0, 1.0).acos().to_degrees();
                let factor = match (scale, luminous_flux) {
                    (Some(_), Some(_)) => return Err("give scale or luminous_flux, one of the two".into()),
                    (None, Some(lumens)) => lumens / table.flux(),
                    (scale, None) => scale.unwrap_or(1.0) * table.tilt_factor(from_down),
                };
                let colour = of_luminance_one(colour.as_ref())?;
                let c0 = c0.map_or_else(|| default_c0(direction), DVec3::from);
                Light::Ies {
                    position: DVec3::from(*position) * unit,
                    direction,
                    c0: (c0 - direction * c0.dot(direction)).normalize_or_zero(),
                    intensity: colour.iter().map(|x| x * factor * table.highest() / efficacy).collect(),
                    table: Arc::new(table),
                }
            }
            Self::Sun { direction, diameter, irradiance, illuminance, colour } => {
                let amounts = [
                    Amount::watts("irradiance", irradiance, 1.0),
                    Amount::lumens("illuminance", *illuminance, 1.0),
                ];
                Light::Sun {
                    direction: DVec3::from(*direction).normalize_or_zero(),
                    diameter: *diameter,
                    irradiance: one_of(&amounts, colour.as_ref(), efficacy)?,
                }
            }
        };
        light.check(3)?;
        Ok(light)
    }
}

/// An intensity, by itself or by the flux that it sends into a solid angle; in watts and in lumens.
fn by_intensity<'a>(
    [intensity, flux]: [&'a Option<Colour>; 2],
    [luminous_intensity, luminous_flux]: [Option<f64>; 2],
    solid_angle: f64,
) -> [Amount<'a>; 4] {
    [
        Amount::watts("intensity", intensity, 1.0),
        Amount::lumens("luminous_intensity", luminous_intensity, 1.0),
        Amount::watts("flux", flux, solid_angle),
        Amount::lumens("luminous_flux", luminous_flux, solid_angle),
    ]
}

/// A unit vector, or zero, from a target or a direction.
fn aim(
    position: &[f64; 3],
    target: &Option<[f64; 3]>,
    direction: &Option<[f64; 3]>,
) -> Result<DVec3, String> {
    match (target, direction) {
        (Some(target), None) => Ok((DVec3::from(*target) - DVec3::from(*position)).normalize_or_zero()),
        (None, Some(direction)) => Ok(DVec3::from(*direction).normalize_or_zero()),
        _ => Err("aim it by target or by direction, one of the two".into()),
    }
}

fn y_up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

/// Where horizontal angle 0 points if nothing is said: along x, or along z if the luminaire's axis nearly
/// does.
fn default_c0(direction: DVec3) -> DVec3 {
    if direction.x.abs() < 0.9 { DVec3::X } else { DVec3::Z }
}

fn intensity_table(file: &Path, world: &mut World) -> Result<IntensityTable, String> {
    let path = world.beside.find_light(file)?;
    let bytes = std::fs::read(&path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
    let mut said = Vec::new();
    let table = IntensityTable::parse(&decode(&bytes), &mut said)
        .map_err(|(line, message)| format!("{}:{line}: {message}", path.display()))?;
    if table.highest() == 0.0 {
        said.push("every intensity is 0: no light comes from it".into());
    }
    world.warnings.extend(said.into_iter().map(|message| format!("light: {}: {message}", path.display())));
    Ok(table)
}

impl SkySettings {
    /// The sky in watts.
    pub fn sky(&self, world: &mut World) -> Result<Sky, String> {
        let efficacy = world.efficacy;
        let (mut sky, [radiance, irradiance], [luminance, illuminance], colour) = match self {
            Self::Constant { up, ground, radiance, luminance, irradiance, illuminance, colour } => {
                let up = DVec3::from(*up).normalize_or_zero();
                // Over ground it is the even one of the general skies.
                let even = || GeneralSky::new(EVEN, up).map_or(SkyKind::Constant, SkyKind::General);
                let kind = if ground.is_some() { even() } else { SkyKind::Constant };
                let sky = Sky { kind, up, zenith: vec![0.0; 3], ground: ground.unwrap_or(0.0) };
                (sky, [radiance, irradiance], [luminance, illuminance], colour)
            }
            Self::Cie { r#type, up, sun, ground, radiance, luminance, irradiance, illuminance, colour } => {
                let up = DVec3::from(*up).normalize_or_zero();
                let kind = general_sky(*r#type, up, *sun)?;
                let sky = Sky { kind, up, zenith: vec![0.0; 3], ground: *ground };
                (sky, [radiance, irradiance], [luminance, illuminance], colour)
            }
            Self::Overcast { up, ground, radiance, luminance, irradiance, illuminance, colour } => {
                let up = DVec3::from(*up).normalize_or_zero();
                let sky = Sky { kind: SkyKind::Overcast, up, zenith: vec![0.0; 3], ground: *ground };
                (sky, [radiance, irradiance], [luminance, illuminance], colour)
            }
            Self::Environment { file, up, turn, scale, luminance, irradiance, illuminance } => {
                let amounts = [
                    ("scale", *scale, Value::Factor(1.0)),
                    ("luminance", *luminance, Value::Factor(efficacy)),
                    ("irradiance", *irradiance, Value::OfGround(1.0)),
                    ("illuminance", *illuminance, Value::OfGround(efficacy)),
                ];
                let up = DVec3::from(*up).normalize_or_zero();
                let pixels = environment_picture(file, world)?;
                if !turn.is_finite() {
                    return Err(format!("turn {turn} must be a number of degrees"));
                }
                return environment(Environment::new(pixels, up, *turn), up, &amounts);
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
        let amounts = [
            Amount::watts("radiance", radiance, 1.0),
            Amount::lumens("luminance", *luminance, 1.0),
            Amount::watts("irradiance", irradiance, horizontal),
            Amount::lumens("illuminance", *illuminance, horizontal),
        ];
        sky.zenith = one_of(&amounts, colour.as_ref(), efficacy)?;
        sky.check(3)?;
        Ok(sky)
    }
}

/// The type of general sky that is the same in all directions.
const EVEN: usize = 5;

/// A CIE sky by its number.
fn general_sky(number: usize, up: DVec3, sun: Option<[f64; 3]>) -> Result<SkyKind, String> {
    let most = GeneralSky::TYPES;
    if number == most + 1 {
        return Ok(SkyKind::Overcast);
    }
    let towards = sun.map_or(up, |sun| DVec3::from(sun).normalize_or_zero());
    let sky = GeneralSky::new(number, towards).ok_or_else(|| {
        format!("type {number} must be 1 to {most}, or {} for the traditional overcast sky", most + 1)
    })?;
    if sun.is_none() && sky.depends_on_sun() {
        return Err(format!("a sky of type {number} needs `sun`, three numbers that point to it"));
    }
    Ok(SkyKind::General(sky))
}

/// What the number behind a key of an environment is divided by to get what a value of 1 in the picture
/// means.
enum Value {
    /// This.
    Factor(f64),
    /// This, times what open level ground gets under the picture as it is.
    OfGround(f64),
}

/// A picture of all that is around.
fn environment_picture(file: &Path, world: &mut World) -> Result<Pixels, String> {
    let path = world.beside.find_light(file)?;
    let about = |message: String| format!("{}: {message}", path.display());
    let pixels = picture_file::read(&path).map_err(about)?;
    let [width, height] = pixels.size();
    if width != 2 * height {
        world.warnings.push(format!(
            "sky: {}: {width} x {height} pixels are stretched around the scene; a picture by longitude and latitude is twice as wide as high",
            path.display()
        ));
    }
    if pixels.highest() == [0.0; 3] {
        world.warnings.push(format!("sky: {}: the picture is black: no light comes from it", path.display()));
    }
    Ok(pixels)
}

/// A sky from a picture.
fn environment(
    environment: Environment,
    up: DVec3,
    amounts: &[(&str, Option<f64>, Value)],
) -> Result<Sky, String> {
    let kind = SkyKind::Environment(Arc::new(environment));
    let mut sky = Sky { kind, up, zenith: vec![1.0; 3], ground: 0.0 };
    sky.check(3)?;
    let mut given = amounts.iter().filter_map(|(key, number, value)| Some((key, (*number)?, value)));
    let (first, None) = (given.next(), given.next()) else {
        let keys: Vec<&str> = amounts.iter().map(|amount| amount.0).collect();
        return Err(format!("say how bright it is by no more than one of {}", keys.join(", ")));
    };
    if let Some((key, number, value)) = first {
        let unit = match value {
            Value::Factor(unit) => *unit,
            Value::OfGround(unit) => unit * sky.horizontal(),
        };
        if unit == 0.0 {
            return Err(format!("{key}: nothing above the horizon is bright; give scale instead"));
        }
        sky.zenith = vec![number / unit; 3];
    }
    sky.check(3)?;
    Ok(sky)
}

/// A power as it may be given: its key, its value, and how much of it goes with one unit of what is wanted.
struct Amount<'a> {
    key: &'static str,
    value: Option<Power<'a>>,
    per_unit: f64,
}

enum Power<'a> {
    Watts(&'a Colour),
    Lumens(f64),
}

impl<'a> Amount<'a> {
    fn watts(key: &'static str, value: &'a Option<Colour>, per_unit: f64) -> Self {
        Self { key, value: value.as_ref().map(Power::Watts), per_unit }
    }

    fn lumens(key: &'static str, value: Option<f64>, per_unit: f64) -> Self {
        Self { key, value: value.map(Power::Lumens), per_unit }
    }
}

/// The one amount that is given, in watts per channel.
fn one_of(amounts: &[Amount], colour: Option<&Colour>, efficacy: f64) -> Result<Vec<f64>, String> {
    let keys: Vec<&str> = amounts.iter().map(|amount| amount.key).collect();
    let mut given = amounts.iter().filter_map(|amount| Some((amount, amount.value.as_ref()?)));
    let (Some((amount, value)), None) = (given.next(), given.next()) else {
        return Err(format!("say how much light it sends by one of {}", keys.join(", ")));
    };
    let numbers = match value {
        Power::Watts(watts) => watts.channels(),
        Power::Lumens(lumens) => vec![*lumens],
    };
    check_power(&numbers, numbers.len()).map_err(|message| format!("{} {message}", amount.key))?;
    match value {
        Power::Watts(_) if colour.is_some() => {
            Err(format!("{} has a colour of its own: give it as [r, g, b] and leave out colour", amount.key))
        }
        Power::Watts(watts) => Ok(watts.channels().iter().map(|x| x / amount.per_unit).collect()),
        Power::Lumens(lumens) => {
            Ok(of_luminance_one(colour)?.iter().map(|x| x * lumens / efficacy / amount.per_unit).collect())
        }
    }
}

/// A colour, white if none is given, of which eyes make 1.
fn of_luminance_one(colour: Option<&Colour>) -> Result<Vec<f64>, String> {
    let colour = colour.map_or(vec![1.0; 3], Colour::channels);
    let whole = luminance(&colour);
    if !(whole > 0.0 && whole.is_finite() && colour.iter().all(|&x| x >= 0.0)) {
        return Err("colour must not be negative or black".into());
    }
    Ok(colour.iter().map(|x| x / whole).collect())
}
