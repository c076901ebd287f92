//! Files as programs write them: encodings, polygons, colours of vertices, names with comments, and files
//! that lie elsewhere.

use std::fs;

use glam::DVec3;
use radiosity::scene::{Loading, Scene, Surface};

use crate::files::loaded;
use crate::scratch::Scratch;

/// A square of material `m` from `a.mtl`.
const SQUARE: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl m\nf 1 2 3 4\n";

/// The square with these lines of its material.
#[track_caller]
fn square(lines: &str) -> Scene {
    loaded(&[("a.obj", SQUARE.to_owned()), ("a.mtl", format!("newmtl m\n{lines}\n"))])
}

fn area(scene: &Scene) -> DVec3 {
    let of = |face: usize| {
        let [a, b, c] = scene.corners(face);
        (b - a).cross(c - a) / 2.0
    };
    (0..scene.faces().len()).map(of).sum()
}

// Polygons.

#[test]
fn a_doorway_in_one_polygon_stays_open_from_whichever_corner() {
    let corners = ["0 0", "1 0", "1 2", "2 2", "2 0", "3 0", "3 2.5", "0 2.5"];
    let vertices: String = corners.iter().map(|corner| format!("v {corner} 7\n")).collect();
    for first in 0..8 {
        let numbers: Vec<String> = (0..8).map(|k| ((first + k) % 8 + 1).to_string()).collect();
        let scene = loaded(&[("a.obj", format!("{vertices}f {}\n", numbers.join(" ")))]);
        assert!((area(&scene).z - 5.5).abs() < 1e-12, "{first}");
        assert_eq!(scene.faces().len(), 6);
        let in_doorway = |face: usize| {
            let middle = scene.corners(face).iter().sum::<DVec3>() / 3.0;
            middle.x > 1.0 && middle.x < 2.0 && middle.y < 2.0
        };
        assert!(!(0..6).any(in_doorway), "{first}");
    }
}

#[test]
fn faces_know_their_polygon() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nf 1 2\nf 1 2 5\no second\nf 1 2 3 4\nf 1 4 5\n";
    let scene = loaded(&[("a.obj", text)]);
    assert_eq!([0, 1, 2, 3].map(|face| scene.polygon_of(face)), [0, 1, 1, 2]);
    assert_eq!(Scene::cornell_box().polygon_of(3), 1);
}

#[test]
fn bent_and_crossing_polygons_are_spoken_of() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nv 1 1 0\nv 0 2 0\nf 1 2 3 4\nf 1 5 2 6\nf 1 2 5 4\n";
    let said = loaded(&[("a.obj", text)]).warnings().join("\n");
    assert!(said.contains("1 polygon that is not flat (line 7)"), "{said}");
    assert!(said.contains("1 polygon whose border crosses itself (line 8)"), "{said}");
}

// Words and letters.

#[test]
fn lines_go_on_after_a_backslash() {
    let text = SQUARE.replace("f 1 2 3 4", "f 1 2 \\\n  3 \\\r\n4");
    let scene = loaded(&[("a.obj", text), ("a.mtl", "newmtl m\nKd .1 \\\n.2 .3\n".into())]);
    assert_eq!((area(&scene).z, &scene.material_of(0).reflectance[..]), (1.0, &[0.1, 0.2, 0.3][..]));
}

#[test]
fn a_scene_in_utf_16_is_the_same_as_in_utf_8() {
    let encoded = |text: &str, mark: bool| -> Vec<u8> {
        let mark = mark.then_some(0xfeff);
        mark.into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
    };
    for mark in [true, false] {
        let files = [
            ("a.obj", encoded(SQUARE, mark)),
            ("a.mtl", encoded("newmtl m\nKd .25\n", mark)),
            ("a.toml", encoded("unit = \"cm\"\n", mark)),
        ];
        let scene = loaded(&files);
        assert_eq!((area(&scene).z, scene.material_of(0).reflectance[0]), (1e-4, 0.25));
        assert_eq!(scene.warnings(), [""; 0]);
    }
}

#[test]
fn comments_behind_names_are_no_part_of_them() {
    for (used, defined) in [
        ("m # paint", "m"),
        ("m", "m # paint"),
        ("m # one", "m # another"),
        ("m#1", "m#1"),
        ("m # 1", "m # 1"),
    ] {
        let text = SQUARE.replace("usemtl m", &format!("o thing # first\nusemtl {used}"));
        let scene = loaded(&[("a.obj", text), ("a.mtl", format!("newmtl {defined}\nKd .25\n"))]);
        assert_eq!(
            (scene.material_of(0).reflectance[0], scene.warnings()),
            (0.25, &[][..]),
            "{used} {defined}"
        );
        assert_eq!(scene.objects(), ["thing"]);
    }
    // Where names differ by nothing else they are whole.
    let library = "newmtl m # 1\nKd .25\nnewmtl m # 2\nKd .75\n";
    let scene = loaded(&[("a.obj", SQUARE.replace("usemtl m", "usemtl m # 2")), ("a.mtl", library.into())]);
    assert_eq!(scene.material_of(0).reflectance[0], 0.75);
}

