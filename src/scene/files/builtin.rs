//! Built-in scenes: the files of `meshes/` that travel inside the library.

use std::path::Path;

use super::beside::Beside;
use super::obj;
use crate::scene::Scene;

/// The Cornell box; see the comment in `meshes/cornell_box.obj`.
pub(crate) fn cornell_box() -> Scene {
    let settings = include_str!("../../../meshes/cornell_box.toml").to_owned();
    let scene = obj::parse(
        (Path::new("cornell_box.obj"), include_str!("../../../meshes/cornell_box.obj")),
        Some((Path::new("cornell_box.toml"), settings)),
        &Beside::new(Path::new(""), false),
        |library, _, warnings| {
            let text = include_str!("../../../meshes/cornell_box.mtl");
            library.read_text(Path::new("cornell_box.mtl"), text, warnings)
        },
    );
    scene.expect("the built-in Cornell box is a valid scene")
}
