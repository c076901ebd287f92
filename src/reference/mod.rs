//! Reference: what answers are held against. The path tracer is an independent witness, the light on every
//! patch by following random light paths on the surfaces themselves.
//!
//! Light from points and suns that mirrors and glass throw on surfaces is found by no path that starts where
//! light is wanted, and the spot of a light right before a surface by hardly any; photons bring both, from
//! the other end. It shares nothing with the solvers but the scene, the tracer and the numbering of patches:
//! no form factors, no patches that are bright or dark all over. It is unbiased, and says how far off it may
//! be by standard errors.

mod beams;
mod estimate;
mod lights;
mod near;
mod photons;
mod rounds;
mod surroundings;
mod table;
mod walk;

use std::f64::consts::FRAC_1_PI;
use std::ops::Range;
use std::time::Instant;

use rayon::prelude::*;

pub use estimate::{Estimate, PathTraced};
pub use rounds::Budget;
pub use table::{ReferenceError, ReferenceRow};

use crate::patches::{MOST_SLOTS, Patches};
use crate::progress::{Cancelled, Progress};
use crate::scene::Side;
use crate::trace::sampling::{Sampler, Sequence, Stream};
use crate::trace::{Hit, Ray, RayHit, Tracer};
use estimate::Half;
use photons::{Throw, Thrower};
use rounds::{Round, first_round, next_round};
use walk::{Beyond, Met, Start, Walker};

/// Why no light paths were traced, or not to their end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// Nothing would end the work, or before it begins.
    #[error(
        "a path tracer needs a budget: a standard error, a time or a number of paths, each above 0 where it is given"
    )]
    Budget,
    /// The observer asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Every slot has two offsets into the stream of paths, one a half.
const _: () = assert!(2 * MOST_SLOTS - 1 <= u32::MAX as u64);

/// Patches between two reports of progress.
const CHUNK: usize = 512;

/// How to trace paths.
#[derive(Clone, Copy, Debug)]
pub struct PathOptions<'a> {
    /// When to stop.
    pub budget: Budget,
    /// Bounces that are kept apart; memory grows in proportion, 32 bytes a patch, bounce and channel.
    pub bounces: usize,
    /// The longest paths, in reflections after the first bounce of light from lamps; `None` for all there
    /// are. Anything else is biased: it leaves out later bounces, to compare with other programs or truncated
    /// series.
    pub longest: Option<usize>,
    /// Number of the random sequences. With a budget of paths or of standard error the same seed gives the
    /// same bits.
    pub seed: u64,
    /// Where to report progress, as stage `reference`.
    pub progress: Progress<'a>,
}

impl Default for PathOptions<'_> {
    /// A relative standard error of 1 %, bounces 1 to 6 kept apart, paths of any length.
    fn default() -> Self {
        Self {
            budget: Budget { standard_error: Some(0.01), ..Budget::default() },
            bounces: 6,
            longest: None,
            seed: 0,
            progress: Progress::default(),
        }
    }
}

/// A path tracer for scenes of diffuse surfaces, mirrors, glass, rough conductors and plastic.
#[derive(Debug)]
pub struct PathTracer<'t, 's> {
    walker: Walker<'t, 's>,
    thrower: Option<Thrower>,
}

/// A round, when so many paths of so many are done.
struct Pace {
    round: Round,
    done: f64,
    all: f64,
}

/// Some batches of a patch and half.
struct Run {
    patch: usize,
    half: usize,
    batches: Range<u32>,
    /// Paths of each.
    size: u32,
}

impl<'t, 's> PathTracer<'t, 's> {
    /// Makes the scene's lamps known to it.
    pub fn new(tracer: &'t Tracer<'s>) -> Self {
        Self { walker: Walker::new(tracer), thrower: Thrower::new(tracer) }
    }

