//! Tally: how many scenes broke which law, and what these scenes have in common.

use std::collections::BTreeMap;

use super::laws::{Law, Outcome};

/// The largest share of scenes whose finer answer may lie beyond both bounds.
const BEYOND: f64 = 0.05;

/// The largest share of scenes that may have warnings.
const WARNED: f64 = 0.15;

/// What of all scenes together.
pub struct Tally(pub Vec<Outcome>);

impl Tally {
    fn share(&self, is: impl Fn(&Outcome) -> bool) -> f64 {
        self.0.iter().filter(|outcome| is(outcome)).count() as f64 / self.0.len().max(1) as f64
    }

    /// What did not hold, a line each.
    pub fn failures(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for Outcome { seed, broken, .. } in &self.0 {
            let always = broken.iter().filter(|(law, _)| *law != Law::Bound);
            lines.extend(always.map(|(law, how)| format!("seed {seed}: {law:?}: {how}")));
        }
        let beyond = |outcome: &Outcome| outcome.broken.iter().any(|(law, _)| *law == Law::Bound);
        if self.share(beyond) > BEYOND {
            for outcome in self.0.iter().filter(|outcome| beyond(outcome)) {
                let how = outcome.broken.iter().filter(|(law, _)| *law == Law::Bound);
                lines.extend(how.map(|(_, how)| format!("seed {}: Bound: {how}", outcome.seed)));
            }
            lines.push(format!("{:.1} % of scenes lie beyond both bounds", 100.0 * self.share(beyond)));
        }
        let warned = self.share(|outcome| !outcome.warnings.is_empty());
        if warned > WARNED {
            lines.push(format!("{:.1} % of scenes have warnings", 100.0 * warned));
        }
        lines
    }

    /// Scenes by what is ugly about them and by broken law.
    pub fn table(&self) -> String {
        let laws = [
            Law::Solved,
            Law::EnergyDirect,
            Law::EnergyIterative,
            Law::SolversAgree,
            Law::AsIfLifted,
            Law::Bound,
            Law::BoundOfUnnamed,
        ];
        let broken =
            |outcome: &Outcome| laws.map(|law| usize::from(outcome.broken.iter().any(|(l, _)| *l == law)));
        let mut rows: BTreeMap<&str, [usize; 10]> = BTreeMap::new();
        for outcome in &self.0 {
            let states = [1, usize::from(outcome.is_refused), usize::from(!outcome.warnings.is_empty())];
            for name in outcome.features.iter().copied().chain(["all scenes"]) {
                let counts = states.into_iter().chain(broken(outcome));
                rows.entry(name).or_default().iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            }
        }
        let mut text = String::from(
            "feature         scenes refused  warned  solved  energy  energy  agree  lifted   bound  unnamed\n\
             \x20                                                direct  iterat.\n",
        );
        for (name, counts) in rows {
            let counts: Vec<String> = counts.iter().map(|count| format!("{count:7}")).collect();
            text += &format!("{name:16}{}\n", counts.join(" "));
        }
        text
    }
}
