//! Builds the example scenes and writes each as OBJ (shape), MTL (paint) and TOML (camera, lights):
//!
//! ```text
//! cargo run --release --example make_meshes              # into meshes/
//! cargo run --release --example make_meshes -- FOLDER    # somewhere else
//! ```
//!
//! Lengths are metres and y points up. A face's front is the side from which its corners run
//! counter-clockwise; rooms front inward, furniture outward, and only the front of a lamp shines.
//! Walls that meet share their corners, so a closed room is closed to the last bit. Where two
//! solids touch, the smaller one leaves out the side that is hidden, so no two faces overlap.
//!
//! At the end every mesh's area is held against a formula that knows nothing of the mesh.

mod carriers;
mod lit;
mod measured;
mod sheets;
mod textured;

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs, io};

use Side::*;

fn main() -> io::Result<ExitCode> {
    let folder = env::args_os().nth(1).map_or("meshes".into(), PathBuf::from);
    fs::create_dir_all(&folder)?;

    let scenes = [
        cornell_box(),
        furnace_cube(),
        furnace_sphere(),
        facing_plates(),
        two_rooms(),
        furnished_room(),
        carriers::mirror_room(),
        carriers::glass_balls(),
        carriers::glossy_floor(),
        carriers::sun_catcher(),
        carriers::plastic_toys(),
        lit::daylit_room(),
        lit::spot_gallery(),
        sheets::blinds(),
        textured::textured_room(),
        measured::office(),
        measured::pavilion(),
    ];
    textured::write_pictures(&folder)?;
    measured::write_files(&folder)?;
    let mut all_right = true;
    for scene in &scenes {
        scene.write(&folder)?;

        // Hold the area of what was written against the formula.
        let (faces, area) = (scene.mesh.face_count(), scene.mesh.area());
        let shortfall = 1.0 - area / scene.area;
        let right = shortfall.abs() <= scene.tolerance;
        all_right &= right;
        println!(
            "{:<15}{faces:>5} faces {area:>11.6} m², by formula {:>10.6} m², short by {shortfall:>8.1e}{}",
            scene.name,
            scene.area,
            if right { "" } else { "  MISMATCH" },
        );
    }
    Ok(if all_right { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

// ---------------------------------------------------------------------------------------------
// The scenes
// ---------------------------------------------------------------------------------------------

/// Tolerance on the area of scenes made of flat faces only: rounding, nothing else.
const ROUNDING: f64 = 1e-9;

fn cornell_box() -> Scene {
    let mut m = Mesh::default();

    // The published corners are as measured, not as intended: the walls lean a little.
    let [floor, ceiling, lamp, short, tall] = [
        [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]],
        [[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]],
        [[343.0, 548.8, 227.0], [343.0, 548.8, 332.0], [213.0, 548.8, 332.0], [213.0, 548.8, 227.0]],
        [[130.0, 165.0, 65.0], [82.0, 165.0, 225.0], [240.0, 165.0, 272.0], [290.0, 165.0, 114.0]],
        [[423.0, 330.0, 247.0], [265.0, 330.0, 296.0], [314.0, 330.0, 456.0], [472.0, 330.0, 406.0]],
    ]
    .map(|corners| corners.map(|point: Point| point.map(|x| x / 100.0)));

    m.paint("floor", "white").face(&floor);
    m.paint("light", "light").face(&lamp);
    m.paint("ceiling", "white").surround(ceiling, lamp);
    m.paint("back_wall", "white").face(&[floor[3], floor[2], ceiling[2], ceiling[1]]);
    m.paint("right_wall", "green").face(&[floor[2], floor[1], ceiling[3], ceiling[2]]);
    m.paint("left_wall", "red").face(&[floor[0], floor[3], ceiling[1], ceiling[0]]);
    m.paint("short_block", "white").block(short);
    m.paint("tall_block", "white").block(tall);

    // The red wall's four corners lie in no plane: it is two triangles, |a × b| / 2 each.
    let red = (5.592_f64 * 5.488).hypot(5.592 * 0.064).hypot(0.032 * 5.488) / 2.0
        + 5.592 * 5.488_f64.hypot(0.032) / 2.0;
    let area = (5.528 + 5.496) / 2.0 * 5.592 // floor
        + 5.56 * 5.592 // ceiling and lamp
        + (5.496 + 5.56) / 2.0 * 5.488 // back wall
        + 5.592 * 5.488 // green wall
        + red
        + block_area(short)
        + block_area(tall);

    Scene {
        name: "cornell_box",
        notes: "\
The Cornell box: the picture every renderer is first asked for.

Geometry: Cornell University Program of Computer Graphics, Cornell Box Data,
https://www.graphics.cornell.edu/online/box/data.html. The published lengths
(millimetres; the real box is 0.55 m wide) are divided by 100, as is customary,
so read in metres the box is ten times its real size. Radiance does not change
with the scale of a scene, power grows with its square.

Colours: customary RGB values for the measured spectra, white as a neutral 0.74.
The front (z = 0) is open: what leaves there is lost. The lamp fills a hole in
the ceiling; the blocks stand on the floor and have no underside.

Known: the lamp emits pi A Le = pi * 1.365 m2 * (17, 12, 4) = (72.901, 51.459,
17.153) W, and absorbed + escaped must add up to that. There is no closed form for
the light itself; hold it against a path tracer.",
        materials: vec![
            Material::matt("white", [0.74, 0.74, 0.74]),
            Material::matt("red", [0.63, 0.065, 0.05]),
            Material::matt("green", [0.14, 0.45, 0.091]),
            Material::glowing("light", [0.78, 0.78, 0.78], [17.0, 12.0, 4.0]),
        ],
        mesh: m,
        lights: "",
        camera: Camera {
            about: "The published camera: focal length 35 mm before a film 25 mm high.",
            position: [2.78, 2.73, -8.0],
            target: [2.78, 2.73, 0.0],
            fov: 39.3,
        },
        area,
        tolerance: ROUNDING,
    }
}

fn furnace_cube() -> Scene {
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

fn furnace_sphere() -> Scene {
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

fn facing_plates() -> Scene {
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

fn two_rooms() -> Scene {
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

fn furnished_room() -> Scene {
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

// ---------------------------------------------------------------------------------------------
// Furniture. Each piece stands on y = 0, faces +z, and returns its area by formula.
// ---------------------------------------------------------------------------------------------

/// A table top 4 cm thick on four legs set in from its rim; centred.
fn table(m: &mut Mesh, name: &'static str, width: f64, height: f64, depth: f64) -> f64 {
    let (x, z, underside) = (width / 2.0, depth / 2.0, height - 0.04);
    m.paint(name, "walnut").solid([-x, underside, -z], [x, height, z], &ALL);
    m.four_legs(x - 0.03, z - 0.03, 0.06, underside);
    box_area(width, 0.04, depth) + 4.0 * walls_area(0.06, underside, 0.06)
}

/// A seat on four legs with an upright back; centred on the seat.
fn chair(m: &mut Mesh, name: &'static str) -> f64 {
    m.paint(name, "beech").solid([-0.21, 0.42, -0.21], [0.21, 0.46, 0.21], &ALL);
    m.four_legs(0.2, 0.2, 0.04, 0.42);
    m.solid([-0.19, 0.46, -0.2], [0.19, 0.9, -0.17], &STANDING);
    box_area(0.42, 0.04, 0.42)
        + 4.0 * walls_area(0.04, 0.42, 0.04)
        + walls_area(0.38, 0.44, 0.03)
        + 0.38 * 0.03
}

/// A bookcase with five open shelves and some books; its back is on the wall at z = 0.
fn bookcase(m: &mut Mesh) -> f64 {
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
fn sofa(m: &mut Mesh) -> f64 {
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
fn picture(m: &mut Mesh) -> f64 {
    let (low, high) = ([-0.55, -0.35, 0.0], [0.55, 0.35, 0.03]);
    let canvas = outside([-0.49, -0.29, 0.03], [0.49, 0.29, 0.03], Front);
    m.paint("picture", "walnut").solid(low, high, &[Left, Right, Bottom, Top]);
    m.surround(outside(low, high, Front), canvas);
    m.paint("picture", "teal").face(&canvas);
    box_area(1.1, 0.7, 0.03) - 1.1 * 0.7
}

// ---------------------------------------------------------------------------------------------
// Building a mesh
// ---------------------------------------------------------------------------------------------

type Point = [f64; 3];
type Quad = [Point; 4];

/// A side of an upright box. Left to right is +x, bottom to top +y, back to front +z.
#[derive(Clone, Copy)]
enum Side {
    Left,
    Right,
    Bottom,
    Top,
    Back,
    Front,
}

const ALL: [Side; 6] = [Left, Right, Bottom, Top, Back, Front];
/// What shows of a box that stands on something.
const STANDING: [Side; 5] = [Left, Right, Top, Back, Front];
/// What shows of a box that stands under something too.
const UPRIGHT: [Side; 4] = [Left, Right, Back, Front];

/// One side of the box from `low` to `high`, its front outward.
fn outside(low: Point, high: Point, side: Side) -> Quad {
    let ([a, b, c], [d, e, f]) = (low, high);
    match side {
        Left => [[a, b, c], [a, b, f], [a, e, f], [a, e, c]],
        Right => [[d, b, f], [d, b, c], [d, e, c], [d, e, f]],
        Bottom => [[a, b, c], [d, b, c], [d, b, f], [a, b, f]],
        Top => [[a, e, f], [d, e, f], [d, e, c], [a, e, c]],
        Back => [[d, b, c], [a, b, c], [a, e, c], [d, e, c]],
        Front => [[a, b, f], [d, b, f], [d, e, f], [a, e, f]],
    }
}

/// The same side with its front inward.
fn inside(low: Point, high: Point, side: Side) -> Quad {
    reversed(outside(low, high, side))
}

/// The same quad from the other side: its back becomes its front.
fn reversed([a, b, c, d]: Quad) -> Quad {
    [a, d, c, b]
}

/// A mesh that grows polygon by polygon. What is added gets the object and material last given
/// to [`Mesh::paint`]; equal points become one vertex.
#[derive(Default)]
struct Mesh {
    vertices: Vec<Point>,
    polygons: Vec<Polygon>,
    /// Texture coordinates.
    coordinates: Vec<[f64; 2]>,
    object: &'static str,
    material: &'static str,
    place: Option<Place>,
}

struct Polygon {
    object: &'static str,
    material: &'static str,
    corners: Vec<usize>,
    /// Places in `coordinates`, one a corner; empty where no picture lies on it.
    coordinates: Vec<usize>,
}

/// Where a piece of furniture stands, and the horizontal unit vector (x, z) it faces.
#[derive(Clone, Copy)]
struct Place {
    origin: Point,
    facing: [f64; 2],
}

impl Place {
    fn apply(&self, [x, y, z]: Point) -> Point {
        let ([ox, oy, oz], [fx, fz]) = (self.origin, self.facing);
        [ox + x * fz + z * fx, oy + y, oz - x * fx + z * fz]
    }
}

impl Mesh {
    /// What follows belongs to this object and is made of this material.
    fn paint(&mut self, object: &'static str, material: &'static str) -> &mut Mesh {
        (self.object, self.material) = (object, material);
        self
    }

    /// Builds something in its own coordinates at another place, facing another way.
    fn placed(&mut self, origin: Point, facing: [f64; 2], build: impl FnOnce(&mut Mesh) -> f64) -> f64 {
        self.place = Some(Place { origin, facing });
        let area = build(self);
        self.place = None;
        area
    }

    /// One polygon, counter-clockwise seen from its front.
    fn face(&mut self, corners: &[Point]) {
        let corners = corners.iter().map(|&point| self.vertex(point)).collect();
        let (object, material, coordinates) = (self.object, self.material, Vec::new());
        self.polygons.push(Polygon { object, material, corners, coordinates });
    }

    /// A quad on which a picture lies, so many times from its first corner to the second and from there to
    /// the third.
    fn mapped(&mut self, quad: &Quad, [across, up]: [f64; 2]) {
        self.face(quad);
        let coordinates = [[0.0, 0.0], [across, 0.0], [across, up], [0.0, up]];
        let places = coordinates.map(|at| self.coordinate(at)).to_vec();
        self.polygons.last_mut().expect("the quad").coordinates = places;
    }

    fn coordinate(&mut self, at: [f64; 2]) -> usize {
        self.coordinates.iter().position(|known| *known == at).unwrap_or_else(|| {
            self.coordinates.push(at);
            self.coordinates.len() - 1
        })
    }

    fn vertex(&mut self, point: Point) -> usize {
        // Round to 12 decimals, so that points meant to be one are one.
        let point = self.place.map_or(point, |place| place.apply(point));
        let point = point.map(|x| (x * 1e12).round() / 1e12 + 0.0);
        self.vertices.iter().position(|v| *v == point).unwrap_or_else(|| {
            self.vertices.push(point);
            self.vertices.len() - 1
        })
    }

    /// The given sides of a box, fronts outward.
    fn solid(&mut self, low: Point, high: Point, sides: &[Side]) {
        for &side in sides {
            self.face(&outside(low, high, side));
        }
    }

    /// The given sides of a box, fronts inward.
    fn room(&mut self, low: Point, high: Point, sides: &[Side]) {
        for &side in sides {
            self.face(&inside(low, high, side));
        }
    }

    /// Fills the ring between a quad and a hole in it with four quads, mitred like a picture
    /// frame: each has one edge of the quad and one of the hole, so nothing meets in mid-edge.
    /// The hole's corners come in the order of the quad's.
    fn surround(&mut self, outer: Quad, hole: Quad) {
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            self.face(&[outer[i], outer[j], hole[j], hole[i]]);
        }
    }

    /// The top of an upright block and its walls down to the floor.
    fn block(&mut self, top: Quad) {
        let floor = top.map(|[x, _, z]| [x, 0.0, z]);
        self.face(&top);
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            self.face(&[floor[i], floor[j], top[j], top[i]]);
        }
    }

    /// Four square legs from the floor to an underside; their outer corners are at (±x, ±z).
    fn four_legs(&mut self, x: f64, z: f64, thickness: f64, height: f64) {
        for x in [-x, x - thickness] {
            for z in [-z, z - thickness] {
                self.solid([x, 0.0, z], [x + thickness, height, z + thickness], &UPRIGHT);
            }
        }
    }

    /// The unit sphere from inside: an icosahedron with every triangle cut in four, `cuts` times.
    fn icosphere(&mut self, cuts: u32) {
        // The icosahedron's corners are (0, ±1, ±φ) and its rotations; all its edges have length 2,
        // and any three corners that far apart from each other are a face.
        let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
        let mut corners = Vec::new();
        for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
            corners.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
        }
        let edge = |a: Point, b: Point| (length(minus(a, b)) - 2.0).abs() < 1e-9;
        for (i, &a) in corners.iter().enumerate() {
            for (j, &b) in corners.iter().enumerate().skip(i + 1) {
                for &c in &corners[j + 1..] {
                    if edge(a, b) && edge(b, c) && edge(c, a) {
                        self.spherical_triangle([a, b, c].map(unit), cuts);
                    }
                }
            }
        }
    }

    fn spherical_triangle(&mut self, [a, b, c]: [Point; 3], cuts: u32) {
        if cuts > 0 {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| unit(plus(p, q)));
            for part in [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]] {
                self.spherical_triangle(part, cuts - 1);
            }
        } else if dot(cross(minus(b, a), minus(c, a)), a) < 0.0 {
            self.face(&[a, b, c]);
        } else {
            self.face(&[a, c, b]);
        }
    }

    /// How many triangles the polygons make once they are fanned.
    fn face_count(&self) -> usize {
        self.polygons.iter().map(|p| p.corners.len() - 2).sum()
    }

    fn area(&self) -> f64 {
        let fan = |p: &Polygon| -> f64 {
            let first = self.vertices[p.corners[0]];
            let spokes: Vec<_> = p.corners[1..].iter().map(|&i| minus(self.vertices[i], first)).collect();
            spokes.windows(2).map(|s| length(cross(s[0], s[1])) / 2.0).sum()
        };
        self.polygons.iter().map(fan).sum()
    }
}

fn plus(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: Point) -> Point {
    a.map(|x| x / length(a))
}

// ---------------------------------------------------------------------------------------------
// Areas by formula
// ---------------------------------------------------------------------------------------------

/// All six sides of a box.
fn box_area(width: f64, height: f64, depth: f64) -> f64 {
    walls_area(width, height, depth) + 2.0 * width * depth
}

/// The four upright sides of a box: perimeter times height.
fn walls_area(width: f64, height: f64, depth: f64) -> f64 {
    2.0 * (width + depth) * height
}

/// Top and walls of a block on the floor: half the cross product of the top's diagonals, and
/// perimeter times height.
fn block_area([a, b, c, d]: Quad) -> f64 {
    let side = |p: Point, q: Point| (q[0] - p[0]).hypot(q[2] - p[2]);
    let top = (c[0] - a[0]) * (d[2] - b[2]) - (c[2] - a[2]) * (d[0] - b[0]);
    top.abs() / 2.0 + (side(a, b) + side(b, c) + side(c, d) + side(d, a)) * a[1]
}

// ---------------------------------------------------------------------------------------------
// Writing
// ---------------------------------------------------------------------------------------------

struct Scene {
    name: &'static str,
    /// What the scene is for and what is known about its answer: the head of the OBJ file.
    notes: &'static str,
    materials: Vec<Material>,
    mesh: Mesh,
    /// Lights without area and the sky, as the TOML file says them.
    lights: &'static str,
    camera: Camera,
    /// The area by formula, m², and how far the mesh may be from it, relative.
    area: f64,
    tolerance: f64,
}

/// Diffuse reflectance, and emitted radiance of the front in W/(sr m²); or what a mirror, metal or glass is.
struct Material {
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
    fn matt(name: &'static str, reflectance: [f64; 3]) -> Material {
        Material { name, reflectance, radiance: None, finish: Finish::Matt, picture: None }
    }

    fn glowing(name: &'static str, reflectance: [f64; 3], radiance: [f64; 3]) -> Material {
        Material { radiance: Some(radiance), ..Material::matt(name, reflectance) }
    }

    fn with_picture(self, key: &'static str, file: &'static str) -> Material {
        Material { picture: Some((key, file)), ..self }
    }

    fn mirror(name: &'static str, reflectance: f64) -> Material {
        Material { finish: Finish::Mirror(reflectance), ..Material::matt(name, [0.0; 3]) }
    }

    fn metal(name: &'static str, reflectance: [f64; 3], roughness: f64) -> Material {
        Material { finish: Finish::Metal(roughness), ..Material::matt(name, reflectance) }
    }

    fn plastic(name: &'static str, reflectance: [f64; 3], roughness: f64) -> Material {
        Material { finish: Finish::Plastic(roughness), ..Material::matt(name, reflectance) }
    }

    fn glass(name: &'static str, index: f64) -> Material {
        Material { finish: Finish::Glass(index), ..Material::matt(name, [0.0; 3]) }
    }
}

struct Camera {
    about: &'static str,
    position: Point,
    target: Point,
    /// Vertical field of view, degrees.
    fov: f64,
}

impl Scene {
    fn write(&self, folder: &Path) -> io::Result<()> {
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
