//! Goals: what iterations bring a residual down to.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVectorView};

use super::relative;
use crate::progress::{Cancelled, Progress};
use crate::transport::Transport;

/// Conjugate gradients and their like reduce a residual by so much at a time: what they say of their own
/// residual holds no longer.
const AT_A_TIME: f64 = 1e-10;

/// What the residual of one channel has to fall below.
pub(super) struct Goal {
    /// π Σ A |r|.
    pub flux: f64,
    /// ‖r‖∞.
    pub size: f64,
}

/// After how many passes over the matrix iterations end in any case, and who is told how far they are.
#[derive(Clone, Copy)]
pub(super) struct Limits<'a> {
    pub passes: usize,
    pub progress: Progress<'a>,
}

/// What the residual of L has to fall below in every channel.
pub(super) struct Goals<'a> {
    k: &'a Transport,
    by_channel: Vec<Goal>,
    /// How many times too large the worst was at first.
    at_start: Option<f64>,
}

impl<'a> Goals<'a> {
    /// One goal per channel.
    pub fn new(k: &'a Transport, by_channel: Vec<Goal>) -> Self {
        Self { k, by_channel, at_start: None }
    }

    /// This part of what E is, both in flux and in ‖·‖∞.
    pub fn relative(k: &'a Transport, e: &DMatrix<f64>, tolerance: f64) -> Self {
        let goal = |column: DVectorView<f64>| Goal {
            flux: tolerance * flux(k, column),
            size: tolerance * column.amax(),
        };
        Self::new(k, e.column_iter().map(|column| goal(column.as_view())).collect())
    }

    /// How many times too large a residual is, per channel; up to 1 it is small enough.
    pub fn excesses(&self, residual: &DMatrix<f64>) -> Vec<f64> {
        let excess = |(goal, r): (&Goal, DVectorView<f64>)| {
            relative(flux(self.k, r), goal.flux).max(relative(r.amax(), goal.size))
        };
        self.by_channel
            .iter()
            .zip(residual.column_iter())
            .map(|(goal, r)| excess((goal, r.as_view())))
            .collect()
    }

    /// Lets iterations that start from this residual reduce it no further than they can tell.
    pub fn starting_from(mut self, residual: &DMatrix<f64>) -> Self {
        for (goal, r) in self.by_channel.iter_mut().zip(residual.column_iter()) {
            goal.flux = goal.flux.max(AT_A_TIME * flux(self.k, r));
            goal.size = goal.size.max(AT_A_TIME * r.amax());
        }
        self
    }

    /// Tells how much of the way is gone, on a logarithmic scale.
    pub fn report(&mut self, excesses: &[f64], progress: Progress) -> Result<(), Cancelled> {
        let worst = excesses.iter().copied().fold(1.0, f64::max);
        let at_start = *self.at_start.get_or_insert(worst);
        progress.at("solve", (1.0 - worst.ln() / at_start.ln().max(f64::MIN_POSITIVE)).clamp(0.0, 0.99))
    }
}

/// π Σ A |x|.
pub(super) fn flux(k: &Transport, x: DVectorView<f64>) -> f64 {
    PI * x.iter().zip(k.mass().sums()).map(|(x, area)| area * x.abs()).sum::<f64>()
}
