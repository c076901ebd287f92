//! Scenes with carriers: mirrors, metals and glass.

use std::f64::consts::PI;

use super::areas::{block_area, box_area};
use super::mesh::Side::*;
use super::mesh::{Mesh, Point, inside, plus};
use super::scene::{Camera, Material, ROUNDING, Scene};

pub fn mirror_room() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [4.0, 2.6, 3.0]);
    let lamp = inside([0.6, 2.6, 0.4], [1.4, 2.6, 1.2], Top);
    let screen = [[2.0, 2.0, 0.0], [1.9, 2.0, 0.0], [1.9, 2.0, 1.8], [2.0, 2.0, 1.8]];
    let block = [[3.0, 0.8, 0.6], [2.6, 0.8, 1.0], [3.0, 0.8, 1.4], [3.4, 0.8, 1.0]];

    m.paint("floor", "oak").room(low, high, &[Bottom]);
    m.paint("mirror_wall", "mirror").room(low, high, &[Front]);
    m.paint("walls", "chalk").room(low, high, &[Left, Back]);
    m.paint("end_wall", "blue").room(low, high, &[Right]);
    m.paint("ceiling", "chalk").surround(inside(low, high, Top), lamp);
    m.paint("lamp", "lamp").face(&lamp);
    m.paint("screen", "chalk").block(screen);
    m.paint("block", "terracotta").block(block);

    Scene {
        name: "mirror_room",
        notes: "\
A closed room of 4 x 2.6 x 3 m whose wall at z = 3 is a mirror. A screen stands between the
lamp and the terracotta block: much of the light that reaches the far end goes by way of the
mirror, and the bright patch it throws there has the outline of the lamp's gap.

Known: the lamp emits pi A Le = pi * 0.64 m2 * (18, 16, 13) = (36.191, 32.170, 26.138) W, and
what the diffuse faces absorb and what the mirror absorbs, 5 % at every reflection, add up to
that.",
        materials: vec![
            Material::matt("chalk", [0.80, 0.78, 0.74]),
            Material::matt("oak", [0.45, 0.32, 0.21]),
            Material::matt("blue", [0.24, 0.44, 0.68]),
            Material::matt("terracotta", [0.66, 0.27, 0.16]),
            Material::mirror("mirror", 0.95),
            Material::glowing("lamp", [0.78, 0.78, 0.78], [18.0, 16.0, 13.0]),
        ],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From the lit end towards the mirror: what it shows is behind the viewer.",
            position: [0.4, 1.7, 0.3],
            target: [2.6, 1.0, 3.0],
            fov: 70.0,
        },
        area: box_area(4.0, 2.6, 3.0) + block_area(screen) + block_area(block),
        tolerance: ROUNDING,
    }
}

pub fn glass_balls() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [3.0, 2.4, 3.0]);
    let lamp = inside([1.3, 2.4, 1.1], [1.7, 2.4, 1.5], Top);

    m.paint("floor", "sand");
    for x in 0..6 {
        for z in 0..6 {
            let corner = [0.5 * f64::from(x), 0.0, 0.5 * f64::from(z)];
            m.room(corner, plus(corner, [0.5, 0.0, 0.5]), &[Bottom]);
        }
    }
    m.paint("left_wall", "red").room(low, high, &[Left]);
    m.paint("right_wall", "blue").room(low, high, &[Right]);
    m.paint("walls", "chalk").room(low, high, &[Back, Front]);
    m.paint("ceiling", "chalk").surround(inside(low, high, Top), lamp);
    m.paint("lamp", "lamp").face(&lamp);
    m.paint("large_ball", "glass");
    ball(&mut m, [1.05, 0.52, 1.1], 0.5, 4);
    m.paint("small_ball", "glass");
    ball(&mut m, [2.1, 0.32, 1.8], 0.3, 3);

    Scene {
        name: "glass_balls",
        notes: "\
Two balls of glass, index of refraction 1.5, under a lamp of 0.4 m x 0.4 m in a closed room with a
red and a blue wall. Each gathers the lamp's light into a caustic on the floor, inside the
shadow it casts, and shows the room upside down.

Known: the lamp emits pi A Le = pi * 0.16 m2 * (60, 56, 50) = (30.159, 28.149, 25.133) W. Clear
glass absorbs nothing: the diffuse faces absorb all of it.",
        materials: vec![
            Material::matt("sand", [0.72, 0.66, 0.52]),
            Material::matt("chalk", [0.80, 0.78, 0.74]),
            Material::matt("red", [0.63, 0.12, 0.10]),
            Material::matt("blue", [0.16, 0.28, 0.62]),
            Material::glass("glass", 1.5),
            Material::glowing("lamp", [0.78, 0.78, 0.78], [60.0, 56.0, 50.0]),
        ],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From the front, down on the balls and their caustics.",
            position: [1.6, 1.5, 2.9],
            target: [1.5, 0.35, 1.2],
            fov: 55.0,
        },
        area: box_area(3.0, 2.4, 3.0) + 4.0 * PI * (0.5_f64.powi(2) + 0.3_f64.powi(2)),
        tolerance: 1e-3,
    }
}

