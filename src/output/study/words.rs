//! Words: `study.md`, what a study found, in sentences that are made of its numbers.

use std::io::{self, Write};

use super::StudySummary;
use crate::measure::{Reading, Slope, StudyRow, StudySolver, Trend, Turn, Want};

/// Writes `study.md`.
///
/// # Errors
/// Those of `writer`.
pub fn write_study_report(writer: &mut dyn Write, study: &StudySummary) -> io::Result<()> {
    let sections = [
        format!("# What accuracy costs: {}\n", study.scene),
        setting(study),
        "![Error against time](study.svg)\n".into(),
        format!("## Which knob to turn\n\n{}", targets(study)),
        format!("## Each knob alone\n\n{}", knobs(study)),
        "![Each knob alone](knobs.svg)\n".into(),
        format!("## How far to trust this\n\n{}", trust(study)),
    ];
    writer.write_all(sections.join("\n").as_bytes())
}

/// What was measured, and against what.
fn setting(study: &StudySummary) -> String {
    let cells = study.grid.patches.len() * study.grid.rays.len();
    format!(
        "Error is the area-weighted relative root mean square error of irradiance by face, the reference's noise taken off. Time is \
         wall-clock time on {} threads from the mesh to irradiance: cutting, tracing, balancing, solving; reading the scene is no part of \
         it. {} of {cells} pairs of patches and rays were measured, each with conjugate gradients, orders of the Neumann series and, \
         where it takes no more than a second or two, the direct solver; {}.\n",
        study.threads,
        cells - study.left_out.len().min(cells),
        match study.basis {
            "linear" => "light varies linearly within a patch",
            _ => "light is constant within a patch",
        }
    )
}

/// The table of accuracies, and what it says.
fn targets(study: &StudySummary) -> String {
    let found = &study.conclusions;
    if found.targets.is_empty() {
        return "No setting that was measured errs by less than 20 %.\n".into();
    }
    let mut text = String::from(
        "| error at most | quickest setting that was measured | error | seconds | memory | light paths | for less error, more |\n\
         |---|---|---|---|---|---|---|\n",
    );
    for target in &found.targets {
        let row = &study.rows[target.row];
        text += &format!(
            "| {} | {} | {} | {} | {} | {} | {} |\n",
            percent(target.accuracy),
            setting_of(row),
            told(row),
            seconds(row.seconds),
            megabytes(row.bytes),
            target.paths_seconds.map_or("–".into(), |s| format!("{} s", seconds(s))),
            target.turn.map_or("–", name)
        );
    }
    text += "\n";
    for stretch in found.targets.chunk_by(|a, b| a.turn == b.turn) {
        let Some(turn) = stretch[0].turn else { continue };
        let [first, last] = [stretch[0].accuracy, stretch[stretch.len() - 1].accuracy].map(percent);
        let from = if first == last { format!("At {first}") } else { format!("From {first} to {last}") };
        text += &match turn {
            Turn::Patches => format!("{from} more patches give most for their time.\n"),
            Turn::Rays => format!("{from} more rays give most for their time.\n"),
            Turn::Both => format!("{from} patches and rays are worth their time alike: raise both.\n"),
            Turn::Order => format!(
                "{from} the series ends too early: raise its order, or let conjugate gradients go on to the end.\n"
            ),
        };
    }
    text + "\n" + &versus_paths(study)
}

/// Where light paths are quicker, and where the matrix is.
fn versus_paths(study: &StudySummary) -> String {
    let ratios: Vec<(f64, f64)> = study
        .conclusions
        .targets
        .iter()
        .filter_map(|t| Some((t.accuracy, t.paths_seconds? / study.rows[t.row].seconds)))
        .collect();
    let Some(&(finest, ratio)) = ratios.last() else { return String::new() };
    let all = "Light paths were asked for faces only; the matrix answers every patch at the same price.";
    let speed = |ratio: f64| match ratio {
        r if r >= 1.0 => format!("{} times as long as the matrix", two_digits(r)),
        r => format!("{} of the time of the matrix", percent(r)),
    };
    format!("For an error of {} light paths would take {}. {all}\n", percent(finest), speed(ratio))
}

/// A sentence or two per knob.
fn knobs(study: &StudySummary) -> String {
    let found = &study.conclusions;
    let mut lines = Vec::new();
    if let Some(trend) = &found.patches {
        lines.push(format!("- **Patches**, at {} rays: {}", trend.other, told_trend(trend, "patches")));
    }
    if let Some(trend) = &found.rays {
        let n = study.rows[trend.rows[0]].patches;
        lines.push(format!("- **Rays**, at {n} patches: {}", told_trend(trend, "rays")));
    }
    if let Some(order) = &found.order {
        let end = study.rows[order.converged].iterations;
        let factor = order.factor.map_or("too few orders stand apart to tell a rate".into(), |factor| {
            format!("each order leaves {factor:.2} of what truncation adds to the error")
        });
        let enough = match order.enough {
            Some(enough) => format!(
                "order {enough} is as good as solving to the end, and what is left is no longer the series' fault"
            ),
            None => "no order that was tried is as good as solving to the end".into(),
        };
        lines.push(format!("- **Order** of the series, at {}: {factor}; {enough}. Conjugate gradients take {end} passes over the matrix.", cell_of(&study.rows[order.converged])));
    }
    let solving = &found.solving;
    if found.best.is_some() {
        let mut text = format!(
            "- **Solver**: conjugate gradients are {} of all time at the best setting, tracing nearly all the rest",
            percent(solving.share)
        );
        if solving.share > 0.3 {
            text = format!(
                "- **Solver**: conjugate gradients are {} of all time at the best setting",
                percent(solving.share)
            );
        }
        if let Some(direct) = solving.direct {
            text += &format!(
                "; the direct solver takes time as patches to the power {}, and errs the same to {}",
                uncertain(direct),
                percent(solving.difference.max(1e-6))
            );
        }
        lines.push(text + ".");
    }
    if let Some(slope) = found.paths {
        lines.push(format!(
            "- **Light paths**: error goes as seconds to the power {} (−½ in theory).",
            uncertain(slope)
        ));
    }
    lines.join("\n") + "\n"
}

