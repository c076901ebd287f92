//! Density: how full the exchange matrix will be, told from the shape alone before a ray is traced.
//!
//! Between patches i and j some N (F_ij + F_ji) rays go, so that an entry is there with probability 1 − exp(−N (F_ij + F_ji)).
//! F is taken from pairs of random points as cos θ cos θ′ A_j / (π r² + A_j). What stands in between is not looked at; but where a row
//! sums to more than 1, some of it must hide the rest, and form factors are taken to fade with distance as exp(−κr), κ such that it
//! sums to 1. The number of entries comes out within a tenth where nothing hides anything, and within a third in furnished rooms.

use glam::DVec3;

use super::recipe::RayCount;
use crate::patches::Outlook;
use crate::scene::Side;
use crate::trace::sampling::{Sequence, uniform_triangle};
use crate::trace::{Lamps, Tracer};

/// Points from which pairs are looked at, and to which.
const ROWS: u32 = 192;
const COLUMNS: u32 = 768;
const CARRIERS: u32 = 128;

/// The streams of their random sequences.
const ROW_STREAM: u64 = 1 << 57;
const COLUMN_STREAM: u64 = 1 << 58;
const CARRIER_STREAM: u64 = 1 << 59;

/// What a patch exchanges with others, on the average over patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Density {
    /// Patches of which its rays find any.
    pub found: f64,
    /// Entries in its row of the matrix.
    pub entries: f64,
    /// Bytes that its row takes by pairs, for linear elements.
    pub pair_bytes: f64,
    /// The part of its rays that lands on patches.
    pub landing: f64,
    /// The part of its rays that meets mirrors or glass.
    pub carried: f64,
    /// The largest mean of what goes on from where they land, over channels, times that part.
    pub reflected: f64,
}

/// A random point that stands for patches.
struct Place {
    point: DVec3,
    normal: DVec3,
    area: f64,
    reflectance: f64,
    /// The part of light that goes on from a carrier.
    passes: f64,
    is_lamp: bool,
    /// How many patches it stands for.
    weight: f64,
}

impl Density {
    /// Looks at pairs of points; `block` is the number of rays from which on a pair of linear elements is kept as a block.
    pub fn new(tracer: &Tracer, outlook: &Outlook, lamps: &Lamps, count: RayCount, block: usize) -> Self {
        let places = Places::new(tracer, &outlook.patches_of, lamps);
        let carriers = Places::new(tracer, &outlook.carriers, lamps);
        let rows = places.draw(ROWS, ROW_STREAM, [1.0, 0.0]);
        let columns = places.draw(COLUMNS, COLUMN_STREAM, [0.5; 2]);
        let carriers = carriers.draw(CARRIERS, CARRIER_STREAM, [0.0, 1.0]);
        let lamp_patches: f64 = lamps.faces().map(|face| outlook.patches_of[face as usize][0]).sum();
        let found_by_pairs = 1.0 - (-f64::from(count.lamp_rays) / lamp_patches.max(1.0)).exp();
        let mut sums = Self::default();
        for row in &rows {
            let mut factors: Vec<f64> = columns.iter().map(|column| form_factor(row, column)).collect();
            let mut to_carriers: Vec<f64> =
                carriers.iter().map(|carrier| form_factor(row, carrier)).collect();
            let seen = || columns.iter().chain(&carriers);
            let all = factors.iter().chain(&to_carriers).zip(seen());
            let parts: Vec<[f64; 2]> =
                all.map(|(f, place)| [f * place.weight, place.point.distance(row.point)]).collect();
            let fade = fading(&parts);
            let faded =
                |(f, place): (&mut f64, &Place)| *f *= (-fade * place.point.distance(row.point)).exp();
            factors.iter_mut().chain(&mut to_carriers).zip(seen()).for_each(faded);
            let straight: f64 = factors.iter().zip(&columns).map(|(f, place)| f * place.weight).sum();
            let met: f64 = to_carriers.iter().zip(&carriers).map(|(f, place)| f * place.weight).sum();
            let carried: f64 =
                to_carriers.iter().zip(&carriers).map(|(f, place)| f * place.weight * place.passes).sum();
            sums.landing += straight + carried;
            sums.carried += met;
            // What carriers pass on is taken to land anywhere.
            let anywhere = carried / outlook.patches();
            for (f, column) in factors.iter().zip(&columns) {
                let f = f + anywhere;
                let one_way = f64::from(count.rays) * f;
                let both = one_way * (1.0 + row.area / column.area);
                let [found, entry, bytes] = if column.is_lamp == row.is_lamp {
                    [1.0 - (-one_way).exp(), 1.0 - (-both).exp(), bytes_of_pair(both, block)]
                } else if f > 0.0 {
                    [0.5 * found_by_pairs, found_by_pairs, 40.0 * found_by_pairs]
                } else {
                    [0.0; 3]
                };
                sums.found += column.weight * found;
                sums.entries += column.weight * entry;
                sums.pair_bytes += column.weight * bytes;
                sums.reflected += column.weight * f * column.reflectance;
            }
        }
        let mean = |sum: f64| sum / f64::from(ROWS);
        let Self { found, entries, pair_bytes, landing, carried, reflected } = sums;
        Self {
            found: mean(found),
            entries: mean(entries),
            pair_bytes: mean(pair_bytes),
            landing: mean(landing),
            carried: mean(carried),
            reflected: mean(reflected),
        }
    }
}

