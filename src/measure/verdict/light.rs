//! Light: whether the numbers of an answer are finite, complete, satisfy the equation and add up.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::constants::{DARK, DOUBTFUL, STANDARD_ERRORS};
use super::{Answer, Cause, Energy, Level, Reason, places};
use crate::measure::ErrorPart;
use crate::scene::{Scene, Side, triangle};
use crate::trace::OverlapKind;

/// NaN and infinite numbers anywhere are bad; an infinite bound alone is doubtful.
pub(super) fn not_finite(answer: &Answer) -> Vec<Reason> {
    let scene = answer.tracer.scene();
    let solution = answer.solution;
    let each = answer.problem.basis().coefficients();
    let is_broken = |i: &usize| {
        [&solution.radiance, &solution.irradiance]
            .iter()
            .any(|field| field.row(*i).iter().any(|x| !x.is_finite()))
    };
    let broken = (0..solution.radiance.nrows()).filter(is_broken);
    let mut faces: Vec<usize> = broken.map(|i| answer.patches.place(i / each).face).collect();
    faces.dedup();
    let energy = answer.energy;
    let losses = [&energy.absorbed, &energy.escaped, &energy.carriers, &energy.lost, &energy.slack];
    let mut numbers =
        losses.into_iter().chain([&energy.emitted]).flatten().copied().chain([energy.imbalance]);
    // Errors relative to no light at all are infinite.
    let errors = answer.budget.map_or([0.0; 2], |budget| [budget.relative_rms, budget.upper95]);
    let is_wrong = |error: f64| error.is_nan() || error.is_infinite() && !answer.solution.report.truncated;
    let report = &solution.report;
    let bounds = [report.residual, report.bound, report.condition];
    let not_finite = !faces.is_empty()
        || numbers.any(|x| !x.is_finite())
        || errors.into_iter().any(is_wrong)
        || bounds.iter().any(|bound| bound.is_nan());
    if not_finite {
        return vec![Reason::new(Cause::NotFinite, Level::Bad, None, faces, scene)];
    }
    // A bound of more than all light there is bounds nothing.
    let guaranteed = answer.budget.map_or(0.0, |b| b.part(ErrorPart::SOLVER) + b.part(ErrorPart::STORAGE));
    match bounds.iter().any(|bound| bound.is_infinite()) || guaranteed > 1.0 {
        true => vec![Reason::new(Cause::Unbounded, Level::Doubtful, None, Vec::new(), scene)],
        false => Vec::new(),
    }
}

/// All emission of the scene is among the sources: that of patches, entry by entry, and that of faces whose
/// front is no patch. The latter is covered by other faces, which may be meant, and so is doubtful at most.
pub(super) fn missing_lamps(answer: &Answer) -> Option<Reason> {
    let Answer { tracer, patches, problem, .. } = *answer;
    let sources = problem.sources();
    let scene = tracer.scene();
    let wanted = answer.problem.basis().coefficients_of(&patches.emitted_radiance());
    let lack = &wanted - &sources.emitted;
    let mut missing = places::power(answer, &lack, PI, |i, c| lack[(i, c)] != 0.0);
    let most = if missing.is_empty() { Level::Doubtful } else { Level::Bad };
    for face in emitters(scene).filter(|&face| patches.patches_of(face, Side::Front).is_empty()) {
        let area = triangle::area(&scene.corners(face));
        let emission = scene.mean_emission(face);
        for (channel, radiance) in emission.iter().enumerate().filter(|(_, radiance)| **radiance > 0.0) {
            missing.add(face, channel, PI * area * radiance);
        }
    }
    let has_lights = scene.lights().next().is_some() || scene.sky().is_some();
    if has_lights && sources.direct.is_none() {
        return Some(Reason::new(Cause::MissingLamps, Level::Bad, None, missing.faces(), scene));
    }
    if missing.is_empty() {
        return None;
    }
    let level = Level::of_share(missing.share(&answer.energy.emitted), 0.0).min(most);
    Some(missing.reason(answer, Cause::MissingLamps, level))
}

/// Faces that take part and emit.
fn emitters(scene: &Scene) -> impl Iterator<Item = usize> {
    (0..scene.faces().len()).filter(|&face| scene.is_diffuse(face) && scene.material_of(face).emits())
}

/// What an answer lacks to satisfy L = Lₑ + R H with H = H₀ + πFL.
pub(super) struct Residual {
    /// H of the radiance found, computed anew, N × c, W·m⁻².
    irradiance: DMatrix<f64>,
    /// r = Lₑ + R H − L, N × c, W·sr⁻¹·m⁻².
    radiance: DMatrix<f64>,
    /// π Σ A |r| as a part of the emitted power.
    pub share: f64,
}

