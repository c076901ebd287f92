//! Facet: a patch's place and what lies over it, all that rays from it need to know.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::cut::Barycentrics;
use super::{Patches, Slot};
use crate::scene::Side;
use crate::scene::triangle;
use crate::trace::{Coat, Interaction, Ray, Tracer, sampling, solid_angle};

/// One side of a cell: a triangle that sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet<'t> {
    pub face: u32,
    pub side: Side,
    pub corners: [DVec3; 3],
    pub normal: DVec3,
    pub coat: Option<&'t Coat>,
}

/// A point of a facet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub point: DVec3,
    /// Weights of the second and third corner.
    pub barycentrics: Barycentrics,
    /// Density with which it was drawn, relative to a uniform one.
    pub density: f64,
}

/// What is nearer than so many radii of a facet lights it up unevenly.
const NEAR: f64 = 3.0;

impl<'t> Facet<'t> {
    /// The point that lies where [u, v] in the unit square does, uniform over the triangle.
    #[inline]
    pub fn point(&self, square: [f64; 2]) -> DVec3 {
        triangle::point(&self.corners, sampling::uniform_triangle(square))
    }

    /// Where light from a point is looked for: drawn by solid angle where the point is near, so that no part
    /// that it lights up is missed, and uniform over the triangle elsewhere.
    #[inline]
    pub fn target(&self, from: DVec3, square: [f64; 2]) -> Target {
        let [a, b, c] = self.corners;
        let uniform = || {
            let barycentrics = sampling::uniform_triangle(square);
            Target { point: triangle::point(&self.corners, barycentrics), barycentrics, density: 1.0 }
        };
        let centre = self.centre();
        let squared = self.corners.map(|corner| corner.distance_squared(centre));
        let radius_squared = squared.into_iter().fold(0.0, f64::max);
        if centre.distance_squared(from) > NEAR * NEAR * radius_squared {
            return uniform();
        }
        let solid_angle = solid_angle(from, &self.corners);
        let directions = self.corners.map(|corner| (corner - from).normalize_or_zero());
        let direction = sampling::uniform_spherical_triangle(directions, square);
        let across = triangle::across(&self.corners);
        let (height, cosine) = (across.dot(a - from), across.dot(direction));
        let distance = height / cosine;
        let to = from + distance * direction - a;
        let squared = across.length_squared();
        let weights = [to.cross(c - a).dot(across) / squared, (b - a).cross(to).dot(across) / squared];
        // In the facet's own plane there is no solid angle to draw from.
        let density = 0.5 * cosine.abs() / (distance * distance * solid_angle);
        if !(density > 0.0 && density.is_finite() && weights.into_iter().all(f64::is_finite)) {
            return uniform();
        }
        let [u, v] = weights.map(|weight| weight.clamp(0.0, 1.0));
        let barycentrics = [u, v].map(|weight| weight / (u + v).max(1.0));
        Target { point: triangle::point(&self.corners, barycentrics), barycentrics, density }
    }

    /// Where light arrives at the point that lies where [u, v] in the unit square does.
    #[inline]
    pub fn interaction(&self, square: [f64; 2]) -> Interaction<'t> {
        let &Self { face, side, normal, coat, .. } = self;
        Interaction { face, side, point: self.point(square), normal, coat }
    }

    pub fn centre(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (a + b + c) / 3.0
    }

    /// By how much light from a direction counts more than even light does: 1 where there is no coat.
    #[inline]
    pub fn weight(&self, direction: DVec3) -> f64 {
        self.coat.map_or(1.0, |coat| coat.weight(self.normal.dot(direction)))
    }

    /// Rays from all over the facet, distributed by the cosine or as its coat lets light out: points `range`
    /// of a random sequence.
    pub fn rays(self, sequence: sampling::Sequence, range: Range<u32>) -> impl Iterator<Item = Ray> + 't {
        let frame = sampling::frame_around(self.normal);
        range.map(move |k| {
            let [s, t, x, y] = sequence.point(k);
            let direction = match self.coat {
                None => sampling::cosine_hemisphere([x, y]),
                Some(coat) => coat.leaving([x, y]),
            };
            let direction = frame * direction;
            Ray { origin: self.point([s, t]), direction, from: self.face }
        })
    }
}

impl Patches<'_> {
    /// A slot's place in the normalised frame.
    pub(crate) fn facet<'t>(&self, tracer: &'t Tracer, slot: u32) -> Facet<'t> {
        let Slot { face, side, cell } = self.slot(slot);
        let on_face = tracer.corners(face);
        let corners = self.cuts.corners(face, cell).map(|corner| triangle::point(on_face, corner));
        let face_number = face as u32;
        Facet {
            face: face_number,
            side,
            corners,
            normal: tracer.normal(face, side),
            coat: tracer.coat_of(face_number),
        }
    }

    /// n² (1 − Ē) of every slot; nothing at all where all are 1.
    pub(super) fn etendues_per_area(&self, tracer: &Tracer) -> Vec<f64> {
        if !tracer.has_dielectrics() && !tracer.has_facets() {
            return Vec::new();
        }
        let per_area = |slot: u32| {
            let facet = self.facet(tracer, slot);
            let index = tracer.medium_at(facet.centre(), facet.face, facet.normal);
            index * index * facet.coat.map_or(1.0, Coat::passed_of_all)
        };
        let all: Vec<f64> = (0..self.slots() as u32).into_par_iter().map(per_area).collect();
        if all.iter().all(|&each| each == 1.0) { Vec::new() } else { all }
    }
}
