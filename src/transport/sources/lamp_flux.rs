//! Lamp flux: where the light of lamps goes, for runs that leave interreflection out.
//!
//! Pairs of points on patches and lamps tell what arrives straight. What does not is estimated on its own, by
//! rays from the lamps: a patch j with étendue πM_j is chosen with probability p_j, and each of N rays from
//! it carries the flux π M_j Lₑ / (N p_j) to where it ends. So neither estimate follows from the other, and
//! with what lamps emit they test each other.

use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{PARTS, TASK};
use crate::patches::Patches;
use crate::trace::sampling::{Discrete, SEQUENCE_END, Stream, uniform_triangle};
use crate::trace::{Destination, Tint, Tracer};
use crate::transport::rows::{ABSORBED, ESCAPED, LOST};

/// Where the light of lamps goes: flux per channel, in W by `unit`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LampFlux {
    /// What reaches patches straight, by pairs of points.
    pub arrived: Vec<f64>,
    /// What leaves the scene or lands straight on sides that are no patches; by rays from lamps, as the next
    /// two.
    pub escaped: Vec<f64>,
    /// What carriers absorb.
    pub absorbed: Vec<f64>,
    /// What carriers pass on to surfaces, which runs without interreflection leave out, and what is given up.
    pub lost: Vec<f64>,
    /// One standard error of the sum of these four, estimated from eight parts of pairs and rays. Parts of
    /// pairs share a sequence and differ more than independent ones would: it is rather too large than too
    /// small.
    pub standard_error: Vec<f64>,
    /// The unit of area in which it was traced, m².
    pub unit: f64,
}

/// How many rays lamps send, and by which random sequence.
pub(super) struct LampRays {
    pub number: u64,
    pub seed: u64,
}

impl LampFlux {
    /// Sends rays from the lamps, at most 2¹⁶ for each of eight parts. `emitted` is Lₑ per patch (n × c),
    /// `arrived` what each eighth of the pairs adds to the flux that arrives, per channel.
    pub(super) fn trace(
        tracer: &Tracer,
        patches: &Patches,
        emitted: &DMatrix<f64>,
        arrived: &[Vec<f64>],
        rays: LampRays,
    ) -> Self {
        let per_part = (rays.number / PARTS as u64).clamp(1, u64::from(SEQUENCE_END)) as u32;
        let missing = Senders::new(tracer, patches, emitted, rays.seed).missing(per_part);
        let of_channels = |value: &dyn Fn(usize) -> f64| (0..emitted.ncols()).map(value).collect();
        let mean =
            |c: usize, kind: usize| missing.iter().map(|part| part[c][kind]).sum::<f64>() / PARTS as f64;
        Self {
            arrived: of_channels(&|c| arrived.iter().map(|part| part[c]).sum()),
            escaped: of_channels(&|c| mean(c, ESCAPED)),
            absorbed: of_channels(&|c| mean(c, ABSORBED)),
            lost: of_channels(&|c| mean(c, LOST)),
            unit: patches.unit_of_area(),
            standard_error: of_channels(&|c| {
                let whole =
                    |part: usize| PARTS as f64 * arrived[part][c] + missing[part][c].iter().sum::<f64>();
                standard_error(&std::array::from_fn(whole))
            }),
        }
    }
}

/// One standard error of the mean of parts.
fn standard_error(parts: &[f64; PARTS]) -> f64 {
    let count = PARTS as f64;
    let mean = parts.iter().sum::<f64>() / count;
    (parts.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count * (count - 1.0))).sqrt()
}

/// What does not arrive, per channel.
type Missing = Vec<[f64; 3]>;

/// The patches that emit.
struct Senders<'a> {
    tracer: &'a Tracer<'a>,
    patches: &'a Patches<'a>,
    /// Per sender its patch, and its radiance averaged over channels.
    all: Vec<(usize, f64)>,
    /// By π M Lₑ, averaged over channels.
    by_power: Discrete,
    seed: u64,
}

