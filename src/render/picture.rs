//! Picture: linear radiance per pixel, and the files made of it.

use std::io::{self, Cursor, Write};

use image::codecs::{openexr::OpenExrEncoder, png};
use image::{ExtendedColorType, ImageEncoder, ImageError};
use rayon::prelude::*;

use super::tone::{Exposure, to_byte};

/// What lamps contribute to a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LampPart {
    /// The part of the pixel's radiance that comes from lamps, W·sr⁻¹·m⁻².
    pub radiance: [f32; 3],
    /// The part of the pixel that lamps cover, 0 to 1.
    pub share: f32,
}

/// A picture in linear radiance; lamps can be told apart from what they light.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Radiance, W·sr⁻¹·m⁻², red, green and blue; rows from the top, each from the left.
    pub pixels: Vec<[f32; 3]>,
    /// The part of each pixel that lamps make up.
    pub lamps: Vec<LampPart>,
}

impl Picture {
    /// A picture without lamps.
    ///
    /// # Panics
    /// If there are not width × height pixels.
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Self {
        assert_eq!(pixels.len(), width * height, "one value per pixel");
        let lamps = vec![LampPart::default(); pixels.len()];
        Self { width, height, pixels, lamps }
    }

    /// The exposure that suits what is seen beside lamps; where lamps are almost all there is, what suits
    /// them.
    pub fn exposure(&self) -> Exposure {
        let seen = |pixel: &[f32; 3]| pixel.iter().any(|&x| x > 0.0);
        let lit = || {
            let pixels = self.pixels.iter().zip(&self.lamps);
            pixels.filter(|&(pixel, lamp)| lamp.share == 0.0 && seen(pixel)).map(|(pixel, _)| pixel)
        };
        let all = || self.pixels.iter().filter(|pixel| seen(pixel));
        if 20 * lit().count() > all().count() {
            Exposure::automatic(lit().map(|p| p.map(f64::from)))
        } else {
            Exposure::automatic(all().map(|p| p.map(f64::from)))
        }
    }

    /// The picture as sRGB bytes, 3 · width · height of them.
    ///
    /// Lamps and the rest of a pixel are exposed apart and then mixed by area, so that the edge of a lamp far
    /// brighter than white is as smooth as any other.
    pub fn to_srgb(&self, exposure: Exposure) -> Vec<u8> {
        let encode = |(pixel, lamp): (&[f32; 3], &LampPart)| -> [u8; 3] {
            if lamp.share == 0.0 {
                return exposure.encode(pixel.map(f64::from));
            }
            let share = f64::from(lamp.share);
            let of_lamp = exposure.display(lamp.radiance.map(|x| f64::from(x) / share));
            let rest = [0, 1, 2].map(|c| f64::from(pixel[c] - lamp.radiance[c]) / (1.0 - share).max(1e-6));
            let of_rest = if share < 1.0 { exposure.display(rest) } else { [0.0; 3] };
            [0, 1, 2].map(|c| to_byte(of_lamp[c] * share + of_rest[c] * (1.0 - share)))
        };
        let mut bytes = vec![0; 3 * self.pixels.len()];
        let pixels = self.pixels.par_iter().zip(&self.lamps).with_min_len(4096);
        bytes.par_chunks_mut(3).zip(pixels).for_each(|(out, pixel)| out.copy_from_slice(&encode(pixel)));
        bytes
    }

    /// Writes an sRGB PNG, 8 bits a channel.
    ///
    /// # Errors
    /// Those of `writer`.
    pub fn write_png(&self, writer: &mut dyn Write, exposure: Exposure) -> io::Result<()> {
        write_rgb_png(writer, &self.to_srgb(exposure), self.width, self.height)
    }

    /// Writes linear radiance (W·sr⁻¹·m⁻²) as OpenEXR, f32.
    ///
    /// # Errors
    /// Those of `writer`.
    pub fn write_exr(&self, writer: &mut dyn Write) -> io::Result<()> {
        let bytes: Vec<u8> = self.pixels.iter().flatten().flat_map(|x| x.to_ne_bytes()).collect();
        // The encoder seeks, which a pipe can't; so it writes to memory first.
        let mut file = Cursor::new(Vec::new());
        let encoder = OpenExrEncoder::new(&mut file);
        let (width, height) = (self.width as u32, self.height as u32);
        encoder.write_image(&bytes, width, height, ExtendedColorType::Rgb32F).map_err(io_error)?;
        writer.write_all(&file.into_inner())
    }

    /// Whether no light arrives anywhere.
    pub fn is_black(&self) -> bool {
        self.pixels.iter().flatten().all(|&x| x <= 0.0)
    }
}

/// Writes sRGB bytes as PNG, 8 bits a channel.
pub(crate) fn write_rgb_png(
    writer: &mut dyn Write,
    bytes: &[u8],
    width: usize,
    height: usize,
) -> io::Result<()> {
    let encoder =
        png::PngEncoder::new_with_quality(writer, png::CompressionType::Fast, png::FilterType::Adaptive);
    encoder.write_image(bytes, width as u32, height as u32, ExtendedColorType::Rgb8).map_err(io_error)
}

fn io_error(error: ImageError) -> io::Error {
    match error {
        ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Picture {
        let pixels = (0..12).map(|k| [0.25 * k as f32, 0.5, 100.0 / (k + 1) as f32]).collect();
        Picture::new(4, 3, pixels)
    }

    #[test]
    fn exr_holds_the_radiance_to_the_last_bit() {
        let mut bytes = Vec::new();
        ramp().write_exr(&mut bytes).unwrap();
        let read = image::load_from_memory(&bytes).unwrap().into_rgb32f();
        assert_eq!(read.dimensions(), (4, 3));
        assert!(read.pixels().zip(&ramp().pixels).all(|(read, pixel)| read.0 == *pixel));
    }

    #[test]
    fn png_holds_the_exposed_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let exposure = Exposure { factor: 0.2 };
        ramp().save_png(&path, exposure).unwrap();
        let read = image::open(&path).unwrap().into_rgb8();
        assert_eq!(read.into_raw(), ramp().to_srgb(exposure));
    }

    #[test]
    fn a_lamp_that_covers_half_a_pixel_is_mixed_in_after_exposure() {
        let mut picture = Picture::new(1, 1, vec![[500.0; 3]]);
        picture.lamps[0] = LampPart { radiance: [500.0; 3], share: 0.5 };
        // Half white, half black in linear light is 188; the mean radiance alone would be white.
        assert!(picture.to_srgb(Exposure::default()).iter().all(|b| (186..=188).contains(b)));
    }

    #[test]
    fn exposure_looks_past_lamps_unless_there_is_nothing_else() {
        let lamp = LampPart { radiance: [100.0; 3], share: 1.0 };
        let mut picture = Picture::new(2, 1, vec![[100.0; 3], [1.0; 3]]);
        picture.lamps[0] = lamp;
        assert_eq!(picture.exposure(), Exposure::automatic([[1.0; 3]]));
        picture.lamps[1] = lamp;
        assert_eq!(picture.exposure(), Exposure::automatic([[100.0; 3], [1.0; 3]]));
    }
}
