//! Files: results are replaced whole and together, or left as they were.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::OutputError;

/// Files of one folder that are about to be replaced.
///
/// They are written under temporary names in the same folder and take their own names together, with
/// [`Outputs::commit`]. Without it nothing changes and nothing stays behind. No folder is made, no other file
/// touched; but for temporary ones of runs that were killed, which are removed.
#[derive(Debug)]
pub struct Outputs {
    folder: PathBuf,
    files: Vec<(OsString, NamedTempFile)>,
    /// What must not be overwritten.
    spared: Vec<PathBuf>,
}

impl Outputs {
    /// None yet, in this folder.
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into(), files: Vec::new(), spared: Vec::new() }
    }

    /// Refuses to overwrite these files, which the run has read.
    pub fn sparing(self, inputs: &[PathBuf]) -> Self {
        Self { spared: inputs.to_vec(), ..self }
    }

    /// Adds a file of this name with what `write` writes.
    ///
    /// # Errors
    /// `Write`.
    pub fn file(
        &mut self,
        name: impl Into<OsString>,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let name = name.into();
        let path = self.folder.join(&name);
        spare(&path, &self.spared)?;
        if self.files.is_empty() {
            remove_left_over(&self.folder, &self.spared);
        }
        let written = || {
            // A folder of that name would stop the commit halfway.
            if path.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            let file = temporary_in(&self.folder)?;
            fill(file.as_file(), write)?;
            Ok(file)
        };
        let file = written().map_err(|source| OutputError::Write { path: path.clone(), source })?;
        self.files.push((name, file));
        Ok(())
    }

    /// Gives all files their names, in the order in which they were added; answers those names.
    ///
    /// # Errors
    /// `Write`.
    pub fn commit(self) -> Result<Vec<String>, OutputError> {
        let Self { folder, files, .. } = self;
        let rename = |(name, file): (OsString, NamedTempFile)| {
            let path = folder.join(&name);
            file.persist(&path).map_err(|failed| OutputError::Write { path, source: failed.error })?;
            Ok(name.to_string_lossy().into_owned())
        };
        files.into_iter().map(rename).collect()
    }
}

/// Writes what `write` writes to `path`, which changes only once everything is written; see [`Outputs`].
///
/// A path that is no ordinary file, such as `/dev/stdout`, is written to directly.
///
/// # Errors
/// `Write`; an old file of that name is then still there.
pub fn replace(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let path = path.as_ref();
    if path.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        let done = File::create(path).and_then(|file| fill(file, write));
        return done.map_err(|source| OutputError::Write { path: path.to_owned(), source });
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut outputs = Outputs::in_folder(folder);
    outputs.file(path.file_name().unwrap_or_default(), write)?;
    outputs.commit()?;
    Ok(())
}

/// Refuses a folder that cannot be made, or in which no file can be made; it is left as it is.
///
/// # Errors
/// `Folder`.
pub fn check_folder(folder: &Path) -> Result<(), OutputError> {
    let or_here = |folder: &'_ Path| match folder.as_os_str().is_empty() {
        true => PathBuf::from("."),
        false => folder.to_owned(),
    };
    let mut above = folder.ancestors().map(or_here);
    let nearest = above.find(|folder| folder.symlink_metadata().is_ok()).unwrap_or_else(|| or_here(folder));
    let tried = match nearest.is_dir() {
        true => temporary_in(&nearest).map(drop),
        false => Err(io::ErrorKind::NotADirectory.into()),
    };
    tried.map_err(|source| OutputError::Folder { path: or_here(folder), source })
}

/// Refuses a path at which no file can be written; nothing is left there. Its folder may be yet to be made.
///
/// # Errors
/// `Write` or `Folder`.
pub fn check_file(path: &Path) -> Result<(), OutputError> {
    match path.metadata() {
        Ok(known) if known.is_dir() => {
            let source = io::ErrorKind::IsADirectory.into();
            Err(OutputError::Write { path: path.to_owned(), source })
        }
        // What is no ordinary file is written to where it is.
        Ok(known) if !known.is_file() => Ok(()),
        _ => check_folder(path.parent().unwrap_or(Path::new("."))),
    }
}

/// Refuses a path at which one of the files lies that the run has read.
///
/// # Errors
/// `Input`.
pub fn spare(path: &Path, inputs: &[PathBuf]) -> Result<(), OutputError> {
    let Ok(whole) = path.canonicalize() else { return Ok(()) };
    match inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == whole)) {
        true => Err(OutputError::Input { path: path.to_owned() }),
        false => Ok(()),
    }
}

