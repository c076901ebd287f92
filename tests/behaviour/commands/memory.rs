//! With little memory for all: too many patches are refused and not tried, and few take little.

use std::path::Path;
use std::process::Output;

use super::CUBE;
use crate::program::text;
use crate::scratch::Scratch;

/// Runs the program with so little memory that asking for it all can't hurt.
fn confined(folder: &Path, arguments: &str) -> Output {
    std::process::Command::new("sh")
        .args(["-c", "ulimit -v 4000000 && exec \"$0\" \"$@\""])
        .arg(assert_cmd::cargo::cargo_bin!("radiosity"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .expect("the program runs")
}

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