pub fn glossy_floor() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [4.0, 2.5, 3.0]);
    let lamp = inside([1.2, 2.5, 0.5], [1.8, 2.5, 1.1], Top);
    let block = [[2.9, 1.1, 0.8], [2.5, 1.1, 1.3], [3.0, 1.1, 1.7], [3.4, 1.1, 1.2]];

    m.paint("floor", "steel").room(low, high, &[Bottom]);
    m.paint("left_wall", "red");
    for (k, l) in (0..5).flat_map(|k| (0..6).map(move |l| (f64::from(k), f64::from(l)))) {
        m.room([0.0, 0.5 * k, 0.5 * l], [4.0, 0.5 * (k + 1.0), 0.5 * (l + 1.0)], &[Left]);
    }
    m.paint("back_wall", "chalk");
    for (k, l) in (0..8).flat_map(|k| (0..5).map(move |l| (f64::from(k), f64::from(l)))) {
        m.room([0.5 * k, 0.5 * l, 0.0], [0.5 * (k + 1.0), 0.5 * (l + 1.0), 3.0], &[Back]);
    }
    m.paint("right_wall", "blue").room(low, high, &[Right]);
    m.paint("front_wall", "chalk").room(low, high, &[Front]);
    m.paint("ceiling", "chalk").surround(inside(low, high, Top), lamp);
    m.paint("lamp", "lamp").face(&lamp);
    m.paint("block", "gold").block(block);

    Scene {
        name: "glossy_floor",
        notes: "\
A closed room of 4 x 2.5 x 3 m with a floor of brushed steel and a block of dull gold. The lamp
near the back wall throws its light up that wall from the floor, and both metals show the room
the more blurred the farther away it is.

Known: the lamp emits pi A Le = pi * 0.36 m2 * (24, 22, 19) = (27.143, 24.881, 21.488) W, and
what the diffuse faces absorb and what the metals absorb add up to that.",
        materials: vec![
            Material::matt("chalk", [0.80, 0.78, 0.74]),
            Material::matt("red", [0.63, 0.12, 0.10]),
            Material::matt("blue", [0.16, 0.28, 0.62]),
            Material::metal("steel", [0.7; 3], 0.4),
            Material::metal("gold", [1.0, 0.78, 0.34], 0.5),
            Material::glowing("lamp", [0.78, 0.78, 0.78], [24.0, 22.0, 19.0]),
        ],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From the front, low over the floor, towards the back wall and the block.",
            position: [1.3, 1.1, 2.9],
            target: [2.1, 0.6, 0.4],
            fov: 60.0,
        },
        area: box_area(4.0, 2.5, 3.0) + block_area(block),
        tolerance: ROUNDING,
    }
}

pub fn sun_catcher() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [4.5, 2.8, 4.0]);
    let window = inside([0.0, 0.9, 1.0], [0.0, 2.4, 3.0], Left);
    let plinth = [[1.2, 0.5, 1.6], [0.6, 0.5, 1.6], [0.6, 0.5, 2.2], [1.2, 0.5, 2.2]];
    m.paint("window_wall", "plaster").surround(inside(low, high, Left), window);
    m.paint("floor", "oak").room(low, high, &[Bottom]);
    m.paint("ceiling", "plaster").room(low, high, &[Top]);
    m.paint("walls", "plaster").room(low, high, &[Back, Front]);
    m.paint("far_wall", "teal").room(low, high, &[Right]);
    m.paint("plinth", "walnut").block(plinth);
    m.paint("mirror", "mirror").room([0.6, 0.52, 1.6], [1.2, 1.0, 2.2], &[Bottom]);
    m.paint("ball", "glass");
    ball(&mut m, [1.3, 0.31, 2.95], 0.3, 4);

    Scene {
        name: "sun_catcher",
        notes: "\
A room, 4.5 x 2.8 x 4 m, with an open window in the wall x = 0, under the sun and a clear sky. A
mirror that lies on a plinth throws the sun at the ceiling, and a ball of glass gathers it on
the floor.

Known: the sun's middle sends light along (0.45, -0.6, 0.15), the mirror, 0.6 m x 0.6 m, lies at
y = 0.52 and is lit all over, and the ceiling is 2.28 m above it: so its picture there is
moved by 1.71 m along x and 0.57 m along z, from (2.31, 2.17) to (2.91, 2.77), and has 0.95 of
the irradiance of level ground.",
        materials: vec![
            Material::matt("plaster", [0.78, 0.76, 0.72]),
            Material::matt("oak", [0.46, 0.33, 0.22]),
            Material::matt("teal", [0.10, 0.36, 0.40]),
            Material::matt("walnut", [0.30, 0.19, 0.12]),
            Material::mirror("mirror", 0.95),
            Material::glass("glass", 1.5),
        ],
        mesh: m,
        lights: "
[[light]]
kind = \"sun\"
direction = [0.45, -0.6, 0.15] # the way its light travels
diameter = 0.533 # degrees
illuminance = 50000 # lx, of what faces it
colour = [1.0, 0.93, 0.82]

[sky]
kind = \"clear\"
sun = [-0.45, 0.6, -0.15]
illuminance = 12000 # lx, of open level ground by the sky alone
colour = [0.75, 0.9, 1.25]
ground = 0.2
",
        camera: Camera {
            about: "From the far corner, low, towards the window.",
            position: [4.2, 1.3, 0.6],
            target: [1.4, 1.2, 2.4],
            fov: 72.0,
        },
        area: box_area(4.5, 2.8, 4.0) - 1.5 * 2.0 + block_area(plinth) + 0.36 + 4.0 * PI * 0.3_f64.powi(2),
        tolerance: 1e-3,
    }
}

