//! The scene whose surfaces have pictures on them, and the pictures.

use std::path::Path;
use std::{fs, io};

use image::{ImageFormat, Rgb, RgbImage};

use super::areas::{box_area, walls_area};
use super::furniture::table;
use super::mesh::Side::*;
use super::mesh::{Mesh, UPRIGHT, inside, outside};
use super::scene::{Camera, Material, ROUNDING, Scene};

/// A living room with textures on floor, rug, wall, painting and screen.
pub fn textured_room() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [4.2, 2.6, 3.6]);
    let lamp = inside([1.7, 2.6, 1.4], [2.5, 2.6, 2.2], Top);
    m.paint("floor", "parquet").mapped(&inside(low, high, Bottom), [3.0, 3.5]);
    // From the lower left corner along the floor.
    let [right, top, left_top, left] = inside(low, high, Back);
    m.paint("brick_wall", "brick").mapped(&[left, right, top, left_top], [4.0, 4.3]);
    m.paint("walls", "plaster").room(low, high, &[Left, Right, Front]);
    m.paint("ceiling", "white").surround(inside(low, high, Top), lamp);
    m.paint("lamp", "lamp").face(&lamp);
    // A rug a centimetre thick, in front of the sofa.
    let (from, to) = ([0.9, 0.0, 1.0], [3.3, 0.01, 2.6]);
    m.paint("rug", "felt").solid(from, to, &UPRIGHT);
    m.paint("rug", "rug").mapped(&outside(from, to, Top), [1.0, 1.0]);
    let area = box_area(4.2, 2.6, 3.6)
        + walls_area(2.4, 0.01, 1.6)
        + 2.4 * 1.6
        + m.placed([2.1, 1.55, 0.0], [0.0, 1.0], painting)
        + m.placed([0.0, 0.0, 1.8], [1.0, 0.0], screen)
        + m.placed([2.3, 0.01, 1.8], [0.0, 1.0], |m| table(m, "table", 0.9, 0.42, 0.55));
    Scene {
        name: "textured_room",
        notes: "\
A closed living room, 4.2 x 2.6 x 3.6 m, with pictures on its surfaces: parquet (JPEG), a rug, a
brick wall and a painting (PNG), all of them reflectances that repeat or not; and a screen that
glows as its picture says (map_Ke). The pictures are made by the program that made this mesh.

Known: the lamp emits pi A Le = pi * 0.64 m2 * (14, 12.5, 10) = (28.149, 25.133, 20.106) W.
The screen, 0.96 x 0.54 m, adds pi * 0.5184 m2 * 2.5 times the mean of its picture.",
        materials: vec![
            Material::matt("parquet", [1.0; 3]).with_picture("map_Kd", "textured_parquet.jpg"),
            Material::matt("brick", [1.0; 3]).with_picture("map_Kd", "textured_brick.png"),
            Material::matt("rug", [1.0; 3]).with_picture("map_Kd", "textured_rug.png"),
            Material::matt("painting", [1.0; 3]).with_picture("map_Kd", "textured_painting.png"),
            Material::glowing("screen", [0.05; 3], [2.5; 3]).with_picture("map_Ke", "textured_screen.png"),
            Material::matt("felt", [0.30, 0.12, 0.10]),
            Material::matt("plaster", [0.78, 0.76, 0.72]),
            Material::matt("white", [0.85, 0.85, 0.84]),
            Material::matt("walnut", [0.30, 0.19, 0.12]),
            Material::matt("black", [0.04, 0.04, 0.04]),
            Material::glowing("lamp", [0.78; 3], [14.0, 12.5, 10.0]),
        ],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From the corner by the door towards the brick wall and the screen.",
            position: [3.9, 1.75, 3.35],
            target: [1.45, 0.85, 0.6],
            fov: 56.0,
        },
        area,
        tolerance: ROUNDING,
    }
}

/// A framed painting, 1.3 x 0.9 m, centred on the origin and hung on the wall at z = 0.
fn painting(m: &mut Mesh) -> f64 {
    let (low, high) = ([-0.65, -0.45, 0.0], [0.65, 0.45, 0.04]);
    let canvas = outside([-0.58, -0.38, 0.04], [0.58, 0.38, 0.04], Front);
    m.paint("frame", "walnut").solid(low, high, &[Left, Right, Bottom, Top]);
    m.surround(outside(low, high, Front), canvas);
    m.paint("painting", "painting").mapped(&canvas, [1.0, 1.0]);
    box_area(1.3, 0.9, 0.04) - 1.3 * 0.9
}

