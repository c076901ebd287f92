//! What `radiosity solve` says of its answer, in a dozen lines.

use radiosity::measure::{BOUND_95, GroupError};
use radiosity::output::{EnergySummary, Photometry, Summary};
use radiosity::patches::Basis;
use radiosity::scene::Scene;
use radiosity::transport::FormFactors;

use crate::{accuracy, materials, verdict};

/// What the user wants to know.
pub fn text(summary: &Summary, scene: &Scene, factors: &FormFactors) -> String {
    let basis = factors.basis();
    let bounds = match basis {
        Basis::Constant => ["error at most", "of the brightest patch, condition at most"],
        Basis::Linear => ["error about", "of the root mean square, condition about"],
    };
    let mut lines = vec![heading(summary, scene, basis)];
    lines.push(format!("materials     {}", materials::line(scene)));
    lines.push(format!("error         {}", error(summary)));
    lines.extend(form_factors(summary, factors));
    lines.push(solver(summary, bounds));
    lines.push(series(summary, bounds));
    lines.extend(undershoot(summary));
    lines.push(energy(&summary.energy));
    lines.push(format!("verdict       {}\n", verdict::phrase(&summary.verdict)));
    lines.extend(errors(&summary.errors, summary.patches, summary.error_of_all.irradiance));
    if !summary.photometry.is_empty() {
        lines.push(illuminances(&summary.photometry));
    }
    lines.push(format!("  order  flux it adds (W)            residual  {}", bounds[0]));
    lines.extend(orders(summary));
    lines.push(times(summary));
    lines.join("\n")
}

fn heading(summary: &Summary, scene: &Scene, basis: Basis) -> String {
    let (faces, patches) = (scene.faces().len(), summary.patches);
    let elements = if basis == Basis::Linear { ", linear" } else { "" };
    let channels = match summary.channels {
        1 => "one channel".into(),
        channels => format!("{channels} channels"),
    };
    format!("{}: {faces} faces, {patches} patches{elements}, {channels}\n", summary.scene)
}

fn error(summary: &Summary) -> String {
    // What a better answer would cost does not depend on pictures and files.
    let stages = summary.stages.iter().filter(|s| !["load", "build", "render", "write"].contains(&s.name));
    let answering: f64 = stages.map(|stage| stage.seconds).sum();
    accuracy::error_line(&summary.error, answering, &summary.series)
}

/// Form factors, and where rays are too few what that changes.
fn form_factors(summary: &Summary, factors: &FormFactors) -> Vec<String> {
    let rays = match summary.rays {
        0 => "without rays".to_owned(),
        rays => format!("{rays} rays a patch"),
    };
    let mut lines = vec![format!(
        "form factors  {rays}, {:.1} MB {}; rows close to {:.0e}, from {:.0e} before balancing",
        factors.bytes() as f64 / 1e6,
        summary.storage,
        summary.closure.after,
        summary.closure.before
    )];
    let kept = factors.exchange().shrinkage();
    if kept < 1.0 {
        lines.push(format!(
            "shrinkage     what varies within patches by {kept:.3}, for rays are too few for more"
        ));
    }
    lines
}

fn solver(Summary { solver, .. }: &Summary, bounds: [&str; 2]) -> String {
    format!(
        "solver        {}: residual {:.0e}, {} {} {} {}",
        solver.name,
        solver.residual,
        bounds[0],
        known(solver.bound, |bound| format!("{bound:.0e}")),
        bounds[1],
        known(solver.condition, |condition| format!("{condition:.3}"))
    )
}

fn series(Summary { series, solver, .. }: &Summary, bounds: [&str; 2]) -> String {
    format!(
        "series        order {}: residual {:.0e}, {:.0e} of the flux left, {} {}; {:.0e} from {}",
        series.order,
        series.residual,
        series.remaining_flux,
        bounds[0],
        known(series.bound, |bound| format!("{bound:.0e}")),
        series.difference,
        solver.name
    )
}

fn undershoot(summary: &Summary) -> Option<String> {
    let [share, depth] = [summary.undershoot.share, summary.undershoot.depth].map(|part| 100.0 * part);
    (share > 0.0).then(|| {
        format!(
            "undershoot    below zero at corners on {share:.1} % of the area, by {depth:.2} % of the brightest at most"
        )
    })
}

fn energy(energy: &EnergySummary) -> String {
    let uncertainty = match energy.imbalance_error {
        0.0 => String::new(),
        error => format!(" ± {error:.0e}"),
    };
    format!(
        "energy        emitted {} W, absorbed {} W, escaped {} W{}; imbalance {:.0e}{uncertainty}",
        triple(energy.emitted),
        triple(energy.absorbed),
        triple(energy.escaped),
        elsewhere(energy),
        energy.imbalance
    )
}

