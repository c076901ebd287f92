//! Log-log plot: curves on two logarithmic axes, each named beside the plot or at its end, drawn into a part
//! of a figure.

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axes::{DARK, GREY, Stroke, apart, is_shown};

pub(super) type Root<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Drawn = Result<(), Box<dyn std::error::Error + Send + Sync>>;

/// Length of the piece of a curve that stands before its name.
const SWATCH: i32 = 24;

/// Room for numbers and names of axes, left of and below a plot, and for its title above.
const LEFT: i32 = 74;
const BELOW: i32 = 52;
const ABOVE: i32 = 40;

/// One axis.
pub(super) struct Axis {
    /// What it shows, with its unit.
    pub name: String,
    /// Where a line and a number stand; powers of ten if there are none.
    pub ticks: Vec<f64>,
    /// How a number is written.
    pub label: fn(f64) -> String,
}

/// How a curve's points are marked.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Mark {
    Nothing,
    Dot,
    Square,
    Diamond,
    Cross,
}

/// A point of a curve.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub x: f64,
    pub y: f64,
    /// One standard error of y.
    pub error: f64,
    /// Stands left of and below it; empty for nothing.
    pub note: String,
}

impl Point {
    /// Without uncertainty and note.
    pub fn at(x: f64, y: f64) -> Self {
        Self { x, y, error: 0.0, note: String::new() }
    }

    fn is_shown(&self) -> bool {
        is_shown(self.x) && is_shown(self.y)
    }
}

/// A named curve; a later one is drawn on top.
pub(super) struct Curve {
    /// What it is called; empty for no name.
    pub name: String,
    pub points: Vec<Point>,
    pub colour: RGBColor,
    /// Of its name, where that would be too pale in the curve's own.
    pub ink: RGBColor,
    /// None for points that no line joins.
    pub stroke: Option<Stroke>,
    pub width: u32,
    pub mark: Mark,
}

impl Curve {
    /// A solid line of dots.
    pub fn line(name: String, points: Vec<Point>, colour: RGBColor) -> Self {
        let (stroke, mark) = (Some(Stroke::Solid), Mark::Dot);
        Self { name, points, colour, ink: colour, stroke, width: 2, mark }
    }
}

/// A plot.
pub(super) struct LogPlot {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// Room for names, right of it.
    pub names: i32,
    pub curves: Vec<Curve>,
}

/// A rectangle of the figure, pixels: left, top, width and height.
#[derive(Clone, Copy)]
pub(super) struct Place(pub [i32; 4]);

/// A logarithmic scale: values from `low` to `high` on pixels from `start` to `end`.
#[derive(Clone, Copy)]
struct Scale {
    low: f64,
    high: f64,
    start: i32,
    end: i32,
}

impl Scale {
    /// For these values, with some room around them.
    fn around(values: impl Iterator<Item = f64>, [start, end]: [i32; 2]) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
        let (low, high) = if high > 0.0 { (low, high) } else { (0.1, 1.0) };
        let room = (high / low).powf(0.06).max(1.1);
        Self { low: low / room, high: high * room, start, end }
    }

    fn place(&self, x: f64) -> i32 {
        let share = (x / self.low).ln() / (self.high / self.low).ln();
        self.start + (share.clamp(-0.5, 1.5) * f64::from(self.end - self.start)).round() as i32
    }

    /// The given ticks, or the powers of ten, within it.
    fn ticks(&self, given: &[f64]) -> Vec<f64> {
        let decades = |x: f64| x.log10().floor() as i32;
        let [first, last] = [decades(self.low), decades(self.high)];
        // Every second or third of many, zero among them.
        let step = 1 + (last - first) / 8;
        let powers = (first..=last).filter(|power| power % step == 0);
        let powers: Vec<f64> = powers.map(|power| 10f64.powi(power)).collect();
        let all = if given.is_empty() { &powers } else { given };
        all.iter().copied().filter(|x| (self.low..=self.high).contains(x)).collect()
    }
}

