//! Planes: those in which opaque faces lie, and those in which two free edges meet, as around a missing roof;
//! the largest first.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::scene::{FaceState, Surface, triangle};
use crate::trace::Tracer;

/// Planes are one whose normals have coordinates that are equal when rounded to this; a pure number.
const SLOPE: f64 = 1e-5;

/// A step between planes is at least this high, normalised lengths.
pub const STEP: f64 = 1e-6;

/// Planes times faces that are looked at; a number. Chosen, not fitted: some tenth of a second.
const MOST_LOOKS: usize = 1 << 24;

/// The fewest and most planes; numbers. Chosen, not fitted.
const PLANES: [usize; 2] = [16, 256];

/// A plane.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// A unit normal, either way.
    pub normal: DVec3,
    /// Of all its points along the normal, normalised.
    pub height: f64,
    /// How much of the scene lies in it: area of faces, or of triangles between free edges, normalised.
    area: f64,
}

impl Plane {
    /// The plane of a triangle; none where that has no area.
    fn through(corners: &[DVec3; 3]) -> Option<Self> {
        let normal = triangle::normal(corners);
        if normal == DVec3::ZERO {
            return None;
        }
        let normal = if normal[normal.abs().max_position()] < 0.0 { -normal } else { normal };
        let height = normal.dot(corners[0] + corners[1] + corners[2]) / 3.0;
        Some(Self { normal, height, area: triangle::area(corners) })
    }

    fn slope(&self) -> [i32; 3] {
        self.normal.to_array().map(|x| (x / SLOPE).round() as i32)
    }
}

/// The planes in which most lies.
pub fn planes(tracer: &Tracer) -> Vec<Plane> {
    let scene = tracer.scene();
    let is_opaque = |&f: &usize| {
        scene.faces()[f].state == FaceState::Kept
            && !matches!(scene.material_of(f).surface, Surface::Pane { .. })
    };
    let faces = (0..scene.faces().len()).filter(is_opaque);
    let mut all: Vec<Plane> = faces.filter_map(|f| Plane::through(tracer.corners(f))).collect();
    all.extend(rims(tracer));
    all.sort_by(|a, b| a.slope().cmp(&b.slope()).then(a.height.total_cmp(&b.height)));
    let runs = all.chunk_by(|a, b| a.slope() == b.slope() && b.height - a.height < STEP);
    let merged = |run: &[Plane]| {
        let largest = run.iter().fold(&run[0], |most, part| if part.area > most.area { part } else { most });
        Plane { area: run.iter().map(|part| part.area).sum(), ..*largest }
    };
    let mut planes: Vec<Plane> = runs.map(merged).collect();
    planes.sort_by(|a, b| b.area.total_cmp(&a.area));
    let [fewest, most] = PLANES;
    planes.truncate((MOST_LOOKS / scene.faces().len().max(1)).clamp(fewest, most));
    planes
}

/// The most faces of a scene whose free edges are looked for; a number. Chosen, not fitted: a tenth of a
/// second. Of larger scenes the planes of faces have to do.
const MOST_FACES: usize = 1 << 16;

/// The planes of each two free edges that meet: edges of one face alone.
fn rims(tracer: &Tracer) -> Vec<Plane> {
    let scene = tracer.scene();
    if scene.faces().len() > MOST_FACES {
        return Vec::new();
    }
    let bits = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
    // Sorted, so that the same scene has the same planes.
    let mut count: BTreeMap<[[u64; 3]; 2], (u32, [DVec3; 2])> = BTreeMap::new();
    for face in (0..scene.faces().len()).filter(|&f| scene.faces()[f].state == FaceState::Kept) {
        let corners = tracer.corners(face);
        for ends in [[0, 1], [1, 2], [2, 0]].map(|ends| ends.map(|k| corners[k])) {
            let mut key = ends.map(bits);
            key.sort_unstable();
            count.entry(key).or_insert((0, ends)).0 += 1;
        }
    }
    let mut ends: BTreeMap<[u64; 3], Vec<DVec3>> = BTreeMap::new();
    for (_, [from, to]) in count.into_values().filter(|&(count, _)| count == 1) {
        ends.entry(bits(from)).or_default().push(to);
        ends.entry(bits(to)).or_default().push(from);
    }
    let mut planes = Vec::new();
    for (at, others) in ends.into_iter().filter(|(_, others)| others.len() == 2) {
        planes.extend(Plane::through(&[DVec3::from(at.map(f64::from_bits)), others[0], others[1]]));
    }
    planes
}
