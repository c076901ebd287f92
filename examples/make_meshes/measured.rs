//! The scenes whose light comes from files: a luminaire's photometric file, and a picture of the sky.

use std::f64::consts::PI;
use std::path::Path;
use std::{fs, io};

use image::Rgb;
use image::codecs::hdr::HdrEncoder;

use super::areas::{box_area, walls_area};
use super::furniture::{chair, table};
use super::mesh::Side::*;
use super::mesh::{ALL, Mesh, STANDING, UPRIGHT};
use super::scene::{Camera, Material, ROUNDING, Scene};
use super::textured::{mix, noise, shade};

/// An office under six luminaires.
pub fn office() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [6.6, 2.8, 4.8]);
    m.paint("floor", "carpet").room(low, high, &[Bottom]);
    m.paint("ceiling", "white").room(low, high, &[Top]);
    m.paint("walls", "plaster").room(low, high, &[Left, Right, Front]);
    m.paint("end_wall", "teal").room(low, high, &[Back]);
    let mut area = box_area(6.6, 2.8, 4.8);
    for [x, z] in LUMINAIRES {
        let (from, to) = ([x - 0.6, 2.74, z - 0.08], [x + 0.6, 2.8, z + 0.08]);
        m.paint("luminaire", "aluminium").solid(from, to, &[Left, Right, Bottom, Back, Front]);
        area += walls_area(1.2, 0.06, 0.16) + 1.2 * 0.16;
    }
    for [x, z] in [[1.5, 1.3], [3.3, 1.3], [1.5, 3.4], [3.3, 3.4]] {
        area += m.placed([x, 0.0, z], [0.0, 1.0], |m| table(m, "desk", 1.5, 0.74, 0.75));
        area += m.placed([x, 0.0, z - 0.65], [0.0, 1.0], |m| chair(m, "chair"));
    }
    Scene {
        name: "office",
        notes: "\
An office, 6.6 x 2.8 x 4.8 m, closed, with four desks. Six luminaires under its ceiling send what
office.ies says, a photometric file (LM-63, type C) made by the program that made this mesh: a
wide distribution for desks, 3200 lm each by office.toml. A receiver, the work plane, is
0.75 m above the floor.

Known: 6 x 3200 lm is all the light there is, and all of it is absorbed.",
        materials: vec![
            Material::matt("white", [0.86, 0.86, 0.85]),
            Material::matt("plaster", [0.72, 0.71, 0.69]),
            Material::matt("teal", [0.20, 0.42, 0.46]),
            Material::matt("carpet", [0.24, 0.25, 0.28]),
            Material::matt("aluminium", [0.70, 0.70, 0.70]),
            Material::matt("walnut", [0.30, 0.19, 0.12]),
            Material::matt("beech", [0.62, 0.47, 0.31]),
            Material::matt("slate", [0.25, 0.33, 0.40]),
            Material::matt("linen", [0.68, 0.64, 0.56]),
        ],
        mesh: m,
        lights: OFFICE_LIGHTS,
        camera: Camera {
            about: "From the corner by the door over the desks.",
            position: [6.3, 1.75, 4.5],
            target: [2.0, 0.85, 1.5],
            fov: 58.0,
        },
        area,
        tolerance: ROUNDING,
    }
}

/// Where the office's luminaires hang: x and z.
const LUMINAIRES: [[f64; 2]; 6] = [[1.4, 1.4], [3.3, 1.4], [5.2, 1.4], [1.4, 3.4], [3.3, 3.4], [5.2, 3.4]];

const OFFICE_LIGHTS: &str = "
[[light]]
kind = \"ies\"
file = \"office.ies\"
position = [1.4, 2.73, 1.4]
direction = [0, -1, 0]
up = [1, 0, 0] # where the file's horizontal angle 0 points: along the luminaire
luminous_flux = 3200 # lm; what the file gives if left out
colour = [1.0, 0.93, 0.84]

[[light]]
kind = \"ies\"
file = \"office.ies\"
position = [3.3, 2.73, 1.4]
direction = [0, -1, 0]
up = [1, 0, 0] # where the file's horizontal angle 0 points: along the luminaire
luminous_flux = 3200 # lm; what the file gives if left out
colour = [1.0, 0.93, 0.84]

