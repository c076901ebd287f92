//! Front: the rows that no other beats in both time and error (Pareto 1896), the quickest first. Times within
//! 5 % of each other are the same: clocks on a busy machine tell no more.

use super::constants::SAME_TIME;
use super::row::StudyRow;

/// Numbers of the rows on the front. An error that the noise hides counts as what it is no larger than.
pub(super) fn front(rows: &[StudyRow], of_it: impl Fn(&StudyRow) -> bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rows.len()).filter(|&k| of_it(&rows[k])).collect();
    let error = |k: usize| rows[k].reading().most();
    order.sort_by(|&a, &b| rows[a].seconds.total_cmp(&rows[b].seconds).then(error(a).total_cmp(&error(b))));
    // With each row the time of the quickest row that it stands for: were it held against the row before,
    // times could drift.
    let mut front: Vec<(usize, f64)> = Vec::new();
    for k in order {
        let seconds = rows[k].seconds;
        match front.last_mut() {
            Some(last) if error(k) >= error(last.0) => {}
            // As quick and better: in its place.
            Some(last) if seconds <= SAME_TIME * last.1 => last.0 = k,
            _ => front.push((k, seconds)),
        }
    }
    front.into_iter().map(|(k, _)| k).collect()
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
                found
                    .iter()
                    .any(|&f| rows[f].seconds <= SAME_TIME * row.seconds && rows[f].error <= row.error),
                "{k}"
            );
        }
    }

    #[test]
    fn of_rows_as_quick_as_each_other_only_the_best_is_on_the_front() {
        let rows = [row(1, 1, 1.0, 0.5), row(1, 2, 1.02, 0.2), row(1, 3, 1.04, 0.1), row(1, 4, 2.0, 0.05)];
        assert_eq!(front(&rows, |_| true), [2, 3]);
    }

    #[test]
    fn times_do_not_drift_along_rows_that_are_each_as_quick_as_the_one_before() {
        let rows: Vec<StudyRow> =
            (0..5).map(|k| row(1, 1 + k, 1.04f64.powi(k as i32), 0.5f64.powi(k as i32))).collect();
        assert_eq!(front(&rows, |_| true), [1, 3, 4]);
    }

    #[test]
    fn what_the_noise_hides_counts_as_its_limit() {
        let hidden = StudyRow { error_se: 0.05, ..row(1, 1, 2.0, 0.0) };
        assert_eq!(front(&[row(1, 1, 1.0, 0.1), hidden.clone()], |_| true), [0]);
        assert_eq!(front(&[row(1, 1, 1.0, 0.2), hidden], |_| true), [0, 1]);
    }
}
