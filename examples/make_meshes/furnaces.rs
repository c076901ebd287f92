//! The furnaces, in which every answer is known: a cube and a sphere.

use std::f64::consts::PI;

use super::mesh::{ALL, Mesh};
use super::scene::{Camera, Material, ROUNDING, Scene};

pub fn furnace_cube() -> Scene {
    let mut m = Mesh::default();
    m.paint("cube", "grey").room([0.0; 3], [1.0; 3], &ALL);

    Scene {
        name: "furnace_cube",
        notes: "\
The furnace: a closed unit cube seen from inside, the same grey glow everywhere.

Known exactly, for every mesh and every set of form factors whose rows sum to 1:
with one Le and one reflectance rho the solution is constant, and L = Le + rho L gives

    L = Le / (1 - rho) = 1 / (1 - 0.5) = 2    on every patch,

and after k bounces L_k = Le (1 - rho^(k+1)) / (1 - rho) = 1, 1.5, 1.75, 1.875, ...
Irradiance is 2 pi. Whatever differs from these numbers is a row sum that is not 1.",
        materials: vec![Material::glowing("grey", [0.5; 3], [1.0; 3])],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From one corner of the cube to the opposite one; a right picture is blank.",
            position: [0.9, 0.9, 0.9],
            target: [0.2, 0.2, 0.2],
            fov: 60.0,
        },
        area: 6.0,
        tolerance: ROUNDING,
    }
}

pub fn furnace_sphere() -> Scene {
    let mut m = Mesh::default();
    m.paint("sphere", "grey").icosphere(3);

    Scene {
        name: "furnace_sphere",
        notes: "\
The furnace in the round: an icosahedron cut three times and blown up to the unit
sphere, 1280 triangles that front inward, the same grey glow everywhere.

Known exactly, as in any closed furnace: L = Le / (1 - rho) = 0.3 / 0.3 = 1 on every
patch, order k is 1 - 0.7^(k+1), irradiance is pi.

Known nearly: in a true sphere every patch sees every other by its share of the area,
F_ij = A_j / (4 pi r^2), wherever the two lie. The mesh is inscribed, so its area falls
short of 4 pi by 0.48 %, and flat triangles do not see themselves.",
        materials: vec![Material::glowing("grey", [0.7; 3], [0.3; 3])],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From near the shell through the centre; a right picture is blank.",
            position: [0.0, 0.0, 0.9],
            target: [0.0, 0.0, 0.0],
            fov: 60.0,
        },
        area: 4.0 * PI,
        tolerance: 0.01,
    }
}
