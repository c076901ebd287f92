//! Density: how full the exchange matrix will be, told from the shape alone, without a ray.
//!
//! Between patches i and j some N (F_ij + F_ji) rays go, so that an entry is there with probability 1 −
//! exp(−N (F_ij + F_ji)). F is taken from pairs of random points as cos θ cos θ′ A_j / (π r² + A_j). What
//! stands in between is not looked at; but where a row sums to more than 1, some of it must hide the rest,
//! and pairs are taken to see each other with a chance that fades with distance as exp(−κr), κ such that it
//! sums to 1. The number of entries comes out within a tenth where nothing hides anything, and within a third
//! in furnished rooms.

use glam::DVec3;

use super::constants::{
    DENSITY_CARRIERS, DENSITY_COLUMNS, DENSITY_ROWS, FADING_HALVINGS, MOST_FADING, PAIR_BLOCK_BYTES,
    PAIR_RAY_BYTES,
};
use crate::patches::{Outlook, Stretch};
use crate::scene::Side;
use crate::scene::triangle;
use crate::trace::sampling::{Discrete, Stream, uniform_triangle};
use crate::trace::{IN_PLANE, Lamps, Tracer};
use crate::transport::rows::RayCount;

/// What a patch exchanges with others, on the average over patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Density {
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
    /// Looks at pairs of points; `block` is the number of rays from which on a pair of linear elements is
    /// kept as a block.
    pub fn new(tracer: &Tracer, outlook: &Outlook, lamps: &Lamps, count: RayCount, block: usize) -> Self {
        let places = Places::new(tracer, &outlook.patches_of, lamps, outlook.stretches.iter().copied());
        let whole = |face: usize| Stretch { face, corners: *tracer.corners(face), cells: 1.0 };
        let faces = (0..outlook.carriers.len()).map(whole);
        let carriers = Places::new(tracer, &outlook.carriers, lamps, faces);
        let rows = places.draw(DENSITY_ROWS, Stream::ForecastRows, [1.0, 0.0]);
        let columns = places.draw(DENSITY_COLUMNS, Stream::ForecastColumns, [0.5; 2]);
        let carriers = carriers.draw(DENSITY_CARRIERS, Stream::ForecastCarriers, [0.0, 1.0]);
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
            let seen_by = |place: &Place| (-fade * place.point.distance(row.point)).exp();
            let visible: Vec<f64> = columns.iter().map(seen_by).collect();
            let whole = factors.clone();
            factors.iter_mut().zip(&visible).for_each(|(f, seen)| *f *= seen);
            to_carriers.iter_mut().zip(&carriers).for_each(|(f, place)| *f *= seen_by(place));
            let straight: f64 = factors.iter().zip(&columns).map(|(f, place)| f * place.weight).sum();
            let met: f64 = to_carriers.iter().zip(&carriers).map(|(f, place)| f * place.weight).sum();
            let carried: f64 =
                to_carriers.iter().zip(&carriers).map(|(f, place)| f * place.weight * place.passes).sum();
            sums.landing += straight + carried;
            sums.carried += met;
            // What carriers pass on is taken to land anywhere.
            let anywhere = carried / outlook.patches();
            for (k, column) in columns.iter().enumerate() {
                // Of a pair that sees each other every ray counts, of one that does not none; what carriers
                // pass on comes beside it.
                let (f, rays) = (factors[k] + anywhere, f64::from(count.rays));
                let back = 1.0 + row.area / column.area;
                let chance = |straight: f64, carried: f64| {
                    1.0 - (1.0 - visible[k] * (1.0 - (-straight).exp())) * (-carried).exp()
                };
                let [one_way, around] = [rays * whole[k], rays * anywhere];
                let [found, entry, bytes] = if column.is_lamp == row.is_lamp {
                    let bytes = visible[k] * bytes_of_pair(one_way * back, block)
                        + bytes_of_pair(around * back, block);
                    [chance(one_way, around), chance(one_way * back, around * back), bytes]
                } else if f > 0.0 {
                    let seen = visible[k] * found_by_pairs;
                    [0.5 * seen, seen, PAIR_BLOCK_BYTES * seen]
                } else {
                    [0.0; 3]
                };
                sums.found += column.weight * found;
                sums.entries += column.weight * entry;
                sums.pair_bytes += column.weight * bytes;
                sums.reflected += column.weight * f * column.reflectance;
            }
        }
        let mean = |sum: f64| sum / f64::from(DENSITY_ROWS);
        let Self { found, entries, pair_bytes, landing, carried, reflected } = sums;
        // Every ray makes two entries at most.
        let most = 2.0 * (f64::from(count.rays) * mean(landing) + f64::from(count.lamp_rays));
        Self {
            found: mean(found),
            entries: mean(entries).min(most),
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
    let (mut low, mut high) = (0.0, MOST_FADING);
    if sum(low) <= 1.0 {
        return 0.0;
    }
    for _ in 0..FADING_HALVINGS {
        let middle = 0.5 * (low + high);
        if sum(middle) > 1.0 { low = middle } else { high = middle }
    }
    high
}

