//! Material libraries: MTL files, every line checked once, read by `tobj`; what their keywords mean here is
//! in the README.

mod lines;
mod meaning;

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use super::beside::Beside;
use super::picture_file::PictureFiles;
use super::text::{decode, named};
use crate::scene::grouped::{Grouped, Names};
use crate::scene::{Material, SceneError};

/// The name of what has none.
pub(crate) const NONE: &str = "(none)";

/// Reflectance of a material that is not defined, or without Kd.
const GREY: [f64; 3] = [0.5; 3];

/// The materials of all libraries, and where each name is to be found.
#[derive(Default)]
pub(crate) struct Library {
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

    /// Adds the libraries that an OBJ file's lines name, or where none of them is there the one that has the
    /// scene's name.
    pub fn read(
        &mut self,
        statements: &[String],
        scene: &str,
        beside: &Beside,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneError> {
        let mut missing = Vec::new();
        let mut paths: Vec<PathBuf> = Vec::new();
        for statement in statements {
            paths.extend(named_by(statement, beside, &mut missing));
        }
        if !missing.is_empty() {
            let otherwise = match paths.is_empty() {
                true => beside.find(beside.folder(), &format!("{scene}.mtl")),
                false => None,
            };
            let taken =
                otherwise.as_ref().map_or(String::new(), |path| format!("; {} is read", path.display()));
            warnings.push(format!(
                "{} not there: {}{taken}",
                if missing.len() == 1 { "a material library is" } else { "material libraries are" },
                missing.iter().map(String::as_str).collect::<Names>()
            ));
            paths.extend(otherwise);
        }
        for path in paths {
            let bytes =
                std::fs::read(&path).map_err(|source| SceneError::Read { path: path.clone(), source })?;
            self.read_text(&path, &decode(&bytes), warnings)?;
        }
        Ok(())
    }

    /// Adds the materials of a library's text; `path` is for messages.
    pub fn read_text(
        &mut self,
        path: &Path,
        text: &str,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneError> {
        let (plain, left_out) = lines::plain(path, text)?;
        warnings.extend(left_out);
        let folder = path.parent().unwrap_or(Path::new(""));
        let loaded = tobj::load_mtl_buf(&mut plain.as_bytes());
        let unreadable = |e| SceneError::Read { path: path.to_path_buf(), source: io::Error::other(e) };
        loaded.map_err(unreadable)?.0.into_iter().for_each(|material| self.add(material, folder));
        self.take_off_comments();
        Ok(())
    }

    /// Names end before a comment, where that leaves each its own.
    fn take_off_comments(&mut self) {
        let mut times: HashMap<String, usize> = HashMap::new();
        for material in &self.materials {
            *times.entry(named(&material.name).to_owned()).or_default() += 1;
        }
        for place in 0..self.materials.len() {
            let long = self.materials[place].name.clone();
            let short = named(&long);
            if short != long && !short.is_empty() && times[short] == 1 {
                self.places.remove(&long);
                self.places.insert(short.to_owned(), place);
                short.clone_into(&mut self.materials[place].name);
            }
        }
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
    pub fn read_materials(&self, beside: &Beside, warnings: &mut Vec<String>) -> Vec<Material> {
        let (mut pictures, mut said) = (PictureFiles::new(beside), Grouped::default());
        let entries = self.materials.iter().zip(&self.folders);
        let materials = entries
            .map(|(entry, folder)| meaning::material(entry, folder, &mut pictures, &mut said))
            .collect();
        warnings.extend(said.sentences("material").chain(pictures.said().sentences("picture")));
        materials
    }

    /// Sees to it that every name that faces use is defined: it means the material that has it but for a
    /// comment, or else a grey one that is added. Answers the names of these.
    pub fn add_unknown<'a>(&mut self, names: &'a [String]) -> Vec<&'a str> {
        let mut unknown = Vec::new();
        for name in names.iter().filter(|name| !self.places.contains_key(*name)).collect::<Vec<_>>() {
            match self.places.get(named(name)) {
                Some(&place) => {
                    self.places.insert(name.clone(), place);
                }
                None => {
                    let grey =
                        tobj::Material { name: name.clone(), diffuse: Some(GREY), ..Default::default() };
                    self.add(grey, Path::new(""));
                    unknown.push(name.as_str());
                }
            }
        }
        unknown
    }
}

/// The libraries that a line names: one, perhaps in quotes or with a comment behind it, whose name may hold
/// spaces, or several with spaces between them.
fn named_by(statement: &str, beside: &Beside, missing: &mut Vec<String>) -> Vec<PathBuf> {
    let find = |name: &str| beside.find(beside.folder(), name);
    let plain = |name: &str| name.trim_matches('"').trim().to_owned();
    let whole = plain(named(statement));
    if whole.is_empty() {
        return Vec::new();
    }
    if let Some(path) = find(&plain(statement)).or_else(|| find(&whole)) {
        return vec![path];
    }
    let names: Vec<String> = match statement.contains('"') {
        true => statement.split('"').map(plain).filter(|name| !name.is_empty()).collect(),
        false => named(statement).split_whitespace().map(str::to_owned).collect(),
    };
    let found: Vec<Option<PathBuf>> = names.iter().map(|name| find(name)).collect();
    if found.iter().all(Option::is_none) {
        missing.push(whole);
        return Vec::new();
    }
    missing.extend(names.into_iter().zip(&found).filter(|(_, path)| path.is_none()).map(|(name, _)| name));
    found.into_iter().flatten().collect()
}
