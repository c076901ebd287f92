//! Numbers: those of a photometric file, each with its line.

use super::MOST_ANGLES;
use crate::scene::LARGEST;

/// The numbers of a file that follow a line, apart by spaces and commas.
pub(super) struct Numbers<'a> {
    words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    /// The line of the number read last.
    line: usize,
}

impl<'a> Numbers<'a> {
    pub fn after(text: &'a str, line: usize) -> Self {
        let lines = (1..).zip(text.lines()).skip(line);
        let separator = |c: char| c.is_whitespace() || c == ',';
        let words = lines.flat_map(move |(number, line)| {
            line.split(separator).filter(|word| !word.is_empty()).map(move |word| (number, word))
        });
        Self { words: Box::new(words), line }
    }

    /// An error at the number read last.
    pub fn wrong(&self, message: &str) -> (usize, String) {
        (self.line, message.to_owned())
    }

    pub fn next(&mut self, what: &str) -> Result<f64, (usize, String)> {
        let Some((line, word)) = self.words.next() else {
            return Err(
                self.wrong(&format!("the file ends where {what} should follow; get a whole copy of it"))
            );
        };
        self.line = line;
        let number = word.parse().ok().filter(|x: &f64| x.abs() <= LARGEST);
        number.ok_or_else(|| {
            self.wrong(&format!("`{word}` stands where {what} should; it must be a number up to {LARGEST:e}"))
        })
    }

    pub fn positive(&mut self, what: &str) -> Result<f64, (usize, String)> {
        match self.next(what)? {
            x if x > 0.0 => Ok(x),
            x => Err(self.wrong(&format!("{what} is {x}, and must be positive"))),
        }
    }

    pub fn not_negative(&mut self, what: &str) -> Result<f64, (usize, String)> {
        match self.next(what)? {
            x if x < 0.0 => Err(self.wrong(&format!("{what} is {x}, and must not be negative"))),
            x => Ok(x),
        }
    }

    pub fn count(&mut self, what: &str) -> Result<usize, (usize, String)> {
        let x = self.next(what)?;
        as_count(x, what).map_err(|message| self.wrong(&message))
    }

    pub fn angles(&mut self, count: usize, which: &str) -> Result<Vec<f64>, (usize, String)> {
        ascending(count, &format!("{which} angle"), |_, what| {
            let angle = self.next(what)?;
            Ok((self.line, angle))
        })
    }

    /// Candelas, if factors have not made them too large.
    pub fn sound(&self, candela: Vec<f64>) -> Result<Vec<f64>, (usize, String)> {
        match candela.iter().find(|x| !(0.0..=LARGEST).contains(&x.abs())) {
            None => Ok(candela),
            Some(x) => {
                Err(self.wrong(&format!("with all factors a candela is {x}, and must be up to {LARGEST:e}")))
            }
        }
    }

    /// Makes sure that nothing follows.
    pub fn end(&mut self, what: &str) -> Result<(), (usize, String)> {
        match self.words.next() {
            None => Ok(()),
            Some((line, word)) => Err((
                line,
                format!(
                    "`{word}` is left over after {what}, and {} more; a count is wrong, or commas stand for decimal points",
                    self.words.by_ref().count()
                ),
            )),
        }
    }
}

/// A number of angles.
pub(super) fn as_count(x: f64, what: &str) -> Result<usize, String> {
    match x {
        x if x >= 1.0 && x <= MOST_ANGLES as f64 && x.fract() == 0.0 => Ok(x as usize),
        x => Err(format!("{what} is {x}, and must be a whole number from 1 to {MOST_ANGLES}")),
    }
}

/// So many numbers, each more than the one before it; `next` reads the k-th under a name for messages, and
/// tells its line.
pub(super) fn ascending(
    count: usize,
    which: &str,
    mut next: impl FnMut(usize, &str) -> Result<(usize, f64), (usize, String)>,
) -> Result<Vec<f64>, (usize, String)> {
    let mut numbers: Vec<f64> = Vec::with_capacity(count);
    for k in 0..count {
        let what = format!("{which} {} of {count}", k + 1);
        let (line, x) = next(k, &what)?;
        if numbers.last().is_some_and(|&last| x <= last) {
            return Err((line, format!("{what} is {x}, and must be more than the one before it")));
        }
        numbers.push(x);
    }
    Ok(numbers)
}
