//! Lines: a material library, every line checked once and put in the form that `tobj` reads: colours of three
//! numbers, no line before a name.
//!
//! A number that no scene can have is an error; a line that makes no sense is left out, and counted.

use std::path::Path;

use crate::scene::files::text::{and_more, lines, numbers, split};
use crate::scene::spelled::spelled;
use crate::scene::{FARTHEST_ON_PICTURE, LARGEST, SceneError};

/// A library's text for `tobj`, and what is to be said of lines that were left out.
pub(super) fn plain(path: &Path, text: &str) -> Result<(String, Option<String>), SceneError> {
    let mut plain = String::with_capacity(text.len());
    let mut left_out: Vec<(usize, String)> = Vec::new();
    for (number, line) in lines(text) {
        let (key, rest) = split(&line);
        if plain.is_empty() && key != "newmtl" {
            continue;
        }
        match value(key, rest) {
            Ok(rest) => plain.extend([key, " ", &rest, "\n"]),
            Err(Wrong::Line(message)) => left_out.push((number, message)),
            Err(Wrong::Number(message)) => {
                return Err(SceneError::Parse { path: path.to_path_buf(), line: number, message });
            }
        }
    }
    let said = left_out.first().map(|(line, message)| {
        let more = and_more(left_out.len() - 1);
        format!("{}:{line}: {message}; the line is left out{more}", path.display())
    });
    Ok((plain, said))
}

/// What is wrong with a line.
enum Wrong {
    /// It makes no sense.
    Line(String),
    /// A number of it is none that a scene can have.
    Number(String),
}

/// What follows a key, spelled out.
fn value(key: &str, rest: &str) -> Result<String, Wrong> {
    let no_sense = |message: &str| Err(Wrong::Line(format!("{key} must be followed by {message}")));
    let numbers = numbers(rest);
    let is_number = matches!(key, "Ka" | "Kd" | "Ks" | "Ke" | "Tf" | "Ns" | "Ni" | "d" | "Pr" | "Pm");
    if let Some(wrong) = numbers.iter().flatten().find(|x| is_number && !(0.0..=LARGEST).contains(&x.abs())) {
        return Err(Wrong::Number(format!(
            "{key} is {}, and must be a number up to {LARGEST:e}",
            spelled(*wrong)
        )));
    }
    if let Some(wrong) = beyond_on_picture(key, rest) {
        let limit = FARTHEST_ON_PICTURE;
        return Err(Wrong::Number(format!("{wrong} of {key}: -s and -o take numbers up to {limit:e}")));
    }
    match key {
        "Ka" | "Kd" | "Ks" | "Ke" | "Tf" => match numbers.as_deref() {
            Some(&[grey]) => Ok(format!("{grey:e} {grey:e} {grey:e}")),
            Some([r, g, b]) => Ok(format!("{r:e} {g:e} {b:e}")),
            _ => no_sense("one or three numbers"),
        },
        "Ns" | "Ni" | "d" => match numbers.as_deref() {
            Some([number, ..]) if *number >= 0.0 => Ok(format!("{number:e}")),
            _ => no_sense("a number that is not negative"),
        },
        "Pr" | "Pm" => match numbers.as_deref() {
            Some([number, ..]) if (0.0..=1.0).contains(number) => Ok(format!("{number:e}")),
            _ => no_sense("a number from 0 to 1"),
        },
        "illum" => match rest.split_whitespace().next().and_then(|word| word.parse::<u8>().ok()) {
            Some(model) => Ok(model.to_string()),
            None => no_sense("the number of a model, 0 to 10"),
        },
        "newmtl" if rest.is_empty() => Ok(super::NONE.into()),
        "bump" if rest.is_empty() => no_sense("the name of a file"),
        map if map.starts_with("map_") && rest.is_empty() => no_sense("the name of a file"),
        _ => Ok(rest.to_owned()),
    }
}

/// A number behind `-s` or `-o` of a picture that is none, or too large.
fn beyond_on_picture<'a>(key: &str, rest: &'a str) -> Option<&'a str> {
    if !key.starts_with("map_") {
        return None;
    }
    let mut words = rest.split_whitespace();
    while let Some(option) = words.next() {
        if !matches!(option, "-s" | "-o") {
            continue;
        }
        let numbers = words.clone().take(3).map_while(|word| Some((word, word.parse::<f64>().ok()?)));
        let wrong = numbers.into_iter().find(|(_, x)| !(0.0..=FARTHEST_ON_PICTURE).contains(&x.abs()));
        if let Some((word, _)) = wrong {
            return Some(word);
        }
    }
    None
}
