//! Comparison: an answer, its reference, and the signed difference of the two, side by side.
//!
//! The difference is that of luminance, in per cent of the reference's mean luminance beside lamps. Since the
//! reference is noisy, the difference is averaged over small squares, and the colour scale ends where all but
//! a fiftieth of the picture lies within it.

use std::io::{self, Write};

use rayon::prelude::*;

use super::canvas::{Area, Canvas, GREY, INK};
use super::diverging::diverging;
use super::panel::{MARGIN, TITLE, draw_picture, draw_pixels, draw_title, enlargement};
use super::text::{Line, TextSize};
use super::{round_up, text};
use crate::render::{Exposure, LampPart, Picture, luminance};

/// Height of the colour scale, of the ticks below it, and of all of that with labels.
const SCALE: usize = 14;
const TICK: usize = 5;
const LEGEND: usize = 12 + SCALE + TICK + 44;

/// The share of the picture that lies within the colour scale.
const WITHIN: f64 = 0.98;

/// What a comparison looks like.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonOptions<'a> {
    /// Titles of the answer, the reference and the difference.
    pub titles: [&'a str; 3],
    /// A line below the answer and one below the reference; may be empty.
    pub notes: [&'a str; 2],
    /// How bright answer and reference are shown; by default as suits the reference.
    pub exposure: Option<Exposure>,
    /// Where the colour scale ends, as a share of the reference's mean; by default at a round number that 98
    /// % of the differences stay below.
    pub range: Option<f64>,
    /// Differences are averaged over squares of 2r + 1 pixels, 0 to 16; this is r. Noise falls by more than
    /// that factor, details of so many pixels are lost.
    pub radius: usize,
}

impl Default for ComparisonOptions<'_> {
    /// Squares of 3 pixels; exposure and range as they suit.
    fn default() -> Self {
        Self {
            titles: ["Matrix", "Path-traced reference", "Difference"],
            notes: [""; 2],
            exposure: None,
            range: None,
            radius: 1,
        }
    }
}

/// Writes `matrix`, `reference` and matrix − reference side by side as PNG.
///
/// # Errors
/// Those of `writer`.
///
/// # Panics
/// If the pictures are not of one size.
pub fn write_comparison(
    writer: &mut dyn Write,
    matrix: &Picture,
    reference: &Picture,
    options: &ComparisonOptions,
) -> io::Result<()> {
    let (width, height) = (reference.width, reference.height);
    assert_eq!((matrix.width, matrix.height), (width, height), "pictures of one size");
    let scale = enlargement(width);
    let area = |k: usize| Area {
        left: MARGIN + k * (scale * width + MARGIN),
        top: MARGIN + TITLE,
        width: scale * width,
        height: scale * height,
    };
    let size = [area(2).right() + MARGIN, area(2).bottom() + LEGEND + MARGIN / 2];
    let mut canvas = Canvas::new(size[0], size[1]);
    let exposure = options.exposure.unwrap_or_else(|| reference.exposure());
    for (k, picture) in [matrix, reference].into_iter().enumerate() {
        draw_picture(&mut canvas, area(k), picture, exposure, scale);
        let at = (area(k).left, area(k).bottom() + 12);
        let note = Line { text: options.notes[k], at, size: TextSize::Small, colour: GREY };
        note.draw_within(&mut canvas, area(k).width);
    }
    let difference = relative_difference(matrix, reference, options.radius.min(16));
    let range = options
        .range
        .filter(|r| r.is_finite() && *r > 0.0)
        .unwrap_or_else(|| robust_range(&difference, reference));
    draw_pixels(&mut canvas, area(2), scale, |x, y| diverging(difference[y * width + x] / range));
    draw_scale(&mut canvas, area(2), range);
    for (k, title) in options.titles.into_iter().enumerate() {
        draw_title(&mut canvas, area(k), title);
    }
    canvas.write_png(writer)
}

