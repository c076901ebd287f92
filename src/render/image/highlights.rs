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

/// How lamps and all else look from the faces that a pixel shows, each seen from where the pixel's first ray
/// met it. A view for every ray took half as long again in three scenes and lowered noise in none.
#[derive(Default)]
pub(super) struct Views {
    lamps: Known<LampView>,
    pub around: Known<Around>,
    /// Room for two values per channel, to be used again and again.
    pub channels: [Vec<f64>; 2],
}

impl Views {
    /// How lamps look from a face's side.
    pub fn lamps_from(&mut self, tracer: &Tracer, lamps: &Lamps, place: &Interaction) -> Rc<LampView> {
        let corners = tracer.corners(place.face as usize);
        self.lamps.of(place, || lamps.view_from(place.point, (corners, place.normal)))
    }
}

/// How bright parts of faces and the sky look from a face.
pub(super) struct Around {
    pub bright: BrightView,
    pub sky: Option<SkyView>,
}

/// What is known of faces' sides: few, so that looking for one among all takes no time.
pub(super) struct Known<T>(Vec<(u32, Side, Rc<T>)>);

impl<T> Default for Known<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Known<T> {
    /// What is known of the side that a place is on, or what is found out now.
    pub fn of(&mut self, place: &Interaction, find_out: impl FnOnce() -> T) -> Rc<T> {
        let is_there = |&&(face, side, _): &&(u32, Side, Rc<T>)| (face, side) == (place.face, place.side);
        let known = self.0.iter().find(is_there).map(|(_, _, known)| known.clone());
        known.unwrap_or_else(|| {
            let found = Rc::new(find_out());
            self.0.push((place.face, place.side, found.clone()));
            found
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
        let view = views.lamps_from(self.tracer, &self.lamps, &place);
        Shine { tracer: self.tracer, lamps: &self.lamps, view, glossy, face: hit.face }
    }
}

/// What a point of a metal shows of lamps.
pub(super) struct Shine<'v> {
    tracer: &'v Tracer<'v>,
    lamps: &'v Lamps,
    view: Rc<LampView>,
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
