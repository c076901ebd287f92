//! The program's study of accuracy against time: its files, how it resumes, and what it refuses.

use std::fs;

use serde_json::Value;

use super::{CUBE, number, refused, table};
use crate::program::{radiosity, text};
use crate::scratch::{Scratch, names};

/// The columns of `study.csv`.
const STUDY: &str = "patches,rays,solver,order,seconds,bytes,error,error_se,bias,leak,solve_seconds,iterations,repeats,asked,study";

const FILES: [&str; 5] = ["knobs.svg", "study.csv", "study.md", "study.svg", "study_reference.csv"];

#[test]
fn study_writes_its_five_files_that_agree_and_resumes_from_them() {
    let scratch = Scratch::new();
    let output =
        radiosity(scratch.folder(), "study -o . --patches 60,120,240 --rays 16 --time 1h --noise 1%");
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(names(scratch.folder()), FILES);
    let before = fs::read_to_string(scratch.path("study.csv")).unwrap();

    let again = "study -o . --patches 60,120,240 --rays 16,32 --time 60min --noise 1% --json";
    let output = radiosity(scratch.folder(), again);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let (header, rows) = table(&scratch.path("study.csv"));
    assert_eq!(header, STUDY);
    let after = fs::read_to_string(scratch.path("study.csv")).unwrap();
    assert!(after.starts_with(&before) && after.len() > before.len(), "old rows stay as they were");

    let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON on standard output");
    assert_eq!(summary["taken_over"], before.lines().count() - 1);
    let told = summary["rows"].as_array().expect("rows");
    assert_eq!(told.len(), rows.len());
    for (row, told) in rows.iter().zip(told) {
        for column in ["patches", "rays", "seconds", "bytes", "error", "error_se", "repeats"] {
            // JSON is read to the last bit but one.
            let [a, b] = [told[column].as_f64().unwrap(), number(row, column)];
            assert!((a - b).abs() <= 1e-15 * b.abs(), "{column}: {a} {b}");
        }
        assert_eq!(told["solver"], row["solver"].as_str());
        assert!(number(row, "seconds") > 0.0 && number(row, "error") >= 0.0 && number(row, "repeats") >= 2.0);
        assert_eq!(row["order"].is_empty(), row["solver"] != "neumann");
    }
    for solver in ["direct", "cg", "neumann", "paths"] {
        assert!(rows.iter().any(|row| row["solver"] == solver), "{solver}");
    }
    let report = fs::read_to_string(scratch.path("study.md")).unwrap();
    for target in summary["conclusions"]["targets"].as_array().expect("targets") {
        // Every setting the report names is the quickest that is good enough.
        let row = &told[target["row"].as_u64().unwrap() as usize];
        let [accuracy, error] = [&target["accuracy"], &row["error"]].map(|value| value.as_f64().unwrap());
        assert!(error <= accuracy);
        assert!(report.contains(&format!("{} patches × {} rays", row["patches"], row["rays"])));
    }
    for word in ["study.svg", "knobs.svg", "light paths", "noise", "rows are from an earlier run"] {
        assert!(report.contains(word), "{word}: {report}");
    }
    for file in ["study.svg", "knobs.svg"] {
        let svg = fs::read_to_string(scratch.path(file)).unwrap();
        assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"), "{file}");
    }
    let svg = fs::read_to_string(scratch.path("study.svg")).unwrap();
    for word in
        ["noise of the reference", "path tracer", "nothing both quicker and better", "order 1", "16 rays"]
    {
        assert!(svg.contains(word), "{word}");
    }
}

#[test]
fn study_with_too_little_time_does_what_it_can_and_says_what_would_do() {
    let scratch = Scratch::new();
    let output = radiosity(scratch.folder(), "study -o . --time 0.1s");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let message = text(&output.stderr);
    assert!(message.contains("fitted into") && message.contains("--time"), "{message}");
    let (_, rows) = table(&scratch.path("study.csv"));
    assert!(rows.iter().any(|row| row["solver"] == "cg"));
    let report = fs::read_to_string(scratch.path("study.md")).unwrap();
    assert!(report.contains("Left out for lack of time"), "{report}");
}

#[test]
fn study_refuses_what_makes_no_sense_and_scenes_without_light() {
    let scratch = Scratch::with(&[("cube.obj", CUBE), ("cube.mtl", "newmtl wall\nnewmtl last\n")]);
    for (arguments, named) in [
        ("study --time 0", "--time"),
        ("study --time soon", "--time"),
        ("study --noise 0", "--noise"),
        ("study --patches 100", "--rays"),
        ("study --rays 16", "--patches"),
        ("study --patches 100 --rays 4", "--rays"),
        ("study --patches 0 --rays 16", "--patches"),
    ] {
        assert!(refused(scratch.folder(), arguments, 2).contains(named), "{arguments}");
    }
    let message = refused(scratch.folder(), "study cube.obj", 1);
    assert!(message.contains("light") || message.contains("emit"), "{message}");
    assert_eq!(names(scratch.folder()), ["cube.mtl", "cube.obj"]);
}
