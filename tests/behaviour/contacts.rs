//! Where surfaces touch: no patch lies on both sides of the line, nothing leaks, and patches stay as many as
//! asked for.

use glam::{DMat3, DVec3};
use radiosity::patches::Patches;
use radiosity::scene::{Material, Scene, Side};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions};

use crate::scenes::{Quad, cut_into as cut, flipped, mesh, quads, room};

/// A room of 1 m with a lamp below its ceiling, a box of the given walls on its floor y = 0, turned a little.
fn with_box(foot: [[f64; 2]; 4], walls: impl Fn([[f64; 2]; 4]) -> Vec<Quad>) -> Scene {
    let lamp = [[0.3, 0.95, 0.3], [0.7, 0.95, 0.3], [0.7, 0.95, 0.7], [0.3, 0.95, 0.7]];
    let all = room([0.0; 3], [1.0; 3]).into_iter().chain(walls(foot)).map(|quad| (quad, 0));
    let all: Vec<(Quad, u32)> = all.chain([(lamp, 1)]).collect();
    quads(&all, vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.0], &[10.0])])
}

/// The corners of the box, x and z.
const FOOT: [[f64; 2]; 4] = [[0.31, 0.27], [0.62, 0.39], [0.5, 0.7], [0.19, 0.58]];

/// The same of a box of which a corner is 4 mm beside the diagonal of the floor.
const NEAR_DIAGONAL: [[f64; 2]; 4] = [[0.503, 0.497], [0.8, 0.39], [0.9, 0.62], [0.6, 0.7]];

/// The upright walls over the sides of a foot, and a lid.
fn box_over(foot: [[f64; 2]; 4], [low, high]: [f64; 2]) -> Vec<Quad> {
    let at = |k: usize, y: f64| [foot[k % 4][0], y, foot[k % 4][1]];
    let wall = |k: usize| [at(k, low), at(k + 1, low), at(k + 1, high), at(k, high)];
    (0..4).map(wall).chain([[0, 1, 2, 3].map(|k| at(k, high))]).collect()
}

fn area_of(foot: [[f64; 2]; 4]) -> f64 {
    let cross = |k: usize| {
        let ([x, z], [next_x, next_z]) = (foot[k], foot[(k + 1) % 4]);
        0.5 * (x * next_z - z * next_x)
    };
    (0..4).map(cross).sum::<f64>().abs()
}

/// The area of the lit patches at height 0 that face up.
fn lit_floor(patches: &Patches) -> f64 {
    let on_floor = |&i: &usize| patches.centre(i).y == 0.0 && patches.place(i).side == Side::Front;
    (0..patches.len()).filter(on_floor).map(|i| patches.area(i)).sum()
}

#[test]
fn no_light_gets_under_a_box() {
    // Standing on the floor without a bottom, sunk into it, and made of walls that are longer than the box.
    let boxes: [&dyn Fn([[f64; 2]; 4]) -> Vec<Quad>; 2] =
        [&|foot| box_over(foot, [0.0, 0.3]), &|foot| box_over(foot, [-0.1, 0.3])];
    for (foot, walls) in [FOOT, NEAR_DIAGONAL].into_iter().flat_map(|foot| boxes.map(|walls| (foot, walls))) {
        let scene = with_box(foot, walls);
        let tracer = Tracer::new(&scene);
        for count in [200, 3000] {
            let (lit, under) = (lit_floor(&cut(&tracer, count)), area_of(foot));
            assert!((lit + under - 1.0).abs() < 1e-6, "{foot:?} {count}: {lit} and {under}");
        }
    }
}

