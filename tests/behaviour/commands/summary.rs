//! The summary of a run, for scripts.

use serde_json::Value;

use super::{STAGES, done, json};
use crate::scratch::Scratch;

#[test]
fn the_summary_has_the_keys_that_scripts_rely_on() {
    let scratch = Scratch::new();
    done(scratch.folder(), "solve -o . --seed 7 --threads 2");
    let solution = json(&scratch.path("solution.json"));
    assert_eq!(solution["scene"], "cornell_box");
    assert_eq!(solution["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&solution["seed"], &solution["threads"]), (&7.into(), &2.into()));
    assert_eq!((&solution["rays"], &solution["channels"]), (&64.into(), &3.into()));
    let patches = solution["patches"].as_u64().expect("a number");
    assert!((160..=240).contains(&patches), "{patches} patches of 200");

    let numbers = |object: &Value, keys: &[&str]| {
        for key in keys {
            assert!(object[key].as_f64().is_some_and(|x| x >= 0.0), "{key}: {object}");
        }
    };
    for entry in solution["plan"].as_array().expect("a list") {
        assert!(
            entry["effect"].is_string() && entry["on"].is_boolean() && entry["reason"].is_string(),
            "{entry}"
        );
        for cost in ["rays", "seconds", "bytes"] {
            assert!(entry.get(cost).is_some_and(|x| x.is_null() || x.is_number()), "{cost}: {entry}");
        }
    }
    let stages = solution["stages"].as_array().expect("a list");
    let names: Vec<&str> = stages.iter().map(|stage| stage["name"].as_str().expect("a name")).collect();
    assert!(names.iter().all(|name| STAGES.contains(name)), "{names:?}");
    assert!((1..names.len()).all(|k| !names[..k].contains(&names[k])), "each stage once: {names:?}");
    for stage in stages {
        numbers(stage, &["seconds"]);
        assert!(stage["bytes"].is_u64(), "{stage}");
    }
    assert!(solution["solver"]["name"].is_string() && solution["solver"]["iterations"].is_u64());
    numbers(&solution["solver"], &["residual", "bound", "condition"]);
    assert!(solution["series"]["order"].is_u64());
    numbers(&solution["series"], &["residual", "remaining_flux", "bound", "difference"]);
    assert_eq!(solution["verdict"], serde_json::json!({ "level": "good", "reasons": [] }));
    numbers(&solution["closure"], &["before", "after"]);
    assert!(solution["closure"]["iterations"].is_u64());
    for term in ["emitted", "absorbed", "escaped", "carriers", "lost", "slack"] {
        let channels = solution["energy"][term].as_array().expect("a list");
        assert_eq!(channels.iter().filter(|x| x.as_f64().is_some_and(|x| x >= 0.0)).count(), 3, "{term}");
        assert_eq!(channels.len(), 3, "{term}");
    }
    numbers(&solution["energy"], &["imbalance", "imbalance_error"]);
    numbers(&solution["error"], &["relative_rms", "upper95"]);
    let parts = solution["error"]["parts"].as_array().expect("a list");
    assert_eq!(parts.len(), 6);
    for part in parts {
        numbers(part, &["value"]);
        assert!(
            part["name"].is_string()
                && ["guaranteed", "estimated"].contains(&part["kind"].as_str().expect("a word"))
        );
    }
}
