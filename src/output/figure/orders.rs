//! Orders: error of the Neumann series against its order, on a logarithmic axis, as SVG.

use std::io::{self, Write};

use plotters::coord::Shift;
use plotters::coord::combinators::LogCoord;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::axes::{
    BLUE, DARK, GREEN, GREY, Stroke, VERMILION, apart, is_shown, percent, power_of_ten, short_percent,
};

/// Width and height, pixels.
const SIZE: (u32, u32) = (800, 500);

/// Room for the names of curves, right of them.
const NAMES: u32 = 215;

/// Length of the piece of a curve that stands before its name.
const SWATCH: i32 = 21;

/// Name of the curve of bounds.
const BOUND: &str = "bound, guaranteed";

/// No more decades than this are shown below the largest value.
const DECADES: i32 = 12;

/// What the plot shows; errors are relative, 1 is 100 %. Values that are not positive and finite are left
/// out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OrdersPlot {
    /// The orders k, ascending.
    pub orders: Vec<usize>,
    /// Of each order: relative RMS difference from the direct solution.
    pub vs_direct: Vec<f64>,
    /// Of each order: relative RMS difference from the reference.
    pub vs_reference: Vec<f64>,
    /// Of each order: one standard error of `vs_reference`.
    pub uncertainty: Vec<f64>,
    /// Of each order: what `vs_direct` is guaranteed not to exceed.
    pub bound: Vec<f64>,
    /// Relative RMS difference of the direct solution from the reference.
    pub direct_vs_reference: f64,
    /// Relative RMS noise of the reference.
    pub noise_floor: f64,
    /// What stands above it.
    pub title: String,
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, LogCoord<f64>>>;

/// A named curve.
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    colour: RGBColor,
    stroke: Stroke,
    /// Radius of the dots at its points, if they are marked.
    dots: Option<i32>,
}

/// Writes the plot as SVG.
///
/// # Errors
/// Those of `writer`.
///
/// # Panics
/// If there are not as many values as orders.
pub fn write_orders_plot(writer: &mut dyn Write, plot: &OrdersPlot) -> io::Result<()> {
    let n = plot.orders.len();
    let lengths = [&plot.vs_direct, &plot.vs_reference, &plot.uncertainty, &plot.bound].map(Vec::len);
    assert_eq!(lengths, [n; 4], "one value per order");
    let mut svg = String::new();
    draw(&mut svg, plot).map_err(io::Error::other)?;
    writer.write_all(svg.as_bytes())
}

fn draw(svg: &mut String, plot: &OrdersPlot) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let first = plot.orders.first().map_or(0.0, |&k| k as f64);
    let last = plot.orders.last().map_or(1.0, |&k| k as f64).max(first + 1.0);
    let curves = curves(plot, [first, last]);
    let [low, high] = axis(&curves);
    let mut chart = ChartBuilder::on(&root)
        .caption(&plot.title, ("sans-serif", 18).into_font().color(&DARK))
        .margin(14)
        .margin_right(NAMES)
        .x_label_area_size(44)
        .y_label_area_size(76)
        .build_cartesian_2d(first - 0.02 * (last - first)..last, (0.97 * low..high).log_scale())?;
    let small = ("sans-serif", 13).into_font().color(&DARK);
    let fine = low < 0.9e-6;
    chart
        .configure_mesh()
        .x_desc("order k of the series")
        .y_desc("error of irradiance, relative RMS")
        .x_labels((last - first).min(12.0) as usize + 1)
        .y_labels(((high / low).log10().round() as usize + 1).min(14))
        .x_label_formatter(&|x| if x.fract() == 0.0 { format!("{x}") } else { String::new() })
        .y_label_formatter(&|y| if fine { power_of_ten(*y) } else { percent(*y) })
        .label_style(small.clone())
        .axis_desc_style(("sans-serif", 14).into_font().color(&DARK))
        .bold_line_style(RGBColor(222, 222, 222))
        .light_line_style(TRANSPARENT)
        .axis_style(GREY)
        .draw()?;
    draw_band(&mut chart, plot, [low, high])?;
    for curve in &curves {
        draw_curve(&mut chart, curve, [low, high])?;
    }
    draw_names(&root, &chart, &curves, [low, high])?;
    root.present()?;
    Ok(())
}

