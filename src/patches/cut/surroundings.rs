//! Surroundings: wide faces with nothing over or under them, such as the ground around a house, and how they
//! are cut the more coarsely the farther they are from all else.
//!
//! Cut as finely as a room, a square kilometre of ground leaves the room one patch a wall. What is far away
//! lights it by its mean, and is itself lit almost evenly: there, patches may grow with their distance.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use rayon::prelude::*;

use super::contacts::box_around;
use super::fineness::Fineness;
use super::part::Part;
use crate::scene::{FaceState, Side, distance_to, triangle};
use crate::trace::sampling::{Stream, cosine_hemisphere, frame_around, uniform_triangle};
use crate::trace::{Ray, Tracer};

/// Faces with nothing over or under them are surroundings where their area is this many times that of the
/// rest; a ratio. Chosen: a plane of four by four with a ball of radius a half is a scene of its own, the
/// ground of 40 by 40 m around a room is not.
const WIDE: f64 = 8.0;

/// Rays by which either side of a face looks around; a number. Chosen: a share is then known to 0.08.
const RAYS: u32 = 32;

/// How many of them may meet anything from a face that has nothing over or under it; a number. Chosen: of the
/// ground between houses about half do, of that around a house few.
const MOST_MET: u32 = 8;

/// How many faces look around, the largest first; a number. Chosen: they take some 0.1 s.
const MOST_FACES: usize = 20_000;

/// By how much boxes are widened before they are rounded to f32, normalised lengths.
const PAD: f64 = 1e-6;

/// The wide faces, and where all others are.
#[derive(Clone)]
pub(crate) struct Surroundings {
    /// Ascending.
    faces: Vec<usize>,
    /// All other faces, in the tree's order.
    others: Vec<[DVec3; 3]>,
    tree: Bvh2,
}

impl std::fmt::Debug for Surroundings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Surroundings").field("faces", &self.faces).finish_non_exhaustive()
    }
}

impl Surroundings {
    /// Of a scene that has any.
    pub fn find(tracer: &Tracer) -> Option<Self> {
        let scene = tracer.scene();
        let area = |face: usize| triangle::area(tracer.corners(face));
        let is_kept = |&face: &usize| scene.faces()[face].state == FaceState::Kept;
        let mut kept: Vec<usize> = (0..scene.faces().len()).filter(is_kept).collect();
        kept.sort_by(|&a, &b| area(b).total_cmp(&area(a)));
        let is_open = |(order, &face): (usize, &usize)| {
            let looks = order < MOST_FACES && scene.is_diffuse(face);
            looks && Side::BOTH.into_iter().all(|side| is_free(tracer, face, side))
        };
        let is_open: Vec<bool> = kept.par_iter().enumerate().map(is_open).collect();
        let (faces, others): (Vec<_>, Vec<_>) = kept.iter().zip(is_open).partition(|&(_, is_open)| is_open);
        let [mut faces, others] =
            [faces, others].map(|all| all.into_iter().map(|(&face, _)| face).collect::<Vec<_>>());
        faces.sort_unstable();
        let total = |faces: &[usize]| faces.iter().map(|&face| area(face)).sum::<f64>();
        if others.is_empty() || total(&faces) < WIDE * total(&others) {
            return None;
        }
        let boxes: Vec<Aabb> = others.iter().map(|&face| box_around(tracer.corners(face), PAD)).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::fastest_build(), &mut Default::default());
        let others = tree.primitive_indices.iter().map(|&k| *tracer.corners(others[k as usize])).collect();
        Some(Self { faces, others, tree })
    }

    /// Whether a face is one of the surroundings.
    pub fn has(&self, face: usize) -> bool {
        self.faces.binary_search(&face).is_ok()
    }

    /// Whether a place (normalised) lies beside all that is not surroundings: farther from it than that is
    /// large.
    pub fn is_beside(&self, place: DVec3) -> bool {
        let all = self.tree.nodes[0].aabb();
        self.distance(place) > f64::from((all.max - all.min).length())
    }

    /// Divides a part of a face into parts that are cut evenly each, and tells for how long legs.
    pub fn divide(&self, part: Part, fineness: Fineness, each: &mut impl FnMut(&Part, f64)) {
        let [a, b, c] = part.corners;
        let (centre, longest) = ((a + b + c) / 3.0, triangle::longest(&part.corners));
        let radius = part.corners.map(|corner| corner.distance(centre)).into_iter().fold(0.0, f64::max);
        let distance = (self.distance(centre) - radius).max(0.0);
        let legs = fineness.at(distance);
        if longest <= legs || fineness.at(distance + longest) <= 2.0 * legs {
            each(&part, legs);
        } else {
            part.halves().into_iter().for_each(|half| self.divide(half, fineness, each));
        }
    }

    /// How far a place is from all other faces.
    fn distance(&self, place: DVec3) -> f64 {
        let mut least = f64::INFINITY;
        let mut nodes = vec![(0, 0.0)];
        while let Some((node, distance)) = nodes.pop() {
            if distance >= least {
                continue;
            }
            let node = &self.tree.nodes[node as usize];
            if node.is_leaf() {
                let first = node.first_index as usize;
                let faces = &self.others[first..first + node.prim_count as usize];
                least = faces.iter().map(|corners| distance_to(place, corners, least)).fold(least, f64::min);
                continue;
            }
            let mut children = [0, 1].map(|k| {
                let child = node.first_index + k;
                (child, distance_to_box(place, self.tree.nodes[child as usize].aabb()))
            });
            children.sort_unstable_by(|a, b| b.1.total_cmp(&a.1));
            nodes.extend(children);
        }
        least
    }
}

/// Whether hardly any rays from a side of a face meet anything.
fn is_free(tracer: &Tracer, face: usize, side: Side) -> bool {
    let frame = frame_around(tracer.normal(face, side));
    let sequence = Stream::Surroundings.sequence(0, face as u32, u64::from(side == Side::Back));
    let meets = |&k: &u32| {
        let [s, t, x, y] = sequence.point(k);
        let origin = triangle::point(tracer.corners(face), uniform_triangle([s, t]));
        let ray = Ray { origin, direction: frame * cosine_hemisphere([x, y]), from: face as u32 };
        tracer.closest_hit(&ray).is_some()
    };
    (0..RAYS).filter(meets).nth(MOST_MET as usize).is_none()
}

/// The distance of a place from a box.
fn distance_to_box(place: DVec3, within: &Aabb) -> f64 {
    let place = Vec3A::from(place.as_vec3());
    f64::from((within.min - place).max(place - within.max).max(Vec3A::ZERO).length())
}