/// Removes temporary files in a folder that no run holds any more.
fn remove_left_over(folder: &Path, spared: &[PathBuf]) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_ours = |entry: &std::fs::DirEntry| {
        let name = entry.file_name();
        let random = name.to_str().and_then(|name| name.strip_prefix(PREFIX));
        random
            .is_some_and(|random| random.len() == RANDOM && random.bytes().all(|b| b.is_ascii_alphanumeric()))
            && entry.metadata().is_ok_and(|known| known.is_file() && is_old(&known))
    };
    for path in entries.filter(is_ours).map(|entry| entry.path()) {
        // A run holds its files locked until they have their names.
        let is_free = File::open(&path).is_ok_and(|file| file.try_lock().is_ok());
        if is_free && spare(&path, spared).is_ok() {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Whether a file has been there for longer than it takes to lock it.
fn is_old(file: &std::fs::Metadata) -> bool {
    const LOCKED: std::time::Duration = std::time::Duration::from_millis(100);
    file.modified().is_ok_and(|changed| changed.elapsed().is_ok_and(|age| age > LOCKED))
}

/// How names of temporary files begin, and how many letters follow.
const PREFIX: &str = ".radiosity-";
const RANDOM: usize = 6;

fn fill(file: impl Write, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    write(&mut writer)?;
    writer.flush()
}

fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).rand_bytes(RANDOM);
    // The permissions of any new file: everyone's, less the umask.
    #[cfg(unix)]
    let ordinary = <std::fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(ordinary);
    // The name of a file that never was helps no one: keep only what the system says.
    let file = builder.tempfile_in(folder).map_err(|e| io::Error::from(e.kind()))?;
    // Where files cannot be locked nothing is removed either.
    let _ = file.as_file().try_lock();
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_written_file_stands_alone_in_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for text in ["first", "second"] {
            replace(&path, |w| w.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert_eq!(names(folder.path()), ["a.txt"]);
        }
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        replace(&path, |w| w.write_all(b"old")).unwrap();
        let failed = replace(&path, |w| {
            w.write_all(&[b'x'; 1 << 20])?;
            Err(io::Error::other("no more"))
        });
        assert!(failed.unwrap_err().to_string().contains("a.txt: no more"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn what_a_killed_run_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let others = [".radiosity-notes", ".radiosity-a.b.cd", ".radiosity-", "radiosity-abc123"];
        for name in others.iter().chain(&[".radiosity-abc123", ".radiosity-spared", ".radiosity-held00"]) {
            fs::write(path(name), "x").unwrap();
        }
        fs::create_dir(path(".radiosity-folder")).unwrap();
        let held = File::open(path(".radiosity-held00")).unwrap();
        held.try_lock().unwrap();
        let spared = [path(".radiosity-spared")];
        remove_left_over(folder.path(), &spared);
        assert!(path(".radiosity-abc123").exists(), "it may be locked any moment");
        let hour_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
        for entry in fs::read_dir(folder.path()).unwrap().flatten().filter(|entry| entry.path().is_file()) {
            File::options().write(true).open(entry.path()).unwrap().set_modified(hour_ago).unwrap();
        }
        remove_left_over(folder.path(), &spared);
        let mut left = names(folder.path());
        left.sort();
        let mut wanted =
            [&others[..], &[".radiosity-spared", ".radiosity-held00", ".radiosity-folder"]].concat();
        wanted.sort_unstable();
        assert_eq!(left, wanted);
    }

    #[test]
    fn files_change_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("folder")).unwrap();
        let started = |bytes: &[u8]| {
            let mut outputs = Outputs::in_folder(folder.path());
            for name in ["a", "b"] {
                outputs.file(name, |w| w.write_all(bytes)).unwrap();
            }
            outputs
        };
        assert_eq!(started(b"old").commit().unwrap(), ["a", "b"]);
        let mut outputs = started(b"new");
        outputs.file("c", |_| Err(io::Error::other("no more"))).unwrap_err();
        outputs.file("folder", |_| Ok(())).unwrap_err();
        drop(outputs);
        let mut left = names(folder.path());
        left.sort();
        assert_eq!(left, ["a", "b", "folder"]);
        assert_eq!(["a", "b"].map(|name| fs::read(folder.path().join(name)).unwrap()), [b"old", b"old"]);
    }

    #[test]
    fn places_where_no_file_can_be_are_found_and_left_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("file"), "x").unwrap();
        for (bad, words) in [("file", "not a directory"), ("file/deeper/still", "not a directory")] {
            let message = check_folder(&path(bad)).unwrap_err().to_string();
            assert!(message.contains(words) && message.contains(bad), "{message}");
        }
        assert!(check_file(folder.path()).is_err() && check_file(&path("file/a.csv")).is_err());
        check_folder(&path("new/deeper")).unwrap();
        check_folder(Path::new("")).unwrap();
        check_file(&path("new/a.csv")).unwrap();
        check_file(&path("file")).unwrap();
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[test]
    fn a_write_into_a_missing_folder_makes_none_and_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let failed = replace(folder.path().join("none/a.txt"), |w| w.write_all(b"x"));
        assert!(failed.unwrap_err().to_string().contains("check that the folder exists"));
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_the_file_as_any_new_one() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let [ours, plain] = ["ours", "plain"].map(|name| folder.path().join(name));
        replace(&ours, |w| w.write_all(b"x")).unwrap();
        fs::write(&plain, "x").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(ours), mode(plain));
    }
}
