//! What commands say of how far their answers can be relied on.

use serde_json::Value;

use super::{CUBE, done};
use crate::program::{radiosity, text};
use crate::scratch::Scratch;

/// The cube with a lamp that is there twice.
fn doubled_lamp() -> Scratch {
    let lamp = "v 0.4 0.5 0.4\nv 0.6 0.5 0.4\nv 0.6 0.5 0.6\nv 0.4 0.5 0.6\n\
                usemtl lamp\no one\nf 9 10 11 12\no two\nf 10 11 12 9\n";
    let mtl = "newmtl wall\nKd .5 .5 .5\nnewmtl last\nKd .5 .5 .5\nnewmtl lamp\nKd 0 0 0\nKe 5 5 5\n";
    let obj = format!("{CUBE}{lamp}");
    Scratch::with(&[("cube.obj", obj.as_str()), ("cube.mtl", mtl)])
}

#[test]
fn doubtful_answers_are_named_in_a_line_and_end_well() {
    let scratch = doubled_lamp();
    let commands = ["solve cube.obj", "render cube.obj", "compare cube.obj --paths 20000 --samples 1"];
    for command in commands {
        let output = done(scratch.folder(), &format!("{command} -o out --strict --json"));
        let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON on standard output");
        let verdict = &summary["verdict"];
        assert_eq!(verdict["level"], "doubtful", "{command}: {verdict:#}");
        let reason = &verdict["reasons"][0];
        assert_eq!((&reason["cause"], &reason["level"]), (&"missing_lamps".into(), &"doubtful".into()));
        assert_eq!(reason["objects"], serde_json::json!(["two"]), "{command}: {verdict:#}");
        assert!(reason["faces"].as_array().is_some_and(|faces| faces.len() == 2));
        assert!(reason["power_share"].as_f64().is_some_and(|share| share > 0.05));
        assert!(reason["remedy"].as_str().is_some_and(|remedy| !remedy.is_empty()));
        let told = text(&output.stderr).lines().find(|line| line.contains("missing lamps")).expect("a line");
        assert!(told.starts_with("warning: doubtful answer: missing lamps: "), "{told}");
    }
    let said = done(scratch.folder(), "solve cube.obj -o out");
    assert!(text(&said.stdout).contains("verdict       doubtful: missing lamps"), "{}", text(&said.stdout));
}

#[test]
fn the_accuracy_asked_for_is_not_reached_by_a_doubtful_answer() {
    let scratch = doubled_lamp();
    let output = radiosity(scratch.folder(), "solve cube.obj -o out --accuracy 20% --size 8x6");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let wanted =
        "warning: the accuracy that was asked for is not reached: the verdict on the best answer is doubtful";
    assert!(text(&output.stderr).contains(wanted), "{}", text(&output.stderr));
}

#[test]
fn good_answers_have_no_reasons_and_truncated_ones_say_so() {
    let scratch = Scratch::new();
    for (arguments, level, cause) in [
        ("solve", "good", None),
        ("solve --basis linear", "good", None),
        ("solve --effects=-interreflection", "good", None),
        ("solve --solver neumann --order 1", "truncated", Some("truncation")),
        ("solve --solver neumann --order 0 --tolerance 0", "truncated", Some("truncation")),
    ] {
        let output = done(scratch.folder(), &format!("{arguments} -o . --json"));
        let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON on standard output");
        let verdict = &summary["verdict"];
        assert_eq!(verdict["level"], level, "{arguments}: {verdict:#}");
        let reasons = verdict["reasons"].as_array().expect("reasons");
        let causes: Vec<&str> = reasons.iter().filter_map(|reason| reason["cause"].as_str()).collect();
        assert_eq!(causes, Vec::from_iter(cause), "{arguments}: {verdict:#}");
    }
}
