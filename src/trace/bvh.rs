//! Bounding volume hierarchy: which triangles a ray may meet.
//!
//! `obvhs` builds a binary tree (PLOC with reinsertion, Meister & Bittner 2018); it is folded here into nodes
//! of four children whose boxes are tested at once. Boxes are f32, widened by [`PAD`] so that no rounding of
//! the box test can lose a triangle; triangles are f64 and decide.

use glam::{DVec3, Vec3, Vec3A, Vec4};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::{BvhBuildParams, ploc::PlocSearchDistance};

use super::watertight::{Corners, Shear, padded};
use super::{Hit, Ray, SKIN};
use crate::scene::Side;

/// By how much boxes are widened, normalised lengths.
///
/// With |coordinates| ≤ 2 each of the half-dozen f32 roundings of the box test moves a plane by at most
/// 2⁻²³; 2⁻¹⁹ covers them sixteen times.
const PAD: f32 = 1.0 / (1 << 19) as f32;

/// Rays that start farther out than this are first moved up to the scene, so that PAD holds for them too.
const NEAR: f64 = 2.0;

/// Children that a walk defers before it sets them aside on the heap.
const STACK: usize = 64;

/// Four children side by side: lane k of every vector is child k.
#[derive(Clone, Debug)]
struct Node {
    /// `[axis][0]` lower and `[axis][1]` upper planes.
    planes: [[Vec4; 2]; 3],
    children: [Child; 4],
}

/// A node's index, or a run of triangles, in one word: eight times the index, plus the number of triangles.
#[derive(Clone, Copy, Debug, Default)]
struct Child(u32);

impl Child {
    fn new(first: u32, triangles: u32) -> Self {
        debug_assert!(triangles < 8 && first < 1 << 29);
        Self(8 * first + triangles)
    }

    /// Index of the node or of the first triangle.
    fn first(self) -> usize {
        (self.0 / 8) as usize
    }

    /// 0 for a node.
    fn triangles(self) -> usize {
        (self.0 % 8) as usize
    }
}

#[derive(Debug)]
pub(super) struct Bvh {
    nodes: Vec<Node>,
    /// Corners, in leaf order.
    corners: Vec<Corners>,
    /// Face numbers, in leaf order.
    faces: Vec<u32>,
}

impl Bvh {
    /// Builds the tree over the faces `kept`, with corners in the normalised frame.
    pub fn new(corners: &[[DVec3; 3]], kept: &[u32]) -> Self {
        let boxes: Vec<Aabb> = kept.iter().map(|&f| padded_box(&corners[f as usize])).collect();
        let params = BvhBuildParams {
            ploc_search_distance: PlocSearchDistance::High,
            reinsertion_batch_ratio: 0.1,
            max_prims_per_leaf: 4,
            ..BvhBuildParams::medium_build()
        };
        let binary = build_bvh2(&boxes, params, &mut Default::default());
        let mut nodes = Vec::new();
        let root = &binary.nodes[0];
        if root.prim_count > 0 {
            nodes.push(Node::new(&[(*root.aabb(), Child::new(0, root.prim_count))]));
        } else {
            fold(&binary, 0, &mut nodes);
        }
        let faces: Vec<u32> = binary.primitive_indices.iter().map(|&k| kept[k as usize]).collect();
        let corners = faces.iter().map(|&f| corners[f as usize].map(padded)).collect();
        Self { nodes, corners, faces }
    }

    /// The first face that the ray meets, other than `ray.from` and those `skipped`.
    pub fn closest_hit(&self, ray: &Ray, skipped: &[u32]) -> Option<Hit> {
        let mut best =
            Hit { face: u32::MAX, side: Side::Front, distance: f64::INFINITY, barycentrics: [0.0; 2] };
        let (ray, ahead) = approach(ray);
        let shear = Shear::new(ray.origin, ray.direction);
        self.walk(&Slabs::new(&ray), f32::INFINITY, |k| {
            let face = self.faces[k];
            if face != ray.from
                && let Some(crossing) = shear.cross(&self.corners[k])
                && crossing.distance > SKIN
                && (crossing.distance, face) < (best.distance, best.face)
                && !skipped.contains(&face)
            {
                best = Hit {
                    face,
                    side: if crossing.front { Side::Front } else { Side::Back },
                    distance: crossing.distance,
                    barycentrics: crossing.barycentrics,
                };
            }
            round_up(best.distance)
        });
        best.distance += ahead;
        (best.face != u32::MAX).then_some(best)
    }

    /// Whether some face other than `ray.from`, `to` and those `skipped` is met before distance `limit`.
    pub fn any_hit(&self, ray: &Ray, (to, skipped): (u32, [&[u32]; 2]), limit: f64) -> bool {
        let (ray, ahead) = approach(ray);
        let limit = limit - ahead;
        let shear = Shear::new(ray.origin, ray.direction);
        let mut met = false;
        self.walk(&Slabs::new(&ray), round_up(limit), |k| {
            let face = self.faces[k];
            met |= face != ray.from
                && face != to
                && shear.cross(&self.corners[k]).is_some_and(|c| c.distance > SKIN && c.distance < limit)
                && skipped.iter().all(|skipped| !skipped.contains(&face));
            if met { f32::NEG_INFINITY } else { round_up(limit) }
        });
        met
    }

