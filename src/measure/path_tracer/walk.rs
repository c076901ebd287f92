//! Walk: one light path, followed backwards from where light is wanted.
//!
//! The irradiance at x is H(x) = π ∫ L(x, ω) cos θ/π dω. With ω drawn with density cos θ/π and y what it meets,
//!
//! H(x) = E\[ π Lₑ(y) + ρ(y) H(y) \],
//!
//! so that a walk over y, y′, … sums up ρ(y) ρ(y′) … · π Lₑ. Lamps are found twice at every step: by ω, and by a point drawn on them. The
//! two are joined by multiple importance sampling with the power heuristic (Veach 1997, eq. 9.13).

use std::f64::consts::PI;

use glam::DVec3;

use super::beams::Beams;
use super::lights::Lights;
use crate::scene::{FaceTexture, Side};
use crate::trace::sampling::{Sequence, cosine_hemisphere, cosine_hemisphere_pdf, frame_around};
use crate::trace::{Hit, Ray, Tracer};

/// Steps that every walk takes; from then on Russian roulette decides whether it goes on.
const CERTAIN: usize = 3;

/// A path that has met more carriers than this between two diffuse surfaces is given up.
const MOST_CARRIERS: usize = 1000;

/// A place on a face's side.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub face: u32,
    pub point: DVec3,
    /// Unit normal of the side.
    pub normal: DVec3,
}

impl Place {
    /// Where a ray ended.
    pub fn of(tracer: &Tracer, hit: &Hit) -> Self {
        let [a, b, c] = *tracer.corners(hit.face as usize);
        let [u, v] = hit.barycentrics;
        Self {
            face: hit.face,
            point: a + (b - a) * u + (c - a) * v,
            normal: tracer.normal(hit.face as usize, hit.side),
        }
    }
}

/// The random numbers of a path: a point of a sequence, four dimensions at a time.
pub(super) struct Numbers {
    pub sequence: Sequence,
    pub point: u32,
    pub set: u32,
}

impl Numbers {
    #[inline]
    pub fn next(&mut self) -> [f64; 4] {
        self.set += 1;
        self.sequence.dimensions(self.point, self.set - 1)
    }
}

/// What a walk needs to know.
#[derive(Debug)]
pub(super) struct Walker<'t, 's> {
    pub tracer: &'t Tracer<'s>,
    pub lights: Lights,
    beams: Option<Beams>,
    pub channels: usize,
    /// Per face and channel.
    reflectance: Vec<f64>,
    emission: Vec<f64>,
    /// Per face, what varies either over it; empty where no face has textures.
    textures: Vec<[Option<FaceTexture<'s>>; 2]>,
}

impl<'t, 's> Walker<'t, 's> {
    pub fn new(tracer: &'t Tracer<'s>) -> Self {
        let scene = tracer.scene();
        let faces = 0..scene.faces().len();
        let textured = if scene.has_textures() { faces.clone() } else { 0..0 };
        Self {
            tracer,
            lights: Lights::new(tracer),
            beams: Beams::new(tracer),
            channels: scene.channels(),
            reflectance: faces
                .clone()
                .flat_map(|f| scene.material_of(f).reflectance.iter().copied())
                .collect(),
            emission: faces.flat_map(|f| scene.material_of(f).emission.iter().copied()).collect(),
            textures: textured.map(|f| [scene.reflectance_texture(f), scene.emission_texture(f)]).collect(),
        }
    }

    /// ρ at a point of a face, per channel; `own` is room for it.
    #[inline]
    pub fn reflectance<'a>(&'a self, face: u32, point: [f64; 2], own: &'a mut [f64; 3]) -> &'a [f64] {
        let reflectance = &self.reflectance[face as usize * self.channels..][..self.channels];
        match self.textures.get(face as usize) {
            Some([Some(texture), _]) => varied(reflectance, texture.at(point), own),
            _ => reflectance,
        }
    }

    /// Lₑ at a point of a face's front, per channel; `own` is room for it.
    #[inline]
    pub fn emission<'a>(&'a self, face: u32, point: [f64; 2], own: &'a mut [f64; 3]) -> &'a [f64] {
        let emission = &self.emission[face as usize * self.channels..][..self.channels];
        match self.textures.get(face as usize) {
            Some([_, Some(texture)]) => varied(emission, texture.at(point), own),
            _ => emission,
        }
    }

