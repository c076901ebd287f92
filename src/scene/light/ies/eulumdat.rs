//! EULUMDAT: photometric files of Europe (`.ldt`), one value a line.

use super::numbers::{as_count, ascending};
use super::{IntensityTable, Symmetry};
use crate::scene::LARGEST;

/// Lines before those of the lamps.
const HEAD: usize = 26;

/// Lines of each set of lamps, and of direct ratios.
const PER_SET: usize = 6;
const RATIOS: usize = 10;

/// Whether a text has numbers where such files have them.
pub(super) fn looks_like(text: &str) -> bool {
    let lines = Values(text.lines().collect());
    lines.0.len() > HEAD && (1..=6).all(|line| lines.at(line, "").is_ok())
}

/// Reads a text.
pub(super) fn parse(text: &str, warnings: &mut Vec<String>) -> Result<IntensityTable, (usize, String)> {
    let values = Values(text.lines().collect());
    let planes = values.count(3, "the number of C-planes")?;
    let angles = values.count(5, "the number of angles in each plane")?;
    let millimetres = |line: usize, what: &str| Ok(values.at(line, what)? / 1000.0);
    // The length lies across C0, the width along it; a width of 0 makes the length a diameter.
    let [length, width] =
        [millimetres(15, "the length of what shines")?, millimetres(16, "the width of what shines")?];
    let height = millimetres(17, "the height of what shines")?;
    let size = if width == 0.0 { [-length, -length, height] } else { [width, length, height] };
    let factor = values.at(23, "the conversion factor for intensities")?;
    let sets = values.count(25, "the number of sets of lamps")?;
    let mut lumens = 0.0;
    for set in 0..sets {
        // With fewer lamps than none it is the flux of the luminaire; intensities are by it all the same.
        lumens += values.at(HEAD + PER_SET * set + 2, "the flux of the lamps")?;
    }
    if sets > 1 {
        warnings.push(format!("{sets} sets of lamps are taken to shine together; if they stand for one another, give luminous_flux"));
    }
    let first = HEAD + PER_SET * sets + RATIOS;
    let (horizontal, line) = values.angles(first, planes, "C-plane")?;
    let (vertical, line) = values.angles(line, angles, "angle")?;
    let is_range = |angles: &[f64], most: f64| angles[0] >= 0.0 && angles[angles.len() - 1] <= most;
    if !(is_range(&horizontal, 360.0) && is_range(&vertical, 180.0) && vertical.len() > 1) {
        let message = "C-planes must lie between 0 and 360, and two or more angles in them between 0 and 180";
        return Err((line, message.into()));
    }
    let (rows, symmetry, horizontal) =
        rows(values.at(2, "the kind of symmetry")?, horizontal).map_err(|message| (3, message))?;
    let factor = factor * lumens / 1000.0;
    let mut candela = vec![0.0; horizontal.len() * vertical.len()];
    for (stored, row) in rows.iter().enumerate() {
        for k in 0..angles {
            let at = line + stored * angles + k;
            let value = values.at(at, &format!("intensity {} of plane {}", k + 1, stored + 1))? * factor;
            if !(0.0..=LARGEST).contains(&value) {
                return Err((
                    at + 1,
                    format!("an intensity of {value} cd; it must not be negative, and up to {LARGEST:e}"),
                ));
            }
            row.iter().for_each(|row| candela[row * angles + k] = value);
        }
    }
    let highest = candela.iter().copied().fold(0.0, f64::max);
    Ok(IntensityTable {
        vertical,
        horizontal,
        candela,
        highest,
        symmetry,
        turn: None,
        tilt: Vec::new(),
        size,
    })
}

/// Which rows of the table each plane that is stored makes, the symmetry, and the table's horizontal angles.
type Rows = (Vec<Vec<usize>>, Symmetry, Vec<f64>);

