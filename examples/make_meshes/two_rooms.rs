//! Two rooms joined by a doorway.

use super::areas::box_area;
use super::mesh::Side::*;
use super::mesh::{Mesh, inside, reversed};
use super::scene::{Camera, Material, ROUNDING, Scene};

pub fn two_rooms() -> Scene {
    let mut m = Mesh::default();
    let (width, height, depth) = (4.0, 2.6, 4.0);
    let (east, far_end) = (4.2, 8.2); // the second room starts beyond a wall 0.2 m thick
    let (door_from, door_to, door_top) = (1.0, 1.9, 2.1);

    // The floors have two corners more, where the door jambs stand. They are fanned from a corner
    // on the far side, so that no triangle degenerates.
    m.paint("lit_floor", "oak").face(&[
        [0.0, 0.0, 0.0],
        [0.0, 0.0, depth],
        [width, 0.0, depth],
        [width, 0.0, door_to],
        [width, 0.0, door_from],
        [width, 0.0, 0.0],
    ]);
    m.paint("dark_floor", "oak").face(&[
        [far_end, 0.0, depth],
        [far_end, 0.0, 0.0],
        [east, 0.0, 0.0],
        [east, 0.0, door_from],
        [east, 0.0, door_to],
        [east, 0.0, depth],
    ]);

    // The partition is three quads around the door, once for each room.
    let partition = |x| {
        [
            [[x, 0.0, 0.0], [x, 0.0, door_from], [x, door_top, door_from], [x, height, 0.0]],
            [[x, height, 0.0], [x, door_top, door_from], [x, door_top, door_to], [x, height, depth]],
            [[x, height, depth], [x, door_top, door_to], [x, 0.0, door_to], [x, 0.0, depth]],
        ]
    };
    m.paint("lit_partition", "chalk");
    partition(width).iter().for_each(|quad| m.face(quad));
    m.paint("dark_partition", "chalk");
    partition(east).iter().for_each(|&quad| m.face(&reversed(quad)));
    let (low, high) = ([width, 0.0, door_from], [east, door_top, door_to]);
    m.paint("doorway", "chalk").room(low, high, &[Bottom, Top, Back, Front]);

    // Each room's other sides; the lamp fills a hole in the lit room's ceiling.
    let (low, high) = ([0.0; 3], [width, height, depth]);
    let lamp = inside([1.4, height, 1.7], [2.6, height, 2.3], Top);
    m.paint("lit_walls", "chalk").room(low, high, &[Left, Front]);
    m.paint("lit_back_wall", "terracotta").room(low, high, &[Back]);
    m.paint("lit_ceiling", "chalk").surround(inside(low, high, Top), lamp);
    m.paint("lamp", "lamp").face(&lamp);

    let (low, high) = ([east, 0.0, 0.0], [far_end, height, depth]);
    m.paint("dark_walls", "chalk").room(low, high, &[Right, Front]);
    m.paint("dark_back_wall", "blue").room(low, high, &[Back]);
    m.paint("dark_ceiling", "chalk").room(low, high, &[Top]);

    Scene {
        name: "two_rooms",
        notes: "\
Two closed rooms, 4 x 2.6 x 4 m each, joined by a doorway 0.9 m wide and 2.1 m high in a
wall 0.2 m thick. Only the first room has a lamp: the second lives on what comes through
the door, most of it after several bounces. The series converges slowly here, and a leak
shows.

Both rooms and the doorway form one closed surface: nothing escapes, every row of form
factors sums to 1.

Known: the lamp emits pi A Le = pi * 0.72 m2 * (15, 14, 12) = (33.929, 31.667, 27.143) W,
and all of it is absorbed: the sum of A (1 - rho) H over all faces is exactly that.",
        materials: vec![
            Material::matt("chalk", [0.80, 0.78, 0.74]),
            Material::matt("oak", [0.45, 0.32, 0.21]),
            Material::matt("terracotta", [0.66, 0.27, 0.16]),
            Material::matt("blue", [0.24, 0.44, 0.68]),
            Material::glowing("lamp", [0.78, 0.78, 0.78], [15.0, 14.0, 12.0]),
        ],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From a corner of the dark room through the door into the lit one.",
            position: [7.95, 2.2, 3.7],
            target: [4.6, 1.05, 1.1],
            fov: 58.0,
        },
        area: 2.0 * box_area(4.0, 2.6, 4.0) - 2.0 * 0.9 * 2.1 + 0.2 * 2.0 * (0.9 + 2.1),
        tolerance: ROUNDING,
    }
}
