//! Meeting: which corners are one point of one smooth surface.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::corners::Corner;
use crate::patches::{Patches, Slot};
use crate::scene::triangle;
use crate::trace::Tracer;

/// Cosine of the angle between normals at which a surface has a crease: 30°.
const CREASE: f64 = 0.866;

/// Whether something stands between patches that meet is told a little within either and as far above it, as
/// a part of the way to its centre; a ratio. Chosen: over all bends that are no creases, and below what
/// stands on a floor.
const INWARDS: f64 = 0.02;

/// Calls `found` with each set of corners that share a place and a smooth surface, and between which nothing
/// stands, always in the same order.
pub fn for_each_point(
    tracer: &Tracer,
    patches: &Patches,
    corners: &[Corner],
    mut found: impl FnMut(&mut Vec<u32>),
) {
    for_each_surface_point(corners, |members| for_each_open(tracer, patches, corners, members, &mut found));
}

/// Calls `found` with each set of corners that share a place and a smooth surface, always in the same order.
fn for_each_surface_point(corners: &[Corner], mut found: impl FnMut(&mut Vec<u32>)) {
    // Sort along a line that no common mesh is aligned with: corners of one place are then near one another.
    let along = DVec3::new(0.634_087, 0.577_919, 0.513_846).normalize();
    let mut order: Vec<(f64, u32)> =
        corners.par_iter().enumerate().map(|(k, corner)| (corner.position.dot(along), k as u32)).collect();
    order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut taken = vec![false; order.len()];
    let mut place = Vec::new();
    for first in 0..order.len() {
        if taken[first] {
            continue;
        }
        let leader = &corners[order[first].1 as usize];
        place.clear();
        for k in first..order.len() {
            let (height, corner) = order[k];
            if height > order[first].0 + leader.same {
                break;
            }
            if !taken[k] && corners[corner as usize].position.distance(leader.position) <= leader.same {
                taken[k] = true;
                place.push(corner);
            }
        }
        split_by_surface(corners, &mut place, &mut found);
    }
}

/// Splits the corners at one place into smooth surfaces: chains of corners without a crease between links.
fn split_by_surface(corners: &[Corner], place: &mut [u32], found: &mut impl FnMut(&mut Vec<u32>)) {
    let smooth = |a: u32, b: u32| {
        let (a, b) = (&corners[a as usize], &corners[b as usize]);
        a.surface == b.surface && a.normal.dot(b.normal) >= CREASE
    };
    for_each_chain(place, smooth, found);
}

/// Splits corners into chains of those that belong together, link by link.
fn for_each_chain(
    mut rest: &mut [u32],
    together: impl Fn(u32, u32) -> bool,
    mut found: impl FnMut(&mut Vec<u32>),
) {
    while !rest.is_empty() {
        // Grow the chain at the front of the slice until no corner of the rest joins it.
        let (mut start, mut end) = (0, 1);
        while start < end && end < rest.len() {
            let first_left = end;
            for k in first_left..rest.len() {
                if together(rest[start], rest[k]) {
                    rest.swap(end, k);
                    end += 1;
                }
            }
            start += 1;
        }
        let (chain, others) = rest.split_at_mut(end);
        found(&mut chain.to_vec());
        rest = others;
    }
}

/// Splits corners of a smooth surface at one place into those between which nothing stands.
fn for_each_open(
    tracer: &Tracer,
    patches: &Patches,
    corners: &[Corner],
    members: &mut Vec<u32>,
    mut found: impl FnMut(&mut Vec<u32>),
) {
    let face_of = |member: u32| patches.place(corners[member as usize].patch as usize).face;
    let first = face_of(members[0]);
    if patches.pieces(first) == 1 && members.iter().all(|&member| face_of(member) == first) {
        return found(members);
    }
    let above = |member: u32| {
        let corner = &corners[member as usize];
        let Slot { face, side, .. } = patches.place(corner.patch as usize);
        let [a, b, c] = patches.corners(corner.patch as usize).map(DVec2::from);
        let centre = triangle::point(tracer.corners(face), ((a + b + c) / 3.0).into());
        let inwards = INWARDS * (centre - corner.position);
        (corner.position + inwards + tracer.normal(face, side) * inwards.length(), face as u32)
    };
    let is_open = |a: u32, b: u32| {
        corners[a as usize].patch == corners[b as usize].patch || tracer.unoccluded(above(a), above(b))
    };
    for_each_chain(members, is_open, found);
}
