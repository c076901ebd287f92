//! What solve writes: its five files, the same bytes for the same seed.

use std::fs;

use super::{CUBE, RESULTS, SMALL, done, json};
use crate::program::{radiosity, run, text};
use crate::scratch::{Scratch, names};

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
    let output = run(scratch.folder(), ["solve", "my room.obj"].into_iter().chain(SMALL));
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(names(&scratch.path("out")), ["cornell_box", "my room"]);
    assert_eq!(names(&scratch.path("out/my room")), RESULTS);
    assert_eq!(json(&scratch.path("out/my room/solution.json"))["scene"], "my room");
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