/// The κ at which parts [f, r] sum to no more than 1 as f exp(−κr).
fn fading(parts: &[[f64; 2]]) -> f64 {
    let sum = |fade: f64| parts.iter().map(|[f, r]| f * (-fade * r).exp()).sum::<f64>();
    let (mut low, mut high) = (0.0, 64.0);
    if sum(low) <= 1.0 {
        return 0.0;
    }
    for _ in 0..16 {
        let middle = 0.5 * (low + high);
        if sum(middle) > 1.0 { low = middle } else { high = middle }
    }
    high
}

/// Bytes of a pair between which so many rays are expected: 8 a ray, or 40 from `block` rays on.
fn bytes_of_pair(rays: f64, block: usize) -> f64 {
    let (mut chance, mut few, mut bytes) = ((-rays).exp(), 0.0, 0.0);
    for k in 0..block {
        few += chance;
        bytes += 8.0 * k as f64 * chance;
        chance *= rays / (k + 1) as f64;
    }
    bytes + 40.0 * (1.0 - few)
}

/// cos θ cos θ′ A / (π r² + A), no more than the cosine.
fn form_factor(from: &Place, to: &Place) -> f64 {
    let between = to.point - from.point;
    let squared = between.length_squared();
    let (here, there) = (from.normal.dot(between), -to.normal.dot(between));
    if here <= 0.0 || there <= 0.0 {
        return 0.0;
    }
    here * there / squared * to.area / (std::f64::consts::PI * squared + to.area)
}

/// All sides of faces that have patches, to draw places from.
struct Places<'a, 's> {
    tracer: &'a Tracer<'s>,
    /// Per face and side.
    counts: &'a [[f64; 2]],
    is_lamp: Vec<bool>,
    sides: Vec<(usize, Side)>,
    /// Cumulative numbers of patches, and areas, per entry of `sides`.
    by: [Vec<f64>; 2],
}

impl<'a, 's> Places<'a, 's> {
    fn new(tracer: &'a Tracer<'s>, counts: &'a [[f64; 2]], lamps: &Lamps) -> Self {
        let mut is_lamp = vec![false; counts.len()];
        lamps.faces().for_each(|face| is_lamp[face as usize] = true);
        let mut places = Self { tracer, counts, is_lamp, sides: Vec::new(), by: [Vec::new(), Vec::new()] };
        let mut sums = [0.0; 2];
        for face in 0..counts.len() {
            for side in Side::BOTH {
                let count = places.count(face, side);
                if count > 0.0 {
                    sums[0] += count;
                    sums[1] += places.area(face);
                    places.sides.push((face, side));
                    places.by.iter_mut().zip(sums).for_each(|(by, sum)| by.push(sum));
                }
            }
        }
        places
    }

    fn count(&self, face: usize, side: Side) -> f64 {
        self.counts[face][usize::from(side == Side::Back)]
    }

    fn area(&self, face: usize) -> f64 {
        let [a, b, c] = *self.tracer.corners(face);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Draws places, these parts of them by number of patches and by area.
    fn draw(&self, number: u32, stream: u64, parts: [f64; 2]) -> Vec<Place> {
        let totals = self.by.each_ref().map(|by| by.last().copied().unwrap_or(0.0));
        let split = (f64::from(number) * parts[0]) as u32;
        let place = |k: u32| {
            let [which, s, t, _] = Sequence::new(0, stream, 0).point(k);
            let kind = usize::from(k >= split);
            let goal = which * totals[kind];
            let at = self.by[kind].partition_point(|&sum| sum <= goal).min(self.sides.len() - 1);
            let (face, side) = self.sides[at];
            let [a, b, c] = *self.tracer.corners(face);
            let [u, v] = uniform_triangle([s, t]);
            let (count, area) = (self.count(face, side), self.area(face));
            // Density of this very patch among all draws.
            let density = parts[0] / totals[0] + parts[1] * area / count / totals[1];
            let material = self.tracer.scene().material_of(face);
            Place {
                point: a + (b - a) * u + (c - a) * v,
                normal: self.tracer.normal(face, side),
                area: area / count,
                reflectance: material.highest_albedo(side),
                passes: material
                    .surface
                    .colour()
                    .map_or(1.0, |part| part.iter().sum::<f64>() / part.len() as f64),
                is_lamp: self.is_lamp[face] && side == Side::Front,
                weight: 1.0 / (density * f64::from(number)),
            }
        };
        if self.sides.is_empty() { Vec::new() } else { (0..number).map(place).collect() }
    }
}