/// (matrix − reference) / mean of the reference beside lamps, in luminance, averaged over squares around each
/// pixel; 0 where there are lamps, whose edges would drown the rest.
fn relative_difference(matrix: &Picture, reference: &Picture, radius: usize) -> Vec<f64> {
    let luminances = |picture: &Picture| -> Vec<f64> {
        let value = |p: &[f32; 3]| Some(luminance(p.map(f64::from))).filter(|y| y.is_finite()).unwrap_or(0.0);
        picture.pixels.iter().map(value).collect()
    };
    let (ours, theirs) = (luminances(matrix), luminances(reference));
    let is_lamp: Vec<bool> =
        matrix.lamps.iter().zip(&reference.lamps).map(|(a, b)| a.share > 0.0 || b.share > 0.0).collect();
    let (mut sum, mut count) = (0.0, 0.0);
    theirs.iter().zip(&is_lamp).filter(|&(&y, &lamp)| !lamp && y > 0.0).for_each(|(y, _)| {
        sum += y;
        count += 1.0;
    });
    let mean = if sum > 0.0 { sum / count } else { 1.0 };
    let (width, height) = (matrix.width, matrix.height);
    let around = |place: usize, end: usize| place.saturating_sub(radius)..(place + radius + 1).min(end);
    let average = |k: usize| {
        if is_lamp[k] {
            return 0.0;
        }
        let (columns, rows) = (around(k % width, width), around(k / width, height));
        let (mut sum, mut count) = (0.0, 0.0);
        for k in rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).filter(|&k| !is_lamp[k]) {
            sum += (ours[k] - theirs[k]) / mean;
            count += 1.0;
        }
        sum / count
    };
    (0..ours.len()).into_par_iter().with_min_len(4096).map(average).collect()
}

/// The round number that most differences stay below, where there is light and no lamp.
fn robust_range(difference: &[f64], reference: &Picture) -> f64 {
    let counts = |(_, (pixel, lamp)): &(&f64, (&[f32; 3], &LampPart))| {
        lamp.share == 0.0 && pixel.iter().any(|&x| x > 0.0)
    };
    let pixels = difference.iter().zip(reference.pixels.iter().zip(&reference.lamps));
    let mut amounts: Vec<f64> = pixels.filter(counts).map(|(d, _)| d.abs()).collect();
    if amounts.is_empty() {
        amounts = difference.iter().map(|d| d.abs()).collect();
    }
    let place = (WITHIN * amounts.len().saturating_sub(1) as f64).round() as usize;
    let most =
        if amounts.is_empty() { 0.0 } else { *amounts.select_nth_unstable_by(place, f64::total_cmp).1 };
    // Rounding alone is no difference worth showing.
    round_up(most.max(1e-5))
}

/// Draws the colour scale below an area, from -range to range, labelled in per cent.
fn draw_scale(canvas: &mut Canvas, area: Area, range: f64) {
    let Area { left, width, .. } = area;
    let bar = Area { left, top: area.bottom() + 12, width, height: SCALE };
    let last = width.saturating_sub(1).max(1) as f64;
    canvas.paint(bar, |x, _| diverging(2.0 * x as f64 / last - 1.0));
    canvas.frame(bar, GREY);
    let labels = bar.bottom() + TICK + 2;
    for k in 0..=4 {
        let share = k as f64 / 4.0;
        let x = left + (share * last).round() as usize;
        canvas.fill(Area { left: x, top: bar.bottom(), width: 1, height: TICK }, GREY);
        let label = percent(range * (2.0 * share - 1.0));
        // The outermost labels stay within the bar.
        let wide = text::width(&label, TextSize::Small);
        let place = (share * (width.saturating_sub(wide)) as f64).round() as usize;
        let centred = (x + wide / 2 > left + width || x < left + wide / 2).then_some(left + place);
        let at = centred.unwrap_or_else(|| x - wide / 2);
        Line { text: &label, at: (at, labels), size: TextSize::Small, colour: INK }.draw(canvas);
    }
    let text = "of the reference's mean; red: the answer is brighter";
    let what = Line { text, at: (left, labels + 19), size: TextSize::Small, colour: GREY };
    what.draw_within(canvas, width);
}

