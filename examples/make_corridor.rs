//! Builds the folded corridor of the comparison with an independent renderer, where light turns corners:
//!
//! ```text
//! cargo run --release --example make_corridor              # into tests/data/
//! cargo run --release --example make_corridor -- FOLDER    # somewhere else
//! ```
//!
//! Three legs, each 3 m long, 1 m wide and 1 m high, lie side by side; an open sheet stands between one leg
//! and the next and leaves the last metre free, left and right in turn. All is white (ρ = 0.9). The lamp is
//! the end of the first leg; light that gets to the end of the third has turned twice. Every face is a metre
//! long and wide, so that values by face tell places apart. Lengths are metres and y points up.

use std::path::PathBuf;
use std::{env, fs, io};

/// A square of a metre: two faces.
type Square = [[u32; 3]; 4];

const NOTES: &str = "\
# A folded corridor: three legs of 3 m x 1 m x 1 m side by side, open sheets between them, all white, lit at one end.
# Known: reflectance 0.9 everywhere but on the lamp, nothing escapes; corridor.csv has irradiance by face and side.
";

const MATERIALS: &str = "\
newmtl white
Kd 0.9 0.9 0.9
illum 1
newmtl lamp
Kd 0.5 0.5 0.5
Ke 10 10 10
illum 1
";

fn main() -> io::Result<()> {
    let folder = env::args_os().nth(1).map_or("tests/data".into(), PathBuf::from);
    let (floors, walls, sheets, lamp) = (floors_and_ceilings(), walls(), sheets(), LAMP);
    let mut obj = format!("{NOTES}mtllib corridor.mtl\n");
    let mut vertices: Vec<[u32; 3]> = Vec::new();
    let mut faces = String::new();
    let objects = [("floor_and_ceiling", floors), ("walls", walls), ("sheets", sheets), ("lamp", vec![lamp])];
    for (name, squares) in objects {
        let material = if name == "lamp" { "lamp" } else { "white" };
        faces += &format!("o {name}\nusemtl {material}\n");
        for square in squares {
            let corners = square.map(|corner| place_of(corner, &mut vertices).to_string());
            faces += &format!("f {}\n", corners.join(" "));
        }
    }
    vertices.iter().for_each(|[x, y, z]| obj += &format!("v {x} {y} {z}\n"));
    fs::write(folder.join("corridor.obj"), obj + &faces)?;
    fs::write(folder.join("corridor.mtl"), MATERIALS)
}

/// The end of the first leg; it fronts inward, as all walls do.
const LAMP: Square = [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]];

fn floors_and_ceilings() -> Vec<Square> {
    let cells = (0..3).flat_map(|x| (0..3).map(move |z| (x, z)));
    let both = cells.flat_map(|(x, z)| {
        let floor = [[x, 0, z], [x, 0, z + 1], [x + 1, 0, z + 1], [x + 1, 0, z]];
        let ceiling = [[x, 1, z], [x + 1, 1, z], [x + 1, 1, z + 1], [x, 1, z + 1]];
        [floor, ceiling]
    });
    both.collect()
}

/// The four outer walls, without the lamp.
fn walls() -> Vec<Square> {
    let along = (0..3).flat_map(|k| {
        let low_x = [[0, 0, k], [0, 1, k], [0, 1, k + 1], [0, 0, k + 1]];
        let high_x = [[3, 0, k], [3, 0, k + 1], [3, 1, k + 1], [3, 1, k]];
        let low_z = [[k, 0, 0], [k + 1, 0, 0], [k + 1, 1, 0], [k, 1, 0]];
        let high_z = [[k, 0, 3], [k, 1, 3], [k + 1, 1, 3], [k + 1, 0, 3]];
        [low_x, high_x, low_z, high_z]
    });
    along.filter(|&wall| wall != LAMP).collect()
}

/// Between the legs: from the left with the right end free, then from the right with the left end free.
fn sheets() -> Vec<Square> {
    let sheet = |x: u32, z: u32| [[x, 0, z], [x + 1, 0, z], [x + 1, 1, z], [x, 1, z]];
    vec![sheet(0, 1), sheet(1, 1), sheet(1, 2), sheet(2, 2)]
}

/// The number of a vertex, from 1; squares that meet share theirs.
fn place_of(corner: [u32; 3], vertices: &mut Vec<[u32; 3]>) -> usize {
    let known = vertices.iter().position(|&vertex| vertex == corner);
    known.unwrap_or_else(|| {
        vertices.push(corner);
        vertices.len() - 1
    }) + 1
}
