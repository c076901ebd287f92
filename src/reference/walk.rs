//! Walk: one light path, followed backwards from where light is wanted.
//!
//! The irradiance at x is H(x) = π ∫ L(x, ω) cos θ/π dω. With ω drawn with density cos θ/π and y what it
//! meets,
//!
//! H(x) = E\[ π Lₑ(y) + ρ(y) H(y) \],
//!
//! so that a walk over y, y′, … sums up ρ(y) ρ(y′) … · π Lₑ. On a sheet there is τ(y) times the H of its
//! other side beside; the walk follows one of the two, by chance. Lamps are found twice at every step: by ω,
//! and by a point drawn on them. The two are joined by multiple importance sampling with the power heuristic
//! (Veach 1997, eq. 9.13). So it is at rough conductors and coats, which stand between x and y as mirrors and
//! glass do, but have directions enough for a lamp to be found by either way.

use std::f64::consts::PI;

use glam::DVec3;

use super::beams::Beams;
use super::lights::Lights;
use crate::scene::{FaceTexture, Side};
use crate::trace::sampling::{Sampler, power_heuristic};
use crate::trace::{
    Destination, Glossy, Hit, IN_PLANE, Interaction, MOST_CARRIERS_OF_PATHS, Ray, RayHit, SpecularPath, Tint,
    Tracer,
};

/// Steps that every walk takes; from then on Russian roulette decides whether it goes on.
pub(super) const CERTAIN: usize = 3;

/// A diffuse surface that a walk has come to.
pub(super) struct Met {
    pub hit: Hit,
    /// Of the last ray.
    pub direction: DVec3,
    /// Its density per unit solid angle, where lamps are looked for from where it started; none after mirrors
    /// and glass.
    pub density: Option<f64>,
    /// Whether it was met straight, with nothing but thin glass in between.
    pub is_straight: bool,
}

/// Where a walk over carriers ends.
pub(super) enum Beyond {
    /// On a diffuse surface.
    Met(Met),
    /// Outside.
    Away {
        /// The last ray.
        ray: Ray,
        /// Whether it went straight, with nothing but thin glass in its way.
        is_straight: bool,
    },
    /// In a carrier, or nowhere.
    Nowhere,
}

/// Where a walk starts.
pub(super) struct Start<'t> {
    pub place: Interaction<'t>,
    /// Its first direction, as a point of the unit square.
    pub first: [f64; 2],
    /// No more reflections than these of what lamps emit.
    pub longest: usize,
}

/// What a walk needs to know.
#[derive(Debug)]
pub(super) struct Walker<'t, 's> {
    pub tracer: &'t Tracer<'s>,
    pub lights: Lights,
    beams: Option<Beams<'t>>,
    pub channels: usize,
    /// Per face and channel.
    reflectance: Vec<f64>,
    /// Of backs, and what comes through; empty where no sheets are.
    backs: Vec<f64>,
    transmittance: Vec<f64>,
    emission: Vec<f64>,
    /// Per face, what varies either over it; empty where no face has textures.
    textures: Vec<[Option<FaceTexture<'s>>; 2]>,
}

impl<'t, 's> Walker<'t, 's> {
    pub fn new(tracer: &'t Tracer<'s>) -> Self {
        let scene = tracer.scene();
        let faces = 0..scene.faces().len();
        let textured = if scene.has_textures() { faces.clone() } else { 0..0 };
        let are_sheets = scene.materials().iter().any(|material| material.sheet.is_some());
        let sheets = if are_sheets { faces.clone() } else { 0..0 };
        let nothing = vec![0.0; scene.channels()];
        Self {
            tracer,
            lights: Lights::new(tracer),
            beams: Beams::new(tracer),
            channels: scene.channels(),
            reflectance: faces
                .clone()
                .flat_map(|f| scene.material_of(f).reflectance.iter().copied())
                .collect(),
            backs: sheets
                .clone()
                .flat_map(|f| scene.material_of(f).reflectance_of(Side::Back).iter().copied())
                .collect(),
            transmittance: sheets
                .flat_map(|f| scene.material_of(f).transmittance().unwrap_or(&nothing).iter().copied())
                .collect(),
            emission: faces.flat_map(|f| scene.material_of(f).emission.iter().copied()).collect(),
            textures: textured.map(|f| [scene.reflectance_texture(f), scene.emission_texture(f)]).collect(),
        }
    }

