//! The operator's health: closure, reciprocity, row sums, ‖K‖∞ and the condition of I − K.

use std::ops::Range;

use nalgebra::DMatrix;

use super::constants::{ILL_CONDITIONED, ROUNDING, TOLERABLE, WELL_CONDITIONED};
use super::{Finding, Grade};
use crate::patches::{Patches, Slot};
use crate::progress::Progress;
use crate::solve::{Amplification, Problem, SolveError};
use crate::transport::{Exchange, FormFactors, Transport, TransportError};

/// The health of form factors and of the operator that they make with the scene's own reflectances.
///
/// A scene that traps light for ever is a bad finding, `condition`, and no error.
///
/// # Errors
/// `Cancelled`.
pub fn operator_health(
    factors: &FormFactors,
    patches: &Patches,
    progress: Progress,
) -> Result<Vec<Finding>, SolveError> {
    // The worst of the tones stands for all.
    let worst = |of: &dyn Fn(&Exchange) -> Finding| {
        let each = factors.exchanges().iter().map(of);
        each.reduce(|a, b| if b.value > a.value { b } else { a })
    };
    let mut findings: Vec<Finding> = [
        worst(&|exchange| closure(exchange, patches)),
        worst(&reciprocity),
        worst(&|exchange| row_sums(exchange, patches)),
        Some(agreement(factors)),
    ]
    .into_iter()
    .flatten()
    .collect();
    match Problem::unlit(patches, factors) {
        Ok(problem) => {
            let k = problem.operator();
            findings.push(norm(k));
            findings.push(condition(k, patches, progress)?);
        }
        Err(error) => findings.push(unsolvable(&error, patches)),
    }
    Ok(findings)
}

/// The most that a row, with what escapes, is off from its patch's area, relative to that.
fn closure(exchange: &Exchange, patches: &Patches) -> Finding {
    let sums = sums(exchange);
    let off = |i: usize| {
        let error = (sums[i] + exchange.ends().leaving[i] - exchange.sums()[i]).abs();
        error / exchange.sums()[i]
    };
    let value = (0..exchange.len()).map(off).fold(0.0, f64::max);
    let finding = Finding::good("closure", value, Some("of light gained or lost"));
    if value < ROUNDING {
        return finding;
    }
    let off = |patch: usize| coefficients(exchange, patch).map(off).fold(0.0, f64::max);
    let verdict = if value < TOLERABLE { Grade::Fair } else { Grade::Bad };
    let remedy = match exchange.closure_error() < ROUNDING {
        true => {
            "these faces send more than the faces they see send back, and more rays will not help: they lie \
             in one plane with others, are doubled, or line a closed pocket; delete what is double, or move \
             it off the plane"
        }
        false => "the form factors are damaged: trace them anew",
    };
    finding.but(verdict, worst_faces(patches, off, ROUNDING), remedy)
}

/// The greatest |S_ij − S_ji| relative to the lesser area.
fn reciprocity(exchange: &Exchange) -> Finding {
    let value = exchange.reciprocity_error();
    let finding = Finding::good("reciprocity", value, Some("of light one way only"));
    if value == 0.0 {
        return finding;
    }
    let remedy = "exchange areas differ between to and fro: the form factors are damaged; trace them anew";
    finding.but(Grade::Bad, [], remedy)
}

/// The greatest sum of a patch's form factors, 1 in a closed place.
fn row_sums(exchange: &Exchange, patches: &Patches) -> Finding {
    let sums = sums(exchange);
    let sum = |i: usize| sums[i] / exchange.sums()[i];
    let sum = |patch: usize| coefficients(exchange, patch).map(sum).fold(0.0, f64::max);
    let value = (0..patches.len()).map(sum).fold(0.0, f64::max);
    let finding = Finding::good("row sums", value, Some("at most"));
    if value <= 1.0 + ROUNDING {
        return finding;
    }
    let remedy = "these faces give out more than they get: trace more rays (--rays)";
    finding.but(Grade::Bad, worst_faces(patches, sum, 1.0 + ROUNDING), remedy)
}