#[test]
fn no_patch_straddles_the_foot_of_a_box() {
    let scene = with_box(FOOT, |foot| box_over(foot, [0.0, 0.3]));
    let patches = cut(&Tracer::new(&scene), 1000);
    // How far a point of the floor lies outside the foot, negative inside.
    let outside = |[x, z]: [f64; 2]| {
        let beyond = |k: usize| {
            let ([ax, az], [bx, bz]) = (FOOT[k], FOOT[(k + 1) % 4]);
            ((z - az) * (bx - ax) - (x - ax) * (bz - az)) / (bx - ax).hypot(bz - az)
        };
        (0..4).map(|k| -beyond(k)).fold(f64::MIN, f64::max)
    };
    for i in (0..patches.len()).filter(|&i| patches.centre(i).y == 0.0) {
        let corners = patches.corners(i).map(|corner| patches.point(patches.place(i).face, corner));
        // A patch is convex, and so is the foot: no inner point of the patch may be inside it.
        let middles = [0.05, 0.35, 0.65, 0.95].map(|t| {
            let near = |k: usize| 0.98 * corners[k] + 0.01 * (corners[(k + 1) % 3] + corners[(k + 2) % 3]);
            [0, 1, 2].map(|k| near(k).lerp(near((k + 1) % 3), t))
        });
        for p in middles.as_flattened() {
            assert!(outside([p.x, p.z]) > 0.0, "{i}: {p}");
        }
    }
}

#[test]
fn patches_stay_as_many_as_asked_for_where_surfaces_touch() {
    for name in ["cornell_box", "spot_gallery", "furnished_room"] {
        let scene = mesh(name);
        let tracer = Tracer::new(&scene);
        for count in [2000, 8000] {
            let share = cut(&tracer, count).len() as f64 / count as f64;
            assert!((share - 1.0).abs() < 0.2, "{name}: {share} of {count}");
        }
    }
}

/// A box turned by three angles around its centre, its sides fronting outward.
fn turned_box(centre: DVec3, half: DVec3, angles: [f64; 3]) -> Vec<Quad> {
    let [x, y, z] = angles;
    let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
    let at = |p: [f64; 3]| (centre + turn * DVec3::from(p)).to_array();
    room((-half).to_array(), half.to_array()).map(|quad| flipped(quad.map(at))).to_vec()
}

#[test]
fn no_light_gets_into_a_sealed_box_that_boards_pierce() {
    // A box of 0.5 m in a room of 4 m, of bare sheets or with walls of 1 cm, and four boards of 1 cm through
    // its walls. At 300 patches every face of a board is smaller than a patch.
    let lamp = ([[1.5, 2.9, 1.5], [2.5, 2.9, 1.5], [2.5, 2.9, 2.5], [1.5, 2.9, 2.5]], 1);
    let (centre, half) = (DVec3::new(2.0, 1.5, 2.0), DVec3::splat(0.25));
    let boards =
        [(0.25, 0.0, 0.1), (-0.25, 0.0, -0.07), (0.0, 0.25, 0.05), (0.0, -0.25, -0.1)].into_iter().zip(0..);
    let boards = boards.flat_map(|((x, z, y), k)| {
        let along = if x == 0.0 { 1.5 } else { 0.0 };
        let angles = [0.3 + 0.1 * f64::from(k), along + 0.2, 0.15];
        turned_box(centre + DVec3::new(x, y, z), DVec3::new(0.17, 0.005, 0.06), angles)
    });
    let boards: Vec<(Quad, u32)> = boards.map(|quad| (quad, 0)).collect();
    for thick in [0.0, 0.01] {
        let mut all: Vec<(Quad, u32)> = room([0.0; 3], [4.0, 3.0, 4.0]).map(|quad| (quad, 0)).to_vec();
        all.push(lamp);
        let inside = half - thick;
        all.extend(turned_box(centre, half, [0.0; 3]).into_iter().map(|quad| (quad, 0)));
        if thick > 0.0 {
            all.extend(turned_box(centre, inside, [0.0; 3]).into_iter().map(|quad| (flipped(quad), 0)));
        }
        all.extend(&boards);
        let scene =
            quads(&all, vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.0], &[10.0])]);
        let tracer = Tracer::new(&scene);
        for count in [300, 1000, 3000] {
            let mut patches = cut(&tracer, count);
            let options = TraceOptions { rays: Some(64), ..Default::default() };
            FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let is_inside = |&i: &usize| (patches.centre(i) - centre).abs().cmplt(inside - 1e-9).all();
            let lit = (0..patches.len()).filter(is_inside).count();
            assert_eq!(lit, 0, "walls of {thick} m, {count} patches: so many are lit inside");
        }
    }
}