pub fn plastic_toys() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [3.0, 2.2, 3.6]);
    let lamp = inside([0.9, 2.2, 0.5], [1.5, 2.2, 1.1], Top);
    let tall = [[2.15, 0.9, 0.55], [1.8, 0.9, 0.75], [2.0, 0.9, 1.1], [2.35, 0.9, 0.9]];
    let low_block = [[1.45, 0.3, 1.35], [1.25, 0.3, 1.75], [1.65, 0.3, 1.95], [1.85, 0.3, 1.55]];
    let radius = 0.42;

    m.paint("floor", "varnished").room(low, high, &[Bottom]);
    m.paint("left_wall", "chalk").room(low, high, &[Left]);
    m.paint("walls", "chalk").room(low, high, &[Back, Right, Front]);
    m.paint("ceiling", "chalk").surround(inside(low, high, Top), lamp);
    m.paint("lamp", "lamp").face(&lamp);
    m.paint("tall_block", "blue").block(tall);
    m.paint("low_block", "yellow").block(low_block);
    m.paint("ball", "red");
    ball(&mut m, [0.95, radius + 0.005, 1.0], radius, 4);

    Scene {
        name: "plastic_toys",
        notes: "\
A ball and two blocks of plastic on a varnished floor: each a diffuse base under a clear coat of
index of refraction 1.5, from the smooth ball to the dull yellow block. The coats show the lamp
as highlights, the more of the room the flatter one looks, and what they reflect goes on to light
the walls.

Known: the lamp emits pi A Le = pi * 0.36 m2 * (22, 21, 19) = (24.881, 23.750, 21.488) W. Coats
absorb nothing: what the diffuse faces absorb, those under coats with them, is all of it.",
        materials: vec![
            Material::matt("chalk", [0.80, 0.78, 0.74]),
            Material::plastic("varnished", [0.36, 0.22, 0.12], 0.25),
            Material::plastic("red", [0.70, 0.06, 0.05], 0.15),
            Material::plastic("blue", [0.05, 0.17, 0.55], 0.35),
            Material::plastic("yellow", [0.80, 0.58, 0.06], 0.6),
            Material::glowing("lamp", [0.78, 0.78, 0.78], [22.0, 21.0, 19.0]),
        ],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From the front, low over the floor, so that it mirrors what stands on it.",
            position: [1.55, 0.85, 3.5],
            target: [1.55, 0.5, 0.9],
            fov: 42.0,
        },
        area: box_area(3.0, 2.2, 3.6) + block_area(tall) + block_area(low_block) + 4.0 * PI * radius * radius,
        tolerance: 1e-3,
    }
}

/// A ball seen from outside: an icosahedron with every triangle cut in four, `cuts` times, blown up to the
/// sphere.
fn ball(m: &mut Mesh, centre: Point, radius: f64, cuts: u32) {
    let mut unit = Mesh::default();
    unit.icosphere(cuts);
    for polygon in &unit.polygons {
        let corners: Vec<Point> = polygon.corners.iter().rev().map(|&k| unit.vertices[k]).collect();
        let placed: Vec<Point> = corners.iter().map(|p| plus(centre, p.map(|x| x * radius))).collect();
        m.face(&placed);
    }
}
