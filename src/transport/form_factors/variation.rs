//! Variation: what it changes elsewhere that the light of lamps varies within a patch, to first order,
//! without new rays.
//!
//! Irradiance on a patch is taken to be even. What lamps near it send to each of its parts is given by
//! Lambert's formula, as far as they are seen; so it is known how far radiance on each part is from the mean.
//! That arrives on lamps as far as Lambert's formula says, by reciprocity, and elsewhere where the patch's
//! own rays land: each stands for the part that it starts on.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::FormFactors;
use super::constants::{CUTS, NEAR_LAMP};
use crate::patches::Patches;
use crate::scene::Side;
use crate::scene::triangle;
use crate::trace::form_factor_between;
use crate::transport::TransportError;
use crate::transport::exchange::Outcome;
use crate::transport::rows::{Row, Rows, origins};

/// Two halves of the rays.
const HALVES: usize = 2;

impl FormFactors {
    /// How irradiance changes (n × c, W·m⁻²) where the light of lamps varies within patches that are near
    /// them, to first order, as either half of the rays has it: the product of both estimates the square
    /// without bias. `radiance` (n × c, W·sr⁻¹·m⁻²) is that of constant elements.
    ///
    /// # Errors
    /// `NoRays` unless the rays were kept.
    pub(crate) fn varied(
        &self,
        patches: &Patches,
        radiance: &DMatrix<f64>,
    ) -> Result<[DMatrix<f64>; HALVES], TransportError> {
        let mut changes = [0; HALVES].map(|_| DMatrix::zeros(radiance.nrows(), radiance.ncols()));
        if self.rays() == 0 {
            return Ok(changes);
        }
        let rows = self.rows().ok_or(TransportError::NoRays)?;
        let reflectances = patches.reflectances();
        let setting = Setting::new(rows, patches);
        let near: Vec<(usize, Vec<Seen>)> = (0..patches.len())
            .into_par_iter()
            .map(|i| (i, setting.near_lamps(i)))
            .filter(|(_, near)| !near.is_empty())
            .collect();
        for (i, near) in &near {
            for c in 0..radiance.ncols() {
                let uneven = setting.uneven(near, (radiance, c));
                let beside: Vec<f64> = uneven.iter().map(|h| reflectances[(*i, c)] * h).collect();
                let sent = Sent { patch: *i, near, beside: &beside, tone: self.tone_of(c), channel: c };
                setting.send(&sent, &mut changes);
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

/// What a patch sends beside its mean.
struct Sent<'a> {
    patch: usize,
    /// The lamp faces near it.
    near: &'a [Seen],
    /// π times the radiance beside the mean, by parts.
    beside: &'a [f64],
    tone: usize,
    channel: usize,
}

/// Where light goes.
struct Setting<'a> {
    rows: &'a Rows,
    patches: &'a Patches<'a>,
    is_lamp: Vec<bool>,
}

impl<'a> Setting<'a> {
    fn new(rows: &'a Rows, patches: &'a Patches<'a>) -> Self {
        let is_lamp = (0..patches.len()).map(|i| rows.is_lamp(patches, i)).collect();
        Self { rows, patches, is_lamp }
    }

    fn row(&self, i: usize) -> Option<&'a Row> {
        self.rows.of(self.patches.slot_of_patch(i))
    }

    /// The lamp faces near a patch that it sees.
    fn near_lamps(&self, i: usize) -> Vec<Seen> {
        let Some(row) = self.row(i).filter(|row| !row.lamps.shares.is_empty()) else { return Vec::new() };
        let place = self.patches.place(i);
        let corners = self.patches.corners(i).map(|at| self.patches.point(place.face, at));
        let turn = if place.side == Side::Back { -1.0 } else { 1.0 };
        let facing = turn * triangle::normal(&corners);
        let centre = corners.iter().sum::<DVec3>() / 3.0;
        let reach = NEAR_LAMP * corners.iter().map(|corner| corner.distance(centre)).fold(0.0, f64::max);
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
            let from =
                |part: &[DVec3; 3]| form_factor_between((part, facing), (&there, triangle::normal(&there)));
            let mut of_parts: Vec<f64> = parts_of(corners).iter().map(from).collect();
            let mean = of_parts.iter().sum::<f64>() / of_parts.len() as f64;
            of_parts.iter_mut().for_each(|factor| *factor *= share / mean);
            (mean > 0.0).then_some(Seen { lamp, of_parts })
        };
        lamps.filter(is_near).filter_map(seen).collect()
    }

    /// How far irradiance on each part is from the mean, W·m⁻².
    fn uneven(&self, near: &[Seen], (radiance, channel): (&DMatrix<f64>, usize)) -> Vec<f64> {
        let mut parts = vec![0.0; CUTS * CUTS];
        for Seen { lamp, of_parts } in near {
            let on_lamp = self.patches.patches_of(*lamp, Side::Front);
            let count = on_lamp.len().max(1) as f64;
            let arriving = PI * on_lamp.map(|j| radiance[(j, channel)]).sum::<f64>() / count;
            let mean = of_parts.iter().sum::<f64>() / of_parts.len() as f64;
            parts.iter_mut().zip(of_parts).for_each(|(sum, factor)| *sum += arriving * (factor - mean));
        }
        parts
    }

    /// Adds the irradiance that what a patch sends causes elsewhere.
    fn send(&self, sent: &Sent, changes: &mut [DMatrix<f64>; HALVES]) {
        let &Sent { patch: i, near, beside, tone, channel } = sent;
        let Some(row) = self.row(i) else { return };
        let etendues = self.patches.normalised_etendues();
        let each = row.landings.len() / HALVES;
        let mut origins = origins(row.slot, self.rows.recipe);
        for (half, change) in changes.iter_mut().enumerate() {
            let ends = row.ends(half * each..(half + 1) * each, tone);
            for (end, from) in ends.zip(&mut origins) {
                let Outcome::Met { patch, .. } = Outcome::of(end, self.patches) else { continue };
                let j = patch as usize;
                if self.is_lamp[i] || !self.is_lamp[j] {
                    let flux = etendues[i] / each as f64 * beside[part_at(from.weights())];
                    change[(j, channel)] += flux / etendues[j];
                }
            }
        }
        for Seen { lamp, of_parts } in near {
            let on_lamp = self.patches.patches_of(*lamp, Side::Front);
            let sum: f64 = of_parts.iter().zip(beside).map(|(factor, beside)| factor * beside).sum();
            let flux = etendues[i] * sum / of_parts.len() as f64;
            let area: f64 = on_lamp.clone().map(|j| etendues[j]).sum();
            for j in on_lamp {
                changes.iter_mut().for_each(|change| change[(j, channel)] += flux / area);
            }
        }
    }
}

/// Equal parts of a triangle, row after row along the first leg, each upright one followed by the one that
/// stands on its head.
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

    #[test]
    fn parts_make_up_the_triangle_and_are_found_by_their_points() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let parts = parts_of(corners);
        assert_eq!(parts.len(), CUTS * CUTS);
        for (k, part) in parts.into_iter().enumerate() {
            assert!((triangle::across(&part).z * (CUTS * CUTS) as f64 - 1.0).abs() < 1e-12, "wound alike");
            for at in [[0.1, 0.1], [0.8, 0.1], [0.1, 0.8]] {
                let p = triangle::point(&part, at);
                assert_eq!(part_at(triangle::weights([p.x, p.y])), k);
            }
        }
    }
}
