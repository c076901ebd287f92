//! Solvers: L = (I − K)⁻¹E, three ways.
//!
//! | solver | how | when |
//! |---|---|---|
//! | [`direct()`] | Cholesky factors of the symmetric form, any number of right-hand sides | up to some thousand patches |
//! | [`conjugate_gradients`] | conjugate gradients on the same form, MINRES where sheets make it indefinite | any size |
//! | [`neumann()`] | E + KE + K²E + …, a bounce of light each | to see how light builds up |
//!
//! Each takes the operator and the right-hand side E (N × c, a row per coefficient) and answers a
//! [`Solution`] that carries its own [`Report`].
//!
//! # Tolerance
//!
//! Iterations end, in every channel, when with tolerance t
//!
//! - the flux that is still on its way is small: π Σ A |r| ≤ t Φ with the residual r = E − (I − K) L and the
//!   flux Φ = π Σ A E that starts;
//! - no irradiance H lacks much: ‖π F L − H‖∞ + π max w ‖r‖∞, which bounds what H lacks anywhere
//!   ([`Amplification`]), is no more than t times the root mean square of H over all surfaces, nor than 10 t
//!   times the least H or a thousandth of that root mean square, whichever is more.
//!
//! Both are of light where it arrives: how bright a lamp is, or how small, does not matter. A tolerance that
//! rounding does not let through counts as met where ‖π F L − H‖∞ ≤ 10⁻¹⁴ ‖H‖∞. E = Lₑ + ρH₀/π has of lights
//! without area what surfaces reflect: against all that these send out, and all the irradiance they cause,
//! what is missing is a smaller part yet.

mod amplification;
mod conjugate_gradient;
mod direct;
mod goals;
mod krylov;
mod minres;
mod neumann;
mod problem;
mod stopping;
mod symmetric;
mod turns;

use nalgebra::DMatrix;

pub use amplification::{Amplification, Certainty};
pub use conjugate_gradient::{CgOptions, conjugate_gradients};
pub use direct::{Direct, DirectOptions, direct};
pub(crate) use direct::{factor_bytes, is_quick};
pub(crate) use krylov::roughly;
pub use neumann::{Bounce, NeumannOptions, Series, bounces, neumann};
pub use problem::Problem;

use crate::patches::Basis;
use crate::progress::{Cancelled, Progress};
use crate::transport::{Sources, Transport, readable};

/// Radiance and irradiance of every patch, and how good they are.
///
/// N is the number of coefficients: of patches n, or 3n for linear elements.
#[derive(Clone)]
pub struct Solution {
    /// Radiance L, N × c, W·sr⁻¹·m⁻². Row by row Lₑ + ρH/π, and on sheets τ/π times H of the other side more.
    pub radiance: DMatrix<f64>,
    /// Irradiance H, N × c, W·m⁻²: of a [`Problem`] all of it, of a solver by itself πFL, without that by
    /// lights without area.
    pub irradiance: DMatrix<f64>,
    /// How light varies over a patch.
    pub basis: Basis,
    /// How it was found.
    pub report: Report,
}

impl Solution {
    /// The same with the irradiance that `sources`, whose right-hand side was solved for, bring beside the
    /// operator.
    fn under(mut self, sources: &Sources) -> Self {
        sources.add_beside_the_operator(&mut self.irradiance);
        self
    }

    /// The means over patches, n × c.
    pub fn means(&self) -> Self {
        let [radiance, irradiance] = [&self.radiance, &self.irradiance].map(|field| self.basis.means(field));
        Self { radiance, irradiance, basis: Basis::Constant, report: self.report.clone() }
    }
}

impl std::fmt::Debug for Solution {
    /// Only the report: the numbers would fill books.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Solution").field("report", &self.report).finish_non_exhaustive()
    }
}

/// What a solver says of its answer.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Report {
    /// `direct`, `cg`, `minres` (conjugate gradients where sheets let through more than they reflect) or
    /// `neumann`.
    pub name: &'static str,
    /// Passes over the matrix; 0 for the direct solver.
    pub iterations: usize,
    /// ‖E − (I − K)L‖∞ / ‖E‖∞, recomputed from the answer; the largest over channels.
    pub residual: f64,
    /// The part of the flux that is still on its way: π Σ A |E − (I − K)L| / π Σ A E, the largest over
    /// channels.
    pub remaining_flux: f64,
    /// Bound on the relative error ‖error‖ / ‖L‖ for this operator, the largest over channels. For constant
    /// elements the norm is ‖·‖∞, for linear ones it is √(∫ L² dA).
    pub bound: f64,
    /// Bound on the condition number ‖I − K‖ ‖(I − K)⁻¹‖ in the same norm, the largest over channels.
    pub condition: f64,
    /// Whether these two bounds are guaranteed.
    pub certainty: Certainty,
    /// Whether this is a series that ended at its highest order before it met the tolerance.
    pub truncated: bool,
    /// Bound on what the irradiance lacks, as root mean square over all surfaces (by area; by étendue where
    /// that differs), per channel, W·m⁻². As certain as the other bounds.
    #[serde(skip)]
    pub missing: Vec<f64>,
}

