//! Picture files: what `map_Kd` and `map_Ke` name, and how it is laid on a surface.
//!
//! Files of 8 or 16 bits a channel are sRGB (IEC 61966-2-1) and are made linear; OpenEXR and Radiance HDR are
//! linear as they are.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec2;
use image::{ColorType, DynamicImage, ImageError, ImageReader};

use super::beside::Beside;
use crate::scene::LARGEST;
use crate::scene::grouped::Grouped;
use crate::scene::material::{Beyond, Pixels, Texture};

/// A picture of more pixels than this is not read: some 1.5 GB.
const MOST_PIXELS: u64 = 1 << 26;

/// The pictures of a scene, each read once.
pub(crate) struct PictureFiles<'b> {
    beside: &'b Beside,
    /// None where a file is no picture.
    known: HashMap<PathBuf, Option<Arc<Pixels>>>,
    said: Grouped,
}

/// What a line such as `map_Kd -s 2 2 1 wood.png` says.
#[derive(Debug, PartialEq)]
struct Statement<'a> {
    file: &'a str,
    scale: DVec2,
    offset: DVec2,
    beyond: Beyond,
    /// Options that mean nothing here.
    ignored: Vec<&'a str>,
}

impl<'b> PictureFiles<'b> {
    /// None is read yet.
    pub fn new(beside: &'b Beside) -> Self {
        Self { beside, known: HashMap::new(), said: Grouped::default() }
    }

    /// The texture that a statement of a material library in `folder` describes, if it can be had; `key` is
    /// for messages.
    pub fn texture(&mut self, key: &str, statement: &str, folder: &Path) -> Option<Texture> {
        let Statement { file, scale, offset, beyond, ignored } = Statement::of(statement);
        if !ignored.is_empty() {
            self.said.say(key, format!("no notice is taken of {}", ignored.join(", ")));
        }
        let Some(path) = self.beside.find(folder, file) else {
            self.said.say(
                file,
                "not there; its material does without it: put it beside the scene, or remove the line",
            );
            return None;
        };
        let known = self.known.entry(path.clone()).or_insert_with(|| match read(&path) {
            Ok(pixels) => Some(Arc::new(pixels)),
            Err(message) => {
                self.said.say(file, format!("its material does without it: {message}"));
                None
            }
        });
        known.clone().map(|pixels| Texture { pixels, scale, offset, beyond })
    }

    /// What is to be said of pictures.
    pub fn said(&self) -> &Grouped {
        &self.said
    }
}

impl<'a> Statement<'a> {
    fn of(text: &'a str) -> Self {
        let mut said = Self {
            file: text,
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
            beyond: Beyond::Repeat,
            ignored: Vec::new(),
        };
        loop {
            let (option, rest) = word(said.file);
            if !option.starts_with('-') || rest.is_empty() {
                return said;
            }
            let numbers = |most: usize| {
                let (mut values, mut rest) = (Vec::new(), rest);
                while let (number, after) = word(rest)
                    && values.len() < most
                    && let Ok(number) = number.parse::<f64>()
                {
                    values.push(number);
                    rest = after;
                }
                (values, rest)
            };
            said.file = match option {
                "-s" | "-o" | "-t" => {
                    let (values, rest) = numbers(3);
                    let second = |otherwise: f64| values.get(1).copied().unwrap_or(otherwise);
                    match (option, values.first()) {
                        ("-s", Some(&u)) => said.scale = DVec2::new(u, second(1.0)),
                        ("-o", Some(&u)) => said.offset = DVec2::new(u, second(0.0)),
                        _ => said.ignored.push(option),
                    }
                    rest
                }
                "-clamp" => {
                    let (answer, rest) = word(rest);
                    said.beyond = if answer == "on" { Beyond::Clamp } else { Beyond::Repeat };
                    rest
                }
                "-mm" => {
                    said.ignored.push(option);
                    numbers(2).1
                }
                "-blendu" | "-blendv" | "-cc" | "-boost" | "-bm" | "-texres" | "-imfchan" | "-type"
                | "-colorspace" => {
                    said.ignored.push(option);
                    word(rest).1
                }
                // No option: the name of a file that starts with a dash.
                _ => return said,
            };
        }
    }
}

/// The first word, and what follows it.
fn word(text: &str) -> (&str, &str) {
    let text = text.trim();
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

/// Reads a picture in linear light; says what is wrong and what to do.
pub(crate) fn read(path: &Path) -> Result<Pixels, String> {
    let no_picture = |e: ImageError| match e {
        ImageError::IoError(e) if e.kind() == std::io::ErrorKind::NotFound => {
            "the file is not there; put it beside the scene's other files, or correct or remove the line"
                .to_owned()
        }
        e => format!("cannot be read ({e}); give a PNG, JPEG, BMP, TGA, HDR or EXR file"),
    };
    let open = || ImageReader::open(path)?.with_guessed_format();
    let (width, height) =
        open().map_err(ImageError::IoError).and_then(ImageReader::into_dimensions).map_err(no_picture)?;
    if u64::from(width) * u64::from(height) > MOST_PIXELS {
        return Err(format!(
            "{width} x {height} pixels are more than the {MOST_PIXELS} that are read; make it smaller"
        ));
    }
    let picture = open().map_err(ImageError::IoError).and_then(ImageReader::decode).map_err(no_picture)?;
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let texels = texels(picture);
    if texels.is_empty() {
        return Err("the picture has no pixels".into());
    }
    let is_light = |x: &f32| *x >= 0.0 && f64::from(*x) <= LARGEST;
    if let Some(k) = texels.iter().position(|texel| !texel.iter().all(is_light)) {
        return Err(format!(
            "the pixel at column {}, row {} is {:?}; light must be finite, up to {LARGEST:e}, and not negative: repair the picture",
            k % width,
            k / width,
            texels[k]
        ));
    }
    Ok(Pixels::new(width, height, texels))
}

fn texels(picture: DynamicImage) -> Vec<[f32; 3]> {
    match picture.color() {
        ColorType::Rgb32F | ColorType::Rgba32F => picture.into_rgb32f().pixels().map(|p| p.0).collect(),
        _ => {
            let linear: Vec<f32> = (0..=u16::MAX).map(|x| linear(f64::from(x) / 65535.0) as f32).collect();
            picture.into_rgb16().pixels().map(|p| p.0.map(|x| linear[usize::from(x)])).collect()
        }
    }
}

/// The sRGB transfer function, backwards (IEC 61966-2-1).
fn linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_say_where_the_picture_lies_and_name_what_is_ignored() {
        let said = Statement::of("-s 2 3 1 -o 0.5 -blendu on -clamp on -mm 0 1 my wood.png");
        let wanted = Statement {
            file: "my wood.png",
            scale: DVec2::new(2.0, 3.0),
            offset: DVec2::new(0.5, 0.0),
            beyond: Beyond::Clamp,
            ignored: vec!["-blendu", "-mm"],
        };
        assert_eq!(said, wanted);
        // A number that is a file's name after as many as the option may have.
        assert_eq!(Statement::of("-s 1 1 1 7").file, "7");
        for file in ["wood.png", "-wood.png", "-s", "-x y.png"] {
            assert_eq!(Statement::of(file).file, file);
        }
    }

    #[test]
    fn srgb_is_made_linear() {
        assert_eq!([linear(0.0), linear(1.0)], [0.0, 1.0]);
        assert!((linear(0.5) - 0.214041).abs() < 1e-6);
        // Both branches meet.
        assert!((linear(0.04045) - linear(0.0404500001)).abs() < 1e-7);
    }
}
