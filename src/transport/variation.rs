//! Variation: what it changes elsewhere that light varies within a patch, to first order, without new rays.
//!
//! Irradiance on a patch is taken to be even. How far it is from that is known in two ways. What lamps near the patch send to each of its parts is
//! given by Lambert's formula, as far as they are seen. And the patch's own rays tell: with ψ₁ and ψ₂ linear on the patch, of mean 0 and mean
//! square 1, and N rays that start at x and bring radiance L,
//!
//! c_k = (1/N) Σ π L ψ_k(x).
//!
//! What leaves the patch beside its mean arrives where the same rays land, of exchange area a/N each, and on lamps as far as Lambert's formula says,
//! by reciprocity. Were both sums over the same rays, their noise would add up; so c_k is taken from one half of the batches and what arrives from the
//! other, and the other way round. The product of the two answers estimates the square without bias.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::assembly::Outcome;
use super::landing::Spot;
use super::rays::{Row, Rows, origins};
use super::{FormFactors, TransportError};
use crate::patches::Patches;
use crate::scene::Side;
use crate::trace::form_factor_between;

/// Two halves of the batches.
const HALVES: usize = 2;

/// A patch falls into the square of so many parts.
const CUTS: usize = 8;

/// Lamps nearer than so many radii light a patch unevenly.
const NEAR: f64 = 3.0;

impl FormFactors {
    /// How irradiance changes (n × c, W·m⁻²) where light varies within patches, to first order, as either half of the rays has it: within those
    /// that are near lamps, and within `others`. `radiance` (n × c, W·sr⁻¹·m⁻²) is that of constant elements.
    ///
    /// # Errors
    /// `NoRays` unless the rays were kept.
    pub(crate) fn varied(
        &self,
        patches: &Patches,
        radiance: &DMatrix<f64>,
        others: &[bool],
    ) -> Result<[DMatrix<f64>; HALVES], TransportError> {
        let mut changes = [0; HALVES].map(|_| DMatrix::zeros(radiance.nrows(), radiance.ncols()));
        if self.rays() == 0 {
            return Ok(changes);
        }
        let rows = self.rows().ok_or(TransportError::NoRays)?;
        let reflectances = patches.reflectances();
        let setting = Setting::new(rows, patches);
        let by_patch: Vec<(usize, Within)> = (0..patches.len())
            .into_par_iter()
            .filter_map(|i| Some((i, setting.within(i, others[i])?)))
            .collect();
        for c in 0..radiance.ncols() {
            let light = Light { setting: &setting, tone: self.tone_of(c), radiance, channel: c };
            let uneven: Vec<Uneven> =
                by_patch.par_iter().map(|(i, within)| light.uneven(*i, within)).collect();
            for ((i, within), uneven) in by_patch.iter().zip(&uneven) {
                light.send(*i, within, uneven, reflectances[(*i, c)], &mut changes);
            }
        }
        Ok(changes)
    }
}

/// Form factors from the parts of a patch to a lamp face, as far as it is seen.
struct Seen {
    lamp: usize,
    of_parts: Vec<f64>,
}

/// What is known of a patch's parts.
struct Within<'a> {
    row: &'a Row,
    near: Vec<Seen>,
}

/// How far irradiance on a patch is from its mean.
struct Uneven {
    /// By lamps near it, per part.
    by_lamps: Vec<f64>,
    /// By rays: along ψ₁ and ψ₂, of either half.
    by_rays: [[f64; 2]; HALVES],
}

/// Where light goes.
struct Setting<'a> {
    rows: &'a Rows,
    patches: &'a Patches<'a>,
    is_lamp: Vec<bool>,
}

impl<'a> Setting<'a> {
    fn new(rows: &'a Rows, patches: &'a Patches<'a>) -> Self {
        let is_lamp = (0..patches.len()).map(|i| {
            let place = patches.place(i);
            place.side == Side::Front && rows.lamp_faces.binary_search(&(place.face as u32)).is_ok()
        });
        Self { rows, patches, is_lamp: is_lamp.collect() }
    }

