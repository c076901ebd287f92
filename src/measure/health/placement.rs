//! Placement: lamps, lights and receivers that are where they cannot be meant to be: outside of the scene,
//! within a solid, or turned away from everything.

use std::f64::consts::FRAC_1_SQRT_2;
use std::fmt::Write;

use glam::DVec3;

use super::constants::{BESIDE, DRAWN_PER_LOOK, FAR_OVER, LOOKS, RECEIVER_POINTS, RIGHT_BEHIND, ROOM};
use super::edges::Edges;
use super::{Grade, lamps};
use crate::scene::{Light, Scene, Side};
use crate::trace::sampling::{Sequence, Stream};
use crate::trace::{Hit, MOST_CROSSINGS, Ray, Tracer, sampling};

/// What a place sees.
enum Surroundings {
    /// Nothing at all.
    Nothing,
    /// Nothing but sky, from outside of the box around the scene.
    Beside,
    /// Backs of an object alone, all around.
    Within(String),
    /// Backs of an object alone, in a plane right before it.
    Behind(String),
    /// Backs alone, from beyond what they enclose.
    Outside,
    /// More than that.
    Scene,
}

/// What is odd about where lamps, lights without area and receivers are, a sentence each.
pub fn odd_placement(tracer: &Tracer, seed: u64) -> Vec<String> {
    let scene = tracer.scene();
    let mut odd = Vec::new();
    let has_lamps = (0..scene.faces().len()).any(|face| scene.material_of(face).emits());
    let astray = has_lamps.then(|| lamps::lamps(&Edges::new(tracer), tracer, seed));
    if let Some(astray) = astray.filter(|found| found.verdict == Grade::Bad)
        && let Some(remedy) = &astray.remedy
    {
        let faces: Vec<String> = astray.faces.iter().map(usize::to_string).collect();
        odd.push(format!("lamps (faces {}): {remedy}", faces.join(", ")));
    }
    for (number, light) in (1..).zip(scene.lights()) {
        let Some(position) = light.position() else { continue };
        let sequence = Stream::Placement.sequence(seed, number, 0);
        let sends = |direction: &DVec3| light.share_towards(*direction) > 0.0;
        // However narrow a beam is, it has an axis.
        let axis = match light {
            Light::Spot { direction, .. } | Light::Ies { direction, .. } => Some(*direction),
            Light::Point { .. } | Light::Sun { .. } => None,
        };
        let all =
            axis.into_iter().chain((0..DRAWN_PER_LOOK * LOOKS).map(|k| anywhere(sequence, k))).filter(sends);
        odd.extend(said(&format!("light {number}"), look(tracer, position, all.take(LOOKS as usize))));
    }
    for (number, receiver) in (0..).zip(scene.receivers()) {
        let frame = sampling::frame_around(receiver.front());
        let step = receiver.len().div_ceil(RECEIVER_POINTS).max(1);
        let points: Vec<DVec3> = receiver.points().step_by(step).collect();
        let sequence = Stream::Placement.sequence(seed, number, 1);
        let ahead = |k: u32| {
            let [u, v, ..] = sequence.point(k);
            frame * sampling::cosine_hemisphere([u, v])
        };
        let views: Vec<Surroundings> =
            points.iter().map(|&point| look(tracer, point, (0..LOOKS).map(ahead))).collect();
        let (looked, who) = (views.len(), format!("receiver {}", receiver.name));
        let mut lost = views.into_iter().filter(|view| !matches!(view, Surroundings::Scene));
        let Some(first) = lost.next() else { continue };
        match 1 + lost.count() {
            all if all == looked => odd.extend(said(&who, first)),
            // Beside the scene or with nothing around it a point is not wrong by itself.
            some => {
                let who = format!(
                    "{who} (about {} of its {} points)",
                    some * receiver.len() / looked,
                    receiver.len()
                );
                let is_wrong = matches!(first, Surroundings::Within(_) | Surroundings::Behind(_));
                odd.extend(is_wrong.then(|| said(&who, first)).flatten());
            }
        }
    }
    odd
}

fn said(who: &str, view: Surroundings) -> Option<String> {
    let mut line = format!("{who} ");
    let _ = match view {
        Surroundings::Nothing => write!(
            line,
            "meets nothing: it lies outside of the scene or is turned away from it; are its numbers in the unit of the OBJ file?"
        ),
        Surroundings::Beside => write!(
            line,
            "lies outside of the box around the scene and meets nothing of it; are its numbers in the unit of the OBJ file?"
        ),
        Surroundings::Within(object) => {
            write!(line, "lies within object {object}: it sees the backs of its faces alone, all around")
        }
        Surroundings::Behind(object) => {
            write!(line, "lies right behind object {object} and sees its backs alone; move it to its front")
        }
        Surroundings::Outside => write!(
            line,
            "meets the backs of faces alone: it lies outside of the room or within a solid; move it, or flip the faces"
        ),
        Surroundings::Scene => return None,
    };
    Some(line)
}

