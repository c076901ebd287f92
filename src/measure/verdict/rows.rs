//! Rows: whether rows of form factors sum to 1 with what leaves, and whether what leaves can.

use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::constants::{DOUBTFUL, EMPTY, EXACT, MOST_ANGLES, NOTABLE};
use super::places::Places;
use super::{Answer, Cause, Level, Reason};
use crate::measure::health::ClosedSurfaces;
use crate::transport::Exchange;

/// What was found out about rows.
#[derive(Default)]
pub(super) struct Rows {
    pub reasons: Vec<Reason>,
    /// The part of the emitted power that rows lose or gain beside their slack.
    pub open: f64,
}

/// What a patch lets escape, W per channel, and whether it exchanges nothing.
struct Escape {
    patch: usize,
    power: Vec<f64>,
    sees_nothing: bool,
}

/// Judges closure, slack, escape from closed surfaces and patches without rays.
pub(super) fn judge(answer: &Answer) -> Rows {
    let Answer { patches, problem, solution, .. } = *answer;
    let operator = problem.operator();
    let unit = operator.mass().unit();
    let (channels, each) = (operator.channels(), operator.basis().coefficients());
    let new = || Places::new(channels);
    let (mut open, mut unclosed, mut slack, mut without_rays) = (new(), new(), new(), new());
    let nothing = |patch| Escape { patch, power: vec![0.0; channels], sees_nothing: true };
    let mut escapes: Vec<Escape> = (0..patches.len()).map(nothing).collect();
    let sums_by_tone: Vec<DMatrix<f64>> = operator.factors().exchanges().iter().map(sums).collect();
    // What a patch receives on average, W·m⁻²: what one that no ray tells of may lack.
    let mut usual = Vec::with_capacity(channels);
    for c in 0..channels {
        let (exchange, sums) = (operator.exchange_of(c), &sums_by_tone[operator.tone_of(c)]);
        let (areas, slack_of) = (exchange.sums(), &exchange.ends().slack);
        usual.push(areas.dot(&solution.irradiance.column(c)) / areas.sum());
        for i in 0..operator.len() {
            let face = patches.place(i / each).face;
            let sent = PI * unit * solution.radiance[(i, c)].abs();
            let lack = areas[i] - sums[i] - exchange.ends().leaving[i];
            let unexplained = (lack - slack_of[i]).abs();
            open.add(face, c, sent * unexplained);
            if lack > EMPTY * areas[i] {
                without_rays.add(face, c, unit * areas[i] * usual[c]);
            } else if unexplained > EXACT * areas[i] {
                unclosed.add(face, c, sent * unexplained);
            }
            if slack_of[i] > EXACT * areas[i] {
                slack.add(face, c, sent * slack_of[i]);
            }
            let escape = &mut escapes[i / each];
            escape.power[c] += sent * exchange.ends().escape(i);
            escape.sees_nothing &= sums[i] == 0.0;
        }
    }
    let mut escaped = new();
    let area =
        |patch: usize| (each * patch..each * (patch + 1)).map(|i| operator.mass().sums()[i]).sum::<f64>();
    for Escape { patch, power, sees_nothing } in enclosed(answer, escapes) {
        let face = patches.place(patch).face;
        for (c, power) in power.into_iter().enumerate() {
            match sees_nothing {
                true => without_rays.add(face, c, unit * area(patch) * usual[c]),
                false => escaped.add(face, c, power),
            }
        }
    }
    let emitted = &answer.energy.emitted;
    let judged = |places: &Places, cause: Cause, allowed: f64| {
        let level =
            if places.is_empty() { Level::Good } else { Level::of_share(places.share(emitted), allowed) };
        (level > Level::Good).then(|| places.reason(answer, cause, level))
    };
    let short = || {
        let short = short_faces(answer);
        let faces: Vec<usize> = slack.faces().into_iter().filter(|face| short.contains(face)).collect();
        let share = Some(slack.share(emitted));
        (!faces.is_empty())
            .then(|| Reason::new(Cause::Slack, Level::Good, share, faces, answer.tracer.scene()))
    };
    let reasons = [
        judged(&unclosed, Cause::Closure, 0.0),
        judged(&slack, Cause::Slack, DOUBTFUL).or_else(short),
        judged(&escaped, Cause::Escape, DOUBTFUL),
        judged(&without_rays, Cause::NoRays, DOUBTFUL),
    ];
    Rows { reasons: reasons.into_iter().flatten().collect(), open: open.share(emitted) }
}

/// The faces that lack a notable part of what they exchange.
fn short_faces(answer: &Answer) -> HashSet<usize> {
    let (patches, operator) = (answer.patches, answer.problem.operator());
    let each = operator.basis().coefficients();
    let of_channel = |c: usize| {
        let exchange = operator.exchange_of(c);
        let mut slack_and_area: HashMap<usize, [f64; 2]> = HashMap::new();
        for (i, (slack, area)) in exchange.ends().slack.iter().zip(exchange.sums()).enumerate() {
            let [lack, all] = slack_and_area.entry(patches.place(i / each).face).or_default();
            (*lack, *all) = (*lack + slack, *all + area);
        }
        slack_and_area.into_iter().filter(|(_, [lack, all])| *lack > NOTABLE * all).map(|(face, _)| face)
    };
    (0..operator.channels()).flat_map(of_channel).collect()
}

/// Σ_j S_ij.
fn sums(exchange: &Exchange) -> DMatrix<f64> {
    let mut sums = DMatrix::zeros(exchange.len(), 1);
    exchange.apply(&DMatrix::repeat(exchange.len(), 1, 1.0), &mut sums);
    sums
}

/// The patches from which rays escape though they are inside a closed surface.
fn enclosed(answer: &Answer, escapes: Vec<Escape>) -> Vec<Escape> {
    let Answer { tracer, patches, problem, .. } = *answer;
    let operator = problem.operator();
    let each = operator.basis().coefficients();
    let lets_out = |patch: usize| {
        (0..operator.channels()).any(|c| {
            let exchange = operator.exchange_of(c);
            (each * patch..each * (patch + 1)).any(|i| exchange.ends().escape(i) > EXACT * exchange.sums()[i])
        })
    };
    let mut escapes: Vec<Escape> = escapes.into_iter().filter(|escape| lets_out(escape.patch)).collect();
    if escapes.is_empty() {
        return escapes;
    }
    let surfaces = ClosedSurfaces::of(tracer);
    if surfaces.faces() == 0 {
        return Vec::new();
    }
    let total = |escape: &Escape| escape.power.iter().sum::<f64>();
    escapes.sort_by(|a, b| total(b).total_cmp(&total(a)));
    escapes.truncate(MOST_ANGLES / surfaces.faces());
    let is_inside = |escape: &Escape| {
        let place = patches.place(escape.patch);
        surfaces.enclose(patches.centre(escape.patch), place.face, place.side)
    };
    escapes.into_par_iter().filter(is_inside).collect()
}