/// A line for each of the first orders, every tenth and the last.
fn orders(Summary { series, .. }: &Summary) -> impl Iterator<Item = String> {
    let told = |order: usize| order <= 5 || order.is_multiple_of(10) || order == series.order;
    series.bounces.iter().filter(move |bounce| told(bounce.order)).map(|bounce| {
        let flux = triple(bounce.flux);
        let bound = known(bounce.bound, |bound| format!("{bound:.1e}"));
        format!("  {:>5}  {flux:26}   {:.1e}  {bound}", bounce.order, bounce.residual)
    })
}

fn times(summary: &Summary) -> String {
    let seconds: f64 = summary.stages.iter().map(|stage| stage.seconds).sum();
    let long = summary.stages.iter().filter(|stage| stage.seconds >= 0.005);
    let stages: Vec<String> = long.map(|stage| format!("{} {:.2}", stage.name, stage.seconds)).collect();
    format!("\n{seconds:.2} s on {} threads: {}", summary.threads, stages.join(", "))
}

/// A bound, where there is one.
fn known(bound: f64, print: impl Fn(f64) -> String) -> String {
    if bound.is_finite() { print(bound) } else { "unknown".into() }
}

/// What ends in mirrors and glass, and what is missing, where anything does or is.
fn elsewhere(energy: &EnergySummary) -> String {
    let part = |name: &str, power: [f64; 3]| match power {
        [0.0, 0.0, 0.0] => String::new(),
        power => format!(", {name} {} W", triple(power)),
    };
    part("in carriers", energy.carriers) + &part("lost", energy.lost) + &part("slack", energy.slack)
}

/// Objects, materials and receivers whose errors are told, at most.
const MOST_TOLD: usize = 5;

/// A table of the objects, materials and receivers with the largest errors relative to their own light, where
/// there are several.
fn errors(all: &[GroupError], patches: usize, irradiance: f64) -> Option<String> {
    let mut told: Vec<&GroupError> = all.iter().filter(|group| group.counts(patches, irradiance)).collect();
    told.sort_by(|a, b| b.budget.upper95.total_cmp(&a.budget.upper95));
    told.truncate(MOST_TOLD);
    let mut text = format!("  {:<28} {:>10} {:>12} {:>10}\n", "largest errors", "patches", "W/m2", "95 %");
    for group in &told {
        let name = format!("{} {}", group.kind, group.name);
        let bound = if group.budget.upper95.is_finite() {
            format!("± {} %", accuracy::percent(group.budget.upper95))
        } else {
            "unknown".into()
        };
        text += &format!(
            "  {name:<28} {:>10} {:>12} {bound:>10}\n",
            group.patches,
            short(group.budget.irradiance)
        );
    }
    (told.len() > 2).then_some(text)
}

/// A table of illuminances, lx.
fn illuminances(rows: &[Photometry]) -> String {
    let mut text = format!(
        "  {:<28} {:>10} {:>9} {:>10} {:>10} {:>11}\n",
        "illuminance, lx", "mean", "95 %", "minimum", "maximum", "uniformity"
    );
    for (row, lux) in rows.iter().filter_map(|row| Some((row, row.illuminance?))) {
        let name = format!("{} {}", row.kind, row.name);
        let [mean, minimum, maximum] = [lux.mean, lux.minimum, lux.maximum].map(short);
        let part = row.illuminance_error.filter(|_| lux.mean > 0.0).map(|error| error.mean / lux.mean);
        let bound =
            part.map_or_else(String::new, |part| format!("± {} %", accuracy::percent(BOUND_95 * part)));
        let uniformity = lux.uniformity;
        text +=
            &format!("  {name:<28} {mean:>10} {bound:>9} {minimum:>10} {maximum:>10} {uniformity:>11.3}\n");
    }
    text
}

/// Three numbers, or one where all are the same.
fn triple([r, g, b]: [f64; 3]) -> String {
    if r == g && g == b { short(r) } else { format!("{} {} {}", short(r), short(g), short(b)) }
}

/// A number with four significant digits.
fn short(x: f64) -> String {
    let magnitude = if x == 0.0 { 0 } else { x.abs().log10().floor() as i32 };
    match magnitude {
        -3..=5 => format!("{x:.*}", (3 - magnitude).max(0) as usize),
        _ => format!("{x:.3e}"),
    }
}
