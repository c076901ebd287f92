//! LM-63: photometric files of North America (IESNA LM-63-1986, 1991, 1995, 2002; ANSI/IES LM-63-19).

use glam::{DMat3, DVec3};

use super::numbers::Numbers;
use super::{IntensityTable, Symmetry};

/// Metres per foot.
const FOOT: f64 = 0.3048;

/// What follows `TILT=` in a text, and the number of that line.
pub(super) fn tilt(text: &str) -> Option<(usize, &str)> {
    (1..).zip(text.lines()).find_map(|(number, line)| {
        let line = line.trim();
        let rest =
            line.get(..4).filter(|key| key.eq_ignore_ascii_case("tilt")).map(|_| line[4..].trim_start());
        Some((number, rest?.strip_prefix('=')?.trim()))
    })
}

/// Reads a text of which this is the line about tilt.
pub(super) fn parse(
    text: &str,
    tilt: Option<(usize, &str)>,
    warnings: &mut Vec<String>,
) -> Result<IntensityTable, (usize, String)> {
    let Some((line, tilt)) = tilt else {
        let message = "there is no line TILT=; is this an LM-63 file (.ies) or EULUMDAT (.ldt)?";
        return Err((text.lines().count().max(1), message.into()));
    };
    let first = text.lines().next().unwrap_or_default().trim();
    let is_early = !first.starts_with("IES") || first.starts_with("IESNA91");
    let mut numbers = Numbers::after(text, line);
    let tilt = match tilt.to_ascii_uppercase().as_str() {
        "NONE" => Vec::new(),
        "INCLUDE" => tilt_factors(&mut numbers)?,
        file => {
            let message = format!(
                "tilt factors in a file of their own ({file}) are not read; write TILT=NONE or include them"
            );
            return Err((line, message));
        }
    };
    for what in ["the number of lamps", "the lumens of a lamp"] {
        numbers.next(what)?;
    }
    let multiplier = numbers.positive("the multiplier of candelas")?;
    let vertical = numbers.count("the number of vertical angles")?;
    let horizontal = numbers.count("the number of horizontal angles")?;
    let kind = match numbers.next("the type of photometry")? {
        1.0 => Kind::C,
        2.0 => Kind::B,
        3.0 => Kind::A,
        other => {
            return Err(
                numbers.wrong(&format!("{other} is no type of photometry; 1 is type C, 2 is B and 3 is A"))
            );
        }
    };
    let unit = match numbers.next("the units")? {
        1.0 => FOOT,
        2.0 => 1.0,
        other => return Err(numbers.wrong(&format!("{other} is no unit of length; 1 are feet and 2 metres"))),
    };
    let mut size = [0.0; 3];
    for (size, what) in size.iter_mut().zip(["the width", "the length", "the height"]) {
        *size = unit * numbers.next(what)?;
    }
    let ballast = numbers.positive("the ballast factor")?;
    let photometric = numbers.next("the ballast-lamp factor, or a number for future use")?;
    numbers.next("the watts")?;
    // Of files after 1991 that number is no factor.
    let factor = multiplier * ballast * if is_early && photometric > 0.0 { photometric } else { 1.0 };
    let vertical = numbers.angles(vertical, "vertical")?;
    let ends = |angles: &[f64]| (angles[0], angles[angles.len() - 1]);
    let known = kind.vertical();
    if !known.contains(&ends(&vertical)) {
        return Err(numbers.wrong(&kind.wrong_ends("vertical", ends(&vertical), known)));
    }
    let horizontal = numbers.angles(horizontal, "horizontal")?;
    let known = kind.horizontal();
    if !known.contains(&ends(&horizontal)) && (kind != Kind::C || horizontal.len() > 1) {
        return Err(numbers.wrong(&kind.wrong_ends("horizontal", ends(&horizontal), known)));
    }
    let count = vertical.len() * horizontal.len();
    let mut candela = Vec::with_capacity(count);
    for k in 0..count {
        candela.push(numbers.not_negative(&format!("candela value {} of {count}", k + 1))? * factor);
    }
    let candela = numbers.sound(candela)?;
    numbers.end(&format!("the {count} candelas of {} by {} angles", vertical.len(), horizontal.len()))?;
    if tilt.iter().any(|pair| pair[1] != 1.0) {
        warnings.push("factors for tilted lamps (TILT=INCLUDE) are applied, with straight down as 0".into());
    }
    let table = Table { vertical, horizontal, candela };
    Ok(IntensityTable { tilt, size, ..table.about(kind) })
}

/// Angles of tilt and what is sent then.
fn tilt_factors(numbers: &mut Numbers) -> Result<Vec<[f64; 2]>, (usize, String)> {
    numbers.next("the lamp's position (TILT=INCLUDE)")?;
    let count = numbers.count("the number of tilt angles")?;
    let angles = numbers.angles(count, "tilt")?;
    let mut factors = Vec::with_capacity(count);
    for k in 0..count {
        factors.push(numbers.not_negative(&format!("tilt factor {} of {count}", k + 1))?);
    }
    Ok(angles.into_iter().zip(factors).map(|(angle, factor)| [angle, factor]).collect())
}

