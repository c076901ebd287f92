//! Amplification: how much larger than its residual an error can be.
//!
//! K ≥ 0, so ‖(I − K)⁻¹‖∞ = max w with w = (I − K)⁻¹1. From any ŵ with ‖1 − (I − K)ŵ‖∞ ≤ ε < 1 follows the
//! guaranteed bound max w ≤ max ŵ / (1 − ε), so that a rough ŵ will do.
//!
//! For linear elements K = R M⁻¹S has negative entries and none of this holds. There errors are measured by
//! √(∫ L² dA): with the symmetric form, (I − K)⁻¹r = r + R (I − R S R)⁻¹ R S r, so that an error is at most
//! 1 + ρ_max/(1 − λ) times its residual, with λ the largest eigenvalue of R S R and
//! ‖M^(−½) S M^(−½)‖ = 1. λ is found by Lanczos' method, from below: the bound is an *estimate*. With sheets
//! it is 1 + |λ|_max(P)/(1 − λ): a quasi-definite matrix has no eigenvalue nearer to 0 than its two definite
//! blocks have.

use nalgebra::DMatrix;

use super::krylov::roughly;
use super::symmetric::Root;
use super::{SolveError, relative};
use crate::patches::Basis;
use crate::progress::Progress;
use crate::transport::{Transport, ends_of_spectrum, uneven};

/// How sure a bound is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Certainty {
    /// It holds for the operator at hand, in exact arithmetic.
    Guaranteed,
    /// It is about right.
    Estimated,
}

/// Upper bounds on ‖(I − K)⁻¹‖ and the condition number, per channel: *guaranteed* in ‖·‖∞ for constant
/// elements, *estimated* in √(∫ L² dA) for linear ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Amplification {
    inverse_norm: Vec<f64>,
    norm: Vec<f64>,
    certainty: Certainty,
}

impl Amplification {
    /// Bounds ‖(I − K)⁻¹‖ by a few steps of conjugate gradients, or of Lanczos' method.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn new(k: &Transport, progress: Progress) -> Result<Self, SolveError> {
        if k.basis() == Basis::Linear {
            return Self::estimate(k, progress);
        }
        let ones = DMatrix::repeat(k.len(), k.channels(), 1.0);
        Ok(Self::from_rough(k, roughly(k, &ones, 0.05, progress)?))
    }

    /// What is known already, or a new bound.
    pub(super) fn known_or_new(
        known: Option<&Self>,
        k: &Transport,
        progress: Progress,
    ) -> Result<Self, SolveError> {
        known.map_or_else(|| Self::new(k, progress), |known| Ok(known.clone()))
    }

    /// The estimate for linear elements.
    pub(super) fn estimate(k: &Transport, progress: Progress) -> Result<Self, SolveError> {
        let root = Root::new(k);
        let most_reflected = root.largest();
        // Start near what is even and lasts longest.
        let mut start = DMatrix::from_iterator(k.len(), 1, uneven(k.len()));
        start.column_mut(0).zip_apply(k.mass().sums(), |x, sum| *x *= sum.sqrt());
        let start = DMatrix::from_fn(k.len(), k.channels(), |i, _| start[i]);
        let mut through = DMatrix::zeros(k.len(), k.channels());
        let ends = ends_of_spectrum(start, |x| {
            progress.at("solve", 0.0)?;
            k.through(&root.times(x), &mut through);
            Ok::<_, SolveError>(root.transposed_times(&through))
        })?;
        // Where J has −1, I + RᵀSR counts there as I − RᵀSR does elsewhere.
        let inverse_norm =
            most_reflected.iter().zip(&ends).enumerate().map(|(c, (&rho, &[least, greatest]))| {
                let farthest = if root.signs(c).is_some() { greatest.max(-least) } else { greatest };
                if farthest < 1.0 { 1.0 + rho / (1.0 - farthest) } else { f64::INFINITY }
            });
        Ok(Self {
            inverse_norm: inverse_norm.collect(),
            norm: most_reflected,
            certainty: Certainty::Estimated,
        })
    }

    /// Guaranteed bounds for constant elements from a rough ŵ (n × c).
    pub(super) fn from_rough(k: &Transport, mut w: DMatrix<f64>) -> Self {
        let ones = DMatrix::repeat(k.len(), k.channels(), 1.0);
        let norm = k.norm();
        let left = |w: &DMatrix<f64>| &ones + k.reflect(&k.irradiance(w)) - w;
        let mut residual = left(&w);
        // Too rough to bound anything: a few plain bounces shrink what is left.
        for _ in 0..50 {
            if residual.amax() < 0.5 {
                break;
            }
            w += &residual;
            residual = left(&w);
        }
        let inverse_norm = (0..k.channels())
            .map(|c| {
                let off = residual.column(c).amax();
                let from_w = if off < 1.0 { w.column(c).max() / (1.0 - off) } else { f64::INFINITY };
                let from_norm = if norm[c] < 1.0 { relative(1.0, 1.0 - norm[c]) } else { f64::INFINITY };
                from_w.min(from_norm)
            })
            .collect();
        Self { inverse_norm, norm, certainty: Certainty::Guaranteed }
    }

    /// Whether the bounds are guaranteed.
    pub fn certainty(&self) -> Certainty {
        self.certainty
    }

    /// ‖x‖ of channel c in the norm of these bounds.
    pub(super) fn size(&self, k: &Transport, x: &DMatrix<f64>, c: usize) -> f64 {
        match self.certainty {
            Certainty::Guaranteed => x.column(c).amax(),
            Certainty::Estimated => k.mass().norm(x.column(c)),
        }
    }

    /// Bound on ‖(I − K)⁻¹‖ in channel c; infinite where none was found.
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