    /// Walks the tree, nearest boxes first. `visit` looks at a triangle and answers the distance beyond which
    /// nothing matters any more; `limit` is the first such distance.
    fn walk(&self, slabs: &Slabs, mut limit: f32, mut visit: impl FnMut(usize) -> f32) {
        let mut stack = [(0.0f32, Child::default()); STACK];
        let mut depth = 1;
        let mut set_aside = Vec::new();
        loop {
            if depth == 0 {
                let Some(deferred) = set_aside.pop() else { return };
                (stack[0], depth) = (deferred, 1);
            }
            depth -= 1;
            let (near, child) = stack[depth];
            if near > limit {
                continue;
            }
            if child.triangles() > 0 {
                for k in child.first()..child.first() + child.triangles() {
                    limit = visit(k);
                }
                continue;
            }
            if depth + 4 > STACK {
                set_aside.extend_from_slice(&stack[..depth]);
                depth = 0;
            }
            let node = &self.nodes[child.first()];
            let (near, mut met) = slabs.meet(node, limit);
            // Push the children that are met, nearest on top.
            let bottom = depth;
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let mut place = depth;
                while place > bottom && stack[place - 1].0 < near[lane] {
                    stack[place] = stack[place - 1];
                    place -= 1;
                }
                stack[place] = (near[lane], node.children[lane]);
                depth += 1;
            }
        }
    }
}

impl Node {
    fn new(children: &[(Aabb, Child)]) -> Self {
        // An empty lane is a box turned inside out, which nothing meets.
        let mut planes = [[Vec4::INFINITY, Vec4::NEG_INFINITY]; 3];
        let mut slots = [Child::default(); 4];
        for (lane, (bounds, child)) in children.iter().enumerate() {
            for (axis, [lower, upper]) in planes.iter_mut().enumerate() {
                lower[lane] = bounds.min[axis];
                upper[lane] = bounds.max[axis];
            }
            slots[lane] = *child;
        }
        Self { planes, children: slots }
    }
}

/// Folds the binary subtree under `root` into nodes of four; returns the new node's index.
fn fold(binary: &Bvh2, root: u32, nodes: &mut Vec<Node>) -> u32 {
    let pair = |k: u32| {
        let first = binary.nodes[k as usize].first_index;
        [first, first + 1]
    };
    let is_inner = |k: u32| binary.nodes[k as usize].prim_count == 0;
    // Open the largest inner child until there are four.
    let mut children = pair(root).to_vec();
    while children.len() < 4 {
        let area = |k: u32| binary.nodes[k as usize].aabb().half_area();
        let largest = (0..children.len())
            .filter(|&i| is_inner(children[i]))
            .max_by(|&i, &j| area(children[i]).total_cmp(&area(children[j])));
        let Some(largest) = largest else { break };
        let opened = children.swap_remove(largest);
        children.extend(pair(opened));
    }
    let index = nodes.len();
    nodes.push(Node::new(&[]));
    let folded: Vec<(Aabb, Child)> = children
        .into_iter()
        .map(|k| {
            let node = &binary.nodes[k as usize];
            let first = if is_inner(k) { fold(binary, k, nodes) } else { node.first_index };
            (*node.aabb(), Child::new(first, node.prim_count))
        })
        .collect();
    nodes[index] = Node::new(&folded);
    index as u32
}

fn padded_box(corners: &[DVec3; 3]) -> Aabb {
    let [low, high] =
        [DVec3::min, DVec3::max].map(|pick| pick(pick(corners[0], corners[1]), corners[2]).as_vec3());
    Aabb { min: Vec3A::from(low - Vec3::splat(PAD)), max: Vec3A::from(high + Vec3::splat(PAD)) }
}

/// The ray, moved up to the scene if it starts far away, and by how much it was moved.
fn approach(ray: &Ray) -> (Ray, f64) {
    if ray.origin.abs().max_element() <= NEAR {
        return (*ray, 0.0);
    }
    // The scene lies in the ball of radius √3 < NEAR around the origin.
    let skipped = (-ray.origin.dot(ray.direction) - NEAR).max(0.0);
    (Ray { origin: ray.origin + ray.direction * skipped, ..*ray }, skipped)
}

/// An f32 no smaller than x.
fn round_up(x: f64) -> f32 {
    x as f32 * (1.0 + 2.0 * f32::EPSILON)
}

/// The ray as the box test wants it.
struct Slabs {
    inverse: [Vec4; 3],
    offset: [Vec4; 3],
    /// Per axis, 1 where the ray runs backwards: which plane is the far one.
    backwards: [usize; 3],
}

impl Slabs {
    fn new(ray: &Ray) -> Self {
        // A component of zero becomes tiny: its planes are then met far behind or far ahead.
        let tame = |d: f64| if d.abs() < 1e-18 { 1e18f64.copysign(d) } else { 1.0 / d };
        let direction = ray.direction.to_array();
        let origin = ray.origin.as_vec3().to_array();
        let inverse = direction.map(|d| tame(d) as f32);
        Self {
            inverse: inverse.map(Vec4::splat),
            offset: [0, 1, 2].map(|k| Vec4::splat(origin[k] * inverse[k])),
            backwards: inverse.map(|i| usize::from(i < 0.0)),
        }
    }

    /// Where the ray enters each child's box, and a bit for each box it meets before `limit`.
    #[inline]
    fn meet(&self, node: &Node, limit: f32) -> (Vec4, u32) {
        let cut = |axis: usize, far: usize| {
            node.planes[axis][self.backwards[axis] ^ far] * self.inverse[axis] - self.offset[axis]
        };
        let enter = cut(0, 0).max(cut(1, 0)).max(cut(2, 0)).max(Vec4::ZERO);
        let leave = cut(0, 1).min(cut(1, 1)).min(cut(2, 1)).min(Vec4::splat(limit));
        (enter, enter.cmple(leave).bitmask())
    }
}
