//! A receiver's point: what its rays find.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;

use super::BATCHES;
use crate::patches::{Basis, BrightParts, BrightView, Patches};
use crate::scene::{Measure, Side, triangle};
use crate::trace::sampling::{
    Sampler, Sequence, Stream, cosine_hemisphere, cosine_hemisphere_pdf, frame_around, power_heuristic,
};
use crate::trace::{
    Arrival, Destination, Hit, Interaction, LampView, Lamps, Lights, Ray, RayHit, SkyView, Tint, Tracer,
    geometry_term,
};
use crate::transport::rows::Tones;

/// All it takes to find the light at a receiver's points.
pub(super) struct Gather<'a, 's> {
    pub tracer: &'a Tracer<'s>,
    pub patches: &'a Patches<'s>,
    pub basis: Basis,
    pub lamps: Lamps,
    pub bright: BrightParts,
    pub lights: Option<Lights>,
    pub measure: Measure,
    /// Towards what the receiver's plane looks, a unit vector.
    pub front: DVec3,
    /// By which all is multiplied.
    pub maintenance: f64,
    /// Rays a point, a multiple of the batches.
    pub rays: u32,
    pub seed: u64,
    pub tones: Tones,
    /// N × c.
    pub radiance: &'a DMatrix<f64>,
}

/// What the rays of a point find.
pub(super) struct Found {
    /// Per tone: coefficients and form factors, ascending.
    pub rows: Vec<Vec<(u32, f64)>>,
    /// H₀ per channel, W·m⁻².
    pub direct: Vec<f64>,
    /// Irradiance that each batch finds by itself, per channel, one batch after another, W·m⁻².
    pub batches: Vec<f64>,
}

/// Planes that stand for a cylinder in each batch of rays; a number. Chosen, not fitted: those of all batches
/// look in as many directions.
pub(super) const PLANES: u32 = 8;

/// Rays of a point.
struct Drawn {
    /// The point's number.
    number: u32,
    batch: u32,
    /// Which of the batch.
    rays: Range<u32>,
}

/// A plane through a point while its light is found.
struct Place {
    point: DVec3,
    normal: DVec3,
    frame: DMat3,
    lamps: LampView,
    bright: BrightView,
    sky: Option<SkyView>,
}

/// Where the rays of a point go.
enum Aim {
    /// Before a plane.
    Plane(Place),
    /// Before planes around the third axis of this frame.
    AllAround(DMat3),
}

/// A place on a patch.
#[derive(Clone, Copy)]
struct OnPatch {
    patch: usize,
    /// Weights of the patch's second and third corner.
    within: [f64; 2],
}

impl Gather<'_, '_> {
    /// The light at the point of this number.
    pub fn at(&self, point: DVec3, number: u32) -> Found {
        let channels = self.radiance.ncols();
        let aim = match self.measure {
            Measure::Cylinder(axis) => Aim::AllAround(frame_around(axis)),
            Measure::Plane | Measure::Normal(_) => Aim::Plane(self.place(point, self.front)),
        };
        let mut found = Found {
            rows: vec![Vec::new(); self.tones.len()],
            direct: vec![0.0; channels],
            batches: vec![0.0; channels * BATCHES as usize],
        };
        for batch in 0..BATCHES {
            let firsts: Vec<usize> = found.rows.iter().map(Vec::len).collect();
            let before = found.direct.clone();
            match &aim {
                Aim::AllAround(frame) => {
                    for plane in 0..PLANES {
                        let part = f64::from(plane * BATCHES + batch) / f64::from(PLANES * BATCHES);
                        let (sine, cosine) = (TAU * part).sin_cos();
                        let place = self.place(point, *frame * DVec3::new(cosine, sine, 0.0));
                        let own = self.rays / (BATCHES * PLANES);
                        let rays = plane * own..(plane + 1) * own;
                        self.add(&place, Drawn { number, batch, rays }, &mut found);
                    }
                }
                Aim::Plane(place) => {
                    self.add(place, Drawn { number, batch, rays: 0..self.rays / BATCHES }, &mut found)
                }
            }
            for (c, sum) in found.batches[batch as usize * channels..][..channels].iter_mut().enumerate() {
                let tone = self.tones.of_channel(c);
                let new = found.rows[tone][firsts[tone]..].iter();
                let from_surfaces: f64 = new.map(|&(j, f)| f * self.radiance[(j as usize, c)]).sum();
                *sum = f64::from(BATCHES) * (found.direct[c] - before[c] + PI * from_surfaces);
            }
        }
        for row in &mut found.rows {
            row.sort_by_key(|&(j, _)| j);
            let sums = row.chunk_by(|a, b| a.0 == b.0);
            let sum = |run: &[(u32, f64)]| self.maintenance * run.iter().map(|&(_, f)| f).sum::<f64>();
            *row = sums.map(|run| (run[0].0, sum(run))).collect();
        }
        found.direct.iter_mut().chain(&mut found.batches).for_each(|h| *h *= self.maintenance);
        found
    }

