//! The Cornell box.

use super::areas::block_area;
use super::mesh::{Mesh, Point};
use super::scene::{Camera, Material, ROUNDING, Scene};

pub fn cornell_box() -> Scene {
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
