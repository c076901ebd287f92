//! The scenes whose light comes from sources without area: sun and sky, and spots.

use super::areas::box_area;
use super::furniture::{chair, picture, table};
use super::mesh::Side::*;
use super::mesh::{Mesh, inside};
use super::scene::{Camera, Material, ROUNDING, Scene};

/// A room with an open window, under the sun and a clear sky.
pub fn daylit_room() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [5.0, 2.8, 4.0]);
    let window = inside([0.0, 0.9, 1.0], [0.0, 2.4, 3.0], Left);
    m.paint("window_wall", "plaster").surround(inside(low, high, Left), window);
    m.paint("floor", "oak").room(low, high, &[Bottom]);
    m.paint("ceiling", "ceiling").room(low, high, &[Top]);
    m.paint("walls", "plaster").room(low, high, &[Back, Front]);
    m.paint("far_wall", "terracotta").room(low, high, &[Right]);
    let area = box_area(5.0, 2.8, 4.0) - 1.5 * 2.0
        + m.placed([2.6, 0.0, 2.2], [1.0, 0.0], |m| table(m, "table", 1.4, 0.74, 0.8))
        + m.placed([3.3, 0.0, 2.2], [-1.0, 0.0], |m| chair(m, "chair"));
    Scene {
        name: "daylit_room",
        notes: "\
A room, 5 x 2.8 x 4 m, with an open window 1.5 m high and 2 m wide in the wall x = 0. Nothing
in it emits: its light is that of the sun and of a clear sky, both in daylit_room.toml.

Known: the sun's disc is half a degree wide and its middle sends light along (0.62, -0.45,
0.25). The window's corners cast its patch on the floor between x = 1.24 m (from the sill)
and the far parts of x = 3.31 m, shifted along z by 0.5 to 1.33 m.",
        materials: vec![
            Material::matt("plaster", [0.78, 0.76, 0.72]),
            Material::matt("ceiling", [0.85, 0.85, 0.84]),
            Material::matt("oak", [0.46, 0.33, 0.22]),
            Material::matt("terracotta", [0.66, 0.33, 0.22]),
            Material::matt("walnut", [0.30, 0.19, 0.12]),
            Material::matt("beech", [0.62, 0.47, 0.31]),
            Material::matt("slate", [0.25, 0.33, 0.40]),
            Material::matt("linen", [0.68, 0.64, 0.56]),
        ],
        mesh: m,
        lights: "
[[light]]
kind = \"sun\"
direction = [0.62, -0.45, 0.25] # the way its light travels
diameter = 0.533 # degrees
illuminance = 60000 # lx, of what faces it
colour = [1.0, 0.93, 0.82]

[sky]
kind = \"clear\"
sun = [-0.62, 0.45, -0.25]
illuminance = 12000 # lx, of open level ground by the sky alone
colour = [0.75, 0.9, 1.25]
ground = 0.2

[[receiver]]
name = \"work plane\"
corner = [0.5, 0.85, 0.5]
edges = [[0, 0, 3], [4, 0, 0]]
points = [12, 16]
",
        camera: Camera {
            about: "From the far corner towards the window.",
            position: [4.8, 1.7, 0.3],
            target: [0.9, 1.0, 2.5],
            fov: 60.0,
        },
        area,
        tolerance: ROUNDING,
    }
}

/// A gallery wall under three spots.
pub fn spot_gallery() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [6.0, 3.0, 4.0]);
    m.paint("floor", "slate").room(low, high, &[Bottom]);
    m.paint("ceiling", "white").room(low, high, &[Top]);
    m.paint("walls", "white").room(low, high, &[Left, Right, Back, Front]);
    let pictures: f64 = [1.2, 3.0, 4.8].map(|x| m.placed([x, 1.5, 0.0], [0.0, 1.0], picture)).iter().sum();
    Scene {
        name: "spot_gallery",
        notes: "\
A gallery, 6 x 3 x 4 m, closed, with three pictures on the wall z = 0. Each has a spot without
area under the ceiling, and a fourth, wide one lights the middle of the floor; see
spot_gallery.toml.

Known: the spots' luminous flux, 3 x 400 lm + 300 lm, is all the light there is, and all of it
is absorbed.",
        materials: vec![
            Material::matt("white", [0.80, 0.79, 0.77]),
            Material::matt("slate", [0.25, 0.27, 0.30]),
            Material::matt("walnut", [0.30, 0.19, 0.12]),
            Material::matt("teal", [0.08, 0.36, 0.38]),
        ],
        mesh: m,
        lights: "
[[light]]
kind = \"spot\"
position = [1.2, 2.9, 1.6]
target = [1.2, 1.5, 0.0]
cone = 24 # degrees from the axis to the end of all light
penumbra = 10 # degrees over which it fades, inwards from there
luminous_flux = 400 # lm
colour = [1.0, 0.86, 0.68]

[[light]]
kind = \"spot\"
position = [3.0, 2.9, 1.6]
target = [3.0, 1.5, 0.0]
cone = 24
penumbra = 10
luminous_flux = 400
colour = [1.0, 0.86, 0.68]

[[light]]
kind = \"spot\"
position = [4.8, 2.9, 1.6]
target = [4.8, 1.5, 0.0]
cone = 24
penumbra = 10
luminous_flux = 400
colour = [1.0, 0.86, 0.68]

[[light]]
kind = \"spot\"
position = [3.0, 2.95, 2.6]
direction = [0, -1, 0]
cone = 50
penumbra = 25
luminous_flux = 300
",
        camera: Camera {
            about: "From the front of the room towards the pictures.",
            position: [3.0, 1.6, 3.9],
            target: [3.0, 1.35, 0.0],
            fov: 62.0,
        },
        area: box_area(6.0, 3.0, 4.0) + pictures,
        tolerance: ROUNDING,
    }
}
