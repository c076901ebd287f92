//! The tables of faces and patches: their columns, and what holds from row to row.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::{CUBE, FACES, done, json, number, table};
use crate::program::text;
use crate::scratch::Scratch;

const PATCHES: &str = "patch,face,side,cx,cy,cz,area,irradiance_r,irradiance_g,irradiance_b,radiance_r,radiance_g,radiance_b,error_r,error_g,error_b";

#[test]
fn tables_have_the_columns_that_scripts_rely_on() {
    let scratch = Scratch::new();
    done(scratch.folder(), "solve -o .");
    let (header, faces) = table(&scratch.path("faces.csv"));
    assert_eq!(header, FACES);
    let (header, patches) = table(&scratch.path("patches.csv"));
    assert_eq!(header, PATCHES);
    assert_eq!(patches.len() as u64, json(&scratch.path("solution.json"))["patches"].as_u64().unwrap());
    for (i, row) in patches.iter().enumerate() {
        assert_eq!(row["patch"], i.to_string());
        assert!(
            faces.iter().any(|face| (&face["face"], &face["side"]) == (&row["face"], &row["side"])),
            "{row:?}"
        );
    }
    for row in faces.iter().chain(&patches) {
        assert!(["front", "back"].contains(&row["side"].as_str()), "{row:?}");
        assert!(row["face"].parse::<usize>().unwrap() < 38, "{row:?}");
        assert!(number(row, "area") > 0.0, "{row:?}");
    }
    let places: Vec<(usize, bool)> =
        faces.iter().map(|row| (row["face"].parse().unwrap(), row["side"] == "back")).collect();
    assert!(
        places.is_sorted() && places.windows(2).all(|pair| pair[0] != pair[1]),
        "a row per face and side, in order"
    );
    let lamp: Vec<_> =
        faces.iter().filter(|row| row["material"] == "light" && row["side"] == "front").collect();
    assert_eq!(
        lamp.iter().map(|row| (&row["face"][..], &row["object"][..])).collect::<Vec<_>>(),
        [("2", "light"), ("3", "light")]
    );
    assert!((lamp.iter().map(|row| number(row, "area")).sum::<f64>() - 1.365).abs() < 1e-9);
}

#[test]
fn faces_are_the_area_average_of_their_patches() {
    let scratch = Scratch::new();
    done(scratch.folder(), "solve -o .");
    let (_, patches) = table(&scratch.path("patches.csv"));
    for face in table(&scratch.path("faces.csv")).1 {
        let own =
            |row: &&BTreeMap<String, String>| row["face"] == face["face"] && row["side"] == face["side"];
        for column in ["irradiance_r", "irradiance_b", "radiance_g"] {
            let sum: f64 =
                patches.iter().filter(own).map(|row| number(row, "area") * number(row, column)).sum();
            let (mean, given) = (sum / number(&face, "area"), number(&face, column));
            assert!((mean - given).abs() <= 1e-7 * given.abs(), "{column}: {mean} {face:?}");
        }
    }
}

#[test]
fn radiance_is_emission_plus_reflected_irradiance_row_by_row() {
    let materials = [
        ("white", [0.74; 3], [0.0; 3]),
        ("red", [0.63, 0.065, 0.05], [0.0; 3]),
        ("green", [0.14, 0.45, 0.091], [0.0; 3]),
        ("light", [0.78; 3], [17.0, 12.0, 4.0]),
    ];
    for solver in ["direct", "cg", "neumann", "neumann --order 0", "neumann --order 2"] {
        let scratch = Scratch::new();
        done(scratch.folder(), &format!("solve -o . --solver {solver}"));
        let (_, faces) = table(&scratch.path("faces.csv"));
        let material_of: BTreeMap<&str, &str> =
            faces.iter().map(|row| (row["face"].as_str(), row["material"].as_str())).collect();
        let (_, patches) = table(&scratch.path("patches.csv"));
        for row in faces.iter().chain(&patches) {
            let material = material_of[row["face"].as_str()];
            let (_, rho, emission) = materials.iter().find(|m| m.0 == material).expect("a known material");
            for (c, channel) in ["r", "g", "b"].into_iter().enumerate() {
                let emitted = if row["side"] == "front" { emission[c] } else { 0.0 };
                let expected = emitted + rho[c] * number(row, &format!("irradiance_{channel}")) / PI;
                let radiance = number(row, &format!("radiance_{channel}"));
                assert!((radiance - expected).abs() <= 2e-8 * radiance.abs(), "{solver}: {expected} {row:?}");
                if solver.ends_with("order 0") {
                    assert_eq!(radiance, emitted, "order 0 is what lamps emit: {row:?}");
                }
            }
        }
        assert!(patches.iter().any(|row| number(row, "radiance_r") > 0.0));
    }
}

#[test]
fn a_grey_scene_is_solved_once_and_written_three_times() {
    let scratch =
        Scratch::with(&[("cube.obj", CUBE), ("cube.mtl", "newmtl wall\nKd 0.5\nKe 1\nnewmtl last\nKd 0\n")]);
    done(scratch.folder(), "solve cube.obj -o .");
    let solution = json(&scratch.path("solution.json"));
    assert_eq!(solution["channels"], 1);
    let emitted = &solution["energy"]["emitted"];
    assert!(
        emitted[0].as_f64().unwrap() > 0.0 && emitted[0] == emitted[1] && emitted[1] == emitted[2],
        "{emitted}"
    );
    for row in table(&scratch.path("faces.csv")).1 {
        assert!(row["radiance_r"] == row["radiance_g"] && row["radiance_g"] == row["radiance_b"], "{row:?}");
    }
}

#[test]
fn dropped_faces_have_no_row_and_the_others_keep_their_number() {
    let with_flat = CUBE.replace("f 5 6 7 8", "f 1 1 2\nf 5 6 7 8\nf 1 2 3");
    let scratch = Scratch::with(&[
        ("cube.obj", with_flat.as_str()),
        ("cube.mtl", "newmtl wall\nKd 0.5\nKe 1\nnewmtl last\nKd 0\n"),
    ]);
    let output = done(scratch.folder(), "solve cube.obj -o .");
    assert_eq!(
        text(&output.stderr).lines().collect::<Vec<_>>(),
        ["warning: dropped 1 face: no area", "warning: dropped 1 face: duplicates of earlier faces"]
    );
    let faces: Vec<String> =
        table(&scratch.path("faces.csv")).1.into_iter().map(|mut row| row.remove("face").unwrap()).collect();
    assert_eq!(faces, ["0", "1", "3", "4", "6", "7", "8", "9", "10", "11", "12", "13"]);
    let warnings = &json(&scratch.path("solution.json"))["warnings"];
    assert_eq!(warnings.as_array().map(Vec::len), Some(2), "{warnings}");
}

#[test]
fn names_with_commas_and_quotes_survive_the_tables() {
    let scratch = Scratch::with(&[
        (
            "cube.obj",
            CUBE.replace("o cube", "o a \"cube\", closed").replace("usemtl wall", "usemtl paint, white"),
        ),
        ("cube.mtl", "newmtl paint, white\nKd 0.5\nKe 1\nnewmtl last\nKd 0\n".into()),
    ]);
    done(scratch.folder(), "solve cube.obj -o .");
    let row = &table(&scratch.path("faces.csv")).1[0];
    assert_eq!((&row["object"][..], &row["material"][..]), ("a \"cube\", closed", "paint, white"));
}
