//! Panel: a picture in its place on a canvas, with a title above it.

use super::canvas::{Area, Canvas, Colour, GREY, INK};
use super::text::{Line, TextSize};
use crate::render::{Exposure, Picture};

/// Space around everything, pixels.
pub(super) const MARGIN: usize = 18;

/// Height of a title with the space below it.
pub(super) const TITLE: usize = 32;

/// Pictures narrower than this are enlarged.
const NARROWEST: usize = 240;

/// By which whole number a picture of this width is enlarged.
pub(super) fn enlargement(width: usize) -> usize {
    NARROWEST.div_ceil(width.max(1))
}

/// Draws an exposed picture, each pixel as a square of this many.
pub(super) fn draw_picture(
    canvas: &mut Canvas,
    area: Area,
    picture: &Picture,
    exposure: Exposure,
    scale: usize,
) {
    let bytes = picture.to_srgb(exposure);
    draw_pixels(canvas, area, scale, |x, y| {
        let at = 3 * (y * picture.width + x);
        [bytes[at], bytes[at + 1], bytes[at + 2]]
    });
}

/// Draws pixels of these colours in a frame, each as a square of `scale`.
pub(super) fn draw_pixels(
    canvas: &mut Canvas,
    area: Area,
    scale: usize,
    colour: impl Fn(usize, usize) -> Colour,
) {
    canvas.paint(area, |x, y| colour(x / scale, y / scale));
    canvas.frame(area, GREY);
}

/// Writes a title above an area, no wider than it.
pub(super) fn draw_title(canvas: &mut Canvas, area: Area, title: &str) {
    let at = (area.left, area.top - TITLE + 4);
    Line { text: title, at, size: TextSize::Large, colour: INK }.draw_within(canvas, area.width);
}
