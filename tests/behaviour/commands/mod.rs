//! The program: what it writes, what it prints, and what it answers when something is wrong.

mod compare;
mod effects;
mod form_factors;
mod plan;
mod study;
mod verdict;

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::{Output, Stdio};

use serde_json::Value;

use crate::scratch::{Scratch, content, names};

/// Settings that make a run short.
const SMALL: [&str; 6] = ["--patches", "200", "--rays", "64", "--size", "80x60"];

/// What `solve` writes.
const RESULTS: [&str; 5] = ["faces.csv", "image.png", "mesh.ply", "patches.csv", "solution.json"];

const FACES: &str = "face,side,object,material,area,irradiance_r,irradiance_g,irradiance_b,radiance_r,radiance_g,radiance_b,error_r,error_g,error_b,polygon";
const PATCHES: &str = "patch,face,side,cx,cy,cz,area,irradiance_r,irradiance_g,irradiance_b,radiance_r,radiance_g,radiance_b,error_r,error_g,error_b";

/// Names that stages may have.
const STAGES: [&str; 10] =
    ["load", "build", "patch", "trace", "balance", "factor", "solve", "series", "render", "write"];

/// A closed cube seen from inside; its last wall is of material `last`, the others of material `wall`.
const CUBE: &str = "mtllib cube.mtl
v 0 0 0\nv 0 1 0\nv 0 1 1\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 1 1 0\nv 1 0 0
o cube\nusemtl wall
f 1 2 3 4\nf 5 6 7 8\nf 1 4 5 8\nf 3 2 7 6\nf 8 7 2 1\nusemtl last\nf 4 3 6 5\n";

