//! The program, run in a folder.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Output;

/// Runs the program in a folder with these arguments.
pub fn run<A: AsRef<OsStr>>(folder: &Path, arguments: impl IntoIterator<Item = A>) -> Output {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("radiosity");
    command.current_dir(folder).args(arguments).output().expect("the program runs")
}

/// The same with arguments separated by spaces.
pub fn radiosity(folder: &Path, arguments: &str) -> Output {
    run(folder, arguments.split_whitespace())
}

/// What the program has printed.
pub fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}
