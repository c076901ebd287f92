//! Small multiples: plots of a few curves each on logarithmic axes, side by side, as SVG.

use std::io::{self, Write};

use plotters::prelude::*;

use super::axes::{BLUE, DARK, GREEN, VERMILION, power_of_ten};
use super::loglog::{Axis, Curve, Drawn, LogPlot, Place, Point, draw_plot};

/// Width and height of each plot, and room for names, pixels.
const PLOT: [i32; 2] = [460, 350];
const NAMES: i32 = 130;

/// Plots side by side.
const COLUMNS: usize = 3;

/// Apart with any kind of colour blindness (Okabe & Ito 2008).
const COLOURS: [RGBColor; 5] = [BLUE, VERMILION, GREEN, DARK, RGBColor(190, 90, 150)];

/// One plot. Values that are not positive and finite are left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SmallPlot {
    /// What stands above it.
    pub title: String,
    /// What the axes show, with units.
    pub axes: [String; 2],
    /// Names, and x and y of points.
    pub curves: Vec<(String, Vec<[f64; 2]>)>,
}

/// Writes plots, three side by side.
///
/// # Errors
/// Those of `writer`.
pub fn write_small_plots(writer: &mut dyn Write, plots: &[SmallPlot]) -> io::Result<()> {
    let mut svg = String::new();
    draw(&mut svg, plots).map_err(io::Error::other)?;
    writer.write_all(svg.as_bytes())
}

fn draw(svg: &mut String, plots: &[SmallPlot]) -> Drawn {
    let [width, height] = PLOT;
    let rows = plots.len().div_ceil(COLUMNS).max(1);
    let size = (width as u32 * COLUMNS as u32, height as u32 * rows as u32);
    let root = SVGBackend::with_string(svg, size).into_drawing_area();
    root.fill(&WHITE)?;
    for (k, plot) in plots.iter().enumerate() {
        let [left, top] = [(k % COLUMNS) as i32 * width, (k / COLUMNS) as i32 * height];
        let [x, y] = plot.axes.clone().map(|name| Axis { name, ticks: Vec::new(), label: power_of_ten });
        let curve = |(k, (name, points)): (usize, &(String, Vec<[f64; 2]>))| {
            let points = points.iter().map(|&[x, y]| Point::at(x, y)).collect();
            Curve::line(name.clone(), points, COLOURS[k % COLOURS.len()])
        };
        let curves = plot.curves.iter().enumerate().map(curve).collect();
        let plot = LogPlot { title: plot.title.clone(), x, y, names: NAMES, curves };
        draw_plot(&root, Place([left, top, width, height]), &plot)?;
    }
    root.present()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_curve_is_drawn_and_what_a_logarithm_has_no_place_for_is_not() {
        let curve = |y: f64| ("curve".to_owned(), vec![[1.0, 1e-3], [10.0, y], [100.0, 1e-1]]);
        let plot = |y: f64| SmallPlot {
            title: "some plot".into(),
            axes: ["across".into(), "up".into()],
            curves: vec![curve(1e-2), curve(y)],
        };
        for (y, dots) in [(0.5, 6), (0.0, 5), (f64::NAN, 5), (f64::INFINITY, 5)] {
            let mut svg = Vec::new();
            write_small_plots(&mut svg, &[plot(y), plot(y)]).unwrap();
            let svg = String::from_utf8(svg).unwrap();
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"));
            // A dot a point, and one before each name.
            assert_eq!(svg.matches("<circle").count(), 2 * (dots + 2), "{y}");
            for word in ["some plot", "across", "up", "10⁻²"] {
                assert!(svg.contains(word), "{word}");
            }
        }
        write_small_plots(&mut Vec::new(), &[]).unwrap();
    }
}
