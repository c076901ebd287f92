//! Final gathering: light at a point itself, not at its patch; L = Lₑ + ρ/π·(H of lamps + H of lights without
//! area + H of all else), and on sheets τ/π times the same of their other side more. What lights without area
//! and the sky send by way of mirrors, metals and glass is that of the patches, smoothed.
//!
//! Lamps are sampled at points drawn on them, everything else by cosine-distributed rays, two for each such
//! point, that bring back the solution where they land. Such rays meet lamps too. Both ways count, weighted
//! by the balance heuristic (Veach & Guibas 1995, eq. 14), so that nothing is counted twice and no sample
//! weighs more than the lamp is bright, however near the lamp. Bright parts of other faces are sampled as
//! lamps are, weighted by the power heuristic.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use nalgebra::DMatrix;

use super::field::{Elements, Field, rgb_of, rgb_rows};
use super::highlights::{Around, Highlights, Shine, Views};
use crate::patches::{Barycentrics, Basis, BrightParts, BrightView, Patches};
use crate::render::tone::to_rgb;
use crate::scene::Side;
use crate::trace::sampling::{Sequence, power_heuristic};
use crate::trace::{
    Arrival, Destination, Hit, Interaction, LampView, Lamps, Lights, Ray, RayHit, SkyView, SpecularPath,
    Tint, Tracer,
};

/// All it takes to gather light at a point.
pub(super) struct Gather<'a, 's> {
    tracer: &'a Tracer<'s>,
    highlights: Option<Highlights<'a, 's>>,
    patches: &'a Patches<'s>,
    lamps: Lamps,
    lights: Option<Lights>,
    bright: BrightParts,
    /// The part of H₀ that comes by way of mirrors, metals and glass, which rays from here would hardly find.
    carried: Option<Field<'a, 's>>,
    /// Radiance L wherever rays land.
    radiance: Elements<'a, 's>,
    /// Of every material, front and back.
    reflectance: Vec<[DVec3; 2]>,
    transmittance: Vec<Option<DVec3>>,
    emission: Vec<DVec3>,
    /// Emission of each patch, where textures vary it; else none.
    emitted: Option<Vec<DVec3>>,
}

/// What is bright, as it is seen from a place.
struct Seen<'v> {
    lamps: &'v LampView,
    bright: &'v BrightView,
}

/// One look at the scene.
pub(super) struct Look<'v> {
    /// The sequence of its random numbers, and its point in it.
    pub sequence: Sequence,
    pub point: u32,
    /// The dimension set of the next numbers for what carriers do; every other one is theirs.
    pub set: u32,
    pub views: &'v mut Views,
}

impl Look<'_> {
    fn next(&mut self) -> [f64; 4] {
        self.set += 2;
        self.sequence.dimensions(self.point, self.set - 2)
    }
}

impl<'a, 's> Gather<'a, 's> {
    pub fn new(
        tracer: &'a Tracer<'s>,
        patches: &'a Patches<'s>,
        radiance: &DMatrix<f64>,
        carried: Option<&DMatrix<f64>>,
    ) -> Self {
        let materials = tracer.scene().materials();
        let lamps = Lamps::new(tracer);
        let means = Basis::of(patches, radiance).means(radiance);
        Self {
            tracer,
            highlights: Highlights::new(tracer),
            patches,
            bright: BrightParts::new(tracer, patches, &means, &lamps),
            lamps,
            lights: Lights::new(tracer),
            carried: carried.map(|field| Field::smooth(tracer, patches, field)),
            radiance: Elements::new(patches, radiance),
            reflectance: materials
                .iter()
                .map(|m| Side::BOTH.map(|side| to_rgb(m.reflectance_of(side)).into()))
                .collect(),
            transmittance: materials.iter().map(|m| Some(to_rgb(m.transmittance()?).into())).collect(),
            emission: materials.iter().map(|m| to_rgb(&m.emission).into()).collect(),
            emitted: tracer.scene().has_textures().then(|| rgb_rows(&patches.emitted_radiance()).collect()),
        }
    }

    /// The radiance that comes along a camera's ray, and what the ray met first; none where no light comes.
    /// Where the ray meets carriers it takes one way at each, by chance, and where that leads outside it sees
    /// `away`.
    pub fn seen_along(
        &self,
        ray: &Ray,
        look: &mut Look,
        away: impl Fn(&Ray) -> DVec3,
    ) -> Option<(Hit, DVec3)> {
        let hit = self.tracer.closest_hit(ray)?;
        if self.tracer.may_go_on(hit.face) {
            look.set = 3;
            let seen = self.seen_over_carriers(RayHit { ray: *ray, hit }, look, away, |hit, look| {
                let lit = self.patches.patch_at(hit.face as usize, hit.side, hit.barycentrics).is_some();
                if lit { self.radiance(hit, look) } else { DVec3::ZERO }
            });
            return Some((hit, seen));
        }
        let lit = self.patches.patch_at(hit.face as usize, hit.side, hit.barycentrics).is_some();
        lit.then(|| (hit, self.radiance(&hit, look)))
    }

