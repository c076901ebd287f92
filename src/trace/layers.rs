//! Layers: the order of faces that lie on each other in one plane.
//!
//! Two faces coincide where they overlap in a plane and rounding alone would decide which of them a ray
//! meets. Each then gets its place in the order of that plane, known from geometry and numbers:
//!
//! - Of faces whose fronts point the same way, the one of the smaller coplanar surface is on top, as a rug on
//!   a floor or a luminaire on a ceiling; of equally large surfaces the first in file order.
//! - Faces whose fronts point in opposite directions lie back to back: only their outer sides act.
//! - A face that transmits light (glass, thin glass, translucent sheets) covers no opaque face, and an opaque
//!   one covers both of its sides. Of two that transmit light, the one that is on top covers both sides of
//!   the other.
//!
//! What is covered is met by no ray, sends out none, and belongs to no patch.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use rayon::prelude::*;

use super::{Hit, Tracer};
use crate::scene::{Scene, Side, Surface, triangle};

/// How far out of a plane a corner may lie by rounding: files often keep six digits. Normalised lengths.
const FLAT: f64 = 1e-6;

/// The largest slope between two faces of one plane.
const SLOPE: f64 = 1e-3;

/// Surfaces whose distance is at least this everywhere, on one side, are apart: geometry says which is on
/// top. Normalised lengths.
const GAP: f64 = 1e-12;

/// An overlap narrower than this share of the thinner face is rounding at a common edge...
const NARROW_SHARE: f64 = 1e-3;

/// ...but none is that is wider than the first, and all are that are narrower than the second. Normalised
/// lengths.
const NARROW: [f64; 2] = [1e-6, 1e-9];

/// Surfaces whose areas differ by less than this share are equally large.
const SAME_AREA: f64 = 1e-9;

/// Faces are of one surface where the cosine between their normals is less than this below 1.
const SAME_PLANE: f64 = 1e-9;

/// How far outside its border a point still counts as on a face, as a weight.
const RIM: f64 = 1e-12;

/// By how much boxes are widened before they are rounded to f32, normalised lengths.
const PAD: f64 = 4.0 * FLAT;

/// The most covers that are looked through at one point; the order of a plane has no circles, so that this
/// only guards against damage.
const MOST_LAYERS: usize = 64;

/// The most pairs of coinciding faces, first for the scene and then as many more for each face: thousands of
/// faces of which every one covers every other are no scene, and the square of their number fills the memory.
const MOST_PAIRS: [usize; 2] = [1 << 16, 8];

/// Two faces that coincide somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// The face on top, and the one that it covers.
    pub faces: [u32; 2],
    /// Area of the overlap, m².
    pub area: f64,
    /// How the two faces lie on each other.
    pub kind: OverlapKind,
}

/// How two coinciding faces lie on each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OverlapKind {
    /// Their fronts point the same way.
    SameFront,
    /// Their fronts point in opposite directions.
    BackToBack,
}

/// A face among others in its plane.
#[derive(Clone, Debug, Default)]
struct Layer {
    /// The faces that coincide with it somewhere, ascending.
    twins: Vec<u32>,
    /// The faces that cover its front and its back somewhere, outermost first.
    covers: [Vec<u32>; 2],
}

/// The order of all coinciding faces of a scene.
#[derive(Debug, Default)]
pub(super) struct Layers {
    /// Per face its place in `layers`, or [`NONE`]; empty where no faces coincide.
    layer_of_face: Vec<u32>,
    layers: Vec<Layer>,
    overlaps: Vec<Overlap>,
    /// A face that coincides with too many others, if the order of all was given up.
    too_many: Option<u32>,
}

const NONE: u32 = u32::MAX;

