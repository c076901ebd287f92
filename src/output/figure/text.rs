//! Text on a canvas: one line, in a bitmap font of three sizes that comes with the program.
//!
//! Raised digits (¹²³⁴…) are set as small ones; an ellipsis as three dots. What the font lacks becomes a
//! question mark.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width};

use super::canvas::{Canvas, Colour};

/// Height of a line, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TextSize {
    Small,
    Medium,
    Large,
}

impl TextSize {
    /// Height of the line.
    pub fn height(self) -> usize {
        self.raster().val()
    }

    /// Where the small line of raised digits starts.
    fn lift(self) -> isize {
        match self {
            Self::Small => -3,
            Self::Medium => -1,
            Self::Large => 0,
        }
    }

    fn raster(self) -> RasterHeight {
        match self {
            Self::Small => RasterHeight::Size16,
            Self::Medium => RasterHeight::Size20,
            Self::Large => RasterHeight::Size24,
        }
    }
}

/// A sign of the font and where it goes.
struct Sign {
    raster: RasterizedChar,
    /// From the start of the line, pixels.
    left: usize,
    /// Down from its upper edge.
    top: isize,
}

/// Width of a line, pixels.
pub(super) fn width(text: &str, size: TextSize) -> usize {
    set(text, size).last().map_or(0, |sign| sign.left + sign.raster.width())
}

/// A line of text and where it goes.
pub(super) struct Line<'a> {
    pub text: &'a str,
    /// Its upper left corner, pixels.
    pub at: (usize, usize),
    pub size: TextSize,
    pub colour: Colour,
}

impl Line<'_> {
    pub fn draw(&self, canvas: &mut Canvas) {
        let (left, top) = self.at;
        for sign in set(self.text, self.size) {
            for (y, row) in sign.raster.rows().enumerate() {
                for (x, &share) in row.iter().enumerate() {
                    if let Some(y) = (top + y).checked_add_signed(sign.top) {
                        canvas.blend(left + sign.left + x, y, self.colour, f64::from(share) / 255.0);
                    }
                }
            }
        }
    }

    /// Draws it in the largest size up to its own in which it is no wider than `room`, cut short if need be.
    pub fn draw_within(&self, canvas: &mut Canvas, room: usize) {
        let (left, top) = self.at;
        let sizes = [TextSize::Large, TextSize::Medium, TextSize::Small];
        let smaller = sizes.into_iter().skip_while(|&size| size != self.size);
        let fitting = smaller.into_iter().find(|&size| width(self.text, size) <= room);
        let at = |chosen: TextSize| (left, top + self.size.height() - chosen.height());
        if let Some(size) = fitting {
            return Line { at: at(size), size, ..*self }.draw(canvas);
        }
        let (mut shorter, size) = (self.text.to_owned(), TextSize::Small);
        while !shorter.is_empty() && width(&shorter, size) > room {
            shorter.pop();
        }
        Line { text: shorter.trim_end(), at: at(size), size, ..*self }.draw(canvas);
    }
}

/// Sets a line, sign by sign.
fn set(text: &str, size: TextSize) -> impl Iterator<Item = Sign> {
    let dots = |c: char| if c == '…' { "...".chars().collect() } else { vec![c] };
    let mut end = 0;
    text.chars().flat_map(dots).map(move |c| {
        let (c, raster_size, top) = match raised(c) {
            Some(digit) => (digit, RasterHeight::Size16, size.lift()),
            None => (if c == '−' { '-' } else { c }, size.raster(), 0),
        };
        let left = end;
        end += get_raster_width(FontWeight::Regular, raster_size);
        let raster =
            get_raster(c, FontWeight::Regular, raster_size).unwrap_or_else(|| question_mark(raster_size));
        Sign { raster, left, top }
    })
}

fn question_mark(size: RasterHeight) -> RasterizedChar {
    get_raster('?', FontWeight::Regular, size).expect("the font has a question mark")
}

/// The digit that is raised here.
fn raised(c: char) -> Option<char> {
    let digit = match c {
        '¹' => 1,
        '²' => 2,
        '³' => 3,
        '⁰' | '⁴'..='⁹' => c as u32 - '⁰' as u32,
        _ => return None,
    };
    char::from_digit(digit, 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How much ink there is in each of some columns and rows.
    fn ink(text: &str, size: TextSize) -> Vec<bool> {
        let mut canvas = Canvas::new(400, 40);
        Line { text, at: (0, 8), size, colour: [0; 3] }.draw(&mut canvas);
        canvas.pixels().map(|pixel| pixel[0] < 128).collect()
    }

    #[test]
    fn all_signs_of_labels_are_in_the_font() {
        for size in [TextSize::Small, TextSize::Medium, TextSize::Large] {
            let unknown = ink("\u{1f600}", size);
            assert_eq!(unknown, ink("?", size));
            for sign in "EK+…×%−±²³⁴⁰⁹/().".chars() {
                assert_ne!(ink(&sign.to_string(), size), unknown, "{sign}");
            }
        }
    }

    #[test]
    fn a_raised_digit_is_higher_than_the_same_digit_beside_it() {
        let top = |text: &str| ink(text, TextSize::Large).iter().position(|&dark| dark).unwrap() / 400;
        let bottom = |text: &str| ink(text, TextSize::Large).iter().rposition(|&dark| dark).unwrap() / 400;
        assert!(bottom("⁴") + 4 < bottom("4") && top("⁴") <= top("4") + 1);
    }

    #[test]
    fn a_line_too_long_is_set_smaller_and_then_cut() {
        let room = |text: &str, room: usize| {
            let mut canvas = Canvas::new(400, 40);
            let line = Line { text, at: (0, 0), size: TextSize::Large, colour: [0; 3] };
            line.draw_within(&mut canvas, room);
            let dark = canvas.pixels().zip(0..).filter(|(pixel, _)| pixel[0] < 255);
            dark.map(|(_, place)| place % 400 + 1).max().unwrap_or(0)
        };
        let natural = width("E + KE + K²E", TextSize::Large);
        for available in [natural + 5, natural - 5, natural / 2, 20, 3] {
            assert!(room("E + KE + K²E", available) <= available, "{available}");
        }
        assert!(room("E + KE + K²E", natural - 5) > natural / 2);
    }
}