/// About which axis a table's planes turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The luminaire's.
    C,
    /// The one across C0.
    B,
    /// C0.
    A,
}

impl Kind {
    /// From which vertical angle to which a table may run.
    fn vertical(self) -> &'static [(f64, f64)] {
        match self {
            Self::C => &[(0.0, 90.0), (90.0, 180.0), (0.0, 180.0)],
            Self::A | Self::B => &[(-90.0, 90.0), (0.0, 90.0)],
        }
    }

    /// The same of horizontal angles.
    fn horizontal(self) -> &'static [(f64, f64)] {
        match self {
            Self::C => &[(0.0, 90.0), (0.0, 180.0), (0.0, 360.0), (90.0, 270.0)],
            Self::A | Self::B => &[(-90.0, 90.0), (0.0, 90.0)],
        }
    }

    fn wrong_ends(self, which: &str, (first, last): (f64, f64), known: &[(f64, f64)]) -> String {
        let known: Vec<String> = known.iter().map(|(first, last)| format!("{first} to {last}")).collect();
        let alone = if self == Self::C && which == "horizontal" { "0 alone, " } else { "" };
        format!("{which} angles run from {first} to {last}; type {self:?} has {alone}{}", known.join(" or "))
    }
}

/// A table as it stands in a file.
struct Table {
    vertical: Vec<f64>,
    horizontal: Vec<f64>,
    /// By horizontal angle, then by vertical.
    candela: Vec<f64>,
}

impl Table {
    /// The same as a table about a pole.
    fn about(self, kind: Kind) -> IntensityTable {
        let highest = self.candela.iter().copied().fold(0.0, f64::max);
        let Table { vertical, horizontal, candela } = match kind {
            Kind::C => self,
            Kind::A => self.mirrored().with_pole_up(),
            Kind::B => self.mirrored().with_pole_across(),
        };
        let symmetry = match horizontal[horizontal.len() - 1] {
            _ if kind != Kind::C => Symmetry::Sector,
            _ if horizontal.len() == 1 => Symmetry::Round,
            90.0 => Symmetry::Quarter,
            180.0 => Symmetry::Half,
            270.0 => Symmetry::OtherHalf,
            _ => Symmetry::Whole,
        };
        // Rows are the axes of the table, the last its pole, by C0, C90 and the axis of the luminaire.
        let turn = match kind {
            Kind::C => None,
            Kind::A => Some([DVec3::Z, DVec3::NEG_Y, DVec3::X]),
            Kind::B => Some([DVec3::Z, DVec3::X, DVec3::NEG_Y]),
        };
        let turn = turn.map(|[x, y, z]| DMat3::from_cols(x, y, z).transpose());
        IntensityTable {
            vertical,
            horizontal,
            candela,
            highest,
            symmetry,
            turn,
            tilt: Vec::new(),
            size: [0.0; 3],
        }
    }

    /// With both halves of what is symmetric about horizontal angle 0.
    fn mirrored(self) -> Self {
        if self.horizontal[0] < 0.0 {
            return self;
        }
        let rows: Vec<&[f64]> = self.candela.chunks_exact(self.vertical.len()).collect();
        let other = rows.iter().skip(1).rev();
        let candela = other.chain(&rows).copied().collect::<Vec<_>>().concat();
        let other = self.horizontal.iter().skip(1).rev().map(|angle| -angle);
        let horizontal = other.chain(self.horizontal.iter().copied()).collect();
        Self { horizontal, candela, ..self }
    }

    /// Of type A: horizontal angles turn about the pole, and vertical ones rise to it.
    fn with_pole_up(self) -> Self {
        let rows = self.candela.chunks_exact(self.vertical.len());
        let candela = rows.flat_map(|row| row.iter().rev().copied()).collect();
        Self { vertical: from_pole(&self.vertical), candela, ..self }
    }

    /// Of type B: vertical angles turn about the pole, and horizontal ones go towards it.
    fn with_pole_across(self) -> Self {
        let (rows, columns) = (self.horizontal.len(), self.vertical.len());
        let at = |column: usize, row: usize| self.candela[row * columns + column];
        let candela = (0..columns).flat_map(|column| (0..rows).rev().map(move |row| (column, row)));
        let candela = candela.map(|(column, row)| at(column, row)).collect();
        Self { vertical: from_pole(&self.horizontal), horizontal: self.vertical, candela }
    }
}

/// Angles from the pole, ascending, of those that rise to it.
fn from_pole(rising: &[f64]) -> Vec<f64> {
    rising.iter().rev().map(|angle| 90.0 - angle).collect()
}