/// Runs the program in a folder with these arguments, separated by spaces.
fn radiosity(folder: &Path, arguments: &str) -> Output {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("radiosity");
    command.current_dir(folder).args(arguments.split_whitespace()).output().expect("the program runs")
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

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

// What solve writes.

#[test]
fn solve_writes_its_five_files_and_no_other() {
    let scratch = Scratch::new();
    done(scratch.folder(), "solve -o results");
    assert_eq!(names(&scratch.path("results")), RESULTS);
    assert_eq!(names(scratch.folder()), ["results"]);
    assert_eq!(image::image_dimensions(scratch.path("results/image.png")).unwrap(), (80, 60));
}

#[test]
fn the_default_folder_is_named_after_the_scene() {
    let scratch = Scratch::with(&[
        ("my room.obj", CUBE),
        ("cube.mtl", "newmtl wall\nKd 0.5\nKe 1\nnewmtl last\nKd 0\n"),
    ]);
    done(scratch.folder(), "solve");
    assert_eq!(names(&scratch.path("out")), ["cornell_box"]);
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("radiosity");
    command.current_dir(scratch.folder()).args(["solve", "my room.obj"]).args(SMALL).assert().success();
    assert_eq!(names(&scratch.path("out")), ["cornell_box", "my room"]);
    assert_eq!(names(&scratch.path("out/my room")), RESULTS);
    assert_eq!(json(&scratch.path("out/my room/solution.json"))["scene"], "my room");
}

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
fn solvers_agree() {
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

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let tables = |arguments: &str| {
        let scratch = Scratch::new();
        let arguments = format!("solve -o . --patches 900 --rays 64 --size 16x12 {arguments}");
        let output = radiosity(scratch.folder(), &arguments);
        assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
        ["faces.csv", "patches.csv", "mesh.ply"].map(|name| fs::read(scratch.path(name)).expect(name))
    };
    for solver in ["direct", "cg", "neumann"] {
        let one = tables(&format!("--seed 3 --threads 1 --solver {solver}"));
        let two = tables(&format!("--seed 3 --threads 2 --solver {solver}"));
        assert!(one == two, "{solver}: one thread and two differ");
        let other = tables(&format!("--seed 4 --threads 2 --solver {solver}"));
        assert!(one.iter().zip(&other).all(|(a, b)| a != b), "{solver}: seeds 3 and 4 agree");
    }
}

#[test]
fn exr_is_written_when_asked_for() {
    let scratch = Scratch::new();
    done(scratch.folder(), "solve -o . --exr");
    let mut expected = RESULTS.to_vec();
    expected.insert(1, "image.exr");
    assert_eq!(names(scratch.folder()), expected);
    assert_eq!(image::image_dimensions(scratch.path("image.exr")).unwrap(), (80, 60));
}

#[test]
fn the_mesh_has_a_face_per_patch() {
    let scratch = Scratch::new();
    done(scratch.folder(), "solve -o .");
    let patches = json(&scratch.path("solution.json"))["patches"].as_u64().unwrap();
    let mesh = fs::read(scratch.path("mesh.ply")).unwrap();
    let header = String::from_utf8_lossy(&mesh[..1000]).into_owned();
    assert!(header.starts_with("ply\nformat "), "{header}");
    assert!(header.contains(&format!("\nelement face {patches}\n")), "{header}");
}

#[test]
fn render_writes_a_picture_and_nothing_else() {
    let scratch = Scratch::new();
    done(scratch.folder(), "render -o .");
    assert_eq!(names(scratch.folder()), ["image.png"]);
    assert_eq!(image::image_dimensions(scratch.path("image.png")).unwrap(), (80, 60));
    done(scratch.folder(), "render -o . --exr --shading flat --outlines");
    assert_eq!(names(scratch.folder()), ["image.exr", "image.png"]);
}

#[test]
fn every_shading_is_saved_as_png_and_exr_with_the_same_bytes_on_any_number_of_threads() {
    let scratch = Scratch::new();
    let mut pictures = Vec::new();
    for shading in ["flat", "smooth", "gather", "path"] {
        for threads in [1, 3] {
            let arguments = format!(
                "render -o {shading}{threads} --exr --shading {shading} --samples 4 --threads {threads}"
            );
            done(scratch.folder(), &arguments);
        }
        let [one, three] = [1, 3].map(|threads| content(&scratch.path(&format!("{shading}{threads}"))));
        assert_eq!(one.keys().collect::<Vec<_>>(), ["image.exr", "image.png"]);
        assert!(one == three, "{shading}");
        pictures.push(one);
    }
    pictures.dedup();
    assert_eq!(pictures.len(), 4, "each shading looks different");
    done(scratch.folder(), "render -o seed --exr --shading gather --samples 4 --seed 5");
    assert!(content(&scratch.path("seed"))["image.exr"] != pictures[2]["image.exr"]);
}

#[test]
fn a_camera_that_sees_nothing_lit_is_warned_about() {
    let scratch = Scratch::with(&[
        ("cube.obj", CUBE),
        ("cube.mtl", "newmtl wall\nKd 0.5\nnewmtl last\nKd 0.5\nKe 1\n"),
        ("cube.toml", "[camera]\nposition = [5, 0.5, 0.5]\ntarget = [9, 0.5, 0.5]\n"),
    ]);
    let output = done(scratch.folder(), "render cube.obj -o .");
    assert!(text(&output.stderr).contains("warning: the picture is black"), "{}", text(&output.stderr));
    let seen = image::open(scratch.path("image.png")).unwrap().into_rgb8();
    assert!(seen.pixels().all(|pixel| pixel.0 == [0; 3]));
    scratch.write("cube.toml", "");
    let output = done(scratch.folder(), "render cube.obj -o .");
    assert!(!text(&output.stderr).contains("black"));
}

#[test]
fn render_and_solve_make_the_same_picture() {
    let scratch = Scratch::new();
    done(scratch.folder(), "render -o rendered");
    done(scratch.folder(), "solve -o solved");
    let [rendered, solved] =
        ["rendered", "solved"].map(|folder| content(&scratch.path(folder)).remove("image.png"));
    assert!(rendered.is_some() && rendered == solved);
}

#[test]
fn vertex_normals_smooth_the_picture_and_change_no_table() {
    let camera = "[camera]\nposition = [0.9, 0.5, 0.5]\ntarget = [0.0, 0.0, 0.0]\n";
    let normals =
        "vn 1 1 1\nvn 1 -1 1\nvn 1 -1 -1\nvn 1 1 -1\nvn -1 1 -1\nvn -1 -1 -1\nvn -1 -1 1\nvn -1 1 1\n";
    let smooth: String = CUBE
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(corners) => {
                let corners: String = corners.split(' ').map(|k| format!(" {k}//{k}")).collect();
                format!("f{corners}\n")
            }
            None => format!("{line}\n"),
        })
        .collect();
    let [flat, round] = [CUBE.to_owned(), smooth].map(|text| {
        let scratch = Scratch::with(&[
            ("cube.obj", format!("{normals}{text}")),
            ("cube.mtl", "newmtl wall\nKd 0.5\nKe 1\nnewmtl last\nKd 0\n".to_owned()),
            ("cube.toml", camera.to_owned()),
        ]);
        done(scratch.folder(), "solve cube.obj -o .");
        content(scratch.folder())
    });
    assert!(flat["image.png"] != round["image.png"] && flat["mesh.ply"] != round["mesh.ply"]);
    assert!(flat["patches.csv"] == round["patches.csv"] && flat["faces.csv"] == round["faces.csv"]);
}

