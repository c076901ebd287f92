//! NPZ: named arrays in one file, as `numpy.load` reads them: a zip archive of `.npy` files.
//!
//! The layout is that of NumPy Enhancement Proposal 1, version 1.0: a line of text that says type and shape,
//! then the numbers.

use std::io::{self, Write};

use zip::write::{SimpleFileOptions, StreamWriter, ZipWriter};

/// Bytes to whose multiples NumPy fills up what stands before the numbers.
const ALIGNMENT: usize = 64;

/// An archive that is being written, array after array.
pub(super) struct Npz<W: Write>(ZipWriter<StreamWriter<W>>);

impl<W: Write> Npz<W> {
    pub fn new(writer: W) -> Self {
        Self(ZipWriter::new_stream(writer))
    }

    /// Writes an array of f64, row after row.
    ///
    /// # Panics
    /// If the rows together have not as many values as `shape` says.
    pub fn array<R: AsRef<[f64]>>(
        &mut self,
        name: &str,
        shape: &[usize],
        rows: impl IntoIterator<Item = R>,
    ) -> io::Result<()> {
        self.begin(name, "<f8", shape)?;
        let mut bytes = Vec::new();
        let mut values = 0;
        for row in rows {
            bytes.clear();
            row.as_ref().iter().for_each(|value| bytes.extend(value.to_le_bytes()));
            values += row.as_ref().len();
            self.0.write_all(&bytes)?;
        }
        assert_eq!(values, shape.iter().product::<usize>(), "as many values as the shape says");
        Ok(())
    }

    /// Writes texts as UTF-32, all as wide as the longest.
    pub fn texts(&mut self, name: &str, texts: &[&str]) -> io::Result<()> {
        let width = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
        self.begin(name, &format!("<U{width}"), &[texts.len()])?;
        for text in texts {
            let letters = text.chars().chain(std::iter::repeat('\0')).take(width);
            let bytes: Vec<u8> = letters.flat_map(|letter| u32::from(letter).to_le_bytes()).collect();
            self.0.write_all(&bytes)?;
        }
        Ok(())
    }

    /// Writes the end of the archive.
    pub fn finish(self) -> io::Result<()> {
        self.0.finish()?.into_inner().flush()
    }

    fn begin(&mut self, name: &str, kind: &str, shape: &[usize]) -> io::Result<()> {
        // Most form factors between patches are zero: the quickest compression does nearly all there is to
        // do.
        let options = SimpleFileOptions::default().compression_level(Some(1)).large_file(true);
        self.0.start_file(format!("{name}.npy"), options)?;
        self.0.write_all(&header(kind, shape))
    }
}

/// What stands before the numbers.
fn header(kind: &str, shape: &[usize]) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
    let shape: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let mut text =
        format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}), }}", shape.trim_end());
    let before = MAGIC.len() + 2;
    let filled = (before + text.len() + 1).next_multiple_of(ALIGNMENT) - before;
    text.extend(std::iter::repeat_n(' ', filled - 1 - text.len()));
    text.push('\n');
    [MAGIC, &(filled as u16).to_le_bytes(), text.as_bytes()].concat()
}

#[cfg(test)]
mod tests {
    use super::header;

    #[test]
    fn headers_are_what_numpy_writes() {
        let written = header("<f8", &[3, 2]);
        assert_eq!(written.len(), 128);
        assert!(written.starts_with(
            b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2,), }  "
        ));
        assert!(written.ends_with(b" \n"));
        assert!(String::from_utf8_lossy(&header("<U5", &[7])).contains("'shape': (7,), }"));
    }
}
