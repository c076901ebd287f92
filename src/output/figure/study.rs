//! Study: error against time on logarithmic axes, as SVG.

use std::io::{self, Write};

use plotters::prelude::*;

use super::axes::{BLUE, DARK, GREY, Stroke, VERMILION, short_percent};
use super::loglog::{Axis, Curve, Drawn, LogPlot, Mark, Place, Point, draw_plot, seconds, share};
use crate::measure::{StudyRow, StudySolver};
use crate::output::StudySummary;

/// Width and height, pixels.
const SIZE: (u32, u32) = (960, 600);

/// Room for names.
const NAMES: i32 = 240;

/// From few patches to many: from light to dark, apart with any kind of colour blindness too.
const SHADES: [RGBColor; 5] = [
    RGBColor(230, 159, 0),
    RGBColor(170, 160, 40),
    RGBColor(53, 150, 100),
    RGBColor(38, 110, 150),
    RGBColor(62, 40, 120),
];

/// Pale, for what lies below the rest.
const PALE: RGBColor = RGBColor(205, 205, 205);

/// The colour of the k-th of `count` numbers of patches.
pub(super) fn shade(k: usize, count: usize) -> RGBColor {
    SHADES[if count > 1 { k * (SHADES.len() - 1) / (count - 1) } else { SHADES.len() - 1 }]
}

/// Writes `study.svg`: every row's error against its time; the front of those that nothing beats, light
/// paths, and the reference's noise.
///
/// # Errors
/// Those of `writer`.
pub fn write_study_plot(writer: &mut dyn Write, study: &StudySummary) -> io::Result<()> {
    let mut svg = String::new();
    draw(&mut svg, study).map_err(io::Error::other)?;
    writer.write_all(svg.as_bytes())
}

fn draw(svg: &mut String, study: &StudySummary) -> Drawn {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let plot = LogPlot {
        title: format!("{}: what accuracy costs in time", study.scene),
        x: Axis { name: "seconds from mesh to irradiance".into(), ticks: Vec::new(), label: seconds },
        y: Axis { name: "error of irradiance by face, relative RMS".into(), ticks: Vec::new(), label: share },
        names: NAMES,
        curves: curves(study),
    };
    draw_plot(&root, Place([8, 4, SIZE.0 as i32 - 16, SIZE.1 as i32 - 12]), &plot)?;
    root.present()?;
    Ok(())
}

/// A row as a point; what the noise hides stands at its limit.
pub(super) fn point(row: &StudyRow, x: f64) -> Point {
    Point { x, y: row.reading().most(), error: row.error_se, note: String::new() }
}

/// Rows of conjugate gradients by number of patches asked for, each with ascending rays.
pub(super) fn by_patches(rows: &[StudyRow]) -> Vec<Vec<&StudyRow>> {
    let mut cg: Vec<&StudyRow> = rows.iter().filter(|row| row.solver == StudySolver::Cg).collect();
    cg.sort_by_key(|row| (row.asked, row.rays));
    cg.chunk_by(|a, b| a.asked == b.asked).map(<[_]>::to_vec).collect()
}

fn curves(study: &StudySummary) -> Vec<Curve> {
    let StudySummary { rows, conclusions, .. } = study;
    let ends = |pick: fn(f64, f64) -> f64, start: f64| rows.iter().map(|row| row.seconds).fold(start, pick);
    let (first, last) = (ends(f64::min, f64::INFINITY), ends(f64::max, 0.0));
    let noise = conclusions.noise;
    let front = conclusions.front.iter().map(|&k| Point::at(rows[k].seconds, rows[k].reading().most()));
    let points = |solver: StudySolver| {
        rows.iter().filter(|row| row.solver == solver).map(|row| point(row, row.seconds)).collect()
    };
    let mut curves = vec![
        Curve {
            ink: GREY,
            width: 9,
            mark: Mark::Nothing,
            ..Curve::line("nothing both quicker and better".into(), front.collect(), PALE)
        },
        Curve {
            stroke: Some(Stroke::Dotted),
            mark: Mark::Nothing,
            ..Curve::line(
                format!("noise of the reference, {}", short_percent(noise)),
                vec![Point::at(first, noise), Point::at(last, noise)],
                GREY,
            )
        },
        Curve {
            stroke: Some(Stroke::Dashed),
            mark: Mark::Cross,
            ..Curve::line("light paths (path tracer)".into(), points(StudySolver::Paths), DARK)
        },
        Curve {
            stroke: None,
            mark: Mark::Square,
            ..Curve::line("direct solver".into(), points(StudySolver::Direct), BLUE)
        },
    ];
    if let Some(order) = &conclusions.order {
        let points = order.rows.iter().map(|&k| {
            let row = &rows[k];
            let k = row.order.unwrap_or(0);
            let note = if row.error > 1.5 * rows[order.converged].error {
                format!("order {k}")
            } else {
                String::new()
            };
            Point { note, ..point(row, row.seconds) }
        });
        let series = Curve::line("series, truncated".into(), points.collect(), VERMILION);
        curves.push(Curve { stroke: Some(Stroke::Dotted), width: 1, mark: Mark::Diamond, ..series });
    }
    let by_patches = by_patches(rows);
    for (k, along) in by_patches.iter().enumerate() {
        let points = along.iter().map(|row| {
            let rays = if k == 0 { format!("{} rays", row.rays) } else { String::new() };
            Point { note: rays, ..point(row, row.seconds) }
        });
        let name = format!("{} patches", along[0].patches);
        curves.push(Curve::line(name, points.collect(), shade(k, by_patches.len())));
    }
    curves
}
