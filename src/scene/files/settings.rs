//! Settings: the optional `.toml` beside an OBJ file, for what OBJ cannot say.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;
use serde::Deserialize;
use toml::Spanned;

use super::beside::Beside;
use super::colour::Colour;
use super::light_settings::{LightSettings, SkySettings, World};
use super::list::{List, Vector};
use super::settings_line::{key_at, line_at, line_of};
use super::settings_shape;
use super::settings_words::in_words;
use crate::scene::material::Sheet;
use crate::scene::photometry::EFFICACY;
use crate::scene::spelled::spelled;
use crate::scene::{
    Camera, FARTHEST, LARGEST, Light, Material, Measure, Receiver, SceneError, SceneParts, Sky, Surface,
    is_near,
};

/// No efficacy may be less, lumens per watt: lumens up to the largest number of light stay numbers in watts.
const LEAST_EFFICACY: f64 = 1e-30;

/// The content of a scene's `.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Metres per unit of length of the OBJ file and of the camera, or the unit's name; 1 if not given.
    unit: Option<Spanned<Unit>>,
    camera: Option<Spanned<CameraSettings>>,
    /// What to change of the MTL file's materials, by name.
    #[serde(default)]
    material: BTreeMap<String, Spanned<MaterialSettings>>,
    /// Lights without area.
    #[serde(default)]
    light: Vec<Spanned<LightSettings>>,
    sky: Option<Spanned<SkySettings>>,
    /// Where to measure light beside the faces.
    #[serde(default)]
    receiver: Vec<Spanned<ReceiverSettings>>,
    /// Lumens per watt; 683 if not given.
    efficacy: Option<Spanned<f64>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraSettings {
    position: Vector,
    target: Vector,
    /// y if not given.
    up: Option<Vector>,
    #[serde(default = "normal_lens")]
    fov: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReceiverSettings {
    name: String,
    corner: Vector,
    edges: List<Vector, 2>,
    /// By the rule of EN 12464-1 if not given.
    points: Option<List<usize, 2>>,
    #[serde(default)]
    kind: MeasureSettings,
    /// Of a plane; of the receiver itself if not given.
    normal: Option<Vector>,
    /// Of a cylinder; y if not given.
    axis: Option<Vector>,
    /// In the unit of the scene.
    #[serde(default)]
    margin: f64,
    maintenance: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum MeasureSettings {
    #[default]
    Planar,
    Cylindrical,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialSettings {
    reflectance: Option<Colour>,
    /// Of the back; as of the front if not given.
    reflectance_back: Option<Colour>,
    /// What comes through, diffusely; nothing if not given.
    transmittance: Option<Colour>,
    emission: Option<Colour>,
    /// Of rough conductors and plastic, 0 to 1.
    roughness: Option<f64>,
    /// Whether glass is a sheet, and not the surface of a solid.
    #[serde(default)]
    thin: bool,
}

/// A unit of length.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "a unit is the number of metres in it, or one of m, dm, cm, mm, km, inch, ft")]
enum Unit {
    Metres(f64),
    Named(Length),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Length {
    #[serde(alias = "metre", alias = "metres", alias = "meter", alias = "meters")]
    M,
    Dm,
    Cm,
    #[serde(alias = "millimetres", alias = "millimeters")]
    Mm,
    Km,
    #[serde(alias = "in", alias = "inches")]
    Inch,
    #[serde(alias = "foot", alias = "feet")]
    Ft,
}

impl Unit {
    fn metres(&self) -> f64 {
        match self {
            Self::Metres(metres) => *metres,
            Self::Named(Length::M) => 1.0,
            Self::Named(Length::Dm) => 0.1,
            Self::Named(Length::Cm) => 0.01,
            Self::Named(Length::Mm) => 0.001,
            Self::Named(Length::Km) => 1000.0,
            Self::Named(Length::Inch) => 0.0254,
            Self::Named(Length::Ft) => 0.3048,
        }
    }
}

fn normal_lens() -> f64 {
    45.0
}

/// Changes the parts of a scene as the settings say; `path` is for messages.
pub(crate) fn apply(
    path: &Path,
    text: &str,
    beside: &Beside,
    parts: &mut SceneParts,
) -> Result<(), SceneError> {
    let file = SettingsFile { path, text };
    let settings = file.read()?;
    let unit = file.scale(settings.unit, parts)?;
    if let Some(given) = settings.camera {
        parts.camera = Some(file.camera(&given, unit)?);
    }
    for (name, given) in &settings.material {
        file.change_material(name, given, parts)?;
    }
    let efficacy = file.efficacy(settings.efficacy)?;
    parts.efficacy = Some(efficacy);
    let up = parts.camera.map_or(DVec3::Y, |camera| camera.up.normalize_or(DVec3::Y));
    let mut world = World { unit, efficacy, up, beside, warnings: &mut parts.warnings };
    for given in &settings.light {
        let light = given.get_ref().light(&mut world);
        parts.lights.push(light.map_err(|message| file.error(given, format!("light: {message}")))?);
    }
    for given in &settings.receiver {
        let receiver = file.receiver(given, unit)?;
        if parts.receivers.iter().any(|known| known.name == receiver.name) {
            let message = format!("receiver {}: another has this name; give each its own", receiver.name);
            return Err(file.error(given, message));
        }
        parts.receivers.push(receiver);
    }
    if let Some(given) = &settings.sky {
        let sky = given.get_ref().sky(&mut world);
        let sky = sky.map_err(|message| file.error(given, format!("sky: {message}")))?;
        parts.warnings.extend(suns_below(&sky, &parts.lights));
        parts.sky = Some(sky);
    }
    Ok(())
}

/// Names suns that stand below the horizon of a sky.
fn suns_below(sky: &Sky, lights: &[Light]) -> Vec<String> {
    let is_below = |light: &Light| match light {
        Light::Sun { direction, .. } => direction.dot(sky.up) > 0.0,
        _ => false,
    };
    let below = (1..).zip(lights).filter(|(_, light)| is_below(light));
    let warning = |(number, _)| {
        format!(
            "sun {number} shines from below the horizon of the sky; its direction is the way its light travels"
        )
    };
    below.map(warning).collect()
}

/// A file of settings, which knows where in it something is wrong.
struct SettingsFile<'a> {
    path: &'a Path,
    text: &'a str,
}

impl SettingsFile<'_> {
    fn read(&self) -> Result<Settings, SceneError> {
        settings_shape::check(self.text).map_err(|(start, message)| {
            let line = line_at(self.text, start);
            let message = match message.as_str() {
                "duplicate key" => in_words(&message, key_at(self.text, line)) + "; keep one",
                _ => message,
            };
            self.error_on(line, message)
        })?;
        toml::from_str(self.text).map_err(|e| {
            let line = self.line_of(e.span().map_or(0, |span| span.start), e.message());
            self.error_on(line, in_words(e.message(), key_at(self.text, line)))
        })
    }

    /// The line of which a message speaks about the settings that start at this byte.
    fn line_of(&self, start: usize, message: &str) -> usize {
        let refusal = |text: &str| toml::from_str::<Settings>(text).err().map(|e| e.message().to_owned());
        line_of(self.text, start, message, refusal)
    }

    fn error_on(&self, line: usize, message: String) -> SceneError {
        SceneError::Parse { path: self.path.to_path_buf(), line, message }
    }

    fn error<T>(&self, given: &Spanned<T>, message: String) -> SceneError {
        self.error_on(self.line_of(given.span().start, &message), message)
    }

    /// Makes vertices metres; answers the unit, in metres.
    fn scale(&self, given: Option<Spanned<Unit>>, parts: &mut SceneParts) -> Result<f64, SceneError> {
        let unit = given.as_ref().map_or(1.0, |unit| unit.get_ref().metres());
        parts.vertices.iter_mut().for_each(|vertex| *vertex *= unit);
        let Some(given) = given else { return Ok(unit) };
        let wrong = |message: String| self.error(&given, format!("unit = {}: {message}", spelled(unit)));
        if !(unit.is_finite() && unit > 0.0) {
            return Err(wrong("metres per unit must be positive".into()));
        }
        if parts.vertices.iter().any(|vertex| !is_near(*vertex)) {
            return Err(wrong(format!("it makes coordinates of more than {FARTHEST:e} m")));
        }
        Ok(unit)
    }

    fn camera(&self, given: &Spanned<CameraSettings>, unit: f64) -> Result<Camera, SceneError> {
        let CameraSettings { position, target, up, fov } = *given.get_ref();
        let [position, target] = [position, target].map(|point| DVec3::from(point.0) * unit);
        let up = up.map_or(DVec3::Y, |up| up.0.into());
        let camera = Camera { position, target, up, fov };
        if camera.is_valid() { Ok(camera) } else { Err(self.error(given, SceneError::Camera.to_string())) }
    }

    fn change_material(
        &self,
        name: &str,
        given: &Spanned<MaterialSettings>,
        parts: &mut SceneParts,
    ) -> Result<(), SceneError> {
        let wrong = |message: String| self.error(given, format!("material {name}: {message}"));
        let Some(material) = parts.materials.iter_mut().find(|m| m.name == name) else {
            let known: Vec<&str> = parts.materials.iter().take(20).map(|m| m.name.as_str()).collect();
            return Err(wrong(format!(
                "no face or library has it; remove it or correct its name; there are {}",
                known.join(", ")
            )));
        };
        given.get_ref().change(material).map_err(|message| wrong(message.into()))?;
        make_sheet(material, given.get_ref(), &mut parts.warnings);
        material.check().map_err(wrong)
    }

    /// Lumens per watt.
    fn efficacy(&self, given: Option<Spanned<f64>>) -> Result<f64, SceneError> {
        let Some(given) = given else { return Ok(EFFICACY) };
        let efficacy = *given.get_ref();
        if (LEAST_EFFICACY..=LARGEST).contains(&efficacy) {
            return Ok(efficacy);
        }
        let message = format!(
            "efficacy = {}: lumens per watt must be positive, from {LEAST_EFFICACY:e} to {LARGEST:e}",
            spelled(efficacy)
        );
        Err(self.error(&given, message))
    }

    fn receiver(&self, given: &Spanned<ReceiverSettings>, unit: f64) -> Result<Receiver, SceneError> {
        let ReceiverSettings { name, corner, edges, points, .. } = given.get_ref();
        let [corner, a, b] = [*corner, edges.0[0], edges.0[1]].map(|p| DVec3::from(p.0) * unit);
        let counts = points.map_or_else(|| Receiver::usual_counts([a, b]), |points| points.0);
        let wrong = |message: &str| self.error(given, format!("receiver {name}: {message}"));
        let ReceiverSettings { kind, normal, axis, margin, maintenance, .. } = *given.get_ref();
        let unit_vector = |v: Vector| DVec3::from(v.0).normalize_or_zero();
        let measure = match (kind, normal, axis) {
            (MeasureSettings::Planar, None, None) => Measure::Plane,
            (MeasureSettings::Planar, Some(normal), None) => Measure::Normal(unit_vector(normal)),
            (MeasureSettings::Cylindrical, None, axis) => {
                Measure::Cylinder(axis.map_or(DVec3::Y, unit_vector))
            }
            (MeasureSettings::Planar, ..) => return Err(wrong("only a cylindrical one has an axis")),
            (MeasureSettings::Cylindrical, ..) => return Err(wrong("a cylindrical one has no normal")),
        };
        let receiver = Receiver {
            measure,
            margin: margin * unit,
            maintenance: maintenance.unwrap_or(1.0),
            ..Receiver::grid(name, corner, [a, b], counts)
        };
        let checked = receiver.check();
        checked.map_err(|message| self.error(given, format!("receiver {name}: {message}")))?;
        Ok(receiver)
    }
}

impl MaterialSettings {
    /// Changes what of a material is given, but for its back and what it lets through.
    fn change(&self, material: &mut Material) -> Result<(), &'static str> {
        if let Some(reflectance) = &self.reflectance {
            match &mut material.surface {
                Surface::Mirror { reflectance: mirrored } => *mirrored = reflectance.channels(),
                Surface::Conductor { reflectance: reflected, .. } => *reflected = reflectance.channels(),
                _ => material.reflectance = reflectance.channels(),
            }
        }
        if self.thin {
            let Surface::Dielectric { index, filter } = &material.surface else {
                return Err(
                    "only glass is thin; make it glass by `illum 4` in the MTL file, or remove `thin`",
                );
            };
            // Light crosses both of its surfaces.
            let filter = filter.iter().map(|part| part * part).collect();
            material.surface = Surface::Pane { index: *index, filter };
        }
        if let Some(given) = self.roughness {
            let (Surface::Conductor { roughness, .. } | Surface::Plastic { roughness, .. }) =
                &mut material.surface
            else {
                return Err(
                    "only metals and plastic have a roughness; make it metal by `Pm 1` or plastic by `Pr` in the MTL file, \
                     or remove it",
                );
            };
            *roughness = given;
        }
        if let Some(emission) = &self.emission {
            material.emission = emission.channels();
        }
        Ok(())
    }
}

/// Gives a material a back and a transmittance of its own, where the settings do.
fn make_sheet(material: &mut Material, settings: &MaterialSettings, warnings: &mut Vec<String>) {
    let MaterialSettings { reflectance_back, transmittance, .. } = settings;
    if reflectance_back.is_none() && transmittance.is_none() {
        return;
    }
    if matches!(material.surface, Surface::Plastic { .. }) {
        warnings.push(format!(
            "material {}: sheets are matt; its gloss (Pr, Pm or illum 5) is left out",
            material.name
        ));
        material.surface = Surface::Diffuse;
    }
    let given = |colour: &Option<Colour>| colour.as_ref().map(Colour::channels);
    material.sheet = Some(Sheet {
        reflectance_back: given(reflectance_back).unwrap_or_else(|| material.reflectance.clone()),
        transmittance: given(transmittance).unwrap_or_else(|| vec![0.0; material.reflectance.len()]),
    });
}
