//! Mesh error: what the size of patches does to the answer, told from what larger ones would have done.
//!
//! Four patches at a time are merged, and the scene is solved with what the larger patches exchange: no new rays, and the noise of those that
//! there are is in both answers. Where error falls in proportion to the edge, and errors on the two cuts are not alike in sign, as along the edges of
//! shadows, the change is √5 times the error that is left; where they are alike, as around corners, no more than twice.

use nalgebra::DMatrix;

use crate::measure::MeasureError;
use crate::patches::{Basis, Clusters, Patches};
use crate::solve::{CgOptions, conjugate_gradients};
use crate::transport::{FormFactors, Reflection, Sources, Transport};

/// How many patches are taken together for coarser elements. Linear elements are held against constant ones on the same patches.
fn together(basis: Basis) -> f64 {
    match basis {
        Basis::Constant => 4.0,
        Basis::Linear => 1.0,
    }
}

/// What is left as error of the change that elements coarser by so many patches each make, as a root mean square over faces. Errors of constant
/// elements in proportion to the edge that are not alike in sign leave 1/√(1 + merged) of it; alike, up to 1. Linear elements err about a third as
/// much as constant ones.
fn remains(basis: Basis, merged: f64) -> f64 {
    match basis {
        Basis::Constant => ALIKE / (1.0 + merged).sqrt(),
        Basis::Linear => 0.4,
    }
}

/// How much more errors on two cuts are alike in sign than chance would have it; measured.
const ALIKE: f64 = 1.23;

/// How many times more than estimated the mesh error may be, in nineteen of twenty cases, where so many patches were merged into one: where faces
/// are cut but little, few can be, and little is told of the rest. Fitted to rooms that no test looks at.
pub(in crate::measure) fn at_most(basis: Basis, merged: f64) -> f64 {
    match basis {
        Basis::Constant => 1.4 * (together(basis) / merged).max(1.0),
        Basis::Linear => 1.6,
    }
}

/// How far irradiance per patch (n × c, W·m⁻²) may be off, with the sign in which coarser elements change it; and how many patches were merged into one
/// to tell.
pub(super) fn mesh_error(
    patches: &Patches,
    factors: &FormFactors,
    sources: &Sources,
    irradiance: &DMatrix<f64>,
) -> Result<(DMatrix<f64>, f64), MeasureError> {
    let light: Vec<f64> = irradiance.row_iter().map(|row| row.sum()).collect();
    let clusters = patches.clusters(together(factors.basis()), Some(&light));
    let on_clusters = solved_on(patches, &clusters, factors, sources)?;
    let change = patches.average_by(&clusters, irradiance) - on_clusters;
    let merged = patches.len() as f64 / clusters.count as f64;
    Ok((patches.spread_over(&clusters, &(remains(factors.basis(), merged) * change)), merged))
}

/// Irradiance per cluster of the scene solved with constant light on clusters.
fn solved_on(
    patches: &Patches,
    clusters: &Clusters,
    factors: &FormFactors,
    sources: &Sources,
) -> Result<DMatrix<f64>, MeasureError> {
    let basis = factors.basis();
    let each = basis.coefficients();
    let of_coefficient: Vec<usize> =
        clusters.of_patch.iter().flat_map(|&cluster| std::iter::repeat_n(cluster, each)).collect();
    let merged = factors.merged(&of_coefficient, clusters.count);
    let mean = |field: &DMatrix<f64>| patches.average_by(clusters, field);
    let k = Transport::new(&merged, Reflection::of(patches).merged(patches, clusters))?;
    let sources = Sources {
        emitted: mean(&basis.means(&sources.emitted)),
        direct: sources.direct.as_ref().map(|direct| mean(&basis.means(direct))),
        spread: Vec::new(),
        carried: None,
    };
    let options = CgOptions { tolerance: 1e-5, ..Default::default() };
    let solution = conjugate_gradients(&k, &sources.right_hand_side(&k), &options)?.under(&sources);
    Ok(solution.irradiance)
}