impl<'a> Senders<'a> {
    fn new(tracer: &'a Tracer, patches: &'a Patches, emitted: &DMatrix<f64>, seed: u64) -> Self {
        let radiance = emitted.row_iter().map(|row| row.mean());
        let all: Vec<(usize, f64)> = radiance.enumerate().filter(|&(_, radiance)| radiance > 0.0).collect();
        let power = |&(patch, radiance): &(usize, f64)| PI * patches.normalised_etendues()[patch] * radiance;
        let by_power = Discrete::new(all.iter().map(power));
        Self { by_power, tracer, patches, all, seed }
    }

    /// What does not arrive of all their light, estimated by each part of the rays.
    fn missing(&self, per_part: u32) -> Vec<Missing> {
        let channels = self.tracer.scene().channels();
        let mut sums = vec![vec![[0.0; 3]; channels]; PARTS];
        if self.all.is_empty() {
            return sums;
        }
        let tasks = per_part.div_ceil(TASK);
        let task = |k: u32| {
            let (part, first) = ((k / tasks) as usize, k % tasks * TASK);
            self.follow(part, first..per_part.min(first + TASK), per_part)
        };
        let found: Vec<Missing> = (0..PARTS as u32 * tasks).into_par_iter().map(task).collect();
        // Sum up in a fixed order.
        for (k, found) in found.into_iter().enumerate() {
            for (sums, found) in sums[k / tasks as usize].iter_mut().zip(found) {
                sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found);
            }
        }
        sums
    }

    /// Follows some rays of a part to where they end.
    fn follow(&self, part: usize, points: Range<u32>, per_part: u32) -> Missing {
        let channels = self.tracer.scene().channels();
        let (mut missing, mut left) = (vec![[0.0; 3]; channels], vec![1.0; channels]);
        let sequence = Stream::LampRays.sequence(self.seed, 0, part as u64);
        let total = self.by_power.total();
        for point in points {
            // Choose a sender by its power.
            let [chance, ..] = sequence.dimensions(point, 1);
            let goal = total * (f64::from(point) + chance) / f64::from(per_part);
            let (patch, radiance) = self.all[self.by_power.draw_at(goal).0];
            let facet = self.patches.facet(self.tracer, self.patches.slot_of_patch(patch));
            let Some(ray) = facet.rays(sequence, point..point + 1).next() else { continue };
            // Follow a ray from it, dimmed by carriers in every channel.
            left.fill(1.0);
            let numbers = |k: u32| sequence.dimensions(point, k + 2);
            let dims = |tint: Tint, _: f64| {
                left.iter_mut().zip(tint.parts()).for_each(|(left, part)| *left *= part);
                left.iter().any(|&left| left > 0.0)
            };
            let end = match self.tracer.destination(&ray, numbers, dims) {
                Destination::Diffuse { hit, carried: false } => {
                    match self.patches.patch_at(hit.face as usize, hit.side, hit.barycentrics) {
                        Some(_) => continue,
                        None => ESCAPED,
                    }
                }
                Destination::Away(_) => ESCAPED,
                Destination::Absorbed => ABSORBED,
                Destination::Diffuse { carried: true, .. } | Destination::Lost => LOST,
            };
            // Add its flux where it ends, and what carriers took of it.
            let worth = total / (f64::from(per_part) * radiance);
            let [s, t, ..] = sequence.point(point);
            let emission = self.emission(patch, uniform_triangle([s, t]));
            for ((missing, emission), left) in missing.iter_mut().zip(emission).zip(&left) {
                missing[end] += worth * emission * left;
                missing[ABSORBED] += worth * emission * (1.0 - left);
            }
        }
        missing
    }

    /// Emitted radiance Lₑ, per channel, at the point of a patch with these weights of its second and third
    /// corner.
    fn emission(&self, patch: usize, [u, v]: [f64; 2]) -> impl Iterator<Item = f64> {
        let scene = self.tracer.scene();
        let face = self.patches.place(patch).face;
        let factors = scene.emission_texture(face).map(|texture| {
            let [a, b, c] = self.patches.corners(patch);
            texture.at([0, 1].map(|k| a[k] + (b[k] - a[k]) * u + (c[k] - a[k]) * v))
        });
        let emission = scene.material_of(face).emission.iter().enumerate();
        emission.map(move |(c, emission)| emission * factors.map_or(1.0, |factors| factors[c]))
    }
}
