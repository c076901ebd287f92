//! The program: what it writes, what it prints, and what it answers when something is wrong.

mod compare; // the comparison with light paths
mod effects; // the option --effects
mod form_factors; // among coloured mirrors
mod leftovers; // what a run leaves alone, done or failed
#[cfg(target_os = "linux")]
mod memory; // confined to little: too many patches, and a small lamp
mod pictures; // render, shadings, warnings of black
mod plan; // what it tells, and that it leaves no trace
mod printing; // standard output and error, --json, --quiet
mod refusals; // statuses and messages
mod results; // the files of solve, the same bytes for the same seed
mod solvers; // every solver, either basis, trapped light
mod study; // accuracy against time, resumed
mod summary; // the keys that scripts rely on
mod tables; // columns, and what holds from row to row
mod verdict; // how far answers can be relied on

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::program::{radiosity, text};

/// Settings that make a run short.
const SMALL: [&str; 6] = ["--patches", "200", "--rays", "64", "--size", "80x60"];

/// What `solve` writes.
const RESULTS: [&str; 5] = ["faces.csv", "image.png", "mesh.ply", "patches.csv", "solution.json"];

const FACES: &str = "face,side,object,material,area,irradiance_r,irradiance_g,irradiance_b,radiance_r,radiance_g,radiance_b,error_r,error_g,error_b,polygon";

/// Names that stages may have.
const STAGES: [&str; 10] =
    ["load", "build", "patch", "trace", "balance", "factor", "solve", "series", "render", "write"];

/// A closed cube seen from inside; its last wall is of material `last`, the others of material `wall`.
const CUBE: &str = "mtllib cube.mtl
v 0 0 0\nv 0 1 0\nv 0 1 1\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 1 1 0\nv 1 0 0
o cube\nusemtl wall
f 1 2 3 4\nf 5 6 7 8\nf 1 4 5 8\nf 3 2 7 6\nf 8 7 2 1\nusemtl last\nf 4 3 6 5\n";

/// A short run that must succeed.
#[track_caller]
fn done(folder: &Path, arguments: &str) -> Output {
    let output = radiosity(folder, &format!("{arguments} {}", SMALL.join(" ")));
    assert!(output.status.success(), "{arguments}: {:?} {}", output.status, text(&output.stderr));
    output
}

/// The message of a run that must fail with this status.
#[track_caller]
fn refused(folder: &Path, arguments: &str, status: i32) -> String {
    let output = radiosity(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments}: {message}");
    assert_eq!(text(&output.stdout), "", "{arguments}");
    assert!(!message.contains("panicked"), "{arguments}: {message}");
    if status == 1 {
        assert_eq!(
            (message.lines().count(), message.starts_with("error: ")),
            (1, true),
            "{arguments}: {message}"
        );
    }
    message.to_owned()
}

/// The header of a table, and its rows by column.
fn table(path: &Path) -> (String, Vec<BTreeMap<String, String>>) {
    let content = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let rows = csv::Reader::from_reader(content.as_bytes()).into_deserialize();
    (content.lines().next().unwrap_or_default().to_owned(), rows.map(|row| row.expect("a row")).collect())
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {:?} is no number", row[column]))
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("a file")).expect("JSON")
}
