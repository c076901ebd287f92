//! Overlaps: faces that lie on each other in one plane, by objects.

use std::collections::BTreeMap;

use super::{Finding, Grade};
use crate::trace::{Overlap, OverlapKind, Tracer};

/// Two objects whose faces coincide with fronts that point the same way.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectOverlap {
    /// The name of the object on top, and of the one that it covers.
    pub objects: [String; 2],
    /// Area that is covered, m².
    pub area: f64,
    /// The covered faces, ascending.
    pub faces: Vec<usize>,
}

/// What overlaps with fronts that point the same way, by pairs of objects, the largest area first. Faces back
/// to back are not listed: boxes stand on floors.
pub fn overlaps(tracer: &Tracer) -> Vec<ObjectOverlap> {
    let scene = tracer.scene();
    let mut by_objects: BTreeMap<[u32; 2], (f64, Vec<usize>)> = BTreeMap::new();
    for overlap in of_kind(tracer, OverlapKind::SameFront) {
        let objects = overlap.faces.map(|face| scene.faces()[face as usize].object);
        let (area, faces) = by_objects.entry(objects).or_default();
        *area += overlap.area;
        faces.push(overlap.faces[1] as usize);
    }
    let name = |object: u32| scene.objects()[object as usize].clone();
    let mut found: Vec<ObjectOverlap> = by_objects
        .into_iter()
        .map(|(objects, (area, mut faces))| {
            faces.sort_unstable();
            faces.dedup();
            ObjectOverlap { objects: objects.map(name), area, faces }
        })
        .collect();
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    found
}

fn of_kind<'t>(tracer: &'t Tracer, kind: OverlapKind) -> impl Iterator<Item = &'t Overlap> {
    tracer.overlaps().iter().filter(move |overlap| overlap.kind == kind)
}

/// The area of faces that lie on others with fronts that point the same way.
pub(super) fn same_front(tracer: &Tracer) -> Finding {
    let found = overlaps(tracer);
    let area = found.iter().fold(0.0, |sum, overlap| sum + overlap.area);
    let finding = Finding::good("overlaps", area, Some("m² in one plane, one front"));
    if found.is_empty() {
        return finding;
    }
    let told = found.iter().take(Finding::MOST_FACES).map(|overlap| {
        let [upper, lower] = &overlap.objects;
        format!("{upper} on {lower} {:.3e} m²", overlap.area)
    });
    let remedy = format!(
        "the smaller coplanar surface is taken to be on top, of equal ones the first in the file; lift one off the other if another \
         order is meant, or delete what is twice there: {}",
        told.collect::<Vec<_>>().join(", ")
    );
    let pairs = of_kind(tracer, OverlapKind::SameFront).count();
    let faces = found.iter().flat_map(|overlap| overlap.faces.iter().copied());
    Finding { count: Some(pairs), ..finding }.but(Grade::Note, faces, remedy)
}

/// The area of faces that lie back to back.
pub(super) fn back_to_back(tracer: &Tracer) -> Finding {
    let area = of_kind(tracer, OverlapKind::BackToBack).fold(0.0, |sum, overlap| sum + overlap.area);
    Finding::good("back to back", area, Some("m² in one plane"))
}