    /// A plane through a point with a normal.
    fn place(&self, point: DVec3, normal: DVec3) -> Place {
        let sky = self.lights.as_ref().and_then(|lights| lights.sky_over(self.tracer, &[point], normal));
        Place {
            point,
            normal,
            frame: frame_around(normal),
            lamps: self.lamps.view_from(point, (&[point], normal)),
            bright: self.bright.view_from(point, normal),
            sky,
        }
    }

    /// Adds what some rays of a batch of a point find.
    fn add(&self, place: &Place, Drawn { number, batch, rays }: Drawn, found: &mut Found) {
        let drawn = |stream: Stream| {
            let (sequence, points) = stream.stretch(self.seed, number, u64::from(batch), self.rays / BATCHES);
            (sequence, points.start + rays.start..points.start + rays.end)
        };
        self.add_rays(place, drawn(Stream::Receivers), found);
        self.add_bright(place, drawn(Stream::ReceiverBright), found);
        self.add_lights(place, drawn(Stream::ReceiverLights), &mut found.direct);
    }

    /// Adds what cosine-distributed rays find, and points drawn on lamps.
    fn add_rays(&self, place: &Place, (sequence, points): (Sequence, Range<u32>), found: &mut Found) {
        let &Place { point, normal, ref lamps, .. } = place;
        let rays = f64::from(self.rays);
        // Density of all samples on a lamp's point, per unit of normalised area: rays find it with density g,
        // lamp samples with p.
        let share = |g: f64, p: f64| g / (rays * (g + p));
        for k in points {
            let [x, y, u, v] = sequence.point(k);
            let direction = place.frame * cosine_hemisphere([x, y]);
            self.add_ray(place, direction, Sampler { sequence, point: k, set: 1 }, found);
            let Some(lamp) = self.lamps.sample(lamps, [u, v]) else { continue };
            let g = geometry_term((point, normal), (lamp.point, lamp.normal));
            if g > 0.0 && self.tracer.unoccluded((point, Ray::FREE), (lamp.point, lamp.face)) {
                let there = self.on_patch(lamp.face as usize, Side::Front, lamp.barycentrics);
                self.push(&mut found.rows, there, |_| share(g, lamp.pdf));
            }
        }
    }

    /// Adds what a ray finds, by way of carriers too.
    fn add_ray(&self, place: &Place, direction: DVec3, mut numbers: Sampler, found: &mut Found) {
        let ray = Ray { origin: place.point, direction, from: Ray::FREE };
        let rays = f64::from(self.rays);
        // What carriers leave of it in each tone; nothing where it meets none.
        let mut colour: Vec<f64> = Vec::new();
        let mut is_straight = true;
        let end = match self.tracer.closest_hit(&ray) {
            None => Destination::Away(ray),
            Some(hit) if !self.tracer.may_go_on(hit.face) => Destination::Diffuse { hit, carried: false },
            Some(hit) => {
                let numbers = |_: u32| numbers.next();
                colour.resize(self.tones.len(), 1.0);
                let dims = |tint: Tint, _: f64| {
                    colour
                        .iter_mut()
                        .enumerate()
                        .for_each(|(tone, part)| *part *= self.tones.part(tone, tint));
                    colour.iter().any(|&part| part > 0.0)
                };
                self.tracer.follow(RayHit { ray, hit }, numbers, dims, |before, hit, after| {
                    is_straight &= self.tracer.goes_straight(before, hit, after);
                })
            }
        };
        match end {
            Destination::Diffuse { hit, carried } => {
                let weight = if carried { 1.0 / rays } else { self.worth(place, direction, &hit) };
                let there = self.on_patch(hit.face as usize, hit.side, hit.barycentrics);
                self.push(&mut found.rows, there, |tone| weight * colour.get(tone).unwrap_or(&1.0));
            }
            // Straight it is looked for by itself.
            Destination::Away(last) if !is_straight => {
                let Some(sky) = self.lights.as_ref().and_then(Lights::sky) else { return };
                let beam = sky.from(last.direction);
                for (c, (sum, zenith)) in found.direct.iter_mut().zip(sky.zenith()).enumerate() {
                    let part = colour[self.tones.of_channel(c)];
                    *sum += PI * beam.weight * beam.tint(c) * zenith * part / rays;
                }
            }
            _ => {}
        }
    }