/// What is seen from a place, in metres, in these directions.
fn look(tracer: &Tracer, place: DVec3, directions: impl Iterator<Item = DVec3>) -> Surroundings {
    let scene = tracer.scene();
    let origin = tracer.frame().from_world(place);
    let hits: Vec<_> =
        directions.map(|direction| tracer.closest_hit(&Ray { origin, direction, from: Ray::FREE })).collect();
    // Under an open sky there is light to be had where no surface is.
    if hits.iter().all(Option::is_none) {
        return match scene.sky() {
            None if !hits.is_empty() => Surroundings::Nothing,
            Some(sky) if is_beside(tracer, origin, sky.up) => Surroundings::Beside,
            _ => Surroundings::Scene,
        };
    }
    let objects = hits.iter().map(|hit| {
        let hit = hit.filter(|hit| hit.side == Side::Back && scene.is_diffuse(hit.face as usize))?;
        Some(scene.faces()[hit.face as usize].object)
    });
    let mut objects: Vec<Option<u32>> = objects.collect();
    objects.dedup();
    if objects.contains(&None) {
        return Surroundings::Scene;
    }
    match objects[..] {
        [Some(object)]
            if extent(scene, Some(object)) < ROOM * extent(scene, None)
                && is_enclosed(tracer, origin, Some(object)) =>
        {
            Surroundings::Within(scene.objects()[object as usize].clone())
        }
        _ if scene.sky().is_none() && !is_enclosed(tracer, origin, None) => Surroundings::Outside,
        [Some(object)] if is_right_behind(tracer, origin, hits.iter().flatten()) => {
            Surroundings::Behind(scene.objects()[object as usize].clone())
        }
        _ => Surroundings::Scene,
    }
}

/// Whether a place (normalised frame) under a sky with this zenith lies so far outside of the box around all
/// faces that it is no part of the scene: far over it, or else a little beside it.
fn is_beside(tracer: &Tracer, place: DVec3, up: DVec3) -> bool {
    let faces = 0..tracer.scene().faces().len();
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) =
        faces.flat_map(|face| tracer.corners(face)).fold(none, |(low, high), &p| (low.min(p), high.max(p)));
    let away = place - place.clamp(low, high);
    let is_over = away.dot(up) > FRAC_1_SQRT_2 * away.length();
    away.length() > if is_over { FAR_OVER } else { BESIDE } * (high - low).max_element()
}

/// Whether the planes of all that is met are hardly any distance before a place (normalised frame).
fn is_right_behind<'h>(tracer: &Tracer, place: DVec3, hits: impl Iterator<Item = &'h Hit>) -> bool {
    let near = RIGHT_BEHIND * extent(tracer.scene(), None) / tracer.frame().scale();
    let mut planes = hits.map(|hit| (tracer.point(hit), tracer.normal(hit.face as usize, hit.side)));
    planes.all(|(point, normal)| normal.dot(place - point).abs() <= near)
}

/// Whether most lines from a place (normalised frame) pass through an odd number of faces, of an object or of
/// all: it has walls around it.
fn is_enclosed(tracer: &Tracer, place: DVec3, object: Option<u32>) -> bool {
    let faces = tracer.scene().faces();
    let sequence = Stream::Placement.sequence(0, 0, 2);
    let crossings = |direction: DVec3| {
        let mut ray = Ray { origin: place, direction, from: Ray::FREE };
        let next = || {
            let hit = tracer.closest_hit(&ray)?;
            ray = Ray { origin: tracer.point(&hit), direction, from: hit.face };
            Some(hit.face as usize)
        };
        let met = std::iter::from_fn(next).take(MOST_CROSSINGS);
        met.filter(|&face| object.is_none_or(|object| faces[face].object == object)).count()
    };
    let odd = (0..LOOKS).filter(|&k| crossings(anywhere(sequence, k)) % 2 == 1).count();
    2 * odd > LOOKS as usize
}

/// The longest side of the box around an object, or around all.
fn extent(scene: &Scene, object: Option<u32>) -> f64 {
    let of_it = |face: &usize| object.is_none_or(|object| scene.faces()[*face].object == object);
    let corners = (0..scene.faces().len()).filter(of_it).flat_map(|face| scene.corners(face));
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = corners.fold(none, |(low, high), p| (low.min(p), high.max(p)));
    (high - low).max_element()
}

/// A direction, all alike.
fn anywhere(sequence: Sequence, k: u32) -> DVec3 {
    let [u, v, ..] = sequence.point(k);
    let (height, turn) = (1.0 - 2.0 * u, std::f64::consts::TAU * v);
    let across = (1.0 - height * height).max(0.0).sqrt();
    DVec3::new(across * turn.cos(), across * turn.sin(), height)
}
