//! Small image files, as bytes.

use std::io::Cursor;

use image::{ImageFormat, Rgb, Rgb32FImage, RgbImage};

/// A PNG file with the colour at column i and row j.
pub fn png(width: u32, height: u32, at: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let picture = RgbImage::from_fn(width, height, |i, j| Rgb(at(i, j)));
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// An OpenEXR file, likewise.
pub fn exr(width: u32, height: u32, at: impl Fn(u32, u32) -> [f32; 3]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let picture = Rgb32FImage::from_fn(width, height, |i, j| Rgb(at(i, j)));
    picture.write_to(&mut bytes, ImageFormat::OpenExr).unwrap();
    bytes.into_inner()
}
