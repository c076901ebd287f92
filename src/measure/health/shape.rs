//! Shape: faces that are no triangles, twice there, or all but flat; and how large the whole is.

use std::collections::HashSet;

use super::constants::{NEEDLE, PLAUSIBLE, SLIVER};
use super::{Finding, Grade};
use crate::scene::{FaceState, Scene, triangle};
use crate::trace::Tracer;

/// The longest side of the box around the scene, metres.
pub(super) fn size(tracer: &Tracer) -> Finding {
    let extent = 2.0 * tracer.frame().scale();
    let finding = Finding::good("size", extent, Some("m"));
    if PLAUSIBLE.contains(&extent) {
        return finding;
    }
    finding.but(
        Grade::Note,
        [],
        "unusual for a place to be lit: if the file is not in metres, set `unit` (metres per unit of the file) in the .toml beside \
         it; radiance and irradiance stay the same, powers grow with its square",
    )
}

/// The kept faces' numbers.
pub(super) fn kept(scene: &Scene) -> impl Iterator<Item = usize> {
    with_state(scene, FaceState::Kept)
}

fn with_state(scene: &Scene, state: FaceState) -> impl Iterator<Item = usize> {
    scene.faces().iter().enumerate().filter(move |(_, face)| face.state == state).map(|(number, _)| number)
}

/// How many faces were dropped because their corners lie on a line.
pub(super) fn zero_area(scene: &Scene) -> Finding {
    let count = with_state(scene, FaceState::ZeroArea).count();
    let finding = Finding::good("zero-area faces", count as f64, Some("faces"));
    if count == 0 {
        return finding;
    }
    let found = with_state(scene, FaceState::ZeroArea);
    finding.but(
        Grade::Note,
        found,
        "they are left out, which changes no light; delete them to be rid of this",
    )
}

/// How many faces were dropped because an earlier one has the same corners in the same winding; bad if light
/// is lost with them.
pub(super) fn duplicates(scene: &Scene) -> Finding {
    let dropped: Vec<usize> = with_state(scene, FaceState::Duplicate).collect();
    let finding = Finding::good("duplicate faces", dropped.len() as f64, Some("faces"));
    if dropped.is_empty() {
        return finding;
    }
    let dark = lost_lamps(scene, &dropped);
    if dark.is_empty() {
        let remedy = "the first of each is used and the others are left out; delete them, or move them if they are meant to be \
                      the two sides of something thick";
        return finding.but(Grade::Note, dropped, remedy);
    }
    let remedy = "some of them emit, but the face that is used in their place does not, so that their light is \
                  lost; delete the faces under the lamps, or move the lamps off them";
    finding.but(Grade::Bad, dark, remedy)
}

/// Dropped faces that emit where the face that acts in their place does not.
fn lost_lamps(scene: &Scene, dropped: &[usize]) -> Vec<usize> {
    let emits = |face: &usize| scene.material_of(*face).emits();
    let mut lost: Vec<usize> = dropped.iter().copied().filter(emits).collect();
    if !lost.is_empty() {
        let shining: HashSet<_> =
            kept(scene).filter(emits).map(|face| scene.oriented_corners(face)).collect();
        lost.retain(|&face| !shining.contains(&scene.oriented_corners(face)));
    }
    lost
}

/// The greatest aspect, longest edge over height, of any face.
pub(super) fn slivers(tracer: &Tracer) -> Finding {
    let aspect = |face: usize| {
        let corners = tracer.corners(face);
        triangle::longest_squared(corners) / triangle::across(corners).length()
    };
    let mut all: Vec<(f64, usize)> = kept(tracer.scene()).map(|face| (aspect(face), face)).collect();
    all.sort_unstable_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    let worst = all.first().map_or(1.0, |x| x.0);
    let finding = Finding::good("slivers", worst, Some("longest edge / height"));
    let slivers = all.partition_point(|x| x.0 > SLIVER);
    if slivers == 0 {
        return finding;
    }
    let finding = Finding { count: Some(slivers), ..finding };
    let faces = all[..slivers].iter().map(|x| x.1);
    match worst > NEEDLE {
        true => finding.but(
            Grade::Bad,
            faces,
            "the thinnest are lines to the arithmetic and their normals are rounding: collapse their shortest edges, or \
             remesh there",
        ),
        false => finding.but(
            Grade::Note,
            faces,
            "safe, but patches on them are long and thin and resolve shadows badly; remesh there if that is where you look",
        ),
    }
}