impl Layers {
    /// Finds the coinciding faces among those `kept`, with corners and unit normals in the normalised frame;
    /// `area_unit` is its unit of area in m².
    pub fn new(
        scene: &Scene,
        (corners, normals): (&[[DVec3; 3]], &[DVec3]),
        kept: &[u32],
        area_unit: f64,
    ) -> Self {
        let touching = match touching_pairs(corners, normals, kept) {
            Ok(touching) if touching.is_empty() => return Self::default(),
            Ok(touching) => touching,
            Err(face) => return Self { too_many: Some(face), ..Self::default() },
        };
        let surfaces = Surfaces::new(corners, normals, kept);
        let pairs = surfaces.coinciding(touching, normals);
        let ranks: Vec<Rank> =
            (0..corners.len()).map(|face| surfaces.rank(face as u32, transmits(scene, face))).collect();
        let mut layers = Self { layer_of_face: vec![NONE; corners.len()], ..Self::default() };
        for pair in &pairs {
            layers.add(pair, normals, &ranks, area_unit);
        }
        for (face, &layer) in layers.layer_of_face.iter().enumerate().filter(|&(_, &layer)| layer != NONE) {
            let layer = &mut layers.layers[layer as usize];
            layer.twins.sort_unstable();
            for (side, covers) in Side::BOTH.into_iter().zip(&mut layer.covers) {
                let outwards = if side == Side::Front { normals[face] } else { -normals[face] };
                let depth = |cover: u32| ranks[cover as usize].depth(normals[cover as usize].dot(outwards));
                covers.sort_by_key(|&cover| depth(cover));
            }
        }
        layers
    }

    /// Enters what a pair of faces says of either.
    fn add(&mut self, pair: &Touching, normals: &[DVec3], ranks: &[Rank], area_unit: f64) {
        let [f, g] = pair.faces;
        let same_front = normals[f as usize].dot(normals[g as usize]) > 0.0;
        for (upper, lower) in [(f, g), (g, f)] {
            let covered = ranks[upper as usize].covers(&ranks[lower as usize], same_front);
            let layer = self.layer_mut(lower);
            layer.twins.push(upper);
            for (covers, covered) in layer.covers.iter_mut().zip(covered) {
                if covered {
                    covers.push(upper);
                }
            }
        }
        let faces = if ranks[f as usize] < ranks[g as usize] { [f, g] } else { [g, f] };
        let kind = if same_front { OverlapKind::SameFront } else { OverlapKind::BackToBack };
        self.overlaps.push(Overlap { faces, area: pair.area * area_unit, kind });
    }

    fn layer_mut(&mut self, face: u32) -> &mut Layer {
        let place = &mut self.layer_of_face[face as usize];
        if *place == NONE {
            *place = self.layers.len() as u32;
            self.layers.push(Layer::default());
        }
        &mut self.layers[*place as usize]
    }

    #[inline]
    fn layer(&self, face: u32) -> Option<&Layer> {
        self.layers.get(*self.layer_of_face.get(face as usize)? as usize)
    }

    /// The faces that coincide with a face somewhere: a ray that starts on it does not meet them.
    #[inline]
    pub fn twins(&self, face: u32) -> &[u32] {
        self.layer(face).map_or(&[], |layer| &layer.twins)
    }

    /// Whether no faces coincide.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.layers.is_empty()
    }
}

