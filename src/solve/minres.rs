//! MINRES on the symmetric form where it is indefinite (Paige & Saunders 1975).
//!
//! Where a sheet lets through more than it reflects, y = J Rᵀ S L solves (J − Rᵀ S R) y = Rᵀ S E, symmetric
//! but not definite. Lanczos' vectors v make the matrix tridiagonal, rotations make that triangular, and of
//! all y in the space that they span the one with the least residual r follows step by step;
//! r_k = s² r_(k−1) + η c v_(k+1), with the rotation (c, s) of the step and |η| = ‖r_k‖, needs no product of
//! its own. All channels go through the matrix in one pass.

use nalgebra::{DMatrix, DVector};

use super::SolveError;
use super::goals::{Goals, Limits};
use super::symmetric::Root;

/// What a channel carries from step to step.
struct Channel {
    /// Lanczos' vectors v of this step and the last.
    v: [DVector<f64>; 2],
    /// Directions of the last two steps, the newer first.
    w: [DVector<f64>; 2],
    y: DVector<f64>,
    r: DVector<f64>,
    /// The entry of the tridiagonal matrix beside its diagonal.
    beta: f64,
    eta: f64,
    /// Rotations (c, s) of the last two steps, the newer first.
    rotations: [[f64; 2]; 2],
}

impl Channel {
    fn new(b: DVector<f64>) -> Self {
        let (zero, length) = (DVector::zeros(b.len()), b.norm());
        let v = if length > 0.0 { &b / length } else { zero.clone() };
        Self {
            v: [v, zero.clone()],
            w: [zero.clone(), zero.clone()],
            y: zero,
            r: b,
            beta: 0.0,
            eta: length,
            rotations: [[1.0, 0.0]; 2],
        }
    }

    /// One step, with the product q of the matrix with v.
    fn step(&mut self, mut q: DVector<f64>) {
        let [v, before] = &self.v;
        // The next of Lanczos' vectors.
        let alpha = v.dot(&q);
        q.axpy(-alpha, v, 1.0);
        q.axpy(-self.beta, before, 1.0);
        let next = q.norm();
        // Bring the new column of the tridiagonal matrix to triangular form.
        let [[c, s], [c_before, s_before]] = self.rotations;
        let above = c * alpha - c_before * s * self.beta;
        let diagonal = above.hypot(next);
        let [first, second] = [s_before * self.beta, s * alpha + c_before * c * self.beta];
        if diagonal == 0.0 {
            // The matrix is singular on this space, and y the best there is.
            self.eta = 0.0;
            return;
        }
        let [c, s] = [above / diagonal, next / diagonal];
        // The next direction, and the best y and residual.
        let mut w = v.clone();
        w.axpy(-first, &self.w[1], 1.0);
        w.axpy(-second, &self.w[0], 1.0);
        w /= diagonal;
        self.y.axpy(c * self.eta, &w, 1.0);
        self.eta *= -s;
        q *= if next > 0.0 { 1.0 / next } else { 0.0 };
        self.r *= s * s;
        self.r.axpy(self.eta * c, &q, 1.0);
        self.rotations = [[c, s], self.rotations[0]];
        self.beta = next;
        self.w.swap(0, 1);
        self.w[0] = w;
        self.v.swap(0, 1);
        self.v[0] = q;
    }
}

/// Iterates until the residual of L = E + R y meets the goals; answers R y and the number of passes, that for
/// `through` = S E among them.
pub(super) fn iterate(
    root: &Root,
    through: &DMatrix<f64>,
    goals: Goals,
    limits: Limits,
) -> Result<(DMatrix<f64>, usize), SolveError> {
    let b = root.transposed_times(through);
    let mut channels: Vec<Channel> =
        b.column_iter().map(|column| Channel::new(column.clone_owned())).collect();
    let gathered = |channels: &[Channel], part: fn(&Channel) -> &DVector<f64>| {
        DMatrix::from_columns(&channels.iter().map(|channel| part(channel).clone()).collect::<Vec<_>>())
    };
    // The residual of L is R J r.
    let residual = |channels: &[Channel]| {
        let mut r = gathered(channels, |channel| &channel.r);
        root.sign(&mut r);
        root.times(&r)
    };
    let mut goals = goals.starting_from(&residual(&channels));
    let mut through = DMatrix::zeros(b.nrows(), b.ncols());
    let mut passes = 1;
    while passes < limits.passes {
        let excesses = goals.excesses(&residual(&channels));
        let goes_on = |(c, channel): (usize, &Channel)| excesses[c] > 1.0 && channel.eta != 0.0;
        if !channels.iter().enumerate().any(goes_on) {
            break;
        }
        goals.report(&excesses, limits.progress)?;
        // q = (J − RᵀSR) v
        let mut v = gathered(&channels, |channel| &channel.v[0]);
        root.operator().through(&root.times(&v), &mut through);
        passes += 1;
        root.sign(&mut v);
        let q = v - root.transposed_times(&through);
        for (c, channel) in channels.iter_mut().enumerate() {
            if excesses[c] > 1.0 && channel.eta != 0.0 {
                channel.step(q.column(c).clone_owned());
            }
        }
    }
    Ok((root.times(&gathered(&channels, |channel| &channel.y)), passes))
}
