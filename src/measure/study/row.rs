//! Row: what one way of solving took, and how far its answer is from the reference.

use serde::{Deserialize, Serialize};

use super::constants::{LIMIT, RESOLVED};
use super::grid::Cell;

/// How irradiance was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StudySolver {
    /// Cholesky factors.
    Direct,
    /// Conjugate gradients, to a tolerance of 10⁻⁶.
    Cg,
    /// The Neumann series, truncated.
    Neumann,
    /// Light paths, without patches or form factors.
    Paths,
}

/// One way of solving: its settings, its price and its error. A row of `study.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyRow {
    /// Number of patches; for light paths the number of faces' sides.
    pub patches: usize,
    /// Rays per patch; for light paths the mean number of paths per side of a face.
    pub rays: u32,
    /// How it was solved.
    pub solver: StudySolver,
    /// Order at which the series was truncated; none of other solvers.
    pub order: Option<usize>,
    /// Wall-clock time from the mesh to irradiance, the median over repeats: cutting, tracing, balancing and
    /// solving.
    pub seconds: f64,
    /// Bytes that the operator takes, with factors where there are any.
    pub bytes: u64,
    /// Area-weighted relative root mean square error of irradiance by face, the reference's noise taken off;
    /// over all repeats.
    pub error: f64,
    /// Standard error of `error`: by the reference's noise and the spread between repeats.
    pub error_se: f64,
    /// ΣA d / ΣA H over all repeats: how much too bright all faces together are.
    pub bias: f64,
    /// Light on sides of faces that no light path reaches, as a part of all light.
    pub leak: f64,
    /// The part of `seconds` that solving took.
    pub solve_seconds: f64,
    /// Passes over the matrix; 0 of the direct solver and of light paths.
    pub iterations: usize,
    /// How often it was measured, with other random numbers each time.
    pub repeats: usize,
    /// The number of patches that was asked for; 0 for light paths.
    pub asked: usize,
}

/// What can be said of an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// It stands out from the reference's noise.
    Resolved(f64),
    /// It does not; it is no larger than this.
    Below(f64),
}

impl Reading {
    /// The error, or what it is no larger than.
    pub fn most(self) -> f64 {
        match self {
            Self::Resolved(error) => error,
            Self::Below(limit) => limit,
        }
    }
}

impl StudyRow {
    /// The error as far as it is known: three standard errors make a limit where two hide the error itself.
    pub fn reading(&self) -> Reading {
        if self.error > RESOLVED * self.error_se {
            Reading::Resolved(self.error)
        } else {
            Reading::Below(self.error + LIMIT * self.error_se)
        }
    }

    /// The cell of the grid that it belongs to; none of light paths.
    pub fn cell(&self) -> Option<Cell> {
        (self.solver != StudySolver::Paths).then_some(Cell { patches: self.asked, rays: self.rays })
    }

    /// Whether the matrix was solved to the end, so that only patches and rays are to blame.
    pub fn is_converged(&self) -> bool {
        matches!(self.solver, StudySolver::Direct | StudySolver::Cg)
    }
}

/// Seconds that it took to measure these rows, repeats and all.
pub(super) fn spent(rows: &[StudyRow]) -> f64 {
    let mut before: Option<Cell> = None;
    let mut sum = 0.0;
    for row in rows {
        let repeats = row.repeats as f64;
        // The rows of a cell follow one another and share all but solving.
        let shared = row.cell().is_some() && row.cell() == before;
        sum += repeats * if shared { row.solve_seconds } else { row.seconds };
        before = row.cell();
    }
    sum
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A row of conjugate gradients.
    pub fn row(patches: usize, rays: u32, seconds: f64, error: f64) -> StudyRow {
        StudyRow {
            patches,
            rays,
            solver: StudySolver::Cg,
            order: None,
            seconds,
            bytes: 1000,
            error,
            error_se: 0.01 * error,
            bias: 0.0,
            leak: 0.0,
            solve_seconds: 0.1 * seconds,
            iterations: 10,
            repeats: 2,
            asked: patches,
        }
    }

    #[test]
    fn the_rows_of_a_cell_share_what_comes_before_solving() {
        let series = StudyRow { solver: StudySolver::Neumann, order: Some(1), ..row(128, 16, 1.0, 0.1) };
        let rows = [row(128, 16, 1.0, 0.1), series.clone(), row(128, 64, 2.0, 0.1)];
        assert!((spent(&rows) - 2.0 * (1.0 + 0.1 + 2.0)).abs() < 1e-12);
        let paths = StudyRow { solver: StudySolver::Paths, repeats: 1, ..series };
        assert!((spent(&[paths.clone(), paths]) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn an_error_within_the_noise_is_a_limit() {
        let noisy = StudyRow { error_se: 0.06, ..row(128, 16, 1.0, 0.1) };
        assert_eq!(noisy.reading(), Reading::Below(0.1 + 0.18));
        assert_eq!(row(128, 16, 1.0, 0.1).reading(), Reading::Resolved(0.1));
    }
}
