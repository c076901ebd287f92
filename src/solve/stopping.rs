//! When iterations stop: by the light that is still missing, not by the radiance of lamps.
//!
//! An answer is an irradiance H and the radiance L = E + R H/π that it causes. One more pass over the matrix
//! shows how far they are from a solution: the step s = π F L − H, and the residual r = E − (I − K) L = R
//! s/π. Since F's rows sum to at most 1, what H lacks is s + π F (I − K)⁻¹ r, with
//!
//! - ‖s + π F (I − K)⁻¹ r‖∞ ≤ ‖s‖∞ + π max w ‖r‖∞ with w = (I − K)⁻¹ 1, and
//! - its root mean square ≤ that of s + π √(max w (1 + max w)) times that of r: columns of (I − K)⁻¹,
//!   weighted by area, sum to at most 1 + max w, and ‖·‖₂ ≤ √(‖·‖₁ ‖·‖∞) (Riesz & Thorin).
//!
//! Both are *guaranteed* for constant elements. For linear ones the [`Amplification`] is that in √(∫ L² dA),
//! and the bounds are *estimates*.
//!
//! R H/π is kept apart from E throughout: beside the radiance of a tiny lamp it would lose its digits.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVectorView};

use super::goals::{Goal, Goals, flux};
use super::{Amplification, Certainty, Report, relative};
use crate::patches::Basis;
use crate::transport::Transport;

/// What rounding leaves of a step, as a part of ‖H‖∞, or of a residual, as a part of ‖R H/π‖∞.
const ROUNDING: f64 = 1e-14;

/// The same where solving for what is left makes no headway.
const NO_HEADWAY: f64 = 1e-12;

/// Irradiance below this part of its root mean square counts as dark: there errors are held against this
/// part.
const DARK: f64 = 1e-3;

/// The relative error of a patch's own irradiance that is allowed, in units of the tolerance.
const BY_PATCH: f64 = 10.0;

/// A radiance L = E + R H/π with the irradiance H, and what one more pass makes of them; all N × c.
pub(super) struct Answer {
    pub irradiance: DMatrix<f64>,
    /// R H/π.
    pub reflected: DMatrix<f64>,
    /// π F L.
    pub next: DMatrix<f64>,
    /// E − (I − K) L.
    pub residual: DMatrix<f64>,
}

/// A solver and the passes over the matrix that it took.
pub(super) struct Run {
    pub name: &'static str,
    pub iterations: usize,
}

impl Answer {
    /// The answer of this irradiance under right-hand side E.
    pub fn new(k: &Transport, e: &DMatrix<f64>, irradiance: DMatrix<f64>) -> Self {
        let reflected = k.reflect(&irradiance);
        let next = k.irradiance(&(e + &reflected));
        let residual = k.reflect(&(&next - &irradiance));
        Self { irradiance, reflected, next, residual }
    }

    /// The answer after `radiance` = E + `reflected` is all but solved.
    pub fn after(k: &Transport, e: &DMatrix<f64>, reflected: &DMatrix<f64>) -> Self {
        Self::new(k, e, k.irradiance(&(e + reflected)))
    }

    /// π F L − H.
    pub fn step(&self) -> DMatrix<f64> {
        &self.next - &self.irradiance
    }

    /// Says how good the answer is.
    pub fn judge(
        &self,
        k: &Transport,
        e: &DMatrix<f64>,
        Run { name, iterations }: Run,
        amplification: &Amplification,
    ) -> Report {
        let (radiance, step) = (e + &self.reflected, self.step());
        let channels = 0..e.ncols();
        let most = |value: &dyn Fn(usize) -> f64| channels.clone().map(value).fold(0.0, f64::max);
        let size = |x: &DMatrix<f64>, c| amplification.size(k, x, c);
        let at_most = |c| amplify(amplification.of(c), size(&self.residual, c));
        let fields = |c: usize| [&step, &self.residual].map(|x| x.column(c));
        Report {
            name,
            iterations,
            residual: most(&|c| relative(self.residual.column(c).amax(), e.column(c).amax())),
            remaining_flux: most(&|c| relative(flux(k, self.residual.column(c)), flux(k, e.column(c)))),
            bound: most(&|c| relative(at_most(c), size(&radiance, c))),
            condition: amplification.condition(),
            certainty: amplification.certainty(),
            truncated: false,
            missing: channels.clone().map(|c| missing(k, amplification, c, fields(c))).collect(),
        }
    }
}

/// The bound on the root mean square, over the mass, of what irradiance lacks in channel c after this step,
/// with this residual.
fn missing(
    k: &Transport,
    amplification: &Amplification,
    c: usize,
    [step, residual]: [DVectorView<f64>; 2],
) -> f64 {
    let root_mean_square = |x| k.mass().root_mean_square(x);
    let w = amplification.of(c);
    match amplification.certainty() {
        _ if residual.amax() == 0.0 => root_mean_square(step),
        Certainty::Estimated => root_mean_square(step) + PI * w * root_mean_square(residual),
        Certainty::Guaranteed => {
            let on_average =
                root_mean_square(step) + PI * (w * (1.0 + w)).sqrt() * root_mean_square(residual);
            on_average.min(step.amax() + PI * w * residual.amax())
        }
    }
}

/// a · b, where nothing stays nothing however it is amplified.
fn amplify(a: f64, b: f64) -> f64 {
    if b == 0.0 { 0.0 } else { a * b }
}

