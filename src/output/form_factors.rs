//! Form factors as files: CSV for tables, Matrix Market for sparse matrices, NPZ for NumPy.

use std::io::{self, Write};
use std::path::Path;

use rayon::prelude::*;

use super::npz::Npz;
use super::table::{digits, significant};
use super::{OutputError, replace};
use crate::patches::{GroupBy, Groups, Patches};
use crate::transport::{Exchange, GroupFactor, Unmet};

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

/// The form factors between groups of patches, by row: F_ab of one side over its whole area, and what
/// escapes, F_a∞. With what carriers absorb and lose a row sums to 1; where form factors could not be
/// balanced it lacks what is missing.
#[derive(Clone, Debug)]
pub struct FactorTable<'a> {
    patches: &'a Patches<'a>,
    groups: &'a Groups,
    values: Values<'a>,
    /// Per group, whether it sends or receives.
    is_listed: Vec<bool>,
}

/// Where the numbers are.
#[derive(Clone, Debug)]
enum Values<'a> {
    /// By sending group, then receiving group, escape last; and what is known of the rest.
    Groups(&'a [GroupFactor], Unmet),
    Patches(&'a Exchange),
}

/// A form factor, and what is known of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorEntry {
    /// F, or what escapes.
    pub form_factor: f64,
    /// Its standard error; not known for patches.
    pub standard_error: Option<f64>,
    /// Its upper 95 % bound; not known for patches. 0 where F is proven to be 0.
    pub upper95: Option<f64>,
}

impl FactorEntry {
    /// What is known for certain.
    fn certain(form_factor: f64) -> Self {
        Self { form_factor, standard_error: Some(0.0), upper95: Some(form_factor) }
    }

    /// As found by rays from the `seeing` part of a group, for the whole of it.
    fn of(found: &GroupFactor, seeing: f64) -> Self {
        let [standard_error, upper95] = [found.standard_error, found.upper95].map(|x| Some(seeing * x));
        Self { form_factor: seeing * found.form_factor, standard_error, upper95 }
    }
}

impl<'a> FactorTable<'a> {
    /// What [`between_groups`](crate::transport::FormFactors::between_groups) found with so many rays a
    /// patch. A group without patches sees nothing, so all it sends out escapes.
    pub fn between_groups(
        patches: &'a Patches,
        groups: &'a Groups,
        factors: &'a [GroupFactor],
        rays: u32,
    ) -> Self {
        let mut is_listed: Vec<bool> = groups.all().iter().map(|group| group.sends).collect();
        let met = factors.iter().filter(|found| groups.all()[found.from].sends).filter_map(|found| found.to);
        met.for_each(|b| is_listed[b] = true);
        let unmet = Unmet::new(patches, groups.of_patch(), rays);
        Self { patches, groups, values: Values::Groups(factors, unmet), is_listed }
    }

    /// Patches, each a group, with form factors F_ij = S_ij / A_i and without standard errors.
    ///
    /// # Panics
    /// If the groups are not the patches.
    pub fn between_patches(patches: &'a Patches, groups: &'a Groups, exchange: &'a Exchange) -> Self {
        assert!(groups.by() == GroupBy::Patch && groups.len() == exchange.len(), "patches as groups");
        let is_listed = vec![true; groups.len()];
        Self { patches, groups, values: Values::Patches(exchange), is_listed }
    }

    /// The patches that were grouped.
    pub fn patches(&self) -> &'a Patches<'a> {
        self.patches
    }

