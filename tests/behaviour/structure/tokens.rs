//! Rust text as words and signs, for tests that read the code.

pub struct Token {
    pub line: usize,
    pub text: String,
}

/// Words, `::` and single signs; comments, strings and characters are left out.
pub fn tokens(text: &str) -> Vec<Token> {
    let text: Vec<char> = text.chars().collect();
    let starts = |at: usize, what: &str| what.chars().enumerate().all(|(k, c)| text.get(at + k) == Some(&c));
    let find =
        |from: usize, what: &str| (from..text.len()).find(|&at| starts(at, what)).unwrap_or(text.len());
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut tokens, mut at, mut line) = (Vec::new(), 0, 1);
    while at < text.len() {
        let begin = at;
        match text[at] {
            '/' if starts(at, "//") => at = find(at, "\n"),
            '/' if starts(at, "/*") => {
                let mut depth = 0;
                while at < text.len() {
                    depth += i32::from(starts(at, "/*")) - i32::from(starts(at, "*/"));
                    at += if starts(at, "/*") || starts(at, "*/") { 2 } else { 1 };
                    if depth == 0 {
                        break;
                    }
                }
            }
            'r' if starts(at, "r\"") || starts(at, "r#\"") => {
                let end = if starts(at, "r\"") { "\"" } else { "\"#" };
                at = find(find(at, "\"") + 1, end) + end.len();
            }
            '"' => {
                at += 1;
                while at < text.len() && text[at] != '"' {
                    at += if text[at] == '\\' { 2 } else { 1 };
                }
                at += 1;
            }
            // A character; otherwise the quote starts a lifetime.
            '\'' if starts(at + 1, "\\") => at = find(at + 3, "'") + 1,
            '\'' if starts(at + 2, "'") => at += 3,
            ':' if starts(at, "::") => {
                tokens.push(Token { line, text: "::".into() });
                at += 2;
            }
            c if is_word(c) => {
                at = (at..text.len()).find(|&k| !is_word(text[k])).unwrap_or(text.len());
                tokens.push(Token { line, text: text[begin..at].iter().collect() });
            }
            c => {
                if !c.is_whitespace() {
                    tokens.push(Token { line, text: c.into() });
                }
                at += 1;
            }
        }
        line += text[begin..at.min(text.len())].iter().filter(|&&c| c == '\n').count();
    }
    tokens
}

pub fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// What comes before tests.
pub fn without_tests(mut tokens: Vec<Token>) -> Vec<Token> {
    let starts = |pair: &[Token]| pair[0].text == "mod" && pair[1].text == "tests";
    if let Some(tests) = tokens.windows(2).position(starts) {
        tokens.truncate(tests);
    }
    tokens
}
