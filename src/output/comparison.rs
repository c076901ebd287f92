//! Comparison: `comparison.json` and `comparison.csv`, an answer beside its path-traced reference.

use std::io::{self, Write};

use nalgebra::DMatrix;
use serde::Serialize;

use super::table::digits;
use super::{Stage, table};
use crate::measure::{AgreementTest, Comparison, MeshError, OrderRow, Verdict};
use crate::patches::Patches;
use crate::reference::PathTraced;
use crate::render::to_rgb;

/// The content of `comparison.json`. All errors are of irradiance per patch: area-weighted relative root mean
/// squares, the reference's noise taken off.
#[derive(Clone, Debug, Serialize)]
pub struct ComparisonSummary {
    /// The scene's name.
    pub scene: String,
    /// This program's version.
    pub version: &'static str,
    /// The seed of all random sequences.
    pub seed: u64,
    /// Number of threads.
    pub threads: usize,
    /// Number of patches (unknowns).
    pub patches: usize,
    /// Rays per patch.
    pub rays: u32,
    /// How light varies over a patch: `constant` or `linear`.
    pub basis: &'static str,
    /// The series, order by order.
    pub orders: Vec<OrderSummary>,
    /// The direct solution.
    pub direct: DirectSummary,
    /// What both are held against.
    pub reference: ReferenceSummary,
    /// Where time went.
    pub stages: Vec<Stage>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Whether the answer can be relied on by itself, without the reference.
    pub verdict: Verdict,
}

/// One order of the series.
#[derive(Clone, Debug, Serialize)]
pub struct OrderSummary {
    /// k.
    pub order: usize,
    /// From the direct solution.
    pub vs_direct: f64,
    /// From the reference.
    pub vs_reference: f64,
    /// Standard error of `vs_reference`.
    pub uncertainty: f64,
    /// Mean difference from the reference, relative to its mean.
    pub bias: f64,
    /// Of the patch that is worst beside its noise, relative to the root mean square of irradiance.
    pub worst: f64,
    /// The same in standard errors.
    pub worst_z: f64,
    /// Bound on `vs_direct`, *guaranteed* for constant elements and *estimated* for linear ones; `null` where
    /// none is known yet.
    pub bound: Option<f64>,
    /// Time that the answer of this order takes, form factors included.
    pub seconds: f64,
}

/// The direct solution.
#[derive(Clone, Debug, Serialize)]
pub struct DirectSummary {
    /// From the reference.
    pub vs_reference: f64,
    /// Standard error of `vs_reference`.
    pub uncertainty: f64,
    /// How much patches of half the length change it: an *estimate* of what the mesh does.
    pub mesh_error: f64,
    /// Root mean square difference in standard errors; 1 where noise is all there is.
    pub z_rms: f64,
    /// Mean difference from the reference, relative to its mean.
    pub bias: f64,
    /// Standard error of `bias`.
    pub bias_error: f64,
    /// Of the patch that is worst beside its noise, relative to the root mean square of irradiance.
    pub worst: f64,
    /// The same in standard errors.
    pub worst_z: f64,
    /// Whether it agrees, in words.
    pub verdict: String,
    /// The tests that decide it.
    pub reasons: Vec<AgreementTest>,
    /// Time that it takes, form factors included.
    pub seconds: f64,
}

/// The path-traced reference.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceSummary {
    /// Paths that were traced.
    pub paths: u64,
    /// Time that they took.
    pub seconds: f64,
    /// Relative standard error of all patches together.
    pub standard_error: f64,
}

impl OrderSummary {
    /// Of an order, with `seconds` for what comes before the series.
    pub fn new(row: &OrderRow, seconds: f64) -> Self {
        Self {
            order: row.order,
            vs_direct: row.vs_direct,
            vs_reference: row.vs_reference.rms,
            uncertainty: row.vs_reference.uncertainty,
            bias: row.vs_reference.bias,
            worst: row.vs_reference.worst.relative,
            worst_z: row.vs_reference.worst.z,
            bound: row.bound.is_finite().then_some(row.bound),
            seconds: seconds + row.seconds,
        }
    }
}

impl DirectSummary {
    /// Of the direct solution, which took `seconds`.
    pub fn new(comparison: &Comparison, seconds: f64) -> Self {
        let by_patch = &comparison.by_patch;
        Self {
            vs_reference: by_patch.rms,
            uncertainty: by_patch.uncertainty,
            mesh_error: comparison.mesh_change,
            z_rms: by_patch.z_rms,
            bias: by_patch.bias,
            bias_error: by_patch.bias_error,
            worst: by_patch.worst.relative,
            worst_z: by_patch.worst.z,
            verdict: comparison.verdict(),
            reasons: comparison.reasons.clone(),
            seconds,
        }
    }
}

impl From<&PathTraced> for ReferenceSummary {
    fn from(traced: &PathTraced) -> Self {
        let standard_error = traced.relative_standard_error();
        Self { paths: traced.paths(), seconds: traced.seconds(), standard_error }
    }
}

/// Writes `comparison.json`.
///
/// # Errors
/// Those of `writer`.
pub fn write_comparison_summary(writer: &mut dyn Write, summary: &ComparisonSummary) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *writer, summary)?;
    writeln!(writer)
}

const COLUMNS: [&str; 17] = [
    "patch",
    "face",
    "side",
    "area",
    "direct_r",
    "direct_g",
    "direct_b",
    "reference_r",
    "reference_g",
    "reference_b",
    "error_r",
    "error_g",
    "error_b",
    "mesh_r",
    "mesh_g",
    "mesh_b",
    "paths",
];

/// Writes `comparison.csv`: per patch the irradiance of the direct solution (n × c, W·m⁻²) and of the
/// reference with its standard error, what patches of half the length change, and how many paths started
/// there.
///
/// # Errors
/// Those of `writer`.
pub fn write_comparison_table(
    writer: &mut dyn Write,
    patches: &Patches,
    irradiance: &DMatrix<f64>,
    reference: &PathTraced,
    mesh: &MeshError,
) -> io::Result<()> {
    let (means, errors) = (reference.means(), reference.standard_errors());
    let fields = [irradiance, &means, &errors, mesh.change()];
    table::write_columns(writer, &COLUMNS, |table| {
        for i in 0..patches.len() {
            let place = patches.place(i);
            let keys = [
                i.to_string(),
                place.face.to_string(),
                place.side.name().to_owned(),
                digits(patches.area(i)),
            ];
            let values =
                fields.iter().flat_map(|field| to_rgb(field.row(i).transpose().as_slice())).map(digits);
            let paths = reference.paths_of(i).to_string();
            table.write_record(keys.into_iter().chain(values).chain([paths]))?;
        }
        Ok(())
    })
}
