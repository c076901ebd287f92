//! Agreement: whether an answer agrees with its reference, differs as its mesh explains, or differs as
//! nothing explains.
//!
//! Four things are looked at: the root mean square over patches and over faces, the mean, and the worst
//! patch. Each is first held against the noise of the reference alone, at a level corrected for their number.
//! What noise does not explain is held against what the mesh may do: [`MeshError`] tells how much half the
//! edge changes; with an error that falls only as √h, as it does along the edges of shadows, 2.4 times the
//! change remains, and three times is allowed. An error that does not come from the mesh does not change with
//! it. That rule holds for fine meshes: where it would allow more than a fifth of the light, or a twentieth
//! of the mean, the mesh explains nothing.
//!
//! The worst of the four decides, and all that is said follows from this one decision.

use super::constants::{
    ALWAYS_OF_MEAN, ALWAYS_OF_ONE, COARSER, ERRORS_OF_ONE, LEVEL, MOST_BY_MESH, MOST_OF_MEAN, REMAINS,
    REMAINS_OF_ONE, SURE,
};
use super::difference::{self, Difference, Place};
use super::mesh_error::MeshError;
use crate::patches::Patches;
use crate::reference::PathTraced;

/// How an answer compares with its reference; the later, the worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Agreement {
    /// The noise of the reference is all there is.
    WithinNoise,
    /// There is more than noise, and no more than the mesh explains.
    MeshExplains,
    /// There is more than noise; the mesh may account for it, but is too coarse to tell.
    MeshTooCoarse,
    /// There is more than noise and mesh explain: one of the two answers is wrong.
    NothingExplains,
}

/// One look at a difference.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct AgreementTest {
    /// What was looked at.
    pub what: &'static str,
    /// Its value, relative to the irradiance of the scene.
    pub found: f64,
    /// Its standard error.
    pub uncertainty: f64,
    /// The chance that noise alone would make it so large.
    pub chance: f64,
    /// How much of it the mesh may account for.
    pub mesh: f64,
    /// What follows.
    pub agreement: Agreement,
}

impl Agreement {
    /// The worst of all looks.
    pub(super) fn of(reasons: &[AgreementTest]) -> Self {
        reasons.iter().map(|reason| reason.agreement).max().unwrap_or(Self::WithinNoise)
    }
}

/// A difference that is looked at.
struct Look {
    what: &'static str,
    found: f64,
    uncertainty: f64,
    /// How likely noise alone is as large.
    chance: f64,
    /// What the mesh may make.
    mesh: f64,
}

impl AgreementTest {
    /// What follows from one of so many looks.
    fn of(Look { what, found, uncertainty, chance, mesh }: Look, looks: usize) -> Self {
        let most = match what {
            "mean" => MOST_OF_MEAN,
            "worst patch" => f64::INFINITY,
            _ => MOST_BY_MESH,
        };
        let is_within = |mesh: f64| found.abs() <= mesh + SURE * uncertainty;
        let agreement = if chance > LEVEL / looks as f64 {
            Agreement::WithinNoise
        } else if !is_within(mesh) {
            Agreement::NothingExplains
        } else if is_within(most) {
            Agreement::MeshExplains
        } else {
            Agreement::MeshTooCoarse
        };
        Self { what, found, uncertainty, chance, mesh, agreement }
    }
}

/// How much half the edge changes, relative to the irradiance of the scene.
pub(super) struct Change {
    pub by_patch: f64,
    by_face: f64,
    mean: f64,
    /// Per patch and channel: W·m⁻².
    single: Vec<Vec<f64>>,
    /// Root mean square irradiance of a channel, W·m⁻².
    typical: f64,
}

