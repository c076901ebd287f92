//! Lines of faces: which corners they name, and how polygons become triangles.

use glam::DVec3;

use super::{CORNERS, loaded, obj, refusal, says};

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
