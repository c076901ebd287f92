//! What materials reflect and emit, and which one a face has.

use radiosity::scene::SceneError;

use super::{CORNERS, TRIANGLE, loaded, mtl, obj, refusal, says};

#[test]
fn refuses_reflectance_outside_0_to_1() {
    for (kd, blame) in [("1.2 0.5 0.5", "1.2"), ("0.5 -0.1 0.5", "-0.1")] {
        let message = refusal(&mtl(&format!("Kd {kd}")));
        says(&message, &["material m", &format!("reflectance {blame}"), "between 0 and 1", "Kd"]);
    }
    for kd in ["0", "1", "0 1 0.5"] {
        loaded(&mtl(&format!("Kd {kd}")));
    }
}

#[test]
fn refuses_negative_or_infinite_emission() {
    let message = refusal(&mtl("Kd 0.5\nKe -1 0 0"));
    says(&message, &["material m", "emission -1", "not negative", "Ke"]);
}

#[test]
fn one_number_is_grey() {
    let scene = loaded(&mtl("Kd 0.25\nKe 3"));
    assert_eq!((scene.channels(), &scene.materials()[0].reflectance[..]), (1, &[0.25][..]));
    assert_eq!(scene.materials()[0].emission, [3.0]);
    let colourful = loaded(&mtl("Kd 0.25\nKe 3\nnewmtl other\nKd 0.1 0.2 0.3"));
    assert_eq!((colourful.channels(), &colourful.materials()[0].reflectance[..]), (3, &[0.25; 3][..]));
}

#[test]
fn a_scene_without_light_loads_but_cannot_be_lit() {
    for text in ["Kd 0.5", "Kd 0.5\nKe 0 0 0"] {
        let error = loaded(&mtl(text)).require_light().expect_err("nothing emits");
        assert!(matches!(error, SceneError::NoLight { .. }));
        says(&error.to_string(), &["a: ", "no light", "Ke in the MTL file", ".toml"]);
    }
    loaded(&mtl("Kd 0.5\nKe 0 0.1 0")).require_light().expect("the green channel emits");
}

#[test]
fn a_lamp_that_no_face_uses_is_no_light() {
    let scene = loaded(&[("a.obj", TRIANGLE), ("a.mtl", "newmtl m\nKd 0.5\nnewmtl lamp\nKe 1\nKd 0\n")]);
    scene.require_light().expect_err("no face emits");
}

#[test]
fn faces_without_a_known_material_are_grey_with_one_warning() {
    for text in [
        "f 1 2 3\n",
        "usemtl ghost\nf 1 2 3\n",
        "f 1 2 3\nv 0 0 1\nusemtl ghost\nf 1 2 4\nusemtl other ghost\nf 1 3 4\n",
        "o one\nf 1 2 3\no two\nv 0 0 1\nf 1 2 4\n",
    ] {
        let scene = loaded(&obj(text));
        assert_eq!(scene.warnings().len(), 1, "{:?}", scene.warnings());
        says(&scene.warnings()[0], &["grey 0.5"]);
        let ghosts =
            ["ghost", "other ghost"].into_iter().filter(|ghost| text.contains(&format!("usemtl {ghost}\n")));
        says(&scene.warnings()[0], &ghosts.collect::<Vec<_>>());
        for face in 0..scene.faces().len() {
            let material = scene.material_of(face);
            assert_eq!(material.reflectance, [0.5]);
            assert!(scene.warnings()[0].contains(&material.name), "{:?}", scene.warnings());
        }
    }
}

#[test]
fn faces_without_a_material_are_grey_even_where_a_material_is_called_default() {
    let text = format!("mtllib a.mtl\n{CORNERS}f 1 2 3\n");
    let scene = loaded(&[("a.obj", text.as_str()), ("a.mtl", "newmtl default\nKd 0.9\nKe 5\n")]);
    assert_eq!(scene.material_of(0).reflectance, [0.5]);
    assert_eq!(scene.material_of(0).emission, [0.0]);
    assert_eq!(scene.warnings().len(), 1, "{:?}", scene.warnings());
}
