//! Knobs: error against patches, rays and order, each alone, and what solving takes, as small multiples in
//! SVG.

use std::io::{self, Write};

use plotters::prelude::*;

use super::axes::{BLUE, DARK, GREY, Stroke, VERMILION};
use super::loglog::{Axis, Curve, Drawn, LogPlot, Mark, Place, Point, draw_plot, number, seconds, share};
use super::study::{by_patches, point, shade};
use crate::measure::{Slope, StudyRow, StudySolver, Trend};
use crate::output::StudySummary;

/// Width and height of the figure, pixels.
const SIZE: (u32, u32) = (1120, 820);

/// Writes `knobs.svg`: four plots, each with one knob on its axis and the fitted power laws.
///
/// # Errors
/// Those of `writer`.
pub fn write_knobs_plot(writer: &mut dyn Write, study: &StudySummary) -> io::Result<()> {
    let mut svg = String::new();
    draw(&mut svg, study).map_err(io::Error::other)?;
    writer.write_all(svg.as_bytes())
}

fn draw(svg: &mut String, study: &StudySummary) -> Drawn {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let [width, height] = [SIZE.0 as i32 / 2, SIZE.1 as i32 / 2];
    let plots = [patches(study), rays(study), orders(study), solving(study)];
    for (k, plot) in plots.iter().enumerate() {
        let [column, row] = [k as i32 % 2, k as i32 / 2];
        draw_plot(&root, Place([column * width + 4, row * height, width - 8, height - 4]), plot)?;
    }
    root.present()?;
    Ok(())
}

const ERROR: &str = "error, relative RMS";

fn error_axis() -> Axis {
    Axis { name: ERROR.into(), ticks: Vec::new(), label: share }
}

/// Values of a knob as ticks.
fn values(name: &str, mut ticks: Vec<f64>) -> Axis {
    ticks.sort_by(f64::total_cmp);
    ticks.dedup();
    Axis { name: name.into(), ticks, label: number }
}

/// The fitted law over the values that a trend has.
fn law(rows: &[StudyRow], trend: Option<&Trend>, value: fn(&StudyRow) -> f64) -> Option<Curve> {
    let trend = trend?;
    let slope: Slope = trend.slope?;
    let ends = [trend.rows.first()?, trend.rows.last()?].map(|&k| value(&rows[k]));
    let name = format!("slope {:.2} ± {:.2}", slope.slope, slope.standard_error.max(0.01)).replace('-', "−");
    let points = ends.map(|x| Point::at(x, slope.at(x))).to_vec();
    let (stroke, mark) = (Some(Stroke::Dashed), Mark::Nothing);
    Some(Curve { stroke, mark, ..Curve::line(name, points, DARK) })
}

fn patches(study: &StudySummary) -> LogPlot {
    let value = |row: &StudyRow| row.patches as f64;
    let mut cg: Vec<&StudyRow> = study.rows.iter().filter(|row| row.solver == StudySolver::Cg).collect();
    cg.sort_by_key(|row| (row.rays, row.asked));
    let lines: Vec<&[&StudyRow]> = cg.chunk_by(|a, b| a.rays == b.rays).collect();
    let curve = |(k, along): (usize, &&[&StudyRow])| {
        let points = along.iter().map(|row| point(row, value(row))).collect();
        Curve::line(format!("{} rays", along[0].rays), points, shade(k, lines.len()))
    };
    let mut curves: Vec<Curve> = lines.iter().enumerate().map(curve).collect();
    curves.extend(law(&study.rows, study.conclusions.patches.as_ref(), value));
    let ticks = by_patches(&study.rows).iter().map(|along| along[0].patches as f64).collect();
    LogPlot { title: "More patches".into(), x: values("patches", ticks), y: error_axis(), names: 160, curves }
}

fn rays(study: &StudySummary) -> LogPlot {
    let value = |row: &StudyRow| f64::from(row.rays);
    let lines = by_patches(&study.rows);
    let curve = |(k, along): (usize, &Vec<&StudyRow>)| {
        let points = along.iter().map(|row| point(row, value(row))).collect();
        Curve::line(format!("{} patches", along[0].patches), points, shade(k, lines.len()))
    };
    let mut curves: Vec<Curve> = lines.iter().enumerate().map(curve).collect();
    curves.extend(law(&study.rows, study.conclusions.rays.as_ref(), value));
    let ticks = lines.iter().flatten().map(|row| f64::from(row.rays)).collect();
    LogPlot {
        title: "More rays".into(),
        x: values("rays per patch", ticks),
        y: error_axis(),
        names: 160,
        curves,
    }
}

fn orders(study: &StudySummary) -> LogPlot {
    let lines = by_patches(&study.rows);
    let order = |row: &StudyRow| row.order.unwrap_or(0) as f64;
    let mut curves = Vec::new();
    for (k, along) in lines.iter().enumerate() {
        // On its best rays.
        let Some(end) = along.last() else { continue };
        let mut series: Vec<&StudyRow> =
            study.rows.iter().filter(|row| row.order.is_some() && row.cell() == end.cell()).collect();
        series.sort_by_key(|row| row.order);
        let points: Vec<Point> = series.iter().map(|row| point(row, order(row))).collect();
        curves.push(Curve::line(format!("{} patches", end.patches), points, shade(k, lines.len())));
    }
    let ticks = study.rows.iter().filter(|row| row.order.is_some()).map(order).collect();
    LogPlot {
        title: "Higher order of the series, each at its most rays".into(),
        x: values("order of the series", ticks),
        y: error_axis(),
        names: 160,
        curves,
    }
}

/// What solving takes by solver, and what comes before, at the most rays that all numbers of patches have.
fn solving(study: &StudySummary) -> LogPlot {
    let lines = by_patches(&study.rows);
    let most = |along: &Vec<&StudyRow>| along.iter().map(|row| row.rays).max();
    let common = lines.iter().filter_map(most).min().unwrap_or(0);
    let at = |solver: StudySolver, order: Option<usize>, time: fn(&StudyRow) -> f64| {
        let mut of: Vec<&StudyRow> = study
            .rows
            .iter()
            .filter(|row| row.solver == solver && row.order == order && row.rays == common)
            .collect();
        of.sort_by_key(|row| row.patches);
        of.into_iter().map(|row| Point::at(row.patches as f64, time(row))).collect::<Vec<_>>()
    };
    let last = study.rows.iter().filter_map(|row| row.order).max();
    let solve: fn(&StudyRow) -> f64 = |row| row.solve_seconds;
    let curves = vec![
        Curve::line(
            "before solving".into(),
            at(StudySolver::Cg, None, |row| row.seconds - row.solve_seconds),
            GREY,
        ),
        Curve::line("direct".into(), at(StudySolver::Direct, None, solve), BLUE),
        Curve::line(format!("order {}", last.unwrap_or(0)), at(StudySolver::Neumann, last, solve), VERMILION),
        Curve::line("cg".into(), at(StudySolver::Cg, None, solve), DARK),
    ];
    let ticks = lines.iter().map(|along| along[0].patches as f64).collect();
    LogPlot {
        title: format!("Time of solving, {common} rays"),
        x: values("patches", ticks),
        y: Axis { name: "seconds".into(), ticks: Vec::new(), label: seconds },
        names: 160,
        curves,
    }
}