    /// ρ at a point of a face's side, per channel; `own` is room for it.
    #[inline]
    fn reflectance<'a>(&'a self, hit: &Hit, own: &'a mut [f64; 3]) -> &'a [f64] {
        let is_back = hit.side == Side::Back && !self.backs.is_empty();
        let reflectance = if is_back { &self.backs } else { &self.reflectance };
        let reflectance = &reflectance[hit.face as usize * self.channels..][..self.channels];
        match self.textures.get(hit.face as usize) {
            Some([Some(texture), _]) => varied(reflectance, texture.at(hit.barycentrics), own),
            _ => reflectance,
        }
    }

    /// Where light arrived that leaves from where a ray ended: on that side, or on the other of a sheet,
    /// decided by `way`. Multiplies `weight` by the part that goes on from there, per channel, over the
    /// chance of going there.
    #[inline]
    pub fn follow(&self, hit: &Hit, way: f64, weight: &mut [f64]) -> Interaction<'t> {
        let mut own = [0.0; 3];
        let reflectance = self.reflectance(hit, &mut own);
        let place = Interaction::of(self.tracer, hit);
        if !self.transmittance.is_empty() {
            let transmittance = &self.transmittance[hit.face as usize * self.channels..][..self.channels];
            let most =
                |part: &[f64]| weight.iter().zip(part).fold(0.0, |most: f64, (w, part)| most.max(w * part));
            let through = most(transmittance);
            if through > 0.0 {
                let chance = through / (through + most(reflectance));
                let goes_through = way < chance;
                let (part, chance) =
                    if goes_through { (transmittance, chance) } else { (reflectance, 1.0 - chance) };
                weight.iter_mut().zip(part).for_each(|(w, part)| *w *= part / chance);
                return if goes_through { place.across() } else { place };
            }
        }
        weight.iter_mut().zip(reflectance).for_each(|(w, rho)| *w *= rho);
        place
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

