//! Lanczos' method (1950): the ends of a symmetric matrix' spectrum from a few products with it.

use nalgebra::DMatrix;

/// Products after which the estimate must do.
const MOST_STEPS: usize = 64;

/// Steps between two looks at how far it has come.
const LOOK: usize = 8;

/// It is far enough when an end's distance from 1 changes by less than this share of itself between two
/// looks.
const SETTLED: f64 = 0.2;

/// The least and the greatest eigenvalue of a symmetric matrix per column of `start`, from inside:
/// *estimated*. `apply` is the product with the matrix; all columns of `start` go through it in one pass.
///
/// # Errors
/// Those of `apply`.
pub(crate) fn ends_of_spectrum<E>(
    start: DMatrix<f64>,
    mut apply: impl FnMut(&DMatrix<f64>) -> Result<DMatrix<f64>, E>,
) -> Result<Vec<[f64; 2]>, E> {
    let (n, columns) = start.shape();
    let mut now = start;
    let mut before = DMatrix::zeros(n, columns);
    let mut bands: Vec<Bands> = vec![Bands::default(); columns];
    for c in 0..columns {
        let length = now.column(c).norm();
        now.column_mut(c).scale_mut(1.0 / length.max(f64::MIN_POSITIVE));
    }
    let mut ends = vec![[0.0; 2]; columns];
    for step in 1..=MOST_STEPS.min(n) {
        let mut next = apply(&now)?;
        for (c, Bands { diagonal, beside }) in bands.iter_mut().enumerate() {
            // Take off what lies along the last two directions; the rest is the next one.
            let along = now.column(c).dot(&next.column(c));
            next.column_mut(c).axpy(-along, &now.column(c), 1.0);
            if let Some(&last) = beside.last() {
                next.column_mut(c).axpy(-last, &before.column(c), 1.0);
            }
            let length = next.column(c).norm();
            diagonal.push(along);
            beside.push(length);
            // A space that is exhausted goes on with nothing, which adds eigenvalue 0.
            next.column_mut(c).scale_mut(if length > 1e-12 { 1.0 / length } else { 0.0 });
        }
        before = std::mem::replace(&mut now, next);
        if step % LOOK == 0 || step == n || step == MOST_STEPS {
            let found: Vec<[f64; 2]> = bands.iter().map(Bands::ends).collect();
            let settled = |(new, old): (&[f64; 2], &[f64; 2])| {
                new.iter().zip(old).all(|(n, o)| (n - o).abs() < SETTLED * (1.0 - n.abs()).abs().max(1e-8))
            };
            let done = step > LOOK && found.iter().zip(&ends).all(settled);
            ends = found;
            if done {
                break;
            }
        }
    }
    Ok(ends)
}

/// n numbers between 0.5 and 1.5 without pattern, always the same: a start that leaves nothing out.
pub(crate) fn uneven(n: usize) -> impl Iterator<Item = f64> {
    let mut state = 1u64;
    (0..n).map(move |_| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        0.5 + (state >> 11) as f64 / (1u64 << 53) as f64
    })
}

/// The tridiagonal matrix that the method builds up.
#[derive(Clone, Default)]
struct Bands {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
}

impl Bands {
    fn ends(&self) -> [f64; 2] {
        let steps = self.diagonal.len();
        let matrix = DMatrix::from_fn(steps, steps, |i, j| match i.abs_diff(j) {
            0 => self.diagonal[i],
            1 => self.beside[i.min(j)],
            _ => 0.0,
        });
        let values = matrix.symmetric_eigenvalues();
        [values.min(), values.max()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_a_known_spectrum_are_found_from_inside() {
        // The path of n nodes has eigenvalues 2 cos(kπ/(n + 1)).
        let n = 30;
        let start = DMatrix::from_iterator(n, 1, uneven(n));
        let path = |x: &DMatrix<f64>| {
            let at = |i: usize| if (1..=n).contains(&i) { x[i - 1] } else { 0.0 };
            Ok::<_, ()>(DMatrix::from_fn(n, 1, |i, _| at(i) + at(i + 2)))
        };
        let [least, greatest] = ends_of_spectrum(start, path).unwrap()[0];
        let exact = 2.0 * (std::f64::consts::PI / (n + 1) as f64).cos();
        assert!((greatest - exact).abs() < 1e-2 && greatest < exact + 1e-9, "{greatest} {exact}");
        assert!((least + exact).abs() < 1e-2 && least > -exact - 1e-9, "{least}");
    }
}
