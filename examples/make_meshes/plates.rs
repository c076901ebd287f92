//! Two plates that face each other.

use super::mesh::Mesh;
use super::mesh::Side::*;
use super::scene::{Camera, Material, ROUNDING, Scene};

pub fn facing_plates() -> Scene {
    let mut m = Mesh::default();
    m.paint("lower_plate", "glowing").room([0.0; 3], [1.0; 3], &[Bottom]);
    m.paint("upper_plate", "pale").room([0.0; 3], [1.0; 3], &[Top]);

    Scene {
        name: "facing_plates",
        notes: "\
Two unit squares face each other at distance 1; the lower one glows, all else is open.

The form factor between identical, parallel, directly opposed rectangles of sides X and
Y times their distance is (Howell, A Catalog of Radiation Heat Transfer Configuration
Factors, C-11)

    F = 2 / (pi X Y) { ln sqrt[(1 + X^2)(1 + Y^2) / (1 + X^2 + Y^2)]
                       + X sqrt(1 + Y^2) atan[X / sqrt(1 + Y^2)] - X atan X
                       + Y sqrt(1 + X^2) atan[Y / sqrt(1 + X^2)] - Y atan Y },

here, with X = Y = 1,

    F = 2 / pi [ln(4/3) / 2 + 2 sqrt(2) atan(1 / sqrt(2)) - pi / 2] = 0.199824895698387.

The rest, 1 - F = 0.800175104301613, escapes. With one patch per plate (that is, radiance
held constant over each plate; 1 = lower, 2 = upper)

    L1 = Le + rho1 F L2,    L2 = rho2 F L1,

so with Le = 1, rho1 = 0.5, rho2 = 0.8

    L1 = 1 / (1 - 0.4 F^2)     = 1.016231240883946,
    L2 = 0.8 F / (1 - 0.4 F^2) = 0.162454641372062,

and of the pi = 3.141593 W emitted 0.178584 W are absorbed and 2.963009 W escape. In truth
irradiance is higher at the middle of a plate than at its rim, so the mean radiances of a
finer mesh differ slightly from these.",
        materials: vec![Material::glowing("glowing", [0.5; 3], [1.0; 3]), Material::matt("pale", [0.8; 3])],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "From outside at half height, where the inner sides of both plates show.",
            position: [1.5, 0.54, 2.9],
            target: [0.5, 0.5, 0.5],
            fov: 36.0,
        },
        area: 2.0,
        tolerance: ROUNDING,
    }
}