impl Tracer<'_> {
    /// The pairs of faces that coincide somewhere.
    pub fn overlaps(&self) -> &[Overlap] {
        &self.layers.overlaps
    }

    /// A face of those that coincide with so many others that no order was worked out; such a scene can't be
    /// cut into patches.
    pub fn face_of_too_many_overlaps(&self) -> Option<usize> {
        self.layers.too_many.map(|face| face as usize)
    }

    /// The faces that cover a face's side somewhere, outermost first.
    pub fn covers(&self, face: usize, side: Side) -> &[u32] {
        self.layers.layer(face as u32).map_or(&[], |layer| &layer.covers[side as usize])
    }

    /// The edges of the faces that cover some of a face, normalised frame, less those between faces that
    /// cover the same sides of it.
    pub fn outlines_of_covers(&self, face: usize) -> Vec<[DVec3; 2]> {
        let covers = Side::BOTH.map(|side| self.covers(face, side));
        let mut all: Vec<u32> = covers.concat();
        all.sort_unstable();
        all.dedup();
        let mut edges = Vec::with_capacity(3 * all.len());
        for cover in all {
            let sides = covers.map(|covers| covers.contains(&cover));
            let turned = self.normals[cover as usize].dot(self.normals[face]) < 0.0;
            let [a, b, c] = self.corners[cover as usize];
            edges.extend([[a, b], [b, c], [c, a]].map(|ends| {
                let (key, reversed) = edge_key(ends);
                (key, sides, reversed != turned, ends)
            }));
        }
        edges.sort_unstable_by_key(|&(key, sides, reversed, _)| (key, sides, reversed));
        // Between neighbours an edge is there twice, once in either direction.
        let mut outlines = Vec::with_capacity(edges.len());
        for same in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let is_between = matches!(same, [(.., first, _), (.., second, _)] if first != second);
            outlines.extend(same.first().filter(|_| !is_between).map(|edge| edge.3));
        }
        outlines
    }

    /// Whether another face covers a face's side at a point of it (normalised frame).
    #[inline]
    pub fn is_covered(&self, face: u32, side: Side, point: DVec3) -> bool {
        let Some(layer) = self.layers.layer(face) else { return false };
        layer.covers[side as usize].iter().any(|&cover| self.weights_on(cover, point).is_some())
    }

    /// The hit on top where `hit` met one of several coinciding faces.
    pub(super) fn hit_on_top(&self, mut hit: Hit) -> Hit {
        for _ in 0..MOST_LAYERS {
            let Some(layer) = self.layers.layer(hit.face) else { return hit };
            let point = self.point(&hit);
            let mut covers = layer.covers[hit.side as usize].iter();
            let on_top = covers.find_map(|&cover| Some((cover, self.weights_on(cover, point)?)));
            let Some((face, barycentrics)) = on_top else { return hit };
            let same_front = self.normals[face as usize].dot(self.normals[hit.face as usize]) > 0.0;
            let side = if same_front { hit.side } else { hit.side.other() };
            hit = Hit { face, side, barycentrics, ..hit };
        }
        hit
    }

    /// The barycentric weights of a face's second and third corner at a point of its plane; none outside of
    /// the face.
    #[inline]
    fn weights_on(&self, face: u32, point: DVec3) -> Option<[f64; 2]> {
        let [a, b, c] = self.corners[face as usize];
        let normal = self.normals[face as usize];
        let (ab, ac, ap) = (b - a, c - a, point - a);
        let area = ab.cross(ac).dot(normal);
        let [v, w] = [ap.cross(ac).dot(normal) / area, ab.cross(ap).dot(normal) / area];
        let inside = v >= -RIM && w >= -RIM && v + w <= 1.0 + RIM;
        inside.then(|| {
            let [v, w] = [v.max(0.0), w.max(0.0)];
            let sum = (v + w).max(1.0);
            [v / sum, w / sum]
        })
    }
}

/// Whether some light comes through a face.
fn transmits(scene: &Scene, face: usize) -> bool {
    let material = scene.material_of(face);
    let is_glass = matches!(material.surface, Surface::Dielectric { .. } | Surface::Pane { .. });
    is_glass || material.transmittance().is_some()
}

/// A face's place in the order of its plane: the lowest is on top of all with the same front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Rank {
    transmits: bool,
    /// By area.
    size_of_surface: u32,
    /// The first face of the surface.
    surface: u32,
    face: u32,
}

impl Rank {
    /// Whether a face covers another's front and back.
    fn covers(&self, other: &Self, same_front: bool) -> [bool; 2] {
        match (self.transmits, other.transmits) {
            (true, false) => [false; 2],
            (_, true) => [self < other; 2],
            (false, false) if same_front => [self < other, self > other],
            (false, false) => [false, true],
        }
    }

