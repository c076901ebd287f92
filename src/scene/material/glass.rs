//! Glass: a dielectric needs an inside, which only a closed surface that fronts outward has.

use std::collections::HashMap;

use glam::DVec3;

use crate::scene::{Face, FaceState, Material, Surface};

/// A directed edge by the bits of its ends.
type Edge = [[u64; 3]; 2];

/// Warns of every dielectric whose faces leave edges open, or enclose a space with their backs outward.
pub(crate) fn warn_of_missing_insides(
    faces: &[Face],
    vertices: &[DVec3],
    materials: &[Material],
    warnings: &mut Vec<String>,
) {
    for (number, material) in (0u32..).zip(materials) {
        if !matches!(material.surface, Surface::Dielectric { .. }) {
            continue;
        }
        let own = faces.iter().filter(|face| face.state == FaceState::Kept && face.material == number);
        let corners: Vec<[DVec3; 3]> = own.map(|face| face.vertices.map(|v| vertices[v as usize])).collect();
        let open = open_edges(&corners);
        if open > 0 {
            warnings.push(format!(
                "material {}: this glass has no inside: {open} edges of its surface are open or wound both ways; close the mesh with \
                 all fronts outward; for a sheet of glass write `[material.{}]` and `thin = true` into the scene's .toml",
                material.name, material.name
            ));
        } else if volume(&corners) < 0.0 {
            warnings.push(format!(
                "material {}: this glass is inside out, for its faces front inward; flip their winding",
                material.name
            ));
        }
    }
}

/// Directed edges that no face passes as often in the other direction.
fn open_edges(faces: &[[DVec3; 3]]) -> usize {
    let mut passed: HashMap<Edge, i64> = HashMap::new();
    for corners in faces {
        // Adding zero makes -0.0 and 0.0 the same place.
        let bits = corners.map(|p| (p + DVec3::ZERO).to_array().map(f64::to_bits));
        for (a, b) in [(bits[0], bits[1]), (bits[1], bits[2]), (bits[2], bits[0])] {
            let (edge, sign) = if a < b { ([a, b], 1) } else { ([b, a], -1) };
            *passed.entry(edge).or_default() += sign;
        }
    }
    passed.values().filter(|&&balance| balance != 0).count()
}

/// The volume that faces enclose, positive where they front outward: Σ a·(b × c)/6.
fn volume(faces: &[[DVec3; 3]]) -> f64 {
    let Some(&[origin, ..]) = faces.first() else { return 0.0 };
    let tetrahedron = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|p| p - origin);
        a.dot(b.cross(c)) / 6.0
    };
    faces.iter().map(tetrahedron).sum()
}