/// Of a kind of symmetry and all planes.
fn rows(kind: f64, planes: Vec<f64>) -> Result<Rows, String> {
    let count = planes.len();
    let upto = |last: f64| {
        let kept: Vec<f64> = planes.iter().copied().filter(|&angle| angle <= last).collect();
        match kept.last() == Some(&last) && kept[0] == 0.0 {
            true => Ok(kept),
            false => Err(format!("the C-planes do not run from 0 to {last}, as symmetry {kind} needs")),
        }
    };
    let each = |count: usize| (0..count).map(|row| vec![row]).collect::<Vec<_>>();
    match kind {
        0.0 if count > 1 && planes[0] == 0.0 && planes[count - 1] < 360.0 => {
            // The first plane closes the circle.
            let mut rows = each(count);
            rows[0].push(count);
            let closed = planes.into_iter().chain([360.0]).collect();
            Ok((rows, Symmetry::Whole, closed))
        }
        0.0 => upto(360.0).map(|kept| (each(kept.len()), Symmetry::Whole, kept)),
        1.0 => Ok((each(1), Symmetry::Round, vec![0.0])),
        2.0 => upto(180.0).map(|kept| (each(kept.len()), Symmetry::Half, kept)),
        // Stored from 270 by 0 to 90: the image in the other plane runs from 90 to 270, backwards.
        3.0 => {
            let kept: Vec<f64> =
                planes.iter().copied().filter(|angle| (90.0..=270.0).contains(angle)).collect();
            match kept.first() == Some(&90.0) && kept.last() == Some(&270.0) {
                true => {
                    let rows = (0..kept.len()).rev().map(|row| vec![row]).collect();
                    Ok((rows, Symmetry::OtherHalf, kept))
                }
                false => Err("the C-planes do not hold 90 and 270, as symmetry 3 needs".into()),
            }
        }
        4.0 => upto(90.0).map(|kept| (each(kept.len()), Symmetry::Quarter, kept)),
        other => Err(format!("{other} is no kind of symmetry; they are 0 to 4")),
    }
}

/// The lines of a file.
struct Values<'a>(Vec<&'a str>);

