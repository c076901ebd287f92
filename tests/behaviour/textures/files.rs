//! Image files: colour spaces, coordinates, where they are found, what is missing.

use std::sync::Arc;

use radiosity::scene::Scene;

use crate::picture_files;
use crate::scratch::Scratch;

const OBJ: &str =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n";

fn png(colour: [u8; 3]) -> Vec<u8> {
    picture_files::png(4, 4, |_, _| colour)
}

fn exr(colour: [f32; 3]) -> Vec<u8> {
    picture_files::exr(4, 4, |_, _| colour)
}

/// A scene of one triangle whose material has these lines.
fn load(lines: &str, files: &[(&str, Vec<u8>)]) -> Result<Scene, String> {
    let scratch = Scratch::with(files);
    scratch.write("a.obj", OBJ);
    scratch.write("a.mtl", format!("newmtl m\n{lines}\n"));
    Scene::load(scratch.path("a.obj")).map_err(|e| e.to_string())
}

#[test]
fn pictures_of_bytes_are_srgb_and_those_of_floats_are_linear() {
    let files = [("grey.png", png([188, 188, 0])), ("glow.exr", exr([2.0, 4.0, 8.0]))];
    let scene = load("Kd 0.5\nmap_Kd grey.png\nKe 3 2 1\nmap_Ke glow.exr", &files).unwrap();
    assert_eq!(scene.warnings(), [""; 0]);
    let rho = scene.reflectance_texture(0).unwrap().at([0.3, 0.3]);
    assert!((rho[0] - 0.502886).abs() < 1e-5 && rho[2] == 0.0, "{rho:?}");
    assert_eq!(scene.mean_emission(0), [6.0, 8.0, 8.0]);
    // Without a factor the picture is taken as it is.
    let scene = load("map_Kd grey.png\nmap_Ke glow.exr", &files).unwrap();
    assert_eq!(
        (&scene.material_of(0).reflectance[..], &scene.mean_emission(0)[..]),
        (&[1.0; 3][..], &[2.0, 4.0, 8.0][..])
    );
    assert_eq!(scene.warnings(), [""; 0]);
}

#[test]
fn grey_pictures_leave_one_channel() {
    let scene = load("Kd 0.5\nmap_Kd grey.png\nKe 1", &[("grey.png", png([90; 3]))]).unwrap();
    assert_eq!(scene.channels(), 1);
    let scene = load("Kd 0.5\nmap_Kd red.png\nKe 1", &[("red.png", png([90, 10, 10]))]).unwrap();
    assert_eq!(scene.channels(), 3);
}

#[test]
fn materials_do_without_pictures_that_cannot_be_had() {
    let without = |lines: &str, files: &[(&str, Vec<u8>)], wanted: &[&str], reflectance: f64| {
        let scene = load(lines, files).unwrap();
        let said = scene.warnings().join("\n");
        wanted.iter().for_each(|word| assert!(said.contains(word), "{word}: {said}"));
        let material = scene.material_of(0);
        assert!(material.textures.all().next().is_none() && !material.emits(), "{lines}");
        assert_eq!(material.reflectance[0], reflectance, "{lines}");
    };
    without("Kd 0.2\nmap_Kd wood.png", &[], &["wood.png", "not there", "remove the line"], 0.2);
    without("map_Kd -s 2 2 2 my wood.png", &[], &["picture my wood.png", "grey 0.5"], 0.5);
    without("map_Kd a.png", &[("a.png", b"no picture".to_vec())], &["cannot be read", "PNG"], 0.5);
    without("map_Kd a.png", &[("a.png", png([9; 3])[..40].to_vec())], &["cannot be read"], 0.5);
    let broken = exr([1.0, f32::NAN, 1.0]);
    without("Kd 0.1\nmap_Ke a.exr", &[("a.exr", broken)], &["column 0, row 0", "NaN", "repair"], 0.1);
    without("map_Ke a.exr", &[("a.exr", exr([-1.0; 3]))], &["not negative"], 0.5);
    let message = load("Kd 0.8\nmap_Kd a.exr", &[("a.exr", exr([1.5; 3]))]).unwrap_err();
    assert!(message.contains("material m") && message.contains("as high as 1.2"), "{message}");
}

