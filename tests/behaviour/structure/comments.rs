//! Comments are no wider than the code around them, which the formatter leaves to their authors.

use super::{read, root, rust_files};

#[test]
fn comments_are_no_wider_than_code() {
    let width = read(&root().join("rustfmt.toml"))
        .lines()
        .find_map(|line| line.strip_prefix("max_width = ")?.parse::<usize>().ok())
        .expect("rustfmt.toml has the width of code");
    let folders = ["src", "tests", "examples"].map(|folder| root().join(folder));
    let files: Vec<_> = folders.iter().flat_map(|folder| rust_files(folder)).collect();
    let mut wide = Vec::new();
    for path in &files {
        for (number, line) in read(path).lines().enumerate() {
            // Rows of tables cannot be broken.
            let text = line.trim_start();
            let is_comment = text.starts_with("//") && !text.starts_with("//! |");
            if is_comment && line.chars().count() > width {
                wide.push(format!("{}:{}", path.display(), number + 1));
            }
        }
    }
    assert!(files.len() > 100 && wide.is_empty(), "\n{}", wide.join("\n"));
}