// What the program prints.

#[test]
fn json_is_all_there_is_on_standard_output() {
    let scratch = Scratch::new();
    let output = done(scratch.folder(), "solve -o . --json");
    let printed: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    let mut written = json(&scratch.path("solution.json"));
    written["stages"] = printed["stages"].clone();
    assert_eq!(printed, written);
    let output = done(scratch.folder(), "render -o . --json --quiet");
    let printed: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert_eq!((&printed["scene"], &printed["files"][0]), (&"cornell_box".into(), &"image.png".into()));
    assert_eq!(text(&output.stderr), "");
}

#[test]
fn quiet_prints_nothing() {
    // A scene without materials would warn.
    let scratch = Scratch::with(&[("cube.obj", CUBE), ("cube.mtl", "newmtl wall\nKd 0.5\nKe 1\nPr 0.3\n")]);
    for command in ["solve", "render"] {
        let output = done(scratch.folder(), &format!("{command} cube.obj -o . --quiet"));
        assert_eq!((text(&output.stdout), text(&output.stderr)), ("", ""), "{command}");
        let output = done(scratch.folder(), &format!("{command} cube.obj -o ."));
        assert!(!output.stdout.is_empty());
        let warnings = text(&output.stderr);
        assert!(warnings.lines().all(|line| line.starts_with("warning: ")), "{warnings}");
        assert!(warnings.contains("grey 0.5") && warnings.contains("plastic"), "{warnings}");
    }
}

#[test]
fn quiet_still_prints_errors() {
    let scratch = Scratch::new();
    let message = refused(scratch.folder(), "solve none.obj --quiet", 1);
    assert!(message.contains("none.obj"), "{message}");
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let scratch = Scratch::new();
    for arguments in ["solve -o .", "solve -o . --json", "render -o ."] {
        let mut run = std::process::Command::new(assert_cmd::cargo::cargo_bin!("radiosity"))
            .current_dir(scratch.folder())
            .args(arguments.split_whitespace().chain(SMALL))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs");
        drop(run.stdout.take());
        let output = run.wait_with_output().expect("the program ends");
        assert!(!text(&output.stderr).contains("panicked"), "{arguments}: {}", text(&output.stderr));
        assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments}: {:?}", output.status);
    }
}

#[test]
fn help_and_version_are_no_errors() {
    let scratch = Scratch::new();
    for arguments in ["--help", "--version", "help solve", "solve --help", "render --help"] {
        let output = radiosity(scratch.folder(), arguments);
        assert!(output.status.success() && !output.stdout.is_empty(), "{arguments}");
    }
    assert!(names(scratch.folder()).is_empty());
}

// What a run leaves alone.

#[test]
fn a_run_replaces_its_own_files_and_leaves_others_alone() {
    let scratch =
        Scratch::with(&[("notes.txt", "mine"), ("image.exr", "old"), ("faces.csv", "old"), (".hidden", "x")]);
    fs::create_dir(scratch.path("deeper")).unwrap();
    scratch.write("deeper/faces.csv", "mine");
    done(scratch.folder(), "solve -o .");
    let files = content(scratch.folder());
    assert_eq!(
        (&files["notes.txt"][..], &files["image.exr"][..], &files[".hidden"][..]),
        (&b"mine"[..], &b"old"[..], &b"x"[..])
    );
    assert!(files["faces.csv"].starts_with(FACES.as_bytes()));
    assert_eq!(content(&scratch.path("deeper"))["faces.csv"], b"mine");
    assert_eq!(files.len(), RESULTS.len() + 3);
}

