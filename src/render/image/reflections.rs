//! Reflections: what is seen in mirrors, metals and coats and through glass.

use glam::DVec3;

use super::field::rgb_of;
use super::highlights::{Highlights, Shine, Views};
use crate::trace::sampling::{SEQUENCE_END, Sequence, Stream};
use crate::trace::{Hit, MOST_CARRIERS_OF_BRANCHES, Ray, Tracer};

/// Ways that bring less than this part of what is seen are left out; a pure number, chosen, not fitted.
const LEAST: f64 = 1e-3;

/// Rays by which the first rough conductor in sight looks around; those seen in it take one each.
const LOBE: u32 = 4;

/// The random numbers of one look: a stretch of a sequence.
#[derive(Clone, Copy)]
pub(super) struct Chances {
    sequence: Sequence,
    first: u32,
}

impl Chances {
    /// Those of look `k` at a pixel; `pixel` is its number.
    pub fn new(seed: u64, pixel: u64, k: u32) -> Self {
        let per_sequence = SEQUENCE_END / LOBE;
        let sequence = Stream::Lobes.sequence(seed, k / per_sequence, pixel);
        Self { sequence, first: k % per_sequence * LOBE }
    }
}

/// A way that is followed.
#[derive(Clone, Copy)]
struct Way {
    /// The part of what comes by it that is seen.
    part: DVec3,
    /// Carriers on it.
    depth: u32,
    /// Which of the look's points it follows, once a rough conductor has been met.
    point: Option<u32>,
}

/// All it takes to follow the ways of one look.
pub(super) struct Look<'a, 's, A, R> {
    pub tracer: &'a Tracer<'s>,
    pub highlights: Option<&'a Highlights<'a, 's>>,
    pub chances: Chances,
    pub views: &'a mut Views,
    /// The radiance of what lies outside.
    pub away: &'a A,
    /// The radiance of diffuse surfaces.
    pub radiance: &'a R,
}

impl<A: Fn(&Ray) -> DVec3, R: Fn(&Hit) -> Option<DVec3>> Look<'_, '_, A, R> {
    /// The radiance that comes along `ray` by all ways over carriers, and what the ray met first.
    pub fn seen_along(&mut self, ray: &Ray) -> Option<(Hit, DVec3)> {
        let hit = self.tracer.closest_hit(ray)?;
        match self.tracer.may_go_on(hit.face) {
            false => Some((hit, (self.radiance)(&hit)?)),
            true => {
                let whole = Way { part: DVec3::ONE, depth: 0, point: None };
                Some((hit, self.over_carriers(ray, &hit, whole)))
            }
        }
    }

    /// The part of what is seen that comes by way of a carrier, or from a coat and from under it.
    fn over_carriers(&mut self, ray: &Ray, hit: &Hit, way: Way) -> DVec3 {
        let Some(glossy) = self.tracer.glossy(ray, hit) else {
            let (first, second) = self.tracer.ways_on(ray, hit);
            let mut sum = DVec3::ZERO;
            for on in std::iter::once(first).chain(second) {
                let colour = on.colour.map_or(DVec3::ONE, rgb_of);
                sum += self.beyond(&on.ray, Way { part: way.part * colour * on.share, ..way }, None);
            }
            return sum;
        };
        // The first one spreads over all points of the look, later ones go on by the point that led to them.
        let points = match way.point {
            None => 0..LOBE,
            Some(point) => point..point + 1,
        };
        let each = way.part / points.len() as f64;
        let base = |passed: f64| way.part * passed * (self.radiance)(hit).unwrap_or_default();
        let mut sum = glossy.passed().map_or(DVec3::ZERO, base);
        for point in points {
            let sequence = self.chances.sequence;
            let numbers = |set: u32| sequence.dimensions(self.chances.first + point, 3 * way.depth + set);
            let shine = match self.highlights {
                Some(highlights) => Some(highlights.shine(self.views, glossy, hit)),
                None => None,
            };
            if let Some(shine) = &shine {
                let [s, t, ..] = numbers(2);
                sum += each * shine.of_a_lamp([s, t]);
            }
            let [chance, u, v, _] = numbers(0);
            let on = glossy.sample([chance, u, v], || numbers(1));
            let part = each * on.share * on.colour.map_or(DVec3::ONE, rgb_of);
            sum += self.beyond(&on.ray, Way { part, point: Some(point), ..way }, shine);
        }
        sum
    }

    /// What comes by a ray that leaves a carrier; lamps have had their share of `shine` already.
    fn beyond(&mut self, ray: &Ray, way: Way, shine: Option<Shine>) -> DVec3 {
        let rays = if way.point.is_some() { f64::from(LOBE) } else { 1.0 };
        if way.part.max_element() * rays < LEAST || way.depth == MOST_CARRIERS_OF_BRANCHES {
            return DVec3::ZERO;
        }
        match self.tracer.closest_hit(ray) {
            None => way.part * (self.away)(ray),
            Some(next) if self.tracer.may_go_on(next.face) => {
                self.over_carriers(ray, &next, Way { depth: way.depth + 1, ..way })
            }
            Some(next) => {
                let radiance = (self.radiance)(&next).unwrap_or_default();
                way.part * shine.map_or(radiance, |shine| shine.left_of(radiance, ray, &next))
            }
        }
    }
}