    /// What is known of a patch's parts; nothing without rays, nor of patches that are neither wanted nor near a lamp.
    fn within(&self, i: usize, is_wanted: bool) -> Option<Within<'a>> {
        let row = self.rows.of(self.patches.slot_of_patch(i))?;
        let near = self.near_lamps(i, row);
        (is_wanted || !near.is_empty()).then_some(Within { row, near })
    }

    fn near_lamps(&self, i: usize, row: &Row) -> Vec<Seen> {
        if row.lamps.shares.is_empty() {
            return Vec::new();
        }
        let place = self.patches.place(i);
        let corners = self.patches.corners(i).map(|at| self.patches.point(place.face, at));
        let turn = if place.side == Side::Back { -1.0 } else { 1.0 };
        let facing = turn * normal(&corners);
        let centre = corners.iter().sum::<DVec3>() / 3.0;
        let reach = NEAR * corners.iter().map(|corner| corner.distance(centre)).fold(0.0, f64::max);
        let scene = self.patches.scene();
        let lamps = self.rows.lamp_faces.iter().map(|&lamp| lamp as usize);
        let is_near =
            |lamp: &usize| scene.corners(*lamp).iter().any(|corner| corner.distance(centre) < reach);
        let seen = |lamp: usize| {
            let slots = self.patches.slots_of(lamp, Side::Front);
            let shares = row.lamps.shares.iter().filter(|share| slots.contains(&share.slot));
            let share: f64 = shares.map(|share| f64::from(share.share)).sum();
            if share == 0.0 {
                return None;
            }
            let there = scene.corners(lamp);
            let from = |part: &[DVec3; 3]| form_factor_between((part, facing), (&there, normal(&there)));
            let mut of_parts: Vec<f64> = parts_of(corners).iter().map(from).collect();
            let mean = of_parts.iter().sum::<f64>() / of_parts.len() as f64;
            of_parts.iter_mut().for_each(|factor| *factor *= share / mean);
            (mean > 0.0).then_some(Seen { lamp, of_parts })
        };
        lamps.filter(is_near).filter_map(seen).collect()
    }
}

/// The light of one channel.
struct Light<'a> {
    setting: &'a Setting<'a>,
    tone: usize,
    radiance: &'a DMatrix<f64>,
    channel: usize,
}

impl Light<'_> {
    /// Where the rays of a half start, and the patch that each meets; not lamps that light sampling looks at.
    fn rays<'r>(&'r self, i: usize, row: &'r Row, half: usize) -> impl Iterator<Item = (Spot, usize)> + 'r {
        let Setting { rows, patches, is_lamp } = self.setting;
        let each = row.landings.len() / HALVES;
        let range = half * each..(half + 1) * each;
        let from = origins(row.slot, rows.recipe).skip(range.start);
        let met = move |(end, from)| match Outcome::of(end, patches) {
            Outcome::Met { patch, .. } => Some((from, patch as usize)),
            Outcome::Left(_) => None,
        };
        row.ends(range, self.tone).zip(from).filter_map(met).filter(move |&(_, j)| is_lamp[i] || !is_lamp[j])
    }

    fn uneven(&self, i: usize, Within { row, near }: &Within) -> Uneven {
        let mut by_lamps = vec![0.0; CUTS * CUTS];
        for Seen { lamp, of_parts } in near {
            let on_lamp = self.setting.patches.patches_of(*lamp, Side::Front);
            let count = on_lamp.len().max(1) as f64;
            let arriving = PI * on_lamp.map(|j| self.radiance[(j, self.channel)]).sum::<f64>() / count;
            let mean = of_parts.iter().sum::<f64>() / of_parts.len() as f64;
            by_lamps.iter_mut().zip(of_parts).for_each(|(sum, factor)| *sum += arriving * (factor - mean));
        }
        let rays = (row.landings.len() / HALVES) as f64;
        let by_rays = std::array::from_fn(|half| {
            let mut sums = [0.0; 2];
            for (from, j) in self.rays(i, row, half) {
                let arriving = PI * self.radiance[(j, self.channel)] / rays;
                sums.iter_mut().zip(linear(from.weights())).for_each(|(sum, psi)| *sum += arriving * psi);
            }
            sums
        });
        Uneven { by_lamps, by_rays }
    }

    /// Adds what uneven light on a patch of this reflectance changes elsewhere, as either half of its rays has it.
    fn send(
        &self,
        i: usize,
        Within { row, near }: &Within,
        uneven: &Uneven,
        reflectance: f64,
        changes: &mut [DMatrix<f64>; HALVES],
    ) {
        let Setting { patches, .. } = self.setting;
        let etendues = patches.etendues();
        let worth = reflectance * etendues[i] * HALVES as f64 / row.landings.len() as f64;
        for (half, change) in changes.iter_mut().enumerate() {
            let along = uneven.by_rays[1 - half];
            for (from, j) in self.rays(i, row, half) {
                let psi = linear(from.weights());
                let beside = uneven.by_lamps[part_at(from.weights())] + psi[0] * along[0] + psi[1] * along[1];
                change[(j, self.channel)] += worth * beside / etendues[j];
            }
        }
        for Seen { lamp, of_parts } in near {
            let on_lamp = patches.patches_of(*lamp, Side::Front);
            let sum: f64 =
                of_parts.iter().zip(&uneven.by_lamps).map(|(factor, beside)| factor * beside).sum();
            let flux = reflectance * etendues[i] * sum / of_parts.len() as f64;
            let area: f64 = on_lamp.clone().map(|j| etendues[j]).sum();
            for j in on_lamp {
                changes.iter_mut().for_each(|change| change[(j, self.channel)] += flux / area);
            }
        }
    }
}

