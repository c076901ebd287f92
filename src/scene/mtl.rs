//! Material libraries: MTL files, every line checked once, read by `tobj`; what their keywords mean here is
//! in the README.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use super::lines::{numbers, split};
use super::picture_file::PictureFiles;
use super::{Material, SceneError, Surface, Textures};

/// Reflectance of a material that is not defined, or without Kd.
const GREY: [f64; 3] = [0.5; 3];

/// Roughness of a metal or plastic without Pr and Ns, and index of refraction of glass or plastic without Ni.
const ROUGHNESS: f64 = 0.3;
const GLASS: f64 = 1.5;

/// The materials of all libraries, and where each name is to be found.
#[derive(Default)]
pub(super) struct Library {
    materials: Vec<tobj::Material>,
    /// Per material: where its library lies.
    folders: Vec<PathBuf>,
    places: HashMap<String, usize>,
}

impl Library {
    /// All entries.
    pub fn materials(&self) -> &[tobj::Material] {
        &self.materials
    }

    /// Every name, with its place among the materials.
    pub fn places(&self) -> impl Iterator<Item = (String, usize)> {
        self.places.iter().map(|(name, &place)| (name.clone(), place))
    }

    /// Adds the library, or the libraries, that a line of the OBJ file names.
    pub fn read(
        &mut self,
        path: &Path,
        line: usize,
        names: &str,
        read: impl Fn(&str) -> io::Result<String>,
    ) -> Result<(), SceneError> {
        // A name may hold spaces; only if there is no such file they separate names.
        let whole = read(names);
        let several = whole.as_ref().is_err_and(|e| e.kind() == io::ErrorKind::NotFound);
        let texts: Vec<(&str, io::Result<String>)> = if several && names.contains(char::is_whitespace) {
            names.split_whitespace().map(|name| (name, read(name))).collect()
        } else {
            vec![(names, whole)]
        };
        for (name, text) in texts {
            let text = text.map_err(|source| SceneError::MissingLibrary {
                path: path.to_path_buf(),
                line,
                library: name.to_owned(),
                source,
            })?;
            let path = path.with_file_name(name);
            let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
            let plain = plain(&path, &text)?;
            let loaded = tobj::load_mtl_buf(&mut plain.as_bytes());
            let loaded = loaded.map_err(|e| SceneError::Read { path, source: io::Error::other(e) })?;
            loaded.0.into_iter().for_each(|material| self.add(material, &folder));
        }
        Ok(())
    }

    /// Adds a material; it replaces an earlier one of the same name.
    fn add(&mut self, material: tobj::Material, folder: &Path) {
        match self.places.get(&material.name) {
            Some(&place) => (self.materials[place], self.folders[place]) = (material, folder.to_path_buf()),
            None => {
                self.places.insert(material.name.clone(), self.materials.len());
                self.materials.push(material);
                self.folders.push(folder.to_path_buf());
            }
        }
    }

    /// What all entries mean, their pictures read.
    pub fn read_materials(&self, warnings: &mut Vec<String>) -> Result<Vec<Material>, SceneError> {
        let mut pictures = PictureFiles::default();
        let entries = self.materials.iter().zip(&self.folders);
        entries.map(|(entry, folder)| material(entry, folder, &mut pictures, warnings)).collect()
    }

    /// Adds a grey material for every name that is not defined; answers those names.
    pub fn add_unknown<'a>(&mut self, names: &[&'a str]) -> Vec<&'a str> {
        let unknown: Vec<&str> =
            names.iter().copied().filter(|name| !self.places.contains_key(*name)).collect();
        for name in &unknown {
            let grey = tobj::Material { name: (*name).to_owned(), diffuse: Some(GREY), ..Default::default() };
            self.add(grey, Path::new(""));
        }
        unknown
    }
}

