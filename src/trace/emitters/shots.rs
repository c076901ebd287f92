//! Shots: rays from lights without area and from the sky to the mirrors, metals and glass that they meet
//! first.
//!
//! A light with a place draws one of these faces by the solid angle that it fills, and a direction evenly
//! within it; a spot draws half of its directions from its cone, and all count by the density of both (Veach
//! & Guibas 1995, eq. 14). Suns and skies draw a face by its area, and a point on it. A shot that meets
//! something else first is void, so that every direction is drawn in one way only.

use std::f64::consts::TAU;

use glam::DVec3;

use super::lights::{Lights, Place};
use super::sky::{SkyBeam, SkySampler};
use crate::scene::{FaceState, Light, Side, triangle};
use crate::trace::sampling::{Discrete, uniform_cone, uniform_triangle};
use crate::trace::solid_angle::{solid_angle, towards_triangle, triangle_pdf};
use crate::trace::{Hit, OUTSIDE, Ray, RayHit, Tracer};

/// What a face in whose direction a light sends nothing counts for all the same, for shares are looked up at
/// a few points alone.
const LEAST_SHARE: f64 = 0.05;

/// The faces of mirrors, metals and glass as lights aim at them.
#[derive(Clone, Debug)]
pub struct Targets {
    /// Ascending.
    faces: Vec<u32>,
    /// Area of all, normalised, and chances by it.
    area: f64,
    by_area: Discrete,
    /// For each light.
    aims: Vec<Aim>,
}

/// How a light aims.
#[derive(Clone, Debug)]
struct Aim {
    /// Chances of faces.
    chances: Discrete,
    /// The axis and solid angle of the cone from which half of the directions are drawn.
    cone: Option<(DVec3, f64)>,
}

/// A ray from a light that meets a carrier first.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// The ray, from the light or from outside of the scene, and the carrier that it meets.
    pub met: RayHit,
    /// Flux by density of the shot, as a part of the light's power, per unit of normalised area.
    pub worth: f64,
}

/// A ray from the sky that meets a carrier first.
#[derive(Clone, Copy, Debug)]
pub struct SkyShot {
    /// The ray, from outside of the scene, and the carrier that it meets.
    pub met: RayHit,
    /// Radiance as a share of the zenith's, and tint.
    pub beam: SkyBeam,
    /// Density of such shots, see [`Targets::sky_density`].
    pub density: f64,
}

impl Targets {
    /// The faces that lights aim at; none where there is nothing of the kind, so that nothing is spent on it.
    pub fn new(tracer: &Tracer, lights: &Lights) -> Option<Self> {
        if !tracer.has_carriers() {
            return None;
        }
        let kept = |f: &u32| tracer.scene().faces()[*f as usize].state == FaceState::Kept;
        let all = 0..tracer.scene().faces().len() as u32;
        let faces: Vec<u32> = all.filter(|&f| tracer.may_go_on(f)).filter(kept).collect();
        let by_area = Discrete::new(faces.iter().map(|&f| triangle::area(tracer.corners(f as usize))));
        let area = by_area.total();
        let aims = (0..lights.len()).map(|light| Aim::new(tracer, lights, light, &faces)).collect();
        (area > 0.0).then_some(Self { faces, area, by_area: by_area.normalised(), aims })
    }

    /// A shot from a light by four random numbers; none where it would meet something else first.
    #[inline]
    pub fn shot(&self, tracer: &Tracer, lights: &Lights, light: usize, random: [f64; 4]) -> Option<Shot> {
        let aim = &self.aims[light];
        match lights.light(light) {
            (source, Place::At(position)) => {
                let [mut choice, u, v, _] = random;
                // Draw a direction, from the cone or towards a face.
                let (direction, drawn) = match aim.cone {
                    Some((axis, angle)) if choice < 0.5 => {
                        (uniform_cone(axis, angle, [2.0 * choice, u]), None)
                    }
                    cone => {
                        if cone.is_some() {
                            choice = 2.0 * choice - 1.0;
                        }
                        let face = self.faces[aim.chances.draw(choice).0];
                        (towards_triangle(position, tracer.corners(face as usize), [u, v]), Some(face))
                    }
                };
                let share = source.share_towards(direction);
                if share <= 0.0 {
                    return None;
                }
                let ray = Ray { origin: position, direction, from: Ray::FREE };
                let hit = tracer.closest_hit(&ray).filter(|hit| tracer.may_go_on(hit.face))?;
                if drawn.is_some_and(|face| face != hit.face) {
                    return None;
                }
                // Weigh it by all ways of drawing it.
                let cosine = tracer.normal(hit.face as usize, hit.side).dot(direction).abs();
                let corners = tracer.corners(hit.face as usize);
                let density = triangle_pdf(position, corners, (hit.distance, cosine));
                let to_face = self.chance(aim, hit.face) * density;
                let density = match aim.cone {
                    Some((axis, angle)) => {
                        let inside = axis.dot(direction) >= 1.0 - angle / TAU;
                        0.5 * (to_face + if inside { 1.0 / angle } else { 0.0 })
                    }
                    None => to_face,
                };
                (density > 0.0).then_some(Shot { met: RayHit { ray, hit }, worth: share / density })
            }
            (_, Place::Towards(..)) => {
                let [choice, u, s, t] = random;
                let (k, fresh) = aim.chances.draw(choice);
                let face = self.faces[k];
                let point = point(tracer.corners(face as usize), [fresh, u]);
                let beam = lights.beam(light, point, [s, t]);
                let (ray, hit) = from_outside(tracer, point, beam.direction, face)?;
                // A face catches what crosses its area, seen along the beam.
                let cosine = tracer.normal(face as usize, Side::Front).dot(beam.direction).abs();
                let caught = beam.density * cosine * triangle::area(tracer.corners(face as usize));
                Some(Shot { met: RayHit { ray, hit }, worth: caught / self.chance(aim, face) })
            }
        }
    }