#[test]
fn pictures_are_found_by_their_bare_names_in_any_letter_case() {
    for statement in ["Wood.PNG", "D:\\maps\\wood.png", "/maps/wood.png", "maps\\wood.png", "../WOOD.png"] {
        for place in ["wood.png", "Textures/wood.PNG"] {
            let scratch = Scratch::with(&[
                ("a.obj", OBJ.to_owned()),
                ("a.mtl", format!("newmtl m\nKd 1\nmap_Kd {statement}\n")),
            ]);
            std::fs::create_dir_all(scratch.path("Textures")).unwrap();
            scratch.write(place, png([188; 3]));
            let scene = Scene::load(scratch.path("a.obj")).unwrap();
            assert!(scene.has_textures(), "{statement} {place}: {:?}", scene.warnings());
            let said = scene.warnings().join("\n");
            assert!(said.contains("found by name") && said.contains(statement), "{said}");
        }
    }
}

#[test]
fn what_a_picture_cannot_do_is_warned_of() {
    let files = [("a.png", png([200; 3]))];
    let warned = |obj: &str, lines: &str, wanted: &str| {
        let scratch = Scratch::with(&files);
        scratch.write("a.obj", obj);
        scratch.write("a.mtl", format!("newmtl m\n{lines}\n"));
        let scene = Scene::load(scratch.path("a.obj")).unwrap();
        assert!(
            scene.warnings().len() == 1 && scene.warnings()[0].contains(wanted),
            "{:?}",
            scene.warnings()
        );
        scene
    };
    let bare = OBJ.replace("f 1/1 2/2 3/3", "f 1 2 3");
    let scene = warned(&bare, "Kd 0.5\nmap_Kd a.png", "1 face without texture coordinates");
    let mean = scene.reflectance_texture(0).unwrap().at([0.9, 0.1]);
    assert!((mean[0] - 0.577580).abs() < 1e-5, "{mean:?}");
    let some = OBJ.replace("f 1/1 2/2 3/3", "f 1/1 2 3/3");
    warned(&some, "Kd 0.5\nmap_Kd a.png", "unwrap the mesh");
    warned(OBJ, "Kd 0\nmap_Kd a.png", "multiplied by Kd, which is 0");
    warned(OBJ, "Kd 1\nmap_Kd -blendu off -boost 2 a.png", "no notice is taken of -blendu, -boost");
}

#[test]
fn coordinates_are_the_face_corners_own_and_options_move_them() {
    let files = [("a.png", picture_files::png(2, 1, |i, _| if i == 0 { [0; 3] } else { [255; 3] }))];
    // Point [s, t] of the face has coordinates (s, t).
    for (options, point, wanted) in [
        ("", [0.25, 0.1], 0.0),
        ("", [0.75, 0.1], 1.0),
        ("-s 2 1 1", [0.375, 0.1], 1.0),
        ("-o 0.5 0 0", [0.25, 0.1], 1.0),
        ("-clamp on -o 7", [0.0, 0.1], 1.0),
    ] {
        let scene = load(&format!("Kd 1\nmap_Kd {options} a.png"), &files).unwrap();
        assert_eq!(scene.reflectance_texture(0).unwrap().at(point)[0], wanted, "{options}");
    }
}

#[test]
fn one_file_for_two_materials_is_read_once() {
    let scratch = Scratch::with(&[("a.png", png([90; 3]))]);
    scratch.write("a.obj", OBJ.replace("f 1/1", "f 1/1 2/2 3/3\nusemtl n\nf 2/1"));
    scratch.write("a.mtl", "newmtl m\nmap_Kd a.png\nnewmtl n\nKd 0.5\nmap_Kd -s 2 2 2 a.png\n");
    let scene = Scene::load(scratch.path("a.obj")).unwrap();
    let [m, n] = [0, 1].map(|k| scene.materials()[k].textures.reflectance.as_ref().unwrap().pixels.clone());
    assert!(Arc::ptr_eq(&m, &n));
}
