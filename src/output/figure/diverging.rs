//! Diverging colours: white for nothing, red for more, blue for less; equal amounts look equally strong.
//!
//! Lightness falls in proportion to the amount, in the colour space OKLab (Ottosson 2020), the same on both
//! sides. Red and blue are told apart with any kind of colour blindness.

use super::canvas::Colour;
use crate::render::to_byte;

/// OKLab lightness and chroma at the ends, hues in radians: an orange red and a blue.
const DARKEST: f64 = 0.42;
const CHROMA: f64 = 0.15;
const MORE: f64 = 0.70;
const LESS: f64 = 4.45;

/// The colour for an amount from -1 to 1; what lies beyond has the colour of the end, what is not a number is
/// white.
pub(super) fn diverging(amount: f64) -> Colour {
    let strength = if amount.is_nan() { 0.0 } else { amount.abs().min(1.0) };
    let lightness = 1.0 - (1.0 - DARKEST) * strength;
    // Chroma rises fast, so that small amounts have a hue, and stays within what a screen can show.
    let chroma = CHROMA * (1.0 - (1.0 - strength).powi(2));
    let hue = if amount < 0.0 { LESS } else { MORE };
    let rgb = oklab_to_linear([lightness, chroma * hue.cos(), chroma * hue.sin()]);
    rgb.map(|x| to_byte(x.clamp(0.0, 1.0)))
}

/// OKLab to linear sRGB.
pub(super) fn oklab_to_linear([l, a, b]: [f64; 3]) -> [f64; 3] {
    let l_ = (l + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m_ = (l - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s_ = (l - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l_ - 3.307_711_591_3 * m_ + 0.230_969_929_2 * s_,
        -1.268_438_004_6 * l_ + 2.609_757_401_1 * m_ - 0.341_319_396_5 * s_,
        -0.004_196_086_3 * l_ - 0.703_418_614_7 * m_ + 1.707_614_701_0 * s_,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_white_and_both_ends_are_as_dark() {
        assert_eq!(diverging(0.0), [255; 3]);
        assert_eq!(diverging(f64::NAN), [255; 3]);
        assert_eq!((diverging(7.0), diverging(-f64::INFINITY)), (diverging(1.0), diverging(-1.0)));
        let [[r, _, b], [less_r, _, less_b]] = [diverging(1.0), diverging(-1.0)];
        assert!(r > b + 60 && less_b > less_r + 60);
    }

    #[test]
    fn more_is_always_darker() {
        let light = |amount: f64| {
            let [r, g, b] = diverging(amount).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for sign in [-1.0, 1.0] {
            for k in 1..=50 {
                let (inner, outer) = (light(sign * (k - 1) as f64 / 50.0), light(sign * k as f64 / 50.0));
                assert!(outer < inner, "{sign} {k}: {inner} {outer}");
            }
        }
    }

    #[test]
    fn the_colour_space_agrees_with_its_author() {
        // White, and the red of sRGB: L 0.62796, a 0.22486, b 0.12585.
        for (lab, rgb) in [([1.0, 0.0, 0.0], [1.0; 3]), ([0.62796, 0.22486, 0.12585], [1.0, 0.0, 0.0])] {
            let found = oklab_to_linear(lab);
            assert!(found.iter().zip(rgb).all(|(x, y)| (x - y).abs() < 1e-4), "{found:?}");
        }
    }
}
