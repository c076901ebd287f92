//! The program: `--sides`, inconsistent winding, scenes without lamps.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;

use super::{data, records};
use crate::program::radiosity;
use crate::scratch::Scratch;

fn senders(records: &[BTreeMap<String, String>]) -> Vec<String> {
    let mut names: Vec<String> = records.iter().map(|record| record["from"].clone()).collect();
    names.dedup();
    names
}

/// A box that is seen from inside, and in it a smaller one seen from outside.
const BOXES: &str = include_str!("../../data/view_factors/box_in_box.obj");

#[test]
fn sides_are_the_front_unless_others_are_asked_for() {
    let scratch = Scratch::with(&[("a.obj", BOXES)]);
    for (sides, expected) in [
        ("", vec!["outer", "inner"]),
        ("--sides front", vec!["outer", "inner"]),
        ("--sides back", vec!["outer (back)", "inner (back)"]),
        ("--sides both", vec!["outer", "inner", "inner (back)"]),
    ] {
        let (records, told) = records(&scratch, &format!("a.obj {sides}"));
        assert_eq!(senders(&records), expected, "{sides}");
        assert!(!told.contains("both sides"), "{told}");
    }
    let refused = radiosity(scratch.folder(), "form-factors a.obj --sides left");
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn where_winding_is_inconsistent_both_sides_are_taken_with_a_warning() {
    // One face of the inner box turned over.
    let lines: Vec<&str> = BOXES.lines().collect();
    let last = lines.last().unwrap().split(' ').collect::<Vec<_>>();
    let turned = format!("f {}", last[1..].iter().rev().copied().collect::<Vec<_>>().join(" "));
    let mixed = lines[..lines.len() - 1].join("\n") + "\n" + &turned + "\n";
    let scratch = Scratch::with(&[("a.obj", mixed)]);
    let (found, told) = records(&scratch, "a.obj");
    assert_eq!(senders(&found), ["outer", "inner", "inner (back)"]);
    assert!(told.contains("both sides of inner") && told.contains("wound"), "{told}");
    // A room inside out: its fronts see nothing.
    let cube = fs::read_to_string(data("cube_inside")).unwrap();
    let turn = |line: &str| match line.strip_prefix("f ") {
        Some(corners) => format!("f {}", corners.split(' ').rev().collect::<Vec<_>>().join(" ")),
        None => line.to_owned(),
    };
    scratch.write("b.obj", cube.lines().map(turn).collect::<Vec<_>>().join("\n"));
    let (found, told) = records(&scratch, "b.obj");
    assert_eq!(senders(&found).len(), 12);
    assert!(told.contains("fronts see nothing"), "{told}");
    let seen: f64 = found
        .iter()
        .filter(|record| record["from"] == "bottom (back)" && record["to"].ends_with("(back)"))
        .map(|record| record["form_factor"].parse::<f64>().unwrap())
        .sum();
    assert!((seen - 1.0).abs() < 1e-9, "{seen}");
}

#[test]
fn plan_and_check_need_no_lamp() {
    for name in ["cube_inside", "far_small", "raystrack_canyon"] {
        let scratch = Scratch::new();
        let file = data(name);
        let plan = radiosity(scratch.folder(), &format!("plan {} --json --patches 500", file.display()));
        let told = String::from_utf8(plan.stderr).unwrap();
        assert!(plan.status.success() && told.contains("no light at all"), "{name}: {told}");
        let plan: Value = serde_json::from_slice(&plan.stdout).unwrap();
        assert!(plan["patches"].as_u64().unwrap() > 100, "{name}");
        let check = radiosity(scratch.folder(), &format!("check {} --json --patches 200", file.display()));
        let told = String::from_utf8(check.stderr).unwrap();
        assert!(check.status.success(), "{name}: {told}");
        let check: Value = serde_json::from_slice(&check.stdout).unwrap();
        let findings = check["findings"].as_array().unwrap();
        assert!(findings.iter().any(|finding| finding["name"] == "closure"), "{name}: {findings:?}");
        // Solving still does.
        let solve = radiosity(scratch.folder(), &format!("solve {}", file.display()));
        assert_eq!(solve.status.code(), Some(1));
        assert!(String::from_utf8(solve.stderr).unwrap().contains("no light at all"));
    }
}