    /// The radiance that comes along a ray which carriers pass on from where it met one, by one way at each;
    /// `radiance` tells that of diffuse surfaces, `away` that of what lies outside.
    fn seen_over_carriers(
        &self,
        met: RayHit,
        look: &mut Look,
        away: impl Fn(&Ray) -> DVec3,
        radiance: impl FnOnce(&Hit, &mut Look) -> DVec3,
    ) -> DVec3 {
        let mut path = Glance {
            gather: self,
            look,
            seen: DVec3::ZERO,
            colour: DVec3::ONE,
            shine: None,
            sender: None,
            ray: met.ray,
        };
        let end = self.tracer.follow_path(met, &mut path);
        let Glance { look, seen, colour, sender, ray, .. } = path;
        match end {
            Destination::Diffuse { hit, .. } => {
                let radiance = radiance(&hit, look);
                seen + colour * sender.map_or(radiance, |shine| shine.left_of(radiance, &ray, &hit))
            }
            Destination::Away(ray) => seen + colour * away(&ray),
            Destination::Absorbed | Destination::Lost => seen,
        }
    }

    /// Radiance that leaves where a ray ended, estimated with random numbers for a point of the lamps and a
    /// direction.
    fn radiance(&self, hit: &Hit, look: &mut Look) -> DVec3 {
        let place = Interaction::of(self.tracer, hit);
        let material = self.tracer.scene().faces()[hit.face as usize].material as usize;
        let scene = self.tracer.scene();
        let mut reflectance = self.reflectance[material][usize::from(hit.side == Side::Back)];
        let mut emitted = DVec3::ZERO;
        if let Some(texture) = scene.reflectance_texture(hit.face as usize) {
            reflectance *= DVec3::from(texture.at(hit.barycentrics));
        }
        if hit.side == Side::Front {
            let texture = scene.emission_texture(hit.face as usize);
            let factors = texture.map_or(DVec3::ONE, |texture| texture.at(hit.barycentrics).into());
            emitted = self.emission[material] * factors;
        }
        let mut radiance = emitted;
        if reflectance != DVec3::ZERO {
            radiance += reflectance * self.arriving(&place, hit.barycentrics, look);
        }
        if let Some(transmittance) = self.transmittance[material] {
            radiance += transmittance * self.arriving(&place.across(), hit.barycentrics, look);
        }
        radiance
    }

    /// H/π at a place.
    fn arriving(&self, place: &Interaction, barycentrics: Barycentrics, look: &mut Look) -> DVec3 {
        // These pairs of dimensions are stratified best.
        let [.., s, t] = look.sequence.dimensions(look.point, 0);
        let [u, x, v, y] = look.sequence.dimensions(look.point, 1);
        let view = look.views.lamps_from(self.tracer, &self.lamps, place);
        let around = look.views.around.of(place, || Around {
            bright: self.bright.view_from(place.point, place.normal),
            sky: self
                .lights
                .as_ref()
                .and_then(|lights| lights.sky_over(self.tracer, &[place.point], place.normal)),
        });
        let seen = Seen { lamps: &view, bright: &around.bright };
        // What varies from one side to the other cancels in two opposite ways.
        let ways = [[u, v], [1.0 - u, 1.0 - v]];
        let of_ways: DVec3 = ways.into_iter().map(|way| self.light_around(place, &seen, way, look)).sum();
        self.light_of_lamps(place, &view, [s, t])
            + self.light_of_bright_parts(place, &around.bright, [x, y])
            + of_ways / ways.len() as f64
            + self.light_of_lights(place, around.sky.as_ref(), [s, t], look)
            + self.carried_light(place, barycentrics)
    }

    /// H₀/π: of lights without area and the sky by way of carriers, as it was solved.
    fn carried_light(&self, place: &Interaction, barycentrics: [f64; 2]) -> DVec3 {
        let Some(field) = &self.carried else { return DVec3::ZERO };
        let patch = self.patches.patch_at(place.face as usize, place.side, barycentrics);
        patch.map_or(DVec3::ZERO, |patch| field.at(patch, barycentrics) * FRAC_1_PI)
    }

    /// H₀/π: straight from lights without area and from the sky.
    fn light_of_lights(
        &self,
        place: &Interaction,
        sky: Option<&SkyView>,
        random: [f64; 2],
        look: &mut Look,
    ) -> DVec3 {
        let Some(lights) = &self.lights else { return DVec3::ZERO };
        let here = Arrival { place: *place, sky };
        let [irradiance, scratch] = &mut look.views.channels;
        irradiance.clear();
        irradiance.resize(self.tracer.scene().channels(), 0.0);
        scratch.resize(irradiance.len(), 0.0);
        lights.add_irradiance(self.tracer, &here, || random, [irradiance, scratch]);
        DVec3::from(to_rgb(irradiance)) * FRAC_1_PI
    }

