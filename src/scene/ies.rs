//! IES: luminous intensity by direction, as LM-63 photometric files of type C give it (IESNA LM-63-1986,
//! 1991, 1995, 2002; ANSI/IES LM-63-19).
//!
//! A vertical angle θ of 0 is the luminaire's axis, usually straight down, and 180 the way back; a horizontal
//! angle φ of 0 is the half-plane C0, and φ grows counter-clockwise seen from behind the luminaire, which is
//! from above. Between the angles of the table intensity is bilinear, outside it is none.

use std::f64::consts::TAU;

/// More angles of a kind than this are refused.
const MOST_ANGLES: usize = 10_000;

/// Luminous intensity by direction, cd.
#[derive(Clone, Debug, PartialEq)]
pub struct IntensityTable {
    /// θ, ascending, degrees.
    vertical: Vec<f64>,
    /// φ, ascending, degrees: a single one, or those from 0 to 90, 180 or 360, or from 90 to 270.
    horizontal: Vec<f64>,
    /// By φ, then θ.
    candela: Vec<f64>,
    highest: f64,
}

impl IntensityTable {
    /// Reads the text of a photometric file. Lamp multiplier and ballast factor are in the intensities then;
    /// what the user should know of is added to `warnings`.
    ///
    /// # Errors
    /// What is wrong and what to do, with the line from 1.
    pub fn parse(text: &str, warnings: &mut Vec<String>) -> Result<Self, (usize, String)> {
        let head = Head::find(text)?;
        let mut numbers = Numbers::after(text, head.tilt_line);
        if head.tilt_included {
            numbers.next("the lamp's position (TILT=INCLUDE)")?;
            let count = numbers.count("the number of tilt angles")?;
            for k in 0..2 * count {
                numbers.next(&format!("tilt angle or factor {} of {}", k + 1, 2 * count))?;
            }
            warnings.push("factors for tilted lamps (TILT=INCLUDE) are not applied".into());
        }
        for what in ["the number of lamps", "the lumens of a lamp"] {
            numbers.next(what)?;
        }
        let multiplier = numbers.positive("the multiplier of candelas")?;
        let vertical = numbers.count("the number of vertical angles")?;
        let horizontal = numbers.count("the number of horizontal angles")?;
        match numbers.next("the type of photometry")? {
            1.0 => {}
            2.0 => {
                return Err(
                    numbers.wrong("photometry of type B is not supported; export the luminaire as type C")
                );
            }
            3.0 => {
                return Err(
                    numbers.wrong("photometry of type A is not supported; export the luminaire as type C")
                );
            }
            other => return Err(numbers.wrong(&format!("{other} is no type of photometry; 1 is type C"))),
        }
        for what in ["the units", "the width", "the length", "the height"] {
            numbers.next(what)?;
        }
        let ballast = numbers.positive("the ballast factor")?;
        let photometric = numbers.next("the ballast-lamp factor, or a number for future use")?;
        numbers.next("the watts")?;
        // Of files after 1991 that number is no factor.
        let factor =
            multiplier * ballast * if head.is_early && photometric > 0.0 { photometric } else { 1.0 };
        let vertical = numbers.angles(vertical, "vertical")?;
        let horizontal = numbers.angles(horizontal, "horizontal")?;
        let ends = |angles: &[f64]| (angles[0], angles[angles.len() - 1]);
        if !matches!(ends(&vertical), (0.0, 90.0) | (90.0, 180.0) | (0.0, 180.0)) {
            let (first, last) = ends(&vertical);
            let message = format!(
                "vertical angles run from {first} to {last}; type C has 0 to 90, 90 to 180 or 0 to 180"
            );
            return Err(numbers.wrong(&message));
        }
        if horizontal.len() > 1
            && !matches!(ends(&horizontal), (0.0, 90.0) | (0.0, 180.0) | (0.0, 360.0) | (90.0, 270.0))
        {
            let (first, last) = ends(&horizontal);
            let message = format!(
                "horizontal angles run from {first} to {last}; type C has 0 alone, 0 to 90, 0 to 180, 0 to 360 or 90 to 270"
            );
            return Err(numbers.wrong(&message));
        }
        let count = vertical.len() * horizontal.len();
        let mut candela = Vec::with_capacity(count);
        for k in 0..count {
            let value = numbers.next(&format!("candela value {} of {count}", k + 1))?;
            if value < 0.0 {
                return Err(numbers.wrong(&format!(
                    "candela value {} of {count} is {value}, and must not be negative",
                    k + 1
                )));
            }
            candela.push(value * factor);
        }
        let highest = candela.iter().copied().fold(0.0, f64::max);
        Ok(Self { vertical, horizontal, candela, highest })
    }

    /// The highest intensity, cd.
    pub fn highest(&self) -> f64 {
        self.highest
    }

