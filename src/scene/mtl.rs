//! MTL files: every line checked once, read by `tobj`; what their keywords mean here is in the README.

use std::path::Path;

use super::lines::{numbers, split};
use super::{Material, SceneError, Surface};

/// Reflectance of a material that is not defined, or without Kd.
pub(super) const GREY: [f64; 3] = [0.5; 3];

/// Checks a library and puts it in the form that `tobj` reads: colours of three numbers, no line before a name.
pub(super) fn check(path: &Path, text: &str) -> Result<String, SceneError> {
    let mut plain = String::with_capacity(text.len());
    for (number, line) in (1..).zip(text.lines()) {
        let (key, rest) = split(line);
        if plain.is_empty() && key != "newmtl" {
            continue;
        }
        let rest = value(key, rest).map_err(|message| SceneError::Parse {
            path: path.to_path_buf(),
            line: number,
            message,
        })?;
        plain.extend([key, " ", &rest, "\n"]);
    }
    Ok(plain)
}

/// What follows a key, spelled out.
fn value(key: &str, rest: &str) -> Result<String, String> {
    match key {
        "Ka" | "Kd" | "Ks" | "Ke" => match numbers(rest).as_deref() {
            Some(&[grey]) => Ok(format!("{grey:e} {grey:e} {grey:e}")),
            Some([r, g, b]) => Ok(format!("{r:e} {g:e} {b:e}")),
            _ => Err(format!("{key} must be followed by one or three numbers")),
        },
        "Ns" | "Ni" | "d" => match numbers(rest).as_deref() {
            Some([number, ..]) => Ok(format!("{number:e}")),
            _ => Err(format!("{key} must be followed by a number")),
        },
        "illum" => match rest.split_whitespace().next().and_then(|word| word.parse::<u8>().ok()) {
            Some(model) => Ok(model.to_string()),
            None => Err("illum must be followed by the number of a model, 0 to 10".into()),
        },
        "newmtl" if rest.is_empty() => Err("newmtl without a name".into()),
        "bump" if rest.is_empty() => Err("bump must be followed by the name of a file".into()),
        map if map.starts_with("map_") && rest.is_empty() => {
            Err(format!("{map} must be followed by the name of a file"))
        }
        _ => Ok(rest.to_owned()),
    }
}

/// What an entry means.
pub(super) fn material(m: &tobj::Material, warnings: &mut Vec<String>) -> Material {
    let has = |key: &str| m.unknown_param.contains_key(key);
    let surface = match m.illumination_model {
        Some(3) => Surface::Mirror,
        Some(4 | 6 | 7 | 9) => Surface::Dielectric,
        Some(5) => Surface::Glossy,
        _ if has("Pr") || has("Pm") => Surface::Glossy,
        _ => Surface::Diffuse,
    };
    if m.diffuse.is_none() && surface == Surface::Diffuse {
        warnings.push(format!("material {} has no Kd: taken as grey 0.5", m.name));
    }
    let kd = m.diffuse.unwrap_or(if surface == Surface::Diffuse { GREY } else { [0.0; 3] });
    Material {
        name: m.name.clone(),
        reflectance: kd.to_vec(),
        emission: m.emissive.unwrap_or([0.0; 3]).to_vec(),
        surface,
        textured: m.diffuse_texture.is_some() || has("map_Ke"),
    }
}
