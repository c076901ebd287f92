//! Files that cannot be read, or hold no scene.

use std::fs;

use radiosity::scene::{Scene, SceneError};

use super::{CORNERS, Random, TRIANGLE, load, loaded, refusal, says};
use crate::scratch::Scratch;

#[test]
fn refuses_a_missing_file() {
    let scratch = Scratch::new();
    let path = scratch.path("none.obj");
    let error = Scene::load(&path).expect_err("there is no such file");
    assert!(matches!(error, SceneError::Read { .. }));
    says(&error.to_string(), &["cannot read", &path.display().to_string()]);
}

#[test]
fn refuses_a_folder() {
    let scratch = Scratch::new();
    fs::create_dir(scratch.path("a.obj")).unwrap();
    let error = Scene::load(scratch.path("a.obj")).expect_err("a folder is no scene");
    says(&error.to_string(), &["cannot read", "a.obj"]);
}

#[test]
fn refuses_files_without_faces() {
    for text in ["", "\n", "# nothing but a comment", CORNERS, "o empty\ng empty\n"] {
        let files = [("a.obj", text)];
        assert!(matches!(load(&files), Err(SceneError::NoFaces { .. })), "{text:?}");
        says(&refusal(&files), &["a: ", "no faces", "`f` lines"]);
    }
}

#[test]
fn refuses_binary_garbage() {
    let mut bytes = vec![0, 0xff, 0xfe, b'\n', b'f', b' ', 0x80, b'\n'];
    let mut random = Random(1);
    bytes.extend((0..16384).map(|_| random.below(256) as u8));
    says(&refusal(&[("a.obj", &bytes)]), &["a.obj:"]);
    says(&refusal(&[("a.obj", &bytes[..3])]), &["no faces"]);
    let library = [("a.obj", TRIANGLE.as_bytes()), ("a.mtl", &bytes)];
    assert_eq!(loaded(&library).material_of(0).reflectance, [0.5], "the material is unknown");
}
