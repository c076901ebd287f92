//! What the program refuses, with which status and what message.

use serde_json::Value;

use super::{CUBE, json, refused};
use crate::program::{radiosity, text};
use crate::scratch::{Scratch, names};

#[test]
fn bad_usage_is_status_2_and_says_what_is_meant() {
    let scratch = Scratch::new();
    for (arguments, word) in [
        ("", "Usage"),
        ("paint", "paint"),
        ("solve --colour", "--colour"),
        ("solve a.obj b.obj", "b.obj"),
        ("solve --rays x", "--rays"),
        ("solve --rays -8", "-8"),
        ("solve --rays -8", "must be a whole number, 0 or more"),
        ("solve --patches 0", "--patches"),
        ("solve --patches many", "--patches"),
        ("solve --edge -1", "-1"),
        ("solve --edge -1", "must be a number above 0"),
        ("solve --accuracy -1%", "write it as 1%"),
        ("solve --accuracy -5lx", "above 0"),
        ("solve --time -5s", "above 0"),
        ("solve --tolerance -1", "must lie between 0 and 1"),
        ("solve --exposure -1", "must be a number above 0"),
        ("solve --memory -1GiB", "at least 16MiB"),
        ("solve --order -3", "must be a whole number, 0 or more"),
        ("compare --standard-error -1%", "between 0 and 1"),
        ("study --time -9s", "above 0"),
        ("solve --edge=-1", "--edge"),
        ("solve --edge 0", "--edge"),
        ("solve --edge nan", "--edge"),
        ("solve --edge 0.1 --patches 100", "--patches"),
        ("solve --tolerance 2", "--tolerance"),
        ("solve --tolerance nan", "--tolerance"),
        ("solve --tolerance=-1", "--tolerance"),
        ("solve --memory foo", "--memory"),
        ("solve --memory 4gigs", "--memory"),
        ("solve --memory=-1GiB", "--memory"),
        ("solve --memory infGiB", "--memory"),
        ("solve --size 0x4", "--size"),
        ("solve --size 4", "--size"),
        ("solve --size 4x-4", "--size"),
        ("solve --exposure 0", "--exposure"),
        ("render --samples 0", "--samples"),
        ("render --samples 2000000", "--samples"),
        ("solve --solver magic", "--solver"),
        ("solve --order x", "--order"),
        ("solve --seed -1", "-1"),
        ("solve --seed -1", "must be a whole number, 0 or more"),
        ("solve --threads 0", "--threads"),
        ("render --shading round", "--shading"),
    ] {
        let message = refused(scratch.folder(), arguments, 2);
        assert!(message.contains(word), "{arguments}: {message}");
    }
    assert!(names(scratch.folder()).is_empty());
}

#[test]
fn failure_is_status_1_and_one_clear_message() {
    let scratch = Scratch::with(&[
        ("dark.obj", CUBE.replace("mtllib cube.mtl", "mtllib dark.mtl")),
        ("dark.mtl", "newmtl wall\nKd 0.5\nnewmtl last\nKd 0.5\n".into()),
        ("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n".into()),
        ("settings.obj", CUBE.into()),
        ("cube.mtl", "newmtl wall\nKe 1\nKd 0\nnewmtl last\nKd 0.5\n".into()),
        ("settings.toml", "\ncolour = 3\n".into()),
    ]);
    for (arguments, words) in [
        ("solve none.obj", ["cannot read", "none.obj"]),
        ("solve dark.obj", ["no light", "Ke"]),
        ("render dark.obj", ["no light", "Ke"]),
        ("solve bad.obj", ["bad.obj:4", "vertex 4 does not exist"]),
        ("solve settings.obj", ["settings.toml:2", "colour"]),
        ("solve --rays 4", ["4 rays", "between 8 and"]),
        ("solve --rays 4294967295", ["4294967295 rays", "between 8 and"]),
        ("solve --memory 16MiB --edge 1e-3", ["more than the 16.8 MB allowed", "raise --memory"]),
        ("solve --size 40000x40000 --patches 50 --rays 8", ["40000 x 40000", "at most"]),
    ] {
        let message = refused(scratch.folder(), arguments, 1);
        assert!(words.iter().all(|word| message.contains(word)), "{arguments}: {message}");
    }
}

#[test]
fn too_little_memory_for_a_chosen_direct_solver_is_said_and_auto_takes_another() {
    let scratch = Scratch::new();
    let enough =
        radiosity(scratch.folder(), "solve -o . --storage sparse --rays 8 --patches 2500 --size 4x4 --json");
    let patches = serde_json::from_slice::<Value>(&enough.stdout).unwrap()["patches"].as_u64().unwrap();
    // Three factors would take 24 n² bytes; the form factors take a tenth of that.
    let limit = format!(
        "solve -o . --storage sparse --rays 8 --patches 2500 --size 4x4 --memory {}",
        4 * patches * patches
    );
    let message = refused(scratch.folder(), &format!("{limit} --solver direct"), 1);
    assert!(message.contains("--memory") && message.contains("--solver cg"), "{message}");
    let output = radiosity(scratch.folder(), &limit);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(json(&scratch.path("solution.json"))["solver"]["name"], "cg");
}
