//! Words: how lists of names are told.

/// The first of several names, `most` at the most: `a, b, c and 12 more`.
///
/// # Panics
/// If there are none.
pub(super) fn few(names: &[String], most: usize) -> String {
    match names {
        [one] => one.clone(),
        [rest @ .., last] if names.len() <= most => format!("{} and {last}", rest.join(", ")),
        _ => format!("{} and {} more", names[..most].join(", "), names.len() - most),
    }
}