/// Draws a plot into its place.
pub(super) fn draw_plot(root: &Root, place: Place, plot: &LogPlot) -> Drawn {
    let Place([left, top, width, height]) = place;
    let [x0, x1] = [left + LEFT, left + width - plot.names];
    let [y0, y1] = [top + height - BELOW, top + ABOVE];
    let shown = || plot.curves.iter().flat_map(|curve| &curve.points).filter(|p| p.is_shown());
    let x = Scale::around(shown().map(|p| p.x), [x0, x1]);
    let y = Scale::around(shown().map(|p| p.y), [y0, y1]);
    let title = style(16, DARK).pos(Pos::new(HPos::Left, VPos::Center));
    root.draw(&Text::new(plot.title.clone(), (x0, top + 18), title))?;
    draw_axes(root, plot, &x, &y)?;
    // Notes interrupt lines, and no mark.
    for curve in &plot.curves {
        draw_curve(root, curve, &x, &y)?;
    }
    for curve in &plot.curves {
        draw_notes(root, curve, &x, &y)?;
    }
    for curve in &plot.curves {
        draw_marks(root, curve, &x, &y)?;
    }
    draw_names(root, plot, &y, x1 + 12)
}

fn style(size: i32, colour: RGBColor) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&colour)
}

fn draw_axes(root: &Root, plot: &LogPlot, x: &Scale, y: &Scale) -> Drawn {
    let light = RGBColor(226, 226, 226).stroke_width(1);
    let number = |h, v| style(13, DARK).pos(Pos::new(h, v));
    for tick in x.ticks(&plot.x.ticks) {
        let at = x.place(tick);
        root.draw(&PathElement::new(vec![(at, y.start), (at, y.end)], light))?;
        root.draw(&Text::new((plot.x.label)(tick), (at, y.start + 6), number(HPos::Center, VPos::Top)))?;
    }
    for tick in y.ticks(&plot.y.ticks) {
        let at = y.place(tick);
        root.draw(&PathElement::new(vec![(x.start, at), (x.end, at)], light))?;
        root.draw(&Text::new((plot.y.label)(tick), (x.start - 8, at), number(HPos::Right, VPos::Center)))?;
    }
    let frame = vec![(x.start, y.end), (x.start, y.start), (x.end, y.start)];
    root.draw(&PathElement::new(frame, GREY.stroke_width(1)))?;
    let middle = Pos::new(HPos::Center, VPos::Center);
    let name = |text: &str, at: (i32, i32), turned: bool| {
        let style = style(14, DARK).pos(middle);
        let style = if turned { style.transform(FontTransform::Rotate270) } else { style };
        Text::new(text.to_owned(), at, style)
    };
    root.draw(&name(&plot.x.name, ((x.start + x.end) / 2, y.start + 36), false))?;
    root.draw(&name(&plot.y.name, (x.start - LEFT + 14, (y.start + y.end) / 2), true))?;
    Ok(())
}

fn draw_curve(root: &Root, curve: &Curve, x: &Scale, y: &Scale) -> Drawn {
    let points = curve.points.iter().filter(|p| p.is_shown());
    let places: Vec<(i32, i32)> = points.map(|p| (x.place(p.x), y.place(p.y))).collect();
    curve.stroke.map_or(Ok(()), |stroke| draw_line(root, &places, curve, stroke))
}

/// Draws each point with its uncertainty.
fn draw_marks(root: &Root, curve: &Curve, x: &Scale, y: &Scale) -> Drawn {
    for point in curve.points.iter().filter(|p| p.is_shown()) {
        let at = (x.place(point.x), y.place(point.y));
        if point.error > 0.0 && point.error.is_finite() {
            let low = (point.y - point.error).max(y.low);
            let bar = vec![(at.0, y.place(low)), (at.0, y.place(point.y + point.error))];
            root.draw(&PathElement::new(bar, curve.colour.stroke_width(1)))?;
        }
        draw_mark(root, curve, at)?;
    }
    Ok(())
}

/// Writes what stands beside points, on white so that no line runs through it.
fn draw_notes(root: &Root, curve: &Curve, x: &Scale, y: &Scale) -> Drawn {
    /// Height of a line and, about, width of a letter, pixels.
    const HEIGHT: i32 = 13;
    const LETTER: i32 = 6;
    for point in curve.points.iter().filter(|p| p.is_shown() && !p.note.is_empty()) {
        let at = (x.place(point.x), y.place(point.y));
        let width = LETTER * point.note.chars().count() as i32;
        let (left, top) = (at.0 - 8 - width, at.1 + 3);
        let corners = [(left - 1, top), (left + width + 1, top + HEIGHT)];
        root.draw(&Rectangle::new(corners, WHITE.filled()))?;
        let style = style(12, curve.ink).pos(Pos::new(HPos::Center, VPos::Center));
        let middle = (left + width / 2, top + HEIGHT / 2);
        root.draw(&Text::new(point.note.clone(), middle, style))?;
    }
    Ok(())
}

