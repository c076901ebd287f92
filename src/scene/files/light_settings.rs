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
use super::list::{List, Vector};
use super::picture_file;
use super::text::decode;
use crate::scene::light::{
    Environment, GeneralSky, IntensityTable, SPHERE, Sky, SkyKind, check_power, spot_solid_angle,
};
use crate::scene::photometry::luminance;
use crate::scene::spelled::{listed, spelled};
use crate::scene::{FARTHEST, LARGEST, Light, Pixels, is_near};

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(crate) enum LightSettings {
    Point {
        position: Vector,
        intensity: Option<Colour>,
        luminous_intensity: Option<f64>,
        flux: Option<Colour>,
        luminous_flux: Option<f64>,
        #[serde(alias = "color")]
        colour: Option<Colour>,
    },
    Spot {
        position: Vector,
        target: Option<Vector>,
        direction: Option<Vector>,
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
        position: Vector,
        target: Option<Vector>,
        direction: Option<Vector>,
        up: Option<Vector>,
        scale: Option<f64>,
        luminous_flux: Option<f64>,
        #[serde(alias = "color")]
        colour: Option<Colour>,
    },
    Sun {
        direction: Vector,
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
        up: Vector,
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
        up: Vector,
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
        up: Vector,
        sun: Option<Vector>,
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
        up: Vector,
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
        up: Vector,
        sun: Vector,
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
                Light::Point { position: place(position, unit)?, intensity }
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
                let direction = aim(position, target.as_ref(), direction.as_ref())?;
                let sent = spot_solid_angle(*cone, *penumbra);
                let amounts = by_intensity([intensity, flux], [*luminous_intensity, *luminous_flux], sent);
                Light::Spot {
                    position: place(position, unit)?,
                    direction,
                    intensity: one_of(&amounts, colour.as_ref(), efficacy)?,
                    cone: *cone,
                    penumbra: *penumbra,
                }
            }
            Self::Ies { file, position, target, direction, up: c0, scale, luminous_flux, colour } => {
                let direction = aim(position, target.as_ref(), direction.as_ref())?;
                let table = intensity_table(file, world)?;
                for (key, amount) in [("scale", scale), ("luminous_flux", luminous_flux)] {
                    check_amount(key, *amount)?;
                }
                let from_down = direction.dot(-world.up).clamp(-1.0, 1.0).acos().to_degrees();
                let factor = match (scale, luminous_flux) {
                    (Some(_), Some(_)) => return Err("give scale or luminous_flux, one of the two".into()),
                    (None, Some(lumens)) if table.flux() > 0.0 => lumens / table.flux(),
                    (None, Some(_)) => return Err("luminous_flux: every intensity in the file is 0".into()),
                    (scale, None) => scale.unwrap_or(1.0) * table.tilt_factor(from_down),
                };
                let colour = of_luminance_one(colour.as_ref())?;
                let c0 = c0.as_ref().map_or(Ok(default_c0(direction)), |up| unit_vector("up", up))?;
                let intensity: Vec<f64> =
                    colour.iter().map(|x| x * factor * table.highest() / efficacy).collect();
                let given = if luminous_flux.is_some() { "luminous_flux" } else { "scale" };
                check_made(given, &intensity)?;
                let c0 = (c0 - direction * c0.dot(direction)).normalize_or_zero();
                if c0 == DVec3::ZERO {
                    return Err(
                        "up is the direction of the light, or its opposite; give one across it".into()
                    );
                }
                Light::Ies {
                    position: place(position, unit)?,
                    direction,
                    c0,
                    intensity,
                    table: Arc::new(table),
                }
            }
            Self::Sun { direction, diameter, irradiance, illuminance, colour } => {
                let amounts = [
                    Amount::watts("irradiance", irradiance, 1.0),
                    Amount::lumens("illuminance", *illuminance, 1.0),
                ];
                Light::Sun {
                    direction: unit_vector("direction", direction)?,
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

/// A place, in metres.
fn place(position: &Vector, unit: f64) -> Result<DVec3, String> {
    let place = DVec3::from(position.0) * unit;
    let wrong =
        || format!("position {} must be finite, no coordinate beyond {FARTHEST:e} m", listed(position.0));
    is_near(place).then_some(place).ok_or_else(wrong)
}

/// The direction that a key gives.
fn unit_vector(key: &str, given: &Vector) -> Result<DVec3, String> {
    let vector = DVec3::from(given.0);
    let plain = vector.normalize_or_zero();
    // Of very long and very short ones the square of the length is no number.
    let scaled = || (vector / vector.abs().max_element()).normalize_or_zero();
    let unit = if plain == DVec3::ZERO { scaled() } else { plain };
    let wrong =
        || format!("{key} {} is no direction; give three finite numbers that are not all 0", listed(given.0));
    (unit != DVec3::ZERO).then_some(unit).ok_or_else(wrong)
}

/// A unit vector from a target or a direction.
fn aim(position: &Vector, target: Option<&Vector>, direction: Option<&Vector>) -> Result<DVec3, String> {
    match (target, direction) {
        (Some(target), None) => {
            let towards = (DVec3::from(target.0) - DVec3::from(position.0)).normalize_or_zero();
            let wrong = || {
                let [position, target] = [position, target].map(|point| listed(point.0));
                format!("target {target} is no way from position {position}; move one of them")
            };
            (towards != DVec3::ZERO).then_some(towards).ok_or_else(wrong)
        }
        (None, Some(direction)) => unit_vector("direction", direction),
        _ => Err("aim it by target or by direction, one of the two".into()),
    }
}

fn y_up() -> Vector {
    List([0.0, 1.0, 0.0])
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
                let up = unit_vector("up", up)?;
                // Over ground it is the even one of the general skies.
                let even = || GeneralSky::new(EVEN, up).map_or(SkyKind::Constant, SkyKind::General);
                let kind = if ground.is_some() { even() } else { SkyKind::Constant };
                let sky = Sky { kind, up, zenith: vec![0.0; 3], ground: ground.unwrap_or(0.0) };
                (sky, [radiance, irradiance], [luminance, illuminance], colour)
            }
            Self::Cie { r#type, up, sun, ground, radiance, luminance, irradiance, illuminance, colour } => {
                let up = unit_vector("up", up)?;
                let kind = general_sky(*r#type, up, sun.as_ref())?;
                let sky = Sky { kind, up, zenith: vec![0.0; 3], ground: *ground };
                (sky, [radiance, irradiance], [luminance, illuminance], colour)
            }
            Self::Overcast { up, ground, radiance, luminance, irradiance, illuminance, colour } => {
                let up = unit_vector("up", up)?;
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
                let up = unit_vector("up", up)?;
                let pixels = environment_picture(file, world)?;
                if !turn.is_finite() {
                    return Err(format!("turn {turn} must be a finite number of degrees"));
                }
                return environment(Environment::new(pixels, up, *turn), up, &amounts);
            }
            Self::Clear { up, sun, ground, radiance, luminance, irradiance, illuminance, colour } => {
                let up = unit_vector("up", up)?;
                let kind = SkyKind::Clear { sun: unit_vector("sun", sun)? };
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
fn general_sky(number: usize, up: DVec3, sun: Option<&Vector>) -> Result<SkyKind, String> {
    let most = GeneralSky::TYPES;
    if number == most + 1 {
        return Ok(SkyKind::Overcast);
    }
    let towards = sun.map_or(Ok(up), |sun| unit_vector("sun", sun))?;
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
        check_amount(key, Some(number))?;
        sky.zenith = vec![number / unit; 3];
        check_made(key, &sky.zenith)?;
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
    let made: Vec<f64> = match value {
        Power::Watts(_) if colour.is_some() => {
            return Err(format!(
                "{} has a colour of its own: give it as [r, g, b] and leave out colour",
                amount.key
            ));
        }
        Power::Watts(watts) => watts.channels().iter().map(|x| x / amount.per_unit).collect(),
        Power::Lumens(lumens) => {
            of_luminance_one(colour)?.iter().map(|x| x * lumens / efficacy / amount.per_unit).collect()
        }
    };
    check_made(amount.key, &made)?;
    Ok(made)
}

/// What is wrong with a number that a key gives, if it gives one.
fn check_amount(key: &str, amount: Option<f64>) -> Result<(), String> {
    let numbers = amount.as_slice();
    check_power(numbers, numbers.len()).map_err(|message| format!("{key} {message}"))
}

/// What is wrong with what a sound number comes to, per channel.
fn check_made(key: &str, made: &[f64]) -> Result<(), String> {
    match made.iter().find(|x| !(0.0..=LARGEST).contains(*x)) {
        Some(x) => Err(format!(
            "{key} comes to {} in watts, by solid angle, colour and efficacy, and that must be at most {LARGEST:e}",
            spelled(*x)
        )),
        None => Ok(()),
    }
}

/// A colour, white if none is given, of which eyes make 1.
fn of_luminance_one(colour: Option<&Colour>) -> Result<Vec<f64>, String> {
    let colour = colour.map_or(vec![1.0; 3], Colour::channels);
    let whole = luminance(&colour);
    if !(whole > 0.0 && whole.is_finite() && colour.iter().all(|&x| x >= 0.0)) {
        return Err("colour must be finite, not negative and not black".into());
    }
    Ok(colour.iter().map(|x| x / whole).collect())
}
