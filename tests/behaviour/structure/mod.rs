//! Data flows one way: a module imports only from modules to its left, and no two rooms of the house need
//! each other. Functions take few parameters, and comments are no wider than code.

mod comments;
mod house; // which file needs what of which other
mod parameters; // how much a function takes, tuples counted by their parts
mod tokens; // Rust text as words and signs

use std::fs;
use std::path::{Path, PathBuf};

use house::House;
use tokens::{Token, tokens};

/// The way through the house, left to right.
const ORDER: [&str; 11] = [
    "parallel",
    "progress",
    "scene",
    "trace",
    "patches",
    "transport",
    "solve",
    "reference",
    "measure",
    "render",
    "output",
];

/// What does the mathematics, the tracing and the files; the program leaves all of it to the library.
const WORKSHOP: [&str; 8] = ["nalgebra", "faer", "sprs", "glam", "obvhs", "sobol_burley", "tobj", "image"];

#[test]
fn modules_import_only_from_their_left() {
    let wrong: Vec<String> = library_files()
        .iter()
        .filter_map(|path| Some((path, module_path(path)?)))
        .flat_map(|(path, module)| arrows_to_the_right(&path.display().to_string(), &module, &read(path)))
        .collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_module_has_its_place_in_the_order() {
    let mut modules: Vec<String> =
        library_files().iter().filter_map(|path| module_path(path)?.into_iter().next()).collect();
    modules.dedup();
    let mut known = ORDER.map(str::to_owned).to_vec();
    known.sort();
    assert_eq!(modules, known, "the folders of src against the order in this test");
}

#[test]
fn the_program_knows_the_library_by_its_public_face_only() {
    let folder = root().join("src/bin/radiosity");
    let files: Vec<PathBuf> = rust_files(&folder);
    let own: Vec<String> =
        files.iter().map(|f| f.file_stem().unwrap().to_string_lossy().into_owned()).collect();
    assert!(own.contains(&"main".to_owned()), "the program is in {}", folder.display());
    for path in &files {
        let tokens = tokens(&read(path));
        for (line, name) in names_from_root(&tokens, &["main".to_owned()]) {
            assert!(
                own.contains(&name),
                "{}:{line}: crate::{name} is no file of the program",
                path.display()
            );
        }
        for (k, token) in tokens.iter().enumerate() {
            let at = format!("{}:{}: {}", path.display(), token.line, token.text);
            let next = tokens.get(k + 1).map_or("", |next| &next.text);
            let previous = k.checked_sub(1).map_or("", |k| &tokens[k].text);
            assert!(!WORKSHOP.contains(&token.text.as_str()), "{at}: the library's business");
            let elsewhere = (token.text == "path" && (previous, next) == ("[", "="))
                || (token.text.starts_with("include") && next == "!");
            assert!(!elsewhere, "{at}: takes in a file from elsewhere");
        }
    }
}

#[test]
fn no_two_rooms_of_the_library_need_each_other() {
    let source = root().join("src");
    let files = library_files().into_iter().filter_map(|path| Some((module_path(&path)?, read(&path))));
    let house = House::new(files.collect());
    assert!(house.arrows().len() > 500, "the arrows of {}", source.display());
    assert_eq!(house.circles(), [""; 0]);
}

#[test]
fn no_two_files_of_the_program_need_each_other() {
    let files = rust_files(&root().join("src/bin/radiosity"));
    let name = |path: &Path| vec![path.file_stem().unwrap().to_string_lossy().into_owned()];
    let house = House::new(files.iter().map(|path| (name(path), read(path))).collect());
    assert_eq!(house.circles(), [""; 0]);
}

#[test]
fn an_arrow_to_the_right_is_found_however_it_is_written() {
    let found = |file: &str, module: &[&str], text: &str| {
        let module: Vec<String> = module.iter().map(|&m| m.to_owned()).collect();
        arrows_to_the_right(file, &module, text)
    };
    let bad = [
        ("use crate::solve::Solution;", 1),
        ("\npub use crate::{scene::Scene, measure};", 2),
        ("use crate::{\n    scene::{Scene, Face},\n    output::{self, Stage},\n};", 3),
        ("fn f() {\n    let x = crate::transport::Plan::new;\n}", 2),
        ("use super::super::output::replace;", 1),
        ("mod tests {\n    use super::super::super::solve::solve;\n}", 2),
        ("use super::super::{scene, solve};", 1),
        ("use crate::*;", 1),
        ("use crate as all;", 1),
        ("use crate::Error;", 1),
        ("use crate::{self as all};", 1),
        ("let quote = '\"'; use crate::solve; let other = \"\";", 1),
        ("let url = \"https://\"; use crate::solve;", 1),
        ("fn f<'a>(x: &'a str) -> crate::output::Stage {}", 1),
    ];
    for (text, line) in bad {
        let found = found("src/patches/sides.rs", &["patches", "sides"], text);
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        assert!(found[0].starts_with(&format!("src/patches/sides.rs:{line}: ")), "{text}: {found:?}");
    }
    let good = [
        "use crate::progress::Progress;\nuse crate::{scene::Scene, trace::{Ray, Tracer}, patches};",
        "use super::subdivide::Cuts;",
        "use super::super::trace::Ray;",
        "mod tests {\n    use super::super::solve_nothing;\n    use super::*;\n}",
        "// crate::solve\n//! [`crate::solve`]\n/* use crate::solve; /* nested */ use crate::output; */",
        "let text = \"crate::solve\"; let raw = r#\"\"crate::solve\"\"#; let c = b\"crate::solve\";",
        "pub(crate) fn f() {}\npub(super) fn g() {}",
    ];
    for text in good {
        assert_eq!(found("src/patches/sides.rs", &["patches", "sides"], text), [""; 0], "{text}");
    }
    assert_eq!(found("src/scene/mod.rs", &["scene"], "use super::output;").len(), 1);
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// All Rust files below a folder, sorted.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
        .into_iter()
        .flat_map(|path| match path.is_dir() {
            true => rust_files(&path),
            false => vec![path],
        })
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .collect()
}

fn library_files() -> Vec<PathBuf> {
    let source = root().join("src");
    let files: Vec<PathBuf> =
        rust_files(&source).into_iter().filter(|path| !path.starts_with(source.join("bin"))).collect();
    assert!(files.len() > ORDER.len(), "the library is in {}", source.display());
    files
}

/// `["patches", "sides"]` for `src/patches/sides.rs`; none for the crate's root.
fn module_path(path: &Path) -> Option<Vec<String>> {
    let inside = path.strip_prefix(root().join("src")).ok()?.with_extension("");
    let mut names: Vec<String> = inside.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|name| name == "mod") {
        names.pop();
    }
    (names != ["lib"]).then_some(names)
}

