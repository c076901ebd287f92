//! The command `check`: its table, its JSON, its status.

use std::process::Output;

use serde_json::Value;

use super::OPERATOR;
use crate::program::{radiosity, text};
use crate::scratch::{Scratch, names};

/// A closed cube with a lamp for a ceiling, whose ceiling is lifted by this much.
fn cube(lifted: f64) -> Scratch {
    let high = 1.0 + lifted;
    let obj = format!(
        "mtllib cube.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n\
         v 0 {high} 0\nv 1 {high} 0\nv 1 {high} 1\nv 0 {high} 1\nusemtl wall\n\
         f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nusemtl lamp\nf 12 11 10 9\n"
    );
    let mtl = "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0.5 0.5 0.5\nKe 1 1 1\n";
    // The ceiling's front must face down, and the floor's up.
    Scratch::with(&[("cube.obj", obj.replace("f 12 11 10 9", "f 9 10 11 12")), ("cube.mtl", mtl.into())])
}

fn run(scratch: &Scratch, arguments: &str) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = radiosity(scratch.folder(), arguments);
    (status.code(), text(&stdout).to_owned(), text(&stderr).to_owned())
}

#[test]
fn the_command_prints_a_table_answers_with_its_status_and_writes_nothing() {
    for (lifted, status, last) in [(0.0, 0, "good"), (0.005, 1, "bad: leaks")] {
        let scratch = cube(lifted);
        let (code, out, err) = run(&scratch, "check cube.obj --patches 200");
        assert_eq!((code, err.as_str()), (Some(status), ""), "{out}");
        for name in ["open edges", "winding", "lamps", "leaks"].iter().chain(&OPERATOR) {
            let line = out.lines().find(|line| line.trim_start().starts_with(name));
            assert!(
                line.is_some_and(|line| ["good", "note", "bad"].iter().any(|v| line.contains(v))),
                "{name}: {out}"
            );
        }
        assert_eq!(out.lines().last(), Some(last), "{out}");
        assert_eq!(names(scratch.folder()), ["cube.mtl", "cube.obj"]);
        assert_eq!(
            run(&scratch, "check cube.obj --patches 200 --quiet"),
            (Some(status), "".into(), "".into())
        );
    }
}

#[test]
fn where_there_is_no_light_to_follow_leaks_are_not_measured() {
    let scratch = Scratch::with(&[("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]);
    let (code, out, _) = run(&scratch, "check one.obj");
    assert!(code == Some(0) && out.contains("one: 1 face, 0 patches"), "{out}");
    let leaks = out.lines().find(|line| line.trim_start().starts_with("leaks")).expect("a line on leaks");
    assert!(leaks.contains("note  not measured") && out.contains("no light to follow"), "{out}");
    let (_, out, _) = run(&scratch, "check one.obj --json");
    let all: Value = serde_json::from_str(&out).unwrap();
    let leaks = all["findings"].as_array().unwrap().iter().find(|finding| finding["name"] == "leaks");
    assert!(leaks.is_some_and(|leaks| leaks["value"].is_null()), "{out}");
}

#[test]
fn the_command_prints_json_alone() {
    for (lifted, status, verdict) in [(0.0, 0, "good"), (0.005, 1, "bad")] {
        let (code, out, _) = run(&cube(lifted), "check cube.obj --patches 200 --json");
        let all: Value = serde_json::from_str(&out).unwrap();
        assert_eq!((code, &all["scene"], &all["verdict"]), (Some(status), &"cube".into(), &verdict.into()));
        let findings = all["findings"].as_array().unwrap();
        assert_eq!(findings.len(), 19);
        for finding in findings {
            assert!(finding["name"].is_string() && finding["value"].is_number(), "{finding}");
            assert!(finding["where"].as_array().is_some_and(|faces| faces.len() <= 10), "{finding}");
            assert_eq!(finding["remedy"].is_null(), finding["verdict"] == "good", "{finding}");
        }
    }
}

#[test]
fn the_command_needs_no_light_but_a_scene() {
    let scratch = cube(0.0);
    scratch.write("cube.mtl", "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0.5 0.5 0.5\n");
    let (code, out, _) = run(&scratch, "check cube.obj --patches 200");
    assert_eq!(code, Some(0));
    assert!(out.contains("nothing emits"), "{out}");
    let (code, out, err) = run(&scratch, "check nowhere.obj");
    assert_eq!((code, out.as_str()), (Some(1), ""));
    assert!(err.starts_with("error: ") && err.contains("nowhere.obj"), "{err}");
    assert_eq!(run(&scratch, "check cube.obj --out somewhere").0, Some(2));
}