/// The rule by which an answer is good enough.
///
/// In every channel, with tolerance t:
///
/// - π Σ A |r| ≤ t Φ, with the flux Φ = π Σ A E that starts; of lights without area what surfaces reflect of
///   theirs, so that this is no laxer than by the flux they emit;
/// - ‖s‖∞ + π max w ‖r‖∞ ≤ t · min(H_rms, 10 max(H_min, 10⁻³ H_rms)), with the root mean square and the least
///   of H, so that no patch is off by more than t of H_rms, nor by more than 10 t of its own irradiance, or
///   of H_rms/1000 where it has less.
///
/// The series knows more: where no patch's step is more than q < 1 times its step before, all later ones come
/// to less than s q/(1 − q), patch by patch, since light only adds (Collatz 1942). Then s/(1 − q) may take
/// the place of the second bound: ≤ t · min(H_rms, 10 max(H, 10⁻³ H_rms)) on every patch.
///
/// What rounding alone leaves is good enough, too: ‖s‖∞ ≤ 10⁻¹⁴ ‖H‖∞.
pub(super) struct Rule<'a> {
    k: &'a Transport,
    amplification: &'a Amplification,
    tolerance: f64,
    /// Φ per channel.
    flux: Vec<f64>,
}

impl<'a> Rule<'a> {
    pub fn new(k: &'a Transport, e: &DMatrix<f64>, amplification: &'a Amplification, tolerance: f64) -> Self {
        let flux = e.column_iter().map(|column| flux(k, column)).collect();
        // Nothing is told of less.
        let tolerance = tolerance.max(f64::EPSILON);
        Self { k, amplification, tolerance, flux }
    }

    /// How many times too much is missing of an answer, the largest over channels; it is good enough up to 1.
    pub fn excess(&self, answer: &Answer) -> f64 {
        self.excess_of(answer, &answer.step(), None)
    }

    /// The same of a partial sum of the series, with its step to the next order and the step before that.
    pub fn excess_of(&self, answer: &Answer, step: &DMatrix<f64>, before: Option<&DMatrix<f64>>) -> f64 {
        let excess = |c: usize| {
            let [irradiance, step, residual] =
                [&answer.irradiance, step, &answer.residual].map(|field| field.column(c));
            if step.amax() <= ROUNDING * answer.next.column(c).amax() {
                return 0.0;
            }
            let lost = relative(flux(self.k, residual), self.tolerance * self.flux[c]);
            let off = step.amax() + PI * amplify(self.amplification.of(c), residual.amax());
            let off = relative(off, self.tolerance * self.yardstick(irradiance));
            let by_steps = before.map(|before| self.excess_by_steps(irradiance, [before.column(c), step]));
            lost.max(by_steps.map_or(off, |by_steps| by_steps.min(off)))
        };
        (0..self.flux.len()).map(excess).fold(0.0, f64::max)
    }

    /// How many times too much is missing by what two steps, one after the other, say of all that follow;
    /// infinite where they do not shrink.
    fn excess_by_steps(&self, irradiance: DVectorView<f64>, [before, step]: [DVectorView<f64>; 2]) -> f64 {
        let ratio = |(step, before): (&f64, &f64)| if *step > 0.0 { step / before } else { 0.0 };
        let shrinks_by = step.iter().zip(&before).map(ratio).fold(0.0, f64::max);
        let only_adds = [before, step].iter().all(|step| step.min() >= 0.0);
        if self.k.basis() == Basis::Linear || !only_adds || shrinks_by.is_nan() || shrinks_by >= 1.0 {
            return f64::INFINITY;
        }
        let typical = self.k.mass().root_mean_square(irradiance);
        let of_patch = |(step, h): (&f64, &f64)| {
            let yardstick = typical.min(BY_PATCH * h.max(DARK * typical));
            relative(step / (1.0 - shrinks_by), self.tolerance * yardstick)
        };
        step.iter().zip(&irradiance).map(of_patch).fold(0.0, f64::max)
    }

    /// Whether what is missing of an answer is rounding, once solving for it makes no headway.
    pub fn is_rounding(&self, answer: &Answer) -> bool {
        let columns = answer.next.column_iter().zip(answer.irradiance.column_iter());
        columns.into_iter().all(|(next, now)| (next - now).amax() <= NO_HEADWAY * next.amax())
    }

    /// What the residual has to fall below, told by an irradiance that is no more than the answer's.
    pub fn goals(&self, irradiance: &DMatrix<f64>) -> Goals<'a> {
        let reflected = self.k.reflect(irradiance);
        let goal = |c: usize| {
            let size =
                self.tolerance * self.yardstick(irradiance.column(c)) / (PI * self.amplification.of(c));
            Goal {
                flux: (self.tolerance * self.flux[c]).max(ROUNDING * flux(self.k, reflected.column(c))),
                size: size.max(ROUNDING * reflected.column(c).amax()),
            }
        };
        Goals::new(self.k, (0..self.flux.len()).map(goal).collect())
    }

    /// The irradiance that the tolerance is a part of.
    fn yardstick(&self, irradiance: DVectorView<f64>) -> f64 {
        let typical = self.k.mass().root_mean_square(irradiance);
        typical.min(BY_PATCH * irradiance.min().max(DARK * typical))
    }
}
