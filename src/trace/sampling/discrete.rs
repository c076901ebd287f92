//! Discrete distribution: one of several things, drawn with probabilities in proportion to their weights.

use std::sync::Arc;

/// A discrete distribution over 0..n, by running sums of weights; clones share them.
#[derive(Clone, Debug, Default)]
pub struct Discrete {
    /// Sum of the weights up to and including each.
    sums: Arc<[f64]>,
}

impl Discrete {
    /// A distribution by weights that are not negative, in any unit.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Self {
        let mut total = 0.0;
        let add = |weight: f64| {
            total += weight;
            total
        };
        Self { sums: weights.into_iter().map(add).collect() }
    }

    /// The same by probabilities, so that [`Discrete::weight`] is one; all zero where the total is.
    pub fn normalised(self) -> Self {
        let total = self.total();
        if total <= 0.0 {
            return self;
        }
        Self { sums: self.sums.iter().map(|sum| sum / total).collect() }
    }

    /// Sum of all weights; 0 where there are none.
    #[inline]
    pub fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// Weight of thing `k`.
    #[inline]
    pub fn weight(&self, k: usize) -> f64 {
        self.sums[k] - self.below(k)
    }

    /// The thing that a random number in [0, 1) falls on, and what is left of the number within the thing's
    /// share, again uniform in [0, 1).
    ///
    /// # Panics
    /// If there is nothing to draw from.
    #[inline]
    pub fn draw(&self, random: f64) -> (usize, f64) {
        self.draw_at(random * self.total())
    }

    /// [`Discrete::draw`] by a number in [0, total).
    #[inline]
    pub fn draw_at(&self, goal: f64) -> (usize, f64) {
        let k = self.sums.partition_point(|&sum| sum <= goal).min(self.sums.len() - 1);
        let weight = self.weight(k);
        (k, if weight > 0.0 { ((goal - self.below(k)) / weight).clamp(0.0, 1.0) } else { 0.5 })
    }

    /// Sum of the weights before thing `k`.
    #[inline]
    fn below(&self, k: usize) -> f64 {
        if k == 0 { 0.0 } else { self.sums[k - 1] }
    }
}

/// A discrete distribution over the places of a table: a row is drawn by one random number, and a column of
/// it by another, so that stratified pairs stay stratified.
#[derive(Clone, Debug)]
pub struct DiscreteTable {
    rows: Discrete,
    columns: Vec<Discrete>,
}

impl DiscreteTable {
    /// By the weights of each row's columns, and how much those of each row count.
    pub fn new(columns: Vec<Discrete>, counts: impl Fn(usize) -> f64) -> Self {
        let row = |(row, columns): (usize, &Discrete)| columns.total() * counts(row);
        let rows = Discrete::new(columns.iter().enumerate().map(row)).normalised();
        Self { rows, columns: columns.into_iter().map(Discrete::normalised).collect() }
    }

    /// The chance of a place.
    #[inline]
    pub fn weight(&self, [row, column]: [usize; 2]) -> f64 {
        self.rows.weight(row) * self.columns[row].weight(column)
    }

    /// The row and column on which two random numbers fall, and what is left of them: across the column and
    /// along the row.
    #[inline]
    pub fn draw(&self, [u, v]: [f64; 2]) -> ([usize; 2], [f64; 2]) {
        let (row, v) = self.rows.draw(v);
        let (column, u) = self.columns[row].draw(u);
        ([row, column], [u, v])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_are_drawn_by_their_weights_and_what_is_left_is_uniform() {
        let weights = [0.0, 3.0, 1.0, 0.0, 4.0, 0.0];
        let n = 8000;
        for distribution in [Discrete::new(weights), Discrete::new(weights).normalised()] {
            let (mut counts, mut left) = ([0.0; 6], [0.0; 6]);
            for k in 0..n {
                let (drawn, fresh) = distribution.draw((f64::from(k) + 0.5) / f64::from(n));
                counts[drawn] += 1.0;
                left[drawn] += fresh;
            }
            for (k, weight) in weights.into_iter().enumerate() {
                assert_eq!(counts[k], weight / 8.0 * f64::from(n));
                assert!((left[k] - 0.5 * counts[k]).abs() < 1e-6);
                assert!((distribution.weight(k) / distribution.total() - weight / 8.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn weights_of_nothing_stay_zero() {
        let nothing = Discrete::new([0.0; 3]).normalised();
        assert_eq!((nothing.total(), nothing.weight(1), nothing.draw(0.3).1), (0.0, 0.0, 0.5));
        assert_eq!(Discrete::default().total(), 0.0);
    }
}
