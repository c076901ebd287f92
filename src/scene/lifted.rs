//! Lifted lights: a light that lies on a face stands a hair in front of it.
//!
//! In a face's own plane a light would be on neither side: half of what it sends would be lost. So a light
//! with a place that touches faces is moved along their normals until it is in front of all of them. What it
//! sends towards them then falls on them, right beside it. Where faces look opposite ways, it is in front of
//! those that come first in the file.

use glam::DVec3;

use super::grouped::count;
use super::{Face, FaceState, Light, triangle};

/// What is as near as this to a face lies on it, and so far in front of it a light is moved at least, as a
/// part of half of the scene's longest side: files often round to as much.
const TOUCH: f64 = 1e-6;

/// By how much farther than it must a light is moved over each face, so that few moves do for several faces.
const MARGIN: f64 = 1.5;

/// Moves over single faces, at most, to get in front of all; a wedge of ten degrees takes 120.
const MOVES: usize = 1000;

/// Lights that are named in the warning.
const NAMED: usize = 3;

/// A plane through a corner of a face, with its unit normal.
type Plane = (DVec3, DVec3);

/// Moves lights that lie on faces in front of these, and says so.
pub(super) fn lift_lights(
    lights: &mut [Light],
    (faces, vertices): (&[Face], &[DVec3]),
    objects: &[String],
    warnings: &mut Vec<String>,
) {
    let corners = |face: &Face| face.vertices.map(|v| vertices[v as usize]);
    let kept = || faces.iter().enumerate().filter(|(_, face)| face.state == FaceState::Kept);
    if lights.iter().all(|light| light.position().is_none()) {
        return;
    }
    let (low, high) = kept()
        .flat_map(|(_, face)| corners(face))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let touch = TOUCH * 0.5 * (high - low).max_element();
    let mut lifted = Vec::new();
    for (number, light) in lights.iter_mut().enumerate() {
        let Some(position) = light.position() else { continue };
        let touched: Vec<(usize, Plane)> = kept()
            .map(|(number, face)| (number, corners(face)))
            .filter(|(_, corners)| distance_to(position, corners, touch) <= touch)
            .map(|(number, corners)| (number, (corners[0], triangle::normal(&corners))))
            .collect();
        let (place, fronts) = in_front_of(position, &touched, touch);
        if let Some(position) = light.position_mut() {
            *position = place;
        }
        if let Some(&first) = fronts.first() {
            let more =
                if fronts.len() > 1 { format!(" and {} more", fronts.len() - 1) } else { String::new() };
            let object = &objects[faces[first].object as usize];
            lifted.push(format!("light {} on face {first} (object {object}){more}", number + 1));
        }
    }
    if !lifted.is_empty() {
        let more = lifted.len().saturating_sub(NAMED);
        let named = lifted[..lifted.len() - more].join(", ");
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        warnings.push(format!(
            "{} in the plane of a face, taken to shine on its front from {touch:.1e} m before it: {named}{more}",
            count(lifted.len(), "light"),
        ));
    }
}

/// Where a light stands in front of the faces that it touches, at least by `lift`, and of which ones.
fn in_front_of(position: DVec3, touched: &[(usize, Plane)], lift: f64) -> (DVec3, Vec<usize>) {
    let (mut place, mut planes, mut fronts) = (position, Vec::new(), Vec::new());
    for &(face, plane) in touched {
        planes.push(plane);
        match raised(place, &planes, lift) {
            Some(higher) => {
                place = higher;
                fronts.push(face);
            }
            None => {
                planes.pop();
            }
        }
    }
    (place, fronts)
}

/// A place over all planes at least by `lift`, by moves over whichever it is lowest over (Agmon 1954); none
/// where there is none near.
fn raised(mut place: DVec3, planes: &[Plane], lift: f64) -> Option<DVec3> {
    for _ in 0..MOVES {
        let height = |&(corner, normal): &Plane| normal.dot(place - corner);
        let lowest = planes.iter().min_by(|a, b| height(a).total_cmp(&height(b)))?;
        let lacking = lift - height(lowest);
        if lacking <= 0.0 {
            return Some(place);
        }
        place += (lacking + (MARGIN - 1.0) * lift) * lowest.1;
    }
    None
}

/// Distance of a point from a triangle; infinite where it is more than `near` from the box around it.
pub(crate) fn distance_to(p: DVec3, corners: &[DVec3; 3], near: f64) -> f64 {
    let &[a, b, c] = corners;
    if (a.min(b).min(c) - p).max(p - a.max(b).max(c)).max_element() > near {
        return f64::INFINITY;
    }
    let normal = triangle::normal(corners);
    let edges = [(a, b), (b, c), (c, a)];
    if edges.iter().all(|&(from, to)| normal.dot((to - from).cross(p - from)) >= 0.0) {
        return normal.dot(p - a).abs();
    }
    let to_edge = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let t = ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        p.distance(from + t * along)
    };
    edges.map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_nearest_point() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let to = |x: f64, y: f64, z: f64| distance_to(DVec3::new(x, y, z), &corners, 10.0);
        assert_eq!(to(0.2, 0.3, 0.5), 0.5);
        assert_eq!(to(0.2, -0.3, 0.4), 0.5);
        assert_eq!(to(-0.3, -0.4, 0.0), 0.5);
        assert!((to(1.0, 1.0, 0.0) - 0.5f64.sqrt()).abs() < 1e-15);
        assert_eq!(distance_to(DVec3::new(0.2, 0.3, 0.5), &corners, 0.4), f64::INFINITY);
    }

    #[test]
    fn a_light_in_a_corner_is_in_front_of_all_its_walls() {
        for normals in [
            vec![DVec3::X],
            vec![DVec3::X, DVec3::X, DVec3::Y],
            vec![DVec3::X, DVec3::Y, DVec3::Z, DVec3::Z],
            // A wedge of ten degrees.
            vec![DVec3::Y, DVec3::new(10f64.to_radians().sin(), -10f64.to_radians().cos(), 0.0)],
        ] {
            let touched: Vec<(usize, Plane)> =
                normals.iter().map(|&normal| (DVec3::ZERO, normal)).enumerate().collect();
            let (place, fronts) = in_front_of(DVec3::ZERO, &touched, 1.0);
            assert_eq!(fronts.len(), normals.len());
            assert!(
                normals.iter().all(|normal| normal.dot(place) >= 1.0) && place.length() < 30.0,
                "{place}"
            );
        }
    }

    #[test]
    fn between_sheets_back_to_back_the_first_decides() {
        let touched = [(4, (DVec3::ZERO, DVec3::Z)), (7, (DVec3::ZERO, DVec3::NEG_Z))];
        let (place, fronts) = in_front_of(DVec3::ZERO, &touched, 1.0);
        assert_eq!((place, fronts), (DVec3::new(0.0, 0.0, 1.5), vec![4]));
    }
}
