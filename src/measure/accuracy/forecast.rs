//! Forecast: what other settings would cost and err.

use super::constants::{FEWEST_MORE_RAYS, HIDDEN, NOISE_POWER, PATCH_IN_RAYS, SAME_CUT, USUALLY_MERGED};
use super::goal::{AccuracyStep, Setting};
use crate::measure::error_bars::{Insight, noise_at_most};
use crate::patches::Basis;

/// What other settings would cost and err, told from one that was tried.
pub(super) struct Forecast {
    pub from: AccuracyStep,
    pub power: f64,
    /// How much is told of the mesh error of the best answer.
    pub insight: Insight,
    /// How many times more than expected noise may be by how batches differ.
    pub scatter: f64,
    /// What slack adds to the error of the best answer, and will to that of others.
    pub slack: f64,
    /// Patches and rays of the best answer.
    pub known: (f64, f64),
}

impl Forecast {
    pub fn upper95(&self, s: &Setting) -> f64 {
        let patches = s.patches / self.from.patches as f64;
        let rays = patches * s.rays / f64::from(self.from.rays);
        let mesh = self.from.mesh.hypot(HIDDEN * self.from.noise) * patches.powf(-0.5 * self.power);
        let noise = self.from.noise * rays.powf(-NOISE_POWER);
        let at_most = self.scatter * noise_at_most(s.rays as u32, self.insight.basis);
        let mut insight = self.insight;
        if !self.is_same_cut(s) {
            insight.merged = insight.merged.max(USUALLY_MERGED);
        }
        (insight.at_most() * mesh).hypot(at_most * noise) + self.slack
    }

    /// What it takes from the start.
    pub fn seconds(&self, s: &Setting) -> f64 {
        self.from.seconds * work(s.patches, s.rays)
            / work(self.from.patches as f64, f64::from(self.from.rays))
    }

    /// What it takes with what is there.
    pub fn price(&self, s: &Setting) -> f64 {
        let rays = self.more_rays(s).unwrap_or(s.rays);
        self.seconds(s) * work(s.patches, rays) / work(s.patches, s.rays)
    }

    /// Whether it is the cut of the best answer.
    fn is_same_cut(&self, s: &Setting) -> bool {
        (s.patches / self.known.0 - 1.0).abs() < SAME_CUT
    }

    /// How many rays the best answer lacks, where that is all it lacks.
    pub fn more_rays(&self, s: &Setting) -> Option<f64> {
        let more = s.rays - self.known.1;
        (self.is_same_cut(s) && more >= FEWEST_MORE_RAYS && self.insight.basis == Basis::Constant)
            .then_some(more)
    }
}

/// Seconds rise in proportion to this.
fn work(patches: f64, rays: f64) -> f64 {
    patches * (rays + PATCH_IN_RAYS)
}
