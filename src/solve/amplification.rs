//! Amplification: how much larger than its residual an error can be.
//!
//! K ≥ 0, so ‖(I − K)⁻¹‖∞ = max w with w = (I − K)⁻¹1. From any ŵ with ‖1 − (I − K)ŵ‖∞ ≤ ε < 1 follows the guaranteed
//! bound max w ≤ max ŵ / (1 − ε), so that a rough ŵ will do.

use nalgebra::DMatrix;

use super::conjugate_gradient::iterate;
use super::{CgOptions, SolveError, bounce, relative};
use crate::transport::Transport;

/// *Guaranteed* upper bounds on ‖(I − K)⁻¹‖∞ and the condition number, per channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Amplification {
    inverse_norm: Vec<f64>,
    norm: Vec<f64>,
}

impl Amplification {
    /// Bounds ‖(I − K)⁻¹‖∞ by a few steps of conjugate gradients.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn new(k: &Transport, options: &CgOptions) -> Result<Self, SolveError> {
        let ones = DMatrix::repeat(k.len(), k.channels(), 1.0);
        let rough = CgOptions { tolerance: 0.05, ..*options };
        let (w, _) = iterate(k, &ones, &rough)?;
        Ok(Self::from_rough(k, w))
    }

    /// What is known already, or a new bound.
    pub(super) fn known_or_new(
        known: Option<&Self>,
        k: &Transport,
        options: &CgOptions,
    ) -> Result<Self, SolveError> {
        known.map_or_else(|| Self::new(k, options), |known| Ok(known.clone()))
    }

    /// Bounds from a rough ŵ (n × c).
    pub(super) fn from_rough(k: &Transport, mut w: DMatrix<f64>) -> Self {
        let ones = DMatrix::repeat(k.len(), k.channels(), 1.0);
        let norm = k.norm();
        let mut residual = bounce(k, &ones, &w).1 - &w;
        // Too rough to bound anything: a few plain bounces shrink what is left.
        for _ in 0..50 {
            if residual.amax() < 0.5 {
                break;
            }
            w += &residual;
            residual = bounce(k, &ones, &w).1 - &w;
        }
        let inverse_norm = (0..k.channels())
            .map(|c| {
                let off = residual.column(c).amax();
                let from_w = if off < 1.0 { w.column(c).max() / (1.0 - off) } else { f64::INFINITY };
                let from_norm = if norm[c] < 1.0 { relative(1.0, 1.0 - norm[c]) } else { f64::INFINITY };
                from_w.min(from_norm)
            })
            .collect();
        Self { inverse_norm, norm }
    }

    /// Bound on ‖(I − K)⁻¹‖∞ in channel c; infinite where none was found.
    pub fn of(&self, c: usize) -> f64 {
        self.inverse_norm[c]
    }

    /// Bound on the condition number of I − K, the largest over channels.
    pub fn condition(&self) -> f64 {
        self.inverse_norm
            .iter()
            .zip(&self.norm)
            .map(|(inverse, norm)| (1.0 + norm) * inverse)
            .fold(1.0, f64::max)
    }
}
