//! Material libraries: where they are found, and which of their lines make sense.

use std::fs;

use radiosity::scene::Scene;

use super::{CORNERS, LAMP, TRIANGLE, loaded, mtl, obj, refusal, says};
use crate::scratch::Scratch;

#[test]
fn a_missing_library_is_done_without() {
    let scene = loaded(&[("a.obj", format!("# first\nmtllib none.mtl\n{CORNERS}f 1 2 3\n"))]);
    says(&scene.warnings()[0], &["a material library is not there: none.mtl"]);
    assert_eq!(scene.material_of(0).reflectance, [0.5]);
}

#[test]
fn a_library_of_the_scene_s_name_stands_in_for_one_that_is_missing() {
    for lines in ["mtllib none.mtl\n", "mtllib D:\\maps\\none.mtl\n", "mtllib \"no ne.mtl\"\n"] {
        let scene = loaded(&[("a.obj", TRIANGLE.replace("mtllib a.mtl\n", lines)), ("a.mtl", LAMP.into())]);
        says(&scene.warnings()[0], &["not there", "a.mtl is read"]);
        assert_eq!(scene.material_of(0).emission, [1.0]);
    }
}

#[test]
fn several_libraries_make_one() {
    let faces = "usemtl m\nf 1 2 3\nusemtl n\nf 1 2 4\n";
    for lines in ["mtllib a.mtl b.mtl\n", "mtllib a.mtl\nmtllib b.mtl\n", "mtllib  a.mtl\t b.mtl\n"] {
        let text = format!("{lines}{CORNERS}v 0 0 1\n{faces}");
        let scene = loaded(&[
            ("a.obj", text.as_str()),
            ("a.mtl", "newmtl n\nKd 0.9\nnewmtl m\nKd 0.25\n"),
            ("b.mtl", "Kd 0.1\nnewmtl n\nKd 0.75\n"),
        ]);
        let reflectance = |face: usize| scene.material_of(face).reflectance[0];
        assert_eq!((reflectance(0), reflectance(1)), (0.25, 0.75), "the later definition counts: {lines:?}");
        assert_eq!((scene.materials().len(), scene.warnings().len()), (2, 0), "{lines:?}");
    }
    let scene = loaded(&[("a.obj", TRIANGLE.replace("a.mtl", "gone.mtl a.mtl")), ("a.mtl", LAMP.into())]);
    says(&scene.warnings()[0], &["a material library is not there: gone.mtl"]);
    assert_eq!(scene.material_of(0).emission, [1.0]);
}

#[test]
fn refuses_numbers_that_no_scene_can_have_by_file_and_line() {
    for (line, blame) in [
        ("Ke 0 inf 0", "Ke is inf"),
        ("Kd 0 0 nan", "Kd is NaN"),
        ("Ke 1e999", "Ke is inf"),
        ("Ke 1e31", "Ke is 1e31"),
        ("Ns -inf", "Ns is -inf"),
        ("Pr nan", "Pr is NaN"),
        ("map_Kd -s nan 1 1 a.png", "nan of map_Kd"),
        ("map_Ke -o 1 1e13 a.png", "1e13 of map_Ke"),
    ] {
        says(&refusal(&mtl(&format!("Kd 0.5\n{line}"))), &["a.mtl:3: ", blame]);
    }
    for line in ["vt 18446744073709551616 0", "vt 0 -inf"] {
        says(&refusal(&obj(&format!("{line}\nf 1 2 3\n"))), &["a.obj:4: ", "`vt`", "none beyond 1e12"]);
    }
}

#[test]
fn lines_of_libraries_that_make_no_sense_are_left_out_with_one_warning() {
    let said = |lines: &str| {
        let scene = loaded(&mtl(&format!("Kd 0.25\n{lines}")));
        assert_eq!(scene.material_of(0).reflectance, [0.25]);
        assert_eq!(scene.warnings().len(), 1, "{:?}", scene.warnings());
        scene.warnings()[0].clone()
    };
    for colour in ["", "0.5 0.5", "red", "0.5 0.5 blue", "0.5 0.5 0.5 0.5", "spectral a.rfl", "0,5"] {
        for key in ["Kd", "Ke", "Ks", "Ka"] {
            says(&said(&format!("{key} {colour}")), &["a.mtl:3: ", key, "one or three numbers", "left out"]);
        }
    }
    for line in [
        "illum",
        "illum two",
        "illum 300",
        "illum 1.5",
        "illum -1",
        "Ns",
        "Ni glass",
        "d half",
        "map_Kd",
        "Pr 1.5",
        "Pm -1",
        "Ns -1",
    ] {
        says(&said(line), &["a.mtl:3: ", "left out"]);
    }
    says(&said("Ns\nKs blue\nNi -1.5"), &["a.mtl:3: Ns", "left out (and 2 more such lines)"]);
}

#[test]
fn a_library_in_another_folder_is_found_from_the_scene() {
    let scratch = Scratch::with(&[("a.obj", TRIANGLE.replace("a.mtl", "materials/a.mtl"))]);
    fs::create_dir(scratch.path("materials")).unwrap();
    scratch.write("materials/a.mtl", "newmtl m\nKd 2\n");
    let refused =
        |scratch: &Scratch| Scene::load(scratch.path("a.obj")).expect_err("a bad library").to_string();
    says(&refused(&scratch), &["material m"]);
    scratch.write("materials/a.mtl", "newmtl m\nKd nan\n");
    says(&refused(&scratch), &[&format!("{}:2: ", scratch.path("materials/a.mtl").display())]);
}