    /// Walks on from `place`, first in direction `first` of the unit square. Calls `arrives(k, part, weight, emission)` for each part
    /// part·weight·emission (per channel) of the irradiance at `place` that, reflected there, is bounce k of the light: 0 for what comes straight
    /// from a light without area. `weight` is scratch: one value a
    /// channel. No more than `longest` reflections of what lamps emit.
    #[inline]
    pub fn irradiance(
        &self,
        mut place: Place,
        first: [f64; 2],
        numbers: &mut Numbers,
        weight: &mut [f64],
        longest: usize,
        mut arrives: impl FnMut(usize, f64, &[f64], &[f64]),
    ) {
        weight.fill(1.0);
        let mut direction = first;
        if let Some(beams) = &self.beams {
            beams.look(self.tracer, &place, numbers.next(), |part, power| arrives(0, part, weight, power));
        }
        for k in 0.. {
            // Look straight at a lamp.
            let [u, v, chance, _] = numbers.next();
            let mut own = [0.0; 3];
            if let Some((seen, face, point)) = self.look_at_light(&place, [u, v]) {
                arrives(k + 1, seen, weight, self.emission(face, point, &mut own));
            }
            // Go on in a direction of density cos θ/π.
            let outwards = frame_around(place.normal) * cosine_hemisphere(direction);
            let ray = Ray { origin: place.point, direction: outwards, from: place.face };
            let Some(first) = self.tracer.closest_hit(&ray) else { return };
            let straight = !self.tracer.is_carrier(first.face);
            let met = if straight { Some(first) } else { self.beyond_carriers(ray, first, numbers, weight) };
            let Some(hit) = met else { return };
            let next = Place::of(self.tracer, &hit);
            // Count the lamp that was met; by way of carriers it can't be found otherwise.
            let density = self.lights.density(hit.face);
            if hit.side == Side::Front && density > 0.0 {
                let trust = if straight {
                    let by_direction = cosine_hemisphere_pdf(place.normal.dot(outwards));
                    let by_light = density * hit.distance * hit.distance / -next.normal.dot(outwards);
                    share(by_direction, by_light)
                } else {
                    1.0
                };
                arrives(k + 1, PI * trust, weight, self.emission(hit.face, hit.barycentrics, &mut own));
            }
            // Reflect, and let chance decide whether what is left is worth another step.
            let before = largest(weight);
            let reflectance = self.reflectance(hit.face, hit.barycentrics, &mut own);
            weight.iter_mut().zip(reflectance).for_each(|(w, rho)| *w *= rho);
            let survival = largest(weight) / before;
            if survival == 0.0 {
                return;
            }
            if let Some(beams) = &self.beams {
                let random = numbers.next();
                beams.look(self.tracer, &next, random, |part, power| arrives(k + 1, part, weight, power));
            }
            if k == longest {
                return;
            }
            if k + 1 >= CERTAIN {
                if chance >= survival {
                    return;
                }
                weight.iter_mut().for_each(|w| *w /= survival);
            }
            place = next;
            let [s, t, ..] = numbers.next();
            direction = [s, t];
        }
    }

    /// The diffuse surface on which a ray ends that mirrors and glass pass on from `hit`, by one way at each; nothing if it leaves or is
    /// absorbed. Its weight takes on their colours.
    pub fn beyond_carriers(
        &self,
        mut ray: Ray,
        mut hit: Hit,
        numbers: &mut Numbers,
        weight: &mut [f64],
    ) -> Option<Hit> {
        for met in 0..MOST_CARRIERS {
            let [way, life, ..] = numbers.next();
            let scattered = self.tracer.scatter(&ray, &hit, way);
            if let Some(colour) = scattered.colour {
                let before = largest(weight);
                weight.iter_mut().zip(colour).for_each(|(w, part)| *w *= part);
                let survival = largest(weight) / before;
                if survival.is_nan() || survival == 0.0 {
                    return None;
                }
                // Far on its way, let chance decide whether what is left is worth another step.
                if met >= CERTAIN {
                    if life >= survival {
                        return None;
                    }
                    weight.iter_mut().for_each(|w| *w /= survival);
                }
            }
            ray = scattered.ray;
            hit = self.tracer.closest_hit(&ray)?;
            if !self.tracer.is_carrier(hit.face) {
                return Some(hit);
            }
        }
        None
    }

    /// A point on a lamp that is seen from `place`: irradiance per unit of its emission, its face, and where on it.
    #[inline]
    fn look_at_light(&self, place: &Place, square: [f64; 2]) -> Option<(f64, u32, [f64; 2])> {
        let light = self.lights.sample(square)?;
        let between = light.point - place.point;
        let squared = between.length_squared();
        let (here, there) = (place.normal.dot(between), -light.normal.dot(between));
        if here <= 0.0 || there <= 0.0 || light.face == place.face {
            return None;
        }
        if !self.tracer.unoccluded((place.point, place.face), (light.point, light.face)) {
            return None;
        }
        let distance = squared.sqrt();
        let by_light = light.density * squared * distance / there;
        let by_direction = cosine_hemisphere_pdf(here / distance);
        // cos θ cos θ′ / r², per density of the point.
        let seen = here * there / (squared * squared) / light.density * share(by_light, by_direction);
        Some((seen, light.face, light.barycentrics))
    }
}

/// A colour under a texture; `own` is room for it.
fn varied<'a>(colour: &[f64], factors: [f64; 3], own: &'a mut [f64; 3]) -> &'a [f64] {
    let channels = colour.len().min(own.len());
    own.iter_mut().zip(colour).zip(factors).for_each(|((own, x), factor)| *own = x * factor);
    &own[..channels]
}

/// The power heuristic: how much of what one way of sampling finds is to be believed beside another.
#[inline]
fn share(density: f64, other: f64) -> f64 {
    let ratio = other / density;
    1.0 / (1.0 + ratio * ratio)
}

#[inline]
fn largest(weight: &[f64]) -> f64 {
    weight.iter().copied().fold(0.0, f64::max)
}