    /// Intensity at a vertical and a horizontal angle, degrees; cd.
    #[inline]
    pub fn at(&self, vertical: f64, horizontal: f64) -> f64 {
        let Some((j, t)) = between(&self.vertical, vertical) else { return 0.0 };
        let Some((i, s)) = between(&self.horizontal, self.folded(horizontal)) else { return 0.0 };
        let row = |i: usize| {
            let row = &self.candela[i * self.vertical.len()..][..self.vertical.len()];
            row[j] + (row[(j + 1).min(row.len() - 1)] - row[j]) * t
        };
        let here = row(i);
        if s > 0.0 { here + (row(i + 1) - here) * s } else { here }
    }

    /// The angle of the table at which the same is sent as at a horizontal angle.
    fn folded(&self, horizontal: f64) -> f64 {
        let [first, last] = [self.horizontal[0], self.horizontal[self.horizontal.len() - 1]];
        let turned = horizontal.rem_euclid(360.0);
        match last {
            _ if self.horizontal.len() == 1 => first,
            90.0 => {
                let half = turned % 180.0;
                half.min(180.0 - half)
            }
            180.0 => turned.min(360.0 - turned),
            270.0 if !(90.0..=270.0).contains(&turned) => (180.0 - turned).rem_euclid(360.0),
            _ => turned,
        }
    }

    /// Luminous flux, lm: the exact integral of intensity over all directions.
    pub fn flux(&self) -> f64 {
        let rows: Vec<f64> =
            self.candela.chunks_exact(self.vertical.len()).map(|row| self.over_vertical(row)).collect();
        if let [only] = rows[..] {
            return TAU * only;
        }
        let span = self.horizontal[self.horizontal.len() - 1] - self.horizontal[0];
        let part = |k: usize| 0.5 * (rows[k] + rows[k + 1]) * (self.horizontal[k + 1] - self.horizontal[k]);
        (0..rows.len() - 1).map(part).sum::<f64>() / span * TAU
    }

    /// ∫ I sin θ dθ over a row, I linear between its angles: [−I cos θ + I′ sin θ].
    fn over_vertical(&self, row: &[f64]) -> f64 {
        let piece = |k: usize| {
            let [a, b] = [self.vertical[k], self.vertical[k + 1]].map(f64::to_radians);
            let slope = (row[k + 1] - row[k]) / (b - a);
            row[k] * a.cos() - row[k + 1] * b.cos() + slope * (b.sin() - a.sin())
        };
        (0..row.len() - 1).map(piece).sum()
    }
}

/// The interval of ascending numbers in which one lies, and how far in; none outside.
#[inline]
fn between(numbers: &[f64], x: f64) -> Option<(usize, f64)> {
    let last = numbers.len() - 1;
    if !(numbers[0]..=numbers[last]).contains(&x) {
        return None;
    }
    let k = (numbers.partition_point(|&number| number <= x) - 1).min(last.saturating_sub(1));
    let share = if last == 0 { 0.0 } else { (x - numbers[k]) / (numbers[k + 1] - numbers[k]) };
    Some((k, share))
}

/// What stands before the numbers.
struct Head {
    /// The number of the line that says TILT=.
    tilt_line: usize,
    tilt_included: bool,
    /// Whether the file follows LM-63-1986 or 1991.
    is_early: bool,
}

impl Head {
    fn find(text: &str) -> Result<Self, (usize, String)> {
        let first = text.lines().next().unwrap_or_default().trim();
        let is_early = !first.starts_with("IES") || first.starts_with("IESNA91");
        for (number, line) in (1..).zip(text.lines()) {
            let Some(tilt) = line.trim().strip_prefix("TILT=") else { continue };
            let tilt_included = match tilt.trim() {
                "NONE" => false,
                "INCLUDE" => true,
                file => {
                    let message = format!(
                        "tilt factors in a file of their own ({file}) are not supported; write TILT=NONE"
                    );
                    return Err((number, message));
                }
            };
            return Ok(Self { tilt_line: number, tilt_included, is_early });
        }
        Err((text.lines().count().max(1), "there is no line TILT=; is this an LM-63 file (.ies)?".into()))
    }
}

/// The numbers of a file, each with its line.
struct Numbers<'a> {
    words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    /// The line of the number read last.
    line: usize,
}

impl<'a> Numbers<'a> {
    fn after(text: &'a str, line: usize) -> Self {
        let lines = (1..).zip(text.lines()).skip(line);
        let separator = |c: char| c.is_whitespace() || c == ',';
        let words = lines.flat_map(move |(number, line)| {
            line.split(separator).filter(|word| !word.is_empty()).map(move |word| (number, word))
        });
        Self { words: Box::new(words), line }
    }

