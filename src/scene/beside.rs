//! Beside: the files that a scene's files name, and where they are looked for.
//!
//! A scene names files as they lay where it was made: with an absolute path, with backslashes, in another
//! letter case. What is not found under its whole name is looked for by its bare name, beside the scene and
//! beside the file that names it, then in `textures/` there. Files lie in the scene's folder or below, after
//! all links are followed: a scene from elsewhere reads nothing else of the machine it is solved on, unless
//! that is allowed.

use std::cell::RefCell;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::grouped::Names;

/// Folders below in which pictures are looked for too.
const POCKETS: [&str; 1] = ["textures"];

/// The folder of a scene, and what became of the files that were looked for.
pub(super) struct Beside {
    folder: PathBuf,
    /// The same after all links.
    root: Option<PathBuf>,
    allows_outside: bool,
    /// Names of files that were found elsewhere than they should lie, and of those that lie outside.
    elsewhere: RefCell<Names>,
    outside: RefCell<Names>,
    found: RefCell<Vec<PathBuf>>,
}

impl Beside {
    /// For a scene in `folder`.
    pub fn new(folder: &Path, allows_outside: bool) -> Self {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        Self {
            folder: folder.to_path_buf(),
            root: folder.canonicalize().ok(),
            allows_outside,
            elsewhere: RefCell::default(),
            outside: RefCell::default(),
            found: RefCell::default(),
        }
    }

    /// The scene's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file that a file in the folder `from` means by `name`.
    pub fn find(&self, from: &Path, name: &str) -> Option<PathBuf> {
        let slashed = name.replace('\\', "/");
        let written = Path::new(&slashed);
        let found = self.inside(from.join(written), name).or_else(|| {
            let found = walk(from, written).and_then(|path| self.inside(path, name));
            found.inspect(|_| note(&self.elsewhere, name))
        });
        found.or_else(|| {
            let bare = Path::new(written.file_name()?);
            let beside = [self.folder.as_path(), from];
            let below =
                POCKETS.iter().flat_map(|pocket| beside.map(|folder| walk(folder, Path::new(pocket))));
            let folders = beside.map(|folder| Some(folder.to_path_buf())).into_iter().chain(below).flatten();
            let mut found = folders.filter_map(|folder| self.inside(walk(&folder, bare)?, name));
            found.next().inspect(|_| note(&self.elsewhere, name))
        })
    }

    /// The file that the settings mean, without which there is no light.
    pub fn find_light(&self, file: &Path) -> Result<PathBuf, String> {
        let name = file.to_string_lossy();
        self.find(&self.folder, &name).ok_or_else(|| {
            let is_outside = self.outside.borrow().contain(&name);
            match is_outside {
                true => format!(
                    "{name} lies outside of the scene's folder; copy it there, or give --allow-outside"
                ),
                false => format!(
                    "{} is not there; put it there or correct its name",
                    self.folder.join(file).display()
                ),
            }
        })
    }

    /// The path, if it is that of a regular file that may be read.
    fn inside(&self, path: PathBuf, name: &str) -> Option<PathBuf> {
        if !fs::metadata(&path).is_ok_and(|found| found.is_file()) {
            return None;
        }
        let is_inside = || Some(path.canonicalize().ok()?.starts_with(self.root.as_ref()?));
        if self.allows_outside || is_inside().unwrap_or(false) {
            self.found.borrow_mut().push(path.clone());
            return Some(path);
        }
        note(&self.outside, name);
        None
    }

    /// The files that were found.
    pub fn found(&self) -> Vec<PathBuf> {
        self.found.borrow().clone()
    }

    /// What is to be said of the files that were looked for.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        let elsewhere = self.elsewhere.borrow();
        let found = (!elsewhere.is_empty()).then(|| {
            format!("found by name beside the scene or in textures/, not where it says: {}", elsewhere)
        });
        let outside = self.outside.borrow();
        let refused = (!outside.is_empty()).then(|| {
            format!(
                "not read, for it lies outside of the scene's folder: {}; copy it there, or give --allow-outside",
                outside
            )
        });
        found.into_iter().chain(refused)
    }
}

fn note(names: &RefCell<Names>, name: &str) {
    names.borrow_mut().add(name);
}

/// What a relative path leads to from a folder, in whatever letter case its parts are.
fn walk(folder: &Path, path: &Path) -> Option<PathBuf> {
    let mut at = folder.to_path_buf();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => at.push(".."),
            Component::Normal(name) => {
                let exact = at.join(name);
                at = match exact.exists() {
                    true => exact,
                    false => {
                        let same = |entry: &fs::DirEntry| entry.file_name().eq_ignore_ascii_case(name);
                        let mut alike: Vec<PathBuf> = fs::read_dir(&at)
                            .ok()?
                            .flatten()
                            .filter(same)
                            .map(|entry| entry.path())
                            .collect();
                        alike.sort();
                        alike.into_iter().next()?
                    }
                };
            }
            Component::Prefix(_) | Component::RootDir => return None,
        }
    }
    Some(at)
}