#[test]
fn a_failed_run_leaves_older_results_untouched() {
    let scratch =
        Scratch::with(&[("cube.obj", CUBE), ("cube.mtl", "newmtl wall\nKd 0.5\nKe 1\nnewmtl last\nKd 0\n")]);
    done(scratch.folder(), "solve cube.obj -o results");
    let before = content(&scratch.path("results"));
    refused(scratch.folder(), "solve cube.obj -o results --memory 16MiB --edge 1e-4", 1);
    refused(scratch.folder(), "solve cube.obj -o results --size 99999x99999 --patches 50 --rays 8", 1);
    scratch.write("cube.mtl", "newmtl wall\nKd 1.5\n");
    refused(scratch.folder(), "solve cube.obj -o results", 1);
    scratch.write("cube.mtl", "newmtl wall\nKd 0.5\n");
    refused(scratch.folder(), "render cube.obj -o results", 1);
    assert!(content(&scratch.path("results")) == before);
    assert_eq!(names(&scratch.path("results")), RESULTS);
}

#[test]
fn a_failed_run_makes_no_folder() {
    let scratch = Scratch::with(&[("a.obj", "v 0 0 0\n")]);
    refused(scratch.folder(), "solve a.obj", 1);
    refused(scratch.folder(), "solve none.obj -o results", 1);
    refused(scratch.folder(), "solve -o results --memory 16MiB --edge 1e-4", 1);
    assert_eq!(names(scratch.folder()), ["a.obj"]);
}

#[test]
fn a_file_in_the_way_of_the_folder_is_an_error() {
    let scratch = Scratch::with(&[("results", "a file")]);
    let message = refused(scratch.folder(), "solve -o results --patches 50 --rays 8 --size 4x4", 1);
    assert!(message.contains("results") && message.contains("--out"), "{message}");
    assert_eq!(content(scratch.folder())["results"], b"a file");
}

#[test]
fn a_result_that_cannot_be_written_leaves_all_others_as_they_were() {
    for blocked in RESULTS {
        let scratch = Scratch::with(&RESULTS.map(|name| (name, "old")));
        fs::remove_file(scratch.path(blocked)).unwrap();
        fs::create_dir(scratch.path(blocked)).unwrap();
        let message = refused(scratch.folder(), "solve -o . --patches 50 --rays 8 --size 4x4", 1);
        assert!(message.contains("cannot write") && message.contains(blocked), "{message}");
        assert_eq!(names(scratch.folder()), RESULTS, "no temporary file is left");
        assert!(content(scratch.folder()).values().all(|bytes| bytes == b"old"), "{blocked}");
    }
}

// Exit status.

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
        ("solve --patches 0", "--patches"),
        ("solve --patches many", "--patches"),
        ("solve --edge -1", "-1"),
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

/// Runs the program with so little memory that asking for it all can't hurt.
#[cfg(target_os = "linux")]
fn confined(folder: &Path, arguments: &str) -> Output {
    std::process::Command::new("sh")
        .args(["-c", "ulimit -v 4000000 && exec \"$0\" \"$@\""])
        .arg(assert_cmd::cargo::cargo_bin!("radiosity"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .expect("the program runs")
}

#[cfg(target_os = "linux")]
#[test]
fn patches_beyond_all_memory_are_refused_and_not_tried() {
    let scratch = Scratch::new();
    for arguments in ["solve --edge 1e-9", "solve --edge 1e-3", "solve --patches 999999999"] {
        let output = confined(scratch.folder(), &format!("{arguments} --memory 1GiB"));
        let message = text(&output.stderr);
        assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{arguments}: {message}");
        assert!(message.contains("--edge") || message.contains("--patches"), "{arguments}: {message}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_small_lamp_that_shines_into_nothing_takes_no_memory() {
    // A lamp of a millimetre outside a room of a metre, and facing away.
    let lamp = "usemtl lamp\nv 0.5 0.5 2\nv 0.501 0.5 2\nv 0.5 0.501 2\nf -3 -2 -1\n";
    let scratch = Scratch::with(&[
        ("a.obj", format!("{CUBE}{lamp}")),
        ("cube.mtl", "newmtl wall\nKd 0.5\nnewmtl last\nKd 0.5\nnewmtl lamp\nKd 0\nKe 1\n".into()),
    ]);
    let output = confined(scratch.folder(), "solve a.obj -o . --rays 8 --size 4x4");
    let message = text(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{:?}: {message}", output.status);
    // That the lamp faces away, and that the picture is black.
    assert!(message.lines().count() <= 2, "{message}");
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
