//! Lamps: whether what emits sends its light to where something can be lit.
//!
//! Emitting faces that share edges are one lamp. Rays from its fronts land on something else, on the lamp
//! itself, or nowhere; where they land on nothing else and those from its backs do, the lamp is the wrong way
//! round.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::constants::{LAMP_RAYS, LAMP_RAYS_PER_SIDE, NEAR_LAMP};
use super::edges::{Edges, Groups};
use super::{Finding, Grade, shape};
use crate::scene::Side;
use crate::scene::triangle;
use crate::trace::sampling::Stream;
use crate::trace::{Ray, Tracer, sampling};

/// What rays from one side of a lamp met.
#[derive(Clone, Copy, Debug, Default)]
struct View {
    /// Rays that landed on another surface.
    lit: usize,
    /// Of these, those that landed near by.
    near: usize,
    /// Rays that landed on the lamp itself.
    own: usize,
}

/// A lamp.
#[derive(Default)]
struct Lamp {
    faces: Vec<usize>,
    area: f64,
    /// Front and back.
    views: [View; 2],
}

/// How many emitting faces there are whose light goes astray.
pub(super) fn lamps(edges: &Edges, tracer: &Tracer, seed: u64) -> Finding {
    const NAME: &str = "lamps";
    let unit = Some("faces that light nothing");
    let scene = edges.scene;
    let lamps = all(edges, tracer, seed);
    if lamps.is_empty() && scene.require_light().is_ok() {
        // What lights without area and the sky shine on is lit, however a mesh is wound.
        return Finding::good(NAME, 0.0, unit);
    }
    if lamps.is_empty() {
        let remedy = "nothing emits: give a material an emission (Ke in the MTL file, or `emission` in the .toml), or add a [[light]] or a [sky] there, before solving";
        return Finding::good(NAME, 0.0, Some("lamps")).but(Grade::Note, [], remedy);
    }
    let alone = lamps.len() == 1 && lamps[0].faces.len() == shape::kept(scene).count();
    let astray: Vec<&Lamp> = lamps.iter().filter(|lamp| !alone && lamp.lights_nothing()).collect();
    let faces: Vec<usize> = astray.iter().flat_map(|lamp| lamp.faces.iter().copied()).collect();
    let finding = Finding::good(NAME, faces.len() as f64, unit);
    if !faces.is_empty() {
        let flipped = astray.iter().any(|lamp| lamp.views[1].lit > 0);
        let remedy = match flipped {
            true => {
                "only fronts emit, and these face away from all that their backs see: flip them (reverse the order of their \
                     corners)"
            }
            false => {
                "there is nothing to light on either side of them: move them into the scene, or let them emit nothing"
            }
        };
        return finding.but(Grade::Bad, faces, remedy);
    }
    let torn = torn(edges);
    if !torn.is_empty() {
        let remedy = "neighbouring faces of one lamp emit to opposite sides: flip one of each pair";
        return finding.but(Grade::Bad, torn, remedy);
    }
    let near: Vec<usize> =
        lamps.iter().filter(|lamp| lamp.faces_a_wall()).flat_map(|lamp| lamp.faces.iter().copied()).collect();
    if !near.is_empty() {
        let remedy = "their fronts are right before a surface and their backs are not: if they are not meant to light it from so \
                      near, flip them";
        return finding.but(Grade::Note, near, remedy);
    }
    finding
}

/// The lamps, with what they see.
fn all(edges: &Edges, tracer: &Tracer, seed: u64) -> Vec<Lamp> {
    let scene = edges.scene;
    let emits = |face: usize| scene.material_of(face).emits();
    let mut groups = Groups::new(scene.faces().len());
    for uses in edges.pairs().filter(|uses| uses.iter().all(|u| emits(u.face))) {
        groups.join(uses[0].face, uses[1].face);
    }
    let mut lamps: BTreeMap<usize, Lamp> = BTreeMap::new();
    for face in shape::kept(scene).filter(|&face| emits(face)) {
        let lamp = lamps.entry(groups.of(face)).or_default();
        lamp.faces.push(face);
        lamp.area += triangle::area(tracer.corners(face));
    }
    let faces: usize = lamps.values().map(|lamp| lamp.faces.len()).sum();
    let rays = (LAMP_RAYS / faces.max(1)).clamp(LAMP_RAYS_PER_SIDE.start, LAMP_RAYS_PER_SIDE.end) as u32;
    let look = |mut lamp: Lamp| {
        lamp.views = Side::BOTH.map(|side| lamp.view(tracer, side, rays, seed));
        lamp
    };
    let lamps: Vec<Lamp> = lamps.into_values().collect();
    lamps.into_par_iter().map(look).collect()
}

/// The faces of lamps that emit to the other side than their neighbours.
fn torn(edges: &Edges) -> Vec<usize> {
    let emits = |face: usize| edges.scene.material_of(face).emits();
    let lamps = edges.shared().filter(|[one, other]| emits(one.face) && emits(other.face));
    let mut faces: Vec<usize> =
        lamps.filter(|[one, other]| one.upwards == other.upwards).map(|[one, _]| one.face).collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

impl Lamp {
    fn view(&self, tracer: &Tracer, side: Side, rays: u32, seed: u64) -> View {
        let near = NEAR_LAMP * self.area.sqrt();
        let seen = self.faces.par_iter().flat_map_iter(|&face| {
            let bare = move |ray: &Ray| !tracer.is_covered(face as u32, side, ray.origin);
            rays_from(tracer, face, side, rays, seed).filter(bare).filter_map(|ray| tracer.closest_hit(&ray))
        });
        let count = |hit: crate::trace::Hit| {
            let own = self.faces.binary_search(&(hit.face as usize)).is_ok();
            let one = |yes: bool| usize::from(yes);
            View { lit: one(!own), near: one(!own && hit.distance < near), own: one(own) }
        };
        let sum = |a: View, b: View| View { lit: a.lit + b.lit, near: a.near + b.near, own: a.own + b.own };
        seen.map(count).reduce(View::default, sum)
    }

    fn lights_nothing(&self) -> bool {
        let [front, back] = self.views;
        front.lit == 0 && (back.lit > 0 || front.own == 0)
    }

    /// Whether fronts see only what is right before them, and backs do not.
    fn faces_a_wall(&self) -> bool {
        let mostly_near = |view: View| view.near as f64 > 0.5 * view.lit as f64;
        let [front, back] = self.views;
        mostly_near(front) && back.lit > 0 && !mostly_near(back)
    }
}

/// Cosine-distributed rays from all over a side of a face.
fn rays_from(tracer: &Tracer, face: usize, side: Side, rays: u32, seed: u64) -> impl Iterator<Item = Ray> {
    let sequence = Stream::LampViews.sequence(seed, face as u32, u64::from(side == Side::Back));
    let corners = *tracer.corners(face);
    let frame = sampling::frame_around(tracer.normal(face, side));
    (0..rays).map(move |k| {
        let [s, t, x, y] = sequence.point(k);
        let origin = triangle::point(&corners, sampling::uniform_triangle([s, t]));
        let direction = frame * sampling::cosine_hemisphere([x, y]);
        Ray { origin, direction, from: face as u32 }
    })
}
