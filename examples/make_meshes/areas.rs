//! Areas by formula, which know nothing of any mesh.

use super::mesh::{Point, Quad};

/// All six sides of a box.
pub fn box_area(width: f64, height: f64, depth: f64) -> f64 {
    walls_area(width, height, depth) + 2.0 * width * depth
}

/// The four upright sides of a box: perimeter times height.
pub fn walls_area(width: f64, height: f64, depth: f64) -> f64 {
    2.0 * (width + depth) * height
}

/// Top and walls of a block on the floor: half the cross product of the top's diagonals, and
/// perimeter times height.
pub fn block_area([a, b, c, d]: Quad) -> f64 {
    let side = |p: Point, q: Point| (q[0] - p[0]).hypot(q[2] - p[2]);
    let top = (c[0] - a[0]) * (d[2] - b[2]) - (c[2] - a[2]) * (d[0] - b[0]);
    top.abs() / 2.0 + (side(a, b) + side(b, c) + side(c, d) + side(d, a)) * a[1]
}
