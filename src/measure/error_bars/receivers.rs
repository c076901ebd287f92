//! Receivers: what the errors of patches, and the noise of a receiver's own rays, do to what it measures.

use nalgebra::DMatrix;

use super::constants::SIXTEEN_BATCHES;
use super::faces::Faces;
use super::fields::Fields;
use super::sizes::Sizes;
use crate::transport::{Received, ReceiverNoise};

/// How wrong what a receiver measures may be.
#[derive(Clone, Debug)]
pub struct ReceiverBars {
    /// One standard error of each point's irradiance, m × c, W·m⁻².
    pub points: DMatrix<f64>,
    /// The noise of its own rays.
    own: ReceiverNoise,
    /// What errors of the light that patches send out change.
    sent: Fields,
    /// What all errors of the mesh have in common, as a part of irradiance.
    common: f64,
    irradiance: DMatrix<f64>,
}

impl ReceiverBars {
    /// Those of what a receiver measures, to which errors of what patches send out do this.
    pub(super) fn new(received: &Received, sent: Fields, common: f64) -> Self {
        let irradiance = received.irradiance.clone();
        let own = received.rows.noise().clone();
        let (points, channels) = irradiance.shape();
        let mut bars = Self { points: DMatrix::zeros(0, 0), own, sent, common, irradiance };
        bars.points = DMatrix::from_fn(points, channels, |i, c| bars.standard_error(|field| field[(i, c)]));
        bars
    }

    /// What it measures, m × c, W·m⁻².
    pub fn irradiance(&self) -> &DMatrix<f64> {
        &self.irradiance
    }

    /// How large each source of error is over the points, by how large `sizes` finds those of what patches
    /// send out: with the noise of the receiver's own rays, and what errors of the mesh have in common.
    pub(super) fn budget(&self, sizes: impl Fn(&Faces, &Fields) -> Sizes) -> Sizes {
        let points = Faces::of_points(&self.irradiance);
        let own = points.relative(|i, c| self.own.variance(|field| field[(i, c)]));
        sizes(&points, &self.sent).with(own, self.common)
    }

    /// One standard error of a linear function of the points' irradiance (m × c), in its unit.
    pub fn standard_error(&self, of: impl Fn(&DMatrix<f64>) -> f64) -> f64 {
        let common = self.common * of(&self.irradiance);
        let sent = self.sent.squared(&of, 1.0);
        (SIXTEEN_BATCHES.powi(2) * self.own.variance(&of) + sent + common * common).sqrt()
    }
}
