//! Groups: the errors of objects and materials, each held against its own light.

use serde::Serialize;

use super::ErrorBudget;
use super::faces::Faces;
use super::fields::Fields;
use crate::patches::Patches;

/// How wrong irradiance by face is on an object or a material, relative to its own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupError {
    /// `object` or `material`.
    pub kind: &'static str,
    /// Its name.
    pub name: String,
    /// How many patches it has.
    pub patches: usize,
    /// Root mean square irradiance of its faces, W·m⁻².
    pub irradiance: f64,
    /// The error to be expected, as area-weighted relative root mean square over its faces and all channels.
    pub relative_rms: f64,
    /// What it does not exceed in 95 cases of 100.
    pub upper95: f64,
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
            GroupError {
                kind,
                name: name.to_owned(),
                patches: count,
                irradiance: budget.irradiance,
                relative_rms: budget.relative_rms,
                upper95: budget.upper95,
            }
        };
        groups.map(error).collect()
    };
    let objects = scene.objects().iter().map(String::as_str).collect();
    let materials = scene.materials().iter().map(|material| material.name.as_str()).collect();
    let mut all = errors("object", objects, &|face| scene.faces()[face].object);
    all.extend(errors("material", materials, &|face| scene.faces()[face].material));
    all
}