impl Values<'_> {
    /// The number in a line, from 0; commas stand for decimal points.
    fn at(&self, line: usize, what: &str) -> Result<f64, (usize, String)> {
        let Some(text) = self.0.get(line) else {
            return Err((
                self.0.len().max(1),
                format!("the file ends where {what} should follow; get a whole copy of it"),
            ));
        };
        let number = text.trim().replace(',', ".").parse().ok().filter(|x: &f64| x.abs() <= LARGEST);
        number.ok_or_else(|| {
            let text = text.trim();
            (line + 1, format!("`{text}` stands where {what} should; it must be a number up to {LARGEST:e}"))
        })
    }

    fn count(&self, line: usize, what: &str) -> Result<usize, (usize, String)> {
        as_count(self.at(line, what)?, what).map_err(|message| (line + 1, message))
    }

    /// Ascending angles from a line on, and the line after them.
    fn angles(&self, first: usize, count: usize, what: &str) -> Result<(Vec<f64>, usize), (usize, String)> {
        let angles = ascending(count, what, |k, what| Ok((first + k + 1, self.at(first + k, what)?)))?;
        Ok((angles, first + count))
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::*;

    /// Line by line: this kind of symmetry, these planes all around of which the first `stored` from `first`
    /// on have intensities, and these sets of lamps, of a number and a flux each.
    fn file(
        symmetry: u8,
        planes: &[f64],
        stored: Range<usize>,
        lamps: &[(i32, f64)],
        candela: impl Fn(f64, f64) -> f64,
    ) -> String {
        let angles: Vec<f64> = (0..=36).map(|k| 5.0 * f64::from(k)).collect();
        let mut lines = vec!["Maker".to_owned(), "1".into(), symmetry.to_string()];
        lines.extend([planes.len().to_string(), "0".into(), angles.len().to_string(), "5".into()]);
        lines.extend(["report", "name", "number", "file", "date"].map(String::from));
        // Of the luminaire, of what shines, below its planes.
        lines.extend(["600", "300", "80", "500", "200", "0", "0", "0", "0"].map(String::from));
        lines.extend(["100", "80", "1.0", "0", &lamps.len().to_string()].map(String::from));
        for (number, flux) in lamps {
            lines.extend([number.to_string(), "LED".into(), flux.to_string()]);
            lines.extend(["3000K", "80", "10"].map(String::from));
        }
        lines.extend(vec!["0,5".to_owned(); RATIOS]);
        lines.extend(planes.iter().chain(&angles).map(f64::to_string));
        for plane in &planes[stored] {
            lines.extend(angles.iter().map(|&angle| candela(*plane, angle).to_string().replace('.', ",")));
        }
        lines.join("\r\n")
    }

    fn told(text: &str) -> (IntensityTable, Vec<String>) {
        assert!(looks_like(text));
        let mut warnings = Vec::new();
        let table = parse(text, &mut warnings).unwrap_or_else(|(line, message)| panic!("{line}: {message}"));
        (table, warnings)
    }

    fn around() -> Vec<f64> {
        (0..24).map(|k| 15.0 * f64::from(k)).collect()
    }

    fn even(lamps: &[(i32, f64)]) -> String {
        file(1, &around(), 0..1, lamps, |_, _| 100.0)
    }

    #[test]
    fn symmetric_files_stand_for_whole_ones() {
        type Case = (u8, Range<usize>, fn(f64) -> f64);
        let cases: [Case; 4] = [
            (1, 0..1, |_| 1.0),
            (2, 0..13, |c| 2.0 + c.to_radians().cos()),
            (3, 18..24, |c| 2.0 + c.to_radians().sin()),
            (4, 0..7, |c| 2.0 + (2.0 * c.to_radians()).cos()),
        ];
        for (symmetry, stored, by_plane) in cases {
            let candela = |c: f64, gamma: f64| by_plane(c) * (200.0 - gamma);
            let mut part = file(symmetry, &around(), stored, &[(1, 2000.0)], candela);
            if symmetry == 3 {
                // From 270 by 0 to 90.
                let rest = file(symmetry, &around(), 0..7, &[(1, 2000.0)], candela);
                let rows: Vec<&str> = rest.lines().collect();
                part = [part.as_str(), &rows[rows.len() - 7 * 37..].join("\r\n")].join("\r\n");
            }
            let whole = file(0, &around(), 0..24, &[(1, 2000.0)], candela);
            let (part, whole) = (told(&part).0, told(&whole).0);
            for k in 0..500 {
                let (gamma, c) = (f64::from(k) * 0.37 % 180.0, f64::from(k) * 7.3 - 900.0);
                let (a, b) = (part.at(gamma, c), whole.at(gamma, c));
                assert!((a - b).abs() < 1e-9 * b, "{symmetry} {gamma} {c}: {a} {b}");
            }
        }
    }

    #[test]
    fn intensities_are_by_the_flux_of_all_lamps() {
        let (table, warnings) = told(&even(&[(1, 2000.0)]));
        assert_eq!((table.at(30.0, 77.0), warnings.len()), (200.0, 0));
        let (table, warnings) = told(&even(&[(1, 2000.0), (2, 500.0)]));
        assert_eq!((table.at(30.0, 77.0), warnings.len()), (250.0, 1));
        assert!(warnings[0].contains("2 sets of lamps") && warnings[0].contains("luminous_flux"));
    }

    #[test]
    fn absolute_files_are_by_the_flux_of_their_luminaire() {
        assert_eq!(told(&even(&[(-1, 4000.0)])).0.at(30.0, 0.0), 400.0);
    }

    #[test]
    fn angles_beyond_a_full_turn_are_refused_by_their_line() {
        let planes = around().into_iter().map(|c| c + 15.0).chain([720.0]).collect::<Vec<_>>();
        let text = file(1, &planes, 0..1, &[(1, 1000.0)], |_, _| 100.0);
        let (line, message) = parse(&text, &mut Vec::new()).unwrap_err();
        assert!(message.contains("between 0 and 360"), "{message}");
        // Told where the angles end.
        assert!(text.lines().nth(line - 1).is_some_and(|text| text == "180"), "{line}");
    }

    #[test]
    fn a_file_that_ends_early_is_refused_by_its_last_line() {
        let whole = even(&[(1, 1000.0)]);
        let half: Vec<&str> = whole.lines().take(80).collect();
        let (line, message) = parse(&half.join("\n"), &mut Vec::new()).unwrap_err();
        assert!(line == 80 && message.contains("the file ends"), "{line} {message}");
    }
}
