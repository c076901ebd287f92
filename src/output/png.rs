//! Pictures as files.

use std::path::Path;

use super::{OutputError, replace};
use crate::render::{Exposure, Picture};

impl Picture {
    /// Writes an sRGB PNG to `path`, which changes only once everything is written.
    ///
    /// # Errors
    /// `Write`.
    pub fn save_png(&self, path: impl AsRef<Path>, exposure: Exposure) -> Result<(), OutputError> {
        replace(path, |writer| self.write_png(writer, exposure))
    }
}
