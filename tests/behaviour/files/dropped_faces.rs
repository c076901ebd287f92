//! Faces without area and faces that are there twice: dropped, counted, and the others keep their number.

use radiosity::patches::Reach;
use radiosity::scene::{FaceState, Scene, SceneError};
use radiosity::trace::Tracer;

use super::{CORNERS, LAMP, cut, load, loaded, obj, refusal, says};

/// The faces that have patches.
fn faces_with_patches(scene: &Scene) -> Vec<usize> {
    let tracer = Tracer::new(scene);
    let patches = cut(&tracer, Reach::Light);
    let mut faces: Vec<usize> = (0..patches.len()).map(|i| patches.place(i).face).collect();
    faces.dedup();
    faces
}

#[test]
fn zero_area_faces_are_dropped_and_counted_and_keep_their_number() {
    let lines = "v 2 0 0\nusemtl m\nf 1 2 4\nf 1 2 3\nf 1 1 2\nf 1 3 4\n";
    let text = format!("mtllib a.mtl\n{CORNERS}{lines}");
    let scene = loaded(&[("a.obj", text.as_str()), ("a.mtl", LAMP)]);
    let states: Vec<FaceState> = scene.faces().iter().map(|face| face.state).collect();
    assert_eq!(states, [FaceState::ZeroArea, FaceState::Kept, FaceState::ZeroArea, FaceState::Kept]);
    assert_eq!(scene.warnings(), ["dropped 2 faces: no area"]);
    assert_eq!(faces_with_patches(&scene), [1, 3]);
}

#[test]
fn exact_duplicates_are_dropped_and_counted_and_keep_their_number() {
    let lines = "v 0 0 -0.0\nusemtl m\nf 1 2 3\nf 2 3 1\nf 4 2 3\nv 0 0 1\nf 1 2 5\n";
    let text = format!("mtllib a.mtl\n{CORNERS}{lines}");
    let scene = loaded(&[("a.obj", text.as_str()), ("a.mtl", LAMP)]);
    let states: Vec<FaceState> = scene.faces().iter().map(|face| face.state).collect();
    assert_eq!(states, [FaceState::Kept, FaceState::Duplicate, FaceState::Duplicate, FaceState::Kept]);
    assert_eq!(scene.warnings(), ["dropped 2 faces: duplicates of earlier faces"]);
    assert_eq!(faces_with_patches(&scene), [0, 3]);
}

#[test]
fn a_dropped_lamp_is_mentioned() {
    let text = format!("mtllib a.mtl\n{CORNERS}usemtl dark\nf 1 2 3\nusemtl m\nf 1 2 3\n");
    let scene = loaded(&[("a.obj", text), ("a.mtl", format!("{LAMP}newmtl dark\nKd 0 0 0\n"))]);
    says(&scene.warnings().join("\n"), &["dropped 1 face: duplicates", "1 duplicate of those emit"]);
    let error = scene.require_light().expect_err("the lamp is dropped");
    says(&error.to_string(), &["no light"]);
}

#[test]
fn refuses_a_scene_of_zero_area_faces_only() {
    let files = obj("f 1 1 2\nf 2 2 2\n");
    assert!(matches!(load(&files), Err(SceneError::NoArea { .. })));
    says(&refusal(&files), &["a: ", "every face has zero area", "check the unit and the vertices"]);
}
