//! Front: the rows that no other beats in both time and error (Pareto 1896), the quickest first.

use super::row::StudyRow;

/// Numbers of the rows on the front. An error that the noise hides counts as what it is no larger than.
pub(super) fn front(rows: &[StudyRow], of_it: impl Fn(&StudyRow) -> bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rows.len()).filter(|&k| of_it(&rows[k])).collect();
    let error = |k: usize| rows[k].reading().most();
    order.sort_by(|&a, &b| rows[a].seconds.total_cmp(&rows[b].seconds).then(error(a).total_cmp(&error(b))));
    let mut least = f64::INFINITY;
    order.retain(|&k| {
        let better = error(k) < least;
        least = least.min(error(k));
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::super::row::tests::row;
    use super::*;

    #[test]
    fn nothing_is_both_quicker_and_better_than_a_row_on_the_front() {
        let rows = [
            row(1, 1, 3.0, 0.01),
            row(1, 2, 1.0, 0.10),
            row(1, 3, 2.0, 0.20),
            row(1, 4, 2.0, 0.05),
            row(1, 5, 4.0, 0.01),
        ];
        let found = front(&rows, |_| true);
        assert_eq!(found, [1, 3, 0]);
        for (k, row) in rows.iter().enumerate().filter(|(k, _)| !found.contains(k)) {
            assert!(
                found.iter().any(|&f| rows[f].seconds <= row.seconds && rows[f].error <= row.error),
                "{k}"
            );
        }
    }

    #[test]
    fn what_the_noise_hides_counts_as_its_limit() {
        let hidden = StudyRow { error_se: 0.05, ..row(1, 1, 2.0, 0.0) };
        assert_eq!(front(&[row(1, 1, 1.0, 0.1), hidden.clone()], |_| true), [0]);
        assert_eq!(front(&[row(1, 1, 1.0, 0.2), hidden], |_| true), [0, 1]);
    }
}
