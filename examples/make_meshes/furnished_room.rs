//! A living room full of furniture.

use super::areas::box_area;
use super::furniture::{bookcase, chair, picture, sofa, table};
use super::mesh::Side::*;
use super::mesh::{Mesh, inside};
use super::scene::{Camera, Material, ROUNDING, Scene};

pub fn furnished_room() -> Scene {
    let mut m = Mesh::default();
    let (low, high) = ([0.0; 3], [5.0, 2.7, 4.0]);

    // The rug is a part of the floor in another colour, the lamp a part of the ceiling.
    let rug = inside([1.9, 0.0, 1.2], [3.9, 0.0, 2.5], Bottom);
    m.paint("floor", "oak").surround(inside(low, high, Bottom), rug);
    m.paint("rug", "brick").face(&rug);
    let lamp = inside([1.9, 2.7, 1.7], [3.1, 2.7, 2.3], Top);
    m.paint("ceiling", "ceiling").surround(inside(low, high, Top), lamp);
    m.paint("lamp", "lamp").face(&lamp);
    m.paint("walls", "plaster").room(low, high, &[Right, Back, Front]);
    m.paint("left_wall", "sage").room(low, high, &[Left]);

    // The chairs are turned to face along (7, 24) / 25: a true unit vector whose decimals end.
    let area = box_area(5.0, 2.7, 4.0)
        + m.placed([1.05, 0.0, 2.95], [0.0, 1.0], |m| table(m, "dining_table", 1.1, 0.75, 0.75))
        + m.placed([2.9, 0.0, 1.8], [0.0, 1.0], |m| table(m, "coffee_table", 0.9, 0.4, 0.5))
        + m.placed([1.05, 0.0, 2.45], [0.28, 0.96], |m| chair(m, "chair_1"))
        + m.placed([1.75, 0.0, 3.0], [-0.96, -0.28], |m| chair(m, "chair_2"))
        + m.placed([0.0, 0.0, 1.6], [1.0, 0.0], bookcase)
        + m.placed([2.0, 0.0, 0.1], [0.0, 1.0], sofa)
        + m.placed([2.9, 1.65, 0.0], [0.0, 1.0], picture);

    Scene {
        name: "furnished_room",
        notes: "\
A living room, 5 x 2.7 x 4 m, closed, lit by one ceiling panel: tables and chairs with thin
legs, a bookcase with open shelves, a sofa, a rug, a picture. This is what daily work looks
like: narrow gaps, hidden undersides, large walls beside small parts.

Walls, floor with rug and ceiling with lamp are one closed surface. Furniture stands on the
floor or against a wall and leaves out the sides that touch.

Known: the lamp emits pi A Le = pi * 0.72 m2 * (12, 11, 9) = (27.143, 24.881, 20.358) W, and
all of it is absorbed: the sum of A (1 - rho) H over all faces is exactly that. There is no
closed form for the light itself; hold it against a path tracer.",
        materials: vec![
            Material::matt("plaster", [0.76, 0.73, 0.67]),
            Material::matt("sage", [0.46, 0.53, 0.43]),
            Material::matt("ceiling", [0.84, 0.84, 0.82]),
            Material::matt("oak", [0.46, 0.33, 0.22]),
            Material::matt("walnut", [0.30, 0.19, 0.12]),
            Material::matt("beech", [0.62, 0.47, 0.31]),
            Material::matt("brick", [0.58, 0.18, 0.12]),
            Material::matt("slate", [0.25, 0.33, 0.40]),
            Material::matt("mustard", [0.78, 0.52, 0.08]),
            Material::matt("linen", [0.68, 0.64, 0.56]),
            Material::matt("teal", [0.08, 0.36, 0.38]),
            Material::glowing("lamp", [0.78, 0.78, 0.78], [12.0, 11.0, 9.0]),
        ],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From a corner just below the ceiling across the whole room.",
            position: [4.8, 2.3, 3.8],
            target: [1.95, 0.75, 1.45],
            fov: 54.0,
        },
        area,
        tolerance: ROUNDING,
    }
}
