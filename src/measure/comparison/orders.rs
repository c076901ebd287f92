//! Orders: the Neumann series, order by order, against the direct solution and the reference.
//!
//! Order k of irradiance is H_k = h_0 + … + h_{k−1} with h_j = πF KʲE; what is missing is T = h_k + h_{k+1} +
//! … Two *guaranteed* bounds are known at order k, and the smaller is told:
//!
//! - all h ≥ 0 and K ≥ 0, so h_{k−1} ≤ θ h_{k−2} everywhere implies h_j ≤ θ h_{j−1} for all that follow, and
//!   T ≤ θ/(1−θ) h_{k−1};
//! - ‖T‖∞ ≤ π ‖(I−K)⁻¹‖∞ ‖KᵏE‖∞, with [`Amplification`].
//!
//! Of linear elements, whose K has negative entries, only the second is known, in the norm √(∫ T² dA), and it
//! is an *estimate*.

use std::f64::consts::PI;
use std::time::Instant;

use nalgebra::DMatrix;

use super::Difference;
use crate::measure::MeasureError;
use crate::patches::Basis;
use crate::progress::Progress;
use crate::reference::PathTraced;
use crate::solve::{Amplification, Problem};
use crate::transport::Transport;

/// How far to sum the series.
#[derive(Clone, Copy, Debug)]
pub struct OrderOptions<'a> {
    /// The order is the last when its bound falls below this.
    pub tolerance: f64,
    /// The highest order.
    pub order: usize,
    /// Where to report progress, as stage `series`.
    pub progress: Progress<'a>,
}

impl Default for OrderOptions<'_> {
    /// A bound of 10⁻⁶, order 1000 at most.
    fn default() -> Self {
        Self { tolerance: 1e-6, order: 1000, progress: Progress::default() }
    }
}

/// The series truncated at one order.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderRow {
    /// k.
    pub order: usize,
    /// Relative root mean square difference of irradiance from the direct solution, over all surfaces.
    pub vs_direct: f64,
    /// Difference of irradiance from the reference, by patch.
    pub vs_reference: Difference,
    /// Bound on `vs_direct` known at this order, *guaranteed* for constant elements and *estimated* for
    /// linear ones; infinite where there is none.
    pub bound: f64,
    /// Time for all orders up to this one, seconds.
    pub seconds: f64,
}

impl OrderRow {
    /// Sums a problem's series until its bound is small enough, comparing each order's irradiance with
    /// the direct solution's (N × c) and, by patch, with the reference.
    ///
    /// # Errors
    /// `Cancelled`.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn all(
        problem: &Problem,
        direct: &DMatrix<f64>,
        reference: &PathTraced,
        amplification: &Amplification,
        options: &OrderOptions,
    ) -> Result<Vec<Self>, MeasureError> {
        let k = problem.operator();
        let mut series = Irradiances::new(problem, amplification);
        let norm = root_mean_square(k, direct);
        let relative = |x: f64| if x == 0.0 { 0.0 } else { x / norm };
        let mut rows: Vec<Self> = Vec::new();
        let mut seconds = 0.0;
        loop {
            let began = Instant::now();
            let bound = relative(series.bound());
            seconds += began.elapsed().as_secs_f64();
            let vs_direct = relative(root_mean_square(k, &(&series.sum - direct)));
            let vs_reference = Difference::new(&k.basis().means(&series.sum), reference);
            rows.push(Self { order: rows.len(), vs_direct, vs_reference, bound, seconds });
            if bound <= options.tolerance || rows.len() > options.order {
                break;
            }
            let done = (bound.min(1.0).ln() / options.tolerance.ln()).clamp(0.0, 0.99);
            options.progress.at("series", done)?;
            let began = Instant::now();
            series.advance();
            seconds += began.elapsed().as_secs_f64();
        }
        options.progress.at("series", 1.0)?;
        Ok(rows)
    }
}

/// The series of irradiances: h_0, h_1, … and their sum so far.
struct Irradiances<'k> {
    k: &'k Transport,
    amplification: &'k Amplification,
    /// What order 1 brings beside the operator, until it does.
    of_order_1: Option<&'k DMatrix<f64>>,
    /// KᵏE.
    term: DMatrix<f64>,
    /// H_k.
    sum: DMatrix<f64>,
    /// h_{k−1} and h_{k−2}, as far as there are such.
    last: Option<DMatrix<f64>>,
    before: Option<DMatrix<f64>>,
}

impl<'k> Irradiances<'k> {
    fn new(problem: &'k Problem, amplification: &'k Amplification) -> Self {
        let (k, sources, term) = (problem.operator(), problem.sources(), problem.order_0());
        let sum = sources.direct.clone().unwrap_or_else(|| DMatrix::zeros(term.nrows(), term.ncols()));
        let of_order_1 = sources.bright.as_ref().map(|bright| &bright.correction);
        Self { k, amplification, of_order_1, term, sum, last: None, before: None }
    }

    fn advance(&mut self) {
        let mut h = self.k.irradiance(&self.term);
        if let Some(correction) = self.of_order_1.take() {
            h += correction;
        }
        self.term = self.k.reflect(&h);
        self.sum += &h;
        self.before = self.last.replace(h);
    }

    /// Bound on the root mean square over patches and channels, area-weighted, of what is missing.
    fn bound(&self) -> f64 {
        let channels = 0..self.term.ncols();
        if self.k.basis() == Basis::Linear {
            let norms = mean_squares(self.k, &self.term);
            return channels.map(|c| (PI * self.amplification.of(c)).powi(2) * norms[c]).sum::<f64>().sqrt();
        }
        let uniform: f64 = channels
            .clone()
            .map(|c| match self.term.column(c).amax() {
                0.0 => 0.0,
                most => (PI * self.amplification.of(c) * most).powi(2),
            })
            .sum::<f64>();
        let (Some(last), Some(before)) = (&self.last, &self.before) else { return uniform.sqrt() };
        let norms = mean_squares(self.k, last);
        let geometric = channels.map(|c| {
            let ratios = last
                .column(c)
                .zip_map(&before.column(c), |now, then| if now == 0.0 { 0.0 } else { now / then });
            match ratios.max() {
                theta if theta < 1.0 => (theta / (1.0 - theta)).powi(2) * norms[c],
                _ => f64::INFINITY,
            }
        });
        uniform.min(geometric.sum()).sqrt()
    }
}

/// Σ over channels of the area-weighted mean square, its root.
fn root_mean_square(k: &Transport, field: &DMatrix<f64>) -> f64 {
    mean_squares(k, field).iter().sum::<f64>().sqrt()
}

/// Area-weighted mean square per channel.
fn mean_squares(k: &Transport, field: &DMatrix<f64>) -> Vec<f64> {
    let whole = k.mass().sums().sum();
    field.column_iter().map(|column| k.mass().norm(column).powi(2) / whole).collect()
}
