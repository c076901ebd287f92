//! Built-in scenes: the files of `meshes/` that travel inside the library.

use std::path::Path;

use super::{Scene, obj};

/// The Cornell box; see the comment in `meshes/cornell_box.obj`.
pub(super) fn cornell_box() -> Scene {
    let settings = include_str!("../../meshes/cornell_box.toml").to_owned();
    let scene = obj::parse(
        Path::new("cornell_box.obj"),
        include_str!("../../meshes/cornell_box.obj"),
        Some((Path::new("cornell_box.toml"), settings)),
        |_| Ok(include_str!("../../meshes/cornell_box.mtl").to_owned()),
    );
    scene.expect("the built-in Cornell box is a valid scene")
}
