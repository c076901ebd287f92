//! Tone: from radiance to what a screen shows, display = encode(compress(factor · L)).
//!
//! `compress` leaves colours below [`KNEE`] as they are and bends brighter ones towards white, keeping their
//! hue, by the curve of the Khronos PBR neutral tone mapper (2024); `encode` is the sRGB transfer function
//! (IEC 61966-2-1).

use crate::scene;

/// Where compression begins, as a share of display white.
const KNEE: f64 = 0.8;

/// How fast what is brighter than white loses its colour.
const BLEACH: f64 = 0.15;

/// How bright a picture is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Radiance (W·sr⁻¹·m⁻²) times this is the share of display white; positive.
    pub factor: f64,
}

impl Default for Exposure {
    /// Radiance 1 is white.
    fn default() -> Self {
        Self { factor: 1.0 }
    }
}

impl Exposure {
    /// The exposure that suits a picture whose pixels, lamps left out, have these radiances.
    ///
    /// The brightest fiftieth lands just below white; where half of the picture would be very dark it is
    /// raised, and an even picture becomes light grey. Black and non-finite pixels do not count; without any
    /// other the factor is 1.
    pub fn automatic(pixels: impl IntoIterator<Item = [f64; 3]>) -> Self {
        let mut luminances: Vec<f64> = pixels.into_iter().map(luminance).collect();
        luminances.retain(|&y| y.is_finite() && y > f64::MIN_POSITIVE);
        if luminances.is_empty() {
            return Self::default();
        }
        let mut at = |share: f64| {
            let k = (share * (luminances.len() - 1) as f64).round() as usize;
            *luminances.select_nth_unstable_by(k, f64::total_cmp).1
        };
        let (middle, bright) = (at(0.5), at(0.98));
        let contrast = bright / middle;
        // Show the bright part at 0.55 in an even picture, at 0.85 where the middle is half as bright or
        // less.
        let shown = 0.55 + 0.3 * (contrast - 1.0).min(1.0);
        // Raise the middle of a dark picture to 0.12, the bright part to no more than 2.
        let shown = shown.max((0.12 * contrast).min(2.0));
        let factor = shown / bright;
        if factor.is_finite() { Self { factor } } else { Self::default() }
    }

    /// Radiance to linear display values, each in [0, 1]; what is not a number or negative is black.
    pub fn display(&self, radiance: [f64; 3]) -> [f64; 3] {
        let colour =
            radiance.map(|x| (x * self.factor).clamp(0.0, 1e6)).map(|x| if x.is_nan() { 0.0 } else { x });
        let peak = colour[0].max(colour[1]).max(colour[2]);
        if peak <= KNEE {
            return colour;
        }
        // Bend the largest channel so that it tends to 1 with slope 1 at the knee.
        let room = 1.0 - KNEE;
        let bent = 1.0 - room * room / (peak + room - KNEE);
        let white = 1.0 - 1.0 / (BLEACH * (peak - bent) + 1.0);
        colour.map(|x| x * bent / peak * (1.0 - white) + bent * white)
    }

    /// Radiance to sRGB, 8 bits a channel.
    pub fn encode(&self, radiance: [f64; 3]) -> [u8; 3] {
        self.display(radiance).map(to_byte)
    }
}

/// The sRGB transfer function: linear display value to encoded value, both in [0, 1].
pub fn srgb(x: f64) -> f64 {
    if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// A linear display value in [0, 1] to an sRGB byte.
pub(crate) fn to_byte(x: f64) -> u8 {
    (255.0 * srgb(x) + 0.5) as u8
}

/// Radiance of any number of channels as red, green and blue: three stay, else all three are the mean.
///
/// What is not a number becomes 0, what is infinite the largest finite f32.
pub fn to_rgb(channels: &[f64]) -> [f64; 3] {
    const LARGEST: f64 = f32::MAX as f64;
    let rgb = match *channels {
        [] => [0.0; 3],
        [r, g, b] => [r, g, b],
        _ => [channels.iter().sum::<f64>() / channels.len() as f64; 3],
    };
    rgb.map(|x| if x.is_nan() { 0.0 } else { x.clamp(-LARGEST, LARGEST) })
}

/// Relative luminance of linear sRGB.
pub(crate) fn luminance([r, g, b]: [f64; 3]) -> f64 {
    scene::luminance(&[r, g, b])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_agrees_with_the_standard() {
        for (linear, byte) in
            [(0.0, 0), (0.0031308, 10), (0.18, 118), (0.2158605, 128), (0.5, 188), (0.73, 222), (1.0, 255)]
        {
            assert_eq!(to_byte(linear), byte, "{linear}");
        }
        assert!((srgb(0.0031308) - 0.04045).abs() < 1e-6);
        assert!((srgb(1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn colours_below_the_knee_are_shown_as_they_are() {
        assert_eq!(Exposure { factor: 2.0 }.display([0.1, 0.2, 0.4]), [0.2, 0.4, 0.8]);
    }

    #[test]
    fn brighter_colours_stay_brighter_and_keep_their_order() {
        let mut last = 0.0;
        for k in 1..2000 {
            let [r, g, b] = Exposure::default().display([0.02 * k as f64, 0.01 * k as f64, 0.001 * k as f64]);
            assert!(r >= last && r <= 1.0 && r >= g && g >= b);
            last = r;
        }
    }

    #[test]
    fn nothing_makes_an_invalid_pixel() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, f64::MAX, 0.0] {
            for factor in [1.0, 1e300, 0.0] {
                let shown = Exposure { factor }.display(to_rgb(&[x, 1.0, x]));
                assert!(shown.iter().all(|v| (0.0..=1.0).contains(v)), "{x}: {shown:?}");
            }
        }
        assert_eq!(Exposure::automatic([[f64::NAN; 3], [f64::INFINITY; 3]]), Exposure::default());
    }

    #[test]
    fn a_black_picture_is_left_alone() {
        assert_eq!(Exposure::automatic([[0.0; 3]; 9]), Exposure::default());
        assert_eq!(Exposure::automatic([]), Exposure::default());
    }

    #[test]
    fn an_even_picture_becomes_light_grey_however_bright_it_is() {
        for level in [1e-9, 1.0, 1e9] {
            let bytes = Exposure::automatic([[level; 3]; 100]).encode([level; 3]);
            assert!(bytes.iter().all(|b| (180..230).contains(b)), "{bytes:?}");
        }
    }

    #[test]
    fn channels_other_than_three_become_grey() {
        assert_eq!(to_rgb(&[0.5]), [0.5; 3]);
        assert_eq!(to_rgb(&[1.0, 2.0, 3.0, 6.0]), [3.0; 3]);
        assert_eq!(to_rgb(&[1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    }
}
