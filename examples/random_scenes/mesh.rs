//! Meshes as text: boxes, quadrilaterals and materials, written as OBJ, MTL and TOML.

use std::fmt::Write as _;

use glam::{DMat3, DVec3};

/// Corners, counter-clockwise seen from the front, metres.
pub type Quad = [DVec3; 4];

/// A box: `low` to `high` along `axes` around `origin`.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    pub origin: DVec3,
    pub axes: DMat3,
    pub low: DVec3,
    pub high: DVec3,
}

impl Block {
    /// A box along the axes of the room.
    pub fn upright(low: DVec3, high: DVec3) -> Self {
        Self { origin: DVec3::ZERO, axes: DMat3::IDENTITY, low, high }
    }

    /// The same box, each side moved outward by `by`.
    pub fn grown(self, by: DVec3) -> Self {
        Self { low: self.low - by, high: self.high + by, ..self }
    }

    /// Its six sides, which front outward: x, y, z at the low end, then at the high end.
    pub fn sides(&self) -> [Quad; 6] {
        let at = |x: usize, y: usize, z: usize| {
            let ends = [self.low, self.high];
            self.origin + self.axes * DVec3::new(ends[x].x, ends[y].y, ends[z].z)
        };
        [
            [at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)],
            [at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)],
            [at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)],
            [at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)],
            [at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0)],
            [at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)],
        ]
    }
}

/// The side across.
pub fn flipped([a, b, c, d]: Quad) -> Quad {
    [a, d, c, b]
}

/// What a surface is made of; colours are red, green, blue.
#[derive(Clone, Copy, Debug)]
pub enum Finish {
    Diffuse([f64; 3]),
    Mirror([f64; 3]),
    Glass([f64; 3]),
    Pane([f64; 3]),
    /// Colour and roughness.
    Metal([f64; 3], f64),
    /// Colour and roughness.
    Plastic([f64; 3], f64),
    /// Reflectance and transmittance.
    Sheet([f64; 3], [f64; 3]),
    /// Reflectance and emitted radiance, W·sr⁻¹·m⁻².
    Lamp([f64; 3], [f64; 3]),
}

/// An object with one material.
#[derive(Clone, Debug)]
pub struct Object {
    pub name: String,
    pub finish: Finish,
    pub quads: Vec<Quad>,
}

/// The text of an OBJ file that names `scene.mtl`.
pub fn obj(objects: &[Object]) -> String {
    let mut text = String::from("mtllib scene.mtl\n");
    let mut vertices = 0;
    for Object { name, quads, .. } in objects {
        let _ = write!(text, "o {name}\nusemtl {name}\n");
        for quad in quads {
            quad.iter().for_each(|p| {
                let _ = writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z);
            });
            let [a, b, c, d] = [1, 2, 3, 4].map(|k| vertices + k);
            let _ = writeln!(text, "f {a} {b} {c} {d}");
            vertices += 4;
        }
    }
    text
}

/// The text of the MTL file: a material for each object, of its name.
pub fn mtl(objects: &[Object]) -> String {
    let mut text = String::new();
    let rgb = |[r, g, b]: [f64; 3]| format!("{r:?} {g:?} {b:?}");
    for Object { name, finish, .. } in objects {
        let _ = match *finish {
            Finish::Diffuse(kd) | Finish::Sheet(kd, _) => writeln!(text, "newmtl {name}\nKd {}", rgb(kd)),
            Finish::Mirror(ks) => writeln!(text, "newmtl {name}\nillum 3\nKs {}", rgb(ks)),
            Finish::Glass(tf) | Finish::Pane(tf) => {
                writeln!(text, "newmtl {name}\nillum 4\nNi 1.5\nTf {}", rgb(tf))
            }
            Finish::Metal(kd, pr) => writeln!(text, "newmtl {name}\nPm 1\nPr {pr:?}\nKd {}", rgb(kd)),
            Finish::Plastic(kd, pr) => writeln!(text, "newmtl {name}\nNi 1.5\nPr {pr:?}\nKd {}", rgb(kd)),
            Finish::Lamp(kd, ke) => writeln!(text, "newmtl {name}\nKd {}\nKe {}", rgb(kd), rgb(ke)),
        };
    }
    text
}

/// The text of the TOML file: what OBJ cannot say of panes and sheets.
pub fn toml(objects: &[Object]) -> String {
    let mut text = String::new();
    for Object { name, finish, .. } in objects {
        let _ = match finish {
            Finish::Pane(_) => writeln!(text, "[material.{name}]\nthin = true"),
            Finish::Sheet(_, through) => writeln!(text, "[material.{name}]\ntransmittance = {through:?}"),
            _ => Ok(()),
        };
    }
    text
}