    fn wrong(&self, message: &str) -> (usize, String) {
        (self.line, message.to_owned())
    }

    fn next(&mut self, what: &str) -> Result<f64, (usize, String)> {
        let Some((line, word)) = self.words.next() else {
            return Err(
                self.wrong(&format!("the file ends where {what} should follow; get a whole copy of it"))
            );
        };
        self.line = line;
        let number = word.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| self.wrong(&format!("`{word}` stands where {what} should; it must be a number")))
    }

    fn positive(&mut self, what: &str) -> Result<f64, (usize, String)> {
        match self.next(what)? {
            x if x > 0.0 => Ok(x),
            x => Err(self.wrong(&format!("{what} is {x}, and must be positive"))),
        }
    }

    fn count(&mut self, what: &str) -> Result<usize, (usize, String)> {
        match self.next(what)? {
            x if x >= 1.0 && x <= MOST_ANGLES as f64 && x.fract() == 0.0 => Ok(x as usize),
            x => {
                Err(self.wrong(&format!("{what} is {x}, and must be a whole number from 1 to {MOST_ANGLES}")))
            }
        }
    }

    fn angles(&mut self, count: usize, which: &str) -> Result<Vec<f64>, (usize, String)> {
        let mut angles: Vec<f64> = Vec::with_capacity(count);
        for k in 0..count {
            let angle = self.next(&format!("{which} angle {} of {count}", k + 1))?;
            if angles.last().is_some_and(|&last| angle <= last) {
                let message = format!(
                    "{which} angle {} of {count} is {angle}, and must be more than the one before it",
                    k + 1
                );
                return Err(self.wrong(&message));
            }
            angles.push(angle);
        }
        Ok(angles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with these angles, and candelas by both.
    fn file(head: &str, vertical: &[f64], horizontal: &[f64], candela: impl Fn(f64, f64) -> f64) -> String {
        let words = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        let mut text = format!(
            "{head}\nTILT=NONE\n1 1000 2 {} {} 1 2 0.1 0.1 0\n0.5 1 30\n",
            vertical.len(),
            horizontal.len()
        );
        text += &format!("{}\n{}\n", words(vertical), words(horizontal));
        for &h in horizontal {
            let row: Vec<f64> = vertical.iter().map(|&v| candela(v, h)).collect();
            text += &format!("{}\n", words(&row));
        }
        text
    }

    fn parse(text: &str) -> IntensityTable {
        IntensityTable::parse(text, &mut Vec::new()).unwrap()
    }

    fn steps(from: f64, to: f64, count: usize) -> Vec<f64> {
        (0..=count).map(|k| from + (to - from) * k as f64 / count as f64).collect()
    }

    #[test]
    fn symmetric_tables_stand_for_whole_ones() {
        let vertical = steps(0.0, 180.0, 18);
        // Each is symmetric in the way that its table says.
        type Case = (Vec<f64>, fn(f64) -> f64);
        let cases: [Case; 5] = [
            (vec![0.0], |_| 1.0),
            (steps(0.0, 90.0, 6), |h| 2.0 + (2.0 * h.to_radians()).cos()),
            (steps(0.0, 180.0, 12), |h| 2.0 + h.to_radians().cos()),
            (steps(90.0, 270.0, 12), |h| 2.0 + h.to_radians().sin()),
            (steps(0.0, 360.0, 24), |h| 2.0 + (h - 15.0).to_radians().cos()),
        ];
        for (horizontal, around) in cases {
            let part =
                parse(&file("IESNA:LM-63-2002", &vertical, &horizontal, |v, h| around(h) * (200.0 - v)));
            let whole = parse(&file("IESNA:LM-63-2002", &vertical, &steps(0.0, 360.0, 24), |v, h| {
                around(h) * (200.0 - v)
            }));
            for k in 0..500 {
                let (v, h) = (f64::from(k) * 0.37 % 180.0, f64::from(k) * 7.3 - 900.0);
                let (a, b) = (part.at(v, h), whole.at(v, h));
                assert!((a - b).abs() < 1e-9 * b, "{horizontal:?} {v} {h}: {a} {b}");
            }
            assert!((part.flux() / whole.flux() - 1.0).abs() < 1e-12, "{horizontal:?}");
        }
    }

    #[test]
    fn flux_is_the_integral_of_intensity() {
        // Even: 4π; the cosine law: π, but for interpolation between its angles.
        let even = parse(&file("IESNA:LM-63-1995", &[0.0, 180.0], &[0.0], |_, _| 7.0));
        assert!((even.flux() / (2.0 * TAU * 7.0) - 1.0).abs() < 1e-12);
        let lambert =
            parse(&file("IESNA91", &steps(0.0, 90.0, 90), &[0.0], |v, _| 10.0 * v.to_radians().cos()));
        assert!((lambert.flux() / (0.5 * TAU * 10.0) - 1.0).abs() < 1e-4, "{}", lambert.flux());
        let uneven =
            parse(&file("IESNA91", &steps(0.0, 90.0, 9), &steps(0.0, 360.0, 8), |v, h| v * (400.0 - h)));
        let n = 720;
        let cell = |k: usize| {
            let (v, h) =
                (((k / n) as f64 + 0.5) * 90.0 / n as f64, ((k % n) as f64 + 0.5) * 360.0 / n as f64);
            uneven.at(v, h) * v.to_radians().sin() * (0.25 * TAU / n as f64) * (TAU / n as f64)
        };
        let sum: f64 = (0..n * n).map(cell).sum();
        assert!((uneven.flux() / sum - 1.0).abs() < 1e-5, "{} {sum}", uneven.flux());
    }

    #[test]
    fn intensity_is_interpolated_and_none_outside_the_table() {
        let table = parse(&file("IESNA:LM-63-2002", &[0.0, 40.0, 90.0], &[0.0, 90.0], |v, h| v + h));
        assert_eq!([table.at(20.0, 45.0), table.at(40.0, 90.0), table.at(90.0, 0.0)], [65.0, 130.0, 90.0]);
        assert_eq!([table.at(90.1, 0.0), table.at(180.0, 0.0)], [0.0; 2]);
        let up = parse(&file("IESNA:LM-63-2002", &[90.0, 180.0], &[0.0], |_, _| 3.0));
        assert_eq!([up.at(89.0, 10.0), up.at(91.0, 10.0)], [0.0, 3.0]);
    }

    #[test]
    fn multiplier_and_ballast_act_and_the_third_factor_only_in_early_files() {
        let with = |head: &str| {
            let text = file(head, &[0.0, 90.0], &[0.0], |_, _| 100.0).replace("0.5 1 30", "0.5 0.8 30");
            parse(&text).at(10.0, 0.0)
        };
        assert_eq!(
            ["an old luminaire", "IESNA91", "IESNA:LM-63-1995", "IES:LM-63-2019"].map(with),
            [80.0, 80.0, 100.0, 100.0]
        );
    }

    #[test]
    fn tilt_factors_are_passed_over_and_spoken_of() {
        let text = file("IESNA:LM-63-2002\n[MANUFAC] none", &[0.0, 90.0], &[0.0], |_, _| 5.0);
        let tilted = text.replace("TILT=NONE", "TILT=INCLUDE\n1\n3\n0 45 90\n1, 0.9, 0.8");
        let mut warnings = Vec::new();
        assert_eq!(IntensityTable::parse(&tilted, &mut warnings).unwrap(), parse(&text));
        assert!(warnings.len() == 1 && warnings[0].contains("TILT=INCLUDE"));
    }

    #[test]
    fn broken_files_are_named_by_line() {
        let good = file("IESNA:LM-63-2002", &[0.0, 45.0, 90.0], &[0.0, 90.0], |_, _| 5.0);
        for (from, to, line, wanted) in [
            ("TILT=NONE", "TILT=a.tlt", 2, "TILT=NONE"),
            ("TILT=NONE", "", 8, "no line TILT="),
            ("3 2 1 2", "3 2 2 2", 3, "type B is not supported"),
            ("3 2 1 2", "3 2 3 2", 3, "type A is not supported"),
            ("3 2 1 2", "3 2 7 2", 3, "no type"),
            ("3 2 1 2", "0 2 1 2", 3, "the number of vertical angles is 0"),
            ("3 2 1 2", "3 1e9 1 2", 3, "the number of horizontal angles"),
            ("1000 2 3", "1000 0 3", 3, "the multiplier of candelas is 0"),
            ("0.5 1 30", "0.5 one 30", 4, "`one` stands where"),
            ("0 45 90", "0 95 90", 5, "vertical angle 3 of 3 is 90"),
            ("0 45 90", "0 45 80", 6, "vertical angles run from 0 to 80"),
            ("\n0 90\n", "\n0 70\n", 6, "horizontal angles run from 0 to 70"),
            ("5 5 5\n5 5 5", "5 5 5\n5 -5 5", 8, "candela value 5 of 6 is -5"),
            ("5 5 5\n5 5 5", "5 5 5\n5 5", 8, "the file ends where candela value 6 of 6"),
            ("5 5 5\n5 5 5", "5 5 5\n5 nan 5", 8, "`nan`"),
        ] {
            assert!(good.contains(from), "{from}");
            let (at, message) =
                IntensityTable::parse(&good.replacen(from, to, 1), &mut Vec::new()).unwrap_err();
            assert!(at == line && message.contains(wanted), "{to}: {at}: {message}");
        }
        assert!(IntensityTable::parse("", &mut Vec::new()).is_err());
    }
}
