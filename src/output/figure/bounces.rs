//! Bounces: how light builds up. A column per order k: the sum E + KE + … + KᵏE above, the bounce KᵏE alone
//! below.

use std::io::{self, Write};

use nalgebra::DMatrix;

use super::canvas::{Area, Canvas, GREY};
use super::panel::{MARGIN, TITLE, draw_picture, draw_title, enlargement};
use super::text::{self, Line, TextSize};
use crate::patches::Patches;
use crate::render::{Exposure, Picture, RenderError, RenderOptions, Surfaces, luminance, picture};
use crate::scene::Camera;
use crate::trace::Tracer;

/// Height of the line above a row of pictures.
const HEADING: usize = 26;

/// One order of the series, in pictures of one size.
#[derive(Clone, Debug)]
pub struct BouncePictures {
    /// The order k.
    pub order: usize,
    /// Of the sum up to it, L_k.
    pub sum: Picture,
    /// Of what it adds, KᵏE.
    pub bounce: Picture,
}

impl BouncePictures {
    /// Renders the terms E, KE, … of the series (N × c each, N = n or 3n) and their sums.
    ///
    /// # Errors
    /// As [`picture`].
    ///
    /// # Panics
    /// If a term has neither n nor 3n rows, or not as many as the others.
    pub fn render(
        tracer: &Tracer,
        patches: &Patches,
        terms: &[DMatrix<f64>],
        camera: &Camera,
        options: &RenderOptions,
    ) -> Result<Vec<Self>, RenderError> {
        // What a bounce adds has nothing emitted in it.
        let options = &RenderOptions { surfaces: Surfaces::Averaged, ..*options };
        let mut sum = DMatrix::zeros(terms.first().map_or(0, DMatrix::nrows), patches.scene().channels());
        let orders = terms.iter().enumerate().map(|(order, term)| {
            sum += term;
            let [sum, bounce] = [&sum, term].map(|field| picture(tracer, patches, field, camera, options));
            Ok(Self { order, sum: sum?, bounce: bounce? })
        });
        orders.collect()
    }
}

/// Writes all orders as PNG: sums at one exposure, that of the last; bounces that much brighter as their
/// labels say.
///
/// # Errors
/// Those of `writer`.
///
/// # Panics
/// If there are no orders, or the pictures are not of one size.
pub fn write_bounces(writer: &mut dyn Write, orders: &[BouncePictures]) -> io::Result<()> {
    let all = &orders[orders.len() - 1].sum;
    let (width, height) = (all.width, all.height);
    let pictures = orders.iter().flat_map(|b| [&b.sum, &b.bounce]);
    assert!(pictures.into_iter().all(|p| (p.width, p.height) == (width, height)), "pictures of one size");
    let scale = enlargement(width);
    let row = HEADING + TITLE + scale * height + MARGIN;
    let area = |column: usize, below: usize| Area {
        left: MARGIN + column * (scale * width + MARGIN),
        top: MARGIN / 2 + below * row + HEADING + TITLE,
        width: scale * width,
        height: scale * height,
    };
    let end = area(orders.len() - 1, 1);
    let mut canvas = Canvas::new(end.right() + MARGIN, end.bottom() + MARGIN);
    let headings = ["Sums of the series, all at one exposure", "Each bounce alone, brighter as stated"];
    for (below, heading) in headings.into_iter().enumerate() {
        let at = (MARGIN, area(0, below).top - TITLE - HEADING + 6);
        let heading = Line { text: heading, at, size: TextSize::Medium, colour: GREY };
        heading.draw_within(&mut canvas, end.right() - MARGIN);
    }
    let exposure = all.exposure();
    for (column, BouncePictures { order, sum, bounce }) in orders.iter().enumerate() {
        draw_picture(&mut canvas, area(column, 0), sum, exposure, scale);
        draw_title(
            &mut canvas,
            area(column, 0),
            &sum_label(*order, |label| text::width(label, TextSize::Large) <= scale * width),
        );
        let times = brightening(all, bounce);
        let brighter = Exposure { factor: exposure.factor * times };
        draw_picture(&mut canvas, area(column, 1), bounce, brighter, scale);
        let stated = if times > 1.0 { format!("  × {times}") } else { String::new() };
        draw_title(&mut canvas, area(column, 1), &(term(*order) + &stated));
    }
    canvas.write_png(writer)
}

/// How many times as much light there is in the sum as in the bounce, beside lamps; a whole number of at most
/// two digits and zeros.
fn brightening(sum: &Picture, bounce: &Picture) -> f64 {
    let light = |picture: &Picture| -> f64 {
        let beside_lamps = picture.pixels.iter().zip(&picture.lamps).filter(|(_, lamp)| lamp.share == 0.0);
        beside_lamps.map(|(pixel, _)| luminance(pixel.map(f64::from))).sum()
    };
    let times = light(sum) / light(bounce);
    if !(1.0..1e9).contains(&times) {
        return 1.0;
    }
    let power = 10f64.powi((times.log10().floor() as i32 - 1).max(0));
    (times / power).round() * power
}

/// KᵏE.
fn term(order: usize) -> String {
    let raised = |digit: char| match digit {
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    match order {
        0 => "E".into(),
        1 => "KE".into(),
        _ => format!("K{}E", order.to_string().chars().map(raised).collect::<String>()),
    }
}

/// E + KE + … + KᵏE, with as many terms as there is room for.
fn sum_label(order: usize, fits: impl Fn(&str) -> bool) -> String {
    let whole: Vec<String> = (0..=order).map(term).collect();
    let label = whole.join(" + ");
    if order < 3 || fits(&label) {
        return label;
    }
    let shorter = format!("E + KE + … + {}", term(order));
    if fits(&shorter) { shorter } else { format!("E + … + {}", term(order)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_those_of_a_textbook() {
        assert_eq!([0, 1, 2, 4, 12].map(term), ["E", "KE", "K²E", "K⁴E", "K¹²E"]);
        assert_eq!(sum_label(2, |_| true), "E + KE + K²E");
        assert_eq!(sum_label(4, |label| label.chars().count() < 20), "E + KE + … + K⁴E");
        assert_eq!(sum_label(4, |_| false), "E + … + K⁴E");
    }

    #[test]
    fn a_bounce_of_a_tenth_is_shown_ten_times_as_bright_and_a_black_one_as_it_is() {
        let even = |level: f32| Picture::new(4, 4, vec![[level; 3]; 16]);
        for (level, times) in [
            (0.1, 10.0),
            (0.3, 3.0),
            (0.051, 20.0),
            (0.0003, 3300.0),
            (1.0, 1.0),
            (7.0, 1.0),
            (0.0, 1.0),
            (f32::NAN, 1.0),
        ] {
            assert_eq!(brightening(&even(1.0), &even(level)), times, "{level}");
        }
    }

    #[test]
    fn a_figure_has_a_column_per_order() {
        let picture = |order: usize| {
            let picture = Picture::new(250, 90, vec![[order as f32; 3]; 22_500]);
            BouncePictures { order, sum: picture.clone(), bounce: picture }
        };
        let size = |orders: usize| {
            let mut bytes = Vec::new();
            write_bounces(&mut bytes, &(0..orders).map(picture).collect::<Vec<_>>()).unwrap();
            image::load_from_memory(&bytes).unwrap().into_rgb8().dimensions()
        };
        let ((one, height), (five, same)) = (size(1), size(5));
        assert_eq!((five - one, height), (4 * (250 + MARGIN as u32), same));
        assert!(height > 180);
    }
}
