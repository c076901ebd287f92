//! Beside: the files that a scene's files name, and where they are looked for.
//!
//! A scene names files as they lay where it was made: with an absolute path, with backslashes, in another
//! letter case. What is not found under its whole name is looked for by its bare name, beside the scene and
//! beside the file that names it, then in `textures/` there. Files lie in the scene's folder or below, after
//! all links are followed: a scene from elsewhere reads nothing else of the machine it is solved on, unless
//! that is allowed.

use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::scene::grouped::Names;

/// The folder below in which pictures are looked for too.
const POCKET: &str = "textures";

/// The folder of a scene, and what became of the files that were looked for.
pub(crate) struct Beside {
    folder: PathBuf,
    /// The same after all links.
    root: Option<PathBuf>,
    allows_outside: bool,
    looked: RefCell<Looked>,
}

/// What became of the files that were looked for.
#[derive(Default)]
struct Looked {
    /// Names of files that were found elsewhere than they should lie, and of those that lie outside.
    elsewhere: Names,
    outside: Names,
    found: BTreeSet<PathBuf>,
    /// The answers, by the folder from which and the name by which was looked.
    answers: HashMap<(PathBuf, String), Option<PathBuf>>,
    /// What lies in folders, by names in small letters.
    listings: HashMap<PathBuf, HashMap<OsString, OsString>>,
}

/// Why a path is no answer.
enum Refused {
    /// There is no regular file.
    Absent,
    /// It lies outside.
    Outside,
}

impl Beside {
    /// For a scene in `folder`.
    pub fn new(folder: &Path, allows_outside: bool) -> Self {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let root = folder.canonicalize().ok();
        Self { folder: folder.to_path_buf(), root, allows_outside, looked: RefCell::default() }
    }

    /// The scene's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file that a file in the folder `from` means by `name`.
    pub fn find(&self, from: &Path, name: &str) -> Option<PathBuf> {
        let key = (from.to_path_buf(), name.to_owned());
        if let Some(known) = self.looked.borrow().answers.get(&key) {
            return known.clone();
        }
        let answer = self.looked_for(from, name);
        let mut looked = self.looked.borrow_mut();
        looked.found.extend(answer.clone());
        looked.answers.insert(key, answer.clone());
        answer
    }

    fn looked_for(&self, from: &Path, name: &str) -> Option<PathBuf> {
        let slashed = name.replace('\\', "/");
        let written = Path::new(&slashed);
        let mut is_outside = false;
        let mut take = |path: Option<PathBuf>| match self.allowed(path?) {
            Ok(path) => Some(path),
            Err(refused) => {
                is_outside |= matches!(refused, Refused::Outside);
                None
            }
        };
        if let Some(path) = take(Some(from.join(written))) {
            return Some(path);
        }
        let beside = [self.folder.as_path(), from];
        let pockets = beside.map(|folder| self.walk(folder, Path::new(POCKET)));
        let folders = beside.map(|folder| Some(folder.to_path_buf())).into_iter().chain(pockets).flatten();
        let bare = written.file_name().map(Path::new);
        let by_name = folders.map(|folder| self.walk(&folder, bare?));
        let elsewhere = std::iter::once_with(|| self.walk(from, written)).chain(by_name).find_map(take);
        let mut looked = self.looked.borrow_mut();
        match &elsewhere {
            Some(_) => looked.elsewhere.add(name),
            None if is_outside => looked.outside.add(name),
            None => {}
        }
        elsewhere
    }

    /// The file that the settings mean, without which there is no light.
    pub fn find_light(&self, file: &Path) -> Result<PathBuf, String> {
        let name = file.to_string_lossy();
        self.find(&self.folder, &name).ok_or_else(|| match self.looked.borrow().outside.contain(&name) {
            true => {
                format!("{name} lies outside of the scene's folder; copy it there, or give --allow-outside")
            }
            false => {
                format!("{} is not there; put it there or correct its name", self.folder.join(file).display())
            }
        })
    }

    /// Whether a file may be read, wherever links lead.
    pub fn allows(&self, path: &Path) -> bool {
        let is_inside = || Some(path.canonicalize().ok()?.starts_with(self.root.as_ref()?));
        self.allows_outside || is_inside().unwrap_or(false)
    }

    /// The path, if it is that of a regular file that may be read.
    fn allowed(&self, path: PathBuf) -> Result<PathBuf, Refused> {
        match fs::metadata(&path).is_ok_and(|found| found.is_file()) {
            false => Err(Refused::Absent),
            true if self.allows(&path) => Ok(path),
            true => Err(Refused::Outside),
        }
    }

    /// What a relative path leads to from a folder, in whatever letter case its parts are.
    fn walk(&self, folder: &Path, path: &Path) -> Option<PathBuf> {
        let mut at = folder.to_path_buf();
        for part in path.components() {
            match part {
                Component::CurDir => {}
                Component::ParentDir => at.push(".."),
                Component::Normal(name) => at = self.entry(&at, name)?,
                Component::Prefix(_) | Component::RootDir => return None,
            }
        }
        Some(at)
    }

    /// What lies in a folder under a name, in whatever letter case.
    fn entry(&self, folder: &Path, name: &OsStr) -> Option<PathBuf> {
        let exact = folder.join(name);
        if exact.exists() {
            return Some(exact);
        }
        let mut looked = self.looked.borrow_mut();
        let listing = looked.listings.entry(folder.to_path_buf()).or_insert_with(|| {
            let names = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.file_name());
            let mut names: Vec<OsString> = names.collect();
            // Of names that differ in letter case alone the first counts, wherever it stands in the folder.
            names.sort_unstable_by(|a, b| b.cmp(a));
            names.into_iter().map(|name| (name.to_ascii_lowercase(), name)).collect()
        });
        listing.get(&name.to_ascii_lowercase()).map(|name| folder.join(name))
    }

    /// The files that were found.
    pub fn found(&self) -> Vec<PathBuf> {
        self.looked.borrow().found.iter().cloned().collect()
    }

    /// What is to be said of the files that were looked for.
    pub fn warnings(&self) -> Vec<String> {
        let Looked { elsewhere, outside, .. } = &*self.looked.borrow();
        let found = (!elsewhere.is_empty()).then(|| {
            format!("found by name beside the scene or in textures/, not where it says: {elsewhere}")
        });
        let refused = (!outside.is_empty()).then(|| {
            format!(
                "not read, for it lies outside of the scene's folder: {outside}; copy it there, or give --allow-outside"
            )
        });
        found.into_iter().chain(refused).collect()
    }
}
