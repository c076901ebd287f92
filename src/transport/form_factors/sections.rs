//! Sections: parts of a binary file, each with its length in front and its checksum behind.

use std::io::{self, Read, Seek, SeekFrom, Write};

use bytemuck::Pod;
use xxhash_rust::xxh3::xxh3_64;

/// Files of another version are refused.
pub const VERSION: u32 = 8;

/// Why a file of form factors can't be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FactorsFileError {
    /// It is something else.
    #[error("this is no file of form factors; make one with --save-factors")]
    Foreign,
    /// Another version of the program wrote it.
    #[error("the file has format version {found}, this program reads {VERSION}; save the form factors anew")]
    Version {
        /// The file's version.
        found: u32,
    },
    /// Some of it is missing or altered.
    #[error("the file is damaged: it is cut off or its checksum does not match; save the form factors anew")]
    Damaged,
    /// What it says cannot be of this geometry.
    #[error("the file is damaged: its {part} cannot be of this geometry; save the form factors anew")]
    Unsound {
        /// Which part of it.
        part: &'static str,
    },
    /// It can't be read.
    #[error("the file cannot be read: {0}")]
    Unreadable(String),
    /// It belongs to another scene.
    #[error(
        "the file belongs to other geometry: vertices, faces, mirrors, metals or glass differ from the scene's; save the form factors anew"
    )]
    OtherScene,
}

impl From<io::Error> for FactorsFileError {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Self::Damaged,
            _ => Self::Unreadable(error.to_string()),
        }
    }
}

/// A section that is being put together.
#[derive(Default)]
pub struct Section(Vec<u8>);

impl Section {
    pub fn one<T: Pod>(&mut self, value: T) {
        self.some(&[value]);
    }

    pub fn some<T: Pod>(&mut self, values: &[T]) {
        self.0.extend_from_slice(bytemuck::cast_slice(values));
    }

    /// The number of values, then the values.
    pub fn list<T: Pod>(&mut self, values: &[T]) {
        self.one(values.len() as u64);
        self.some(values);
    }

    pub fn write(self, to: &mut dyn Write) -> io::Result<()> {
        to.write_all(&(self.0.len() as u64).to_le_bytes())?;
        to.write_all(&self.0)?;
        to.write_all(&xxh3_64(&self.0).to_le_bytes())
    }
}

/// Reads the section that comes next.
pub fn read_section(file: &mut (impl Read + Seek)) -> Result<Vec<u8>, FactorsFileError> {
    let length = read_u64(file)?;
    if length.checked_add(8).is_none_or(|needed| needed > left(file)) {
        return Err(FactorsFileError::Damaged);
    }
    let mut content = vec![0; length as usize];
    file.read_exact(&mut content)?;
    if read_u64(file)? == xxh3_64(&content) { Ok(content) } else { Err(FactorsFileError::Damaged) }
}

/// Makes sure that one section and nothing else comes next, without reading it.
pub fn ends_with_section(file: &mut (impl Read + Seek)) -> Result<(), FactorsFileError> {
    let length = read_u64(file)?;
    let whole = length.checked_add(8) == Some(left(file));
    file.seek(SeekFrom::Current(-8))?;
    if whole { Ok(()) } else { Err(FactorsFileError::Damaged) }
}

fn read_u64(file: &mut impl Read) -> Result<u64, FactorsFileError> {
    let mut bytes = [0; 8];
    file.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

/// Bytes from here to the end.
fn left(file: &mut impl Seek) -> u64 {
    let here = file.stream_position().unwrap_or(0);
    let end = file.seek(SeekFrom::End(0)).unwrap_or(here);
    file.seek(SeekFrom::Start(here)).map_or(0, |here| end.saturating_sub(here))
}

/// The part of a section that is still to be taken apart.
#[derive(Clone, Copy)]
pub struct Content<'a>(pub &'a [u8]);

impl Content<'_> {
    pub fn one<T: Pod>(&mut self) -> Result<T, FactorsFileError> {
        self.some(1).map(|values| values[0])
    }

    pub fn some<T: Pod>(&mut self, count: usize) -> Result<Vec<T>, FactorsFileError> {
        let bytes = count.checked_mul(size_of::<T>()).ok_or(FactorsFileError::Damaged)?;
        let (values, rest) = self.0.split_at_checked(bytes).ok_or(FactorsFileError::Damaged)?;
        self.0 = rest;
        Ok(bytemuck::pod_collect_to_vec(values))
    }

    pub fn list<T: Pod>(&mut self) -> Result<Vec<T>, FactorsFileError> {
        let count = self.one::<u64>()?;
        self.some(count as usize)
    }
}
