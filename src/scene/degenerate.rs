//! Degenerate faces: those without area, and exact duplicates, which take no part.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::DVec3;

use super::grouped::count;
use super::{Face, FaceState, Material, triangle};

/// Marks zero-area faces and exact duplicates, and says how many there were.
pub(super) fn drop_degenerate(
    faces: &mut [Face],
    vertices: &[DVec3],
    materials: &[Material],
    warnings: &mut Vec<String>,
) {
    let (mut flat, mut twice, mut lamps_lost) = (0, 0, 0);
    let mut emits_at: HashMap<[[u64; 3]; 3], bool> = HashMap::new();
    for face in faces.iter_mut() {
        let corners = face.vertices.map(|v| vertices[v as usize]);
        if triangle::across(&corners).length() <= 1e-12 * triangle::longest_squared(&corners) {
            face.state = FaceState::ZeroArea;
            flat += 1;
            continue;
        }
        let corners = oriented(corners);
        let emits = materials[face.material as usize].emits();
        match emits_at.entry(corners) {
            Entry::Vacant(first) => {
                first.insert(emits);
            }
            Entry::Occupied(first) => {
                face.state = FaceState::Duplicate;
                twice += 1;
                lamps_lost += usize::from(emits && !first.get());
            }
        }
    }
    if flat > 0 {
        warnings.push(format!("dropped {}: no area", count(flat, "face")));
    }
    if twice > 0 {
        warnings.push(format!("dropped {}: duplicates of earlier faces", count(twice, "face")));
    }
    if lamps_lost > 0 {
        warnings.push(format!("{} of those emit, the earlier ones do not", count(lamps_lost, "duplicate")));
    }
}

/// A triangle as a key: the same for the same corners in the same winding. The other winding lies back to
/// back and is another face.
pub(super) fn oriented(corners: [DVec3; 3]) -> [[u64; 3]; 3] {
    // Adding zero makes -0.0 and 0.0 the same corner.
    let mut corners = corners.map(|p| (p + DVec3::ZERO).to_array().map(f64::to_bits));
    let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
    corners.rotate_left(first);
    corners
}
