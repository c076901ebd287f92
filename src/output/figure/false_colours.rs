//! False colours: a picture of illuminance or luminance, with a line wherever a round value is passed, and a
//! legend.

use std::f64::consts::TAU;
use std::io::{self, Write};

use super::canvas::{Area, Canvas, Colour, GREY, INK};
use super::diverging::oklab_to_linear;
use super::panel::{MARGIN, TITLE, draw_pixels, draw_title, enlargement};
use super::round_up;
use super::text::{Line, TextSize};
use crate::render::{Picture, luminance, to_byte};

/// Steps of the legend, from nothing to the highest value shown.
const STEPS: usize = 10;

/// The share of pixels that may be brighter than the highest value shown.
const ABOVE: f64 = 0.005;

/// Width of the legend's bar and of all of it, pixels.
const BAR: usize = 24;
const LEGEND: usize = 120;

/// Lamps and sky.
const BLANK: Colour = [200; 3];

/// What a picture in false colours shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Illuminance, lx.
    Illuminance,
    /// Luminance, cd/m².
    Luminance,
}

impl Quantity {
    fn title(self) -> &'static str {
        match self {
            Self::Illuminance => "illuminance, lx",
            Self::Luminance => "luminance, cd/m²",
        }
    }
}

/// Writes a picture whose pixels are illuminance (lx, the same in every channel) or radiance (W·sr⁻¹·m⁻²) as
/// PNG; lamps and sky are left grey. `unit` is what a pixel's value is multiplied by: 1 for illuminance, the
/// efficacy (lm·W⁻¹) for luminance.
///
/// # Errors
/// Those of `writer`.
pub fn write_false_colours(
    writer: &mut dyn Write,
    picture: &Picture,
    quantity: Quantity,
    unit: f64,
) -> io::Result<()> {
    let scale = enlargement(picture.width);
    let (width, height) = (picture.width * scale, picture.height * scale);
    let mut canvas = Canvas::new(width + LEGEND + 2 * MARGIN, height + TITLE + 2 * MARGIN);
    let area = Area { left: MARGIN, top: MARGIN + TITLE, width, height };
    let top = highest(picture, unit);
    let step = top / STEPS as f64;
    let pixels = Pixels { picture, unit, step };
    draw_pixels(&mut canvas, area, scale, |x, y| match pixels.at(x, y) {
        None => BLANK,
        Some(_) if pixels.is_on_line(x, y) => INK,
        Some(lux) => sequential(lux / top),
    });
    draw_title(&mut canvas, area, quantity.title());
    // The legend runs upwards, with a line and a number at each step.
    let bar = Area { left: area.right() + MARGIN, top: area.top, width: BAR, height };
    canvas.paint(bar, |_, y| sequential(1.0 - (y as f64 + 0.5) / height as f64));
    canvas.frame(bar, GREY);
    let labels = if height >= STEPS * TextSize::Small.height() { 1 } else { STEPS };
    for k in (0..=STEPS).step_by(labels) {
        let y = bar.top + height - height * k / STEPS;
        canvas.fill(Area { left: bar.left, top: y.min(bar.bottom() - 1), width: BAR, height: 1 }, INK);
        let label = format!("{}", (step * k as f64 * 1e6).round() / 1e6);
        let at = (bar.right() + 6, y.saturating_sub(TextSize::Small.height() / 2));
        let label = Line { text: &label, at, size: TextSize::Small, colour: INK };
        label.draw_within(&mut canvas, LEGEND - MARGIN - BAR - 6);
    }
    canvas.write_png(writer)
}

/// A round value that few pixels beside lamps and sky exceed.
fn highest(picture: &Picture, unit: f64) -> f64 {
    let seen = picture.pixels.iter().zip(&picture.lamps).filter(|(_, lamp)| lamp.share == 0.0);
    let values = seen.map(|(pixel, _)| value(pixel, unit));
    let mut values: Vec<f64> = values.filter(|value| *value > 0.0).collect();
    if values.is_empty() {
        return 1.0;
    }
    let place = ((1.0 - ABOVE) * (values.len() - 1) as f64).round() as usize;
    round_up(*values.select_nth_unstable_by(place, f64::total_cmp).1)
}

/// What a pixel stands for.
fn value(pixel: &[f32; 3], unit: f64) -> f64 {
    match pixel.map(f64::from) {
        [r, g, b] if r == g && g == b => unit * r,
        colour => unit * luminance(colour),
    }
}

struct Pixels<'a> {
    picture: &'a Picture,
    unit: f64,
    /// What lies between two lines.
    step: f64,
}

impl Pixels<'_> {
    /// The value; none for lamps and sky and beyond the picture.
    fn at(&self, x: usize, y: usize) -> Option<f64> {
        let Picture { width, height, pixels, lamps } = self.picture;
        let place = y * width + x;
        let inside = x < *width && y < *height && lamps[place].share < 0.5;
        inside.then(|| value(&pixels[place], self.unit))
    }

    /// Whether a round value lies between this pixel and the next to the right or below.
    fn is_on_line(&self, x: usize, y: usize) -> bool {
        let band = |lux: f64| (lux / self.step).floor().min(STEPS as f64);
        let here = self.at(x, y).map(band);
        [(x + 1, y), (x, y + 1)]
            .into_iter()
            .filter_map(|(x, y)| self.at(x, y))
            .any(|lux| here.is_some_and(|here| band(lux) != here))
    }
}

/// From dark violet through green to light yellow; what lies beyond has the colour of the end. Lightness
/// rises evenly.
fn sequential(amount: f64) -> Colour {
    let amount = amount.clamp(0.0, 1.0);
    let (lightness, hue) = (0.28 + 0.67 * amount, TAU * (0.82 - 0.52 * amount));
    let chroma = 0.06 + 0.08 * amount;
    oklab_to_linear([lightness, chroma * hue.cos(), chroma * hue.sin()]).map(|x| to_byte(x.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Picture {
        Picture::new(100, 20, (0..2000).map(|k| [(k % 100) as f32; 3]).collect())
    }

    #[test]
    fn colours_grow_lighter_with_the_amount() {
        let light = |amount: f64| sequential(amount).map(f64::from).iter().sum::<f64>();
        assert!((1..=50).all(|k| light(f64::from(k) / 50.0) > light(f64::from(k - 1) / 50.0)));
        assert_eq!(sequential(7.0), sequential(1.0));
    }

    #[test]
    fn lines_are_where_round_values_are_passed() {
        let picture = ramp();
        let pixels = Pixels { picture: &picture, unit: 1.0, step: highest(&picture, 1.0) / STEPS as f64 };
        assert_eq!([highest(&picture, 1.0), highest(&picture, 7.0)], [100.0, 1000.0]);
        let lines: Vec<usize> = (0..100).filter(|&x| pixels.is_on_line(x, 3)).collect();
        assert_eq!(lines, [9, 19, 29, 39, 49, 59, 69, 79, 89]);
    }

    #[test]
    fn dark_and_lampless_pictures_can_be_drawn_too() {
        let mut bytes = Vec::new();
        let dark = Picture::new(3, 2, vec![[0.0; 3]; 6]);
        write_false_colours(&mut bytes, &dark, Quantity::Luminance, 683.0).unwrap();
        let drawn = image::load_from_memory(&bytes).unwrap().into_rgb8();
        assert!(drawn.width() > 240 && drawn.pixels().any(|p| p.0 == sequential(0.0)));
    }
}