    /// The form factor that a ray is worth which lands here straight.
    fn worth(&self, place: &Place, direction: DVec3, hit: &Hit) -> f64 {
        let rays = f64::from(self.rays);
        let face = hit.face as usize;
        if self.lamps.contains(face, hit.side) {
            let there = (place.point + direction * hit.distance, self.tracer.normal(face, hit.side));
            let g = geometry_term((place.point, place.normal), there);
            // What lamp samples can't face is left to rays.
            return if g > 0.0 { g / (rays * (g + self.lamps.pdf(&place.lamps, face))) } else { 1.0 / rays };
        }
        let by_part = self.bright.pdf(&place.bright, place.point, direction, hit);
        power_heuristic(cosine_hemisphere_pdf(place.normal.dot(direction)), by_part) / rays
    }

    /// Adds what points drawn on bright patches bring.
    fn add_bright(&self, place: &Place, (sequence, points): (Sequence, Range<u32>), found: &mut Found) {
        if place.bright.is_empty() {
            return;
        }
        let rays = f64::from(self.rays);
        for k in points {
            let [u, v, ..] = sequence.point(k);
            let Some(to) = self.bright.sample(&place.bright, place.point, [u, v]) else { continue };
            let by_cosine = cosine_hemisphere_pdf(place.normal.dot(to.direction));
            if by_cosine <= 0.0 {
                continue;
            }
            let ray = Ray { origin: place.point, direction: to.direction, from: Ray::FREE };
            let weight = by_cosine / to.pdf * power_heuristic(to.pdf, by_cosine) / rays;
            if let Some(hit) = self.tracer.closest_hit(&ray).filter(|hit| hit.face == to.face) {
                let there = self.on_patch(hit.face as usize, hit.side, hit.barycentrics);
                self.push(&mut found.rows, there, |_| weight);
            }
        }
    }

    /// Adds what lights without area and the sky bring straight.
    fn add_lights(&self, place: &Place, (sequence, points): (Sequence, Range<u32>), direct: &mut [f64]) {
        let Some(lights) = &self.lights else { return };
        let (point, normal) = (place.point, place.normal);
        let free = Interaction { face: Ray::FREE, side: Side::Front, point, normal, coat: None };
        let here = Arrival { place: free, sky: place.sky.as_ref() };
        let [mut arrived, mut scratch] = [0, 1].map(|_| vec![0.0; direct.len()]);
        for k in points {
            let [u, v, s, t] = sequence.point(k);
            let mut numbers = [[u, v], [s, t]].into_iter().cycle();
            let mut random = || numbers.next().unwrap_or([u, v]);
            lights.add_irradiance(self.tracer, &here, &mut random, [&mut arrived, &mut scratch]);
        }
        direct.iter_mut().zip(arrived).for_each(|(sum, h)| *sum += h / f64::from(self.rays));
    }

    /// The place on a patch where a face's side has one.
    fn on_patch(&self, face: usize, side: Side, barycentrics: [f64; 2]) -> Option<OnPatch> {
        let patch = self.patches.patch_at(face, side, barycentrics)?;
        let within = match self.basis {
            Basis::Constant => [0.0; 2],
            Basis::Linear => self.patches.weights_in(self.patches.slot_of_patch(patch), barycentrics),
        };
        Some(OnPatch { patch, within })
    }

    /// Adds a form factor, of each tone, to where it belongs: the patch, or its corners.
    fn push(&self, rows: &mut [Vec<(u32, f64)>], there: Option<OnPatch>, form_factor: impl Fn(usize) -> f64) {
        let Some(OnPatch { patch, within }) = there else { return };
        for (tone, row) in rows.iter_mut().enumerate() {
            match self.basis {
                Basis::Constant => row.push((patch as u32, form_factor(tone))),
                Basis::Linear => {
                    let corners = triangle::weights(within).into_iter().zip(3 * patch as u32..);
                    row.extend(corners.map(|(weight, corner)| (corner, weight * form_factor(tone))));
                }
            }
        }
    }
}