    /// Radiance that arrives along `ray`, per channel, W·sr⁻¹·m⁻²: one path, by point `k` of `sequence` from
    /// dimension set 1 on. Adds it to `radiance`; answers what the ray met first. What only photons bring is
    /// not part of it.
    ///
    /// # Panics
    /// If `radiance` has not c values.
    pub fn add_radiance(&self, ray: &Ray, sequence: Sequence, k: u32, radiance: &mut [f64]) -> Option<Hit> {
        let walker = &self.walker;
        assert_eq!(radiance.len(), walker.channels, "a value per channel");
        let first = walker.tracer.closest_hit(ray)?;
        let met = RayHit { ray: *ray, hit: first };
        let mut numbers = Sampler { sequence, point: k, set: 1 };
        let mut colour = vec![1.0; walker.channels];
        let mut weight = vec![0.0; 2 * walker.channels];
        let met = if walker.tracer.may_go_on(first.face) {
            let scratch = &mut weight[..walker.channels];
            let lamp_seen = |part: f64, weight: &[f64], emission: &[f64]| {
                let seen = emission.iter().zip(weight);
                radiance.iter_mut().zip(seen).for_each(|(sum, (e, weight))| *sum += part * e * weight);
            };
            match walker.beyond_carriers(met, &mut numbers, [&mut colour, scratch], lamp_seen) {
                Beyond::Met(met) => met,
                Beyond::Away { ray: last, .. } => {
                    if let Some(sky) = walker.tracer.scene().sky() {
                        let (share, tint) = sky.shares().tinted(last.direction);
                        let seen = sky.zenith.iter().zip(&colour).enumerate();
                        radiance.iter_mut().zip(seen).for_each(|(sum, (c, (zenith, colour)))| {
                            *sum += share * tint.map_or(1.0, |tint| tint[c]) * zenith * colour;
                        });
                    }
                    return Some(first);
                }
                Beyond::Nowhere => return Some(first),
            }
        } else {
            Met { hit: first, direction: ray.direction, density: None, is_straight: true }
        };
        let hit = met.hit;
        let mut own = [0.0; 3];
        if hit.side == Side::Front && walker.lights.density(hit.face) > 0.0 {
            let mis_weight = walker.mis_weight(&met);
            let emission = walker.emission(hit.face, hit.barycentrics, &mut own);
            let seen = emission.iter().zip(&colour);
            radiance.iter_mut().zip(seen).for_each(|(sum, (e, colour))| *sum += mis_weight * e * colour);
        }
        let [s, t, way, _] = numbers.next();
        let mut rho = vec![1.0; walker.channels];
        let place = walker.follow(&hit, way, &mut rho);
        let start = Start { place, first: [s, t], longest: usize::MAX };
        walker.irradiance(start, &mut numbers, &mut weight, |_, part, weight, emission| {
            for (c, sum) in radiance.iter_mut().enumerate() {
                *sum += FRAC_1_PI * colour[c] * rho[c] * part * weight[c] * emission[c];
            }
        });
        Some(first)
    }

    /// Estimates the irradiance of every patch until the budget is used up.
    ///
    /// # Errors
    /// `Budget` or `Cancelled`.
    pub fn irradiance(&self, patches: &Patches, options: &PathOptions) -> Result<PathTraced, PathError> {
        let areas: Vec<f64> = (0..patches.len()).map(|i| patches.area(i)).collect();
        let mut estimate = PathTraced::new(self.walker.channels, options.bounces, &areas);
        self.refine(patches, &mut estimate, options)?;
        Ok(estimate)
    }

    /// Goes on with an estimate until another budget is used up. A wanted standard error is that of the whole
    /// estimate, time and paths are those to be added. With the same seed, paths are new ones all the same.
    ///
    /// # Errors
    /// `Budget` or `Cancelled`; the estimate is then as it was after its last whole round.
    ///
    /// # Panics
    /// If `patches` are not those of the estimate.
    pub fn refine(
        &self,
        patches: &Patches,
        estimate: &mut PathTraced,
        options: &PathOptions,
    ) -> Result<(), PathError> {
        assert_eq!(patches.len(), estimate.len(), "the patches that paths were traced from");
        let PathOptions { budget, progress, .. } = options;
        if !budget.is_valid() {
            return Err(PathError::Budget);
        }
        progress.at("reference", 0.0)?;
        let began = Instant::now();
        let (known, before) = (estimate.paths, estimate.seconds);
        let mut left = match known {
            0 => f64::INFINITY,
            _ => budget.left(estimate, 0.0, 0),
        };
        while left > 0.0 && !patches.is_empty() {
            let round = match estimate.paths {
                0 => first_round(estimate, budget),
                _ => next_round(estimate, left),
            };
            let added = (estimate.paths - known) as f64;
            let round = Pace { round, done: added, all: added + left };
            self.walk(patches, estimate, &round, options)?;
            estimate.note_spread();
            let seconds = began.elapsed().as_secs_f64();
            estimate.seconds = before + seconds;
            left = budget.left(estimate, seconds, estimate.paths - known);
        }
        progress.at("reference", 1.0)?;
        Ok(())
    }