[[light]]
kind = \"ies\"
file = \"office.ies\"
position = [5.2, 2.73, 1.4]
direction = [0, -1, 0]
up = [1, 0, 0] # where the file's horizontal angle 0 points: along the luminaire
luminous_flux = 3200 # lm; what the file gives if left out
colour = [1.0, 0.93, 0.84]

[[light]]
kind = \"ies\"
file = \"office.ies\"
position = [1.4, 2.73, 3.4]
direction = [0, -1, 0]
up = [1, 0, 0] # where the file's horizontal angle 0 points: along the luminaire
luminous_flux = 3200 # lm; what the file gives if left out
colour = [1.0, 0.93, 0.84]

[[light]]
kind = \"ies\"
file = \"office.ies\"
position = [3.3, 2.73, 3.4]
direction = [0, -1, 0]
up = [1, 0, 0] # where the file's horizontal angle 0 points: along the luminaire
luminous_flux = 3200 # lm; what the file gives if left out
colour = [1.0, 0.93, 0.84]

[[light]]
kind = \"ies\"
file = \"office.ies\"
position = [5.2, 2.73, 3.4]
direction = [0, -1, 0]
up = [1, 0, 0] # where the file's horizontal angle 0 points: along the luminaire
luminous_flux = 3200 # lm; what the file gives if left out
colour = [1.0, 0.93, 0.84]

[[receiver]]
name = \"work plane\"
corner = [0.5, 0.75, 0.5]
edges = [[0, 0, 3.8], [5.6, 0, 0]]
points = [19, 28]
";

/// A pavilion under a sky from a picture.
pub fn pavilion() -> Scene {
    let mut m = Mesh::default();
    let ground = [[-6.0, 0.0, -6.0], [-6.0, 0.0, 6.0], [6.0, 0.0, 6.0], [6.0, 0.0, -6.0]];
    m.paint("ground", "gravel").face(&ground);
    m.paint("plinth", "limestone").solid([-1.8, 0.0, -1.8], [1.8, 0.2, 1.8], &STANDING);
    m.paint("step", "limestone").solid([-0.7, 0.0, 1.8], [0.7, 0.1, 2.2], &[Left, Right, Top, Front]);
    for [x, z] in [[-1.5, -1.5], [1.2, -1.5], [-1.5, 1.2], [1.2, 1.2]] {
        m.paint("columns", "plaster").solid([x, 0.2, z], [x + 0.3, 2.1, z + 0.3], &UPRIGHT);
    }
    m.paint("roof", "plaster").solid([-1.9, 2.1, -1.9], [1.9, 2.3, 1.9], &ALL);
    m.paint("wall", "terracotta").solid([-1.2, 0.2, -1.45], [1.2, 1.7, -1.3], &STANDING);
    m.paint("bench", "teal").solid([-0.7, 0.2, -0.5], [0.7, 0.62, 0.0], &STANDING);
    let standing = |width: f64, height: f64, depth: f64| walls_area(width, height, depth) + width * depth;
    Scene {
        name: "pavilion",
        notes: "\
An open pavilion on level ground. Nothing in it emits: its light is that of a sky which is a picture
by longitude and latitude, pavilion_sky.hdr, with a low sun among clouds; see pavilion.toml. The
picture is made by the program that made this mesh.

Known: open level ground gets the 40 000 lx that pavilion.toml asks for.",
        materials: vec![
            Material::matt("gravel", [0.36, 0.34, 0.31]),
            Material::matt("limestone", [0.62, 0.59, 0.53]),
            Material::matt("plaster", [0.78, 0.76, 0.72]),
            Material::matt("terracotta", [0.66, 0.33, 0.22]),
            Material::matt("teal", [0.10, 0.38, 0.40]),
        ],
        mesh: m,
        lights: "
[sky]
kind = \"environment\"
file = \"pavilion_sky.hdr\"
turn = 0 # degrees, counter-clockwise seen from above
illuminance = 40000 # lx, of open level ground
",
        camera: Camera {
            about: "From the front, past the sun's side, into the pavilion.",
            position: [3.9, 1.35, 5.6],
            target: [0.0, 1.22, 0.0],
            fov: 44.0,
        },
        area: 12.0 * 12.0
            + standing(3.6, 0.2, 3.6)
            + 0.1 * (1.4 + 2.0 * 0.4)
            + 1.4 * 0.4
            + 4.0 * walls_area(0.3, 1.9, 0.3)
            + box_area(3.8, 0.2, 3.8)
            + standing(2.4, 1.5, 0.15)
            + standing(1.4, 0.42, 0.5),
        tolerance: ROUNDING,
    }
}

