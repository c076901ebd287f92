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
