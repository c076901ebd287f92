//! How much a function takes: few parameters, and a tuple hides none, for it counts as what is in it.

use super::tokens::{Token, is_name, tokens, without_tests};
use super::{read, root, rust_files};

/// The most that a function takes, `self` included.
const MOST: usize = 5;

/// A line for every function, outside of tests, that takes more than [`MOST`].
fn that_take_too_much(file: &str, text: &str) -> Vec<String> {
    let tokens = without_tests(tokens(text));
    let functions = tokens.windows(2).enumerate();
    let told = |(at, pair): (usize, &[Token])| {
        let is_function = pair[0].text == "fn" && is_name(&pair[1].text);
        let count = if is_function { parameters(&tokens[at + 2..]) } else { 0 };
        (count > MOST).then(|| format!("{file}:{}: {} takes {count}", pair[0].line, pair[1].text))
    };
    functions.filter_map(told).collect()
}

/// The number of a function's parameters, tuples counted by their parts; its tokens start behind its name.
fn parameters(tokens: &[Token]) -> usize {
    // Generics come first, and a bound in them may have parentheses of its own.
    let start = if tokens[0].text == "<" { closed(tokens) } else { 0 };
    parts(&tokens[start..]).into_iter().map(worth).sum()
}

/// What a parameter counts: the parts of a tuple in its pattern or in its type, whichever is more.
fn worth(parameter: &[Token]) -> usize {
    let colon = parameter.iter().position(|token| token.text == ":");
    let (pattern, of_type) = parameter.split_at(colon.unwrap_or(parameter.len()));
    leaves(pattern).max(leaves(of_type.get(1..).unwrap_or_default()))
}

/// The parts of a tuple and of the tuples in it; one for anything else.
fn leaves(mut tokens: &[Token]) -> usize {
    loop {
        match tokens {
            [sign, rest @ ..] if sign.text == "&" || sign.text == "mut" => tokens = rest,
            [quote, _, rest @ ..] if quote.text == "'" => tokens = rest,
            [open, ..] if open.text == "(" && closed(tokens) == tokens.len() => {
                return parts(tokens).into_iter().map(leaves).sum();
            }
            _ => return 1,
        }
    }
}

/// Where the bracket that comes first has been closed.
fn closed(tokens: &[Token]) -> usize {
    let mut depth = 0;
    let ends = |at: usize| {
        depth += step(tokens, at);
        depth == 0
    };
    (0..tokens.len()).position(ends).expect("a bracket that is closed") + 1
}

/// What commas separate in the bracket that comes first.
fn parts(tokens: &[Token]) -> Vec<&[Token]> {
    let inside = &tokens[1..closed(tokens) - 1];
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for at in 0..inside.len() {
        depth += step(inside, at);
        if depth == 0 && inside[at].text == "," {
            parts.push(&inside[start..at]);
            start = at + 1;
        }
    }
    if start < inside.len() {
        parts.push(&inside[start..]);
    }
    parts
}

/// How a token changes the number of open brackets; the arrow of `->` closes none.
fn step(tokens: &[Token], at: usize) -> i32 {
    match tokens[at].text.as_str() {
        "(" | "[" | "{" | "<" => 1,
        ">" if at > 0 && tokens[at - 1].text == "-" => 0,
        ")" | "]" | "}" | ">" => -1,
        _ => 0,
    }
}

#[test]
fn no_function_takes_more_than_five_parameters_not_even_in_tuples() {
    let files = rust_files(&root().join("src"));
    assert!(files.len() > 100, "{} files", files.len());
    let wrong: Vec<String> =
        files.iter().flat_map(|path| that_take_too_much(&path.display().to_string(), &read(path))).collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn parameters_are_counted_however_they_are_written() {
    let known = [
        ("fn f() {}", 0),
        ("fn f(&self) {}", 1),
        ("fn f(a: f64, b: f64,) {}", 2),
        ("fn f((a, b): (f64, f64)) {}", 2),
        ("fn f(&(a, b): &(f64, f64), c: f64) {}", 3),
        ("fn f(pair: (f64, f64)) {}", 2),
        ("fn f(pair: &'a mut (f64, f64)) {}", 2),
        ("fn f((face, side): FaceSide) {}", 2),
        ("fn f((a, b): (f64, (f64, f64))) {}", 3),
        ("fn f(self, (a, (b, c)): (f64, (f64, f64)), d: Vec<(f64, f64)>) {}", 5),
        ("fn f([a, b]: [f64; 2], map: BTreeMap<u32, f64>) {}", 2),
        ("fn f(of: impl Fn(f64, f64) -> f64, also: &(dyn Fn(f64, f64) -> f64 + Sync)) {}", 2),
        ("fn f(of: fn(f64, f64) -> f64) -> (f64, f64) {}", 1),
        ("fn f<'a, T: Fn(f64, f64) -> f64, const N: usize>(of: &'a T, n: [f64; N]) {}", 2),
        ("fn f(a: f64, // (b, c): (f64, f64)\n) {}", 1),
    ];
    for (text, count) in known {
        assert_eq!(parameters(&tokens(text)[2..]), count, "{text}");
    }
}

#[test]
fn a_function_of_too_many_parameters_is_found_and_named() {
    let found = |text: &str| that_take_too_much("a.rs", text);
    let bad = [
        "trait A {\n    fn f(a: u8, b: u8, c: u8, d: u8, e: u8, f: u8);\n}",
        "impl A {\n    pub(crate) fn f(&self, (a, b): (u8, u8), (c, d): (u8, u8), e: u8) -> u8 {}\n}",
        "fn ok() {}\nfn f(a: (u8, (u8, u8)), (b, c, d): (u8, u8, u8)) {}",
    ];
    for text in bad {
        assert_eq!(found(text), ["a.rs:2: f takes 6"], "{text}");
    }
    let good = [
        "fn f(a: u8, (b, c): (u8, u8), d: [u8; 3], e: u8) {}",
        "fn f(a: u8) {\n    let g = |(a, b, c): (u8, u8, u8), (d, e, f): (u8, u8, u8)| a;\n}",
        "mod tests {\n    fn f(a: u8, b: u8, c: u8, d: u8, e: u8, f: u8) {}\n}",
    ];
    for text in good {
        assert_eq!(found(text), [""; 0], "{text}");
    }
}