fn draw_line(root: &Root, places: &[(i32, i32)], curve: &Curve, stroke: Stroke) -> Drawn {
    let style = curve.colour.stroke_width(curve.width);
    match stroke {
        Stroke::Solid => root.draw(&PathElement::new(places.to_vec(), style))?,
        Stroke::Dashed => root.draw(&DashedPathElement::new(places.to_vec(), 8, 5, style))?,
        Stroke::Dotted => root.draw(&DashedPathElement::new(places.to_vec(), 2, 4, style))?,
    }
    Ok(())
}

fn draw_mark(root: &Root, curve: &Curve, (x, y): (i32, i32)) -> Drawn {
    let line = curve.colour.stroke_width(2);
    match curve.mark {
        Mark::Nothing => {}
        Mark::Dot => root.draw(&Circle::new((x, y), 4, curve.colour.filled()))?,
        Mark::Square => root.draw(&Rectangle::new([(x - 5, y - 5), (x + 5, y + 5)], line))?,
        Mark::Diamond => {
            let corners = vec![(x, y - 5), (x + 5, y), (x, y + 5), (x - 5, y)];
            root.draw(&Polygon::new(corners, curve.colour.filled()))?;
        }
        Mark::Cross => {
            root.draw(&PathElement::new(vec![(x - 4, y - 4), (x + 4, y + 4)], line))?;
            root.draw(&PathElement::new(vec![(x - 4, y + 4), (x + 4, y - 4)], line))?;
        }
    }
    Ok(())
}

/// Writes each curve's name right of the plot, at the height of its last point, moved apart where these are
/// close.
fn draw_names(root: &Root, plot: &LogPlot, y: &Scale, left: i32) -> Drawn {
    let mut names: Vec<(i32, &Curve)> = plot
        .curves
        .iter()
        .filter(|curve| !curve.name.is_empty())
        .filter_map(|curve| Some((y.place(curve.points.iter().rev().find(|p| p.is_shown())?.y), curve)))
        .collect();
    names.sort_by_key(|&(at, _)| at);
    let wanted: Vec<i32> = names.iter().map(|name| name.0.max(y.end + 6)).collect();
    for ((_, curve), at) in names.into_iter().zip(apart(&wanted, y.start - 6)) {
        if let Some(stroke) = curve.stroke {
            draw_line(root, &[(left, at), (left + SWATCH, at)], curve, stroke)?;
        }
        draw_mark(root, curve, (left + SWATCH / 2, at))?;
        let style = style(13, curve.ink).pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(curve.name.clone(), (left + SWATCH + 7, at), style))?;
    }
    Ok(())
}

/// Seconds as they are read.
pub(super) fn seconds(s: f64) -> String {
    if s < 0.0999 { format!("{} ms", number(1e3 * s)) } else { format!("{} s", number(s)) }
}

/// A share as per cent, with as many digits as it takes.
pub(super) fn share(x: f64) -> String {
    format!("{} %", number(100.0 * x))
}

/// A number without digits that say nothing.
pub(super) fn number(x: f64) -> String {
    let digits = (-x.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{x:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (x, text) in
            [(100.0, "100"), (10.0, "10"), (1.0, "1"), (0.1, "0.1"), (0.001, "0.001"), (2048.0, "2048")]
        {
            assert_eq!(number(x), text);
        }
        assert_eq!([seconds(0.01), seconds(0.1), seconds(10.0)], ["10 ms", "0.1 s", "10 s"]);
        assert_eq!([share(0.1), share(0.001)], ["10 %", "0.1 %"]);
    }

    #[test]
    fn a_scale_holds_its_values_and_its_powers_of_ten() {
        let scale = Scale::around([0.02, 3.0].into_iter(), [100, 500]);
        assert!(scale.place(0.02) > 100 && scale.place(3.0) < 500 && scale.place(0.3) > scale.place(0.1));
        let ticks = scale.ticks(&[]);
        assert!(ticks.len() == 2 && (ticks[0] - 0.1).abs() < 1e-12 && ticks[1] == 1.0);
        assert_eq!(scale.ticks(&[0.001, 0.5]), [0.5]);
        // Nothing to show is a scale too.
        assert!(Scale::around(std::iter::empty(), [0, 1]).high > 0.0);
    }
}
