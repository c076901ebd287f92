//! The house: which file needs what of which other, names that are re-exported counted where they come from.

use std::collections::{BTreeMap, BTreeSet};

use super::tokens::{Token, is_name, tokens, without_tests};

/// A module or a name in one, from the crate's root.
type Path = Vec<String>;

/// The modules of a crate, each with the names it uses.
pub struct House {
    uses: BTreeMap<Path, BTreeSet<Path>>,
    /// What a name that a module re-exports stands for.
    stands_for: BTreeMap<Path, Path>,
}

/// A name that one module takes from another.
pub struct Arrow {
    from: Path,
    to: Path,
    name: String,
}

impl House {
    /// Reads modules, each with its text; tests in them are left out.
    pub fn new(files: Vec<(Path, String)>) -> Self {
        let modules: BTreeSet<Path> = files.iter().map(|(module, _)| module.clone()).collect();
        let mut house = Self { uses: BTreeMap::new(), stands_for: BTreeMap::new() };
        for (module, text) in &files {
            let reader = Reader { module, modules: &modules, tokens: without_tests(tokens(text)) };
            let used = reader.read(&mut house.stands_for);
            house.uses.insert(module.clone(), used);
        }
        house
    }

    /// Every name that a module takes from another that is neither around it nor inside it.
    pub fn arrows(&self) -> Vec<Arrow> {
        let of = |(from, used): (&Path, &BTreeSet<Path>)| -> Vec<Arrow> {
            let arrow = |path: &Path| {
                let (to, name) = self.origin(path.clone());
                let related = to.starts_with(from) || from.starts_with(&to);
                (!related).then(|| Arrow { from: from.clone(), to, name })
            };
            used.iter().filter_map(arrow).collect()
        };
        self.uses.iter().flat_map(of).collect()
    }

    /// A line for every arrow between two modules, or folders of modules, that need each other.
    pub fn circles(&self) -> Vec<String> {
        // Per folder, which of what is in it needs which other.
        let mut needs: BTreeMap<Path, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
        let arrows = self.arrows();
        let fork = |arrow: &Arrow| {
            let depth = arrow.from.iter().zip(&arrow.to).take_while(|(a, b)| a == b).count();
            (arrow.from[..depth].to_vec(), arrow.from[depth].clone(), arrow.to[depth].clone())
        };
        for arrow in &arrows {
            let (folder, from, to) = fork(arrow);
            needs.entry(folder).or_default().entry(from).or_default().insert(to);
        }
        let leads = |folder: &Path, from: &String, to: &String| {
            let (mut known, mut ahead) = (BTreeSet::from([from]), vec![from]);
            while let Some(here) = ahead.pop() {
                let next = needs[folder].get(here).into_iter().flatten();
                ahead.extend(next.filter(|&next| known.insert(next)));
            }
            known.contains(to)
        };
        let told = |arrow: &Arrow| {
            let (folder, from, to) = fork(arrow);
            let line =
                || format!("{} needs {} of {}", arrow.from.join("::"), arrow.name, arrow.to.join("::"));
            leads(&folder, &to, &from).then(line)
        };
        arrows.iter().filter_map(told).collect()
    }

    /// The module where a name is defined, and the name.
    fn origin(&self, mut path: Path) -> (Path, String) {
        loop {
            let depth = (1..=path.len()).rev().find(|&k| self.uses.contains_key(&path[..k])).unwrap_or(0);
            let name = path.get(depth).cloned().unwrap_or_default();
            match path.get(..depth + 1).and_then(|head| self.stands_for.get(head)) {
                Some(origin) if origin[..] != path[..depth + 1] => {
                    path = [&origin[..], &path[depth + 1..]].concat();
                }
                _ => return (path[..depth].to_vec(), name),
            }
        }
    }
}

/// One file that is read.
struct Reader<'a> {
    module: &'a Path,
    modules: &'a BTreeSet<Path>,
    tokens: Vec<Token>,
}

