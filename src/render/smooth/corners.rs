//! Corners: where patches meet, of all that are cut alike or otherwise.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::patches::{Barycentrics, Basis, Patches, Slot};
use crate::scene::{FaceState, Side, triangle};
use crate::trace::Tracer;

/// Corners are the same point if nearer than this share of their patch's shortest leg ...
const SAME_OF_LEG: f64 = 1e-3;

/// ... and nearer than this, normalised lengths.
const SAME: f64 = 1e-6;

/// A corner of one patch, or a place on the patch's edge that is a corner of others.
#[derive(Clone, Copy)]
pub struct Corner {
    pub patch: u32,
    /// Which of its corners; none for a place on its edge.
    pub number: Option<u8>,
    /// The place within the patch: weights of its second and third corner.
    pub within: Barycentrics,
    pub position: DVec3,
    pub normal: DVec3,
    /// Corners of different surfaces are never mixed: material, and whether it emits.
    pub surface: u32,
    /// Angle of the patch at this place, radians.
    pub angle: f64,
    /// Farther away than this is another point.
    pub same: f64,
}

impl Corner {
    /// What the patch's own field is here, in channel `c`.
    pub fn value(&self, basis: Basis, field: &DMatrix<f64>, c: usize) -> f64 {
        let patch = self.patch as usize;
        match basis {
            Basis::Constant => field[(patch, c)],
            Basis::Linear => {
                let at = |k: usize| field[(3 * patch + k, c)];
                let [u, v, w] = triangle::weights(self.within);
                at(0) * u + at(1) * v + at(2) * w
            }
        }
    }
}

/// The corners of all patches, and the places on their edges that are corners of others.
pub fn corners(tracer: &Tracer, patches: &Patches) -> Vec<Corner> {
    let mut corners: Vec<Corner> =
        (0..patches.len()).into_par_iter().flat_map_iter(|i| corners_of(tracer, patches, i)).collect();
    corners.extend(corners_on_edges(tracer, patches));
    corners.extend((0..patches.len()).flat_map(|i| places_beside(tracer, patches, i)));
    corners
}

fn corners_of(tracer: &Tracer, patches: &Patches, patch: usize) -> [Corner; 3] {
    let Slot { face, side, .. } = patches.place(patch);
    let on_face = patches.corners(patch);
    let at = on_face.map(|corner| triangle::point(tracer.corners(face), corner));
    let leg = |k: usize| at[(k + 1) % 3] - at[k];
    let shortest = leg(0).length().min(leg(1).length()).min(leg(2).length());
    [0, 1, 2].map(|k| Corner {
        patch: patch as u32,
        number: Some(k as u8),
        within: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][k],
        position: at[k],
        normal: shading_normal(tracer, face, side, on_face[k]),
        surface: surface(tracer, face, side),
        angle: leg(k).angle_between(-leg((k + 2) % 3)).max(1e-9),
        same: SAME.min(SAME_OF_LEG * shortest),
    })
}

/// Where a patch's corners lie on the rim of patches of the same face that are cut otherwise: those patches.
fn places_beside<'a>(
    tracer: &'a Tracer,
    patches: &'a Patches,
    patch: usize,
) -> impl Iterator<Item = Corner> + 'a {
    let Slot { face, side, .. } = patches.place(patch);
    let several = patches.pieces(face) > 1;
    let corners = several.then(|| corners_of(tracer, patches, patch).into_iter().zip(patches.corners(patch)));
    corners.into_iter().flatten().flat_map(move |(corner, point)| {
        patches.patches_meeting(face, side, point).into_iter().filter(move |&other| other != patch).map(
            move |other| {
                let within = patches.weights_in(patches.slot_of_patch(other), point);
                Corner { patch: other as u32, number: None, within, angle: PI, ..corner }
            },
        )
    })
}

/// A number for what the side of a face is made of.
fn surface(tracer: &Tracer, face: usize, side: Side) -> u32 {
    let emits = side == Side::Front && tracer.scene().material_of(face).emits();
    2 * tracer.scene().faces()[face].material + u32::from(emits)
}

/// The ends of an edge, the same for every face that has it: the bits of their coordinates, in ascending
/// order.
type Edge = [[u64; 3]; 2];