impl Residual {
    pub fn of(answer: &Answer) -> Self {
        let Answer { problem, solution, .. } = *answer;
        let (operator, sources) = (problem.operator(), problem.sources());
        let mut irradiance = operator.irradiance(&solution.radiance);
        sources.add_beside_the_operator(&mut irradiance);
        let radiance = &sources.emitted + operator.reflect(&irradiance) - &solution.radiance;
        let share = places::power(answer, &radiance, PI, |_, _| true).share(&answer.energy.emitted);
        Self { irradiance, radiance, share }
    }
}

/// The residual is small: its power as a part of all power, and in no row radiance or irradiance is off by
/// 0.1 % or ten tolerances.
pub(super) fn unsolved(answer: &Answer, residual: &Residual) -> Option<Reason> {
    let Residual { irradiance, radiance, share } = residual;
    let mass = answer.problem.operator().mass().sums();
    let rms = |c: usize| {
        let squares: f64 = irradiance.column(c).iter().zip(mass).map(|(h, area)| area * h * h).sum();
        (squares / mass.sum()).sqrt()
    };
    let dark: Vec<f64> = (0..irradiance.ncols()).map(|c| DARK * rms(c)).collect();
    let limit = DOUBTFUL.max(answer.exact());
    let is_wrong = |i: usize, c: usize| {
        let off = (irradiance[(i, c)] - answer.solution.irradiance[(i, c)]).abs();
        off.max(PI * radiance[(i, c)].abs()) > limit * irradiance[(i, c)].abs().max(dark[c])
    };
    let wrong = places::power(answer, radiance, PI, is_wrong);
    if *share < answer.exact() && wrong.is_empty() {
        return None;
    }
    let (cause, level) = match answer.solution.report.truncated {
        true => (Cause::Truncation, Level::Truncated),
        false => (Cause::Unsolved, Level::of_share(*share, 0.0)),
    };
    Some(Reason::new(cause, level, Some(*share), wrong.faces(), answer.tracer.scene()))
}

/// What is emitted comes to all terms together, but for what the residual and open rows of form factors
/// explain.
pub(super) fn imbalance(answer: &Answer, explained: f64) -> Option<Reason> {
    let Energy { emitted, absorbed, escaped, carriers, lost, slack, imbalance, imbalance_error } =
        answer.energy;
    let off = |c: usize| match emitted[c] {
        0.0 => 0.0,
        all => ((all - absorbed[c] - escaped[c] - carriers[c] - lost[c] - slack[c]) / all).abs(),
    };
    let share = (0..emitted.len()).map(off).fold(*imbalance, f64::max);
    // Without interreflection shadow rays estimate each term by itself, with their noise.
    let noise = STANDARD_ERRORS * imbalance_error;
    let allowed = answer.exact() + if answer.has_rows() { explained } else { noise };
    let level = Level::of_share(share, allowed);
    (level > Level::Good)
        .then(|| Reason::new(Cause::EnergyImbalance, level, Some(share), Vec::new(), answer.tracer.scene()))
}

/// Faces that others in their plane with the same front cover; none where no light has to do with them, as
/// with undersides of what stands on a floor.
pub(super) fn overlaps(answer: &Answer) -> Option<Reason> {
    let overlaps = answer.tracer.overlaps().iter().filter(|overlap| overlap.kind == OverlapKind::SameFront);
    let faces: Vec<usize> = overlaps.flat_map(|overlap| overlap.faces).map(|face| face as usize).collect();
    let scene = answer.tracer.scene();
    let shine = faces.iter().any(|&face| scene.material_of(face).emits());
    listed(answer, Cause::Overlap, Level::Good, faces)
        .filter(|reason| shine || reason.power_share.is_none_or(|share| share > 0.0))
}

/// Sides of faces whose rays to and fro find different amounts of light; only told where little of it arrives
/// there.
pub(super) fn directions(answer: &Answer) -> Option<Reason> {
    let pairs = answer.problem.factors().disagreements().iter();
    let faces = pairs.flat_map(|pair| pair.sides).map(|(face, _)| face);
    let reason = listed(answer, Cause::Directions, Level::Doubtful, faces.collect())?;
    let does_harm = reason.power_share.is_none_or(|share| share >= DOUBTFUL);
    Some(Reason { level: if does_harm { Level::Doubtful } else { Level::Good }, ..reason })
}

/// What is known of some faces, with the part of all light that arrives there.
fn listed(answer: &Answer, cause: Cause, level: Level, mut faces: Vec<usize>) -> Option<Reason> {
    if faces.is_empty() {
        return None;
    }
    faces.sort_unstable();
    faces.dedup();
    let each = answer.problem.basis().coefficients();
    let is_listed = |i: usize, _| faces.binary_search(&answer.patches.place(i / each).face).is_ok();
    let irradiance = &answer.solution.irradiance;
    let arriving = places::power(answer, irradiance, 1.0, is_listed);
    let share = arriving.share(places::power(answer, irradiance, 1.0, |_, _| true).by_channel());
    let mut named = arriving.faces();
    // Those without light, as what is covered whole, come last.
    faces.retain(|face| !named.contains(face));
    named.extend(faces);
    Some(Reason::new(cause, level, Some(share), named, answer.tracer.scene()))
}
