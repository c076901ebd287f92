//! Every solver, either basis: the same light, and none where light is trapped.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::{CUBE, SMALL, done, json, number, refused, table};
use crate::program::{radiosity, text};
use crate::scratch::{Scratch, content, names};

#[test]
fn every_solver_writes_the_same_radiance() {
    let radiance = |solver: &str| -> Vec<f64> {
        let scratch = Scratch::new();
        done(scratch.folder(), &format!("solve -o . --tolerance 1e-9 --solver {solver}"));
        let solution = json(&scratch.path("solution.json"));
        assert_eq!(solution["solver"]["name"], solver);
        assert!(solution["solver"]["residual"].as_f64().unwrap() <= 1e-9, "{solver}");
        assert!(solution["series"]["difference"].as_f64().unwrap() < 1e-7, "{solver}");
        table(&scratch.path("patches.csv")).1.iter().map(|row| number(row, "radiance_r")).collect()
    };
    let direct = radiance("direct");
    let brightest = direct.iter().copied().fold(0.0, f64::max);
    for solver in ["cg", "neumann"] {
        let other = radiance(solver);
        assert_eq!(other.len(), direct.len());
        let apart = other.iter().zip(&direct).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-7 * brightest, "{solver}: {apart}");
    }
}

#[test]
fn linear_elements_fill_the_same_tables_and_say_what_they_are() {
    let scratch = Scratch::new();
    let told = |basis: &str| {
        let output =
            done(scratch.folder(), &format!("solve -o {basis} --basis {basis} --save-factors {basis}.ff"));
        let solution = json(&scratch.path(&format!("{basis}/solution.json")));
        assert_eq!(solution["basis"], basis);
        assert!(solution["energy"]["imbalance"].as_f64().unwrap() < 1e-5);
        let rows = table(&scratch.path(&format!("{basis}/patches.csv"))).1;
        assert_eq!(rows.len() as u64, solution["patches"].as_u64().unwrap());
        (text(&output.stdout).to_owned(), solution, rows)
    };
    let (constant, linear) = (told("constant"), told("linear"));
    assert_eq!(constant.1["solver"]["certainty"], "guaranteed");
    assert_eq!(linear.1["solver"]["certainty"], "estimated");
    assert!(constant.0.contains("error at most") && !constant.0.contains("linear"), "{}", constant.0);
    assert!(linear.0.contains("patches, linear") && linear.0.contains("error about"), "{}", linear.0);
    assert_eq!(constant.1["undershoot"]["share"], 0.0);
    // The same patches, and about the same light.
    assert_eq!(linear.2.len(), constant.2.len());
    let sum = |rows: &[BTreeMap<String, String>]| {
        rows.iter().map(|row| number(row, "area") * number(row, "irradiance_g")).sum::<f64>()
    };
    assert!((sum(&linear.2) / sum(&constant.2) - 1.0).abs() < 0.05);
    // Light paths find the same.
    done(scratch.folder(), "compare -o against --basis linear --paths 200000 --samples 1");
    let comparison = json(&scratch.path("against/comparison.json"));
    assert_eq!(comparison["basis"], "linear");
    let orders = comparison["orders"].as_array().expect("a list");
    let (first, last) = (&orders[0], &orders[orders.len() - 1]);
    assert_eq!(first["vs_direct"], 1.0);
    assert!(last["vs_direct"].as_f64().unwrap() < 1e-5 && last["bound"].as_f64().unwrap() < 1e-5, "{last}");
    // Saved form factors bring their basis along.
    let output = radiosity(scratch.folder(), "solve -o again --factors linear.ff --size 80x60");
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(json(&scratch.path("again/solution.json"))["basis"], "linear");
    let [saved, traced] =
        ["again", "linear"].map(|folder| content(&scratch.path(folder))["patches.csv"].clone());
    assert!(saved == traced);
    let refused = radiosity(scratch.folder(), "solve -o . --factors linear.ff --basis linear");
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn trapped_light_is_refused_by_the_names_of_what_traps_it() {
    let white = "newmtl wall\nKd 1\nKe 1\nnewmtl last\n";
    let scratch = Scratch::with(&[("cube.obj", CUBE), ("cube.mtl", &format!("{white}Kd 1 1 1\n"))]);
    for solver in ["direct", "cg", "neumann"] {
        let arguments = format!("solve cube.obj -o . {} --solver {solver}", SMALL.join(" "));
        let message = refused(scratch.folder(), &arguments, 1);
        assert!(message.contains("light is trapped: last, wall") && message.contains("Kd"), "{message}");
    }
    assert_eq!(names(scratch.folder()), ["cube.mtl", "cube.obj"]);

    // One channel is enough.
    scratch.write("cube.mtl", "newmtl wall\nKd 0.5 1 0.5\nKe 1\nnewmtl last\nKd 0 1 0\n");
    let message = refused(scratch.folder(), &format!("solve cube.obj -o . {}", SMALL.join(" ")), 1);
    assert!(message.contains("light is trapped"), "{message}");
}

#[test]
fn one_absorbing_wall_makes_a_white_room_solvable() {
    let scratch =
        Scratch::with(&[("cube.obj", CUBE), ("cube.mtl", "newmtl wall\nKd 1\nKe 1\nnewmtl last\nKd 0.5\n")]);
    for solver in ["direct", "cg", "neumann"] {
        done(scratch.folder(), &format!("solve cube.obj -o . --solver {solver}"));
        let energy = &json(&scratch.path("solution.json"))["energy"];
        let [emitted, absorbed] = ["emitted", "absorbed"].map(|term| energy[term][0].as_f64().unwrap());
        assert!((emitted - 5.0 * PI).abs() < 1e-9, "five glowing walls of a square metre: {emitted}");
        assert!((absorbed / emitted - 1.0).abs() < 1e-4, "{solver}: {absorbed} of {emitted}");
    }
}
