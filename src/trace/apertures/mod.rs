//! Apertures: openings through which places inside see sun and sky, such as windows, roof lights and doors.
//!
//! Where a building has few and small ones, rays by the cosine seldom find them. So directions are drawn
//! towards apertures too, by solid angle. They only guide samples: whatever they miss is found by the other
//! samples, each direction counts by the density of all ways of drawing it, and an aperture that leads
//! nowhere costs samples and no truth.
//!
//! Candidates are panes of thin glass and what the opaque faces of a plane leave open within their convex
//! hull ([`holes`]). Lines through each tell whether it is an aperture: one end must reach the sky and the
//! other a surface from which little else of the sky is seen.

mod holes;
mod planes;
mod through;
mod view;

use glam::DVec3;
use rayon::prelude::*;

use super::sampling::{Stream, cosine_hemisphere, frame_around, uniform_triangle};
use super::{Ray, Tracer};
use crate::scene::{FaceState, Light, Side, Sky, SkyShares, Surface, triangle};
pub use through::Through;
pub use view::ApertureView;

/// Lines by which a candidate is judged at first, and in all if some of these pass; numbers. Chosen, not
/// fitted.
const LINES: [u32; 2] = [16, 128];

/// The least part of the lines that must pass; a pure number. Chosen, not fitted: what passes less is found
/// about as well without aiming.
const LEAST_PASSING: f64 = 0.02;

/// The most triangles of apertures: the widest are kept. Chosen, not fitted.
const MOST: usize = 256;

/// The most candidates that are judged: those of the largest planes. Chosen, not fitted.
const MOST_CANDIDATES: usize = 8192;

/// Apertures with less than so many times a triangle's area are small beside it; a number. Chosen, not
/// fitted.
const SMALL: f64 = 4.0;

/// A triangle of an aperture, as it is seen from inside.
#[derive(Clone, Debug)]
pub(super) struct Opening {
    /// Normalised frame.
    pub corners: [DVec3; 3],
    /// Unit normal towards the inside.
    pub normal: DVec3,
    pub area: f64,
    /// What a vector from the first corner is to be multiplied by for its weights of the second and third.
    weights: [DVec3; 2],
    /// By how much these change at most where a direction from one unit of length away is off by [`RIM`].
    rim: f64,
    /// The part of the lines through it that lead from the inside to the sky.
    pub passing: f64,
}

/// The apertures of a scene; none where it has neither sun nor sky, or lies open.
#[derive(Clone, Debug, Default)]
pub struct Apertures {
    openings: Vec<Opening>,
}

impl Apertures {
    /// Finds the apertures of a scene.
    pub(super) fn find(tracer: &Tracer) -> Self {
        let scene = tracer.scene();
        let has_sun = scene.lights().any(|light| matches!(light, Light::Sun { .. }));
        if scene.sky().is_none() && !has_sun {
            return Self::default();
        }
        // Of a sky that is dark in parts, what shows these is none.
        let shares = scene.sky().map(Sky::shares);
        let mut candidates = panes(tracer);
        for plane in planes::planes(tracer) {
            if candidates.len() > MOST_CANDIDATES {
                break;
            }
            candidates.extend(holes::holes(tracer, &plane));
        }
        let judged = |(number, corners): (usize, &[DVec3; 3])| {
            Side::BOTH.map(|side| judge(tracer, shares.as_ref(), (number as u32, side), corners))
        };
        let mut openings: Vec<Opening> =
            candidates.par_iter().enumerate().flat_map_iter(judged).flatten().collect();
        openings.sort_by(|a, b| (b.passing * b.area).total_cmp(&(a.passing * a.area)));
        openings.truncate(MOST);
        Self { openings }
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.openings.len()
    }

    /// A point of a triangle, uniform over it, and the unit normal towards the outside.
    pub fn point_of(&self, opening: usize, square: [f64; 2]) -> (DVec3, DVec3) {
        let Opening { corners, normal, .. } = &self.openings[opening];
        (triangle::point(corners, uniform_triangle(square)), -*normal)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.openings.is_empty()
    }

