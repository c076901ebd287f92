//! The form-factors command among coloured mirrors.

use std::fs;

use super::{CUBE, refused};
use crate::program::{radiosity, text};
use crate::scratch::Scratch;

#[test]
fn form_factors_among_coloured_mirrors_are_those_of_the_channel_that_is_asked_for() {
    let scratch = Scratch::new();
    scratch.write("cube.obj", CUBE);
    scratch.write("cube.mtl", "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl last\nillum 3\nKs 0.9 0.5 0.1\n");
    let run = |file: &str, more: &str| {
        let arguments =
            format!("form-factors cube.obj --by material --patches 100 --rays 512 -o {file} {more}");
        let output = radiosity(scratch.folder(), &arguments);
        assert!(output.status.success(), "{more}: {}", text(&output.stderr));
        (text(&output.stderr).to_owned(), fs::read_to_string(scratch.path(file)).expect("a table"))
    };
    let (warning, first) = run("F.csv", "");
    assert!(warning.contains("channel 1") && warning.contains("--channel"), "{warning}");
    let of_channel = |k: usize| {
        let (warning, table) = run("F.csv", &format!("--channel {k}"));
        assert_eq!(warning, "");
        table
    };
    let tables = [1, 2, 3].map(of_channel);
    assert_eq!(first, tables[0]);
    // The mirror fills a sixth of what a wall sees, or a little more.
    let kept = |table: &String| {
        let row = table.lines().find(|line| line.starts_with("wall,wall,")).expect("a row");
        row.split(',').nth(2).expect("a form factor").parse::<f64>().expect("a number")
    };
    let [red, green, blue] = tables.each_ref().map(kept);
    let mirror = (red - blue) / 0.8;
    assert!((0.18..0.22).contains(&mirror), "{mirror}");
    assert!((red - 0.4 * mirror - green).abs() < 0.01, "{red} {green} {blue}");
    let message = refused(scratch.folder(), "form-factors cube.obj --channel 4", 1);
    assert!(message.contains("--channel 4"), "{message}");
}
