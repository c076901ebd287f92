//! The option --effects: what it warns of, what it changes, what it refuses.

use std::path::Path;

use super::{done, json, number, refused, table};
use crate::program::{radiosity, text};
use crate::scratch::{Scratch, content, names};

#[test]
fn an_effect_that_is_switched_off_is_warned_of_and_kept_in_the_plan() {
    let scratch = Scratch::new();
    let output = done(scratch.folder(), "solve -o . --effects -colour,-interreflection");
    let warnings = text(&output.stderr);
    for word in ["colour is switched off", "grey", "interreflection is switched off", "straight"] {
        assert!(warnings.contains(word), "{word}: {warnings}");
    }
    let solution = json(&scratch.path("solution.json"));
    assert_eq!((&solution["channels"], &solution["rays"]), (&1.into(), &0.into()));
    for entry in solution["plan"].as_array().expect("a list") {
        if ["colour", "interreflection"].contains(&entry["effect"].as_str().expect("a name")) {
            let told = entry["reason"].as_str().expect("a reason");
            assert!(entry["on"] == false && told.starts_with("switched off"), "{entry}");
            assert_eq!((&entry["rays"], &entry["bytes"]), (&0.into(), &0.into()), "{entry}");
        }
    }
    // Row by row L = Lₑ + ρ H / π, and less light than with all bounces.
    let (_, direct) = table(&scratch.path("faces.csv"));
    done(scratch.folder(), "solve -o . --effects -colour");
    let (_, all) = table(&scratch.path("faces.csv"));
    for row in &direct {
        let same = all.iter().find(|other| (&other["face"], &other["side"]) == (&row["face"], &row["side"]));
        let same = same.expect("a face that light reaches straight is reached");
        assert!(number(row, "irradiance_r") <= 1.1 * number(same, "irradiance_r"), "{row:?} {same:?}");
    }
}

#[test]
fn effects_left_to_auto_change_no_result() {
    let scratch = Scratch::new();
    done(scratch.folder(), "solve -o one");
    let output = done(scratch.folder(), "solve -o two --effects auto,+colour,+interreflection");
    assert_eq!(text(&output.stderr), "");
    let files = |name: &str| {
        let mut files = content(&scratch.path(name));
        files.remove("solution.json");
        files
    };
    assert_eq!(files("one"), files("two"));
}

#[test]
fn the_help_names_every_effect() {
    let scratch = Scratch::new();
    let output = radiosity(scratch.folder(), "solve --help");
    let words: Vec<&str> = text(&output.stdout).split(|c: char| !(c.is_alphanumeric() || c == '-')).collect();
    for name in radiosity::transport::Switches::names().split(", ") {
        assert!(words.contains(&name), "{name}");
    }
}

#[test]
fn impossible_effects_are_refused() {
    let scratch = Scratch::new();
    let message = refused(scratch.folder(), "solve --effects -fog", 2);
    for name in ["fog", "interreflection", "back-sides", "caustics"] {
        assert!(message.contains(name), "{message}");
    }
    for arguments in [
        "compare --effects -interreflection",
        "render --shading path --effects -back-sides",
        "solve --lamp-groups --effects -interreflection",
        "solve --save-factors f --effects -lamps",
    ] {
        refused_with_warnings(scratch.folder(), arguments);
    }
    assert_eq!(names(scratch.folder()), [""; 0]);
}

/// A run that must fail, its last line the error.
#[track_caller]
fn refused_with_warnings(folder: &Path, arguments: &str) {
    let output = radiosity(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{arguments}: {message}");
    assert!(message.lines().last().is_some_and(|line| line.starts_with("error: ")), "{arguments}: {message}");
}
