//! Scene files: what they mean, and how bad ones are refused. A refusal names the file, the line, the face or
//! the material, and what to do; nothing panics.

use std::fs;

use glam::DVec3;
use radiosity::patches::{PatchSize, Patches, Reach, Tessellation};
use radiosity::scene::{FaceState, Scene, SceneError, Surface};
use radiosity::trace::Tracer;
use radiosity::transport::Plan;

use crate::scratch::Scratch;

/// Three vertices, on lines 1 to 3.
const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// One face of material `m` from `a.mtl`.
const TRIANGLE: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";

/// A lamp of material `m`.
const LAMP: &str = "newmtl m\nKd 0.5 0.5 0.5\nKe 1 1 1\n";

/// Loads `a.obj` of a folder with these files.
fn load<C: AsRef<[u8]>>(files: &[(&str, C)]) -> Result<Scene, SceneError> {
    Scene::load(Scratch::with(files).path("a.obj"))
}

#[track_caller]
fn loaded<C: AsRef<[u8]>>(files: &[(&str, C)]) -> Scene {
    load(files).unwrap_or_else(|e| panic!("{e}"))
}

/// The message with which `a.obj` is refused.
#[track_caller]
fn refusal<C: AsRef<[u8]>>(files: &[(&str, C)]) -> String {
    match load(files) {
        Ok(scene) => panic!("{} faces loaded, warnings {:?}", scene.faces().len(), scene.warnings()),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn says(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "{word:?} is missing in: {message}");
    }
}

