//! OBJ files: their lines checked, then read by `tobj`; what their keywords mean here is in the README.

use std::collections::HashMap;
use std::io;
use std::path::Path;

use glam::DVec3;

use super::lines::Lines;
use super::{Face, FaceState, Scene, SceneError, SceneParts, mtl, settings};

/// Reads `path`, the libraries it names and the `.toml` beside it.
pub(super) fn load(path: &Path) -> Result<Scene, SceneError> {
    let read = |path: &Path| {
        let bytes = std::fs::read(path)?;
        Ok(String::from_utf8_lossy(&bytes).trim_start_matches('\u{feff}').to_owned())
    };
    let text = read(path).map_err(|e| unreadable(path, e))?;
    let beside = path.with_extension("toml");
    let settings = match read(&beside) {
        Ok(toml) => Some((beside.as_path(), toml)),
        Err(e) if e.kind() == io::ErrorKind::NotFound => None,
        Err(e) => return Err(unreadable(&beside, e)),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    parse(path, &text, settings, |library| read(&folder.join(library)))
}

fn unreadable(path: &Path, source: io::Error) -> SceneError {
    SceneError::Read { path: path.to_path_buf(), source }
}

/// Makes a scene of an OBJ text, an optional settings text with its path, and a way to read libraries.
pub(super) fn parse(
    path: &Path,
    text: &str,
    settings: Option<(&Path, String)>,
    read_library: impl Fn(&str) -> io::Result<String>,
) -> Result<Scene, SceneError> {
    let lines = Lines::check(path, text)?;
    let mut library = Library::default();
    for &(line, names) in &lines.libraries {
        library.read(path, line, names, &read_library)?;
    }
    let unknown = library.add_unknown(&lines.materials);

    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let loaded = tobj::load_obj_buf(&mut lines.reader(), &options, |_| {
        Ok((library.materials.clone(), library.places.clone().into_iter().collect()))
    });
    let (models, _) = loaded.map_err(|e| unreadable(path, io::Error::other(e)))?;

    let mut parts = SceneParts {
        name: path.file_stem().map_or("scene".into(), |s| s.to_string_lossy().into_owned()),
        ..Default::default()
    };
    parts.materials = library.materials.iter().map(|m| mtl::material(m, &mut parts.warnings)).collect();
    if !unknown.is_empty() {
        parts.warnings.push(format!("taken as grey 0.5, for no library defines it: {}", unknown.join(", ")));
    }
    for model in &models {
        append(model, &mut parts);
    }
    if let Some((path, toml)) = settings {
        settings::apply(path, &toml, &mut parts)?;
    }
    Scene::new(parts)
}

/// The materials of all libraries, and where each name is to be found.
#[derive(Default)]
struct Library {
    materials: Vec<tobj::Material>,
    places: HashMap<String, usize>,
}

impl Library {
    /// Adds the library, or the libraries, that a line of the OBJ file names.
    fn read(
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
            let plain = mtl::check(&path, &text)?;
            let loaded = tobj::load_mtl_buf(&mut plain.as_bytes());
            for material in loaded.map_err(|e| unreadable(&path, io::Error::other(e)))?.0 {
                self.add(material);
            }
        }
        Ok(())
    }

    /// Adds a material; it replaces an earlier one of the same name.
    fn add(&mut self, material: tobj::Material) {
        match self.places.get(&material.name) {
            Some(&place) => self.materials[place] = material,
            None => {
                self.places.insert(material.name.clone(), self.materials.len());
                self.materials.push(material);
            }
        }
    }

    /// Adds a grey material for every name that is not defined; answers those names.
    fn add_unknown<'a>(&mut self, names: &[&'a str]) -> Vec<&'a str> {
        let unknown: Vec<&str> =
            names.iter().copied().filter(|name| !self.places.contains_key(*name)).collect();
        for name in &unknown {
            self.add(tobj::Material {
                name: (*name).to_owned(),
                diffuse: Some(mtl::GREY),
                ..Default::default()
            });
        }
        unknown
    }
}

/// Adds a model's vertices, normals and triangles.
fn append(model: &tobj::Model, parts: &mut SceneParts) {
    let mesh = &model.mesh;
    let Some(material) = mesh.material_id.filter(|_| !mesh.indices.is_empty()) else { return };
    let object = match parts.objects.iter().position(|name| *name == model.name) {
        Some(known) => known,
        None => {
            parts.objects.push(model.name.clone());
            parts.objects.len() - 1
        }
    };
    let triples = |v: &[f64]| v.chunks_exact(3).map(DVec3::from_slice).collect::<Vec<_>>();
    let normals = triples(&mesh.normals);
    let is_direction = |n: &u32| normals[*n as usize].try_normalize().is_some();
    let (first_vertex, first_normal) = (parts.vertices.len() as u32, parts.normals.len() as u32);
    for (corners, normals) in mesh.indices.chunks_exact(3).zip(mesh.normal_indices.chunks_exact(3)) {
        let smooth = normals.iter().all(is_direction);
        parts.faces.push(Face {
            vertices: [0, 1, 2].map(|k| first_vertex + corners[k]),
            normals: smooth.then(|| [0, 1, 2].map(|k| first_normal + normals[k])),
            material: material as u32,
            object: object as u32,
            state: FaceState::Kept,
        });
    }
    parts.vertices.extend(triples(&mesh.positions));
    parts.normals.extend(normals);
}