#[test]
fn a_nameless_material_is_grey_unless_a_library_has_one() {
    let nameless = SQUARE.replace("usemtl m", "usemtl ");
    let scene = loaded(&[("a.obj", nameless.as_str()), ("a.mtl", "newmtl m\nKd .25\n")]);
    assert_eq!(scene.material_of(0).reflectance[0], 0.5);
    assert!(scene.warnings()[0].contains("1 usemtl without a name (line 6)"), "{:?}", scene.warnings());
    let scene = loaded(&[("a.obj", nameless.as_str()), ("a.mtl", "newmtl\nKd .25\n")]);
    assert_eq!(scene.material_of(0).reflectance[0], 0.25);
}

#[test]
fn a_library_in_quotes_or_one_of_several_is_found() {
    for line in
        ["\"a.mtl\"", "gone.mtl \"a.mtl\"", "\"gone.mtl\" \"a.mtl\"", "A.MTL", ".\\a.mtl", "a.mtl # all"]
    {
        let text = SQUARE.replace("mtllib a.mtl", &format!("mtllib {line}"));
        let scene = loaded(&[("a.obj", text.as_str()), ("a.mtl", "newmtl m\nKd .25\n")]);
        assert_eq!(scene.material_of(0).reflectance[0], 0.25, "{line}: {:?}", scene.warnings());
        assert_eq!(
            scene.warnings().iter().any(|said| said.contains("gone.mtl")),
            line.contains("gone"),
            "{line}"
        );
    }
}

// Colours of vertices.

#[test]
fn colours_of_vertices_are_reflectance_where_there_is_no_material() {
    let square = |colours: [&str; 4], material: &str| {
        let places = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"];
        let vertices: String =
            places.iter().zip(colours).map(|(place, colour)| format!("v {place} {colour}\n")).collect();
        loaded(&[
            ("a.obj", format!("mtllib a.mtl\n{vertices}{material}f 1 2 3\nf 1 3 4\n")),
            ("a.mtl", "newmtl m\nKd .25\n".into()),
        ])
    };
    let of = |scene: &Scene, face: usize| match scene.reflectance_texture(face) {
        Some(texture) => texture.mean(),
        None => [0, 1, 2].map(|k| scene.material_of(face).reflectance[k.min(scene.channels() - 1)]),
    };
    let one = square(["0.2 0.4 0.6"; 4], "");
    assert_eq!([of(&one, 0), of(&one, 1)], [[0.2, 0.4, 0.6]; 2]);
    // Bytes, and another colour at one corner of the second face.
    let two = square(["51 102 153", "51 102 153", "51 102 153", "204 102 0"], "");
    for (face, wanted) in [(0, [0.2, 0.4, 0.6]), (1, [0.4, 0.4, 0.4])] {
        assert!((0..3).all(|k| (of(&two, face)[k] - wanted[k]).abs() < 1e-6), "{:?}", of(&two, face));
    }
    assert!(two.warnings()[0].contains("colours of their vertices"), "{:?}", two.warnings());
    assert_eq!(of(&square(["1 1 1"; 4], ""), 0), [0.5; 3], "white everywhere says nothing");
    assert_eq!(of(&square(["0.2 0.4 0.6"; 4], "usemtl m\n"), 0), [0.25; 3]);
    assert_eq!(of(&square(["0.2 0.4 0.6"; 4], "usemtl ghost\n"), 0), [0.2, 0.4, 0.6]);
}

// Materials of exporters.

#[test]
fn metallic_parts_of_exporters_make_metals_and_no_mirrors() {
    let surface =
        |lines: &str| square(&format!("Kd .8 .8 .4\nKs .5\n{lines}")).material_of(0).surface.clone();
    let metal = |r: f64| Surface::Conductor { reflectance: vec![0.8, 0.8, 0.4], roughness: r };
    assert_eq!(surface("illum 3\nKa .05\nNs 250"), Surface::Diffuse);
    assert_eq!(surface("illum 3\nKa .5\nNs 250"), metal(0.5));
    assert_eq!(surface("illum 3\nKa 1\nNs 1000"), metal(0.0));
    assert_eq!(surface("illum 3\nPm 1\nPr .25"), metal(0.25));
    assert!(
        matches!(surface("illum 3\nKa .05\nNs 640"), Surface::Plastic { roughness, .. } if (roughness - 0.2).abs() < 1e-12)
    );
    // Mirrors of old, whose Ka is their Kd or nothing.
    for lines in ["illum 3\nKa .8 .8 .4", "illum 3", "illum 3\nKa 0"] {
        assert!(matches!(surface(lines), Surface::Mirror { .. }), "{lines}");
    }
    // What stands in every plain material.
    assert_eq!(surface("illum 2\nPr .5\nPm 0\nPs 0\nPc 0"), Surface::Diffuse);
    assert!(matches!(surface("Pr .2\nPm 0"), Surface::Plastic { .. }));
}

