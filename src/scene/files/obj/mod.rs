//! OBJ files: their lines checked, then read by `tobj`; what their keywords mean here is in the README.

mod colours;
mod lines;
mod noticed;
mod polygon;

use std::collections::HashMap;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::beside::Beside;
use super::mtl::Library;
use super::settings;
use super::text::decode;
use crate::scene::{Face, FaceState, Loading, Scene, SceneError, SceneParts};
use lines::Lines;

/// Reads `path`, the libraries it names and the `.toml` beside it.
pub(crate) fn load(path: &Path, options: Loading) -> Result<Scene, SceneError> {
    let text = read_text(path).map_err(|e| unreadable(path, e))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let beside = Beside::new(folder, options.allow_outside);
    let toml = settings_path(path);
    if toml.exists() && !beside.allows(&toml) {
        let outside = "it lies outside of the scene's folder; copy it there, or give --allow-outside";
        return Err(unreadable(&toml, io::Error::other(outside)));
    }
    let settings = match read_text(&toml) {
        Ok(text) => Some((toml.as_path(), text)),
        Err(e) if e.kind() == io::ErrorKind::NotFound && !toml.is_symlink() => None,
        Err(e) => return Err(unreadable(&toml, e)),
    };
    let other = settings.is_none().then(|| settings_of_another_name(path, folder)).flatten();
    parse((path, &text), settings, &beside, |library, named, warnings| {
        warnings.extend(other);
        library.read(named, &name(path), &beside, warnings)
    })
}

/// Where the settings of a scene are, if it has some.
fn settings_path(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(".toml");
    path.with_file_name(name)
}

/// What is to be said of settings beside a scene that has none, if no other scene there has them.
fn settings_of_another_name(path: &Path, folder: &Path) -> Option<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let is_settings = |path: &PathBuf| {
        let of_program = ["Cargo.toml", "pyproject.toml", "clippy.toml", "rustfmt.toml"];
        path.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"))
            && !path.file_name().is_some_and(|name| of_program.iter().any(|known| name == *known))
            && !path.with_extension("obj").exists()
    };
    let mut found = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).filter(is_settings);
    let other = found.next()?;
    Some(format!(
        "{} is not read: the settings of this scene are those of {}",
        other.display(),
        settings_path(path).display()
    ))
}

/// Reads an OBJ text from a stream.
pub(crate) fn read(mut stream: impl Read, folder: &Path, options: Loading) -> Result<Scene, SceneError> {
    let path = Path::new("stdin");
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).map_err(|e| unreadable(path, e))?;
    let beside = Beside::new(folder, options.allow_outside);
    parse((path, &decode(&bytes)), None, &beside, |library, named, warnings| {
        library.read(named, &name(path), &beside, warnings)
    })
}

/// The text of a regular file: others may have no end.
fn read_text(path: &Path) -> io::Result<String> {
    let kind = match std::fs::metadata(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound && path.is_symlink() => {
            return Err(io::Error::new(e.kind(), "it is a link that leads nowhere"));
        }
        known => known?.file_type(),
    };
    if !kind.is_file() {
        return Err(io::Error::other(
            "it is not a regular file; give `-` to read a scene from standard input",
        ));
    }
    Ok(decode(&std::fs::read(path)?))
}

fn unreadable(path: &Path, source: io::Error) -> SceneError {
    SceneError::Read { path: path.to_path_buf(), source }
}

/// Makes a scene of an OBJ text with its path, an optional settings text with its own, and a way to read
/// the libraries that lines name.
pub(crate) fn parse(
    (path, text): (&Path, &str),
    settings: Option<(&Path, String)>,
    beside: &Beside,
    read_libraries: impl FnOnce(&mut Library, &[String], &mut Vec<String>) -> Result<(), SceneError>,
) -> Result<Scene, SceneError> {
    let lines = Lines::check(path, text)?;
    let mut parts = SceneParts { name: name(path), ..Default::default() };
    parts.warnings.extend(lines.noticed.warnings());
    let mut library = Library::default();
    read_libraries(&mut library, &lines.libraries, &mut parts.warnings)?;
    let unknown = library.add_unknown(&lines.materials);

    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let loaded = tobj::load_obj_buf(&mut lines.reader(), &options, |_| {
        Ok((library.materials().to_vec(), library.places().collect()))
    });
    let (models, _) = loaded.map_err(|e| unreadable(path, io::Error::other(e)))?;

    parts.materials = library.read_materials(beside, &mut parts.warnings);
    let mut objects = HashMap::new();
    for model in &models {
        append(model, &mut objects, &mut parts);
    }
    colours::paint(&lines, &unknown, &mut parts);
    parts.polygons = lines.polygons;
    parts.inputs.push(path.to_path_buf());
    let has_unit = settings.as_ref().is_some_and(|(_, toml)| toml.contains("unit"));
    parts.warnings.extend(hint_of_unit(path, &parts.vertices).filter(|_| !has_unit));
    if let Some((path, toml)) = settings {
        settings::apply(path, &toml, beside, &mut parts)?;
        parts.inputs.push(path.to_path_buf());
    }
    parts.inputs.extend(beside.found());
    parts.warnings.extend(beside.warnings());
    Scene::new(parts)
}

/// What is to be said of a scene that is larger than a street.
fn hint_of_unit(path: &Path, vertices: &[DVec3]) -> Option<String> {
    const LONG: f64 = 500.0;
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = vertices.iter().fold(none, |(low, high), &p| (low.min(p), high.max(p)));
    let longest = (high - low).max_element();
    (longest > LONG).then(|| {
        format!(
            "the scene is {longest:.0} m long; if it was not made in metres, say so in {}: unit = \"mm\", or cm, inch, ft",
            settings_path(path).display()
        )
    })
}

/// The name of a scene: that of its file, but for names that are folders.
fn name(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    stem.filter(|stem| stem.contains(|letter| letter != '.')).unwrap_or_else(|| "scene".into())
}

/// Adds a model's vertices, normals, texture coordinates and triangles.
fn append<'m>(model: &'m tobj::Model, objects: &mut HashMap<&'m str, usize>, parts: &mut SceneParts) {
    let mesh = &model.mesh;
    let Some(material) = mesh.material_id.filter(|_| !mesh.indices.is_empty()) else { return };
    let object = *objects.entry(&model.name).or_insert_with(|| {
        parts.objects.push(model.name.clone());
        parts.objects.len() - 1
    });
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
