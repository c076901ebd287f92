//! Solvers: L = (I − K)⁻¹E, three ways.
//!
//! | solver | how | when |
//! |---|---|---|
//! | [`direct()`] | Cholesky factors of the symmetric form, any number of right-hand sides | up to some thousand patches |
//! | [`conjugate_gradients`] | conjugate gradients on the same form, MINRES where sheets make it indefinite | any size |
//! | [`neumann()`] | E + KE + K²E + …, a bounce of light each | to see how light builds up |
//!
//! Each takes the operator and the right-hand side E (N × c, a row per coefficient) and answers a [`Solution`] that carries its own [`Report`].

mod amplification;
mod conjugate_gradient;
mod direct;
mod minres;
mod neumann;
mod symmetric;
mod turns;

use nalgebra::DMatrix;

pub use amplification::{Amplification, Certainty};
pub(crate) use conjugate_gradient::roughly;
pub use conjugate_gradient::{CgOptions, conjugate_gradients};
pub use direct::{Direct, DirectOptions, direct};
pub(crate) use direct::{factor_bytes, is_quick};
pub use neumann::{Bounce, NeumannOptions, Series, bounces, neumann};

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
    /// Irradiance H, N × c, W·m⁻²; less that by lights without area where [`Solution::under`] has not added it.
    pub irradiance: DMatrix<f64>,
    /// How it was found.
    pub report: Report,
}

impl Solution {
    /// The solution under the lights of `sources` whose right-hand side was solved for: solvers find πFL, and lights without area
    /// add H₀ to it.
    ///
    /// # Panics
    /// If the sources are not of as many coefficients and channels.
    pub fn under(mut self, sources: &Sources) -> Self {
        if let Some(direct) = &sources.direct {
            self.irradiance += direct;
        }
        self
    }

    /// The means over patches, n × c, of a solution by coefficients of this basis.
    pub fn means(self, basis: Basis) -> Self {
        match basis {
            Basis::Constant => self,
            Basis::Linear => {
                let (radiance, irradiance) = (basis.means(&self.radiance), basis.means(&self.irradiance));
                Self { radiance, irradiance, report: self.report }
            }
        }
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
    /// `direct`, `cg`, `minres` (conjugate gradients where sheets let through more than they reflect) or `neumann`.
    pub name: &'static str,
    /// Passes over the matrix; 0 for the direct solver.
    pub iterations: usize,
    /// ‖E − (I − K)L‖∞ / ‖E‖∞, recomputed from the answer; the largest over channels.
    pub residual: f64,
    /// Bound on the relative error ‖error‖ / ‖L‖ for this operator, the largest over channels. For constant elements the norm
    /// is ‖·‖∞, for linear ones it is √(∫ L² dA).
    pub bound: f64,
    /// Bound on the condition number ‖I − K‖ ‖(I − K)⁻¹‖ in the same norm, the largest over channels.
    pub condition: f64,
    /// Whether these two bounds are guaranteed.
    pub certainty: Certainty,
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
        "{} did not reach residual {tolerance:.1e} in {} iterations (it stands at {:.1e}); raise --tolerance, or use --solver direct",
        best.report.name, best.report.iterations, best.report.residual
    )]
    NotConverged {
        /// The best that was found.
        best: Box<Solution>,
        /// What was asked for.
        tolerance: f64,
    },
    /// The observer asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
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
    /// Relative residual of the iterative ones.
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
    /// The automatic choice, a residual of 10⁻⁶, order 1000, 4 GiB.
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
///
/// # Errors
/// As the solver's own.
///
/// # Panics
/// If some right-hand side is not N × c.
pub fn solve_all(
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
            Ok(all.map(|e| factored.solve(e)).collect())
        }
    }
}

/// One fixed-point step from radiance `l`: the irradiance it causes, and the radiance that this irradiance causes.
fn bounce(k: &Transport, e: &DMatrix<f64>, l: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let irradiance = k.irradiance(l);
    let radiance = e + k.reflect(&irradiance);
    (irradiance, radiance)
}

/// Makes a solution of a radiance that is all but solved: takes one more step, so that radiance and irradiance belong
/// together row by row, and judges what comes out by its true residual.
fn finish(
    k: &Transport,
    e: &DMatrix<f64>,
    radiance: &DMatrix<f64>,
    (name, iterations): (&'static str, usize),
    amplification: &Amplification,
) -> Solution {
    let (irradiance, radiance) = bounce(k, e, radiance);
    let (_, next) = bounce(k, e, &radiance);
    let report = judge(k, (name, iterations), e, &radiance, &(next - &radiance), amplification);
    Solution { radiance, irradiance, report }
}

/// Judges radiance `l` by its residual r = E − (I − K)L.
fn judge(
    k: &Transport,
    (name, iterations): (&'static str, usize),
    e: &DMatrix<f64>,
    l: &DMatrix<f64>,
    r: &DMatrix<f64>,
    amplification: &Amplification,
) -> Report {
    let bound = (0..e.ncols())
        .map(|c| {
            let size = |x: &DMatrix<f64>| amplification.size(k, x, c);
            relative(amplification.of(c) * size(r), size(l))
        })
        .fold(0.0, f64::max);
    Report {
        name,
        iterations,
        residual: relative_residual(r, e),
        bound,
        condition: amplification.condition(),
        certainty: amplification.certainty(),
    }
}

/// max over channels of ‖r‖∞ / ‖e‖∞.
fn relative_residual(r: &DMatrix<f64>, e: &DMatrix<f64>) -> f64 {
    (0..e.ncols()).map(|c| relative(r.column(c).amax(), e.column(c).amax())).fold(0.0, f64::max)
}

/// a / b, where nothing of nothing is nothing.
fn relative(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}
