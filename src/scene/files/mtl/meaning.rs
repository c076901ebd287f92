//! Meaning: what an entry of a material library says about a surface, as exporters write entries.
//!
//! Some write the same whatever a surface is. Blender marks every material that is metallic at all as a
//! mirror (`illum 3`), with its metallic part as `Ka`, and gives the roughness of its default, `Pr 0.5` and
//! `Pm 0`, to every plain wall. Mirrors and coats are taken only from entries that mean one.

use std::path::Path;

use super::GREY;
use crate::scene::files::picture_file::PictureFiles;
use crate::scene::files::text::numbers;
use crate::scene::grouped::Grouped;
use crate::scene::material::{Texture, Textures};
use crate::scene::{Material, Surface};

/// Roughness of a metal or plastic without Pr and Ns, and index of refraction of glass or plastic without Ni.
const ROUGHNESS: f64 = 0.3;
const GLASS: f64 = 1.5;

/// From this metallic part on a surface is a metal.
const METALLIC: f64 = 0.5;

/// From this roughness on a surface without metal is diffuse, where an exporter states both of every
/// material.
const MATT: f64 = 0.5;

/// What an entry means.
pub(super) fn material(
    m: &tobj::Material,
    folder: &Path,
    pictures: &mut PictureFiles,
    said: &mut Grouped,
) -> Material {
    // A picture alone is taken as it is.
    let alone = |key: &str| if m.unknown_param.contains_key(key) { [1.0; 3] } else { [0.0; 3] };
    let mut emission = m.emissive.unwrap_or(alone("map_Ke"));
    let surface = surface(m, emission.iter().any(|&e| e > 0.0), said);
    let mut picture = |key: &str, statement: Option<&String>, factor: [f64; 3]| {
        let statement = statement.filter(|_| !surface.is_carrier())?;
        if factor == [0.0; 3] {
            let by = &key[4..];
            said.say(
                &m.name,
                format!("{key} is multiplied by {by}, which is 0: raise it, or remove it to take the picture as it is"),
            );
        }
        pictures.texture(&format!("{}, {key}", m.name), statement, folder)
    };
    let reflected: Option<Texture> =
        picture("map_Kd", m.diffuse_texture.as_ref(), m.diffuse.unwrap_or([1.0; 3]));
    let emitted = picture("map_Ke", m.unknown_param.get("map_Ke"), emission);
    if emitted.is_none() && m.emissive.is_none() {
        emission = [0.0; 3];
    }
    let kd = match m.diffuse {
        Some(kd) if surface.is_carrier() && kd != [0.0; 3] => {
            if !matches!(surface, Surface::Conductor { .. }) {
                said.say(&m.name, "a mirror or glass (illum): its Kd is ignored");
            }
            [0.0; 3]
        }
        Some(kd) => kd,
        None if surface.is_carrier() => [0.0; 3],
        None if reflected.is_some() => [1.0; 3],
        None => {
            said.say(&m.name, "no Kd: taken as grey 0.5");
            GREY
        }
    };
    Material {
        name: m.name.clone(),
        reflectance: kd.to_vec(),
        emission: emission.to_vec(),
        surface,
        sheet: None,
        textures: Textures { reflectance: reflected, emission: emitted },
    }
}

/// How the surface passes light on.
fn surface(m: &tobj::Material, emits: bool, said: &mut Grouped) -> Surface {
    let has_kd = m.diffuse.is_some_and(|kd| kd != [0.0; 3]) || m.diffuse_texture.is_some();
    let [roughness, metallic] = ["Pr", "Pm"].map(|key| parameter(m, key));
    let metallic = metallic.or(metallic_of_exporter(m));
    let is_metal = metallic.is_some_and(|metallic| metallic >= METALLIC);
    let is_plain = || match (roughness, parameter(m, "Pm")) {
        (Some(roughness), Some(_)) => roughness >= MATT,
        (None, None) => metallic.is_none() || roughness_of_exporter(m) >= MATT,
        _ => false,
    };
    match m.illumination_model {
        Some(3..=7 | 9) if emits => lamp(m, said),
        _ if emits && (is_metal || !is_plain()) => lamp(m, said),
        Some(3) if !has_kd || metallic.is_none() => mirror(m, said),
        Some(4 | 6 | 7 | 9) => dielectric(m, said),
        _ if is_metal => metal(m, m.diffuse, said),
        Some(5) if !has_kd => metal(m, m.specular, said),
        Some(5) => plastic(m),
        _ if is_plain() => Surface::Diffuse,
        _ => plastic(m),
    }
}

