//! OBJ and MTL files, read by `tobj`; what their keywords mean here is in the README.

use std::io;
use std::path::Path;

use glam::DVec3;

use super::{Face, FaceState, Material, Scene, SceneError, SceneParts, Surface, settings::Settings};

/// What a face without a usable material looks like.
const GREY: [f64; 3] = [0.5; 3];

/// Reads `path`, the libraries it names and the `.toml` beside it.
pub(super) fn load(path: &Path) -> Result<Scene, SceneError> {
    let read = |path: &Path| {
        let bytes = std::fs::read(path)?;
        Ok(String::from_utf8_lossy(&bytes).trim_start_matches('\u{feff}').to_owned())
    };
    let unreadable = |path: &Path, source| SceneError::Read { path: path.to_path_buf(), source };
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

/// Makes a scene of an OBJ text, an optional settings text with its path, and a way to read libraries.
pub(super) fn parse(
    path: &Path,
    text: &str,
    settings: Option<(&Path, String)>,
    read_library: impl Fn(&str) -> io::Result<String>,
) -> Result<Scene, SceneError> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let libraries = load_libraries(path, text, read_library)?;
    let loaded = tobj::load_obj_buf(&mut text.as_bytes(), &options, |library| {
        let text = library.to_str().and_then(|name| libraries.iter().find(|l| l.0 == name));
        tobj::load_mtl_buf(&mut text.map_or("", |l| l.1.as_str()).as_bytes())
    });
    let (models, library) = loaded.map_err(|e| explain(path, text, &e.to_string()))?;
    if models.iter().any(|m| m.mesh.positions.iter().any(|x| !x.is_finite())) {
        return Err(explain(path, text, "a vertex is not finite"));
    }
    let mut parts = SceneParts {
        name: path.file_stem().map_or("scene".into(), |s| s.to_string_lossy().into_owned()),
        ..Default::default()
    };
    let library = library.map_err(|e| explain(path, text, &e.to_string()))?;
    parts.materials = library.iter().map(|m| material(m, &mut parts.warnings)).collect();
    warn_of_unknown_materials(text, &mut parts);
    for model in &models {
        append(model, &mut parts);
    }
    if let Some((path, toml)) = settings {
        Settings::parse(path, &toml)?.apply(&mut parts)?;
    }
    Scene::new(parts)
}

/// Reads every library that the OBJ names; `(name, text)` each, in a form `tobj` can digest.
fn load_libraries(
    path: &Path,
    text: &str,
    read: impl Fn(&str) -> io::Result<String>,
) -> Result<Vec<(String, String)>, SceneError> {
    let mut libraries = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.split_whitespace().next() != Some("mtllib") {
            continue;
        }
        let library = line.split_once(' ').unwrap_or_default().1.trim();
        let mtl = read(library).map_err(|source| SceneError::MissingLibrary {
            path: path.to_path_buf(),
            line: index + 1,
            library: library.to_owned(),
            source,
        })?;
        let mtl_path = path.with_file_name(library);
        libraries.push((library.to_owned(), spell_out_colours(&mtl_path, &mtl)?));
    }
    Ok(libraries)
}

/// Writes colours given by one number as three, and refuses those that are not numbers.
fn spell_out_colours(path: &Path, mtl: &str) -> Result<String, SceneError> {
    let mut out = String::with_capacity(mtl.len());
    for (index, line) in mtl.lines().enumerate() {
        let error = |message| SceneError::Parse { path: path.to_path_buf(), line: index + 1, message };
        let mut words = line.split_whitespace();
        match words.next() {
            Some(key @ ("Ka" | "Kd" | "Ks" | "Ke")) => {
                let numbers: Result<Vec<f64>, _> = words.map(str::parse).collect();
                let [r, g, b] = match numbers.as_deref() {
                    Ok([grey]) => [*grey; 3],
                    Ok([r, g, b]) => [*r, *g, *b],
                    _ => return Err(error(format!("{key} must be followed by one or three numbers"))),
                };
                out.push_str(&format!("{key} {r} {g} {b}\n"));
            }
            Some(key @ ("Ns" | "Ni" | "d" | "illum")) => {
                let value = words.next().and_then(|word| word.parse::<f64>().ok());
                let value = value.ok_or_else(|| error(format!("{key} must be followed by a number")))?;
                out.push_str(&format!("{key} {value}\n"));
            }
            Some("newmtl") if words.next().is_none() => return Err(error("newmtl without a name".into())),
            _ => {
                out.push_str(line);
                out.push('\n');
            }
        }
    }
    Ok(out)
}

