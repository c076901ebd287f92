//! Settings beside the scene: what they change, and how bad ones are refused.

use glam::DVec3;

use super::{CORNERS, LAMP, TRIANGLE, loaded, refusal, says};

/// A lamp with these settings.
fn toml(text: &str) -> [(&'static str, String); 3] {
    [("a.obj", TRIANGLE.into()), ("a.mtl", LAMP.into()), ("a.toml", text.into())]
}

#[test]
fn refuses_settings_that_make_no_sense_by_file_and_line() {
    for (text, line, words) in [
        ("unit = 1.0\ncolour = 3\n", 2, ["colour", ""]),
        ("\n[camera]\nposition = [0, 0, 0]\ntarget = [0.0, 0.0, 1.0]\nzoom = 3\n", 5, ["zoom", ""]),
        ("\n\n[material.m]\nKd = 0.5\n", 4, ["Kd", "reflectance"]),
        ("# lengths\nunit = \"furlong\"\n", 2, ["a unit is the number of metres in it", "mm"]),
        ("[camera]\nposition = [0.0, 0.0]\ntarget = [0.0, 0.0, 1.0]\n", 2, ["", ""]),
        ("[camera]\nposition = [0.0, 0.0, 0.0]\n", 1, ["target", ""]),
        ("unit = 1.0\n[material.m\nreflectance = 0.5\n", 2, ["", ""]),
        ("unit = 1.0\nunit = 2.0\n", 2, ["duplicate", ""]),
    ] {
        let message = refusal(&toml(text));
        says(&message, &[&format!("a.toml:{line}: ")]);
        says(&message, &words);
    }
}

#[test]
fn tables_in_other_brackets_or_of_no_kind_are_refused_with_how_they_are_written() {
    for (text, line, words) in [
        ("sky = \"clear\"\n", 1, ["sky: \"clear\"", "write [sky]"]),
        ("camera = 5\n", 1, ["camera: 5", "write [camera]"]),
        ("\n[[sky]]\nkind = \"clear\"\n", 2, ["sky: there is no more than one", "[sky] in single brackets"]),
        ("\n[receiver]\nname = \"a\"\n", 2, ["receiver: there may be several", "[[receiver]] in double"]),
        ("light = 5\n", 1, ["light: 5", "write [[light]]"]),
        ("[sky]\nkind = \"clear\"\n[sky]\nkind = \"clear\"\n", 3, ["sky: duplicate key", "keep one"]),
        ("[[light]]\nkind = 5\n", 2, ["light: kind = 5", "\"spot\""]),
        ("[[light]]\ntype = \"point\"\n", 2, ["light: write kind in place of type", "\"point\""]),
        ("\n[sky]\ntype = 3\n", 2, ["sky: kind is missing", "\"overcast\""]),
        (
            "[[receiver]]\nname = \"a\"\nkind = \"round\"\n",
            3,
            ["receiver: kind = \"round\"", "\"cylindrical\""],
        ),
        ("[material]\nreflectance = 1\n", 2, ["material: 1", "write [material.NAME]"]),
        ("[[material.m]]\nreflectance = 1\n", 1, ["material: ", "single brackets"]),
    ] {
        let message = refusal(&toml(text));
        says(&message, &[&format!("a.toml:{line}: ")]);
        says(&message, &words);
    }
}

#[test]
fn values_of_another_type_are_refused_with_their_key_and_what_it_takes() {
    let point = "[[light]]\nkind = \"point\"\nflux = 1\n";
    let sky = "[sky]\nkind = \"cie\"\nilluminance = 1\n";
    for (text, line, words) in [
        (format!("{point}position = [0, 1]\n"), 4, "position: 2 in place of 3 values"),
        (format!("{point}position = [0, 1, \"a\"]\n"), 4, "position: \"a\" stands where a number should"),
        (format!("{point}position = 1\n"), 4, "position: 1 stands where a list in brackets should"),
        (format!("{sky}type = 5\nup = [0, 1, 0, 0]\n"), 5, "up: 4 in place of 3 values"),
        (format!("{sky}type = 1.5\n"), 4, "type: 1.5 stands where a whole number, 0 or more, should"),
        ("[material.m]\nthin = 1\n".into(), 2, "thin: 1 stands where true or false should"),
        ("[material.m]\nreflectance = [1, 2]\n".into(), 2, "reflectance: a colour is one number, or three"),
        ("[camera]\nposition = [0,\n0, \"x\"]\n".into(), 3, "position: \"x\" stands where a number should"),
        ("efficacy = \"x\"\n".into(), 1, "efficacy: \"x\" stands where a number should"),
    ] {
        says(&refusal(&toml(&text)), &[&format!("a.toml:{line}: "), words]);
    }
}

#[test]
fn refuses_settings_that_are_no_text() {
    let bytes = [0u8, 1, 0xff, b'=', 0xfe];
    let files = [("a.obj", TRIANGLE.as_bytes()), ("a.mtl", LAMP.as_bytes()), ("a.toml", &bytes)];
    says(&refusal(&files), &["a.toml:1: "]);
}

#[test]
fn a_colour_of_another_form_is_refused_with_how_it_is_written() {
    for colour in ["\"white\"", "[0.1, 0.2]", "true"] {
        let message = refusal(&toml(&format!("[material.m]\nreflectance = {colour}\n")));
        says(&message, &["a.toml:2: ", "number"]);
        assert!(!message.contains("untagged enum"), "the words of the reader, not of its author: {message}");
    }
}

#[test]
fn refuses_a_unit_that_is_no_length() {
    for unit in ["0", "0.0", "-1.0", "nan", "inf"] {
        let message = refusal(&toml(&format!("unit = {unit}\n")));
        says(&message, &["a.toml:1: ", "unit", "must be positive"]);
        let message = refusal(&toml(&format!("# lengths\n\nunit = {unit}\n")));
        says(&message, &["a.toml:3: "]);
    }
}

#[test]
fn refuses_a_unit_that_makes_vertices_infinite() {
    let text = TRIANGLE.replace("v 1", "v 10");
    let files = [("a.obj", text.as_str()), ("a.mtl", LAMP), ("a.toml", "unit = 1e308\n")];
    says(&refusal(&files), &["a.toml:1: unit", "more than 1e30 m"]);
}

#[test]
fn refuses_a_camera_that_sees_nothing() {
    for camera in [
        "position = [1.0, 2.0, 3.0]\ntarget = [1.0, 2.0, 3.0]",
        "position = [1.0, 2.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, 0.0]",
        "position = [1.0, 2.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\nfov = 0.0",
        "position = [1.0, 2.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\nfov = 180.0",
        "position = [1.0, 2.0, nan]\ntarget = [0.0, 0.0, 0.0]",
    ] {
        let message = refusal(&toml(&format!("unit = 2.0\n[camera]\n{camera}\n")));
        says(
            &message,
            &["a.toml:2: camera", "position and target must differ", "fov must lie between 0 and 180"],
        );
    }
}

#[test]
fn refuses_changes_to_a_material_that_does_not_exist() {
    says(
        &refusal(&toml("\n[material.ghost]\nreflectance = 0.5\n")),
        &["a.toml:2: ", "material ghost", "no face", "there are m"],
    );
}

#[test]
fn settings_are_held_to_the_same_physics() {
    let bad = |line: &str| refusal(&toml(&format!("[material.m]\n{line}\n")));
    says(&bad("reflectance = 1.5"), &["a.toml:2: ", "material m", "reflectance 1.5"]);
    says(&bad("emission = [1.0, -2.0, 0.0]"), &["a.toml:2: ", "material m", "emission -2"]);
}

#[test]
fn the_unit_scales_vertices_and_camera() {
    let text = "unit = 0.01\n[camera]\nposition = [100.0, 0.0, 0.0]\ntarget = [0.0, 300.0, 0.0]\nup = [0.0, 0.0, 5.0]\nfov = 30.0\n";
    let scene = loaded(&toml(text));
    assert_eq!(scene.corners(0), [DVec3::ZERO, 0.01 * DVec3::X, 0.01 * DVec3::Y]);
    let camera = scene.camera().expect("the settings give a camera");
    assert_eq!((camera.position, camera.target), (DVec3::X, 3.0 * DVec3::Y));
    assert_eq!((camera.up, camera.fov), (5.0 * DVec3::Z, 30.0));
}

#[test]
fn settings_change_what_they_name_and_nothing_else() {
    let second = "newmtl n\nKd 0.3\nKe 2\n";
    let settings = "[material.m]\nreflectance = [0.1, 0.2, 0.3]\n[material.n]\nemission = 7\n";
    let scene = loaded(&[("a.obj", TRIANGLE), ("a.mtl", &format!("{LAMP}{second}")), ("a.toml", settings)]);
    let [m, n] = scene.materials() else { panic!("two materials") };
    assert_eq!((&m.reflectance[..], &m.emission[..]), (&[0.1, 0.2, 0.3][..], &[1.0; 3][..]));
    assert_eq!((&n.reflectance[..], &n.emission[..]), (&[0.3; 3][..], &[7.0; 3][..]));
    assert_eq!((scene.channels(), scene.camera()), (3, None));
}

#[test]
fn settings_may_define_what_no_library_does() {
    let text = format!("{CORNERS}f 1 2 3\nv 0 0 1\nusemtl ghost\nf 1 2 4\n");
    let settings = "[material.ghost]\nreflectance = 0.25\n[material.\"(none)\"]\nemission = 2\n";
    let scene = loaded(&[("a.obj", text.as_str()), ("a.toml", settings)]);
    let names: Vec<&str> = (0..2).map(|face| scene.material_of(face).name.as_str()).collect();
    assert_eq!(names, ["(none)", "ghost"]);
    assert_eq!((scene.material_of(0).emission[0], scene.material_of(1).reflectance[0]), (2.0, 0.25));
}

#[test]
fn empty_settings_change_nothing() {
    let scene = loaded(&toml("# nothing\n"));
    assert_eq!((scene.corners(0)[1], scene.camera()), (DVec3::X, None));
}