    /// How deep a face lies among the covers of a side, where `facing` tells whether its front looks out of
    /// that side.
    fn depth(self, facing: f64) -> (bool, bool, Self, std::cmp::Reverse<Self>) {
        // Fronts lie over backs; among fronts the lowest rank is outermost, among backs the highest.
        let neutral = Self { transmits: false, size_of_surface: 0, surface: 0, face: 0 };
        let (front, back) = if facing > 0.0 { (self, neutral) } else { (neutral, self) };
        (self.transmits, facing <= 0.0, front, std::cmp::Reverse(back))
    }
}

/// Two faces that overlap in one plane but for rounding.
#[derive(Clone, Copy)]
struct Touching {
    faces: [u32; 2],
    /// Of the overlap, normalised.
    area: f64,
    /// The lowest and the highest point of the second face over the plane of the first, within the overlap.
    heights: [f64; 2],
}

/// All pairs of faces that overlap in one plane but for rounding; where they are too many, one face of them.
fn touching_pairs(corners: &[[DVec3; 3]], normals: &[DVec3], kept: &[u32]) -> Result<Vec<Touching>, u32> {
    let boxes: Vec<Aabb> = kept.iter().map(|&face| box_around(&corners[face as usize])).collect();
    let tree: Bvh2 = build_bvh2(&boxes, BvhBuildParams::fastest_build(), &mut Default::default());
    let (most, count) = (MOST_PAIRS[0] + MOST_PAIRS[1] * kept.len(), AtomicUsize::new(0));
    let of_face = |k: usize| {
        let face = kept[k];
        let (triangle, normal) = (&corners[face as usize], normals[face as usize]);
        let sides = Sides::new(triangle, normal);
        let mut found = Vec::new();
        tree.aabb_traverse(boxes[k], |tree, node| {
            let node = &tree.nodes[node as usize];
            let (first, count) = (node.first_index as usize, node.prim_count as usize);
            for &other in &tree.primitive_indices[first..first + count] {
                let other = kept[other as usize];
                let second = &corners[other as usize];
                let alike = normal.dot(normals[other as usize]).abs() > 0.9;
                if other > face && alike && !sides.are_before(second) {
                    let overlap = overlap([triangle, second], normal);
                    found.extend(overlap.map(|(area, heights)| Touching {
                        faces: [face, other],
                        area,
                        heights,
                    }));
                }
            }
            found.len() <= most
        });
        let before = count.fetch_add(found.len(), Ordering::Relaxed);
        if before + found.len() > most { Err(face) } else { Ok(found) }
    };
    let found: Vec<Vec<Touching>> = (0..kept.len()).into_par_iter().map(of_face).collect::<Result<_, _>>()?;
    let mut found = found.concat();
    found.sort_unstable_by_key(|pair| pair.faces);
    Ok(found)
}

fn box_around(corners: &[DVec3; 3]) -> Aabb {
    let [a, b, c] = *corners;
    let round = |p: DVec3| Vec3A::from(p.as_vec3());
    Aabb { min: round(a.min(b).min(c) - PAD), max: round(a.max(b).max(c) + PAD) }
}

