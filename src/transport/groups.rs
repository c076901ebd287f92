//! Groups: form factors between faces, materials or objects, with standard errors.
//!
//! F_ab = Σ_{i∈a} Σ_{j∈b} S_ij / Σ_{i∈a} A_i, by the jackknife over batches of rays: everything, balancing included, is done again
//! without each batch in turn. The spread of what comes out gives the standard error (Tukey 1958); its mean, the bias that
//! scales which depend on the same noisy rays leave behind, which is taken off (Quenouille 1956): F = 8 F(all) − 7 mean F(all but
//! one). That is linear, so what closes and what is reciprocal stays so.

use rayon::prelude::*;

use super::exchange::Exchange;
use super::recipe::BATCHES;
use super::storage::StorageKind;
use super::{FormFactors, TransportError};
use crate::patches::Patches;
use crate::progress::Progress;

/// A form factor between two groups.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupFactor {
    /// The group that sends.
    pub from: usize,
    /// The group that receives; none for what escapes.
    pub to: Option<usize>,
    /// F, 0 to 1, the bias of balancing taken off.
    pub form_factor: f64,
    /// Its standard error, estimated from 8 batches (7 degrees of freedom).
    pub standard_error: f64,
}

/// Sums over groups, by sending group: (receiving group, value), ascending; escape comes last.
type Sums = Vec<Vec<(usize, f64)>>;

impl FormFactors {
    /// Form factors between groups of patches, in the first channel where coloured carriers make channels differ; those that are zero are
    /// left out. `group_of` names each patch's group, from 0.
    ///
    /// # Errors
    /// `Cancelled`; `NoRays` unless the rays were kept.
    ///
    /// # Panics
    /// If there is not one group per patch.
    pub fn between_groups(
        &self,
        patches: &Patches,
        group_of: &[usize],
        progress: Progress,
    ) -> Result<Vec<GroupFactor>, TransportError> {
        self.between_groups_in(0, patches, group_of, progress)
    }

    /// The same in another channel.
    ///
    /// # Errors
    /// `Cancelled`; `NoRays` unless the rays were kept.
    ///
    /// # Panics
    /// If there is not one group per patch.
    pub fn between_groups_in(
        &self,
        channel: usize,
        patches: &Patches,
        group_of: &[usize],
        progress: Progress,
    ) -> Result<Vec<GroupFactor>, TransportError> {
        assert_eq!(group_of.len(), self.len(), "one group per patch");
        let rows = self.rows().ok_or(TransportError::NoRays)?;
        // A coefficient belongs where its patch does.
        let each = self.basis().coefficients();
        let group_of: Vec<usize> =
            group_of.iter().flat_map(|&group| std::iter::repeat_n(group, each)).collect();
        let all = sums(self.exchange_of(channel), &group_of);
        let mut without: Vec<Sums> = Vec::new();
        for batch in 0..BATCHES {
            progress.at("errors", batch as f64 / BATCHES as f64)?;
            let kind = match self.exchange().storage_name() {
                "dense" => StorageKind::Dense,
                _ => StorageKind::Sparse,
            };
            let of = (patches, self.tone_of(channel));
            let exchange = Exchange::from_rows(rows, of, kind, Some(batch), Progress::default())?;
            without.push(sums(&exchange, &group_of));
        }
        progress.at("errors", 1.0)?;
        let groups = all.len();
        let factor = |from: usize, to: usize, form_factor: f64| {
            let value = |sums: &Sums| {
                let row = &sums[from];
                row.binary_search_by_key(&to, |entry| entry.0).map_or(0.0, |k| row[k].1)
            };
            let values: Vec<f64> = without.iter().map(value).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let spread: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            let standard_error = (spread * (BATCHES - 1) as f64 / BATCHES as f64).sqrt();
            let form_factor = form_factor + (BATCHES - 1) as f64 * (form_factor - mean);
            GroupFactor { from, to: (to < groups).then_some(to), form_factor, standard_error }
        };
        let rows = all.iter().enumerate();
        Ok(rows
            .flat_map(|(from, row)| row.iter().map(move |&(to, f)| (from, to, f)))
            .map(|(a, b, f)| factor(a, b, f))
            .collect())
    }
}

fn sums(exchange: &Exchange, group_of: &[usize]) -> Sums {
    let groups = group_of.iter().max().map_or(0, |last| last + 1);
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); groups];
    group_of.iter().enumerate().for_each(|(i, &group)| members[group].push(i));
    let sum_of = |members: &Vec<usize>| {
        let mut to: Vec<(usize, f64)> = Vec::new();
        for &i in members {
            exchange.for_row(i, |j, area| to.push((group_of[j], area)));
            to.push((groups, exchange.escape(i)));
            // Sum up now and then, so that the list stays short.
            if to.len() > 1 << 16 {
                add_up(&mut to);
            }
        }
        add_up(&mut to);
        let area: f64 = members.iter().map(|&i| exchange.areas()[i]).sum();
        to.retain(|entry| entry.1 > 0.0);
        to.iter_mut().for_each(|entry| entry.1 /= area);
        to
    };
    members.par_iter().map(sum_of).collect()
}

/// Adds up entries of the same group; ascending.
fn add_up(entries: &mut Vec<(usize, f64)>) {
    entries.sort_by_key(|entry| entry.0);
    entries.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
}