/// The curves of a plot between two orders; the last drawn is on top.
fn curves(plot: &OrdersPlot, [first, last]: [f64; 2]) -> Vec<Curve> {
    let of_orders = |values: &[f64]| -> Vec<(f64, f64)> {
        plot.orders.iter().map(|&k| k as f64).zip(values.iter().copied()).filter(|p| is_shown(p.1)).collect()
    };
    let level = |value: f64| if is_shown(value) { vec![(first, value), (last, value)] } else { Vec::new() };
    let curve =
        |name: &str, points, colour, stroke, dots| Curve { name: name.into(), points, colour, stroke, dots };
    let (direct, noise) = (plot.direct_vs_reference, plot.noise_floor);
    let all = [
        curve(
            &format!("noise of reference, {}", short_percent(noise)),
            level(noise),
            GREY,
            Stroke::Dotted,
            None,
        ),
        curve(
            &format!("direct vs reference, {}", short_percent(direct)),
            level(direct),
            GREEN,
            Stroke::Dashed,
            None,
        ),
        curve(BOUND, of_orders(&plot.bound), DARK, Stroke::Dashed, None),
        curve("order k vs direct", of_orders(&plot.vs_direct), BLUE, Stroke::Solid, Some(5)),
        curve(
            "order k vs reference ± 1 s.e.",
            of_orders(&plot.vs_reference),
            VERMILION,
            Stroke::Solid,
            Some(3),
        ),
    ];
    all.into_iter().filter(|c| !c.points.is_empty()).collect()
}

/// The decades that curves are shown in. A bound far above all errors does not stretch them.
fn axis(curves: &[Curve]) -> [f64; 2] {
    let values = |curve: &Curve| curve.points.iter().map(|p| p.1).collect::<Vec<_>>();
    let (bounds, errors): (Vec<&Curve>, Vec<&Curve>) = curves.iter().partition(|c| c.name == BOUND);
    let errors: Vec<f64> = errors.into_iter().flat_map(values).collect();
    let most = errors.iter().copied().fold(0.0, f64::max);
    let most = if most > 0.0 { 10.0 * most } else { f64::INFINITY };
    decades(errors.iter().copied().chain(bounds.into_iter().flat_map(values).filter(|&y| y <= most)))
}

/// The powers of ten around these values.
fn decades(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), y| (low.min(y), high.max(y)));
    if high == 0.0 {
        return [1e-3, 1.0];
    }
    let top = high.log10().ceil() as i32;
    let bottom = (low.log10().floor() as i32).clamp(top - DECADES, top - 1);
    [10f64.powi(bottom), 10f64.powi(top)]
}

/// Draws `vs_reference` ± its uncertainty as a band.
fn draw_band(
    chart: &mut Chart,
    plot: &OrdersPlot,
    [low, high]: [f64; 2],
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let values = plot.orders.iter().zip(plot.vs_reference.iter().zip(&plot.uncertainty));
    let sound = values.filter(|(_, (v, u))| is_shown(**v) && u.is_finite() && **u >= 0.0);
    let edges: Vec<(f64, [f64; 2])> =
        sound.map(|(&k, (v, u))| (k as f64, [(v - u).clamp(low, high), (v + u).clamp(low, high)])).collect();
    let upper = edges.iter().map(|&(k, [_, y])| (k, y));
    let outline: Vec<(f64, f64)> = upper.chain(edges.iter().rev().map(|&(k, [y, _])| (k, y))).collect();
    if edges.len() > 1 {
        chart.draw_series([Polygon::new(outline, VERMILION.mix(0.2))])?;
    }
    Ok(())
}

fn draw_curve(
    chart: &mut Chart,
    curve: &Curve,
    [low, high]: [f64; 2],
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let points = || curve.points.iter().copied().filter(|p| (low..=high).contains(&p.1));
    let style = curve.colour.stroke_width(2);
    match curve.stroke {
        Stroke::Solid => chart.draw_series(LineSeries::new(points(), style))?,
        Stroke::Dashed => chart.draw_series(DashedLineSeries::new(points(), 8, 5, style))?,
        Stroke::Dotted => chart.draw_series(DashedLineSeries::new(points(), 2, 4, style))?,
    };
    if let Some(radius) = curve.dots {
        chart.draw_series(points().map(|p| Circle::new(p, radius, curve.colour.filled())))?;
    }
    Ok(())
}

