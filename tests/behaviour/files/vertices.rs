//! Lines of vertices: their three numbers, and what may stand behind them.

use glam::DVec3;

use super::{loaded, refusal, says};

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
