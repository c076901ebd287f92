//! Solvability: light must be able to end somewhere.

use nalgebra::DMatrix;

use super::FormFactors;

/// A set of patches that sees only itself, lets nothing out and absorbs nothing in some channel, if there is one.
pub(super) fn trapped(factors: &FormFactors, reflectance: &DMatrix<f64>) -> Option<Vec<usize>> {
    reflectance.column_iter().enumerate().find_map(|(channel, rho)| {
        let exchange = factors.exchange_of(channel);
        // Only a set of perfect reflectors can be such a set; most scenes have none at all.
        let mut unvisited: Vec<bool> = rho.iter().map(|&r| r == 1.0).collect();
        (0..exchange.len()).find_map(|start| {
            if !unvisited[start] {
                return None;
            }
            let (mut set, mut at) = (vec![start], 0);
            let mut loses = false;
            unvisited[start] = false;
            while at < set.len() {
                let i = set[at];
                loses |= exchange.leaving()[i] > 0.0;
                exchange.for_row(i, |j, _| {
                    loses |= rho[j] < 1.0;
                    if std::mem::take(&mut unvisited[j]) {
                        set.push(j);
                    }
                });
                at += 1;
            }
            (!loses).then_some(set)
        })
    })
}