/// Area of the overlap of two triangles in the plane of the first, and the lowest and highest point of the
/// second over it there; none where they only touch or are not in one plane.
fn overlap([first, second]: [&[DVec3; 3]; 2], normal: DVec3) -> Option<(f64, [f64; 2])> {
    // Clip the second triangle by the edges of the first, in the plane of the first.
    let [a, b, c] = *first;
    let along = (b - a).normalize_or_zero();
    let axes = [along, normal.cross(along), normal];
    let place = |p: DVec3| DVec3::from(axes.map(|axis| (p - a).dot(axis)));
    let clip_by = [a, b, c].map(place);
    let mut polygon: Vec<DVec3> = second.iter().map(|&p| place(p)).collect();
    let thin = thickness(&clip_by).min(thickness(&polygon));
    for k in 0..3 {
        let (from, to) = (clip_by[k].truncate(), clip_by[(k + 1) % 3].truncate());
        let inside = |p: DVec3| (to - from).perp_dot(p.truncate() - from);
        let mut clipped = Vec::with_capacity(polygon.len() + 1);
        for (i, &p) in polygon.iter().enumerate() {
            let q = polygon[(i + 1) % polygon.len()];
            let (here, next) = (inside(p), inside(q));
            if here >= 0.0 {
                clipped.push(p);
            }
            if (here >= 0.0) != (next >= 0.0) {
                clipped.push(p.lerp(q, here / (here - next)));
            }
        }
        polygon = clipped;
        if polygon.len() < 3 {
            return None;
        }
    }
    // Tell overlaps from common edges, and planes from slopes.
    let narrow = (NARROW_SHARE * thin).clamp(NARROW[1], NARROW[0]);
    if thickness(&polygon) <= narrow {
        return None;
    }
    let heights = polygon.iter().map(|p| p.z);
    let heights = [heights.clone().fold(f64::INFINITY, f64::min), heights.fold(f64::NEG_INFINITY, f64::max)];
    let flat = heights[0].abs().max(heights[1].abs()) <= FLAT.min(SLOPE * diameter(&polygon));
    flat.then(|| (area(&polygon), heights))
}

/// The sides of a triangle, in its plane: a point of each, and the unit vector that points inwards.
struct Sides([(DVec3, DVec3); 3]);

impl Sides {
    fn new([a, b, c]: &[DVec3; 3], normal: DVec3) -> Self {
        Self([(a, b), (b, c), (c, a)].map(|(&from, &to)| (from, normal.cross(to - from).normalize_or_zero())))
    }

    /// Whether a triangle lies beyond one of them, but for less than any overlap is wide: most pairs that are
    /// looked at are neighbours.
    fn are_before(&self, triangle: &[DVec3; 3]) -> bool {
        let is_beyond = |(from, inwards): &(DVec3, DVec3)| {
            triangle.iter().all(|&p| (p - *from).dot(*inwards) < NARROW[1])
        };
        self.0.iter().any(is_beyond)
    }
}

/// Area of a polygon in the plane.
fn area(polygon: &[DVec3]) -> f64 {
    let twice = |k: usize| polygon[k].truncate().perp_dot(polygon[(k + 1) % polygon.len()].truncate());
    0.5 * (0..polygon.len()).map(twice).sum::<f64>().abs()
}

/// The longest distance between two corners.
fn diameter(polygon: &[DVec3]) -> f64 {
    let from = |p: &DVec3| polygon.iter().map(|q| p.truncate().distance(q.truncate())).fold(0.0, f64::max);
    polygon.iter().map(from).fold(0.0, f64::max)
}

/// About how wide a polygon is across its longest extent.
fn thickness(polygon: &[DVec3]) -> f64 {
    let longest = diameter(polygon);
    if longest > 0.0 { area(polygon) / longest } else { 0.0 }
}

/// Coplanar faces joined by common edges, with fronts that point the same way.
struct Surfaces {
    /// Per face, the first face of its surface.
    first_face: Vec<u32>,
    /// Per face that is the first of its surface: how large the surface is, as its place by area.
    size: HashMap<u32, u32>,
}

