//! The plan command: what it tells, and that it leaves no trace.

use serde_json::Value;

use super::{SMALL, STAGES, done, json};
use crate::program::{radiosity, text};
use crate::scratch::{Scratch, names};

#[test]
fn plan_tells_of_every_effect_and_stage_and_writes_nothing() {
    let scratch = Scratch::new();
    let output = radiosity(scratch.folder(), "plan --json --patches 3000 --rays 100");
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(names(scratch.folder()), [""; 0]);
    let plan: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(
        (&plan["scene"], &plan["rays"], &plan["channels"]),
        (&"cornell_box".into(), &104.into(), &3.into())
    );
    let about = plan["patches"].as_u64().expect("a number");
    assert!((2400..=3600).contains(&about), "{about} patches of 3000");
    for entry in plan["plan"].as_array().expect("a list") {
        let keys: Vec<&str> = entry.as_object().expect("an entry").keys().map(String::as_str).collect();
        assert_eq!(keys.len(), 6, "{keys:?}");
        for key in ["effect", "on", "reason", "rays", "seconds", "bytes"] {
            assert!(keys.contains(&key), "{keys:?}");
        }
    }
    let stages: Vec<&str> = plan["stages"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|s| s["name"].as_str().expect("a name"))
        .collect();
    assert!(stages.iter().all(|name| STAGES.contains(name)), "{stages:?}");
    assert!(plan["total"]["seconds"].as_f64().is_some_and(|s| s > 0.0));

    let output = radiosity(scratch.folder(), "plan --patches 3000");
    for word in ["interreflection", "no mirror", "stage", "trace", "nothing was traced", "threads"] {
        assert!(text(&output.stdout).contains(word), "{word}: {}", text(&output.stdout));
    }
}

#[test]
fn plan_refuses_what_solve_would_refuse_before_tracing() {
    let scratch = Scratch::new();
    for arguments in
        ["--rays 4", "--factors none", "--memory 16MiB --edge 1e-3", "--shading path --effects -back-sides"]
    {
        let last = |command: &str| {
            let output = radiosity(scratch.folder(), &format!("{command} {arguments}"));
            assert_eq!(output.status.code(), Some(1), "{command} {arguments}");
            text(&output.stderr).lines().last().unwrap_or_default().to_owned()
        };
        assert_eq!(last("plan"), last("solve"));
    }
    let output =
        radiosity(scratch.folder(), "plan --solver direct --memory 200MB --storage sparse --rays 64");
    let told = text(&output.stderr);
    assert!(
        output.status.success() && told.contains("directly takes") && told.contains("--solver cg"),
        "{told}"
    );
}

#[test]
fn solve_keeps_the_plan_it_began_with() {
    let scratch = Scratch::new();
    done(scratch.folder(), "solve -o .");
    let output = radiosity(scratch.folder(), &format!("plan --json {}", SMALL.join(" ")));
    let plan: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(json(&scratch.path("solution.json"))["plan"], plan["plan"]);
}
