//! Furniture. Each piece stands on y = 0, faces +z, and returns its area by formula.

use super::areas::{box_area, walls_area};
use super::mesh::Side::*;
use super::mesh::{ALL, Mesh, STANDING, outside};

/// A table top 4 cm thick on four legs set in from its rim; centred.
pub fn table(m: &mut Mesh, name: &'static str, width: f64, height: f64, depth: f64) -> f64 {
    let (x, z, underside) = (width / 2.0, depth / 2.0, height - 0.04);
    m.paint(name, "walnut").solid([-x, underside, -z], [x, height, z], &ALL);
    m.four_legs(x - 0.03, z - 0.03, 0.06, underside);
    box_area(width, 0.04, depth) + 4.0 * walls_area(0.06, underside, 0.06)
}

/// A seat on four legs with an upright back; centred on the seat.
pub fn chair(m: &mut Mesh, name: &'static str) -> f64 {
    m.paint(name, "beech").solid([-0.21, 0.42, -0.21], [0.21, 0.46, 0.21], &ALL);
    m.four_legs(0.2, 0.2, 0.04, 0.42);
    m.solid([-0.19, 0.46, -0.2], [0.19, 0.9, -0.17], &STANDING);
    box_area(0.42, 0.04, 0.42)
        + 4.0 * walls_area(0.04, 0.42, 0.04)
        + walls_area(0.38, 0.44, 0.03)
        + 0.38 * 0.03
}

/// A bookcase with five open shelves and some books; its back is on the wall at z = 0.
pub fn bookcase(m: &mut Mesh) -> f64 {
    const SHELVES: [f64; 5] = [0.08, 0.44, 0.80, 1.16, 1.52]; // what stands on each starts here
    const BOOKS: [(usize, f64, f64, f64, &str); 8] = [
        (1, 0.10, 0.38, 0.24, "slate"), // shelf, from, to, height, colour
        (1, 0.60, 0.88, 0.20, "linen"),
        (2, 0.30, 0.52, 0.27, "brick"),
        (2, 0.58, 0.90, 0.22, "teal"),
        (3, 0.09, 0.33, 0.25, "mustard"),
        (3, 0.40, 0.62, 0.21, "slate"),
        (4, 0.14, 0.46, 0.23, "linen"),
        (4, 0.52, 0.66, 0.27, "brick"),
    ];

    // Two uprights, and between them the back panel, the plinth, the boards and the top.
    m.paint("bookcase", "walnut");
    for x in [0.0, 0.97] {
        m.solid([x, 0.0, 0.0], [x + 0.03, 1.9, 0.28], &[Left, Right, Top, Front]);
    }
    m.solid([0.03, 0.08, 0.0], [0.97, 1.87, 0.02], &[Front]);
    m.solid([0.03, 0.0, 0.02], [0.97, 0.08, 0.28], &[Top, Front]);
    for y in &SHELVES[1..] {
        m.solid([0.03, y - 0.03, 0.02], [0.97, *y, 0.28], &[Bottom, Top, Front]);
    }
    m.solid([0.03, 1.87, 0.0], [0.97, 1.9, 0.28], &[Bottom, Top, Front]);

    let mut books = 0.0;
    for (shelf, from, to, height, colour) in BOOKS {
        let y = SHELVES[shelf];
        m.paint("books", colour).solid([from, y, 0.02], [to, y + height, 0.22], &[Left, Right, Top, Front]);
        books += (to - from) * (0.2 + height) + 2.0 * 0.2 * height;
    }

    2.0 * (1.9 * (0.28 + 0.28 + 0.03) + 0.28 * 0.03) // uprights
        + 0.94 * (1.79 + 0.08 + 0.26) // back panel, plinth
        + 4.0 * 0.94 * (0.26 + 0.26 + 0.03) // boards
        + 0.94 * (0.28 + 0.28 + 0.03) // top
        + books
}

/// A sofa: a back as wide as the whole, two arms, a base with a seat flush on top, a cushion.
pub fn sofa(m: &mut Mesh) -> f64 {
    m.paint("sofa", "slate");
    m.solid([0.0, 0.0, 0.0], [1.8, 0.8, 0.2], &STANDING);
    for x in [0.02, 1.6] {
        m.solid([x, 0.0, 0.2], [x + 0.18, 0.58, 0.85], &[Left, Right, Top, Front]);
    }
    m.solid([0.2, 0.0, 0.2], [1.6, 0.26, 0.83], &[Front]);
    m.paint("sofa", "linen").solid([0.2, 0.26, 0.2], [1.6, 0.43, 0.83], &[Top, Front]);
    m.paint("cushion", "mustard").solid([0.34, 0.43, 0.2], [0.76, 0.75, 0.32], &[Left, Right, Top, Front]);
    walls_area(1.8, 0.8, 0.2) + 1.8 * 0.2 // back
        + 2.0 * (0.58 * (0.65 + 0.65 + 0.18) + 0.65 * 0.18) // arms
        + 1.4 * (0.26 + 0.17 + 0.63) // base and seat
        + 0.32 * (0.12 + 0.12 + 0.42) + 0.42 * 0.12 // cushion
}

/// A framed picture, 1.1 x 0.7 m, centred on the origin and hung on the wall at z = 0.
pub fn picture(m: &mut Mesh) -> f64 {
    let (low, high) = ([-0.55, -0.35, 0.0], [0.55, 0.35, 0.03]);
    let canvas = outside([-0.49, -0.29, 0.03], [0.49, 0.29, 0.03], Front);
    m.paint("picture", "walnut").solid(low, high, &[Left, Right, Bottom, Top]);
    m.surround(outside(low, high, Front), canvas);
    m.paint("picture", "teal").face(&canvas);
    box_area(1.1, 0.7, 0.03) - 1.1 * 0.7
}