    /// The groups, in the order of rows and columns.
    pub fn groups(&self) -> &'a Groups {
        self.groups
    }

    /// The groups whose rows are asked for.
    pub fn senders(&self) -> impl Iterator<Item = usize> {
        (0..self.groups.len()).filter(|&a| self.groups.all()[a].sends)
    }

    /// The groups that send, and those that anything was found to land on.
    pub fn receivers(&self) -> impl Iterator<Item = usize> {
        (0..self.groups.len()).filter(|&b| self.is_listed[b])
    }

    /// Calls `f(b, F_ab)` for every group b that was found to receive something of what group a sends out.
    pub fn for_row(&self, a: usize, mut f: impl FnMut(usize, FactorEntry)) {
        match &self.values {
            Values::Groups(..) => {
                let seeing = self.groups.all()[a].seeing;
                let found = self.row(a).iter().filter_map(|v| Some((v.to?, v)));
                found.for_each(|(b, v)| f(b, FactorEntry::of(v, seeing)));
            }
            Values::Patches(exchange) => exchange.for_entries(a, |b, area| {
                let form_factor = area / exchange.sums()[a];
                f(b, FactorEntry { form_factor, standard_error: None, upper95: None });
            }),
        }
    }

    /// Row a with its zeros. Between groups a zero is what no ray found, with the bound that follows, or what
    /// is proven to be none.
    pub fn full_row(&self, a: usize) -> Vec<FactorEntry> {
        let nothing = |b: usize| match &self.values {
            Values::Groups(_, unmet) if self.may_exchange(a, b) => {
                FactorEntry::of(&unmet.between(a, Some(b)), self.groups.all()[a].seeing)
            }
            Values::Groups(..) => FactorEntry::certain(0.0),
            Values::Patches(_) => FactorEntry { form_factor: 0.0, standard_error: None, upper95: None },
        };
        let mut row = vec![None; self.groups.len()];
        self.for_row(a, |b, entry| row[b] = Some(entry));
        let zeros = row.into_par_iter().enumerate();
        zeros.map(|(b, found): (usize, Option<FactorEntry>)| found.unwrap_or_else(|| nothing(b))).collect()
    }

    /// Whether something may go from group a to b that rays did not find.
    fn may_exchange(&self, a: usize, b: usize) -> bool {
        [a, b].iter().all(|&group| self.groups.all()[group].seeing > 0.0) && self.groups.may_exchange(a, b)
    }

    /// F_a∞, the share of what group a sends out that leaves the scene.
    pub fn escape(&self, a: usize) -> FactorEntry {
        let seeing = self.groups.all()[a].seeing;
        match &self.values {
            Values::Groups(..) if seeing == 0.0 => FactorEntry::certain(1.0),
            Values::Groups(_, unmet) => {
                let away = self.row(a).iter().find(|v| v.to.is_none());
                let found = FactorEntry::of(&away.copied().unwrap_or_else(|| unmet.between(a, None)), seeing);
                let blind = 1.0 - seeing;
                let upper95 = found.upper95.map(|bound| bound + blind);
                FactorEntry { form_factor: found.form_factor + blind, upper95, ..found }
            }
            Values::Patches(exchange) => {
                let form_factor = exchange.ends().escape(a) / exchange.sums()[a];
                FactorEntry { form_factor, standard_error: None, upper95: None }
            }
        }
    }

    /// What is known of what group a sends out.
    fn row(&self, a: usize) -> &'a [GroupFactor] {
        match self.values {
            Values::Groups(all, _) => {
                &all[all.partition_point(|v| v.from < a)..all.partition_point(|v| v.from <= a)]
            }
            Values::Patches(_) => &[],
        }
    }

    fn has_errors(&self) -> bool {
        matches!(self.values, Values::Groups(..))
    }
}

/// Writes form factors in the format that the file's name asks for: rows of the groups that send, of one side
/// over its whole area.
///
/// - `.csv`: `from,to,form_factor,standard_error,from_area,escape,escape_error,upper95`; by face
///   `from,from_side,to,to_side,form_factor,…`; by patch numbers from 0 and nothing of errors. `from_area` in
///   m², `escape` and its standard error are of the whole group and the same in all of its rows; `upper95` is
///   the upper 95 % bound on the form factor. By object and by material every pair has its row: one that no
///   ray met with a form factor of 0 and its bound, which is 0 only where the two provably cannot face each
///   other. By face all pairs have rows that may face each other where there are no more than 64 groups,
///   else, and by patch, those that were found to exchange anything.
/// - `.mtx`: Matrix Market, `coordinate real general`, g × g, all digits; comments name the groups. Without
///   standard errors and escape.
/// - `.npz`: arrays `names` (g), `area` (g, m²), `form_factor`, `standard_error` and `upper95` (g × g),
///   `escape` and `escape_standard_error` (g); NaN for groups that do not send. By patch without errors and
///   bounds, but with `centre` (g × 3, m), `reflectance` and `emission` (g × c), all that L = E + K L takes.
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

/// Significant digits of what adds up to 1, for sums over many rows to do so too.
const SHARE_DIGITS: usize = 12;

/// Groups by face up to which every pair is listed.
const FEW_FACES: usize = 64;

