//! What a run leaves alone, done or failed.

use std::fs;

use super::{CUBE, FACES, RESULTS, done, refused};
use crate::scratch::{Scratch, content, names};

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
fn places_that_cannot_be_written_are_found_before_the_work() {
    let scratch = Scratch::with(&[("results", "a file")]);
    fs::create_dir(scratch.path("a.csv")).unwrap();
    let before = names(scratch.folder());
    // None of these scenes can be cut: that would be the first error of the work.
    for (arguments, word) in [
        ("solve -o results", "cannot make the folder results"),
        ("solve -o results/deeper", "cannot make the folder results/deeper"),
        ("render -o results", "--out"),
        ("study -o results", "--out"),
        ("form-factors -o results/a.csv", "cannot make the folder results"),
        ("form-factors -o a.csv", "cannot write a.csv"),
        ("solve --save-factors none/f", "cannot write none/f"),
    ] {
        let cut = if arguments.starts_with("study") { "" } else { "--memory 16MiB --edge 1e-4" };
        let message = refused(scratch.folder(), &format!("{arguments} {cut}"), 1);
        assert!(message.contains(word), "{arguments}: {message}");
    }
    refused(scratch.folder(), "form-factors -o new/a.csv --memory 16MiB --edge 1e-4", 1);
    refused(scratch.folder(), "form-factors --memory 16MiB --edge 1e-4", 1);
    assert_eq!(names(scratch.folder()), before, "no empty folder is left");
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