/// An OBJ text of the three corners and more lines, which begin on line 4.
fn obj(lines: &str) -> [(&'static str, String); 1] {
    [("a.obj", format!("{CORNERS}{lines}"))]
}

/// A triangle whose only material is made of these lines, which begin on line 2.
fn mtl(lines: &str) -> [(&'static str, String); 2] {
    [("a.obj", TRIANGLE.into()), ("a.mtl", format!("newmtl m\n{lines}\n"))]
}

/// A lamp with these settings.
fn toml(text: &str) -> [(&'static str, String); 3] {
    [("a.obj", TRIANGLE.into()), ("a.mtl", LAMP.into()), ("a.toml", text.into())]
}

fn cut<'s>(tracer: &Tracer<'s>, reach: Reach) -> Patches<'s> {
    let size = PatchSize::Count(60);
    Patches::new(tracer, &Tessellation { size, reach, ..Default::default() })
        .expect("a small scene can be cut")
}

/// The faces that have patches.
fn faces_with_patches(scene: &Scene) -> Vec<usize> {
    let tracer = Tracer::new(scene);
    let patches = cut(&tracer, Reach::Light);
    let mut faces: Vec<usize> = (0..patches.len()).map(|i| patches.place(i).face).collect();
    faces.dedup();
    faces
}

// Files that can't be read, or hold no scene.

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

// Vertices and faces.

#[test]
fn refuses_vertices_that_are_not_finite() {
    for vertex in ["v nan 0 0", "v inf 0 0", "v 0 -inf 0", "v 0 0 1e999"] {
        let text = format!("v 0 0 0\n{vertex}\nv 0 1 0\nf 1 2 3\n");
        says(&refusal(&[("a.obj", text)]), &["a.obj:2: ", "3 numbers, none beyond 1e30"]);
    }
}

#[test]
fn refuses_malformed_vertices() {
    for vertex in ["v", "v 1 0", "v 1 zero 0", "v 1,0,0", "v 0x1 0 0"] {
        let text = format!("v 0 0 0\n{vertex}\nv 0 1 0\nf 1 2 3\n");
        says(&refusal(&[("a.obj", text)]), &["a.obj:2: ", "`v`", "3 numbers"]);
    }
}

#[test]
fn a_malformed_weight_or_colour_is_left_out() {
    for vertex in ["v 1 0 0 heavy", "v 1 0 0 0.5 0.5", "v 1 0 0 0.5 0.5 nan"] {
        let scene = loaded(&[("a.obj", format!("v 0 0 0\n{vertex}\nv 0 1 0\nf 1 2 3\n"))]);
        assert_eq!(scene.corners(0), [DVec3::ZERO, DVec3::X, DVec3::Y]);
        says(&scene.warnings()[0], &["1 vertex with more than a place", "line 2", "left out"]);
    }
}

#[test]
fn colours_of_vertices_do_not_matter() {
    for colours in
        [["", "", ""], [" 1 0 0", " 0 1 0", " 0 0 1"], ["", " 0.5 0.5 0.5", ""], [" 1 1 1", "", ""]]
    {
        let [a, b, c] = colours;
        let scene = loaded(&[("a.obj", format!("v 0 0 0{a}\nv 1 0 0{b}\nv 0 1 0{c}\nf 1 2 3\n"))]);
        assert_eq!(scene.corners(0), [DVec3::ZERO, DVec3::X, DVec3::Y]);
    }
}

#[test]
fn weights_of_vertices_have_a_meaning_for_curves_alone() {
    let scene = loaded(&[("a.obj", "v 0 0 0 1\nv 1 0 0 2\nv 0 1 0 0\nf 1 2 3\n")]);
    assert_eq!(scene.corners(0), [DVec3::ZERO, DVec3::X, DVec3::Y]);
}

#[test]
fn comments_may_stand_behind_numbers() {
    let scene = loaded(&[("a.obj", "v 0 0 0 # origin\nv 1 0 0\t#x\nv 0 1 0\nf 1 2 3 # the only one\n")]);
    assert_eq!(scene.corners(0), [DVec3::ZERO, DVec3::X, DVec3::Y]);
}

#[test]
fn faces_may_come_before_their_vertices() {
    let scene = loaded(&[("a.obj", format!("o one\nf 1 2 3\no two\n{CORNERS}f -1 -2 -3\n"))]);
    assert_eq!(scene.corners(0), [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(scene.corners(1), [DVec3::Y, DVec3::X, DVec3::ZERO]);
}

#[test]
fn a_face_has_normals_only_if_all_its_corners_have_one_that_makes_sense() {
    let normals = "vn 0 0 1\nvn 0 0 0\nvn nan 0 1\nvn inf 0 1\n";
    let faces =
        "f 1//1 2//1 3//-4\nf 1 2 3\nf 1//1 2//1 3\nf 1//1 2//2 3//1\nf 1//1 2//1 3//3\nf 1//4 2//1 3//1\n";
    let scene = loaded(&obj(&format!("{normals}{faces}")));
    let smooth: Vec<bool> = scene.faces().iter().map(|face| face.normals.is_some()).collect();
    assert_eq!(smooth, [true, false, false, false, false, false]);
    let given = scene.faces()[0].normals.expect("the first face has normals");
    assert_eq!(given.map(|n| scene.normals()[n as usize]), [DVec3::Z; 3]);
}

#[test]
fn refuses_face_corners_that_do_not_exist() {
    for vertex in ["4", "-4", "0", "99999999999999"] {
        let message = refusal(&obj(&format!("# a face\n\nf 1 2 {vertex}\nf 1 2 3\n")));
        says(&message, &["a.obj:6: ", &format!("vertex {vertex} does not exist; there are 3")]);
    }
}

#[test]
fn texture_coordinates_and_normals_that_do_not_exist_are_done_without() {
    for (corners, what) in [
        ("1/1 2/1 3/2", "1 missing or malformed texture coordinate (vt) (line 6)"),
        ("1//1 2//0 3//2", "2 missing or malformed normals (vn) (the first in line 6)"),
        ("1/1/1 2/x/1 3/-2/1", "2 missing or malformed texture coordinates (vt) (the first in line 6)"),
    ] {
        let scene = loaded(&obj(&format!("vt 0 0\nvn 0 0 1\nf {corners}\n")));
        says(&scene.warnings().join("\n"), &[what]);
        assert_eq!(scene.faces()[0].normals.is_some(), corners.starts_with("1/1/1"));
    }
}

#[test]
fn refuses_words_that_are_no_face_corners() {
    for corner in ["three", "3.0", "/1", "1e0"] {
        says(&refusal(&obj(&format!("f 1 2 {corner}\nf 1 2 3\n"))), &["a.obj:4: ", "corner"]);
    }
}

#[test]
fn faces_of_one_or_two_corners_are_left_out_and_counted() {
    for face in ["f", "f ", "f 1", "f 1 2", "f 1 2 # 3"] {
        let scene = loaded(&obj(&format!("{face}\nf 1 2 3\n{face}")));
        assert_eq!(scene.faces().len(), 1);
        says(&scene.warnings()[0], &["2 faces of one or two corners", "line 4", "left out"]);
    }
}

#[test]
fn all_lines_are_looked_at_before_one_is_refused() {
    let message = refusal(&obj("f 1 2 9\nv nan 0 0\nf 1 2 4\nf one\n"));
    says(&message, &["a.obj:4: vertex 9 does not exist", "(and 2 more such lines)"]);
    // What no face asks for does not matter.
    let scene = loaded(&obj("v nan 0 0\nv 1 one 1\nf 1 2 3\n"));
    says(&scene.warnings()[0], &["2 malformed vertices that no face uses (the first in line 4)"]);
}

#[test]
fn points_and_lines_are_no_faces() {
    let scene = loaded(&obj("p 1\nl 1 2\nl 1 2 3\nf 1 2 3\n"));
    assert_eq!(scene.faces().len(), 1);
}

#[test]
fn negative_corners_count_back_from_their_line() {
    let scene = loaded(&obj("f -3 -2 -1\nv 9 9 9\nf 1 2 -1\n"));
    assert_eq!(scene.corners(0), [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(scene.corners(1), [DVec3::ZERO, DVec3::X, DVec3::splat(9.0)]);
}

#[test]
fn polygons_become_fans_in_file_order() {
    let pentagon = "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 1\n";
    let scene = loaded(&[("a.obj", format!("{pentagon}f 1 2 6\nf 1 2 3 4 5\nf 1 2 3 4\n"))]);
    let corners: Vec<[DVec3; 3]> = (0..scene.faces().len()).map(|face| scene.corners(face)).collect();
    let [a, b, c, d, e] =
        [[0, 0], [1, 0], [2, 1], [1, 2], [0, 2]].map(|[x, y]| DVec3::new(x as f64, y as f64, 0.0));
    assert_eq!(corners, [[a, b, DVec3::Z], [a, b, c], [a, c, d], [a, d, e], [a, b, c], [a, c, d]]);
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

// Materials.

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
fn refuses_numbers_that_no_scene_can_have_by_file_and_line() {
    for (line, blame) in [
        ("Ke 0 inf 0", "Ke is inf"),
        ("Kd 0 0 nan", "Kd is NaN"),
        ("Ke 1e999", "Ke is inf"),
        ("Ke 1e31", "Ke is 10000000000000000000000000000000"),
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

#[test]
fn plastic_is_told_from_what_exporters_write_everywhere() {
    let on = |lines: &str| -> Vec<&str> {
        let plan = Plan::new(&loaded(&mtl(&format!("Kd 0.5\n{lines}"))));
        plan.effects.iter().filter(|e| e.on && e.reason == "m").map(|e| e.effect).collect()
    };
    for lines in ["Pr 0.3", "Pm 0.2", "illum 5\nNs 100"] {
        assert_eq!(on(lines), ["plastic"], "{lines:?}");
    }
    for lines in ["illum 0", "illum 1\nKs 0.9", "illum 2\nKs 1 1 1\nNs 90"] {
        assert_eq!(on(lines), [""; 0], "{lines:?}: exporters write a meaningless Ks everywhere");
    }
}

#[test]
fn mirrors_and_glass_are_recognised_by_their_illumination_model() {
    let surface = |lines: &str| {
        let scene = loaded(&mtl(lines));
        (scene.materials()[0].surface.clone(), scene.warnings().len())
    };
    let mirror = |r: f64| Surface::Mirror { reflectance: vec![r] };
    let glass = |index: f64, t: f64| Surface::Dielectric { index, filter: vec![t] };
    assert_eq!(surface("illum 3\nKs 0.9"), (mirror(0.9), 0));
    assert_eq!(surface("illum 3"), (mirror(1.0), 1));
    assert_eq!(surface("illum 3\nKs 0.9\nKd 0.5"), (mirror(0.9), 1));
    for model in [4, 6, 7, 9] {
        // A lone triangle of glass has no inside either.
        assert_eq!(surface(&format!("illum {model}\nNi 1.33\nTf 0.8")), (glass(1.33, 0.8), 1));
        assert_eq!(surface(&format!("illum {model}")), (glass(1.5, 1.0), 2));
    }
    assert_eq!(surface("illum 3\nKs 0.9\nKd 0.5\nKe 1"), (Surface::Diffuse, 1));
}

#[test]
fn metals_are_recognised_by_their_metalness_or_their_highlight_without_a_base() {
    let metal = |lines: &str| {
        let scene = loaded(&mtl(lines));
        match scene.materials()[0].surface.clone() {
            Surface::Conductor { reflectance, roughness } => {
                (reflectance[0], (1000.0 * roughness).round() / 1000.0, scene.warnings().len())
            }
            other => panic!("{lines}: {other:?}"),
        }
    };
    assert_eq!(metal("Kd 0.8\nPm 1\nPr 0.4"), (0.8, 0.4, 0));
    assert_eq!(metal("Kd 0.8\nPm 0.6\nPr 0.4"), (0.8, 0.4, 1));
    assert_eq!(metal("Pm 1"), (1.0, 0.3, 2));
    // α² = 2/(Ns + 2) is 0.02.
    assert_eq!(metal("Ks 0.9\nNs 98\nillum 5"), (0.9, 0.376, 0));
    assert_eq!(metal("Kd 0\nKs 0.9\nNs 98\nPr 0.2\nillum 5"), (0.9, 0.2, 0));
    let lamp = loaded(&mtl("Kd 0.5\nKe 1\nPm 1\nPr 0.3"));
    assert_eq!((lamp.materials()[0].surface.clone(), lamp.warnings().len()), (Surface::Diffuse, 1));
}

#[test]
fn refuses_mirrors_and_glass_that_cannot_be() {
    for (lines, words) in [
        ("illum 4\nNi 0", ["material m", "index of refraction 0", "1.5"]),
        ("illum 4\nNi 1.5\nTf 1.2", ["material m", "filter 1.2", "between 0 and 1"]),
        ("illum 3\nKs 1.5", ["material m", "mirror reflectance 1.5", "between 0 and 1"]),
        ("illum 5\nKs 1.5", ["material m", "reflectance 1.5 of a metal", "between 0 and 1"]),
    ] {
        says(&refusal(&mtl(lines)), &words);
    }
}

#[test]
fn glass_without_an_inside_is_named_with_what_to_do() {
    let tetrahedron = |faces: &str| {
        let text = format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl pane\n{faces}");
        let scene = loaded(&[("a.obj", text.as_str()), ("a.mtl", "newmtl pane\nillum 4\nNi 1.5\n")]);
        scene.warnings().join("\n")
    };
    assert_eq!(tetrahedron("f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"), "");
    says(&tetrahedron("f 1 3 2\nf 1 2 4\nf 1 4 3\n"), &["material pane", "no inside", "close the mesh"]);
    says(&tetrahedron("f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 4 3\n"), &["material pane", "no inside"]);
    says(&tetrahedron("f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"), &["material pane", "inside out", "flip"]);
}

// White space and names.

#[test]
fn line_endings_of_either_kind_mean_the_same() {
    let scene = Scene::cornell_box();
    let crlf = |text: &str| text.replace('\n', "\r\n");
    let files = [
        ("a.obj", crlf(include_str!("../../meshes/cornell_box.obj")).replace("cornell_box.mtl", "a.mtl")),
        ("a.mtl", crlf(include_str!("../../meshes/cornell_box.mtl"))),
        ("a.toml", crlf(include_str!("../../meshes/cornell_box.toml"))),
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

// Settings beside the scene.

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
fn refuses_settings_that_are_no_text() {
    let bytes = [0u8, 1, 0xff, b'=', 0xfe];
    let files = [("a.obj", TRIANGLE.as_bytes()), ("a.mtl", LAMP.as_bytes()), ("a.toml", &bytes)];
    says(&refusal(&files), &["a.toml:1: "]);
}

#[test]
fn says_how_a_colour_is_written() {
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
fn settings_may_be_empty() {
    let scene = loaded(&toml("# nothing\n"));
    assert_eq!((scene.corners(0)[1], scene.camera()), (DVec3::X, None));
}

// Anything at all.

#[test]
fn huge_and_tiny_scenes_are_cut_like_any_other() {
    let text = include_str!("../../meshes/cornell_box.obj").replace("cornell_box.mtl", "a.mtl");
    let patches_of = |unit: &str| {
        let library = include_str!("../../meshes/cornell_box.mtl");
        let scene =
            loaded(&[("a.obj", text.as_str()), ("a.mtl", library), ("a.toml", &format!("unit = {unit}\n"))]);
        let tracer = Tracer::new(&scene);
        cut(&tracer, Reach::Light).len()
    };
    let ordinary = patches_of("1.0");
    for unit in ["1e27", "1e-30"] {
        assert_eq!(patches_of(unit), ordinary, "unit {unit}");
    }
}

#[test]
fn where_nothing_is_reached_nothing_is_cut_ever_finer() {
    // A lone sliver, so that even the finest cut ends soon.
    let sliver = loaded(&[("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1e-5 0\nf 1 2 3\n")]);
    let tracer = Tracer::new(&sliver);
    for reach in [Reach::Light, Reach::Everything] {
        let patches = cut(&tracer, reach);
        assert!(patches.is_empty(), "{reach:?}");
        assert!(patches.edge() > 1e-3, "{reach:?}: cut into legs of {} m for 60 patches", patches.edge());
    }
}

#[test]
fn coordinates_of_any_size_never_panic() {
    for far in ["1e30", "-1e30", "1e-30", "1e154", "1e200", "1.7e308", "1e-160", "1e-200", "5e-324"] {
        for corner in ["X 0 0", "X X X", "0 X 0", "X 1 0"] {
            for others in
                ["v 0 0 0\nv 0 0 1\n", "v 0 0 0\nv 0 0 X\n", "v 1 X 1\nv 2 X 2\n", "v -X -X 0\nv -X X 0\n"]
            {
                let text = format!(
                    "mtllib a.mtl\nv {corner}\n{others}v 0 1 0\nv 1 0 0\nusemtl m\nf 1 2 3 4\nf 2 4 5\n"
                );
                survives(text.replace('X', far).replace("--", ""), LAMP, "");
            }
        }
    }
}

#[test]
fn three_hundred_damaged_scenes_never_panic() {
    let [scene, library, settings] = [
        include_str!("../../meshes/cornell_box.obj"),
        include_str!("../../meshes/cornell_box.mtl"),
        include_str!("../../meshes/cornell_box.toml"),
    ];
    let scene = scene.replace("cornell_box.mtl", "a.mtl");
    let mut refused = 0;
    for seed in 0..300 {
        let damaged = damage(seed, scene.as_bytes());
        refused += usize::from(!survives(damaged, library, settings));
        // Libraries and settings are short: one hit in three runs each.
        match seed % 3 {
            0 => survives(&scene, damage(seed, library.as_bytes()), settings),
            1 => survives(&scene, library, damage(seed, settings.as_bytes())),
            _ => true,
        };
    }
    assert!(
        (30..=270).contains(&refused),
        "{refused} of 300 refused: the damage is too great or too small to tell"
    );
}

/// Loads a scene and cuts it if it has light; whether it loads is the answer, a panic fails the test.
fn survives(scene: impl AsRef<[u8]>, library: impl AsRef<[u8]>, settings: impl AsRef<[u8]>) -> bool {
    let files = [("a.obj", scene.as_ref()), ("a.mtl", library.as_ref()), ("a.toml", settings.as_ref())];
    let Ok(scene) = load(&files) else { return false };
    if scene.require_light().is_ok() {
        let tracer = Tracer::new(&scene);
        let size = PatchSize::Count(60);
        if let Ok(patches) = Patches::new(&tracer, &Tessellation { size, ..Default::default() }) {
            let faces = (0..patches.len()).map(|i| &scene.faces()[patches.place(i).face]);
            assert!(faces.into_iter().all(|face| face.state == FaceState::Kept));
        }
    }
    true
}

/// Deletes, doubles or alters a few stretches of bytes.
fn damage(seed: u64, bytes: &[u8]) -> Vec<u8> {
    const WORDS: [&str; 12] = [
        "nan",
        "-1",
        "0",
        "1e300",
        "1e-300",
        "\n",
        " ",
        "f 1 2 3\n",
        "//",
        "99999999999999999999",
        "\u{feff}",
        "#",
    ];
    let mut bytes = bytes.to_vec();
    let mut random = Random(seed);
    for _ in 0..1 + seed % 4 {
        let start = random.below(bytes.len());
        let end = (start + 1 + random.below(12)).min(bytes.len());
        match random.below(4) {
            0 => drop(bytes.drain(start..end)),
            1 => bytes.splice(start..start, bytes[start..end].to_vec()).for_each(drop),
            2 => bytes[start] = random.below(256) as u8,
            _ => bytes.splice(start..start, WORDS[random.below(WORDS.len())].bytes()).for_each(drop),
        }
    }
    bytes
}

/// SplitMix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}
