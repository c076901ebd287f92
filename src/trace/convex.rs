//! Convex: whether a scene is empty and convex seen from inside, so that everything in front of a face is
//! seen from it.
//!
//! If all corners lie in front of the plane of every face, all faces lie on the hull of them, and no straight
//! line between two fronts meets a third face. From a point inside the faces then fill no more than the whole
//! sphere of directions, and all of it where they leave no gap; faces that overlap would be counted twice and
//! rule it out.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::Tracer;
use super::solid_angle::solid_angle;
use crate::scene::{FaceState, Side};

/// How far behind a plane a corner may lie for rounding, in normalised lengths.
const FLAT: f64 = 1e-9;

/// With more faces than this it is not looked into.
const MOST_FACES: usize = 10_000;

/// How faces surround the empty inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enclosure {
    /// On all sides.
    Closed,
    /// With gaps.
    Open,
}

/// What speaks against it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotConvex {
    /// Light is bent on its way, or not sent out by the cosine.
    #[error("mirrors, metal, glass or plastic are in the scene")]
    Carriers,
    /// A corner is behind a face.
    #[error("face {behind} is not in front of face {face}")]
    Behind {
        /// The face.
        face: usize,
        /// The face with a corner behind its plane.
        behind: usize,
    },
    /// Two faces overlap in their plane.
    #[error("faces overlap")]
    Overlap,
    /// It was not looked into.
    #[error("more than {MOST_FACES} faces")]
    Faces,
}

impl Tracer<'_> {
    /// Whether the scene is empty and convex seen from the fronts of its faces, and how they surround it.
    ///
    /// # Errors
    /// What speaks against it.
    pub fn enclosure(&self) -> Result<Enclosure, NotConvex> {
        if self.has_carriers() {
            return Err(NotConvex::Carriers);
        }
        let faces: Vec<usize> =
            (0..self.corners.len()).filter(|&f| self.scene.faces()[f].state == FaceState::Kept).collect();
        if faces.len() > MOST_FACES {
            return Err(NotConvex::Faces);
        }
        let behind = |&face: &usize| {
            let (normal, p) = (self.normal(face, Side::Front), self.corners[face][0]);
            let is_behind =
                |&&other: &&usize| self.corners[other].iter().any(|corner| normal.dot(corner - p) < -FLAT);
            faces.iter().find(is_behind).map(|&behind| NotConvex::Behind { face, behind })
        };
        if let Some(found) = faces.par_iter().find_map_first(behind) {
            return Err(found);
        }
        if !self.overlaps().is_empty() {
            return Err(NotConvex::Overlap);
        }
        // Look from the middle of all faces, which is inside unless all of them lie in one plane.
        let middles = faces.iter().map(|&f| self.corners[f].iter().sum::<DVec3>() / 3.0);
        let middle = middles.sum::<DVec3>() / faces.len() as f64;
        let filled: f64 = faces.iter().map(|&f| solid_angle(middle, &self.corners[f])).sum();
        if (filled / (4.0 * PI) - 1.0).abs() < 1e-9 {
            return Ok(Enclosure::Closed);
        }
        Ok(Enclosure::Open)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn enclosure(name: &str) -> Result<Enclosure, NotConvex> {
        let scene = Scene::load(format!("{}/meshes/{name}.obj", env!("CARGO_MANIFEST_DIR"))).unwrap();
        Tracer::new(&scene).enclosure()
    }

    #[test]
    fn rooms_with_something_in_them_are_not_empty() {
        assert_eq!(enclosure("furnace_cube"), Ok(Enclosure::Closed));
        assert_eq!(enclosure("furnace_sphere"), Ok(Enclosure::Closed));
        assert_eq!(enclosure("facing_plates"), Ok(Enclosure::Open));
        assert_eq!(enclosure("mirror_room"), Err(NotConvex::Carriers));
        for name in ["cornell_box", "two_rooms", "furnished_room", "spot_gallery", "daylit_room"] {
            assert!(matches!(enclosure(name), Err(NotConvex::Behind { .. })), "{name}");
        }
    }
}