/// Bytes of a pair between which so many rays are expected: those of the rays, or from `block` rays on those
/// of a block.
fn bytes_of_pair(rays: f64, block: usize) -> f64 {
    let (mut chance, mut few, mut bytes) = ((-rays).exp(), 0.0, 0.0);
    for k in 0..block {
        few += chance;
        bytes += PAIR_RAY_BYTES * k as f64 * chance;
        chance *= rays / (k + 1) as f64;
    }
    bytes + PAIR_BLOCK_BYTES * (1.0 - few)
}

/// cos θ cos θ′ A / (π r² + A), no more than the cosine.
fn form_factor(from: &Place, to: &Place) -> f64 {
    let between = to.point - from.point;
    let squared = between.length_squared();
    let (here, there) = (from.normal.dot(between), -to.normal.dot(between));
    if here.min(there) <= IN_PLANE {
        return 0.0;
    }
    here * there / squared * to.area / (std::f64::consts::PI * squared + to.area)
}

/// All stretches of sides that have patches, to draw places from.
pub(super) struct Places<'a, 's> {
    tracer: &'a Tracer<'s>,
    is_lamp: Vec<bool>,
    sides: Vec<(Stretch, Side)>,
    /// Entries of `sides` by number of patches, and by area.
    by: [Discrete; 2],
}

impl<'a, 's> Places<'a, 's> {
    /// Those of `stretches` that have patches by `counts`, per face and side.
    pub fn new(
        tracer: &'a Tracer<'s>,
        counts: &[[f64; 2]],
        lamps: &Lamps,
        stretches: impl Iterator<Item = Stretch>,
    ) -> Self {
        let mut is_lamp = vec![false; counts.len()];
        lamps.faces().for_each(|face| is_lamp[face as usize] = true);
        let mut sides: Vec<(Stretch, Side)> = Vec::new();
        for stretch in stretches {
            let with_patches = Side::BOTH.into_iter().zip(counts[stretch.face]).filter(|side| side.1 > 0.0);
            sides.extend(with_patches.map(|(side, _)| (stretch, side)));
        }
        let by_count = Discrete::new(sides.iter().map(|(stretch, _)| stretch.cells));
        let by_area = Discrete::new(sides.iter().map(|(stretch, _)| triangle::area(&stretch.corners)));
        Self { tracer, is_lamp, sides, by: [by_count, by_area] }
    }

    pub fn tracer(&self) -> &'a Tracer<'s> {
        self.tracer
    }

    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// The stretch of a side that a random number draws, each by its number of patches.
    pub fn by_number(&self, random: f64) -> (Stretch, Side) {
        self.sides[self.by[0].draw(random).0]
    }

    /// Draws places, these parts of them by number of patches and by area.
    fn draw(&self, number: u32, stream: Stream, parts: [f64; 2]) -> Vec<Place> {
        let totals = self.by.each_ref().map(Discrete::total);
        let split = (f64::from(number) * parts[0]) as u32;
        let place = |k: u32| {
            let [which, s, t, _] = stream.sequence(0, 0, 0).point(k);
            let (drawn, _) = self.by[usize::from(k >= split)].draw(which);
            let (Stretch { face, corners, cells: count }, side) = self.sides[drawn];
            let area = triangle::area(&corners);
            // Density of this very patch among all draws.
            let density = parts[0] / totals[0] + parts[1] * area / count / totals[1];
            let material = self.tracer.scene().material_of(face);
            Place {
                point: triangle::point(&corners, uniform_triangle([s, t])),
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
