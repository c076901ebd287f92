//! File: a file is replaced whole, or left as it was.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::OutputError;

/// Writes what `write` writes to `path`, which changes only once everything is written.
///
/// The bytes go to a temporary file in the same folder, which then takes the name; no folder is made, no other file
/// touched. A path that is no ordinary file, such as `/dev/stdout`, is written to directly.
///
/// # Errors
/// `Write`; an old file of that name is then still there.
pub fn replace(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let path = path.as_ref();
    let special = path.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir());
    let done =
        if special { File::create(path).and_then(|f| fill(f, write)) } else { rename_over(path, write) };
    done.map_err(|source| OutputError::Write { path: path.to_owned(), source })
}

fn rename_over(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = temporary_in(folder)?;
    fill(file.as_file(), write)?;
    file.persist(path).map_err(|failed| failed.error)?;
    Ok(())
}

fn fill(file: impl Write, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    write(&mut writer)?;
    writer.flush()
}

fn temporary_in(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".radiosity-");
    // The permissions of any new file: everyone's, less the umask.
    #[cfg(unix)]
    let ordinary = <std::fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(ordinary);
    builder.tempfile_in(folder)
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
    fn makes_no_folder_and_says_so() {
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