/// A line for every name a file takes from the crate's root that does not stand to its left.
fn arrows_to_the_right(file: &str, module: &[String], text: &str) -> Vec<String> {
    let place = |name: &str| ORDER.iter().position(|&known| known == name);
    let own = place(&module[0]);
    let wrong = |name: &str| place(name).is_none_or(|theirs| own.is_none_or(|own| theirs > own));
    names_from_root(&tokens(text), module)
        .into_iter()
        .filter(|(_, name)| wrong(name))
        .map(|(line, name)| format!("{file}:{line}: {} may not use {name}", module[0]))
        .collect()
}

/// The names that paths starting with `crate` or enough `super`s take from the crate's root, with their
/// lines.
fn names_from_root(tokens: &[Token], module: &[String]) -> Vec<(usize, String)> {
    let is = |at: usize, text: &str| tokens.get(at).is_some_and(|token| token.text == text);
    let mut names = Vec::new();
    // Inline modules that are open, by the depth of braces around them.
    let (mut open, mut depth) = (Vec::new(), 0);
    let mut at = 0;
    while at < tokens.len() {
        match tokens[at].text.as_str() {
            "{" => depth += 1,
            "}" => {
                depth -= 1;
                open.pop_if(|inside| *inside == depth);
            }
            "mod" if is(at + 2, "{") => open.push(depth),
            "crate" | "super" => {
                let mut level = if is(at, "crate") { 0 } else { module.len() + open.len() - 1 };
                while is(at + 1, "::") && is(at + 2, "super") {
                    level = level.saturating_sub(1);
                    at += 2;
                }
                // `pub(crate)` and `pub(super)` take nothing.
                if level == 0 && !is(at + 1, ")") {
                    heads(tokens, at, &mut names);
                }
            }
            _ => {}
        }
        at += 1;
    }
    names
}

/// The names right after the root, which stands at `at`: one, or several in braces; the root's own where none
/// follows.
fn heads(tokens: &[Token], at: usize, names: &mut Vec<(usize, String)>) {
    let mut push = |token: &Token| names.push((token.line, token.text.clone()));
    match (tokens.get(at + 1), tokens.get(at + 2)) {
        (Some(colons), Some(brace)) if colons.text == "::" && brace.text == "{" => {
            let mut depth = 0;
            for pair in tokens[at + 2..].windows(2) {
                depth += i32::from(pair[0].text == "{") - i32::from(pair[0].text == "}");
                match pair[0].text.as_str() {
                    "{" | "," if depth == 1 && pair[1].text != "}" => push(&pair[1]),
                    "}" if depth == 0 => break,
                    _ => {}
                }
            }
        }
        (Some(colons), Some(name)) if colons.text == "::" => push(name),
        _ => push(&tokens[at]),
    }
}