/// A share as per cent, with a sign.
fn percent(share: f64) -> String {
    let value = 100.0 * share;
    if value == 0.0 {
        return "0".into();
    }
    let digits = (-value.abs().log10().floor()).clamp(0.0, 6.0) as usize + 1;
    let text = format!("{value:+.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text} %")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(matrix: &Picture, reference: &Picture, options: &ComparisonOptions) -> image::RgbImage {
        let mut bytes = Vec::new();
        write_comparison(&mut bytes, matrix, reference, options).unwrap();
        image::load_from_memory(&bytes).unwrap().into_rgb8()
    }

    /// The colour in the middle of panel k.
    fn middle(image: &image::RgbImage, k: u32) -> [u8; 3] {
        let panel = image.width() / 3;
        image.get_pixel(k * panel + panel / 2, MARGIN as u32 + TITLE as u32 + 40).0
    }

    fn even(level: f32) -> Picture {
        Picture::new(300, 100, vec![[level; 3]; 30_000])
    }

    #[test]
    fn answer_and_reference_are_exposed_alike_and_the_difference_is_signed() {
        let options = ComparisonOptions { range: Some(0.2), ..Default::default() };
        let [same, brighter, darker] =
            [1.0, 1.1, 0.9].map(|level| written(&even(level), &even(1.0), &options));
        assert_eq!((middle(&same, 0), middle(&same, 2)), (middle(&same, 1), [255; 3]));
        assert!(middle(&brighter, 0) > middle(&brighter, 1));
        assert_eq!(middle(&brighter, 2), diverging(0.1f32 as f64 / 0.2));
        assert_eq!(middle(&darker, 2), diverging(-0.5));
    }

    #[test]
    fn a_fiftieth_of_outliers_and_lamps_do_not_set_the_range() {
        let mut matrix = even(1.0);
        for (k, pixel) in matrix.pixels.iter_mut().enumerate() {
            *pixel = [if k % 101 == 0 { 50.0 } else { 1.0 + 0.03 * (k % 2) as f32 }; 3];
        }
        let mut reference = even(1.0);
        reference.lamps[7] = LampPart { radiance: [1e6; 3], share: 1.0 };
        reference.pixels[7] = [1e6; 3];
        let difference = relative_difference(&matrix, &reference, 0);
        assert!((robust_range(&difference, &reference) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn averages_take_noise_off_and_leave_what_is_even() {
        let mut matrix = even(1.1);
        matrix.pixels.iter_mut().enumerate().for_each(|(k, p)| *p = [p[0] + 0.2 * (k % 3) as f32 - 0.2; 3]);
        let difference = relative_difference(&matrix, &even(1.0), 1);
        assert!(difference.iter().skip(1).take(298).all(|d| (d - 0.1).abs() < 1e-6));
    }

    #[test]
    fn pictures_of_nothing_and_of_invalid_numbers_can_be_compared() {
        let nothing = Picture::new(1, 1, vec![[0.0; 3]]);
        let wild = Picture::new(1, 1, vec![[f32::NAN, f32::INFINITY, -1.0]]);
        for pair in [[&nothing, &nothing], [&wild, &nothing], [&nothing, &wild], [&wild, &wild]] {
            let image = written(pair[0], pair[1], &Default::default());
            assert!(image.width() > 3 * 240 && image.height() > 240);
        }
    }

    #[test]
    fn labels_are_signed_per_cent() {
        let labels = [-0.05, -0.025, 0.0, 0.0005, 2.0].map(percent);
        assert_eq!(labels, ["-5 %", "-2.5 %", "0", "+0.05 %", "+200 %"]);
    }
}
