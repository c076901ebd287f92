//! What the program prints, and where.

use std::process::Stdio;

use serde_json::Value;

use super::{CUBE, SMALL, done, json, refused};
use crate::program::{radiosity, text};
use crate::scratch::{Scratch, names};

#[test]
fn json_is_all_there_is_on_standard_output() {
    let scratch = Scratch::new();
    let output = done(scratch.folder(), "solve -o . --json");
    let printed: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    let mut written = json(&scratch.path("solution.json"));
    written["stages"] = printed["stages"].clone();
    assert_eq!(printed, written);
    let output = done(scratch.folder(), "render -o . --json --quiet");
    let printed: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert_eq!((&printed["scene"], &printed["files"][0]), (&"cornell_box".into(), &"image.png".into()));
    assert_eq!(text(&output.stderr), "");
}

#[test]
fn an_accuracy_in_lux_is_answered_in_lux() {
    let scratch = Scratch::new();
    for (goal, unit) in [("60lx", "lx"), ("0.1W/m2", "W/m²")] {
        let output = radiosity(scratch.folder(), &format!("solve -o . --size 8x6 --accuracy {goal}"));
        let told = text(&output.stdout);
        let line =
            told.lines().find(|line| line.starts_with("accuracy ")).unwrap_or_else(|| panic!("{told}"));
        let number = |before: &str| {
            let after = line.split(before).nth(1).expect("a number follows").trim_start();
            after.split(' ').next().unwrap().parse::<f64>().expect("a number")
        };
        assert!(line.ends_with(unit) && number("±") <= number("asked for:"), "{line}");
    }
}

#[test]
fn quiet_prints_nothing() {
    // A scene without materials would warn.
    let scratch = Scratch::with(&[("cube.obj", CUBE), ("cube.mtl", "newmtl wall\nKd 0.5\nKe 1\nPr 0.3\n")]);
    for command in ["solve", "render"] {
        let output = done(scratch.folder(), &format!("{command} cube.obj -o . --quiet"));
        assert_eq!((text(&output.stdout), text(&output.stderr)), ("", ""), "{command}");
        let output = done(scratch.folder(), &format!("{command} cube.obj -o ."));
        assert!(!output.stdout.is_empty());
        let warnings = text(&output.stderr);
        assert!(warnings.lines().all(|line| line.starts_with("warning: ")), "{warnings}");
        assert!(warnings.contains("grey 0.5") && warnings.contains("plastic"), "{warnings}");
    }
}

#[test]
fn quiet_still_prints_errors() {
    let scratch = Scratch::new();
    let message = refused(scratch.folder(), "solve none.obj --quiet", 1);
    assert!(message.contains("none.obj"), "{message}");
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let scratch = Scratch::new();
    for arguments in ["solve -o .", "solve -o . --json", "render -o ."] {
        let mut run = std::process::Command::new(assert_cmd::cargo::cargo_bin!("radiosity"))
            .current_dir(scratch.folder())
            .args(arguments.split_whitespace().chain(SMALL))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs");
        drop(run.stdout.take());
        let output = run.wait_with_output().expect("the program ends");
        assert!(!text(&output.stderr).contains("panicked"), "{arguments}: {}", text(&output.stderr));
        assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments}: {:?}", output.status);
    }
}

#[test]
fn help_and_version_are_no_errors() {
    let scratch = Scratch::new();
    for arguments in ["--help", "--version", "help solve", "solve --help", "render --help"] {
        let output = radiosity(scratch.folder(), arguments);
        assert!(output.status.success() && !output.stdout.is_empty(), "{arguments}");
    }
    assert!(names(scratch.folder()).is_empty());
}
