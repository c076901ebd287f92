//! Settings: the optional `.toml` beside an OBJ file, for what OBJ cannot say.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;
use serde::Deserialize;

use super::{Camera, SceneError, SceneParts};

/// The content of a scene's `.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    /// Metres per unit of length of the OBJ file and of the camera.
    #[serde(default = "metre")]
    unit: f64,
    camera: Option<CameraSettings>,
    /// What to change of the MTL file's materials, by name.
    #[serde(default)]
    material: BTreeMap<String, MaterialSettings>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraSettings {
    position: [f64; 3],
    target: [f64; 3],
    #[serde(default = "y_up")]
    up: [f64; 3],
    #[serde(default = "normal_lens")]
    fov: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialSettings {
    reflectance: Option<Colour>,
    emission: Option<Colour>,
}

/// One number for every channel, or one each.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "a colour is one number, or three in brackets")]
enum Colour {
    Grey(f64),
    Rgb([f64; 3]),
}

impl Colour {
    fn channels(&self) -> Vec<f64> {
        match self {
            Colour::Grey(value) => vec![*value; 3],
            Colour::Rgb(values) => values.to_vec(),
        }
    }
}

fn metre() -> f64 {
    1.0
}

fn y_up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

fn normal_lens() -> f64 {
    45.0
}

impl Settings {
    pub(super) fn parse(path: &Path, text: &str) -> Result<Self, SceneError> {
        let settings: Self = toml::from_str(text).map_err(|e| {
            let before = e.span().map_or("", |span| &text[..span.start.min(text.len())]);
            SceneError::Parse {
                path: path.to_path_buf(),
                line: before.matches('\n').count() + 1,
                message: e.message().to_owned(),
            }
        })?;
        if !(settings.unit.is_finite() && settings.unit > 0.0) {
            let message = format!("unit = {}: metres per unit must be positive", settings.unit);
            let line = 1 + text.lines().position(|line| line.trim_start().starts_with("unit")).unwrap_or(0);
            return Err(SceneError::Parse { path: path.to_path_buf(), line, message });
        }
        Ok(settings)
    }

    /// Changes the parts of a scene as the settings say.
    pub(super) fn apply(self, parts: &mut SceneParts) -> Result<(), SceneError> {
        for vertex in &mut parts.vertices {
            *vertex *= self.unit;
        }
        parts.camera = self.camera.map(|c| Camera {
            position: DVec3::from(c.position) * self.unit,
            target: DVec3::from(c.target) * self.unit,
            up: DVec3::from(c.up),
            fov: c.fov,
        });
        for (name, change) in self.material {
            let Some(material) = parts.materials.iter_mut().find(|m| m.name == name) else {
                let message = "the .toml file changes it, but no face or library has it".into();
                return Err(SceneError::Material { material: name, message });
            };
            if let Some(reflectance) = change.reflectance {
                material.reflectance = reflectance.channels();
            }
            if let Some(emission) = change.emission {
                material.emission = emission.channels();
            }
        }
        Ok(())
    }
}
