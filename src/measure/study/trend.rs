//! Trend: how error falls when one knob is turned and all others stay.
//!
//! Error ∝ xˢ is a straight line in logarithms. It is fitted to the stretch on which turning the knob still
//! helps; where something else rules, error stays as it is, and a slope through that would mean nothing.

use serde::Serialize;

use super::constants::{HELPS, HELPS_PER};
use super::row::{Reading, StudyRow};

/// A power law with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slope {
    /// s of error ∝ xˢ.
    pub slope: f64,
    /// Its standard error: by the scatter about the line or by the errors' own, whichever is larger.
    pub standard_error: f64,
    /// Error at x = 1.
    pub at_one: f64,
    /// Number of values that it was fitted to.
    pub points: usize,
}

impl Slope {
    /// The law at x.
    pub fn at(&self, x: f64) -> f64 {
        self.at_one * x.powf(self.slope)
    }

    /// The least squares line through (x, y, standard error of y) in logarithms; none through fewer than
    /// three points, or where all x are the same.
    pub fn fit(points: &[[f64; 3]]) -> Option<Self> {
        let sound = |p: &&[f64; 3]| p[0] > 0.0 && p[1] > 0.0 && p.iter().all(|x| x.is_finite());
        let logs: Vec<[f64; 3]> =
            points.iter().filter(sound).map(|&[x, y, se]| [x.ln(), y.ln(), se / y]).collect();
        let n = logs.len() as f64;
        let mean = |k: usize| logs.iter().map(|p| p[k]).sum::<f64>() / n;
        let (x, y) = (mean(0), mean(1));
        let spread: f64 = logs.iter().map(|p| (p[0] - x).powi(2)).sum();
        if logs.len() < 3 || spread <= 0.0 {
            return None;
        }
        let slope = logs.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>() / spread;
        let scatter: f64 = logs.iter().map(|p| (p[1] - y - slope * (p[0] - x)).powi(2)).sum();
        let by_scatter = (scatter / (n - 2.0) / spread).sqrt();
        let by_errors = logs.iter().map(|p| ((p[0] - x) * p[2]).powi(2)).sum::<f64>().sqrt() / spread;
        let at_one = (y - slope * x).exp();
        Some(Self { slope, standard_error: by_scatter.max(by_errors), at_one, points: logs.len() })
    }
}

/// Error against one knob.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trend {
    /// The value of the other knob.
    pub other: usize,
    /// Numbers of the rows, by ascending value of the knob.
    pub rows: Vec<usize>,
    /// The power law of the stretch on which the knob helps; none if that has fewer than three values.
    pub slope: Option<Slope>,
    /// The value from which on the knob hardly helps any more, if there is one.
    pub enough: Option<usize>,
}

impl Trend {
    /// Of rows with ascending values of a knob.
    pub(super) fn new(
        all: &[StudyRow],
        rows: Vec<usize>,
        other: usize,
        value: fn(&StudyRow) -> usize,
    ) -> Self {
        let helped = |pair: &[usize]| {
            let [before, after] = [&all[pair[0]], &all[pair[1]]];
            let factor = value(after) as f64 / value(before).max(1) as f64;
            // What is within the noise may have fallen.
            match after.reading() {
                Reading::Resolved(error) => {
                    before.reading().most() > error * HELPS.powf(factor.ln() / HELPS_PER.ln())
                }
                Reading::Below(_) => true,
            }
        };
        let falling = 1 + rows.windows(2).take_while(|pair| helped(pair)).count();
        let points: Vec<[f64; 3]> = rows
            .iter()
            .take(falling)
            .map(|&k| &all[k])
            .filter(|row| matches!(row.reading(), Reading::Resolved(_)))
            .map(|row| [value(row) as f64, row.error, row.error_se])
            .collect();
        let enough = (falling < rows.len()).then(|| value(&all[rows[falling - 1]]));
        Self { other, slope: Slope::fit(&points), enough, rows }
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::tests::row;
    use super::*;

    #[test]
    fn a_power_law_is_found_with_its_exponent() {
        let points = [1.0f64, 4.0, 16.0, 64.0].map(|x| [x, 0.3 * x.powf(-0.6), 0.0]);
        let found = Slope::fit(&points).unwrap();
        assert!((found.slope + 0.6).abs() < 1e-12 && (found.at_one - 0.3).abs() < 1e-12);
        assert!(found.standard_error < 1e-12 && (found.at(16.0) - points[2][1]).abs() < 1e-12);
        assert_eq!(Slope::fit(&points[..2]), None);
        assert_eq!(Slope::fit(&[[2.0, 0.1, 0.0]; 4]), None);
        // One standard error of 10 % each: Σ(x − x̄)² of four steps of ln 4 is 5 ln² 4.
        let uncertain = points.map(|[x, y, _]| [x, y, 0.1 * y]);
        let expected = 0.1 / (5f64.sqrt() * 4f64.ln());
        assert!((Slope::fit(&uncertain).unwrap().standard_error - expected).abs() < 1e-12);
    }

    #[test]
    fn where_a_knob_no_longer_helps_the_slope_ends() {
        let errors = [0.08, 0.04, 0.02, 0.019, 0.0185];
        let rows: Vec<StudyRow> = (0..5).map(|k| row(100, 16 << (2 * k), 1.0, errors[k as usize])).collect();
        let trend = Trend::new(&rows, (0..5).collect(), 100, |row| row.rays as usize);
        assert_eq!(trend.enough, Some(256));
        let slope = trend.slope.unwrap();
        assert!((slope.slope + 0.5).abs() < 1e-9 && slope.points == 3);
        let falling = Trend::new(&rows, vec![0, 1, 2], 100, |row| row.rays as usize);
        assert_eq!(falling.enough, None);
    }
}