impl Reader<'_> {
    fn is(&self, at: usize, text: &str) -> bool {
        self.tokens.get(at).is_some_and(|token| token.text == text)
    }

    /// All paths from the root that the file names; what it re-exports is added to `stands_for`.
    fn read(&self, stands_for: &mut BTreeMap<Path, Path>) -> BTreeSet<Path> {
        let mut used = BTreeSet::new();
        // Modules that can be named by their last name alone.
        let mut at_hand: BTreeMap<String, Path> = BTreeMap::new();
        let mut at = 0;
        while at < self.tokens.len() {
            // `use<'a>` in a bound takes nothing.
            if self.is(at, "use") && !self.is(at + 1, "<") {
                let is_public = at > 0 && (self.is(at - 1, "pub") || self.is(at - 1, ")"));
                let mut leaves = Vec::new();
                at = self.leaves(at + 1, &[], &mut leaves);
                for (path, name) in
                    leaves.into_iter().filter_map(|(path, name)| Some((self.in_full(&path)?, name)))
                {
                    if is_public {
                        stands_for
                            .insert([&self.module[..], std::slice::from_ref(&name)].concat(), path.clone());
                    }
                    if self.modules.contains(&path) {
                        at_hand.insert(name, path.clone());
                    }
                    used.insert(path);
                }
                continue;
            }
            let starts =
                !(at > 0 && (self.is(at - 1, "::") || self.is(at - 1, "."))) && self.is(at + 1, "::");
            if starts {
                let mut path = vec![self.tokens[at].text.clone()];
                while self.is(at + 1, "::")
                    && self.tokens.get(at + 2).is_some_and(|token| is_name(&token.text))
                {
                    path.push(self.tokens[at + 2].text.clone());
                    at += 2;
                }
                let known = at_hand.get(&path[0]).map(|module| [&module[..], &path[1..]].concat());
                used.extend(known.or_else(|| self.in_full(&path)));
            }
            at += 1;
        }
        used
    }

    /// The leaves of a tree of names that starts at `at`, each with the name it goes by; answers where the
    /// tree ends.
    fn leaves(&self, mut at: usize, head: &[String], leaves: &mut Vec<(Path, String)>) -> usize {
        let mut path = head.to_vec();
        loop {
            match self.tokens[at].text.as_str() {
                "{" => {
                    at += 1;
                    while !self.is(at, "}") {
                        at = self.leaves(at, &path, leaves);
                        at += usize::from(self.is(at, ","));
                    }
                    return at + 1;
                }
                "::" => at += 1,
                "," | "}" | ";" => break,
                "as" => {
                    leaves.push((path, self.tokens[at + 1].text.clone()));
                    return at + 2;
                }
                name => {
                    path.push(name.to_owned());
                    at += 1;
                }
            }
        }
        path.pop_if(|last| last == "self" || last == "*");
        if let Some(name) = path.last().cloned() {
            leaves.push((path, name));
        }
        at
    }

    /// A path from the root, if it leads to a module of this crate.
    fn in_full(&self, path: &[String]) -> Option<Path> {
        let ups = path.iter().take_while(|name| *name == "super").count();
        let inside = |rest: &[String]| [&self.module[..], rest].concat();
        match path[0].as_str() {
            "crate" => Some(path[1..].to_vec()),
            "super" => Some([&self.module[..self.module.len() - ups], &path[ups..]].concat()),
            "self" => Some(inside(&path[1..])),
            _ => self.modules.contains(&inside(&path[..1])).then(|| inside(path)),
        }
    }
}

#[test]
fn files_and_folders_that_need_each_other_are_found_however_the_name_is_taken() {
    let house = |files: &[(&str, &str)]| {
        let path = |module: &str| module.split('/').map(str::to_owned).collect();
        House::new(files.iter().map(|&(module, text)| (path(module), text.to_owned())).collect())
    };
    let rooms = [
        ("a", "mod x;\nmod y;\npub use x::{One, Two as Other};"),
        ("a/x", "pub struct One;\npub struct Two;"),
        ("a/y", "pub struct Three;"),
        ("b", "pub struct Four;"),
    ];
    let with = |module: &str, text: &str| {
        let change = |&(known, old): &(&'static str, &'static str)| (known.to_owned(), old.to_owned());
        let mut files: Vec<(String, String)> = rooms.iter().map(change).collect();
        files.iter_mut().find(|(known, _)| known == module).unwrap().1 += text;
        files
    };
    let circles = |files: &[(String, String)]| {
        let files: Vec<(&str, &str)> = files.iter().map(|(m, t)| (m.as_str(), t.as_str())).collect();
        house(&files).circles()
    };
    assert_eq!(house(&rooms).circles(), [""; 0]);
    // One way is none.
    assert_eq!(circles(&with("a/y", "use super::Other;")), [""; 0]);
    assert_eq!(circles(&with("b", "use crate::a::One;")), [""; 0]);
    // Both ways, by a name that is re-exported, in a path, by a module's last name, in a deeper file.
    for text in
        ["use super::y::Three;", "fn f() -> super::y::Three {}", "use super::y;\nfn f(_: y::Three) {}"]
    {
        let mut files = with("a/y", "use super::Other;");
        files[1].1 += text;
        let found = circles(&files);
        assert!(found.len() >= 2 && found[0].starts_with("a::x needs"), "{text}: {found:?}");
    }
    let mut files = with("b", "use crate::a::{One};");
    files[2].1 += "use crate::b::Four;";
    assert_eq!(circles(&files), ["a::y needs Four of b", "b needs One of a::x"]);
    // Parents and children may.
    assert_eq!(circles(&with("a/x", "use super::Other;")), [""; 0]);
    // Tests are left out.
    let mut files = with("b", "use crate::a::One;");
    files[2].1 += "mod tests { use crate::b::Four; }";
    assert_eq!(circles(&files), [""; 0]);
}
