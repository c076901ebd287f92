//! Grouped: things to be said of many, one sentence per kind.

/// What is said, each with the names of those of whom it is said.
#[derive(Debug, Default)]
pub(super) struct Grouped(Vec<(String, Vec<String>)>);

/// So many names are written out.
const NAMED: usize = 4;

impl Grouped {
    /// Says something of a name.
    pub fn say(&mut self, name: &str, what: impl Into<String>) {
        let what = what.into();
        match self.0.iter_mut().find(|(known, _)| *known == what) {
            Some((_, names)) if names.iter().any(|known| known == name) => {}
            Some((_, names)) => names.push(name.to_owned()),
            None => self.0.push((what, vec![name.to_owned()])),
        }
    }

    /// A sentence per kind; `noun` is what the names are of.
    pub fn sentences(&self, noun: &str) -> impl Iterator<Item = String> {
        self.0.iter().map(move |(what, names)| match &names[..] {
            [name] => format!("{noun} {name}: {what}"),
            names if names.len() <= NAMED => {
                format!("{} {noun}s ({}): {what}", names.len(), names.join(", "))
            }
            names => {
                let more = names.len() - NAMED;
                format!("{} {noun}s ({} and {more} more): {what}", names.len(), names[..NAMED].join(", "))
            }
        })
    }
}
