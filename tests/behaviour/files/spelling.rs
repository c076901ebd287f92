//! White space, line endings and names.

use glam::DVec3;
use radiosity::scene::Scene;

use super::{CORNERS, LAMP, TRIANGLE, loaded};
use crate::scratch::Scratch;

#[test]
fn line_endings_of_either_kind_mean_the_same() {
    let scene = Scene::cornell_box();
    let crlf = |text: &str| text.replace('\n', "\r\n");
    let files = [
        ("a.obj", crlf(include_str!("../../../meshes/cornell_box.obj")).replace("cornell_box.mtl", "a.mtl")),
        ("a.mtl", crlf(include_str!("../../../meshes/cornell_box.mtl"))),
        ("a.toml", crlf(include_str!("../../../meshes/cornell_box.toml"))),
    ];
    let same = loaded(&files);
    assert_eq!((same.faces(), same.materials()), (scene.faces(), scene.materials()));
    assert_eq!((same.vertices(), same.objects()), (scene.vertices(), scene.objects()));
    assert_eq!((same.camera(), same.warnings()), (scene.camera(), scene.warnings()));
}

#[test]
fn space_around_names_is_not_part_of_them() {
    for text in [
        TRIANGLE.replace("usemtl m", "usemtl m  \t "),
        TRIANGLE.replace("usemtl m", "usemtl   m"),
        TRIANGLE.replace("a.mtl", " a.mtl  "),
    ] {
        let scene = loaded(&[("a.obj", text.as_str()), ("a.mtl", "newmtl   m \t\nKd 0.25\n")]);
        assert_eq!((scene.material_of(0).reflectance[0], scene.warnings().len()), (0.25, 0), "{text:?}");
    }
}

#[test]
fn tabs_separate_words_and_lines_may_be_indented() {
    let tabs = TRIANGLE.replace(' ', "\t");
    let indented: String = TRIANGLE.lines().map(|line| format!("  {line}\n")).collect();
    for text in [tabs, indented] {
        let scene = loaded(&[("a.obj", text.as_str()), ("a.mtl", "\tnewmtl\tm\n\tKd\t0.25\n")]);
        assert_eq!((scene.material_of(0).reflectance[0], scene.warnings().len()), (0.25, 0), "{text:?}");
    }
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_first_word() {
    let mark = |text: &str| format!("\u{feff}{text}");
    let text = format!("{CORNERS}v 9 9 9\nmtllib a.mtl\nusemtl m\nf 1 2 3\n");
    let scene = loaded(&[("a.obj", mark(&text)), ("a.mtl", mark(LAMP)), ("a.toml", mark("unit = 2.0\n"))]);
    assert_eq!(scene.corners(0), [DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y]);
    assert_eq!((scene.material_of(0).emission[0], scene.warnings().len()), (1.0, 0));
}

#[test]
fn file_names_may_hold_spaces_and_other_letters() {
    let scratch = Scratch::with(&[
        ("the living rööm.obj", TRIANGLE.replace("a.mtl", "all the färgs.mtl")),
        ("all the färgs.mtl", LAMP.into()),
        ("the living rööm.toml", "unit = 0.5".into()),
    ]);
    let scene = Scene::load(scratch.path("the living rööm.obj")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((scene.name(), scene.material_of(0).emission[0]), ("the living rööm", 1.0));
    assert_eq!(scene.corners(0)[1], 0.5 * DVec3::X);
}