    /// Traces the batches of one round.
    fn walk(
        &self,
        patches: &Patches,
        estimate: &mut PathTraced,
        Pace { round, done, all }: &Pace,
        options: &PathOptions,
    ) -> Result<(), Cancelled> {
        let values = (estimate.bounces + 1) * estimate.channels;
        let mut halves = estimate.halves.clone();
        let mut paths = 0;
        for (h, (half, more)) in halves.iter_mut().zip(round).enumerate() {
            let Half { batches, sums, .. } = half;
            let rows = sums.chunks_mut(CHUNK * values).zip(batches.chunks_mut(CHUNK));
            for (chunk, (sums, batches)) in rows.enumerate() {
                options.progress.at("reference", ((done + paths as f64) / all).min(0.999))?;
                let rows = sums.par_chunks_mut(values).zip(batches).enumerate();
                rows.for_each(|(k, (sums, batches))| {
                    let patch = chunk * CHUNK + k;
                    let range = *batches..*batches + more[patch];
                    let run = Run { patch, half: h, batches: range, size: estimate.batch };
                    self.run(patches, run, sums, options);
                    *batches += more[patch];
                });
                let range = chunk * CHUNK..more.len().min((chunk + 1) * CHUNK);
                paths += more[range].iter().map(|&n| u64::from(n) * u64::from(estimate.batch)).sum::<u64>();
            }
        }
        if let Some(thrower) = &self.thrower {
            let mut photons = estimate.photons.clone().unwrap_or_default();
            let job = Throw { walker: &self.walker, patches, options };
            thrower.throw(&job, &mut photons, paths)?;
            estimate.photons = Some(photons);
        }
        estimate.halves = halves;
        estimate.paths += paths;
        Ok(())
    }

    /// Adds the means of a run of batches to the sums of its patch.
    fn run(&self, patches: &Patches, run: Run, sums: &mut [[f64; 2]], options: &PathOptions) {
        let Run { patch, half, batches, size } = run;
        let channels = self.walker.channels;
        let kept = sums.len() / channels - 1;
        let longest = options.longest.unwrap_or(usize::MAX);
        let facet = patches.facet(self.walker.tracer, patches.slot_of_patch(patch));
        let offset = 2 * patches.slot_of_patch(patch) + half as u32;
        let mut found = vec![0.0; sums.len()];
        let mut weight = vec![0.0; 2 * channels];
        for batch in batches {
            let sequence = Stream::Paths.sequence(options.seed, offset, u64::from(batch));
            found.fill(0.0);
            for point in 0..size {
                let mut numbers = Sampler { sequence, point, set: 0 };
                let [s, t, x, y] = numbers.next();
                let start = Start { place: facet.interaction([s, t]), first: [x, y], longest };
                self.walker.irradiance(start, &mut numbers, &mut weight, |bounce, part, weight, emission| {
                    for c in 0..channels {
                        let arrived = part * weight[c] * emission[c];
                        found[kept * channels + c] += arrived;
                        if (1..=kept).contains(&bounce) {
                            found[(bounce - 1) * channels + c] += arrived;
                        }
                    }
                });
            }
            for ([sum, squares], found) in sums.iter_mut().zip(&found) {
                let mean = found / f64::from(size);
                *sum += mean;
                *squares += mean * mean;
            }
        }
    }
}