    /// Walks on from a start. Calls `arrives(k, part, weight, emission)` for each part part·weight·emission
    /// (per channel) of the irradiance there that, reflected there, is bounce k of the light: 0 for what
    /// comes straight from a light without area. `weight` is scratch: two values a channel.
    #[inline]
    pub fn irradiance(
        &self,
        Start { mut place, first, longest }: Start<'t>,
        numbers: &mut Sampler,
        weight: &mut [f64],
        mut arrives: impl FnMut(usize, f64, &[f64], &[f64]),
    ) {
        let (weight, scratch) = weight.split_at_mut(self.channels);
        weight.fill(1.0);
        let mut direction = first;
        if let Some(beams) = &self.beams {
            beams.look(&place, numbers.next(), scratch, |part, power| {
                arrives(0, part, weight, power);
            });
        }
        for k in 0.. {
            // Look straight at a lamp.
            let [u, v, chance, way] = numbers.next();
            let mut own = [0.0; 3];
            if let Some((seen, face, point)) = self.look_at_light(&place, [u, v]) {
                arrives(k + 1, seen, weight, self.emission(face, point, &mut own));
            }
            // Go on in a direction of density cos θ/π, or as the coat lets light in.
            let outwards = place.direction(direction);
            let ray = place.ray(outwards);
            let Some(hit) = self.tracer.closest_hit(&ray) else { return };
            let met = if self.tracer.may_go_on(hit.face) {
                let lamp_seen = |part: f64, weight: &[f64], emission: &[f64]| {
                    arrives(k + 1, PI * part, weight, emission);
                };
                match self.beyond_carriers(RayHit { ray, hit }, numbers, [weight, scratch], lamp_seen) {
                    Beyond::Met(met) => met,
                    Beyond::Away { ray, is_straight: false } => {
                        if let Some(share) =
                            self.beams.as_ref().and_then(|b| b.sky_from(ray.direction, scratch))
                        {
                            arrives(k, PI * share, weight, scratch);
                        }
                        return;
                    }
                    // What comes straight was looked for.
                    Beyond::Away { .. } | Beyond::Nowhere => return,
                }
            } else {
                let density = Some(place.pdf(place.normal.dot(outwards)));
                Met { hit, direction: outwards, density, is_straight: true }
            };
            let hit = met.hit;
            // Count the lamp that was met.
            if hit.side == Side::Front && self.lights.density(hit.face) > 0.0 {
                let emission = self.emission(hit.face, hit.barycentrics, &mut own);
                arrives(k + 1, PI * self.mis_weight(&met), weight, emission);
            }
            // Reflect or let through, and let chance decide whether what is left is worth another step.
            let before = largest(weight);
            let next = self.follow(&hit, way, weight);
            let survival = (largest(weight) / before).min(1.0);
            if survival == 0.0 {
                return;
            }
            if let Some(beams) = &self.beams {
                let random = numbers.next();
                beams.look(&next, random, scratch, |part, power| {
                    arrives(k + 1, part, weight, power);
                });
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

    /// Where a ray ends that carriers pass on from where it has met one, by one way at each. Its weight takes
    /// on their colours; beside it there is scratch, both a value a channel. Calls `lamp_seen(part, weight,
    /// emission)` for each part·weight·emission of the radiance that comes straight from a lamp by a rough
    /// conductor or a coat and was looked for there.
    pub fn beyond_carriers(
        &self,
        met: RayHit,
        numbers: &mut Sampler,
        [weight, scratch]: [&mut [f64]; 2],
        lamp_seen: impl FnMut(f64, &[f64], &[f64]),
    ) -> Beyond {
        let mut path = SpecularWalk {
            walker: self,
            numbers,
            weight,
            scratch,
            lamp_seen,
            met: 0,
            glossy: None,
            sender: None,
            direction: met.ray.direction,
            is_straight: true,
        };
        let end = self.tracer.follow_path(met, &mut path);
        let SpecularWalk { sender, direction, is_straight, .. } = path;
        match end {
            Destination::Diffuse { hit, .. } => {
                let density = sender.map(|glossy| glossy.density(direction));
                Beyond::Met(Met { hit, direction, density, is_straight })
            }
            Destination::Away(ray) => Beyond::Away { ray, is_straight },
            Destination::Absorbed | Destination::Lost => Beyond::Nowhere,
        }
    }

    /// Weight of a lamp that was met by multiple importance sampling, beside points drawn on lamps.
    pub fn mis_weight(&self, Met { hit, direction, density, .. }: &Met) -> f64 {
        let Some(by_direction) = *density else { return 1.0 };
        let cosine = -self.tracer.normal(hit.face as usize, hit.side).dot(*direction);
        power_heuristic(by_direction, self.lights.density(hit.face) * hit.distance * hit.distance / cosine)
    }

    /// A point on a lamp that is seen from a rough conductor: calls `seen(part, tint, (face, point))` for
    /// parts of the radiance that is sent on, per unit of its emission.
    fn look_at_light_from<'w>(
        &'w self,
        glossy: &Glossy<'w>,
        from: u32,
        square: [f64; 2],
        mut seen: impl FnMut(f64, Tint, (u32, [f64; 2])),
    ) {
        let Some(light) = self.lights.sample(square).filter(|light| light.face != from) else { return };
        let between = light.point - glossy.point();
        let distance = between.length();
        let direction = between / distance;
        let cosine = -light.normal.dot(direction);
        let reflected = glossy.reflected(direction);
        let by_direction = reflected[0].0 + reflected[1].0;
        if cosine * distance <= IN_PLANE || by_direction <= 0.0 {
            return;
        }
        if !self.tracer.unoccluded((glossy.point(), from), (light.point, light.face)) {
            return;
        }
        let by_light = light.density * distance * distance / cosine;
        let mis_weight = power_heuristic(by_light, by_direction);
        for (value, tint) in reflected {
            seen(value / by_light * mis_weight, tint, (light.face, light.barycentrics));
        }
    }

    /// A point on a lamp that is seen from `place`: irradiance per unit of its emission, its face, and where
    /// on it.
    #[inline]
    fn look_at_light(&self, place: &Interaction, square: [f64; 2]) -> Option<(f64, u32, [f64; 2])> {
        let light = self.lights.sample(square)?;
        let between = light.point - place.point;
        let squared = between.length_squared();
        let (here, there) = (place.normal.dot(between), -light.normal.dot(between));
        // The products are the heights of either point over the other's plane.
        if here.min(there) <= IN_PLANE {
            return None;
        }
        if !self.tracer.unoccluded((place.point, place.face), (light.point, light.face)) {
            return None;
        }
        let distance = squared.sqrt();
        let by_light = light.density * squared * distance / there;
        let by_direction = place.pdf(here / distance);
        // cos θ cos θ′ / r², per density of the point.
        let seen =
            here * there / (squared * squared) / light.density * power_heuristic(by_light, by_direction);
        let seen = seen * place.weight(here / distance);
        Some((seen, light.face, light.barycentrics))
    }
}

/// A walk over carriers: it takes their colours, looks for a lamp from each rough one, and lets chance decide
/// far on its way whether what is left is worth another step.
struct SpecularWalk<'a, 't, 's, F> {
    walker: &'a Walker<'t, 's>,
    numbers: &'a mut Sampler,
    weight: &'a mut [f64],
    scratch: &'a mut [f64],
    lamp_seen: F,
    /// Carriers so far.
    met: usize,
    /// The rough carrier that was met last; a lamp was looked for from there.
    glossy: Option<Glossy<'a>>,
    /// The one that sent the last ray.
    sender: Option<Glossy<'a>>,
    /// Of the last ray.
    direction: DVec3,
    is_straight: bool,
}

impl<F: FnMut(f64, &[f64], &[f64])> SpecularPath for SpecularWalk<'_, '_, '_, F> {
    const MOST: u32 = MOST_CARRIERS_OF_PATHS;

