//! Mesh error: what the size of patches does to the answer, told from what larger ones would have done.
//!
//! Some five patches at a time are merged, and the scene is solved with what the larger patches exchange: no
//! new rays, and the noise of those that there are is in both answers. Where error falls in proportion to the
//! edge it is √5 times as large on the larger patches; and where errors of patches are not alike in sign, as
//! along the edges of shadows, a mean over some of them takes more from many small ones than from few large
//! ones, so that it is 5 times as large over faces of more patches than are merged.
//!
//! Near lamps light varies within patches more than merging them shows. What is known of it there tells what
//! it changes elsewhere.

use std::collections::HashSet;
use std::f64::consts::PI;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::constants::{
    CHANGE_TOLERANCE, FLAT_NORMALS, FOCUSED, MERGED, MERGED_ENOUGH, MERGED_LINEAR, MESH_AT_MOST,
    MESH_AT_MOST_LINEAR, NORMAL_STEPS, REMAINS_LINEAR,
};
use crate::measure::MeasureError;
use crate::patches::{Basis, Clusters, Patches};
use crate::progress::Progress;
use crate::scene::triangle;
use crate::solve::roughly;
use crate::transport::{FormFactors, Reflection, Sources, Transport};

/// How many patches are taken together for coarser elements.
fn together(basis: Basis) -> f64 {
    match basis {
        Basis::Constant => MERGED,
        Basis::Linear => MERGED_LINEAR,
    }
}

/// How much merging could tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::measure) struct Insight {
    pub basis: Basis,
    /// How many patches were merged into one.
    pub merged: f64,
    /// Whether lamps shine by way of curved carriers.
    pub is_focused: bool,
}

impl Insight {
    /// What is left as error of the change by merging, in a mean over so many patches. Errors of constant
    /// elements in proportion to the edge that are not alike in sign are √m times as large on patches merged
    /// from m, and of n such patches there are only n/m to take the mean of, if more than one.
    ///
    /// Where lamps shine by way of curved glass or mirrors, they light spots smaller than patches, and most
    /// what they find again by the same way: more is left.
    pub fn remains(&self, patches: f64) -> f64 {
        let usually = match self.basis {
            Basis::Constant => 1.0 / (1.0 + self.merged * patches.min(self.merged)).sqrt(),
            Basis::Linear => REMAINS_LINEAR,
        };
        if self.is_focused { FOCUSED * usually } else { usually }
    }

    /// How many times less of it is left in a mean over so many patches than in one.
    pub fn less(&self, patches: f64) -> f64 {
        self.remains(1.0) / self.remains(patches)
    }

    /// How many times more than estimated the mesh error may be, in nineteen of twenty cases. Where faces are
    /// cut but little, few patches can be merged, and little is told of the rest.
    pub fn at_most(&self) -> f64 {
        match self.basis {
            Basis::Constant => MESH_AT_MOST * (MERGED_ENOUGH / self.merged).max(1.0),
            Basis::Linear => MESH_AT_MOST_LINEAR,
        }
    }
}

/// What is known of the mesh error.
pub(super) struct MeshError {
    /// How much more irradiance patches have (n × c, W·m⁻²) than with coarser elements; an error of which
    /// [`Insight::remains`] tells how much is left.
    pub by_merging: DMatrix<f64>,
    /// What light that varies within patches near lamps changes, as either half of the rays has it; nothing
    /// for linear elements.
    pub by_variation: [DMatrix<f64>; 2],
    /// How much this tells.
    pub insight: Insight,
}

/// What is known of an answer, as means over patches (n × c).
pub(super) struct Known<'a> {
    pub radiance: &'a DMatrix<f64>,
    pub irradiance: &'a DMatrix<f64>,
    /// The order of a truncated series.
    pub order: Option<usize>,
}

/// How far irradiance may be off by the size of patches. `k` is of constant elements, `factors` of the
/// answer's.
pub(super) fn mesh_error(
    patches: &Patches,
    (factors, k): (&FormFactors, &Transport),
    sources: &Sources,
    known: &Known,
) -> Result<MeshError, MeasureError> {
    let basis = factors.basis();
    let &Known { radiance, irradiance, order } = known;
    let light: Vec<f64> = irradiance.row_iter().map(|row| row.sum()).collect();
    let clusters = patches.clusters(together(basis), Some(&light));
    let merged_factors = k.factors().merged(&clusters.of_patch, clusters.count);
    let coarse_k = Transport::new(&merged_factors, Reflection::of(patches).merged(patches, &clusters))?;
    let by_cluster = |field: &DMatrix<f64>| patches.average_by(&clusters, &basis.means(field));
    let coarse = Sources {
        emitted: by_cluster(&sources.emitted),
        direct: sources.direct.as_ref().map(by_cluster),
        bright: sources.bright.as_ref().map(|bright| bright.map(by_cluster)),
        spread: Vec::new(),
        carried: None,
        lamps: None,
    };
    let change = changed_by(patches, &clusters, &coarse_k, &coarse, known)?;
    // What light that varies sends elsewhere has arrived from order 2 on.
    let by_variation = match basis {
        Basis::Constant if order.is_none_or(|order| order > 1) => {
            varied(patches, &clusters, (factors, &coarse_k), radiance)?
        }
        _ => [0; 2].map(|_| DMatrix::zeros(radiance.nrows(), radiance.ncols())),
    };
    let merged = patches.len() as f64 / clusters.count as f64;
    let insight =
        Insight { basis, merged, is_focused: factors.has_caustics() && has_curved_carriers(patches) };
    let mut by_merging = patches.spread_over(&clusters, &change);
    if order != Some(0) {
        by_merging += within(patches, &clusters, k, radiance);
    }
    Ok(MeshError { by_merging, by_variation, insight })
}

