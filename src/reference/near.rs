//! Near: the faces right beside a light with a place. What it sends there falls on a spot so small that paths
//! from where light is wanted hardly ever find it; photons bring it.

use crate::scene::{FaceState, Light, distance_to};
use crate::trace::Tracer;

/// Faces at most as far as this from a light are near it, normalised lengths.
const NEAR: f64 = 1e-4;

/// The faces near a light that scatter diffusely, ascending.
pub(super) fn near_faces(tracer: &Tracer, light: &Light) -> Vec<u32> {
    let Some(position) = light.position().map(|position| tracer.frame().from_world(position)) else {
        return Vec::new();
    };
    let is_near = |&face: &u32| {
        tracer.scene().faces()[face as usize].state == FaceState::Kept
            && !tracer.is_carrier(face)
            && distance_to(position, tracer.corners(face as usize), NEAR) <= NEAR
    };
    (0..tracer.scene().faces().len() as u32).filter(is_near).collect()
}