/// Writes each curve's name beside its end, moved apart where ends are close.
fn draw_names(
    root: &DrawingArea<SVGBackend, Shift>,
    chart: &Chart,
    curves: &[Curve],
    [low, high]: [f64; 2],
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let end = |curve: &Curve| {
        let last =
            curve.points.iter().rev().find(|p| (low..=high).contains(&p.1)).unwrap_or(&curve.points[0]);
        chart.backend_coord(&(last.0, last.1.clamp(low, high))).1
    };
    let mut names: Vec<(i32, &Curve)> = curves.iter().map(|curve| (end(curve), curve)).collect();
    names.sort_by_key(|&(y, _)| y);
    let places = apart(&names.iter().map(|name| name.0).collect::<Vec<_>>(), SIZE.1 as i32 - 60);
    let right = (SIZE.0 - NAMES) as i32 + 6;
    for ((_, curve), y) in names.into_iter().zip(places) {
        let style = ("sans-serif", 13).into_font().color(&curve.colour);
        let (dash, gap) = match curve.stroke {
            Stroke::Solid => (SWATCH, 1),
            Stroke::Dashed => (8, 5),
            Stroke::Dotted => (2, 4),
        };
        for start in (0..SWATCH).step_by((dash + gap) as usize) {
            let ends = vec![(right + start, y), (right + (start + dash).min(SWATCH), y)];
            root.draw(&PathElement::new(ends, curve.colour.stroke_width(2)))?;
        }
        if let Some(radius) = curve.dots {
            root.draw(&Circle::new((right + SWATCH / 2, y), radius, curve.colour.filled()))?;
        }
        root.draw(&Text::new(curve.name.clone(), (right + SWATCH + 6, y - 7), style))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> OrdersPlot {
        let orders: Vec<usize> = (0..=12).collect();
        let fall = |k: &usize| 0.6f64.powi(*k as i32 + 1);
        OrdersPlot {
            vs_direct: orders.iter().map(fall).collect(),
            vs_reference: orders.iter().map(|k| fall(k).hypot(0.006)).collect(),
            uncertainty: vec![0.002; 13],
            bound: orders.iter().map(|k| 4.0 * fall(k)).collect(),
            orders,
            direct_vs_reference: 0.006,
            noise_floor: 0.003,
            title: "Cornell box".into(),
        }
    }

    fn svg(plot: &OrdersPlot) -> String {
        let mut bytes = Vec::new();
        write_orders_plot(&mut bytes, plot).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn every_curve_is_drawn_and_named() {
        let svg = svg(&plot());
        for word in [
            "Cornell box",
            "order k vs direct",
            "± 1 s.e.",
            "bound",
            "noise of reference, 0.30 %",
            "0.60 %",
            "order k of",
        ] {
            assert!(svg.contains(word), "{word}");
        }
        assert_eq!(svg.matches("<circle").count(), 2 * 13 + 2);
        assert!(svg.contains("<polygon"), "the band");
    }

    #[test]
    fn what_a_logarithm_has_no_place_for_is_left_out() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-310, f64::MIN_POSITIVE, f64::MAX] {
            let mut some = plot();
            (some.vs_direct[3], some.bound[0], some.uncertainty[5]) = (bad, bad, bad);
            (some.noise_floor, some.vs_reference[1]) = (bad, bad);
            let all = OrdersPlot {
                vs_direct: vec![bad; 13],
                vs_reference: vec![bad; 13],
                uncertainty: vec![bad; 13],
                bound: vec![bad; 13],
                direct_vs_reference: bad,
                noise_floor: bad,
                ..plot()
            };
            for drawn in [svg(&some), svg(&all)] {
                assert!(
                    drawn.ends_with("</svg>\n") && !drawn.contains("NaN") && !drawn.contains("inf"),
                    "{bad}"
                );
            }
        }
        let circles = svg(&OrdersPlot { vs_direct: vec![0.0; 13], ..plot() }).matches("<circle").count();
        assert_eq!(circles, 13 + 1);
    }

    #[test]
    fn no_order_and_one_order_are_plots_too() {
        assert!(svg(&OrdersPlot::default()).contains("order k of"));
        let one = OrdersPlot {
            orders: vec![3],
            vs_direct: vec![0.1],
            vs_reference: vec![0.1],
            uncertainty: vec![0.0],
            bound: vec![0.2],
            ..Default::default()
        };
        assert!(svg(&one).contains("bound"));
    }

    #[test]
    fn the_axis_spans_whole_decades_but_not_too_many() {
        let close = |values: &[f64], [low, high]: [f64; 2]| {
            let [a, b] = decades(values.iter().copied());
            assert!((a / low - 1.0).abs() < 1e-9 && (b / high - 1.0).abs() < 1e-9, "{a} {b}");
        };
        close(&[0.02, 0.5], [0.01, 1.0]);
        close(&[1.0], [0.1, 1.0]);
        close(&[1e-40, 5.0], [1e-11, 10.0]);
        close(&[], [1e-3, 1.0]);
    }

    #[test]
    fn a_bound_far_above_all_errors_does_not_stretch_the_axis() {
        let far = OrdersPlot { bound: vec![1e9; 13], ..plot() };
        assert_eq!(axis(&curves(&far, [0.0, 12.0]))[1], 1.0);
        assert_eq!(axis(&curves(&plot(), [0.0, 12.0]))[1], 10.0);
    }
}