/// What an MTL entry means.
fn material(m: &tobj::Material, warnings: &mut Vec<String>) -> Material {
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

/// Names, in one warning, the materials that faces ask for and no library defines.
fn warn_of_unknown_materials(text: &str, parts: &mut SceneParts) {
    let mut unknown: Vec<&str> = Vec::new();
    for line in text.lines().filter(|l| l.starts_with("usemtl")) {
        let name = line.split_once(' ').unwrap_or_default().1.trim();
        if !unknown.contains(&name) && !parts.materials.iter().any(|m| m.name == name) {
            unknown.push(name);
        }
    }
    if !unknown.is_empty() {
        parts.warnings.push(format!("taken as grey 0.5, for no library defines it: {}", unknown.join(", ")));
    }
}

/// Adds a model's vertices, normals and triangles.
fn append(model: &tobj::Model, parts: &mut SceneParts) {
    let mesh = &model.mesh;
    let triples = |v: &[f64]| v.chunks_exact(3).map(DVec3::from_slice).collect::<Vec<_>>();
    let corners = |indices: &[u32], base: usize| [0, 1, 2].map(|k| indices[k] + base as u32);
    if mesh.indices.is_empty() {
        return;
    }
    let object = match parts.objects.iter().position(|name| *name == model.name) {
        Some(known) => known,
        None => {
            parts.objects.push(model.name.clone());
            parts.objects.len() - 1
        }
    };
    let material = mesh.material_id.unwrap_or_else(|| grey_material(parts));
    let (first_vertex, first_normal) = (parts.vertices.len(), parts.normals.len());
    parts.vertices.extend(triples(&mesh.positions));
    parts.normals.extend(triples(&mesh.normals));
    let has_normals = mesh.normal_indices.len() == mesh.indices.len();
    for (k, indices) in mesh.indices.chunks_exact(3).enumerate() {
        let normals = has_normals.then(|| corners(&mesh.normal_indices[3 * k..3 * k + 3], first_normal));
        parts.faces.push(Face {
            vertices: corners(indices, first_vertex),
            normals,
            material: material as u32,
            object: object as u32,
            state: FaceState::Kept,
        });
    }
}

/// The material of faces that name none, made when first needed.
fn grey_material(parts: &mut SceneParts) -> usize {
    const NAME: &str = "default";
    if let Some(known) = parts.materials.iter().position(|m| m.name == NAME) {
        return known;
    }
    if parts.warnings.iter().all(|w| !w.contains("grey 0.5")) {
        parts.warnings.push("some faces have no material: taken as grey 0.5".into());
    }
    parts.materials.push(Material::diffuse(NAME, &GREY));
    parts.materials.len() - 1
}

/// Finds the line of an OBJ text that is to blame for `what`, which `tobj` or we found wrong with it.
fn explain(path: &Path, text: &str, what: &str) -> SceneError {
    let total = |key| text.lines().filter(|l| l.split_whitespace().next() == Some(key)).count();
    let totals = [total("v"), total("vt"), total("vn")];
    let mut so_far = [0usize; 3];
    for (index, line) in text.lines().enumerate() {
        let error = |message| SceneError::Parse { path: path.to_path_buf(), line: index + 1, message };
        let mut words = line.split_whitespace();
        let key = words.next().unwrap_or_default();
        match key {
            "v" | "vt" | "vn" => {
                let (slot, needed) = match key {
                    "v" => (0, 3),
                    "vt" => (1, 2),
                    _ => (2, 3),
                };
                so_far[slot] += 1;
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                if numbers.len() < needed || numbers.iter().take(needed).any(|x| !x.is_finite()) {
                    return error(format!("`{key}` must be followed by {needed} finite numbers"));
                }
            }
            "f" | "l" => {
                for corner in words {
                    if let Some(message) = bad_corner(corner, totals, so_far) {
                        return error(message);
                    }
                }
            }
            "usemtl" if words.next().is_none() => return error("usemtl without a name".into()),
            _ => {}
        }
    }
    SceneError::Parse { path: path.to_path_buf(), line: text.lines().count(), message: what.to_owned() }
}

/// What is wrong with a corner such as `3/1/2` or `-1//-1`, if anything.
fn bad_corner(corner: &str, totals: [usize; 3], so_far: [usize; 3]) -> Option<String> {
    let kinds = ["vertex", "texture coordinate", "normal"];
    for (kind, word) in corner.split('/').enumerate().take(3) {
        if word.is_empty() && kind > 0 {
            continue;
        }
        let Ok(index) = word.parse::<i64>() else {
            return Some(format!("`{corner}` is not a face corner; write vertex/texture/normal numbers"));
        };
        let resolved = if index < 0 { so_far[kind] as i64 + index + 1 } else { index };
        if resolved < 1 || resolved > totals[kind] as i64 {
            return Some(format!("{} {index} does not exist; there are {}", kinds[kind], totals[kind]));
        }
    }
    None
}