    /// A shot from the sky by four random numbers; none where it would meet something else first.
    #[inline]
    pub fn sky_shot(&self, tracer: &Tracer, sky: &SkySampler, random: [f64; 4]) -> Option<SkyShot> {
        let [choice, u, s, t] = random;
        // Draw a side of a face, a point on it, and a direction into the sky over it.
        let (k, fresh) = self.by_area.draw(choice);
        let face = self.faces[k];
        let (side, fresh) =
            if fresh < 0.5 { (Side::Front, 2.0 * fresh) } else { (Side::Back, 2.0 * fresh - 1.0) };
        let normal = tracer.normal(face as usize, side);
        let beam = sky.sample(normal, [s, t]);
        if beam.weight <= 0.0 {
            return None;
        }
        let point = point(tracer.corners(face as usize), [fresh, u]);
        let (ray, hit) = from_outside(tracer, point, beam.direction, face)?;
        let density = self.sky_density(tracer, sky, face, beam.direction);
        Some(SkyShot { met: RayHit { ray, hit }, beam, density })
    }

    /// Density of sky shots that meet a face from a direction, per unit of area across the ray and of solid
    /// angle.
    #[inline]
    pub fn sky_density(&self, tracer: &Tracer, sky: &SkySampler, face: u32, direction: DVec3) -> f64 {
        let normal = tracer.normal(face as usize, Side::Front);
        let cosine = normal.dot(direction);
        let normal = if cosine < 0.0 { -normal } else { normal };
        sky.pdf(normal, direction) / (2.0 * self.area * cosine.abs())
    }

    /// The chance that a light draws a face.
    fn chance(&self, aim: &Aim, face: u32) -> f64 {
        self.faces.binary_search(&face).map_or(0.0, |k| aim.chances.weight(k))
    }
}

impl Aim {
    fn new(tracer: &Tracer, lights: &Lights, light: usize, faces: &[u32]) -> Self {
        let (source, place) = lights.light(light);
        let weight = |&face: &u32| {
            let corners = tracer.corners(face as usize);
            match place {
                Place::At(position) => {
                    let [a, b, c] = *corners;
                    let shares = [a, b, c, (a + b + c) / 3.0]
                        .map(|p| source.share_towards((p - position).normalize_or(DVec3::Y)));
                    solid_angle(position, corners) * (LEAST_SHARE + shares.iter().sum::<f64>() / 4.0)
                }
                Place::Towards(middle, sine) => {
                    triangle::area(corners)
                        * (tracer.normal(face as usize, Side::Front).dot(middle).abs() + sine)
                }
            }
        };
        let chances = Discrete::new(faces.iter().map(weight)).normalised();
        let cone = match *source {
            Light::Spot { .. } => Some(source.cone()),
            _ => None,
        };
        Self { chances, cone }
    }
}

/// A ray that comes from a direction to a point of a face, from outside of the scene, where the face is the
/// first that it meets.
#[inline]
fn from_outside(tracer: &Tracer, point: DVec3, direction: DVec3, face: u32) -> Option<(Ray, Hit)> {
    let ray = Ray { origin: point + OUTSIDE * direction, direction: -direction, from: Ray::FREE };
    let hit = tracer.closest_hit(&ray).filter(|hit| hit.face == face)?;
    Some((ray, hit))
}

#[inline]
fn point(corners: &[DVec3; 3], square: [f64; 2]) -> DVec3 {
    triangle::point(corners, uniform_triangle(square))
}