/// Why there is no solution.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// The matrix of the direct solver would not fit.
    #[error(
        "factoring {n} patches directly takes {}, more than the {} allowed; raise --memory, or use --solver cg",
        readable(*needed), readable(*limit)
    )]
    Memory {
        /// Number of patches.
        n: usize,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// The symmetric matrix turned out not to be positive definite, or quasi-definite with sheets.
    #[error(
        "the matrix is singular to working precision at patch {patch}; some reflectance, or its sum with a transmittance, is too close to 1 for a scene so closed"
    )]
    Singular {
        /// The patch at which factorization stopped.
        patch: usize,
    },
    /// The tolerance was not met.
    #[error(
        "{} did not meet tolerance {tolerance:.1e} in {} iterations ({:.1e} of the flux is still on its way); raise --tolerance, or use --solver direct",
        best.report.name, best.report.iterations, best.report.remaining_flux
    )]
    NotConverged {
        /// The best that was found.
        best: Box<Solution>,
        /// What was asked for.
        tolerance: f64,
    },
    /// Light is not finite: what lamps emit is too much for numbers, or reflectances leave the matrix all but
    /// singular.
    #[error(
        "the light of patch {patch} is not a finite number; lower what lamps emit, or reflectances too close to 1"
    )]
    NotFinite {
        /// The first such patch.
        patch: usize,
    },
    /// The observer asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl SolveError {
    /// The same with the irradiance by lights without area in the best that was found.
    fn under(self, sources: &Sources) -> Self {
        match self {
            Self::NotConverged { best, tolerance } => {
                Self::NotConverged { best: Box::new(best.under(sources)), tolerance }
            }
            other => other,
        }
    }
}

/// Which solver to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Direct where its factors fit and take a second or two, else conjugate gradients.
    #[default]
    Auto,
    /// [`direct()`].
    Direct,
    /// [`conjugate_gradients`].
    ConjugateGradients,
    /// [`neumann()`].
    Neumann,
}

/// What every solver can be asked for.
#[derive(Clone, Copy, Debug)]
pub struct SolveOptions<'a> {
    /// Which solver to take.
    pub method: Method,
    /// The [tolerance](self#tolerance) of the iterative ones.
    pub tolerance: f64,
    /// The highest order of the series.
    pub order: usize,
    /// The most bytes the direct solver's factors may take.
    pub memory: u64,
    /// What [`Amplification::new`] says of the operator, where that is known already.
    pub amplification: Option<&'a Amplification>,
    /// Where to report progress.
    pub progress: Progress<'a>,
}

impl Default for SolveOptions<'_> {
    /// The automatic choice, a tolerance of 10⁻⁶, order 1000, 4 GiB.
    fn default() -> Self {
        let (NeumannOptions { order, tolerance, .. }, DirectOptions { memory, .. }) = Default::default();
        Self {
            method: Method::Auto,
            tolerance,
            order,
            memory,
            amplification: None,
            progress: Progress::default(),
        }
    }
}

/// Solves L = E + K L by the method of the options.
///
/// # Errors
/// As the solver's own.
///
/// # Panics
/// If `e` is not N × c.
pub fn solve(k: &Transport, e: &DMatrix<f64>, options: &SolveOptions) -> Result<Solution, SolveError> {
    solve_all(k, &[e], options).map(|mut solutions| solutions.remove(0))
}

/// Solves L = E + K L for several right-hand sides; the direct solver factors once for all.
fn solve_all(
    k: &Transport,
    right_hand_sides: &[&DMatrix<f64>],
    options: &SolveOptions,
) -> Result<Vec<Solution>, SolveError> {
    let &SolveOptions { tolerance, order, memory, amplification, progress, .. } = options;
    let all = right_hand_sides.iter();
    let cg = CgOptions { tolerance, amplification, progress, ..Default::default() };
    let series = NeumannOptions { order, tolerance, amplification, progress };
    match options.method {
        Method::Neumann => all.map(|e| Ok(neumann(k, e, &series)?.solution)).collect(),
        Method::Auto if !direct::is_quick(k, memory) => all.map(|e| conjugate_gradients(k, e, &cg)).collect(),
        Method::ConjugateGradients => all.map(|e| conjugate_gradients(k, e, &cg)).collect(),
        Method::Auto | Method::Direct => {
            let factored = direct(k, &DirectOptions { memory, progress })?;
            progress.at("solve", 0.0)?;
            all.map(|e| {
                check_finite(k, e)?;
                let solution = factored.solve(e);
                check_finite(k, &solution.radiance).map(|()| solution)
            })
            .collect()
        }
    }
}

/// Makes sure that light is finite.
fn check_finite(k: &Transport, light: &DMatrix<f64>) -> Result<(), SolveError> {
    let each = k.basis().coefficients();
    let odd = |light: &f64| !light.is_finite();
    let patch = light.column_iter().find_map(|column| column.iter().position(odd)).map(|i| i / each);
    patch.map_or(Ok(()), |patch| Err(SolveError::NotFinite { patch }))
}

/// a / b, where nothing of nothing is nothing.
fn relative(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}
