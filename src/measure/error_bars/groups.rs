//! Groups: the errors of objects, materials and receivers, each held against its own light, and which of them
//! is the worst.

use serde::Serialize;

use super::ErrorBudget;
use super::constants::LEAST_PATCHES;
use super::faces::Faces;
use super::fields::Fields;
use crate::measure::DARK;
use crate::patches::Patches;

/// How wrong irradiance is by face on an object or a material, or at the points of a receiver, relative to
/// its own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupError {
    /// [`GroupError::OBJECT`], [`GroupError::MATERIAL`] or [`GroupError::RECEIVER`]; or [`GroupError::ALL`].
    pub kind: &'static str,
    /// Its name.
    pub name: String,
    /// How many patches it has; of a receiver, points.
    pub patches: usize,
    /// What is to be expected, and why.
    #[serde(flatten)]
    pub budget: ErrorBudget,
}

impl GroupError {
    /// All faces.
    pub const ALL: &'static str = "all";
    /// Faces of one object.
    pub const OBJECT: &'static str = "object";
    /// Faces of one material.
    pub const MATERIAL: &'static str = "material";
    /// Points of a receiver.
    pub const RECEIVER: &'static str = "receiver";

    /// Whether it is large enough to speak for a scene of so many patches, receivers always are, and has
    /// light that is more than darkness beside the scene's root mean square irradiance.
    pub fn counts(&self, patches: usize, irradiance: f64) -> bool {
        let is_large = self.kind == Self::RECEIVER || self.patches as f64 >= LEAST_PATCHES * patches as f64;
        is_large && self.budget.irradiance > DARK * irradiance
    }
}

/// The object or receiver whose error is the largest by `size`, of those that count in a scene of so many
/// patches and so much irradiance.
pub(super) fn worst(
    groups: &[GroupError],
    (patches, irradiance): (usize, f64),
    size: impl Fn(&ErrorBudget) -> f64,
) -> Option<&GroupError> {
    let counts = |group: &&GroupError| {
        group.kind != GroupError::MATERIAL
            && group.counts(patches, irradiance)
            && group.budget.upper95.is_finite()
    };
    let candidates = groups.iter().filter(counts);
    candidates.max_by(|a, b| size(&a.budget).total_cmp(&size(&b.budget)))
}

/// The errors of every object and material that has patches, in order of their numbers; `budget` makes one of
/// some faces and their fields.
pub(super) fn by_group(
    patches: &Patches,
    faces: &Faces,
    fields: &Fields,
    budget: impl Fn(&Faces, &Fields) -> ErrorBudget,
) -> Vec<GroupError> {
    let scene = patches.scene();
    let errors = |kind, names: Vec<&str>, of: &dyn Fn(usize) -> u32| -> Vec<GroupError> {
        let mut members = vec![Vec::new(); names.len()];
        for (row, face) in faces.irradiance.iter().enumerate() {
            members[of(face.face) as usize].push(row);
        }
        let groups = names.into_iter().zip(members).filter(|(_, rows)| !rows.is_empty());
        let error = |(name, rows): (&str, Vec<usize>)| {
            let own = faces.of_rows(&rows);
            let budget = budget(&own, &fields.map(|field| field.select_rows(&rows)));
            let count = own.irradiance.iter().map(|row| patches.patches_of(row.face, row.side).len()).sum();
            GroupError { kind, name: name.to_owned(), patches: count, budget }
        };
        groups.map(error).collect()
    };
    let objects = scene.objects().iter().map(String::as_str).collect();
    let materials = scene.materials().iter().map(|material| material.name.as_str()).collect();
    let mut all = errors(GroupError::OBJECT, objects, &|face| scene.faces()[face].object);
    all.extend(errors(GroupError::MATERIAL, materials, &|face| scene.faces()[face].material));
    all
}