/// The metallic part that Blender writes as Ka of a material that it calls a mirror: one grey, which is not
/// the colour.
fn metallic_of_exporter(m: &tobj::Material) -> Option<f64> {
    let [r, g, b] = m.ambient.filter(|_| m.illumination_model == Some(3))?;
    let is_part = r == g && g == b && r > 0.0 && r <= 1.0 && m.diffuse != Some([r, g, b]);
    is_part.then_some(r)
}

/// The roughness that Blender writes as Ns: 1000 (1 − roughness)².
fn roughness_of_exporter(m: &tobj::Material) -> f64 {
    1.0 - (m.shininess.unwrap_or(250.0) / 1000.0).clamp(0.0, 1.0).sqrt()
}

/// A number that `tobj` does not know.
fn parameter(m: &tobj::Material, key: &str) -> Option<f64> {
    m.unknown_param.get(key).and_then(|rest| numbers(rest)).and_then(|numbers| numbers.first().copied())
}

/// What emits is diffuse.
fn lamp(m: &tobj::Material, said: &mut Grouped) -> Surface {
    said.say(
        &m.name,
        "it emits (Ke): taken as a diffuse lamp, not as a mirror, metal, glass or plastic; give the glass around a lamp a material of its own",
    );
    Surface::Diffuse
}

/// A rough conductor of this reflectance, Ks or Kd.
fn metal(m: &tobj::Material, reflectance: Option<[f64; 3]>, said: &mut Grouped) -> Surface {
    if reflectance.is_none() {
        said.say(&m.name, "a metal without colour (Ks, or Kd with Pm): taken to reflect everything");
    }
    if parameter(m, "Pm").is_some_and(|metal| (METALLIC..1.0).contains(&metal)) {
        said.say(&m.name, "metal in part (Pm): taken as metal; Pm below 0.5 makes it plastic");
    }
    let roughness = roughness(m);
    if roughness.is_none() {
        said.say(&m.name, format!("a metal without roughness (Pr or Ns): its Pr is taken as {ROUGHNESS}"));
    }
    Surface::Conductor {
        reflectance: reflectance.unwrap_or([1.0; 3]).to_vec(),
        roughness: roughness.unwrap_or(ROUGHNESS),
    }
}

/// Pr, or what Ns says: to Blender, or else what makes a highlight about as wide, α² = 2/(Ns + 2) (Walter et
/// al. 2007, sec. 5.2).
fn roughness(m: &tobj::Material) -> Option<f64> {
    let of_exporter = metallic_of_exporter(m).map(|_| roughness_of_exporter(m));
    let of_exponent = |ns: f64| (2.0 / (ns.max(0.0) + 2.0)).powf(0.25);
    parameter(m, "Pr").or(of_exporter).or(m.shininess.map(of_exponent))
}

/// A coat of varnish over Kd.
fn plastic(m: &tobj::Material) -> Surface {
    Surface::Plastic {
        index: m.optical_density.unwrap_or(GLASS),
        roughness: roughness(m).unwrap_or(ROUGHNESS),
    }
}

fn mirror(m: &tobj::Material, said: &mut Grouped) -> Surface {
    if m.specular.is_none() {
        said.say(&m.name, "a mirror without Ks: taken to reflect everything");
    }
    Surface::Mirror { reflectance: m.specular.unwrap_or([1.0; 3]).to_vec() }
}

fn dielectric(m: &tobj::Material, said: &mut Grouped) -> Surface {
    if m.optical_density.is_none() {
        said.say(&m.name, format!("glass without Ni: its index of refraction is taken as {GLASS}"));
    }
    let filter = m.unknown_param.get("Tf").and_then(|rest| numbers(rest));
    Surface::Dielectric {
        index: m.optical_density.unwrap_or(GLASS),
        filter: filter.unwrap_or_else(|| vec![1.0; 3]),
    }
}
