//! Variation: what it changes elsewhere that light varies within a patch, to first order, without new rays.
//!
//! Irradiance on a patch is taken to be even. What the patch's own rays found says how far it is from that: with ψ₁ and ψ₂ linear on the patch, of
//! mean 0 and mean square 1, and N rays that start at x and bring L,
//!
//! c_k = (1/N) Σ π L ψ_k(x), and light sampling adds what Lambert's formula says of lamps, as far as they are seen.
//!
//! The radiance ρ c_k ψ_k/π leaves the patch beside its mean, and the same rays say where it arrives: of exchange area a/N each,
//! it causes (a/N) Σ ψ_k(x) ρ c_k on a patch. Were both sums over the same rays, their noise would add up; so c_k is taken from one half of the
//! batches and what arrives from the other, and the other way round. The product of the two answers estimates the square without bias.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::assembly::Outcome;
use super::rays::{Row, Rows, origins};
use super::{FormFactors, TransportError};
use crate::patches::Patches;
use crate::scene::Side;
use crate::trace::form_factor_between;

/// With more lamp faces than this their light within a patch is not looked at.
const MOST_LAMPS: usize = 256;

/// A patch falls into the square of so many parts, on each of which lamps are looked at.
const PARTS: usize = 4;

/// Which half of the batches.
const HALVES: usize = 2;

impl FormFactors {
    /// How irradiance changes (n × c, W·m⁻²) where light on some patches varies linearly, to first order, as either half of the rays has it.
    /// `radiance` (n × c, W·sr⁻¹·m⁻²) is that of constant elements.
    ///
    /// # Errors
    /// `NoRays` unless the rays were kept.
    pub(crate) fn varied(
        &self,
        patches: &Patches,
        radiance: &DMatrix<f64>,
        some: &[usize],
    ) -> Result<[DMatrix<f64>; HALVES], TransportError> {
        let mut changes = [0; HALVES].map(|_| DMatrix::zeros(radiance.nrows(), radiance.ncols()));
        if self.rays() == 0 || some.is_empty() {
            return Ok(changes);
        }
        let rows = self.rows().ok_or(TransportError::NoRays)?;
        let reflectances = patches.reflectances();
        for c in 0..radiance.ncols() {
            let light = Light { rows, patches, tone: self.tone_of(c), radiance, channel: c };
            let coefficients: Vec<Option<[[f64; 2]; HALVES]>> =
                some.par_iter().map(|&i| light.coefficients(i)).collect();
            for (&i, of_patch) in some.iter().zip(coefficients) {
                let Some(of_patch) = of_patch else { continue };
                for (half, change) in changes.iter_mut().enumerate() {
                    light.send(i, half, of_patch[1 - half].map(|k| reflectances[(i, c)] * k), change);
                }
            }
        }
        Ok(changes)
    }
}

/// The light of one channel.
struct Light<'a> {
    rows: &'a Rows,
    patches: &'a Patches<'a>,
    tone: usize,
    radiance: &'a DMatrix<f64>,
    channel: usize,
}