impl Change {
    pub fn new(patches: &Patches, reference: &PathTraced, mesh: &MeshError) -> Self {
        let (finer, coarser) = (mesh.change(), &mesh.coarser);
        let channels = finer.ncols();
        let area = |i: usize| reference.area(i);
        let n = reference.len();
        let sum = |value: &dyn Fn(usize, usize) -> f64| -> f64 {
            (0..n).map(|i| area(i) * (0..channels).map(|c| value(i, c)).sum::<f64>()).sum()
        };
        let known = reference.means();
        let squares = sum(&|i, c| known[(i, c)].powi(2)).max(f64::MIN_POSITIVE);
        let total = sum(&|i, c| known[(i, c)]).max(f64::MIN_POSITIVE);
        let faces = patches.average_by_face(finer);
        let face_squares: f64 =
            faces.iter().map(|row| row.area * row.mean.iter().map(|x| x * x).sum::<f64>()).sum();
        let means = [finer, coarser].map(|change| (sum(&|i, c| change[(i, c)]) / total).abs());
        let single =
            |i: usize| (0..channels).map(|c| finer[(i, c)].abs() + COARSER * coarser[(i, c)].abs()).collect();
        let all_area = sum(&|_, _| 1.0);
        Self {
            by_patch: (sum(&|i, c| finer[(i, c)].powi(2)) / squares).sqrt(),
            by_face: (face_squares / squares).sqrt(),
            mean: means[0].max(COARSER * means[1]),
            single: (0..n).map(single).collect(),
            typical: (squares / all_area.max(f64::MIN_POSITIVE)).sqrt(),
        }
    }
}

/// Looks at a difference in all four ways.
pub(super) fn reasons(
    places: &[Place],
    by_patch: &Difference,
    by_face: &Difference,
    change: &Change,
) -> Vec<AgreementTest> {
    const LOOKS: usize = 4;
    let [by_square, by_mean, _] = by_patch.chance;
    let [by_face_square, ..] = by_face.chance;
    let mean = REMAINS * change.mean.max(ALWAYS_OF_MEAN * change.by_patch);
    vec![
        AgreementTest::of(
            Look {
                what: "patches",
                found: by_patch.rms,
                uncertainty: by_patch.uncertainty,
                chance: by_square,
                mesh: REMAINS * change.by_patch,
            },
            LOOKS,
        ),
        AgreementTest::of(
            Look {
                what: "faces",
                found: by_face.rms,
                uncertainty: by_face.uncertainty,
                chance: by_face_square,
                mesh: REMAINS * change.by_face,
            },
            LOOKS,
        ),
        AgreementTest::of(
            Look {
                what: "mean",
                found: by_patch.bias,
                uncertainty: by_patch.bias_error,
                chance: by_mean,
                mesh: mean,
            },
            LOOKS,
        ),
        worst_patch(places, by_patch, change, LOOKS),
    ]
}

/// The patch that noise and mesh explain least, if there is one that they do not explain; or else the one
/// that is worst beside its noise.
fn worst_patch(places: &[Place], by_patch: &Difference, change: &Change, looks: usize) -> AgreementTest {
    let values = places.iter().map(|place| place.channels.len()).sum();
    let typical = difference::typical_error(places);
    let always = ALWAYS_OF_ONE * change.by_patch * change.typical;
    let relative = |x: f64| if change.typical > 0.0 { x / change.typical } else { 0.0 };
    let look = |place: usize, channel: usize| {
        let [value, mean, error] = places[place].channels[channel];
        let mesh = REMAINS_OF_ONE * change.single[place][channel] + always;
        let error = if error > 0.0 { error } else { typical };
        let z = if error > 0.0 { (value - mean) / error } else { 0.0 };
        let chance = difference::chance_of_one(z, places[place].degrees_of_freedom, values);
        AgreementTest::of(
            Look {
                what: "worst patch",
                found: relative(value - mean),
                uncertainty: relative(ERRORS_OF_ONE * error),
                chance,
                mesh: relative(mesh),
            },
            looks,
        )
    };
    let all = (0..places.len()).flat_map(|i| (0..places[i].channels.len()).map(move |c| (i, c)));
    let beyond = |reason: &AgreementTest| reason.found.abs() - SURE * reason.uncertainty - reason.mesh;
    let unexplained = all
        .map(|(i, c)| look(i, c))
        .filter(|reason| reason.agreement == Agreement::NothingExplains)
        .max_by(|a, b| beyond(a).total_cmp(&beyond(b)));
    let worst = by_patch.worst;
    match unexplained {
        Some(reason) => reason,
        None if places.is_empty() => AgreementTest::of(
            Look { what: "worst patch", found: 0.0, uncertainty: 0.0, chance: 1.0, mesh: 0.0 },
            looks,
        ),
        None => look(worst.place, worst.channel),
    }
}
