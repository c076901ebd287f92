//! Outlines: the edges of patches as thin dark lines.

use glam::DVec2;

use super::lens::Lens;
use crate::patches::Patches;
use crate::scene::triangle;
use crate::trace::Tracer;

/// How much darker the middle of a line is.
const DARKNESS: f64 = 0.6;

/// The factor by which the edges of `patch`, which is seen there, dim a point of the picture.
pub(super) fn dimming(tracer: &Tracer, patches: &Patches, lens: &Lens, point: DVec2, patch: usize) -> f64 {
    let face = tracer.corners(patches.place(patch).face);
    let corners = patches.corners(patch).map(|corner| triangle::point(face, corner));
    let distances = [0, 1, 2].map(|k| lens.distance_to_line(point, corners[k], corners[(k + 1) % 3]));
    // Half of a line of one pixel lies on this side of the edge; lines of tiny patches would leave nothing
    // else.
    let covered = (1.0 - distances.into_iter().fold(f64::INFINITY, f64::min)).clamp(0.0, 1.0);
    let height: f64 = distances.iter().sum();
    1.0 - DARKNESS * covered * ((height - 2.0) / 8.0).clamp(0.0, 1.0)
}