/// A screen, 0.96 x 0.54 m, on a low board against the wall at z = 0.
fn screen(m: &mut Mesh) -> f64 {
    let (low, high) = ([-0.7, 0.0, 0.0], [0.7, 0.45, 0.4]);
    m.paint("board", "walnut").solid(low, high, &[Left, Right, Top, Front]);
    let (low, high) = ([-0.5, 0.5, 0.1], [0.5, 1.08, 0.14]);
    let glass = outside([-0.48, 0.52, 0.14], [0.48, 1.06, 0.14], Front);
    m.paint("screen", "black").solid(low, high, &[Left, Right, Bottom, Top, Back]);
    m.surround(outside(low, high, Front), glass);
    m.paint("screen", "screen").mapped(&glass, [1.0, 1.0]);
    1.4 * 0.45 + 2.0 * 0.45 * 0.4 + 1.4 * 0.4 + box_area(1.0, 0.58, 0.04)
}

/// Paints all pictures into a folder.
pub fn write_pictures(folder: &Path) -> io::Result<()> {
    let png = |name: &str, width: u32, height: u32, colour: &dyn Fn(f64, f64) -> [f64; 3]| {
        paint(width, height, colour).save_with_format(folder.join(name), ImageFormat::Png)
    };
    png("textured_brick.png", 160, 120, &brick).map_err(io::Error::other)?;
    png("textured_rug.png", 144, 96, &rug).map_err(io::Error::other)?;
    png("textured_painting.png", 174, 114, &landscape).map_err(io::Error::other)?;
    png("textured_screen.png", 128, 72, &news).map_err(io::Error::other)?;
    let mut parquet_file = fs::File::create(folder.join("textured_parquet.jpg"))?;
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut parquet_file, 82);
    paint(256, 256, &parquet).write_with_encoder(encoder).map_err(io::Error::other)
}

/// A picture by its colour at (x, y), each 0 to 1 from the upper left, as sRGB bytes of 32 shades, which pack
/// well.
fn paint(width: u32, height: u32, colour: &dyn Fn(f64, f64) -> [f64; 3]) -> RgbImage {
    RgbImage::from_fn(width, height, |i, j| {
        let place = |k: u32, count: u32| (f64::from(k) + 0.5) / f64::from(count);
        Rgb(colour(place(i, width), place(j, height))
            .map(|x| ((x.clamp(0.0, 1.0) * 63.0).round() * 255.0 / 63.0) as u8))
    })
}

