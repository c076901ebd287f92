//! What the reader of settings refuses, in words of TOML: it tells of Rust's types, and names no key.

/// What the reader says about a key, in words that an author of settings knows.
pub(super) fn in_words(message: &str, key: &str) -> String {
    if let Some(field) = quoted(message, "missing field `") {
        return format!("{key}: {field} is missing");
    }
    if let Some(field) = quoted(message, "unknown field `") {
        return format!("{field}: there is no such key here; there are {}", choices(message));
    }
    if let Some(field) = quoted(message, "duplicate field `") {
        return format!("{field}: it is given twice; keep one");
    }
    let mismatch = ["invalid type: ", "invalid value: "].iter().find_map(|start| message.strip_prefix(start));
    if let Some((found, expected)) = mismatch.and_then(|rest| rest.rsplit_once(", expected ")) {
        return format!("{key}: {} stands where {} should", value(found), wanted(expected));
    }
    format!("{key}: {message}")
}

/// What stands between the start of a message, which ends with a backquote, and the next backquote.
fn quoted<'m>(message: &'m str, start: &str) -> Option<&'m str> {
    message.strip_prefix(start)?.split('`').next()
}

/// The names from which to choose, each in backquotes after what was found.
fn choices(message: &str) -> String {
    let names = message.split(", expected ").nth(1).unwrap_or_default().split('`').skip(1).step_by(2);
    names.filter(|&name| name != "color").collect::<Vec<_>>().join(", ")
}

/// A value, without the name of its type.
fn value(found: &str) -> &str {
    match found {
        "map" => "a table",
        "sequence" => "a list",
        _ => found.strip_prefix("string ").or_else(|| found.split('`').nth(1)).unwrap_or(found),
    }
}

fn wanted(expected: &str) -> &str {
    match expected {
        "f64" => "a number",
        "usize" => "a whole number, 0 or more,",
        "a string" => "text in quotes",
        "path string" => "the name of a file, in quotes,",
        "a boolean" => "true or false",
        "a sequence" => "a list in brackets",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_of_rust_are_told_as_values_of_toml() {
        for (message, words) in [
            ("missing field `cone`", "cone: cone is missing"),
            (
                "unknown field `Kd`, expected one of `colour`, `color`, `thin`",
                "Kd: there is no such key here; there are colour, thin",
            ),
            (
                "unknown field `Kd`, expected `thin` or `emission`",
                "Kd: there is no such key here; there are thin, emission",
            ),
            (
                "invalid type: string \"a, expected b\", expected f64",
                "cone: \"a, expected b\" stands where a number should",
            ),
            (
                "invalid value: integer `-1`, expected usize",
                "cone: -1 stands where a whole number, 0 or more, should",
            ),
            ("invalid type: sequence, expected f64", "cone: a list stands where a number should"),
            ("2 in place of 3 values", "cone: 2 in place of 3 values"),
        ] {
            assert_eq!(in_words(message, "cone"), words);
        }
    }
}
