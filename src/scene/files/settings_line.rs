//! Which line of a settings file a message is about: its reader knows the line of a table's head, where its
//! author looks for the key.

/// The line, from 1, on which a byte of a text lies.
pub(crate) fn line_at(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|&byte| byte == b'\n').count()
}

/// The line, from 1, of what a message says of the table or key that begins at byte `start`. `refusal` is
/// what the reader says of a text, if it refuses it.
pub(crate) fn line_of(
    text: &str,
    start: usize,
    message: &str,
    refusal: impl Fn(&str) -> Option<String>,
) -> usize {
    let head = line_at(text, start) - 1;
    let lines: Vec<&str> = text.lines().collect();
    let is_head = |line: &&str| line.trim_start().starts_with('[');
    if !lines.get(head).is_some_and(is_head) || message.starts_with("missing field") {
        return head + 1;
    }
    let keys: Vec<(usize, &str)> = (head + 1..lines.len())
        .take_while(|&k| !is_head(&lines[k]))
        .filter_map(|k| Some((k, lines[k].split_once('=')?.0.trim())))
        .collect();
    // What a message is about stands before what it expects.
    let about = message.split(", expected").next().unwrap_or(message);
    let words: Vec<&str> = about.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
    let mut named = keys.iter().filter(|(_, key)| words.contains(key));
    let named = named.next().filter(|_| named.next().is_none());
    // If it names no key or several, it is about the line without which it would not be said.
    let needed = || {
        refusal(text).filter(|said| said == message)?;
        keys.iter().find(|&&(k, key)| {
            let mut rest = lines.clone();
            rest[k] = "";
            key != "kind" && refusal(&rest.join("\n")).as_deref() != Some(message)
        })
    };
    named.or_else(needed).map_or(head, |(k, _)| *k) + 1
}

/// The key that a line, from 1, gives a value, or that a line above it begins to; of a table's head its name.
pub(crate) fn key_at(text: &str, line: usize) -> &str {
    let above = text.lines().take(line).map(str::trim).collect::<Vec<_>>().into_iter().rev();
    let key = |line: &'_ str| match line.starts_with('[') {
        true => line.find(']').map(|end| (1, end)),
        false => line.find('=').map(|end| (0, end)),
    };
    let is_comment = |line: &&str| line.starts_with('#');
    let mut keys =
        above.filter(|line| !is_comment(line)).filter_map(|line| key(line).map(|(a, b)| &line[a..b]));
    keys.next().unwrap_or_default().trim_start_matches('[').trim()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "unit = 1.0\n\n[[light]]\nkind = \"spot\"\n# aimed\ncone = 30\nposition = [0, 1]\n\n[sky]\ncone = 1\n";

    fn line(start: &str, message: &str) -> usize {
        let refusal = |text: &str| text.contains("[0, 1]").then(|| "invalid length 2".to_owned());
        line_of(TEXT, TEXT.find(start).unwrap(), message, refusal)
    }

    #[test]
    fn messages_lead_to_the_key_that_they_name() {
        assert_eq!(line("[[light]]", "light: cone of 200 degrees"), 6);
        assert_eq!(line("[[light]]", "unknown field `cone`, expected one of `kind`, `position`"), 6);
        assert_eq!(line("[sky]", "sky: cone"), 10);
    }

    #[test]
    fn lines_tell_of_the_key_that_they_are_part_of() {
        let text = "unit = 1.0\n[[light]]\nposition = [\n  # x = 1\n  0, 1,\n]\n[material.\"m 1\"] # =\n";
        let keys = [1, 2, 3, 5].map(|line| key_at(text, line));
        assert_eq!((keys, key_at(text, 7)), (["unit", "light", "position", "position"], "material.\"m 1\""));
        assert_eq!(key_at("", 1), "");
    }

    #[test]
    fn messages_that_name_no_key_lead_to_the_line_that_they_need() {
        assert_eq!(line("[[light]]", "invalid length 2"), 7);
    }

    #[test]
    fn other_messages_lead_to_the_head_or_to_where_they_begin() {
        assert_eq!(line("[[light]]", "missing field `target`"), 3);
        assert_eq!(line("[[light]]", "light: lamp.ies is not there"), 3);
        assert_eq!(line("[[light]]", "light: give cone or position"), 3);
        assert_eq!(line("cone = 30", "invalid"), 6);
        assert_eq!(line_of("", 0, "missing field `x`", |_| None), 1);
    }
}
