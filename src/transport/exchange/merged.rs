//! Merging: what groups of patches exchange, as one larger patch each.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::storage::Storage;
use super::{Ends, Exchange, ExchangeParts};

impl Exchange {
    /// The exchange areas S_IJ = Σ S_(ia)(jb) between groups of patches, with constant elements on each: what
    /// rays would have found on so coarse a cut. Symmetric and closed as these are. `group_of` names each
    /// coefficient's group, from 0.
    ///
    /// # Panics
    /// If there is not one group per coefficient, or one is `groups` or more.
    pub fn merged(&self, group_of: &[usize], groups: usize) -> Self {
        assert_eq!(group_of.len(), self.len(), "one group per coefficient");
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); groups];
        group_of.iter().enumerate().for_each(|(k, &group)| members[group].push(k));
        let row = |sums: &mut Vec<f64>, members: &Vec<usize>| {
            let mut met: Vec<u32> = Vec::new();
            for &k in members {
                self.for_entries(k, |l, area| {
                    let sum: &mut f64 = &mut sums[group_of[l]];
                    if *sum == 0.0 {
                        met.push(group_of[l] as u32);
                    }
                    *sum += area;
                });
            }
            met.sort_unstable();
            met.dedup();
            // What was summed up is taken out, so that the next group finds zeros.
            met.into_iter().map(|to| (to, std::mem::take(&mut sums[to as usize]) as f32)).collect()
        };
        let rows: Vec<Vec<(u32, f32)>> = members.par_iter().map_init(|| vec![0.0; groups], row).collect();
        let over = |of: &dyn Fn(usize) -> f64| {
            let sums = members.iter().map(|members| members.iter().map(|&k| of(k)).sum::<f64>());
            DVector::from_iterator(groups, sums)
        };
        let entries: usize = rows.iter().map(Vec::len).sum();
        let storage =
            if 2 * entries > groups * groups { Storage::Dense(dense(&rows)) } else { sparse(&rows) };
        let leaving = over(&|k| self.ends().leaving[k]);
        let in_carriers = self.ends().in_carriers.as_ref().map(|_| {
            let share = |part: DVector<f64>| {
                part.zip_map(&leaving, |part, all| if all > 0.0 { part / all } else { 0.0 })
            };
            [share(over(&|k| self.ends().absorbed(k))), share(over(&|k| self.ends().lost(k)))]
        });
        let mass = self.mass().of_groups(over(&|k| self.sums()[k]));
        let scale = DVector::repeat(groups, 1.0);
        let ends = Ends { leaving, in_carriers, slack: over(&|k| self.ends().slack[k]) };
        let parts = ExchangeParts { storage, scale, ends, closure: *self.closure(), shrinkage: 1.0 };
        Self::from_parts(parts, mass)
    }
}

/// Both triangles of a matrix from its rows; the mean of the two, which differ in rounding.
fn dense(rows: &[Vec<(u32, f32)>]) -> DMatrix<f32> {
    let mut m = DMatrix::zeros(rows.len(), rows.len());
    for (i, row) in rows.iter().enumerate() {
        for &(j, value) in row.iter().filter(|entry| entry.0 as usize >= i) {
            m[(i, j as usize)] = value;
            m[(j as usize, i)] = value;
        }
    }
    m
}

fn sparse(rows: &[Vec<(u32, f32)>]) -> Storage {
    let upper = |i: usize, j: u32| {
        let (i, j) = (i.min(j as usize), i.max(j as usize) as u32);
        rows[i].binary_search_by_key(&j, |entry| entry.0).map_or(0.0, |k| rows[i][k].1)
    };
    let row = |i: usize| rows[i].iter().map(|&(j, _)| (j, upper(i, j))).collect();
    let symmetric: Vec<Vec<(u32, f32)>> = (0..rows.len()).map(row).collect();
    Storage::sparse(&symmetric)
}
