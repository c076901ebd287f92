//! Text: files of words and numbers as programs write them, whatever their encoding.

use std::borrow::Cow;

/// Turns bytes into text: UTF-8 or UTF-16, with a byte order mark or without; what is neither keeps its
/// letters of ASCII.
pub(crate) fn decode(bytes: &[u8]) -> String {
    let utf16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        char::decode_utf16(units).map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        // The first letters of such files are of ASCII: every other byte is 0.
        [first, 0, second, 0, ..] if *first != 0 && *second != 0 => utf16(bytes, u16::from_le_bytes),
        [0, first, 0, second, ..] if *first != 0 && *second != 0 => utf16(bytes, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => String::from_utf8_lossy(bytes).into_owned(),
    }
}

/// The lines of a text, each with its number from 1; those that end in `\` go on in the next.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut rest = (1..).zip(text.lines());
    std::iter::from_fn(move || {
        let (number, line) = rest.next()?;
        let begun = line.trim_end().strip_suffix('\\').filter(|line| !line.trim_start().starts_with('#'));
        let Some(begun) = begun else { return Some((number, line.into())) };
        let mut whole = begun.to_owned();
        for (_, line) in rest.by_ref() {
            whole.push(' ');
            let goes_on = line.trim_end().strip_suffix('\\');
            whole.push_str(goes_on.unwrap_or(line));
            if goes_on.is_none() {
                break;
            }
        }
        Some((number, whole.into()))
    })
}

/// What is said of more lines like one.
pub(crate) fn and_more(count: usize) -> String {
    match count {
        0 => String::new(),
        1 => " (and 1 more such line)".into(),
        count => format!(" (and {count} more such lines)"),
    }
}

/// The first word of a line, and the rest without space around it.
pub(crate) fn split(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (key, rest.trim_start())
}

/// Numbers up to a comment; none if a word is no number.
pub(crate) fn numbers(words: &str) -> Option<Vec<f64>> {
    uncommented(words).map(|word| word.parse().ok()).collect()
}

/// Words up to a comment.
pub(crate) fn uncommented(words: &str) -> impl Iterator<Item = &str> {
    words.split_whitespace().take_while(|word| !word.starts_with('#'))
}

/// A name without the comment behind it, which begins with a `#` after a space.
pub(crate) fn named(name: &str) -> &str {
    let comment = name
        .match_indices('#')
        .map(|(at, _)| at)
        .find(|&at| at == 0 || name[..at].ends_with(char::is_whitespace));
    name[..comment.unwrap_or(name.len())].trim_end()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_the_same_in_every_encoding() {
        let text = "v 1 2 3\nusemtl grün\n";
        let units: Vec<u16> = text.encode_utf16().collect();
        let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
        for (mark, bytes) in [
            (&[][..], text.as_bytes()),
            (&[0xef, 0xbb, 0xbf], text.as_bytes()),
            (&[], &little),
            (&[0xff, 0xfe], &little),
            (&[], &big),
            (&[0xfe, 0xff], &big),
        ] {
            assert_eq!(decode(&[mark, bytes].concat()), text, "{mark:?}");
        }
        assert_eq!(decode(b"o gr\xfcn"), "o gr\u{fffd}n");
        assert_eq!(decode(b""), "");
    }

    #[test]
    fn lines_go_on_after_a_backslash() {
        let text = "f 1 2 \\\n 3 \\ \r\n4\nv 1\\\nend\\\n\n# C:\\\nv 2";
        let found: Vec<(usize, String)> = lines(text).map(|(k, line)| (k, line.into_owned())).collect();
        let wanted = [(1, "f 1 2   3  4"), (4, "v 1 end "), (7, "# C:\\"), (8, "v 2")];
        assert_eq!(found, wanted.map(|(k, line)| (k, line.to_owned())));
    }

    #[test]
    fn names_end_before_a_comment() {
        for (line, name) in
            [("wall # of brick", "wall"), ("wall#1", "wall#1"), ("# none", ""), ("a b #", "a b"), ("", "")]
        {
            assert_eq!(named(line), name);
        }
    }
}