    pub(super) fn openings(&self) -> &[Opening] {
        &self.openings
    }
}

/// The faces of thin glass.
fn panes(tracer: &Tracer) -> Vec<[DVec3; 3]> {
    let scene = tracer.scene();
    let is_pane = |&f: &usize| {
        scene.faces()[f].state == FaceState::Kept
            && matches!(scene.material_of(f).surface, Surface::Pane { .. })
    };
    (0..scene.faces().len()).filter(is_pane).map(|f| *tracer.corners(f)).collect()
}

/// A candidate as an aperture for what lies on one of its sides, if it is one.
fn judge(
    tracer: &Tracer,
    sky: Option<&SkyShares>,
    (number, inside): (u32, Side),
    corners: &[DVec3; 3],
) -> Option<Opening> {
    let front = triangle::normal(corners);
    let normal = if inside == Side::Front { front } else { -front };
    let channels = tracer.scene().channels();
    let sequence = Stream::Apertures.sequence(0, number, u64::from(inside == Side::Back));
    let frame = frame_around(normal);
    let mut left = vec![1.0; channels];
    let mut sees_sky = |ray: &Ray| {
        left.fill(1.0);
        sky.is_none_or(|shares| shares.from(ray.direction) > 0.0)
            && tracer.passes(ray, f64::INFINITY, &mut left)
    };
    let mut passes = |point: u32| {
        let [s, t, x, y] = sequence.point(point);
        let origin = triangle::point(corners, uniform_triangle([s, t]));
        let direction = frame * cosine_hemisphere([x, y]);
        if !sees_sky(&Ray { origin, direction: -direction, from: Ray::FREE }) {
            return false;
        }
        let Some(hit) = tracer.closest_hit(&Ray { origin, direction, from: Ray::FREE }) else { return false };
        // Does it see as much without aiming?
        let [x, y, ..] = sequence.dimensions(point, 1);
        let around = frame_around(tracer.normal(hit.face as usize, hit.side)) * cosine_hemisphere([x, y]);
        tracer.scene().is_diffuse(hit.face as usize)
            && !sees_sky(&Ray { origin: tracer.point(&hit), direction: around, from: hit.face })
    };
    let [few, all] = LINES;
    let mut count = (0..few).filter(|&k| passes(k)).count();
    if count > 0 {
        count += (few..all).filter(|&k| passes(k)).count();
    }
    let passing = count as f64 / f64::from(all);
    (passing >= LEAST_PASSING).then(|| Opening::new(corners, normal, passing))
}

/// Directions that miss a triangle by no more than this meet its rim, rad: what was drawn on the rim must not
/// be taken for drawn in another way, or it would count for a thousand others.
const RIM: f64 = 1e-13;

impl Opening {
    fn new(corners: &[DVec3; 3], normal: DVec3, passing: f64) -> Self {
        let (&[a, b, c], across) = (corners, triangle::across(corners));
        let weights = [(c - a).cross(across), across.cross(b - a)].map(|w| w / across.length_squared());
        let rim = RIM * (weights[0].length() + weights[1].length());
        Self { corners: *corners, normal, area: triangle::area(corners), weights, rim, passing }
    }

    /// The distance, perhaps negative, at which the line through a point in a direction meets it; none if it
    /// does not.
    #[inline]
    fn met_at(&self, point: DVec3, direction: DVec3) -> Option<f64> {
        let from = point - self.corners[0];
        let cosine = -self.normal.dot(direction);
        let distance = self.normal.dot(from) / cosine;
        let at = from + distance * direction;
        let [u, v] = self.weights.map(|weight| weight.dot(at));
        // A direction that is off by so little moves the point by so much.
        let rim = self.rim * (distance / cosine).abs();
        (u >= -rim && v >= -rim && u + v <= 1.0 + rim).then_some(distance)
    }
}