// Files elsewhere.

#[test]
fn files_outside_of_the_scene_s_folder_are_not_read_unless_that_is_allowed() {
    let scratch = Scratch::new();
    for folder in ["scene", "secret"] {
        fs::create_dir(scratch.path(folder)).unwrap();
    }
    scratch.write("secret/b.mtl", "newmtl m\nKd .25\n");
    let absolute = scratch.path("secret/b.mtl").display().to_string();
    let mut statements = vec!["../secret/b.mtl".to_owned(), absolute];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(scratch.path("secret/b.mtl"), scratch.path("scene/link.mtl")).unwrap();
        statements.push("link.mtl".into());
    }
    for statement in statements {
        scratch.write("scene/a.obj", SQUARE.replace("a.mtl", &statement));
        let path = scratch.path("scene/a.obj");
        let scene = Scene::load(&path).unwrap();
        assert_eq!(scene.material_of(0).reflectance[0], 0.5, "{statement}");
        let said = scene.warnings().join("\n");
        assert!(said.contains("outside of the scene's folder") && said.contains("--allow-outside"), "{said}");
        let scene = Scene::load_with(&path, Loading { allow_outside: true }).unwrap();
        assert_eq!((scene.material_of(0).reflectance[0], scene.warnings()), (0.25, &[][..]), "{statement}");
    }
}

#[test]
#[cfg(unix)]
fn settings_behind_a_link_to_elsewhere_are_refused() {
    let scratch = Scratch::new();
    fs::create_dir(scratch.path("scene")).unwrap();
    scratch.write("secret.toml", "unit = \"mm\"\n");
    scratch.write("scene/a.obj", SQUARE);
    std::os::unix::fs::symlink(scratch.path("secret.toml"), scratch.path("scene/a.toml")).unwrap();
    let path = scratch.path("scene/a.obj");
    let refused = Scene::load(&path).unwrap_err().to_string();
    assert!(refused.contains("a.toml") && refused.contains("--allow-outside"), "{refused}");
    let scene = Scene::load_with(&path, Loading { allow_outside: true }).unwrap();
    assert!((area(&scene).z - 1e-6).abs() < 1e-18);
}

#[test]
fn what_is_found_inside_is_not_said_to_lie_outside() {
    let scratch = Scratch::with(&[("b.mtl", "newmtl m\nKd .75\n")]);
    fs::create_dir(scratch.path("scene")).unwrap();
    scratch.write("scene/a.obj", SQUARE.replace("a.mtl", "../b.mtl"));
    scratch.write("scene/b.mtl", "newmtl m\nKd .25\n");
    let scene = Scene::load(scratch.path("scene/a.obj")).unwrap();
    assert_eq!(scene.material_of(0).reflectance[0], 0.25);
    let said = scene.warnings().join("\n");
    assert!(said.contains("found by name") && !said.contains("outside"), "{said}");
}

#[test]
fn a_library_that_is_named_many_times_is_read_once() {
    let text = format!("{}{}", "mtllib a.mtl\n".repeat(1000), SQUARE);
    let scene = loaded(&[("a.obj", text), ("a.mtl", "newmtl m\nKd .25\nKd x\n".to_owned())]);
    assert_eq!(scene.material_of(0).reflectance[0], 0.25);
    let said = scene.warnings().join("\n");
    assert!(said.contains("a.mtl:3") && !said.contains("more such"), "{said}");
}

#[test]
fn a_scene_may_come_as_a_stream() {
    let scratch = Scratch::with(&[("a.mtl", "newmtl m\nKd .25\n")]);
    let scene = Scene::read(SQUARE.as_bytes(), scratch.path(""), Loading::default()).unwrap();
    assert_eq!((scene.name(), scene.material_of(0).reflectance[0]), ("stdin", 0.25));
}

#[test]
fn settings_of_another_name_are_spoken_of() {
    let files = [("a.obj", SQUARE), ("a.mtl", "newmtl m\nKd .25\n"), ("scene.toml", "unit = 2.0\n")];
    let said = loaded(&files).warnings().join("\n");
    assert!(said.contains("scene.toml is not read") && said.contains("a.toml"), "{said}");
    let files = [("a.obj", SQUARE), ("a.mtl", "newmtl m\nKd .25\n"), ("b.toml", ""), ("b.obj", SQUARE)];
    assert_eq!(loaded(&files).warnings(), [""; 0]);
}
