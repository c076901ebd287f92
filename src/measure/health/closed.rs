//! Closed surfaces: opaque faces connected by edges each of which exactly two of them share. No light leaves one from inside.
//!
//! A point is inside where the winding number w = Σ Ω_f / 4π of the surface around it is not 0, with Ω_f the signed solid angle of face f. It is
//! constant on any path that does not cross the surface, and 0 far away.

use std::f64::consts::PI;

use glam::DVec3;

use super::edges::Edges;
use crate::scene::{Scene, Side, Surface};
use crate::trace::Tracer;

/// One closed surface, its faces turned so that all fronts agree.
struct Closed {
    /// Corners (metres) and numbers of faces, and whether a face had to be turned.
    faces: Vec<(usize, [DVec3; 3], bool)>,
    /// The box around it.
    low: DVec3,
    high: DVec3,
}

/// The closed surfaces of a scene.
pub(in crate::measure) struct ClosedSurfaces(Vec<Closed>);

impl ClosedSurfaces {
    /// Finds them by their edges; surfaces that let light through, or have no two sides, are left out.
    pub fn of(tracer: &Tracer) -> Self {
        let scene = tracer.scene();
        let edges = Edges::new(tracer);
        let mut is_closed: Vec<bool> = (0..scene.faces().len()).map(|face| is_opaque(scene, face)).collect();
        edges.unpaired().for_each(|face| is_closed[face] = false);
        let surfaces = edges.oriented().into_iter();
        let closed = surfaces.filter(|(faces, agree)| *agree && faces.iter().all(|&(f, _)| is_closed[f]));
        Self(closed.map(|(faces, _)| Closed::new(scene, &faces)).collect())
    }

    /// Number of faces of all of them.
    pub fn faces(&self) -> usize {
        self.0.iter().map(|surface| surface.faces.len()).sum()
    }

    /// Whether light that leaves a point (metres) on a side of a face is inside one of them.
    pub fn enclose(&self, point: DVec3, face: usize, side: Side) -> bool {
        self.0.iter().any(|surface| surface.winding(point, face, side).abs() > 0.5)
    }
}

impl Closed {
    fn new(scene: &Scene, faces: &[(usize, bool)]) -> Self {
        let faces: Vec<_> = faces.iter().map(|&(face, turned)| (face, scene.corners(face), turned)).collect();
        let corners = || faces.iter().flat_map(|(_, corners, _)| corners);
        let low = corners().fold(DVec3::INFINITY, |low, corner| low.min(*corner));
        let high = corners().fold(DVec3::NEG_INFINITY, |high, corner| high.max(*corner));
        Self { faces, low, high }
    }

    /// The winding number around a point; for a point on the surface, that on the given side of its face.
    fn winding(&self, point: DVec3, face: usize, side: Side) -> f64 {
        if point.cmplt(self.low).any() || point.cmpgt(self.high).any() {
            return 0.0;
        }
        let mut own = 0.0;
        let mut sum = 0.0;
        for &(f, corners, turned) in &self.faces {
            let sign = if turned { -1.0 } else { 1.0 };
            if f == face {
                // The mean over both sides is what the other faces add up to; the side behind the surface has half a turn more.
                own = if (side == Side::Back) != turned { 0.5 } else { -0.5 };
            } else {
                sum += sign * solid_angle(point, corners);
            }
        }
        sum / (4.0 * PI) + own
    }
}

/// The solid angle of a triangle seen from a point, positive where its back faces the point (Van Oosterom & Strackee 1983).
fn solid_angle(point: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let [la, lb, lc] = [a.length(), b.length(), c.length()];
    let volume = a.dot(b.cross(c));
    2.0 * volume.atan2(la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la)
}

fn is_opaque(scene: &Scene, face: usize) -> bool {
    !matches!(scene.material_of(face).surface, Surface::Dielectric { .. } | Surface::Pane { .. })
}