fn told_trend(trend: &Trend, knob: &str) -> String {
    let slope = trend.slope.map(|slope| format!("error goes as {knob} to the power {}", uncertain(slope)));
    match (slope, trend.enough) {
        (Some(slope), None) => format!("{slope} as far as was measured."),
        (Some(slope), Some(enough)) => {
            format!("{slope} up to {enough}; beyond, something else rules the error.")
        }
        (None, Some(enough)) => format!("beyond {enough} they hardly help: something else rules the error."),
        (None, None) => "too few errors stand out from the noise to tell a power.".into(),
    }
}

/// The reference, its noise and the second witness; what was left out.
fn trust(study: &StudySummary) -> String {
    let found = &study.conclusions;
    let mut lines = vec![format!(
        "- The reference is {} light paths ({} s), of noise {}. It is taken off; errors below {} can't be told from nothing all the same, \
         and are given as limits (<).",
        study.reference_paths,
        seconds(study.reference_seconds),
        percent(found.noise),
        percent(found.resolution)
    )];
    if let Some(best) = found.best.map(|best| &study.rows[best]) {
        let apart = match best.reading() {
            Reading::Resolved(error) => format!("{} ± {} apart", percent(error), percent(best.error_se)),
            Reading::Below(limit) => format!("less than {} apart, which is noise", percent(limit)),
        };
        lines.push(format!(
            "- The best matrix solution, {}, shares nothing with the reference but the scene and the tracer: two witnesses, {apart}.",
            cell_of(best)
        ));
        if best.leak > 1e-4 {
            lines.push(format!(
                "- Faces' sides that no light path reaches, inside solids that stand on something, are left out of the error. Patches astride \
                 an edge leak {} of all light onto them at the best setting.",
                percent(best.leak)
            ));
        }
    }
    lines.push(format!(
        "- Every setting was measured {}; ± is one standard error, by the spread between repeats and the reference's noise. Times \
         are medians of those on this machine, as busy as it was.",
        match (least_repeats(&study.rows), most_repeats(&study.rows)) {
            (a, b) if a == b => format!("{a} times with other random numbers"),
            (a, b) => format!("{a} to {b} times with other random numbers"),
        }
    ));
    if study.taken_over > 0 {
        lines.push(format!("- {} of {} rows are from an earlier run.", study.taken_over, study.rows.len()));
    }
    let for_time: Vec<String> = study
        .left_out
        .iter()
        .filter(|left| matches!(left.wants, Want::Seconds(_)))
        .map(|left| format!("{} × {}", left.cell.patches, left.cell.rays))
        .collect();
    if !for_time.is_empty() {
        lines.push(format!(
            "- Left out for lack of time (patches × rays): {}. All of them fit into {} s.",
            for_time.join(", "),
            study.seconds_for_all.ceil()
        ));
    }
    for left in &study.left_out {
        if let Want::Memory(message) = &left.wants {
            lines.push(format!(
                "- Left out for lack of memory: {} × {}: {message}.",
                left.cell.patches, left.cell.rays
            ));
        }
    }
    lines.join("\n") + "\n"
}

fn least_repeats(rows: &[StudyRow]) -> usize {
    rows.iter().map(|row| row.repeats).min().unwrap_or(0)
}

fn most_repeats(rows: &[StudyRow]) -> usize {
    rows.iter().map(|row| row.repeats).max().unwrap_or(0)
}

fn name(turn: Turn) -> &'static str {
    match turn {
        Turn::Patches => "patches",
        Turn::Rays => "rays",
        Turn::Both => "patches and rays",
        Turn::Order => "orders",
    }
}

fn cell_of(row: &StudyRow) -> String {
    format!("{} patches × {} rays", row.patches, row.rays)
}

fn setting_of(row: &StudyRow) -> String {
    let solver = match (row.solver, row.order) {
        (StudySolver::Direct, _) => "direct".into(),
        (StudySolver::Cg, _) => "cg".into(),
        (StudySolver::Neumann, order) => format!("order {}", order.unwrap_or(0)),
        (StudySolver::Paths, _) => "light paths".into(),
    };
    format!("{}, {solver}", cell_of(row))
}

/// An error as far as it is known.
fn told(row: &StudyRow) -> String {
    match row.reading() {
        Reading::Resolved(error) => format!("{} ± {}", percent(error), percent(row.error_se)),
        Reading::Below(limit) => format!("< {}", percent(limit)),
    }
}

fn uncertain(slope: Slope) -> String {
    let minus = if slope.slope < 0.0 { "−" } else { "" };
    format!("{minus}{:.2} ± {:.2}", slope.slope.abs(), slope.standard_error.max(0.01))
}

/// With two digits that count.
fn percent(share: f64) -> String {
    format!("{} %", two_digits(100.0 * share))
}

fn two_digits(x: f64) -> String {
    if x <= 0.0 {
        return "0".into();
    }
    let digits = (1.0 - x.log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{x:.digits$}");
    // 5 %, not 5.0 %.
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

fn seconds(s: f64) -> String {
    two_digits(s)
}

fn megabytes(bytes: u64) -> String {
    format!("{} MB", two_digits(bytes as f64 / 1e6))
}
