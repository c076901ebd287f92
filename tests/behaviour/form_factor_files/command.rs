//! The command `form-factors`: what it writes, prints and refuses, and how it groups patches.

use std::fs;
use std::process::Output;

use radiosity::patches::GroupBy;
use radiosity::scene::{Material, Scene};
use serde_json::Value;

use super::pairs;
use crate::program::radiosity;
use crate::scenes::{flipped, quads};
use crate::scratch::{Scratch, names};

#[test]
fn the_usual_groups_are_objects_else_materials_else_faces() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let grey = || Material::diffuse("grey", &[0.5]);
    let two = quads(&[(square, 0), (flipped(square), 0)], vec![grey()]);
    assert_eq!(GroupBy::usual(&two), GroupBy::Object);
    assert_eq!(GroupBy::usual(&quads(&[(square, 0)], vec![grey(), grey()])), GroupBy::Face);
    let scratch = scratch();
    scratch.write("a.obj", LIT_BY_NOTHING.replace("o roof\n", ""));
    assert_eq!(GroupBy::usual(&Scene::load(scratch.path("a.obj")).unwrap()), GroupBy::Material);
}

/// Two plates that face each other.
const LIT_BY_NOTHING: &str = "mtllib a.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
o base\nusemtl dull\nf 1 2 3 4\no roof\nusemtl black\nf 8 7 6 5\n";

fn scratch() -> Scratch {
    Scratch::with(&[("a.obj", LIT_BY_NOTHING), ("a.mtl", "newmtl dull\nKd 0.5\nnewmtl black\nKd 0\n")])
}

fn form_factors(scratch: &Scratch, arguments: &str) -> Output {
    radiosity(scratch.folder(), &format!("form-factors {arguments}"))
}

#[track_caller]
fn done(scratch: &Scratch, arguments: &str) -> String {
    let output = form_factors(scratch, &format!("{arguments} --patches 200 --rays 64"));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {message}");
    String::from_utf8(output.stdout).unwrap()
}

#[track_caller]
fn refused(scratch: &Scratch, arguments: &str, status: i32, words: &[&str]) {
    let output = form_factors(scratch, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(status), 0), "{arguments}: {message}");
    assert!(words.iter().all(|word| message.contains(word)), "{arguments}: {message}");
    assert!(status == 2 || message.starts_with("error: "), "{arguments}: {message}");
}

#[test]
fn the_command_needs_no_light_and_writes_one_file() {
    let scratch = scratch();
    let said = done(&scratch, "a.obj");
    assert_eq!(names(&scratch.path("out/a")), ["form_factors.csv"]);
    let pairs = pairs(&scratch.path("out/a/form_factors.csv"));
    let (form_factor, error) = pairs[&("base".into(), "roof".into())];
    assert!((form_factor - 0.199824895698387).abs() < 4.0 * error, "{form_factor} ± {error}");
    assert!(said.contains("from") && said.contains("(escape)") && said.contains("±"), "{said}");
    assert!(said.contains("wrote") && said.contains("form_factors.csv"), "{said}");

    done(&scratch, "a.obj -o deeper/still/F.MTX --by patch");
    done(&scratch, "a.obj -o f.npz --by material");
    assert_eq!(done(&scratch, "a.obj -o f.csv --by face --quiet"), "");
    assert_eq!(names(scratch.folder()), ["a.mtl", "a.obj", "deeper", "f.csv", "f.npz", "out"]);
    assert_eq!(names(&scratch.path("deeper/still")), ["F.MTX"]);
}

#[test]
fn the_summary_names_groups_with_their_areas() {
    let scratch = scratch();
    let summary: Value = serde_json::from_str(&done(&scratch, "a.obj -o f.csv --json --quiet")).unwrap();
    assert_eq!(
        (&summary["scene"], &summary["by"], &summary["file"]),
        (&"a".into(), &"object".into(), &"f.csv".into())
    );
    assert_eq!(summary["rays"], 64);
    assert!(summary["patches"].as_u64().unwrap() > 100);
    assert!(summary["closure"]["after"].as_f64().unwrap() < 1e-12);
    let groups = summary["groups"].as_array().unwrap();
    let of = |key: &str| groups.iter().map(|group| group[key].clone()).collect::<Vec<Value>>();
    assert_eq!(of("name"), ["base", "roof"]);
    assert!(of("area").iter().all(|area| (area.as_f64().unwrap() - 1.0).abs() < 1e-9));
    assert!(of("escape").iter().all(|escape| (0.75..0.85).contains(&escape.as_f64().unwrap())));
    let stages: Vec<&str> =
        summary["stages"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(stages, ["load", "build", "patch", "trace", "balance", "errors", "write"]);
}

#[test]
fn the_same_seed_gives_the_same_bytes_whatever_the_number_of_threads() {
    let scratch = scratch();
    for by in ["object", "patch"] {
        for extension in ["csv", "mtx", "npz"] {
            let [one, two] = [1, 2].map(|threads| {
                let name = format!("{by}{threads}.{extension}");
                done(&scratch, &format!("a.obj -o {name} --by {by} --seed 7 --threads {threads}"));
                fs::read(scratch.path(&name)).unwrap()
            });
            assert!(one == two, "{by} {extension}");
        }
    }
}

#[test]
fn where_nothing_sees_anything_all_escapes() {
    let apart =
        LIT_BY_NOTHING.replace("f 8 7 6 5", "f 1 2 6").replace("v 0 0 1\nv 1 0 1", "v 2 5 0\nv 3 5 0");
    let scratch = scratch();
    scratch.write("a.obj", apart);
    let output = form_factors(&scratch, "a.obj -o f.csv --json");
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("no face sees another"));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&summary["patches"], &summary["closure"]), (&0.into(), &Value::Null));
    assert_eq!(summary["groups"][1]["escape"], 1.0);
    assert!(pairs(&scratch.path("f.csv")).into_values().all(|values| values == (0.0, 0.0)));
}

#[test]
fn broken_input_is_refused_and_leaves_no_file() {
    let scratch = scratch();
    scratch.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    scratch.write("empty.obj", "v 0 0 0\n");
    let before = names(scratch.folder());
    for name in ["f.txt", "f", "folder/"] {
        refused(&scratch, &format!("a.obj -o {name}"), 2, &["--out", ".csv", ".mtx", ".npz"]);
    }
    refused(&scratch, "a.obj --by colour", 2, &["--by", "material"]);
    refused(&scratch, "a.obj --patches 0", 2, &["--patches"]);
    refused(&scratch, "a.obj --solver cg", 2, &["--solver"]);
    refused(&scratch, "none.obj", 1, &["cannot read", "none.obj"]);
    refused(&scratch, "bad.obj -o f.csv", 1, &["bad.obj:4", "vertex 4"]);
    refused(&scratch, "empty.obj -o f.csv", 1, &["no faces"]);
    refused(&scratch, "a.obj -o f.csv --rays 4", 1, &["4 rays", "between 8 and"]);
    refused(&scratch, "a.obj -o f.csv --memory 16MiB --edge 1e-4", 1, &["--memory"]);
    refused(&scratch, "a.obj -o a.obj/f.csv --rays 8 --patches 10", 1, &["cannot make the folder", "--out"]);
    assert_eq!(names(scratch.folder()), before);
}