    /// Emission as surfaces around see it: where a texture varies it, its mean over the patch.
    fn emitted(&self, face: u32, side: Side, point: Barycentrics) -> DVec3 {
        match (side, &self.emitted) {
            (Side::Back, _) => DVec3::ZERO,
            (Side::Front, None) => {
                self.emission[self.tracer.scene().faces()[face as usize].material as usize]
            }
            (Side::Front, Some(emitted)) => {
                self.patches.patch_at(face as usize, side, point).map_or(DVec3::ZERO, |patch| emitted[patch])
            }
        }
    }

    /// H/π from a point drawn on the lamps.
    fn light_of_lamps(&self, place: &Interaction, view: &LampView, random: [f64; 2]) -> DVec3 {
        let Some(lamp) = self.lamps.sample(view, random).filter(|lamp| lamp.face != place.face) else {
            return DVec3::ZERO;
        };
        let g = place.geometry_term((lamp.point, lamp.normal));
        if g == 0.0 || !self.tracer.unoccluded((place.point, place.face), (lamp.point, lamp.face)) {
            return DVec3::ZERO;
        }
        // Weigh g/p by p/(p + g): a ray finds the same point with density g.
        self.emitted(lamp.face, Side::Front, lamp.barycentrics) * (g / (lamp.pdf + g))
    }

    /// H/π from a point drawn on bright parts of faces.
    fn light_of_bright_parts(&self, place: &Interaction, view: &BrightView, random: [f64; 2]) -> DVec3 {
        let Some(to) = self.bright.sample(view, place.point, random) else { return DVec3::ZERO };
        let cosine = place.normal.dot(to.direction);
        let by_ray = place.pdf(cosine);
        if to.face == place.face || cosine <= 0.0 || by_ray <= 0.0 {
            return DVec3::ZERO;
        }
        let hit = self.tracer.closest_hit(&place.ray(to.direction)).filter(|hit| hit.face == to.face);
        let weight = by_ray / to.pdf * power_heuristic(to.pdf, by_ray);
        hit.map_or(DVec3::ZERO, |hit| weight * self.solved(&hit))
    }

    /// The solution's radiance where a ray lands.
    fn solved(&self, hit: &Hit) -> DVec3 {
        let patch = self.patches.patch_at(hit.face as usize, hit.side, hit.barycentrics);
        patch.map_or(DVec3::ZERO, |patch| self.radiance.at(patch, hit.barycentrics))
    }

    /// H/π from where a ray lands that is distributed by the cosine, or as a coat lets light in.
    fn light_around(
        &self,
        place: &Interaction,
        Seen { lamps: view, bright }: &Seen,
        random: [f64; 2],
        look: &mut Look,
    ) -> DVec3 {
        let ray = place.ray(place.direction(random));
        let Some(hit) = self.tracer.closest_hit(&ray) else { return DVec3::ZERO };
        // What comes by way of carriers is found by such rays, and by looks at lamps from rough metal.
        if self.tracer.may_go_on(hit.face) {
            look.set = 2;
            let met = RayHit { ray, hit };
            return self.seen_over_carriers(met, look, |_| DVec3::ZERO, |hit, _| self.solved(hit));
        }
        let radiance = self.solved(&hit);
        if !self.lamps.contains(hit.face as usize, hit.side) {
            let by_part = self.bright.pdf(bright, place.point, ray.direction, &hit);
            return radiance * power_heuristic(place.pdf(place.normal.dot(ray.direction)), by_part);
        }
        // Leave to lamp points their share of what the lamp emits, none of what they can't face.
        let there = Interaction::of(self.tracer, &hit);
        let pdf = self.lamps.pdf(view, hit.face as usize);
        let g = place.geometry_term((there.point, there.normal));
        let share = if g > 0.0 { pdf / (pdf + g) } else { 0.0 };
        // A linear element that falls below what the lamp emits leaves nothing to add.
        (radiance - self.emitted(hit.face, hit.side, hit.barycentrics) * share).max(DVec3::ZERO)
    }
}

/// A camera's ray on its way over carriers.
struct Glance<'a, 'v, 'l, 's> {
    gather: &'a Gather<'a, 's>,
    look: &'l mut Look<'v>,
    /// Radiance that rough carriers reflect from lamps, so far.
    seen: DVec3,
    /// What carriers leave of what is still to be seen.
    colour: DVec3,
    /// Lamps as the rough carrier that was met last shows them.
    shine: Option<Shine<'a>>,
    /// And the one that sent the last ray.
    sender: Option<Shine<'a>>,
    /// The last ray.
    ray: Ray,
}