impl Surfaces {
    fn new(corners: &[[DVec3; 3]], normals: &[DVec3], kept: &[u32]) -> Self {
        // Join faces that point the same way and go on from one another at an edge, which neighbours run
        // along in opposite directions.
        let mut edges: Vec<([[u64; 3]; 2], bool, u32)> = Vec::with_capacity(3 * kept.len());
        for &face in kept {
            let [a, b, c] = corners[face as usize];
            edges.extend([[a, b], [b, c], [c, a]].map(|ends| {
                let (key, reversed) = edge_key(ends);
                (key, reversed, face)
            }));
        }
        edges.par_sort_unstable();
        let mut parent: Vec<u32> = (0..corners.len() as u32).collect();
        for beside in edges.chunk_by(|a, b| a.0 == b.0) {
            let (forwards, backwards) = beside.split_at(beside.partition_point(|edge| !edge.1));
            for &(.., face) in forwards {
                let normal = normals[face as usize];
                let alike = |other: u32| normal.dot(normals[other as usize]) > 1.0 - SAME_PLANE;
                for &(.., other) in backwards.iter().filter(|edge| alike(edge.2)) {
                    let roots = [root(&mut parent, face), root(&mut parent, other)];
                    parent[roots[0].max(roots[1]) as usize] = roots[0].min(roots[1]);
                }
            }
        }
        // Rank surfaces by area.
        let first_face: Vec<u32> = (0..corners.len() as u32).map(|face| root(&mut parent, face)).collect();
        let mut areas: HashMap<u32, f64> = HashMap::new();
        for &face in kept {
            *areas.entry(first_face[face as usize]).or_default() += triangle::area(&corners[face as usize]);
        }
        let mut by_area: Vec<(f64, u32)> = areas.into_iter().map(|(surface, area)| (area, surface)).collect();
        by_area.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (mut place, mut last) = (0, 0.0);
        let mut size = HashMap::with_capacity(by_area.len());
        for (area, surface) in by_area {
            if area > last * (1.0 + SAME_AREA) {
                place += 1;
            }
            last = area;
            size.insert(surface, place);
        }
        Self { first_face, size }
    }

    /// The pairs between surfaces of which geometry does not say which is on top.
    fn coinciding(&self, pairs: Vec<Touching>, normals: &[DVec3]) -> Vec<Touching> {
        let key = |pair: &Touching| {
            let mut surfaces = pair.faces.map(|face| self.first_face[face as usize]);
            surfaces.sort_unstable();
            surfaces
        };
        let mut heights: HashMap<[u32; 2], [f64; 2]> = HashMap::new();
        for pair in &pairs {
            // Heights of the later surface over the earlier one, along the front of the earlier.
            let [f, g] = pair.faces.map(|face| face as usize);
            let opposite = normals[f].dot(normals[g]) < 0.0;
            let swapped = self.first_face[f] > self.first_face[g];
            let [low, high] = match swapped && !opposite {
                true => [-pair.heights[1], -pair.heights[0]],
                false => pair.heights,
            };
            let range = heights.entry(key(pair)).or_insert([f64::INFINITY, f64::NEG_INFINITY]);
            *range = [range[0].min(low), range[1].max(high)];
        }
        let coincide = |pair: &Touching| heights[&key(pair)][0] < GAP && heights[&key(pair)][1] > -GAP;
        pairs.into_iter().filter(coincide).collect()
    }

    fn rank(&self, face: u32, transmits: bool) -> Rank {
        let surface = self.first_face[face as usize];
        Rank { transmits, size_of_surface: self.size.get(&surface).copied().unwrap_or(0), surface, face }
    }
}

/// A key that an edge has in common with its reverse and no other, and whether it runs the other way than the
/// key.
fn edge_key(ends: [DVec3; 2]) -> ([[u64; 3]; 2], bool) {
    // Adding zero makes -0.0 and 0.0 the same corner.
    let [a, b] = ends.map(|p| (p + DVec3::ZERO).to_array().map(f64::to_bits));
    if a <= b { ([a, b], false) } else { ([b, a], true) }
}

/// The face that stands for all that a face is joined to.
fn root(parent: &mut [u32], mut face: u32) -> u32 {
    while parent[face as usize] != face {
        parent[face as usize] = parent[parent[face as usize] as usize];
        face = parent[face as usize];
    }
    face
}
