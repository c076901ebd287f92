//! The program's comparison with light paths: its files, its verdict, and what it refuses.

use std::fs;

use serde_json::Value;

use super::{CUBE, done, refused};
use crate::scratch::{Scratch, names};

/// The columns of `comparison.csv`.
const COMPARISON: &str = "patch,face,side,area,direct_r,direct_g,direct_b,reference_r,reference_g,reference_b,error_r,error_g,error_b,\
                          mesh_r,mesh_g,mesh_b,paths";

#[test]
fn compare_writes_its_five_files_and_a_verdict() {
    let scratch = Scratch::new();
    let output = done(scratch.folder(), "compare -o . --paths 20000 --samples 1 --tolerance 1e-3 --json");
    let files = ["bounces.png", "comparison.csv", "comparison.json", "comparison.png", "orders.svg"];
    assert_eq!(names(scratch.folder()), files);
    let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON on standard output");
    let file: Value = serde_json::from_slice(&fs::read(scratch.path("comparison.json")).unwrap()).unwrap();
    assert_eq!(summary, file);
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} is a number"));
    let orders = summary["orders"].as_array().expect("orders");
    for (k, order) in orders.iter().enumerate() {
        assert_eq!(order["order"], k);
        for key in ["vs_direct", "vs_reference", "uncertainty", "seconds"] {
            assert!(number(&order[key]) >= 0.0, "{key}");
        }
        assert!(order["bound"].is_null() || number(&order["bound"]) >= number(&order["vs_direct"]));
    }
    assert!(number(&orders[orders.len() - 1]["bound"]) <= 1e-3);
    let direct = &summary["direct"];
    for key in ["vs_reference", "mesh_error", "z_rms", "seconds"] {
        assert!(number(&direct[key]) > 0.0, "{key}");
    }
    let verdict = direct["verdict"].as_str().expect("a verdict");
    assert!(verdict == "agrees within noise" || verdict.ends_with("which the mesh explains"), "{verdict}");
    let reference = &summary["reference"];
    assert!(number(&reference["paths"]) >= 15_000.0 && number(&reference["standard_error"]) > 0.0);
    let table = fs::read_to_string(scratch.path("comparison.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some(COMPARISON));
    assert_eq!(lines.count(), summary["patches"].as_u64().unwrap() as usize);
    let svg = fs::read_to_string(scratch.path("orders.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("guaranteed"));
}

#[test]
fn compare_refuses_budgets_that_make_no_sense_and_scenes_without_light() {
    let scratch = Scratch::with(&[("cube.obj", CUBE), ("cube.mtl", "newmtl wall\nnewmtl last\n")]);
    for (arguments, named) in [
        ("compare --paths 0", "--paths"),
        ("compare --seconds 0", "--seconds"),
        ("compare --standard-error 0", "--standard-error"),
        ("compare --standard-error 120%", "--standard-error"),
        ("compare --samples 0", "--samples"),
    ] {
        assert!(refused(scratch.folder(), arguments, 2).contains(named), "{arguments}");
    }
    let message = refused(scratch.folder(), "compare cube.obj", 1);
    assert!(message.contains("light") || message.contains("emit"), "{message}");
}