/// Two functions that are linear over a triangle, of mean 0 and mean square 1, at the point with these weights of corners.
fn linear([a, b, c]: [f64; 3]) -> [f64; 2] {
    [6f64.sqrt() * (b - c), 8f64.sqrt() * (a - 0.5 * (b + c))]
}

fn normal(&[a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Equal parts of a triangle, row after row along the first leg, each upright one followed by the one that stands on its head.
fn parts_of([a, b, c]: [DVec3; 3]) -> Vec<[DVec3; 3]> {
    let at = |[i, j]: [usize; 2]| a + ((b - a) * i as f64 + (c - a) * j as f64) / CUTS as f64;
    let mut parts = Vec::with_capacity(CUTS * CUTS);
    for (i, j) in (0..CUTS).flat_map(|i| (0..CUTS - i).map(move |j| (i, j))) {
        parts.push([[i, j], [i + 1, j], [i, j + 1]].map(at));
        if i + j + 1 < CUTS {
            parts.push([[i + 1, j + 1], [i, j + 1], [i + 1, j]].map(at));
        }
    }
    parts
}

/// Which of the [parts](parts_of) the point with these weights of corners lies in.
fn part_at([_, u, v]: [f64; 3]) -> usize {
    let scaled = [u, v].map(|x| x * CUTS as f64);
    let i = (scaled[0] as usize).min(CUTS - 1);
    let j = (scaled[1] as usize).min(CUTS - 1 - i);
    let is_turned = scaled[0] - i as f64 + scaled[1] - j as f64 > 1.0 && i + j + 1 < CUTS;
    // Row k has 2 (CUTS − k) − 1 parts.
    let before: usize = (0..i).map(|k| 2 * (CUTS - k) - 1).sum();
    before + 2 * j + usize::from(is_turned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::sampling::TRIANGLE_RULE_7;

    #[test]
    fn linear_functions_are_orthonormal_on_a_triangle() {
        let mean = |f: &dyn Fn([f64; 2]) -> f64| -> f64 {
            TRIANGLE_RULE_7.iter().map(|&([u, v], part)| part * f(linear([1.0 - u - v, u, v]))).sum()
        };
        assert!(mean(&|[x, y]| x * y).abs() < 1e-14);
        for k in 0..2 {
            assert!(mean(&|psi| psi[k]).abs() < 1e-14);
            assert!((mean(&|psi| psi[k] * psi[k]) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn parts_make_up_the_triangle_and_are_found_by_their_points() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let parts = parts_of(corners);
        assert_eq!(parts.len(), CUTS * CUTS);
        for (k, [a, b, c]) in parts.into_iter().enumerate() {
            assert!(((b - a).cross(c - a).z * (CUTS * CUTS) as f64 - 1.0).abs() < 1e-12, "wound alike");
            for weights in [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8]] {
                let p = weights[0] * a + weights[1] * b + weights[2] * c;
                assert_eq!(part_at([1.0 - p.x - p.y, p.x, p.y]), k);
            }
        }
    }
}
