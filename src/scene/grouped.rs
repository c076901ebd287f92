//! Grouped: things to be said of many, one sentence per kind.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// So many names are written out.
const NAMED: usize = 4;

/// `1 face`, `2 faces`.
pub(super) fn count(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

/// What is said, each with the names of those of whom it is said.
#[derive(Debug, Default)]
pub(super) struct Grouped {
    kinds: Vec<(String, Names)>,
    places: HashMap<String, usize>,
}

impl Grouped {
    /// Says something of a name.
    pub fn say(&mut self, name: &str, what: impl Into<String>) {
        let place = match self.places.entry(what.into()) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(new) => {
                self.kinds.push((new.key().clone(), Names::default()));
                *new.insert(self.kinds.len() - 1)
            }
        };
        self.kinds[place].1.add(name);
    }

    /// A sentence per kind; `noun` is what the names are of.
    pub fn sentences(&self, noun: &str) -> impl Iterator<Item = String> {
        self.kinds.iter().map(move |(what, names)| match names.len() {
            1 => format!("{noun} {names}: {what}"),
            count => format!("{count} {noun}s ({names}): {what}"),
        })
    }
}

/// Names, each once, in the order of their first mention.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// The first few.
    first: Vec<String>,
    all: std::collections::HashSet<String>,
}

impl Names {
    /// Adds a name.
    pub fn add(&mut self, name: &str) {
        if self.all.insert(name.to_owned()) && self.first.len() < NAMED {
            self.first.push(name.to_owned());
        }
    }

    /// Whether a name is among them.
    pub fn contain(&self, name: &str) -> bool {
        self.all.contains(name)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }
}

impl<'a> FromIterator<&'a str> for Names {
    fn from_iter<I: IntoIterator<Item = &'a str>>(names: I) -> Self {
        let mut all = Self::default();
        names.into_iter().for_each(|name| all.add(name));
        all
    }
}

/// The first few, and how many more.
impl std::fmt::Display for Names {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.first.join(", "))?;
        match self.len() - self.first.len() {
            0 => Ok(()),
            more => write!(f, " and {more} more"),
        }
    }
}
