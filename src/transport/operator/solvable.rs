//! Solvability: light must be able to end somewhere. Slack does not count: what rows lack is missing from the
//! numbers, not absorbed in the scene. A row without any entry traps nothing, though: what it lacks is all of
//! it.

use super::Transport;
use crate::transport::exchange::Exchange;

/// A share that rounding alone can leave of nothing.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A set of coefficients' patches that sees only itself, lets nothing out and absorbs nothing in some
/// channel, if there is one.
pub fn trapped(k: &Transport) -> Option<Vec<usize>> {
    let passed_on = k.passed_on();
    (0..k.channels()).find_map(|channel| {
        let absorbs = |i: usize| 1.0 - passed_on[(i, channel)] > ROUNDING;
        let light = Light { k, exchange: k.exchange_of(channel), channel, across: across(k, channel) };
        // Only a set that passes everything on can be such a set; most scenes have none at all.
        let mut unvisited: Vec<bool> = (0..k.len()).map(|i| !absorbs(i)).collect();
        (0..k.len()).find_map(|start| {
            if !unvisited[start] {
                return None;
            }
            let (mut set, mut at) = (vec![start], 0);
            let mut loses = false;
            unvisited[start] = false;
            while at < set.len() {
                for i in light.leaves_by(set[at]) {
                    let mut is_empty = true;
                    light.exchange.for_entries(i, |j, _| {
                        is_empty = false;
                        loses |= absorbs(j);
                        if std::mem::take(&mut unvisited[j]) {
                            set.push(j);
                        }
                    });
                    loses |= is_empty || light.exchange.ends().leaving[i] > 0.0;
                }
                at += 1;
            }
            (!loses).then_some(set)
        })
    })
}

/// Light in one channel.
struct Light<'a> {
    k: &'a Transport,
    exchange: &'a Exchange,
    channel: usize,
    /// Per coefficient, the other side of its sheet if light comes through; empty without sheets.
    across: Vec<Option<usize>>,
}

impl Light<'_> {
    /// The sides by which light leaves that arrives at `i`.
    fn leaves_by(&self, i: usize) -> impl Iterator<Item = usize> {
        let back = (self.k.reflectance()[(i, self.channel)] > 0.0).then_some(i);
        back.into_iter().chain(self.across.get(i).copied().flatten())
    }
}

fn across(k: &Transport, channel: usize) -> Vec<Option<usize>> {
    let Some(sheets) = k.sheets() else { return Vec::new() };
    let mut across = vec![None; k.len()];
    for (p, &[front, back]) in sheets.pairs.iter().enumerate() {
        if sheets.transmittance[(p, channel)] > 0.0 {
            (across[front], across[back]) = (Some(back), Some(front));
        }
    }
    across
}