/// A number from 0 to 1 that looks random, the same for the same cell.
fn hash(i: i64, j: i64) -> f64 {
    let mut x =
        (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (j as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    for _ in 0..2 {
        x = (x ^ (x >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    (x >> 11) as f64 / (1u64 << 53) as f64
}

/// Smooth noise with `period` cells each way, so that it repeats.
pub(super) fn noise(x: f64, y: f64, period: [i64; 2]) -> f64 {
    let (x, y) = (x * period[0] as f64, y * period[1] as f64);
    let (i, j) = (x.floor(), y.floor());
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (s, t) = (smooth(x - i), smooth(y - j));
    let at =
        |a: i64, b: i64| hash((i as i64 + a).rem_euclid(period[0]), (j as i64 + b).rem_euclid(period[1]));
    (at(0, 0) * (1.0 - s) + at(1, 0) * s) * (1.0 - t) + (at(0, 1) * (1.0 - s) + at(1, 1) * s) * t
}

pub(super) fn shade(colour: [f64; 3], factor: f64) -> [f64; 3] {
    colour.map(|x| x * factor)
}

pub(super) fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * t)
}

/// Boards of oak, each row shifted against the next.
fn parquet(x: f64, y: f64) -> [f64; 3] {
    const ROWS: f64 = 8.0;
    let row = (y * ROWS).floor();
    let along = (x * 2.0 + hash(row as i64, 3)).rem_euclid(2.0);
    let board = along.floor();
    let tone = 0.8 + 0.3 * hash(row as i64 * 7 + board as i64, 5);
    let grain = noise(x, y, [6, 160]) * 0.16 + noise(x + 0.3 * noise(x, y, [3, 12]), y, [3, 64]) * 0.12;
    let (gap_y, gap_x) = ((y * ROWS).fract(), along.fract());
    let joint = if !(0.04..0.96).contains(&gap_y) || gap_x < 0.012 { 0.62 } else { 1.0 };
    shade([0.78, 0.62, 0.45], (tone - grain) * joint)
}

/// Bricks in stretcher bond, 4 courses and 2 bricks across.
fn brick(x: f64, y: f64) -> [f64; 3] {
    let course = (y * 6.0).floor();
    let along = x * 4.0 + if course.rem_euclid(2.0) == 1.0 { 0.5 } else { 0.0 };
    let (u, v) = (along.fract(), (y * 6.0).fract());
    let rough = noise(x, y, [40, 30]);
    let mortar = !(0.035..0.965).contains(&(u + 0.01 * rough)) || !(0.07..0.93).contains(&(v + 0.03 * rough));
    if mortar {
        return shade([0.74, 0.71, 0.67], 0.92 + 0.1 * rough);
    }
    let number = hash(along.floor().rem_euclid(4.0) as i64, course as i64);
    let clay = mix([0.50, 0.27, 0.22], [0.63, 0.38, 0.30], number);
    shade(clay, 0.86 + 0.22 * rough)
}

/// A rug with a border and diamonds.
fn rug(x: f64, y: f64) -> [f64; 3] {
    let (dx, dy) = ((x.min(1.0 - x)) * 1.5, y.min(1.0 - y));
    let edge = dx.min(dy);
    let (red, cream, blue) = ([0.62, 0.16, 0.14], [0.90, 0.84, 0.70], [0.14, 0.22, 0.42]);
    let weave = 0.93 + 0.07 * hash((x * 144.0) as i64, (y * 96.0) as i64);
    let colour = match edge {
        e if e < 0.03 => cream,
        e if e < 0.11 => match ((x * 36.0 + y * 24.0).fract() < 0.5) as u8 {
            1 => blue,
            _ => mix(blue, cream, 0.35),
        },
        e if e < 0.13 => cream,
        _ => {
            let (u, v) = ((x * 9.0).fract() - 0.5, (y * 6.0).fract() - 0.5);
            let diamond = u.abs() + v.abs();
            if diamond < 0.16 {
                cream
            } else if diamond < 0.32 {
                blue
            } else {
                red
            }
        }
    };
    shade(colour, weave)
}

/// Hills before a sunset.
fn landscape(x: f64, y: f64) -> [f64; 3] {
    let sky = mix([0.28, 0.42, 0.68], [0.99, 0.78, 0.52], (y / 0.62).min(1.0));
    let sun = (x - 0.66).hypot((y - 0.42) * 0.66);
    let mut colour =
        if sun < 0.055 { [1.0, 0.95, 0.78] } else { mix([1.0, 0.86, 0.6], sky, (sun * 3.2).min(1.0)) };
    for (k, (height, tint)) in
        [(0.52, [0.58, 0.50, 0.60]), (0.66, [0.36, 0.42, 0.48]), (0.80, [0.20, 0.33, 0.27])]
            .into_iter()
            .enumerate()
    {
        let k = k as f64;
        let ridge =
            height + 0.05 * (x * (5.0 + 2.0 * k) + 1.7 * k).sin() + 0.025 * (x * (13.0 + 3.0 * k) + k).sin();
        if y > ridge {
            colour = shade(tint, 1.0 - 0.5 * (y - ridge));
        }
    }
    colour
}

/// A screen: a bright window over a blue ground, with lines of text below.
fn news(x: f64, y: f64) -> [f64; 3] {
    if y > 0.80 {
        let line = (0.85..0.90).contains(&y) && x < 0.8 || (0.93..0.97).contains(&y) && x < 0.55;
        return if line && hash((x * 60.0) as i64, (y * 20.0) as i64) > 0.25 {
            [0.95; 3]
        } else {
            [0.62, 0.08, 0.10]
        };
    }
    if (0.08..0.62).contains(&x) && (0.12..0.70).contains(&y) {
        let (u, v) = ((x - 0.08) / 0.54, (y - 0.12) / 0.58);
        return landscape(u, v);
    }
    mix([0.05, 0.16, 0.42], [0.20, 0.50, 0.85], x * 0.7 + 0.3 * y)
}
