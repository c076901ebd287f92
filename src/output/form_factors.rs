//! Form factors as files: CSV for tables, Matrix Market for sparse matrices, NPZ for NumPy.

use std::io::{self, Write};
use std::path::Path;

use super::npz::Npz;
use super::table::digits;
use super::{OutputError, replace};
use crate::patches::{GroupBy, Groups, Patches};
use crate::transport::{Exchange, GroupFactor};

/// How form factors are written, as the end of the file's name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorFormat {
    /// `.csv`: a row per pair.
    Csv,
    /// `.mtx`: Matrix Market, coordinates.
    MatrixMarket,
    /// `.npz`: NumPy arrays.
    Npz,
}

impl FactorFormat {
    /// The format of a file of this name.
    ///
    /// # Errors
    /// `Format` if the name ends in none of the three.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("mtx") => Ok(Self::MatrixMarket),
            Some("npz") => Ok(Self::Npz),
            _ => Err(OutputError::Format { path: path.to_owned() }),
        }
    }
}

/// The form factors between groups of patches, by row: F_ab, and what escapes, F_a∞ = 1 − Σ_b F_ab.
#[derive(Clone, Copy, Debug)]
pub struct FactorTable<'a> {
    patches: &'a Patches<'a>,
    groups: &'a Groups,
    values: Values<'a>,
}

/// Where the numbers are.
#[derive(Clone, Copy, Debug)]
enum Values<'a> {
    /// By sending group, then receiving group, escape last.
    Groups(&'a [GroupFactor]),
    Patches(&'a Exchange),
}

/// A form factor with its standard error where that is known.
type Known = (f64, Option<f64>);

impl<'a> FactorTable<'a> {
    /// What [`between_groups`](crate::transport::FormFactors::between_groups) found. A group without patches sees
    /// nothing, so all it sends out escapes.
    pub fn between_groups(patches: &'a Patches, groups: &'a Groups, factors: &'a [GroupFactor]) -> Self {
        Self { patches, groups, values: Values::Groups(factors) }
    }

    /// Patches, each a group, with form factors F_ij = S_ij / A_i and without standard errors.
    ///
    /// # Panics
    /// If the groups are not the patches.
    pub fn between_patches(patches: &'a Patches, groups: &'a Groups, exchange: &'a Exchange) -> Self {
        assert!(groups.by() == GroupBy::Patch && groups.len() == exchange.len(), "patches as groups");
        Self { patches, groups, values: Values::Patches(exchange) }
    }

    /// The patches that were grouped.
    pub fn patches(&self) -> &'a Patches<'a> {
        self.patches
    }

    /// The groups, in the order of rows and columns.
    pub fn groups(&self) -> &'a Groups {
        self.groups
    }

    /// Calls `f(b, F_ab, standard error)` for every group b that receives something of what group a sends out.
    pub fn for_row(&self, a: usize, mut f: impl FnMut(usize, f64, Option<f64>)) {
        match self.values {
            Values::Groups(_) => {
                self.row(a)
                    .iter()
                    .filter_map(|v| Some((v.to?, v)))
                    .for_each(|(b, v)| f(b, v.form_factor, Some(v.standard_error)));
            }
            Values::Patches(exchange) => {
                exchange.for_row(a, |b, area| f(b, area / exchange.areas()[a], None));
            }
        }
    }

    /// Row a with its zeros: form factors and standard errors.
    pub fn full_row(&self, a: usize) -> Vec<Known> {
        let zero = matches!(self.values, Values::Groups(_)).then_some(0.0);
        let mut row = vec![(0.0, zero); self.groups.len()];
        self.for_row(a, |b, form_factor, error| row[b] = (form_factor, error));
        row
    }

    /// F_a∞, the share of what group a sends out that leaves the scene, and its standard error.
    pub fn escape(&self, a: usize) -> Known {
        match self.values {
            Values::Groups(_) if self.groups.all()[a].area == 0.0 => (1.0, Some(0.0)),
            Values::Groups(_) => {
                let away = self.row(a).iter().find(|v| v.to.is_none());
                away.map_or((0.0, Some(0.0)), |v| (v.form_factor, Some(v.standard_error)))
            }
            Values::Patches(exchange) => (exchange.escape(a) / exchange.areas()[a], None),
        }
    }

    /// What is known of what group a sends out.
    fn row(&self, a: usize) -> &'a [GroupFactor] {
        match self.values {
            Values::Groups(all) => {
                &all[all.partition_point(|v| v.from < a)..all.partition_point(|v| v.from <= a)]
            }
            Values::Patches(_) => &[],
        }
    }

    fn has_errors(&self) -> bool {
        matches!(self.values, Values::Groups(_))
    }
}