fn write_csv(file: &mut dyn Write, table: &FactorTable) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(file);
    let (by, groups) = (table.groups.by(), table.groups.all());
    let sides = by == GroupBy::Face;
    let header: &[&str] = if sides { &["from", "from_side", "to", "to_side"] } else { &["from", "to"] };
    let values = ["form_factor", "standard_error", "from_area", "escape", "escape_error", "upper95"];
    csv.write_record(header.iter().chain(&values))?;
    let keys: Vec<Vec<String>> = (0..groups.len())
        .map(|a| match by {
            GroupBy::Patch => vec![a.to_string()],
            GroupBy::Face => groups[a].name.split(' ').map(str::to_owned).collect(),
            GroupBy::Material | GroupBy::Object => vec![groups[a].name.clone()],
        })
        .collect();
    let every_pair = match by {
        GroupBy::Material | GroupBy::Object => true,
        GroupBy::Face => groups.len() <= FEW_FACES,
        GroupBy::Patch => false,
    };
    let known = |value: Option<f64>| value.map_or(String::new(), digits);
    for a in table.senders() {
        let mut row = Vec::new();
        if every_pair {
            let all = table.full_row(a);
            let may_be = |b: &usize| by != GroupBy::Face || all[*b].upper95 != Some(0.0);
            row.extend(table.receivers().filter(may_be).map(|b| (b, all[b])));
        } else {
            table.for_row(a, |b, entry| row.push((b, entry)));
        }
        let escape = table.escape(a);
        let share = |entry: FactorEntry| significant(entry.form_factor, SHARE_DIGITS);
        let of_group = [digits(groups[a].area), share(escape), known(escape.standard_error)];
        for (b, entry) in row {
            let values = [share(entry), known(entry.standard_error)];
            let bound = [known(entry.upper95)];
            csv.write_record(keys[a].iter().chain(&keys[b]).chain(&values).chain(&of_group).chain(&bound))?;
        }
    }
    csv.flush()
}

fn write_matrix_market(file: &mut dyn Write, table: &FactorTable) -> io::Result<()> {
    let (groups, by) = (table.groups.all(), table.groups.by().name());
    let size = groups.len();
    let mut entries = 0;
    table.senders().for_each(|a| table.for_row(a, |_, _| entries += 1));
    writeln!(file, "%%MatrixMarket matrix coordinate real general")?;
    writeln!(file, "% form factors F(from, to) by {by}; what escapes is what a row lacks to 1")?;
    for (a, group) in groups.iter().enumerate() {
        let name = group.name.replace(char::is_control, " ");
        let empty = if group.sends { "" } else { ", not asked for: its row is empty" };
        writeln!(file, "% {}: {name}, {} m2{empty}", a + 1, digits(group.area))?;
    }
    writeln!(file, "{size} {size} {entries}")?;
    for a in table.senders() {
        let mut lines = String::new();
        table.for_row(a, |b, entry| lines += &format!("{} {} {:e}\n", a + 1, b + 1, entry.form_factor));
        file.write_all(lines.as_bytes())?;
    }
    Ok(())
}

fn write_npz(file: &mut dyn Write, table: &FactorTable) -> io::Result<()> {
    let (groups, size) = (table.groups.all(), table.groups.len());
    let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let rows = |part: fn(&FactorEntry) -> Option<f64>| {
        (0..size).map(move |a| match groups[a].sends {
            true => table.full_row(a).iter().map(|entry| or_nan(part(entry))).collect::<Vec<f64>>(),
            false => vec![f64::NAN; size],
        })
    };
    let escape = |part: fn(&FactorEntry) -> Option<f64>| {
        let of_group = |a: usize| if groups[a].sends { or_nan(part(&table.escape(a))) } else { f64::NAN };
        (0..size).map(|a| [of_group(a)]).collect::<Vec<_>>()
    };
    let mut npz = Npz::new(file);
    npz.texts("names", &groups.iter().map(|group| group.name.as_str()).collect::<Vec<_>>())?;
    npz.array("area", &[size], groups.iter().map(|group| [group.area]))?;
    npz.array("form_factor", &[size, size], rows(|entry| Some(entry.form_factor)))?;
    npz.array("escape", &[size], escape(|entry| Some(entry.form_factor)))?;
    if table.has_errors() {
        npz.array("standard_error", &[size, size], rows(|entry| entry.standard_error))?;
        npz.array("upper95", &[size, size], rows(|entry| entry.upper95))?;
        npz.array("escape_standard_error", &[size], escape(|entry| entry.standard_error))?;
    } else {
        let patches = table.patches;
        npz.array("centre", &[size, 3], (0..size).map(|i| patches.centre(i).to_array()))?;
        let mut by_channel =
            vec![("reflectance", patches.reflectances()), ("emission", patches.emitted_radiance())];
        by_channel.extend(patches.transmittances().map(|tau| ("transmittance", tau)));
        for (name, values) in by_channel {
            let rows = values.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>());
            npz.array(name, &[size, values.ncols()], rows)?;
        }
    }
    npz.finish()
}
