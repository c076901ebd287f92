//! Accuracy: the cheapest cut and number of rays that are good enough, found by trying.
//!
//! A first answer is coarse and quick. Its budget tells how much of its error is mesh and how much is noise;
//! with what both are known to fall by as patches and rays grow, the setting that meets the goal in the least
//! time follows and is tried next. Each step tells better how this scene's errors fall. Where an answer
//! misses its goal by noise alone, its rays are kept and others are added to them.

mod constants;
mod decision;
mod forecast;
mod goal;
mod receivers;
mod search;

use std::time::Instant;

use super::{Level, MeasureError};
use crate::patches::{Cutter, Tessellation};
use crate::trace::Tracer;
use crate::transport::TraceOptions;
use constants::{FIRST_PATCHES, FIRST_RAYS, MESH_POWER, RAYS_RANGE, RUNG, RUNGS};
use decision::Next;
pub use goal::{AccuracyStep, Accurate, Ending, Goal, Resource, Setting, Tolerated};
pub use receivers::{missed, receive};
use search::{Attempt, Choice, Rung, Search};

/// Finds the cheapest answer that meets `goal`. The sizes and numbers of rays in the options are not used.
///
/// # Errors
/// As cutting, tracing and solving; `Memory` where not even the first step fits.
pub fn reach<'s>(
    tracer: &Tracer<'s>,
    goal: Goal,
    tessellation: &Tessellation,
    trace: &TraceOptions,
) -> Result<Accurate<'s>, MeasureError> {
    let began = Instant::now();
    let asked = |k: i32| FIRST_PATCHES * RUNG.powi(k);
    let ladder = (0..RUNGS).map(|k| Rung { asked: asked(k), patches: asked(k), known: false }).collect();
    let mut search = Search {
        tracer,
        cutter: Cutter::new(tracer)?,
        goal,
        tessellation,
        trace,
        began,
        steps: Vec::new(),
        scatter: Vec::new(),
        power: MESH_POWER,
        ladder,
    };
    // Where faces alone are more patches than that, with fewer rays each.
    let patches = FIRST_PATCHES.max(tracer.scene().faces().len() as f64);
    let rays = (FIRST_PATCHES * FIRST_RAYS / patches).max(RAYS_RANGE[0]);
    let mut best = search.step(None, Choice { rung: 0, setting: Setting { patches, rays } })?;
    let ending = loop {
        match search.next(&best) {
            Next::End(ending) => break ending,
            Next::MoreRays(rays) => best = search.add_rays(best, rays)?,
            Next::Step(choice) => {
                let answer = search.step(Some(&best.patches), choice)?;
                if answer.rank() < best.rank() {
                    best = answer;
                }
            }
        }
    };
    let Attempt { patches, factors, verdict, .. } = best;
    let ending = match ending {
        Ending::Reached if verdict.level > Level::Good => Ending::Doubtful,
        ending => ending,
    };
    Ok(Accurate { patches, factors, steps: search.steps, ending, verdict })
}
