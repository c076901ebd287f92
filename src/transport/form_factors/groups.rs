//! Groups: form factors between faces, materials or objects, with standard errors.
//!
//! F_ab = Σ_{i∈a} Σ_{j∈b} S_ij / Σ_{i∈a} A_i, by the jackknife over batches of rays: everything, balancing
//! included, is done again without each batch in turn. The spread of what comes out gives the standard error
//! (Tukey 1958); its mean, the bias that scales which depend on the same noisy rays leave behind, which is
//! taken off (Quenouille 1956): F = 8 F(all) − 7 mean F(all but one). That is linear, so what closes and what
//! is reciprocal stays so.
//!
//! Where few rays or none went from a to b or back, batches cannot tell the noise. A ray between patches i
//! and j is worth w_ij = A_i A_j / ((A_i + A_j) N) of exchange area, so on average S_ij / w_ij of them land,
//! and their number follows Poisson's law: no standard error is less than what one ray is worth, and upper
//! bounds hold for the number of rays that were seen.

use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::FormFactors;
use super::constants::{FEW_SEEN, MOST_LISTED, NONE_SEEN, STUDENT};
use crate::patches::Patches;
use crate::progress::Progress;
use crate::transport::TransportError;
use crate::transport::exchange::{Exchange, Selection, StorageKind};
use crate::transport::rows::BATCHES;

/// A form factor between two groups.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupFactor {
    /// The group that sends.
    pub from: usize,
    /// The group that receives; none for what escapes.
    pub to: Option<usize>,
    /// F, 0 to 1, the bias of balancing taken off.
    pub form_factor: f64,
    /// Its standard error, estimated from 8 batches (7 degrees of freedom); at least what one ray is worth.
    pub standard_error: f64,
    /// An upper bound on F that holds in 95 cases of 100: by the standard error, and where no more than 64
    /// rays tell of F by their number.
    pub upper95: f64,
}

/// What is known of form factors that no ray found.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmet {
    /// Rays per patch.
    rays: f64,
    /// Per group, the largest étendue by π of a patch, and that of all patches, m².
    largest: Vec<f64>,
    whole: Vec<f64>,
}

impl Unmet {
    /// For groups of patches that sent so many rays each; `group_of` as in [`FormFactors::between_groups`].
    pub fn new(patches: &Patches, group_of: &[usize], rays: u32) -> Self {
        let groups = group_of.iter().max().map_or(0, |last| last + 1);
        let (mut largest, mut whole) = (vec![0.0f64; groups], vec![0.0; groups]);
        for (i, &group) in group_of.iter().enumerate() {
            largest[group] = largest[group].max(patches.etendue(i));
            whole[group] += patches.etendue(i);
        }
        Self { rays: f64::from(rays), largest, whole }
    }

    /// The form factor from group a to b, or what escapes, where no ray went from one to the other: 0. With
    /// the weight w of one ray, the standard error is w and the upper bound 3 w. Wherever on a and b they see
    /// each other, w is not more than for the largest patches, and 1/w not less than the number of rays where
    /// all patches are alike. Nothing is uncertain where a group has no patches.
    pub fn between(&self, a: usize, b: Option<usize>) -> GroupFactor {
        let size = |group: usize| self.largest.get(group).copied().unwrap_or(0.0);
        let [here, there] = [size(a), b.map_or(f64::INFINITY, size)];
        let w = if here > 0.0 && there > 0.0 { worth(here, there, self.rays) / self.whole[a] } else { 0.0 };
        let upper95 = (NONE_SEEN * w).min(1.0);
        GroupFactor { from: a, to: b, form_factor: 0.0, standard_error: w, upper95 }
    }
}

/// The exchange area that one ray tells of between patches of these étendues that send so many each.
fn worth(here: f64, there: f64, rays: f64) -> f64 {
    // So written that infinity stands for the outside, which sends none.
    1.0 / ((1.0 / here + 1.0 / there) * rays)
}

/// Sums over groups, by sending group: (receiving group, value), ascending; escape comes last.
type Sums = Vec<Vec<(usize, f64)>>;

impl FormFactors {
    /// Form factors between groups of patches, in the first channel where coloured carriers make channels
    /// differ; those that are zero are left out. `group_of` names each patch's group, from 0.
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
        let evidence = evidence(self.exchange_of(channel), &group_of, f64::from(self.rays()));
        let mut without: Vec<Sums> = Vec::new();
        for batch in 0..BATCHES {
            progress.at("errors", batch as f64 / BATCHES as f64)?;
            let kind = match self.exchange().storage_name() {
                "dense" => StorageKind::Dense,
                _ => StorageKind::Sparse,
            };
            let selection = Selection { rows, patches, tone: self.tone_of(channel), left_out: Some(batch) };
            let exchange = Exchange::from_rows(&selection, kind, Progress::default())?;
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
            let Evidence { hits, worth } = evidence_of(&evidence[from], to);
            let standard_error = (spread * (BATCHES - 1) as f64 / BATCHES as f64).sqrt().max(worth);
            let form_factor = form_factor + (BATCHES - 1) as f64 * (form_factor - mean);
            let upper95 = upper95(form_factor, standard_error, hits);
            GroupFactor { from, to: (to < groups).then_some(to), form_factor, standard_error, upper95 }
        };
        let rows = all.iter().enumerate();
        Ok(rows
            .flat_map(|(from, row)| row.iter().map(move |&(to, f)| (from, to, f)))
            .map(|(a, b, f)| factor(a, b, f))
            .collect())
    }
}

