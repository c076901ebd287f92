//! A scene, and how it is written: shape as OBJ, paint as MTL, camera and lights as TOML.

use std::fmt::Write as _;
use std::path::Path;
use std::{fs, io};

use super::mesh::{Mesh, Point};

/// Tolerance on the area of scenes made of flat faces only: rounding, nothing else.
pub const ROUNDING: f64 = 1e-9;

pub struct Scene {
    pub name: &'static str,
    /// What the scene is for and what is known about its answer: the head of the OBJ file.
    pub notes: &'static str,
    pub materials: Vec<Material>,
    pub mesh: Mesh,
    /// Lights without area and the sky, as the TOML file says them.
    pub lights: &'static str,
    pub camera: Camera,
    /// The area by formula, m², and how far the mesh may be from it, relative.
    pub area: f64,
    pub tolerance: f64,
}

/// Diffuse reflectance, and emitted radiance of the front in W/(sr m²); or what a mirror, metal or glass is.
pub struct Material {
    name: &'static str,
    reflectance: [f64; 3],
    radiance: Option<[f64; 3]>,
    finish: Finish,
    /// The entry that names a picture, and its file.
    picture: Option<(&'static str, &'static str)>,
}

enum Finish {
    Matt,
    /// Reflectance.
    Mirror(f64),
    /// Index of refraction.
    Glass(f64),
    /// Roughness; its reflectance is the material's.
    Metal(f64),
    /// Roughness of the coat over it, of index of refraction 1.5.
    Plastic(f64),
}

impl Material {
    pub fn matt(name: &'static str, reflectance: [f64; 3]) -> Material {
        Material { name, reflectance, radiance: None, finish: Finish::Matt, picture: None }
    }

    pub fn glowing(name: &'static str, reflectance: [f64; 3], radiance: [f64; 3]) -> Material {
        Material { radiance: Some(radiance), ..Material::matt(name, reflectance) }
    }

    pub fn with_picture(self, key: &'static str, file: &'static str) -> Material {
        Material { picture: Some((key, file)), ..self }
    }

    pub fn mirror(name: &'static str, reflectance: f64) -> Material {
        Material { finish: Finish::Mirror(reflectance), ..Material::matt(name, [0.0; 3]) }
    }

    pub fn metal(name: &'static str, reflectance: [f64; 3], roughness: f64) -> Material {
        Material { finish: Finish::Metal(roughness), ..Material::matt(name, reflectance) }
    }

    pub fn plastic(name: &'static str, reflectance: [f64; 3], roughness: f64) -> Material {
        Material { finish: Finish::Plastic(roughness), ..Material::matt(name, reflectance) }
    }

    pub fn glass(name: &'static str, index: f64) -> Material {
        Material { finish: Finish::Glass(index), ..Material::matt(name, [0.0; 3]) }
    }
}

pub struct Camera {
    pub about: &'static str,
    pub position: Point,
    pub target: Point,
    /// Vertical field of view, degrees.
    pub fov: f64,
}

impl Scene {
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        let save =
            |ending: &str, text: String| fs::write(folder.join(format!("{}.{ending}", self.name)), text);
        save("obj", self.obj())?;
        save("mtl", self.mtl())?;
        save("toml", self.toml())
    }

    fn obj(&self) -> String {
        let mut text = String::new();
        for line in self.notes.lines() {
            text += format!("# {line}").trim_end();
            text += "\n";
        }
        let _ = writeln!(text, "\nmtllib {}.mtl\n", self.name);
        for [x, y, z] in &self.mesh.vertices {
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        for [u, v] in &self.mesh.coordinates {
            let _ = writeln!(text, "vt {u} {v}");
        }
        let (mut object, mut material) = ("", "");
        for polygon in &self.mesh.polygons {
            if polygon.object != object {
                (object, material) = (polygon.object, "");
                let _ = writeln!(text, "\no {object}");
            }
            if polygon.material != material {
                material = polygon.material;
                let _ = writeln!(text, "usemtl {material}");
            }
            text += "f";
            for (k, corner) in polygon.corners.iter().enumerate() {
                let _ = match polygon.coordinates.get(k) {
                    Some(at) => write!(text, " {}/{}", corner + 1, at + 1),
                    None => write!(text, " {}", corner + 1),
                };
            }
            text += "\n";
        }
        text
    }

    fn mtl(&self) -> String {
        let mut text = String::from(
            "# Kd: diffuse reflectance. Ke: radiance emitted by the front, W/(sr m2). Linear RGB.\n",
        );
        for Material { name, reflectance: [r, g, b], radiance, finish, picture } in &self.materials {
            let _ = writeln!(text, "\nnewmtl {name}\nKd {r} {g} {b}");
            if let Some([r, g, b]) = radiance {
                let _ = writeln!(text, "Ke {r} {g} {b}");
            }
            if let Some((key, file)) = picture {
                let _ = writeln!(text, "{key} {file}");
            }
            let _ = match finish {
                Finish::Matt => writeln!(text, "illum 1"),
                Finish::Mirror(ks) => writeln!(text, "Ks {ks} {ks} {ks}\nillum 3"),
                Finish::Glass(ni) => writeln!(text, "Ni {ni}\nTf 1 1 1\nillum 4"),
                Finish::Metal(roughness) => writeln!(text, "Pm 1\nPr {roughness}\nillum 2"),
                Finish::Plastic(roughness) => writeln!(text, "Pr {roughness}\nNi 1.5\nillum 2"),
            };
        }
        text
    }

    fn toml(&self) -> String {
        let Camera { about, position, target, fov } = self.camera;
        format!(
            "# {about}\n\n[camera]\nposition = {position:?}\ntarget = {target:?}\n\
             up = [0.0, 1.0, 0.0]\nfov = {fov:?} # vertical, degrees\n{}",
            self.lights
        )
    }
}