/// Checks a library and puts it in the form that `tobj` reads: colours of three numbers, no line before a
/// name.
fn plain(path: &Path, text: &str) -> Result<String, SceneError> {
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
        "Ka" | "Kd" | "Ks" | "Ke" | "Tf" => match numbers(rest).as_deref() {
            Some(&[grey]) => Ok(format!("{grey:e} {grey:e} {grey:e}")),
            Some([r, g, b]) => Ok(format!("{r:e} {g:e} {b:e}")),
            _ => Err(format!("{key} must be followed by one or three numbers")),
        },
        "Ns" if numbers(rest).is_some_and(|ns| ns.first().is_some_and(|&ns| ns < 0.0)) => {
            Err("Ns must not be negative".into())
        }
        "Ns" | "Ni" | "d" => match numbers(rest).as_deref() {
            Some([number, ..]) => Ok(format!("{number:e}")),
            _ => Err(format!("{key} must be followed by a number")),
        },
        "Pr" | "Pm" => match numbers(rest).as_deref() {
            Some([number, ..]) if (0.0..=1.0).contains(number) => Ok(format!("{number:e}")),
            _ => Err(format!("{key} must be followed by a number from 0 to 1")),
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
fn material(
    m: &tobj::Material,
    folder: &Path,
    pictures: &mut PictureFiles,
    warnings: &mut Vec<String>,
) -> Result<Material, SceneError> {
    let has = |key: &str| m.unknown_param.contains_key(key);
    let is_metal = parameter(m, "Pm").is_some_and(|metal| metal >= 0.5);
    let is_coloured = m.diffuse.is_some_and(|kd| kd != [0.0; 3]);
    // A picture alone is taken as it is.
    let unsaid = |key: &str| if has(key) { [1.0; 3] } else { [0.0; 3] };
    let emission = m.emissive.unwrap_or(unsaid("map_Ke"));
    let emits = emission.iter().any(|&e| e > 0.0);
    let surface = match m.illumination_model {
        Some(3 | 4 | 5 | 6 | 7 | 9) if emits => lamp(m, warnings),
        Some(3) => mirror(m, warnings),
        Some(4 | 6 | 7 | 9) => dielectric(m, warnings),
        _ if is_metal && emits => lamp(m, warnings),
        _ if is_metal => metal(m, m.diffuse, warnings),
        Some(5) if !is_coloured => metal(m, m.specular, warnings),
        Some(5) => plastic(m),
        _ if (has("Pr") || has("Pm")) && emits => lamp(m, warnings),
        _ if has("Pr") || has("Pm") => plastic(m),
        _ => Surface::Diffuse,
    };
    let has_picture = m.diffuse_texture.is_some();
    if m.diffuse.is_none() && !surface.is_carrier() && !has_picture {
        warnings.push(format!("material {} has no Kd: taken as grey 0.5", m.name));
    }
    let unsaid = match surface {
        _ if has_picture => [1.0; 3],
        Surface::Diffuse | Surface::Plastic { .. } => GREY,
        _ => [0.0; 3],
    };
    let mut kd = m.diffuse.unwrap_or(unsaid);
    let mut textures = Textures::default();
    if !surface.is_carrier() {
        let mut picture = |key: &str, statement: Option<&String>, factor: [f64; 3]| {
            let Some(statement) = statement else { return Ok(None) };
            if factor == [0.0; 3] {
                warnings.push(format!(
                    "material {}: {key} is multiplied by {}, which is 0: raise it, or remove it to take the picture as it is",
                    m.name,
                    &key[4..]
                ));
            }
            pictures.texture((&m.name, key), statement, folder, warnings).map(Some)
        };
        textures.reflectance = picture("map_Kd", m.diffuse_texture.as_ref(), kd)?;
        textures.emission = picture("map_Ke", m.unknown_param.get("map_Ke"), emission)?;
    }
    if surface.is_carrier() && kd != [0.0; 3] {
        if !is_metal {
            warnings.push(format!("material {} is a mirror or glass (illum): its Kd is ignored", m.name));
        }
        kd = [0.0; 3];
    }
    Ok(Material {
        name: m.name.clone(),
        reflectance: kd.to_vec(),
        emission: emission.to_vec(),
        surface,
        sheet: None,
        textures,
    })
}

/// A number that `tobj` does not know.
fn parameter(m: &tobj::Material, key: &str) -> Option<f64> {
    m.unknown_param.get(key).and_then(|rest| numbers(rest)).and_then(|numbers| numbers.first().copied())
}

/// What emits is diffuse.
fn lamp(m: &tobj::Material, warnings: &mut Vec<String>) -> Surface {
    warnings.push(format!(
        "material {} emits (Ke): taken as a diffuse lamp, not as a mirror, metal, glass or plastic; give the glass around a lamp a material of \
         its own",
        m.name
    ));
    Surface::Diffuse
}

/// A rough conductor of this reflectance, Ks or Kd.
fn metal(m: &tobj::Material, reflectance: Option<[f64; 3]>, warnings: &mut Vec<String>) -> Surface {
    if reflectance.is_none() {
        warnings.push(format!(
            "material {} is a metal without colour (Ks, or Kd with Pm): taken to reflect everything",
            m.name
        ));
    }
    if parameter(m, "Pm").is_some_and(|metal| (0.5..1.0).contains(&metal)) {
        warnings.push(format!(
            "material {} is metal in part (Pm): taken as metal; Pm below 0.5 makes it plastic",
            m.name
        ));
    }
    let roughness = roughness(m);
    if roughness.is_none() {
        warnings.push(format!(
            "material {} is a metal without roughness (Pr or Ns): its Pr is taken as {ROUGHNESS}",
            m.name
        ));
    }
    Surface::Conductor {
        reflectance: reflectance.unwrap_or([1.0; 3]).to_vec(),
        roughness: roughness.unwrap_or(ROUGHNESS),
    }
}

/// Pr, or what makes a highlight about as wide as that of Ns: α² = 2/(Ns + 2) (Walter et al. 2007, sec. 5.2).
fn roughness(m: &tobj::Material) -> Option<f64> {
    let of_exponent = |ns: f64| (2.0 / (ns.max(0.0) + 2.0)).powf(0.25);
    parameter(m, "Pr").or(m.shininess.map(of_exponent))
}

/// A coat of varnish over Kd.
fn plastic(m: &tobj::Material) -> Surface {
    Surface::Plastic {
        index: m.optical_density.unwrap_or(GLASS),
        roughness: roughness(m).unwrap_or(ROUGHNESS),
    }
}

fn mirror(m: &tobj::Material, warnings: &mut Vec<String>) -> Surface {
    if m.specular.is_none() {
        warnings.push(format!("material {} is a mirror without Ks: taken to reflect everything", m.name));
    }
    Surface::Mirror { reflectance: m.specular.unwrap_or([1.0; 3]).to_vec() }
}

fn dielectric(m: &tobj::Material, warnings: &mut Vec<String>) -> Surface {
    if m.optical_density.is_none() {
        warnings.push(format!(
            "material {} is glass without Ni: its index of refraction is taken as {GLASS}",
            m.name
        ));
    }
    let filter = m.unknown_param.get("Tf").and_then(|rest| numbers(rest));
    Surface::Dielectric {
        index: m.optical_density.unwrap_or(GLASS),
        filter: filter.unwrap_or_else(|| vec![1.0; 3]),
    }
}