/// By how many rays a form factor between groups is known.
#[derive(Clone, Copy, Debug, Default)]
struct Evidence {
    /// Their number; where they have different weights, that of equal ones that tell as much (Kish 1965).
    hits: f64,
    /// What one of them is worth of F.
    worth: f64,
}

/// The upper 95 % bound on a form factor: Student's for 7 degrees of freedom, and where few rays tell of it,
/// Poisson's for their number.
fn upper95(form_factor: f64, standard_error: f64, hits: f64) -> f64 {
    let by_batches = form_factor + STUDENT * standard_error;
    let few = hits > 0.0 && hits <= FEW_SEEN;
    // The 95 % bound on the mean of a number h that was seen is half the quantile of χ² with 2 h + 2 degrees
    // of freedom.
    let quantile = |hits: f64| ChiSquared::new(2.0 * hits + 2.0).map(|chi| 0.5 * chi.inverse_cdf(0.95));
    let by_number = quantile(hits).ok().filter(|_| few).map_or(0.0, |most| form_factor * most / hits);
    by_batches.max(by_number).min(1.0).max(form_factor)
}

/// What is known of a group in a row.
fn evidence_of(row: &[(usize, Evidence)], to: usize) -> Evidence {
    row.binary_search_by_key(&to, |entry| entry.0).map_or(Evidence::default(), |k| row[k].1)
}

/// By how many rays each form factor between groups is known, by sending group and ascending; escape comes
/// last.
fn evidence(exchange: &Exchange, group_of: &[usize], rays: f64) -> Vec<Vec<(usize, Evidence)>> {
    let groups = group_of.iter().max().map_or(0, |last| last + 1);
    let (areas, (storage, scale)) = (exchange.sums(), exchange.raw());
    // A landing adds its worth to what is not balanced yet: sums of that, and of its worth.
    let evidence_of = |(own, members): (usize, &Vec<usize>)| {
        let mut totals: Vec<(usize, f64)> = Vec::new();
        let mut squares: Vec<(usize, f64)> = Vec::new();
        let mut add = |to: usize, raw: f64, worth: f64| {
            totals.push((to, raw));
            squares.push((to, raw * worth));
            if totals.len() > MOST_LISTED {
                add_up(&mut totals);
                add_up(&mut squares);
            }
        };
        for &i in members {
            storage.for_row(i, |j, raw| add(group_of[j], raw, worth(areas[i], areas[j], rays)));
            add(groups, exchange.ends().escape(i) / scale[i], areas[i] / rays);
        }
        add_up(&mut totals);
        add_up(&mut squares);
        let area: f64 = members.iter().map(|&i| areas[i]).sum();
        let seen = totals.iter().zip(&squares).filter(|((_, total), _)| *total > 0.0);
        let of_pair = |(&(to, total), &(_, square)): (&(usize, f64), &(usize, f64))| {
            // Within a group every ray was met from either end.
            let twice = if to == own { 2.0 } else { 1.0 };
            (to, Evidence { hits: total * total / square / twice, worth: square / total / area })
        };
        seen.map(of_pair).collect()
    };
    members_of(group_of).par_iter().enumerate().map(evidence_of).collect()
}

/// The members of each group.
fn members_of(group_of: &[usize]) -> Vec<Vec<usize>> {
    let groups = group_of.iter().max().map_or(0, |last| last + 1);
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); groups];
    group_of.iter().enumerate().for_each(|(i, &group)| members[group].push(i));
    members
}

fn sums(exchange: &Exchange, group_of: &[usize]) -> Sums {
    let groups = group_of.iter().max().map_or(0, |last| last + 1);
    let members = members_of(group_of);
    let sum_of = |members: &Vec<usize>| {
        let mut to: Vec<(usize, f64)> = Vec::new();
        for &i in members {
            exchange.for_entries(i, |j, area| to.push((group_of[j], area)));
            to.push((groups, exchange.ends().escape(i)));
            // Sum up now and then, so that the list stays short.
            if to.len() > MOST_LISTED {
                add_up(&mut to);
            }
        }
        add_up(&mut to);
        let area: f64 = members.iter().map(|&i| exchange.sums()[i]).sum();
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
