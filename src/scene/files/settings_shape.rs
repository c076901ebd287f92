//! The shape of a settings file: which tables it has, in which brackets, and of which kind they are. What is
//! wrong with that is told here; the reader of the tables would tell it by the names of types.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Tables of which a file has one.
const ONE: [&str; 2] = ["camera", "sky"];

/// Tables of which it may have several.
const SEVERAL: [&str; 2] = ["light", "receiver"];

/// Tables whose `kind` must be told, or may be, and the kinds that there are.
const KINDS: [(&str, &[&str]); 3] = [
    ("light", &["point", "spot", "ies", "sun"]),
    ("sky", &["constant", "overcast", "cie", "environment", "clear"]),
    (RECEIVER, &["planar", "cylindrical"]),
];

/// The head of a material's table.
const MATERIAL: &str = "[material.NAME], with the name of a material,";

/// A table of the usual kind where none is told.
const RECEIVER: &str = "receiver";

/// What is wrong, and with what begins at which byte.
type Wrong = (usize, String);

/// Looks for what is wrong with the tables of a file, or with its being a file of tables at all.
pub(super) fn check(text: &str) -> Result<(), Wrong> {
    let file =
        DeTable::parse(text).map_err(|e| (e.span().map_or(0, |span| span.start), e.message().to_owned()))?;
    file.get_ref().iter().try_for_each(|(key, value)| check_entry(key.get_ref(), value))
}

fn check_entry(key: &str, value: &Spanned<DeValue>) -> Result<(), Wrong> {
    let wrong = |at: &Spanned<DeValue>, message: String| Err((at.span().start, format!("{key}: {message}")));
    match value.get_ref() {
        DeValue::Table(table) if ONE.contains(&key) => check_kind(key, value, table),
        DeValue::Array(_) if ONE.contains(&key) => {
            wrong(value, format!("there is no more than one: write [{key}] in single brackets"))
        }
        DeValue::Array(all) if SEVERAL.contains(&key) => all.iter().try_for_each(|one| match one.get_ref() {
            DeValue::Table(table) => check_kind(key, one, table),
            other => wrong(one, no_table(other, &format!("[[{key}]]"))),
        }),
        DeValue::Table(_) if SEVERAL.contains(&key) => {
            wrong(value, format!("there may be several: write [[{key}]] in double brackets"))
        }
        other if ONE.contains(&key) => wrong(value, no_table(other, &format!("[{key}]"))),
        other if SEVERAL.contains(&key) => wrong(value, no_table(other, &format!("[[{key}]]"))),
        DeValue::Table(all) if key == "material" => {
            let is_table = |one: &&Spanned<DeValue>| one.get_ref().is_table();
            match all.values().find(|one| !is_table(one)) {
                Some(list) if list.get_ref().is_array() => {
                    wrong(list, "write [material.NAME] in single brackets, once for each material".into())
                }
                Some(other) => wrong(other, no_table(other.get_ref(), MATERIAL)),
                None => Ok(()),
            }
        }
        other if key == "material" => wrong(value, no_table(other, MATERIAL)),
        _ => Ok(()),
    }
}

/// What to say of a value in place of a table with this head.
fn no_table(value: &DeValue, head: &str) -> String {
    format!(
        "{} stands where a table should; write {head} on a line of its own, and its keys below it",
        as_written(value)
    )
}

fn check_kind(key: &str, whole: &Spanned<DeValue>, table: &DeTable) -> Result<(), Wrong> {
    let Some((_, kinds)) = KINDS.into_iter().find(|(known, _)| *known == key) else { return Ok(()) };
    let all = kinds.iter().map(|kind| format!("\"{kind}\"")).collect::<Vec<_>>().join(", ");
    let given = |name: &str| table.iter().find(|(key, _)| key.get_ref() == name).map(|(_, value)| value);
    let (at, message) = match (given("kind"), given("type")) {
        (Some(kind), _) if kind.get_ref().as_str().is_some_and(|kind| kinds.contains(&kind)) => return Ok(()),
        (Some(kind), _) => (kind, format!("kind = {} is none of {all}", as_written(kind.get_ref()))),
        (None, Some(word)) if word.get_ref().is_str() => {
            (word, format!("write kind in place of type, one of {all}"))
        }
        (None, _) if key == RECEIVER => return Ok(()),
        (None, _) => (whole, format!("kind is missing; write kind = one of {all}")),
    };
    Err((at.span().start, format!("{key}: {message}")))
}

/// A value as it stands in the file, or what it is where that is long.
fn as_written(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("{text:?}"),
        DeValue::Integer(number) => number.as_str().to_owned(),
        DeValue::Float(number) => number.as_str().to_owned(),
        DeValue::Boolean(truth) => truth.to_string(),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
