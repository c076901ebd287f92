//! Files: Wavefront OBJ and MTL, the settings beside them, and pictures.

mod beside;
mod builtin;
mod colour;
mod light_settings;
mod list;
mod mtl;
mod obj;
mod picture_file;
mod settings;
mod settings_line;
mod settings_shape;
mod settings_words;
mod text;
pub(super) use builtin::cornell_box;
pub(super) use obj::{load, read};
