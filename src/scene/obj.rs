//! OBJ files: their lines checked, then read by `tobj`; what their keywords mean here is in the README.

use std::io;
use std::path::Path;

use glam::{DVec2, DVec3};

use super::lines::Lines;
use super::mtl::Library;
use super::{Face, FaceState, Scene, SceneError, SceneParts, settings};

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
        Ok((library.materials().to_vec(), library.places().collect()))
    });
    let (models, _) = loaded.map_err(|e| unreadable(path, io::Error::other(e)))?;

    let mut parts = SceneParts {
        name: path.file_stem().map_or("scene".into(), |s| s.to_string_lossy().into_owned()),
        ..Default::default()
    };
    parts.materials = library.read_materials(&mut parts.warnings)?;
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

/// Adds a model's vertices, normals, texture coordinates and triangles.
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
    let coordinates: Vec<DVec2> = mesh.texcoords.chunks_exact(2).map(DVec2::from_slice).collect();
    let of_corners = mesh.texcoord_indices.chunks_exact(3).map(|corners| {
        let corners = [0, 1, 2].map(|k| coordinates[corners[k] as usize]);
        corners.iter().all(|corner| corner.is_finite()).then_some(corners)
    });
    parts.texture_coordinates.extend(of_corners);
    parts.vertices.extend(triples(&mesh.positions));
    parts.normals.extend(normals);
}