/// How many pairs of face sides found different exchange areas to and fro.
fn agreement(factors: &FormFactors) -> Finding {
    let found = factors.disagreements();
    let finding = Finding::good("directions", found.len() as f64, Some("pairs of faces that disagree"));
    let Some(worst) = found.first() else { return finding };
    let remedy = format!(
        "rays from these faces to others and back find different amounts of light, by up to {:.0} standard errors: faces meet there in a          way that rounding decides; look for faces that almost coincide",
        worst.z
    );
    finding.but(Grade::Fair, found.iter().flat_map(|pair| pair.sides.map(|(face, _)| face)), remedy)
}

/// ‖K‖∞, the largest share of what arrives anywhere that goes on to where it is not lost.
fn norm(k: &Transport) -> Finding {
    let value = k.norm().into_iter().fold(0.0, f64::max);
    let finding = Finding::good("‖K‖∞", value, None);
    if value <= 1.0 + ROUNDING {
        return finding;
    }
    finding.but(Grade::Bad, [], "a bounce adds energy: trace more rays (--rays)")
}

/// A bound on the condition number of I − K: by how much an error of its entries can grow.
fn condition(k: &Transport, patches: &Patches, progress: Progress) -> Result<Finding, SolveError> {
    let value = Amplification::new(k, progress)?.condition();
    let finding = Finding::good("condition", value, Some("at most"));
    if value < WELL_CONDITIONED {
        return Ok(finding);
    }
    let (brightest, passed_on) = brightest(patches);
    let remedy = format!(
        "light goes on almost for ever, and small errors of reflectances become large ones of the answer; lower the reflectance of \
         {brightest} ({passed_on}), which few real surfaces have"
    );
    let verdict = if value < ILL_CONDITIONED { Grade::Fair } else { Grade::Bad };
    Ok(finding.but(verdict, [], remedy))
}

fn unsolvable(error: &TransportError, patches: &Patches) -> Finding {
    let TransportError::Unsolvable { materials } = error else {
        return Finding::good("condition", f64::INFINITY, None).but(Grade::Bad, [], error.to_string());
    };
    let scene = patches.scene();
    let traps = |face: usize| materials.contains(&scene.material_of(face).name);
    let mut faces: Vec<usize> =
        (0..patches.len()).map(|i| patches.place(i).face).filter(|&f| traps(f)).collect();
    faces.dedup();
    Finding::good("condition", f64::INFINITY, None).but(Grade::Bad, faces, error.to_string())
}

/// The material that passes most on, by reflection and where it is a sheet through it, and how much.
fn brightest<'s>(patches: &Patches<'s>) -> (&'s str, f64) {
    let scene = patches.scene();
    let most = |place: &Slot| scene.material_of(place.face).highest_albedo(place.side);
    let places = (0..patches.len()).map(|i| patches.place(i));
    let brightest = places.max_by(|a, b| most(a).total_cmp(&most(b)));
    brightest.map_or(("nothing", 0.0), |place| (&scene.material_of(place.face).name, most(&place)))
}

/// The coefficients of a patch.
fn coefficients(exchange: &Exchange, patch: usize) -> Range<usize> {
    let each = exchange.basis().coefficients();
    each * patch..each * (patch + 1)
}

/// Σ_j S_ij.
fn sums(exchange: &Exchange) -> DMatrix<f64> {
    let mut sums = DMatrix::zeros(exchange.len(), 1);
    exchange.apply(&DMatrix::repeat(exchange.len(), 1, 1.0), &mut sums);
    sums
}

/// The faces of patches whose value exceeds `limit`, the worst first, each once.
fn worst_faces(patches: &Patches, value: impl Fn(usize) -> f64, limit: f64) -> Vec<usize> {
    let mut over: Vec<(f64, usize)> =
        (0..patches.len()).map(|i| (value(i), patches.place(i).face)).filter(|x| x.0 > limit).collect();
    over.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut faces = Vec::new();
    for (_, face) in over {
        if faces.len() < Finding::MOST_FACES && !faces.contains(&face) {
            faces.push(face);
        }
    }
    faces
}
