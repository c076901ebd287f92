//! Facet: a patch's place and what lies over it, all that rays from it need to know.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::{Patches, Slot};
use crate::scene::Side;
use crate::scene::triangle;
use crate::trace::{Coat, Interaction, Ray, Target, Tracer, sampling, target};

/// One side of a cell: a triangle that sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet<'t> {
    pub face: u32,
    pub side: Side,
    pub corners: [DVec3; 3],
    pub normal: DVec3,
    pub coat: Option<&'t Coat>,
}

impl<'t> Facet<'t> {
    /// A triangle of a face's side, corners in the normalised frame.
    pub fn new(tracer: &'t Tracer, (face, side): (usize, Side), corners: [DVec3; 3]) -> Self {
        let (normal, face) = (tracer.normal(face, side), face as u32);
        Self { face, side, corners, normal, coat: tracer.coat_of(face) }
    }

    /// The point that lies where [u, v] in the unit square does, uniform over the triangle.
    #[inline]
    pub fn point(&self, square: [f64; 2]) -> DVec3 {
        triangle::point(&self.corners, sampling::uniform_triangle(square))
    }

    /// Where light from a point is looked for: drawn by solid angle where the point is near, so that no part
    /// that it lights up is missed, and uniform over the triangle elsewhere.
    #[inline]
    pub fn target(&self, from: DVec3, square: [f64; 2]) -> Target {
        target(from, &self.corners, square)
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
        Facet::new(tracer, (face, side), corners)
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
