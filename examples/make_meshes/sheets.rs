//! The scene whose light comes through sheets: a roller blind and a lampshade.

use std::f64::consts::PI;

use super::areas::{box_area, walls_area};
use super::furniture::{chair, table};
use super::mesh::Side::*;
use super::mesh::{ALL, Mesh, STANDING, UPRIGHT, inside};
use super::scene::{Camera, Material, ROUNDING, Scene};

/// A room with a blind half down before its window, and a standard lamp.
pub fn blinds() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [4.0, 2.6, 3.6]);
    let window = inside([0.0, 0.1, 0.7], [0.0, 2.3, 2.9], Left);
    m.paint("window_wall", "plaster").surround(inside(low, high, Left), window);
    m.paint("floor", "oak").room(low, high, &[Bottom]);
    m.paint("ceiling", "ceiling").room(low, high, &[Top]);
    m.paint("walls", "plaster").room(low, high, &[Right, Back, Front]);
    m.paint("blind", "blind").face(&inside([0.05, 1.5, 0.6], [0.05, 2.45, 3.0], Left));
    let area = box_area(4.0, 2.6, 3.6) - 2.2 * 2.2
        + 0.95 * 2.4
        + m.placed([1.0, 0.0, 0.45], [0.0, 1.0], standard_lamp)
        + m.placed([2.0, 0.0, 1.9], [1.0, 0.0], |m| table(m, "table", 1.2, 0.74, 0.7))
        + m.placed([2.7, 0.0, 1.9], [-1.0, 0.0], |m| chair(m, "chair"));
    Scene {
        name: "blinds",
        notes: "\
A room, 4 x 2.6 x 3.6 m, early in the morning. Sun and sky light it through a window 2.2 m high
and 2.2 m wide in the wall x = 0, whose upper part a roller blind covers: it hangs 5 cm before the
wall, and lets a fifth of the light through. A bulb on a stand has a shade of paper, open above
and below, that lets two fifths through. What blind and shade do is in blinds.toml.

Known: what lights the blind from outside and comes through is lost nowhere: emitted = absorbed +
escaped to rounding. Below the blind the sun's patch on the floor ends at x = 2.98 m.",
        materials: vec![
            Material::matt("plaster", [0.78, 0.76, 0.72]),
            Material::matt("ceiling", [0.85, 0.85, 0.84]),
            Material::matt("oak", [0.46, 0.33, 0.22]),
            Material::matt("walnut", [0.30, 0.19, 0.12]),
            Material::matt("beech", [0.62, 0.47, 0.31]),
            Material::matt("iron", [0.12, 0.12, 0.12]),
            Material::matt("blind", [0.62, 0.52, 0.36]),
            Material::matt("paper", [0.50, 0.46, 0.38]),
            Material::glowing("bulb", [0.60, 0.60, 0.60], [33.0, 24.0, 14.0]),
        ],
        mesh: m,
        lights: "
[material.blind]
reflectance_back = [0.68, 0.66, 0.62] # white towards the window
transmittance = [0.20, 0.18, 0.135]

[material.paper]
transmittance = [0.42, 0.37, 0.26]

[[light]]
kind = \"sun\"
direction = [0.82, -0.42, 0.18] # the way its light travels
diameter = 0.533 # degrees
illuminance = 6000 # lx, of what faces it
colour = [1.0, 0.9, 0.72]

[sky]
kind = \"clear\"
sun = [-0.82, 0.42, -0.18]
illuminance = 2500 # lx, of open level ground by the sky alone
colour = [0.75, 0.9, 1.25]
ground = 0.2

[[receiver]]
name = \"table\"
corner = [1.65, 0.8, 1.3]
edges = [[0, 0, 1.2], [0.7, 0, 0]]
points = [6, 8]
",
        camera: Camera {
            about: "From the far corner towards the window.",
            position: [3.8, 1.55, 3.2],
            target: [0.6, 1.05, 1.15],
            fov: 58.0,
        },
        area,
        tolerance: ROUNDING,
    }
}

/// A bulb on a thin stand, inside a cylinder of paper that is open above and below.
fn standard_lamp(m: &mut Mesh) -> f64 {
    const SIDES: usize = 32;
    const RADIUS: f64 = 0.22;
    m.paint("lamp_stand", "iron").solid([-0.14, 0.0, -0.14], [0.14, 0.02, 0.14], &STANDING);
    m.solid([-0.012, 0.02, -0.012], [0.012, 1.42, 0.012], &UPRIGHT);
    m.paint("bulb", "bulb").solid([-0.04, 1.42, -0.04], [0.04, 1.5, 0.04], &ALL);
    let rim = |k: usize, y: f64| {
        let (sine, cosine) = (2.0 * PI * (k % SIDES) as f64 / SIDES as f64).sin_cos();
        [RADIUS * cosine, y, -RADIUS * sine]
    };
    m.paint("lampshade", "paper");
    for k in 0..SIDES {
        m.face(&[rim(k, 1.3), rim(k + 1, 1.3), rim(k + 1, 1.66), rim(k, 1.66)]);
    }
    let stand = 0.28 * 0.28 + walls_area(0.28, 0.02, 0.28) + walls_area(0.024, 1.4, 0.024);
    let shade = 0.36 * 2.0 * RADIUS * SIDES as f64 * (PI / SIDES as f64).sin();
    stand + box_area(0.08, 0.08, 0.08) + shade
}
