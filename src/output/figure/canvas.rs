//! Canvas: an sRGB image to put pictures, boxes and words on.

use std::io::{self, Write};

use crate::render::write_rgb_png;

/// An sRGB colour.
pub(super) type Colour = [u8; 3];

pub(super) const INK: Colour = [34; 3];
pub(super) const GREY: Colour = [110; 3];

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    pub left: usize,
    pub top: usize,
    pub width: usize,
    pub height: usize,
}

impl Area {
    pub fn right(&self) -> usize {
        self.left + self.width
    }

    pub fn bottom(&self) -> usize {
        self.top + self.height
    }
}

/// An image under construction; what is drawn beyond its edges is lost.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    bytes: Vec<u8>,
}

impl Canvas {
    /// A white one.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, bytes: vec![255; 3 * width * height] }
    }

    /// Lays `colour` over a pixel, covering this share of it (0 to 1).
    pub fn blend(&mut self, x: usize, y: usize, colour: Colour, share: f64) {
        if x < self.width && y < self.height {
            let pixel = &mut self.bytes[3 * (y * self.width + x)..][..3];
            for (byte, over) in pixel.iter_mut().zip(colour) {
                *byte = (f64::from(*byte) * (1.0 - share) + f64::from(over) * share).round() as u8;
            }
        }
    }

    /// Fills an area with a colour for each of its pixels, which may depend on the place within it.
    pub fn paint(&mut self, area: Area, colour: impl Fn(usize, usize) -> Colour) {
        for y in 0..area.height {
            for x in 0..area.width {
                self.blend(area.left + x, area.top + y, colour(x, y), 1.0);
            }
        }
    }

    /// Fills an area.
    pub fn fill(&mut self, area: Area, colour: Colour) {
        self.paint(area, |_, _| colour);
    }

    /// Draws a line of one pixel around an area.
    pub fn frame(&mut self, Area { left, top, width, height }: Area, colour: Colour) {
        let (outer_left, outer_top) = (left.saturating_sub(1), top.saturating_sub(1));
        for top in [outer_top, top + height] {
            self.fill(Area { left: outer_left, top, width: width + 2, height: 1 }, colour);
        }
        for left in [outer_left, left + width] {
            self.fill(Area { left, top: outer_top, width: 1, height: height + 2 }, colour);
        }
    }

    /// All pixels, rows from the top.
    #[cfg(test)]
    pub fn pixels(&self) -> impl Iterator<Item = Colour> {
        self.bytes.chunks(3).map(|p| [p[0], p[1], p[2]])
    }

    /// Writes the image as PNG.
    ///
    /// # Errors
    /// Those of `writer`.
    pub fn write_png(&self, writer: &mut dyn Write) -> io::Result<()> {
        write_rgb_png(writer, &self.bytes, self.width, self.height)
    }
}