/// Writes form factors in the format that the file's name asks for.
///
/// - `.csv`: `from,to,form_factor,standard_error`, nine digits. By object and by material every pair has its row. By face
///   (`from,from_side,to,to_side,form_factor,standard_error`) and by patch (numbers from 0, no standard errors) those pairs have
///   that exchange anything. What escapes has no row: it is what the rows of a group lack to 1.
/// - `.mtx`: Matrix Market, `coordinate real general`, g × g, all digits; comments name the groups. Without standard errors
///   and escape.
/// - `.npz`: arrays `names` (g), `area` (g, m²), `form_factor` and `standard_error` (g × g), `escape` and
///   `escape_standard_error` (g). By patch without standard errors, but with `centre` (g × 3, m), `reflectance` and `emission` (g × c),
///   all that L = E + K L takes.
///
/// # Errors
/// `Format` or `Write`.
pub fn write_form_factors(path: &Path, table: &FactorTable) -> Result<(), OutputError> {
    match FactorFormat::of(path)? {
        FactorFormat::Csv => replace(path, |file| write_csv(file, table)),
        FactorFormat::MatrixMarket => replace(path, |file| write_matrix_market(file, table)),
        FactorFormat::Npz => replace(path, |file| write_npz(file, table)),
    }
}

fn write_csv(file: &mut dyn Write, table: &FactorTable) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(file);
    let by = table.groups.by();
    let sides = by == GroupBy::Face;
    let header: &[&str] = if sides { &["from", "from_side", "to", "to_side"] } else { &["from", "to"] };
    csv.write_record(header.iter().chain(&["form_factor", "standard_error"]))?;
    let groups = table.groups.all();
    let keys: Vec<Vec<String>> = (0..groups.len())
        .map(|a| match by {
            GroupBy::Patch => vec![a.to_string()],
            GroupBy::Face => groups[a].name.split(' ').map(str::to_owned).collect(),
            GroupBy::Material | GroupBy::Object => vec![groups[a].name.clone()],
        })
        .collect();
    let every_pair = matches!(by, GroupBy::Material | GroupBy::Object);
    for (a, from) in keys.iter().enumerate() {
        let mut row = Vec::new();
        if every_pair {
            row.extend(table.full_row(a).into_iter().enumerate());
        } else {
            table.for_row(a, |b, form_factor, error| row.push((b, (form_factor, error))));
        }
        for (b, (form_factor, error)) in row {
            let values = [digits(form_factor), error.map_or(String::new(), digits)];
            csv.write_record(from.iter().chain(&keys[b]).chain(&values))?;
        }
    }
    csv.flush()
}

fn write_matrix_market(file: &mut dyn Write, table: &FactorTable) -> io::Result<()> {
    let (groups, by) = (table.groups.all(), table.groups.by().name());
    let size = groups.len();
    let mut entries = 0;
    (0..size).for_each(|a| table.for_row(a, |_, _, _| entries += 1));
    writeln!(file, "%%MatrixMarket matrix coordinate real general")?;
    writeln!(file, "% form factors F(from, to) by {by}; what escapes is what a row lacks to 1")?;
    for (a, group) in groups.iter().enumerate() {
        let name = group.name.replace(char::is_control, " ");
        writeln!(file, "% {}: {name}, {} m2", a + 1, digits(group.area))?;
    }
    writeln!(file, "{size} {size} {entries}")?;
    for a in 0..size {
        let mut lines = String::new();
        table.for_row(a, |b, form_factor, _| lines += &format!("{} {} {form_factor:e}\n", a + 1, b + 1));
        file.write_all(lines.as_bytes())?;
    }
    Ok(())
}

fn write_npz(file: &mut dyn Write, table: &FactorTable) -> io::Result<()> {
    let (groups, size) = (table.groups.all(), table.groups.len());
    let (form_factor, error) = (|known: &Known| known.0, |known: &Known| known.1.unwrap_or(f64::NAN));
    let column = |value: &dyn Fn(usize) -> f64| (0..size).map(|a| [value(a)]).collect::<Vec<_>>();
    let rows = |part: fn(&Known) -> f64| {
        (0..size).map(move |a| table.full_row(a).iter().map(part).collect::<Vec<f64>>())
    };
    let mut npz = Npz::new(file);
    npz.texts("names", &groups.iter().map(|group| group.name.as_str()).collect::<Vec<_>>())?;
    npz.array("area", &[size], column(&|a| groups[a].area))?;
    npz.array("form_factor", &[size, size], rows(form_factor))?;
    npz.array("escape", &[size], column(&|a| form_factor(&table.escape(a))))?;
    if table.has_errors() {
        npz.array("standard_error", &[size, size], rows(error))?;
        npz.array("escape_standard_error", &[size], column(&|a| error(&table.escape(a))))?;
    } else {
        let patches = table.patches;
        npz.array("centre", &[size, 3], (0..size).map(|i| patches.centre(i).to_array()))?;
        let mut by_channel = vec![("reflectance", patches.reflectances()), ("emission", patches.sources())];
        by_channel.extend(patches.transmittances().map(|tau| ("transmittance", tau)));
        for (name, values) in by_channel {
            let rows = values.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>());
            npz.array(name, &[size, values.ncols()], rows)?;
        }
    }
    npz.finish()
}
