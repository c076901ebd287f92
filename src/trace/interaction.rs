//! Interaction: where a ray has met a surface, and how light that arrives there is sampled.

use glam::DVec3;

use super::sampling::{cosine_hemisphere, cosine_hemisphere_pdf, frame_around};
use super::scattering::Coat;
use super::{Hit, Ray, Tracer, geometry_term};
use crate::scene::Side;

/// A point on a side of a face, where light arrives.
#[derive(Clone, Copy)]
pub(crate) struct Interaction<'t> {
    pub face: u32,
    pub side: Side,
    /// Normalised frame.
    pub point: DVec3,
    /// Unit normal of the side.
    pub normal: DVec3,
    /// What lies over it.
    pub coat: Option<&'t Coat>,
}

impl<'t> Interaction<'t> {
    /// Where a ray ended.
    pub fn of(tracer: &'t Tracer, hit: &Hit) -> Self {
        Self {
            face: hit.face,
            side: hit.side,
            point: tracer.point(hit),
            normal: tracer.normal(hit.face as usize, hit.side),
            coat: tracer.coat_of(hit.face),
        }
    }

    /// The ray that leaves in a direction.
    #[inline]
    pub fn ray(&self, direction: DVec3) -> Ray {
        Ray { origin: self.point, direction, from: self.face }
    }

    /// A direction in which light is looked for, with density [`Interaction::pdf`].
    #[inline]
    pub fn direction(&self, square: [f64; 2]) -> DVec3 {
        let local = self.coat.map_or_else(|| cosine_hemisphere(square), |coat| coat.leaving(square));
        frame_around(self.normal) * local
    }

    /// cos θ/π, or (1 − E) cos θ / (π (1 − Ē)) under a coat.
    #[inline]
    pub fn pdf(&self, cosine: f64) -> f64 {
        self.coat.map_or_else(|| cosine_hemisphere_pdf(cosine), |coat| coat.leaving_pdf(cosine))
    }

    /// By how much light from an angle counts more than even light does: 1 where there is no coat.
    #[inline]
    pub fn weight(&self, cosine: f64) -> f64 {
        self.coat.map_or(1.0, |coat| coat.weight(cosine))
    }

    /// cos θ cos θ′ / (π r²) to another point and its normal, as a coat lets light in from there.
    #[inline]
    pub fn geometry_term(&self, there: (DVec3, DVec3)) -> f64 {
        let g = geometry_term((self.point, self.normal), there);
        let towards = || (there.0 - self.point).normalize();
        self.coat.map_or(g, |coat| g * coat.weight(self.normal.dot(towards())))
    }

    /// The same point on the other side of a sheet.
    #[inline]
    pub fn across(self) -> Self {
        Self { side: self.side.other(), normal: -self.normal, ..self }
    }
}