    #[inline]
    fn numbers(&mut self) -> [f64; 4] {
        self.numbers.next()
    }

    #[inline]
    fn meets(&mut self, ray: &Ray, hit: &Hit) {
        let walker = self.walker;
        self.glossy = walker.tracer.glossy(ray, hit);
        // Plastic that lets light under it is no lamp, so that nothing looks for it from elsewhere.
        self.sender = None;
        let Some(glossy) = &self.glossy else { return };
        let [u, v, ..] = self.numbers.next();
        let Self { weight, scratch, lamp_seen, .. } = self;
        let mut own = [0.0; 3];
        walker.look_at_light_from(glossy, hit.face, [u, v], |part, tint, (face, point)| {
            scratch.iter_mut().zip(&**weight).zip(tint.parts()).for_each(|((s, w), t)| *s = w * t);
            lamp_seen(part, scratch, walker.emission(face, point, &mut own));
        });
    }

    #[inline]
    fn survives(&mut self, colour: Tint, chance: f64) -> bool {
        let before = largest(self.weight);
        self.weight.iter_mut().zip(colour.parts()).for_each(|(w, part)| *w *= part);
        let survival = largest(self.weight) / before;
        if survival.is_nan() || survival == 0.0 {
            return false;
        }
        if self.met >= CERTAIN {
            if chance >= survival {
                return false;
            }
            self.weight.iter_mut().for_each(|w| *w /= survival);
        }
        true
    }

    #[inline]
    fn goes_on(&mut self, before: &Ray, hit: &Hit, after: &Ray) {
        self.is_straight &= self.walker.tracer.goes_straight(before, hit, after);
        self.sender = self.glossy.take();
        self.direction = after.direction;
        self.met += 1;
    }
}

/// A colour under a texture; `own` is room for it.
fn varied<'a>(colour: &[f64], factors: [f64; 3], own: &'a mut [f64; 3]) -> &'a [f64] {
    let channels = colour.len().min(own.len());
    own.iter_mut().zip(colour).zip(factors).for_each(|((own, x), factor)| *own = x * factor);
    &own[..channels]
}

#[inline]
pub(super) fn largest(weight: &[f64]) -> f64 {
    weight.iter().copied().fold(0.0, f64::max)
}
