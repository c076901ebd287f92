//! Highlights: lamps as rough metals and coats show them.
//!
//! A lamp is found by points drawn on it, and by rays that the metal sends out. Both count, weighted by the
//! balance heuristic (Veach & Guibas 1995, eq. 14).

use std::rc::Rc;

use glam::DVec3;

use super::field::rgb_of;
use crate::patches::BrightView;
use crate::render::tone::to_rgb;
use crate::scene::Side;
use crate::trace::{Glossy, Hit, IN_PLANE, Interaction, LampView, Lamps, Ray, SkyView, Tracer};

/// How lamps look from the faces that a pixel shows, each seen from where the pixel's first ray met it. A
/// view for every ray took half as long again in three scenes and lowered noise in none.
#[derive(Default)]
pub(super) struct Views {
    lamps: Vec<(u32, Side, LampView)>,
    around: Vec<(u32, Side, Rc<Around>)>,
}

/// How bright parts of faces and the sky look from a face.
pub(super) struct Around {
    pub bright: BrightView,
    pub sky: Option<SkyView>,
}

impl Views {
    /// How lamps look from this point of a face's side, or from the one that was asked for first.
    pub fn seen_at(&mut self, tracer: &Tracer, lamps: &Lamps, place: &Interaction) -> &LampView {
        let key = (place.face, place.side);
        let known = self.lamps.iter().position(|&(face, side, _)| (face, side) == key);
        let k = known.unwrap_or_else(|| {
            let (corners, normal) = (tracer.corners(key.0 as usize), tracer.normal(key.0 as usize, key.1));
            self.lamps.push((key.0, key.1, lamps.view_from(place.point, (corners, normal))));
            self.lamps.len() - 1
        });
        &self.lamps[k].2
    }

    /// How all else looks from this point of a face's side, or from the one that was asked for first.
    pub fn around(&mut self, place: &Interaction, look: impl FnOnce() -> Around) -> Rc<Around> {
        let key = (place.face, place.side);
        let known = self.around.iter().find(|&&(face, side, _)| (face, side) == key);
        known.map(|(_, _, around)| around.clone()).unwrap_or_else(|| {
            let around = Rc::new(look());
            self.around.push((key.0, key.1, around.clone()));
            around
        })
    }
}

/// The lamps that metals show.
pub(super) struct Highlights<'a, 's> {
    tracer: &'a Tracer<'s>,
    lamps: Lamps,
}

impl<'a, 's> Highlights<'a, 's> {
    /// Nothing where there is neither rough metal nor plastic.
    pub fn new(tracer: &'a Tracer<'s>) -> Option<Self> {
        tracer.has_facets().then(|| Self { tracer, lamps: Lamps::new(tracer) })
    }

    /// What a point of a metal that was met shows of lamps.
    pub fn shine<'v>(&'v self, views: &mut Views, glossy: Glossy<'v>, hit: &Hit) -> Shine<'v> {
        let place = Interaction::of(self.tracer, hit);
        let view = views.seen_at(self.tracer, &self.lamps, &place).clone();
        Shine { tracer: self.tracer, lamps: &self.lamps, view, glossy, face: hit.face }
    }
}

/// What a point of a metal shows of lamps.
pub(super) struct Shine<'v> {
    tracer: &'v Tracer<'v>,
    lamps: &'v Lamps,
    view: LampView,
    glossy: Glossy<'v>,
    face: u32,
}

impl Shine<'_> {
    /// Radiance that the metal reflects from a point drawn on the lamps.
    pub fn of_a_lamp(&self, random: [f64; 2]) -> DVec3 {
        let lamp = self.lamps.sample(&self.view, random).filter(|lamp| lamp.face != self.face);
        let Some(lamp) = lamp else { return DVec3::ZERO };
        let between = lamp.point - self.glossy.point();
        let distance = between.length();
        let direction = between / distance;
        let cosine = -lamp.normal.dot(direction);
        let reflected = self.glossy.reflected(direction);
        let by_direction = reflected[0].0 + reflected[1].0;
        if cosine * distance <= IN_PLANE
            || by_direction <= 0.0
            || !self.tracer.unoccluded((self.glossy.point(), self.face), (lamp.point, lamp.face))
        {
            return DVec3::ZERO;
        }
        let by_lamp = lamp.pdf * distance * distance / cosine;
        let part: DVec3 = reflected.map(|(value, tint)| value * rgb_of(tint)).into_iter().sum();
        self.emitted(lamp.face) * part / (by_lamp + by_direction)
    }

    /// What is left to a ray that the metal sent to a diffuse surface of this radiance.
    pub fn left_of(&self, radiance: DVec3, ray: &Ray, hit: &Hit) -> DVec3 {
        let face = hit.face as usize;
        if !self.lamps.contains(face, hit.side) {
            return radiance;
        }
        let cosine = -self.tracer.normal(face, hit.side).dot(ray.direction);
        let by_lamp = self.lamps.pdf(&self.view, face) * hit.distance * hit.distance / cosine;
        let share = by_lamp / (by_lamp + self.glossy.density(ray.direction));
        // A field that falls below what the lamp emits leaves nothing to add.
        if share > 0.0 { (radiance - self.emitted(hit.face) * share).max(DVec3::ZERO) } else { radiance }
    }

    fn emitted(&self, face: u32) -> DVec3 {
        to_rgb(&self.tracer.scene().material_of(face as usize).emission).into()
    }
}