/// Writes the luminaire's photometric file and the picture of the sky into a folder.
pub fn write_files(folder: &Path) -> io::Result<()> {
    fs::write(folder.join("office.ies"), luminaire())?;
    let (width, height) = (144, 72);
    let pixels: Vec<Rgb<f32>> = (0..width * height)
        .map(|k| {
            let place = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
            Rgb(sky(place(k % width, width), place(k / width, height)).map(|x| x as f32))
        })
        .collect();
    let file = fs::File::create(folder.join("pavilion_sky.hdr"))?;
    HdrEncoder::new(io::BufWriter::new(file)).encode(&pixels, width, height).map_err(io::Error::other)
}

/// A photometric file: a wide distribution, wider across the luminaire (C90) than along it (C0).
fn luminaire() -> String {
    let vertical: Vec<f64> = (0..=18).map(|k| 5.0 * f64::from(k)).collect();
    let horizontal: Vec<f64> = (0..=6).map(|k| 15.0 * f64::from(k)).collect();
    let words = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let mut text = format!(
        "IESNA:LM-63-2002\n[TEST] made for the example scene of an office\n[MANUFAC] none\n[LUMINAIRE] linear, wide distribution\n\
         TILT=NONE\n1 3200 1 {} {} 1 2 0.16 1.2 0\n1 1 26\n{}\n{}\n",
        vertical.len(),
        horizontal.len(),
        words(&vertical),
        words(&horizontal),
    );
    for h in &horizontal {
        let across = (h * PI / 180.0).sin().powi(2);
        let row: Vec<f64> = vertical
            .iter()
            .map(|v| {
                let angle = v * PI / 180.0;
                let wings = 1.0 + 1.1 * across * (2.0 * angle.min(PI / 4.0)).sin().powi(3);
                // Nothing above 70 degrees from the axis but a glimmer, so that screens do not glare.
                let shield = 1.0 / (1.0 + ((v - 66.0) / 4.0).exp());
                (9500.0 * wings * angle.cos() * (0.02 + 0.98 * shield)).round() / 10.0
            })
            .collect();
        text += &words(&row);
        text.push('\n');
    }
    text
}

/// Radiance of a sky at longitude x and latitude y from the top, each 0 to 1: a low sun among clouds over a
/// plain.
fn sky(x: f64, y: f64) -> [f64; 3] {
    let elevation = (0.5 - y) * PI;
    if elevation < 0.0 {
        return shade([0.66, 0.60, 0.52], 1.0 + 0.15 * noise(x, y, [24, 12]));
    }
    let height = elevation.sin();
    let mut colour = mix([1.05, 0.86, 0.66], [0.16, 0.34, 0.80], height.powf(0.45));
    // Clouds in bands, lit from the sun's side.
    let bands = 0.55 * noise(x, y, [10, 26]) + 0.3 * noise(x, y, [22, 52]) + 0.15 * noise(x, y, [48, 72]);
    let cloud = ((bands - 0.46) * 4.5).clamp(0.0, 1.0) * (1.0 - height).powf(0.6);
    colour = mix(colour, [1.25, 1.10, 0.98], 0.85 * cloud);
    // The sun, 27 degrees high, to the left behind the camera, and its glow.
    let (sun_x, sun_elevation) = (0.135, 27.0 * PI / 180.0);
    let turn = (x - sun_x) * 2.0 * PI;
    let cosine = elevation.sin() * sun_elevation.sin() + elevation.cos() * sun_elevation.cos() * turn.cos();
    let apart = cosine.clamp(-1.0, 1.0).acos() * 180.0 / PI;
    let disc = if apart < 2.0 { 2600.0 } else { 0.0 };
    let glow = 2.2 * (-apart / 9.0).exp() + 0.5 * (-apart / 30.0).exp();
    let warm = shade([1.0, 0.88, 0.68], disc + glow);
    [0, 1, 2].map(|c| colour[c] + warm[c])
}
