//! Exposure: what it takes to look for the sky and for lights without area from the patches of a scene, told
//! by a few rays from places drawn at random.
//!
//! A place with no aperture above its horizon takes plain rays. One behind windows draws its rays towards
//! apertures, and each ray costs more, since it is weighed by the density of all ways of drawing it. One that
//! a small aperture lights up in part takes more of them. And where no light is found, more looks are spent
//! on finding that.

use super::constants::{EXPOSED, MORE_POINTS, POINTS_WITHOUT_APERTURES, SLOT_LOOKS, SLOTS_EXPOSED};
use super::density::Places;
use crate::patches::{Facet, Outlook};
use crate::scene::triangle;
use crate::trace::sampling::{Sequence, Stream, uniform_triangle};
use crate::trace::{Arrival, Lamps, Lights, Tracer};

/// What looks for the sky and for lights without area take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exposure {
    /// Of patches.
    pub patches: Looks,
    /// Of slots, whether they become patches or not.
    pub slots: Looks,
    /// Looks by which a slot is found to be lit, or to be dark.
    pub until_lit: f64,
}

/// The same of the mean patch or slot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Looks {
    /// Rays into the sky for each usual one: those that are drawn by the sky alone, and those that are
    /// weighed by apertures too.
    pub sky: [f64; 2],
    /// Rays towards lights without area for each usual one towards one light, all lights together.
    pub lights: f64,
    /// Points that are drawn where light comes through apertures or from a narrow cone, by the same count;
    /// most cost no ray.
    pub points: f64,
}

impl Exposure {
    /// Looks around from a few places; nothing where the scene has neither sky nor lights without area.
    pub fn new(tracer: &Tracer, outlook: &Outlook, lamps: &Lamps) -> Self {
        let Some(lights) = Lights::new(tracer) else { return Self::default() };
        let of_patches = Places::new(tracer, &outlook.patches_of, lamps, outlook.stretches.iter().copied());
        let both = vec![[1.0; 2]; outlook.patches_of.len()];
        let of_slots = Places::new(tracer, &both, lamps, outlook.stretches.iter().copied());
        let mut exposure = Self::default();
        for facet in of_patches.facets(EXPOSED, Stream::ForecastRows) {
            exposure.patches.add(tracer, &lights, &facet, 1.0 / f64::from(EXPOSED));
        }
        let sequence = Stream::ForecastColumns.sequence(0, 0, 0);
        for (facet, k) in of_slots.facets(SLOTS_EXPOSED, Stream::ForecastColumns).zip(0..) {
            let share = 1.0 / f64::from(SLOTS_EXPOSED);
            exposure.slots.add(tracer, &lights, &facet, share);
            exposure.until_lit += share * f64::from(looks_until_lit(tracer, &lights, &facet, (sequence, k)));
        }
        exposure
    }
}

impl Looks {
    /// Adds what a patch takes, as one of 1 / `share`.
    fn add(&mut self, tracer: &Tracer, lights: &Lights, facet: &Facet, share: f64) {
        let &Facet { ref corners, normal, .. } = facet;
        if let Some(view) = lights.sky_over(tracer, corners, normal) {
            let apertures = tracer.apertures();
            let is_aimed = !apertures.is_empty() && !apertures.view(corners, normal).is_empty();
            self.sky[usize::from(is_aimed)] += share * f64::from(view.rays(1));
        }
        for light in 0..lights.len() {
            let mean = lights.mean_density(light, corners, normal);
            if mean == Some(0.0) {
                continue;
            }
            let is_narrow = mean.is_some_and(|mean| lights.narrow_cone(light, corners, mean).is_some());
            if !lights.sun_through(light, tracer, corners, normal).is_empty() {
                self.points += share * MORE_POINTS;
                self.lights += share * MORE_POINTS * POINTS_WITHOUT_APERTURES;
            } else if is_narrow {
                self.points += share * MORE_POINTS;
            } else {
                self.lights += share;
            }
        }
    }
}

/// How many looks from a slot it takes to find light, of as many as it has.
fn looks_until_lit(
    tracer: &Tracer,
    lights: &Lights,
    facet: &Facet,
    (sequence, place): (Sequence, u32),
) -> u32 {
    let sky = lights.sky_over(tracer, &facet.corners, facet.normal);
    let [mut arrived, mut scratch] = [0, 1].map(|_| vec![0.0; tracer.scene().channels()]);
    let mut is_lit = |look: u32| {
        let [s, t, u, v] = sequence.dimensions(place, 1 + look);
        arrived.fill(0.0);
        let here = Arrival { place: facet.interaction([s, t]), sky: sky.as_ref() };
        lights.add_irradiance(tracer, &here, || [u, v], [&mut arrived, &mut scratch]);
        arrived.iter().any(|&x| x > 0.0)
    };
    (0..SLOT_LOOKS).position(&mut is_lit).map_or(SLOT_LOOKS, |first| first as u32 + 1)
}

impl<'a> Places<'a, '_> {
    /// Patches drawn with the same chance each.
    fn facets(&self, number: u32, stream: Stream) -> impl Iterator<Item = Facet<'a>> {
        let sequence = stream.sequence(0, 0, 0);
        let drawn = if self.is_empty() { 0 } else { number };
        (0..drawn).map(move |k| {
            let [which, s, t, _] = sequence.point(k);
            let (stretch, side) = self.by_number(which);
            // Of the shape of the stretch around a point of it.
            let point = triangle::point(&stretch.corners, uniform_triangle([s, t]));
            let scale = stretch.cells.sqrt().recip();
            let corners = stretch.corners.map(|corner| point + scale * (corner - point));
            Facet::new(self.tracer(), (stretch.face, side), corners)
        })
    }
}