/// How much more irradiance patches (n × c, W·m⁻²) have here than if each cluster sent out constant light, as
/// far as that differs within a cluster: on faces smaller than clusters what their clusters have as a whole
/// tells little.
fn within(patches: &Patches, clusters: &Clusters, k: &Transport, radiance: &DMatrix<f64>) -> DMatrix<f64> {
    let smooth = |field: &DMatrix<f64>| patches.spread_over(clusters, &patches.average_by(clusters, field));
    let more = k.irradiance(&(radiance - smooth(radiance)));
    let common = smooth(&more);
    more - common
}

/// What light that varies within patches near lamps changes, all reflections of it included.
fn varied(
    patches: &Patches,
    clusters: &Clusters,
    (factors, k): (&FormFactors, &Transport),
    radiance: &DMatrix<f64>,
) -> Result<[DMatrix<f64>; 2], MeasureError> {
    let [first, second] = factors.varied(patches, radiance)?;
    let with_reflections = |straight: DMatrix<f64>| -> Result<DMatrix<f64>, MeasureError> {
        if straight.iter().all(|&change| change == 0.0) {
            return Ok(straight);
        }
        let reflected = k.reflect(&patches.average_by(clusters, &straight));
        let more = k.irradiance(&roughly(k, &reflected, CHANGE_TOLERANCE, Progress::default())?);
        Ok(straight + patches.spread_over(clusters, &more))
    };
    Ok([with_reflections(first)?, with_reflections(second)?])
}

/// What irradiance of patches (n × c, W·m⁻²) may be off because what they see of larger patches nearby is
/// unlike these as a whole, such as what lies in their own shadow: π L F of each such patch, by the part of
/// it that a patch does not cover, and by F once more: what comes from many patches is as bright as they are
/// on average.
pub(super) fn unresolved(patches: &Patches, factors: &FormFactors, radiance: &DMatrix<f64>) -> DMatrix<f64> {
    let (areas, channels) = (patches.normalised_areas(), radiance.ncols());
    let of_patch = |i: usize| {
        let mut squares = vec![0.0; channels];
        factors.exchange().for_entries(i, |j, exchange| {
            let share = exchange / areas[i];
            let unlike = PI * share * share * (1.0 - areas[i] / areas[j]).max(0.0);
            let squared = unlike * unlike;
            squares.iter_mut().enumerate().for_each(|(c, sum)| *sum += squared * radiance[(j, c)].powi(2));
        });
        squares.into_iter().map(f64::sqrt).collect::<Vec<_>>()
    };
    let rows: Vec<Vec<f64>> = (0..patches.len()).into_par_iter().map(of_patch).collect();
    DMatrix::from_fn(patches.len(), channels, |i, c| rows[i][c])
}

/// Whether surfaces that pass light on undiffused face more than a few ways.
fn has_curved_carriers(patches: &Patches) -> bool {
    let scene = patches.scene();
    let ways = (0..scene.faces().len())
        .filter(|&face| scene.passes_on(face))
        .map(|face| (triangle::normal(&scene.corners(face)) * NORMAL_STEPS).round().as_ivec3());
    ways.collect::<HashSet<_>>().len() > FLAT_NORMALS
}

/// How much more irradiance clusters have here than in the scene solved with constant light on clusters,
/// whose sources these are.
fn changed_by(
    patches: &Patches,
    clusters: &Clusters,
    k: &Transport,
    sources: &Sources,
    &Known { radiance, irradiance, order }: &Known,
) -> Result<DMatrix<f64>, MeasureError> {
    let mean = |field: &DMatrix<f64>| patches.average_by(clusters, field);
    let e = sources.right_hand_side(k);
    let on_clusters = match order {
        // What is known is nearly right: only what it lacks is solved for, and that need not be exact.
        None => {
            let known = mean(radiance);
            let lacking = e + k.reflect(&k.irradiance(&known)) - &known;
            k.irradiance(&(known + roughly(k, &lacking, CHANGE_TOLERANCE, Progress::default())?))
        }
        Some(order) => (0..order)
            .fold(sources.at_order_0(), |irradiance, _| k.irradiance(&(&e + k.reflect(&irradiance)))),
    };
    let mut there = on_clusters;
    sources.add_beside_the_operator(&mut there);
    Ok(mean(irradiance) - there)
}