/// A face's edge `k`, from corner k to the next.
fn edge_of(tracer: &Tracer, face: usize, k: usize) -> Edge {
    let corners = tracer.corners(face);
    // Adding zero makes -0.0 and 0.0 the same place.
    let mut ends = [k, (k + 1) % 3].map(|k| (corners[k] + DVec3::ZERO).to_array().map(f64::to_bits));
    ends.sort_unstable();
    ends
}

/// Where corners of patches lie within an edge of their face: the patches of the other faces with that edge.
fn corners_on_edges(tracer: &Tracer, patches: &Patches) -> Vec<Corner> {
    // Collect the places, by edge.
    let mut places: HashMap<Edge, Vec<(usize, DVec3, f64)>> = HashMap::new();
    let faces = tracer.scene().faces().len();
    let cut = |&face: &usize| Side::BOTH.iter().any(|&side| patches.patches_of(face, side).len() > 1);
    for face in (0..faces).filter(cut) {
        for patch in Side::BOTH.into_iter().flat_map(|side| patches.patches_of(face, side)) {
            for (corner, at) in corners_of(tracer, patches, patch).into_iter().zip(patches.corners(patch)) {
                let weights = triangle::weights(at).map(|w| w > 1e-9);
                // Edge k faces corner k + 2.
                if let Some(k) = (0..3).find(|&k| weights[k] && weights[(k + 1) % 3] && !weights[(k + 2) % 3])
                {
                    let place = (face, corner.position, corner.same);
                    places.entry(edge_of(tracer, face, k)).or_default().push(place);
                }
            }
        }
    }
    if places.is_empty() {
        return Vec::new();
    }
    // Find the other faces' patches there.
    let kept = (0..faces).filter(|&face| tracer.scene().faces()[face].state == FaceState::Kept);
    let edges = kept.flat_map(|face| [0, 1, 2].map(|k| (face, k)));
    let met = edges.filter_map(|(face, k)| Some((face, k, places.get(&edge_of(tracer, face, k))?)));
    met.flat_map(|(face, k, places)| {
        let others = places.iter().filter(move |place| place.0 != face);
        others.flat_map(move |&(_, position, same)| {
            on_edge(tracer, patches, EdgePlace { face, edge: k, position, same })
        })
    })
    .collect()
}

/// A place on an edge of a face.
struct EdgePlace {
    face: usize,
    /// From 0; edge k leads from corner k to the next.
    edge: usize,
    position: DVec3,
    same: f64,
}

/// The patches, front and back, at a place on a face's edge.
fn on_edge<'a>(
    tracer: &'a Tracer,
    patches: &'a Patches,
    EdgePlace { face, edge: k, position, same }: EdgePlace,
) -> impl Iterator<Item = Corner> + 'a {
    let corners = tracer.corners(face);
    let [start, end] = [corners[k], corners[(k + 1) % 3]];
    let along = (position - start).dot(end - start) / (end - start).length_squared();
    let mut weights = [0.0; 3];
    weights[k] = 1.0 - along;
    weights[(k + 1) % 3] = along;
    let point = [weights[1], weights[2]];
    Side::BOTH.into_iter().filter_map(move |side| {
        let patch = patches.patch_at(face, side, point)?;
        let within = patches.weights_in(patches.slot_of_patch(patch), point);
        Some(Corner {
            patch: patch as u32,
            number: None,
            within,
            position,
            normal: shading_normal(tracer, face, side, point),
            surface: surface(tracer, face, side),
            angle: PI,
            same,
        })
    })
}

/// The interpolated `vn` of a face's side where it has them and they make sense, else the facet's normal.
fn shading_normal(tracer: &Tracer, face: usize, side: Side, at: Barycentrics) -> DVec3 {
    let flat = tracer.normal(face, Side::Front);
    let scene = tracer.scene();
    let given = scene.faces()[face].normals.map(|n| n.map(|n| scene.normals()[n as usize]));
    let [u, v, w] = triangle::weights(at);
    let shading = given.map_or(flat, |[a, b, c]| (a * u + b * v + c * w).normalize_or_zero());
    let normal = if shading.dot(flat) > 0.0 { shading } else { flat };
    if side == Side::Back { -normal } else { normal }
}