impl Light<'_> {
    /// Where the rays of a half start, as ψ, and the patch that each meets.
    fn rays<'r>(&'r self, row: &'r Row, half: usize) -> impl Iterator<Item = ([f64; 2], usize)> + 'r {
        let each = row.landings.len() / HALVES;
        let range = half * each..(half + 1) * each;
        let origins = origins(row.slot, self.rows.recipe).skip(range.start);
        row.ends(range, self.tone).zip(origins).filter_map(|(end, from)| {
            match Outcome::of(end, self.patches) {
                Outcome::Met { patch, .. } => Some((linear(from.weights()), patch as usize)),
                Outcome::Left(_) => None,
            }
        })
    }

    /// The coefficients of irradiance on a patch by ψ₁ and ψ₂, as either half of its rays has them; none without rays.
    fn coefficients(&self, i: usize) -> Option<[[f64; 2]; HALVES]> {
        let row = self.rows.of(self.patches.slot_of_patch(i))?;
        let by_lamps = self.of_lamps(i, row);
        let is_lamp = self.is_lamp(i);
        let rays = row.landings.len() / HALVES;
        Some(std::array::from_fn(|half| {
            let mut sums = by_lamps;
            // What light sampling looks at is known from that.
            for (psi, j) in self.rays(row, half).filter(|&(_, j)| is_lamp || !self.is_lamp(j)) {
                let arriving = PI * self.radiance[(j, self.channel)] / rays as f64;
                sums.iter_mut().zip(psi).for_each(|(sum, psi)| *sum += arriving * psi);
            }
            sums
        }))
    }

    fn is_lamp(&self, i: usize) -> bool {
        let place = self.patches.place(i);
        place.side == Side::Front && self.rows.lamp_faces.binary_search(&(place.face as u32)).is_ok()
    }

    /// The same coefficients of what comes straight from lamps: as unoccluded light varies, as far as lamps are seen.
    fn of_lamps(&self, i: usize, row: &Row) -> [f64; 2] {
        let mut sums = [0.0; 2];
        if self.rows.lamp_faces.len() > MOST_LAMPS || row.lamps.shares.is_empty() {
            return sums;
        }
        let place = self.patches.place(i);
        let corners = self.patches.corners(i).map(|at| self.patches.point(place.face, at));
        let parts = parts_of(corners);
        let scene = self.patches.scene();
        for &lamp in &self.rows.lamp_faces {
            let slots = self.patches.slots_of(lamp as usize, Side::Front);
            let shares = row.lamps.shares.iter().filter(|share| slots.contains(&share.slot));
            let seen: f64 = shares.map(|share| f64::from(share.share)).sum();
            let on_lamp = self.patches.patches_of(lamp as usize, Side::Front);
            if seen == 0.0 || on_lamp.is_empty() {
                continue;
            }
            let there = scene.corners(lamp as usize);
            let turn = if place.side == Side::Back { -1.0 } else { 1.0 };
            let from = |(part, _): &([DVec3; 3], [f64; 2])| {
                form_factor_between((part, turn * normal(part)), (&there, normal(&there)))
            };
            let factors: Vec<f64> = parts.iter().map(from).collect();
            let mean = factors.iter().sum::<f64>() / factors.len() as f64;
            if mean == 0.0 {
                continue;
            }
            let bright = on_lamp.clone().map(|j| self.radiance[(j, self.channel)]).sum::<f64>();
            let arriving = PI * seen * bright / on_lamp.len() as f64;
            for (factor, (_, psi)) in factors.iter().zip(&parts) {
                let here = arriving * factor / (mean * factors.len() as f64);
                sums.iter_mut().zip(psi).for_each(|(sum, psi)| *sum += here * psi);
            }
        }
        sums
    }

    /// Adds the irradiance that `sent` · ψ/π, sent out by a patch, causes where one half of its rays land.
    fn send(&self, i: usize, half: usize, sent: [f64; 2], change: &mut DMatrix<f64>) {
        let Some(row) = self.rows.of(self.patches.slot_of_patch(i)) else { return };
        let etendues = self.patches.etendues();
        let worth = etendues[i] * HALVES as f64 / row.landings.len() as f64;
        for (psi, j) in self.rays(row, half) {
            let flux = worth * (psi[0] * sent[0] + psi[1] * sent[1]);
            change[(j, self.channel)] += flux / etendues[j];
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

/// Equal parts of a triangle, with the linear functions at their centres.
fn parts_of([a, b, c]: [DVec3; 3]) -> Vec<([DVec3; 3], [f64; 2])> {
    let at = |[u, v]: [f64; 2]| a + (b - a) * u + (c - a) * v;
    let mut parts = Vec::with_capacity(PARTS * PARTS);
    let mut add = |corners: [[usize; 2]; 3]| {
        let corners = corners.map(|corner| corner.map(|x| x as f64 / PARTS as f64));
        let [u, v] = [0, 1].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0);
        parts.push((corners.map(at), linear([1.0 - u - v, u, v])));
    };
    for (i, j) in (0..PARTS).flat_map(|i| (0..PARTS - i).map(move |j| (i, j))) {
        add([[i, j], [i + 1, j], [i, j + 1]]);
        if i + j + 1 < PARTS {
            add([[i + 1, j + 1], [i, j + 1], [i + 1, j]]);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_functions_are_orthonormal_on_a_triangle() {
        let parts = crate::trace::sampling::TRIANGLE_RULE_7;
        let mean = |f: &dyn Fn([f64; 2]) -> f64| -> f64 {
            parts.iter().map(|&([u, v], part)| part * f(linear([1.0 - u - v, u, v]))).sum()
        };
        for (k, exact) in [(0, 0.0), (1, 0.0)] {
            assert!((mean(&|psi| psi[k]) - exact).abs() < 1e-14);
        }
        assert!((mean(&|[x, y]| x * y)).abs() < 1e-14);
        for k in 0..2 {
            assert!((mean(&|psi| psi[k] * psi[k]) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn parts_make_up_the_triangle() {
        let corners = [DVec3::ZERO, 2.0 * DVec3::X, DVec3::new(0.3, 1.0, 0.0)];
        let parts = parts_of(corners);
        assert_eq!(parts.len(), PARTS * PARTS);
        let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).z;
        for (part, _) in &parts {
            assert!((area(*part) * 16.0 - area(corners)).abs() < 1e-12, "all wound alike");
        }
    }
}
