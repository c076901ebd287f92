//! Reference: irradiance of faces by other means, such as another program's path tracer, and the tables it
//! comes in.

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::scene::Side;

/// The irradiance of a face's side by other means, such as a path tracer.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceRow {
    /// The face's number.
    pub face: usize,
    /// Front or back.
    pub side: Side,
    /// Mean per channel, W·m⁻².
    pub mean: Vec<f64>,
    /// Its standard error per channel.
    pub standard_error: Vec<f64>,
}

/// Why a table of references could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// The file can't be opened, read or taken for a table.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system or the reader of tables says.
        source: csv::Error,
    },
    /// The table lacks a column.
    #[error(
        "{}: there is no column {column}; the first line must name {}", path.display(), COLUMNS.join(",")
    )]
    Column {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
    },
    /// A field does not say what it should.
    #[error("{}:{line}: {column} is `{field}`; {wanted}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The column.
        column: &'static str,
        /// What stands there.
        field: String,
        /// What should.
        wanted: &'static str,
    },
}

/// The columns that are read, in the usual order; others may stand among them.
const COLUMNS: [&str; 8] = ["face", "side", "E_r", "E_g", "E_b", "se_r", "se_g", "se_b"];

impl ReferenceRow {
    /// Reads a CSV table with the columns `face,side,E_r,E_g,E_b,se_r,se_g,se_b`, in any order and with any
    /// others among them: a face's number, `front` or `back`, and irradiance with its standard errors, W·m⁻².
    ///
    /// # Errors
    /// `Read`, `Column` or `Field`; each names the file, and the line where there is one.
    pub fn read(path: impl AsRef<Path>) -> Result<Vec<Self>, ReferenceError> {
        let path = path.as_ref();
        let unreadable = |source| ReferenceError::Read { path: path.to_path_buf(), source };
        let mut table = csv::Reader::from_path(path).map_err(unreadable)?;
        let header = table.headers().map_err(unreadable)?.clone();
        let mut places = [0; COLUMNS.len()];
        for (place, column) in places.iter_mut().zip(COLUMNS) {
            let missing = || ReferenceError::Column { path: path.to_path_buf(), column };
            *place = header.iter().position(|name| name.trim() == column).ok_or_else(missing)?;
        }
        let mut rows = Vec::new();
        for record in table.records() {
            let record = record.map_err(unreadable)?;
            let field = |column: usize| record.get(places[column]).unwrap_or_default().trim();
            let wrong = |column: usize, wanted| ReferenceError::Field {
                path: path.to_path_buf(),
                line: record.position().map_or(0, csv::Position::line),
                column: COLUMNS[column],
                field: field(column).to_owned(),
                wanted,
            };
            let number = |column: usize| {
                let number = field(column).parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
                number.ok_or_else(|| wrong(column, "it must be a number that is finite and not negative"))
            };
            let numbers = |columns: Range<usize>| columns.map(number).collect::<Result<Vec<f64>, _>>();
            rows.push(Self {
                face: field(0).parse().map_err(|_| wrong(0, "it must be the number of a face, from 0"))?,
                side: match field(1) {
                    "front" => Side::Front,
                    "back" => Side::Back,
                    _ => return Err(wrong(1, "it must be front or back")),
                },
                mean: numbers(2..5)?,
                standard_error: numbers(5..8)?,
            });
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<ReferenceRow>, ReferenceError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        std::fs::write(&path, text).unwrap();
        ReferenceRow::read(path)
    }

    #[test]
    fn columns_are_found_by_name() {
        let rows = read("side,se_r,se_g,se_b,area,face,E_b,E_g,E_r\nback,0.1,0.2,0.3,9,7,3,2,1\n").unwrap();
        let row = ReferenceRow {
            face: 7,
            side: Side::Back,
            mean: vec![1.0, 2.0, 3.0],
            standard_error: vec![0.1, 0.2, 0.3],
        };
        assert_eq!(rows, [row]);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let head = "face,side,area,E_r,E_g,E_b,se_r,se_g,se_b\n0,front,1,1,1,1,0,0,0\n";
        for (text, wanted) in [
            (head.replace("se_g", "error"), "there is no column se_g"),
            (format!("{head}one,front,1,1,1,1,0,0,0\n"), "table.csv:3: face is `one`"),
            (format!("{head}1,top,1,1,1,1,0,0,0\n"), "table.csv:3: side is `top`; it must be front or back"),
            (format!("{head}1,front,1,1,nan,1,0,0,0\n"), "table.csv:3: E_g is `nan`"),
            (format!("{head}1,front,1,1,1,1,0,-1,0\n"), "table.csv:3: se_g is `-1`"),
            (format!("{head}1,front\n"), "table.csv: "),
        ] {
            let message = read(&text).unwrap_err().to_string();
            assert!(message.contains(wanted), "{message}");
        }
        let missing = ReferenceRow::read("no such table.csv").unwrap_err();
        assert!(missing.to_string().starts_with("cannot read no such table.csv: "));
    }
}
