//! Facing: which sides of faces can see anything, and which can see each other, by the heights of corners
//! over planes.
//!
//! A side sees only what lies in front of its plane. Where nothing does, it provably sees nothing, without a
//! ray; any other side may see something, however few rays find it.

use glam::DVec3;
use rayon::prelude::*;

use crate::scene::{FaceState, Scene, Side, triangle};
use crate::trace::{Frame, IN_PLANE, Tracer};

/// Corners that share a box.
const CORNERS: usize = 48;

/// Pairs of sides that are tried before two groups are held to face each other.
const MOST_PAIRS: usize = 1 << 20;

/// A side of a face, by its number.
pub(crate) type FaceSide = (usize, Side);

/// Per face, for front and back: whether it takes part, is diffuse and may see anything. What may not
/// provably sees nothing: no corner of any face lies in front of it.
pub fn seeing_sides(tracer: &Tracer) -> Vec<[bool; 2]> {
    let scene = tracer.scene();
    let facing = Facing::new(scene, tracer.frame());
    let sees = |face: usize| Side::BOTH.map(|side| scene.is_diffuse(face) && facing.may_see((face, side)));
    (0..scene.faces().len()).into_par_iter().map(sees).collect()
}

/// An axis-aligned box around points.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extent {
    low: DVec3,
    high: DVec3,
}

impl Extent {
    fn around(points: impl Iterator<Item = DVec3>) -> Self {
        let nothing = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        points.fold(nothing, |all, p| Self { low: all.low.min(p), high: all.high.max(p) })
    }

    /// Whether its highest corner rises over a plane.
    fn rises_over(&self, plane: &Plane) -> bool {
        self.low.x <= self.high.x
            && plane.is_under(DVec3::select(plane.normal.cmpgt(DVec3::ZERO), self.high, self.low))
    }
}

/// The plane of a side, its normal towards what the side sees.
struct Plane {
    point: DVec3,
    normal: DVec3,
}

impl Plane {
    fn is_under(&self, point: DVec3) -> bool {
        self.normal.dot(point - self.point) > IN_PLANE
    }
}

/// Where the faces of a scene lie, normalised frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Facing {
    faces: Vec<[DVec3; 3]>,
    /// The corners of all faces that take part, and a box around each few.
    corners: Vec<DVec3>,
    boxes: Vec<Extent>,
    /// Whether mirrors, glass or coats may lead light from a side to what does not face it.
    is_led_around: bool,
}

/// Sides of faces, and a box around them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Members {
    sides: Vec<FaceSide>,
    extent: Extent,
}

impl Facing {
    pub fn new(scene: &Scene, frame: &Frame) -> Self {
        let number = scene.faces().len();
        let faces: Vec<[DVec3; 3]> =
            (0..number).map(|face| scene.corners(face).map(|p| frame.from_world(p))).collect();
        let kept = (0..number).filter(|&face| scene.faces()[face].state == FaceState::Kept);
        let corners: Vec<DVec3> = kept.flat_map(|face| faces[face]).collect();
        let boxes = corners.chunks(CORNERS).map(|few| Extent::around(few.iter().copied())).collect();
        let is_led_around = (0..number).any(|face| scene.passes_on(face));
        Self { faces, corners, boxes, is_led_around }
    }

    /// These sides as a group.
    pub fn members(&self, sides: Vec<FaceSide>) -> Members {
        let extent = Extent::around(sides.iter().flat_map(|&(face, _)| self.faces[face]));
        Members { sides, extent }
    }

    /// Whether a side may see anything: some corner of another face lies in front of it.
    fn may_see(&self, side: FaceSide) -> bool {
        let plane = self.plane(side);
        let chunks = self.boxes.iter().zip(self.corners.chunks(CORNERS));
        chunks
            .filter(|(extent, _)| extent.rises_over(&plane))
            .any(|(_, few)| few.iter().any(|&p| plane.is_under(p)))
    }

    /// Whether some side of a group may send light to one of another. That they may not is proven; that they
    /// may is only not disproven.
    pub fn may_exchange(&self, here: &Members, there: &Members) -> bool {
        if self.is_led_around {
            return true;
        }
        let mut tried = 0;
        for &one in &here.sides {
            let plane = self.plane(one);
            if !there.extent.rises_over(&plane) {
                continue;
            }
            for &other in &there.sides {
                tried += 1;
                let seen = self.faces[other.0].iter().any(|&p| plane.is_under(p));
                let back = self.plane(other);
                if tried > MOST_PAIRS || seen && self.faces[one.0].iter().any(|&p| back.is_under(p)) {
                    return true;
                }
            }
        }
        false
    }

    fn plane(&self, (face, side): FaceSide) -> Plane {
        let corners = &self.faces[face];
        let normal = triangle::normal(corners);
        Plane { point: corners[0], normal: if side == Side::Front { normal } else { -normal } }
    }
}