impl SpecularPath for Glance<'_, '_, '_, '_> {
    fn numbers(&mut self) -> [f64; 4] {
        self.look.next()
    }

    fn meets(&mut self, ray: &Ray, hit: &Hit) {
        let gather = self.gather;
        self.sender = None;
        self.shine = match (&gather.highlights, gather.tracer.glossy(ray, hit)) {
            (Some(highlights), Some(glossy)) => Some(highlights.shine(self.look.views, glossy, hit)),
            _ => None,
        };
        if let Some(shine) = &self.shine {
            let [s, t, ..] = self.look.next();
            self.seen += self.colour * shine.of_a_lamp([s, t]);
        }
    }

    fn survives(&mut self, colour: Tint, _chance: f64) -> bool {
        self.colour *= rgb_of(colour);
        self.colour.max_element() > 0.0
    }

    fn goes_on(&mut self, _before: &Ray, _hit: &Hit, after: &Ray) {
        self.ray = *after;
        self.sender = self.shine.take();
    }
}

#[cfg(test)]
mod tests {
    use super::super::{RenderOptions, Shading, picture};
    use super::*;
    use crate::patches::Reach;
    use crate::render::test_scenes::{cut, quad, triangles};
    use crate::scene::{Camera, Material};
    use crate::trace::form_factor_to_triangle;

    const EMITTED: [f64; 3] = [1.0, 2.0, 4.0];

    /// Radiance of a floor's point (x, 0, z) below a black lamp of 1 m² at this height, as seen in
    /// `side`² pixels with each of 16 seeds; and the closed form.
    fn under_a_lamp(height: f64, [x, z]: [f64; 2], side: usize, samples: u32) -> (Vec<[f32; 3]>, f64) {
        let floor = quad([-5.0, 0.0, -5.0], [0.0, 0.0, 10.0], [10.0, 0.0, 0.0]);
        let lamp = quad([-0.5, height, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let materials =
            vec![Material::diffuse("floor", &[0.5; 3]), Material::lamp("lamp", &[0.0; 3], &EMITTED)];
        let scene = triangles(&[floor, lamp].concat(), &[0, 0, 1, 1], materials);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 1.0, Reach::Light);
        let target = DVec3::new(x, 0.0, z);
        // Look along the floor, under the lamp.
        let position = target + DVec3::new(0.9 * height, 0.5 * height, 0.0);
        let camera = Camera { position, target, up: DVec3::Y, fov: 1e-4 };
        let seen = |seed: u64| {
            let shading = Shading::Gather;
            let options =
                RenderOptions { width: side, height: side, shading, samples, seed, ..Default::default() };
            picture(&tracer, &patches, &patches.emitted_radiance(), &camera, &options).unwrap().pixels
        };
        let at = tracer.frame().from_world(target);
        let form_factor = |f: usize| form_factor_to_triangle(at, DVec3::Y, tracer.corners(f));
        ((0..16).flat_map(seen).collect(), 0.5 * (form_factor(2) + form_factor(3)))
    }

    #[test]
    fn gathered_light_under_a_lamp_is_lamberts_formula_within_the_standard_error() {
        for (height, place) in
            [(1.0, [0.3, 0.2]), (0.05, [0.3, 0.2]), (0.05, [0.52, 0.0]), (1e-3, [0.1, 0.1])]
        {
            let (seen, exact) = under_a_lamp(height, place, 1, 256);
            for (c, emitted) in EMITTED.iter().enumerate() {
                let n = seen.len() as f64;
                let mean = seen.iter().map(|rgb| f64::from(rgb[c])).sum::<f64>() / n;
                let squares: f64 = seen.iter().map(|rgb| (f64::from(rgb[c]) - mean).powi(2)).sum();
                let error = (squares / (n * (n - 1.0))).sqrt();
                let z = (mean - exact * emitted) / error;
                // Student's t with 15 degrees of freedom exceeds 4.88 once in 5000 times.
                assert!(z.abs() < 4.88, "{height} {place:?}: {mean} ± {error}, not {}", exact * emitted);
                assert!(error < 0.02 * mean, "{height} {place:?}: {mean} ± {error}");
            }
        }
    }

    #[test]
    fn no_sample_is_brighter_than_the_lamp_on_white_both_ways() {
        for height in [1.0, 0.05, 1e-4, 1e-9] {
            let (seen, _) = under_a_lamp(height, [0.4, 0.1], 64, 1);
            // ρ = 0.5, and each of two ways may bring all that the lamp emits.
            assert!(
                seen.iter().all(|rgb| rgb.iter().zip(EMITTED).all(|(&x, e)| f64::from(x) <= e)),
                "{height}"
            );
        }
    }
}
