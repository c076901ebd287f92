//! Where surfaces touch: no patch lies on both sides of the line, nothing leaks, and patches stay as many as asked for.

use radiosity::patches::{PatchSize, Patches, Tessellation};
use radiosity::scene::{Material, Scene, Side};
use radiosity::trace::Tracer;

use crate::scenes::{quads, room};

type Quad = [[f64; 3]; 4];

/// A room of 1 m with a lamp below its ceiling, a box of the given walls on its floor y = 0, turned a little.
fn with_box(walls: impl Fn([[f64; 2]; 4]) -> Vec<Quad>) -> Scene {
    let lamp = [[0.3, 0.95, 0.3], [0.7, 0.95, 0.3], [0.7, 0.95, 0.7], [0.3, 0.95, 0.7]];
    let all = room([0.0; 3], [1.0; 3]).into_iter().chain(walls(FOOT)).map(|quad| (quad, 0));
    let all: Vec<(Quad, u32)> = all.chain([(lamp, 1)]).collect();
    quads(&all, vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.0], &[10.0])])
}

/// The corners of the box, x and z.
const FOOT: [[f64; 2]; 4] = [[0.31, 0.27], [0.62, 0.39], [0.5, 0.7], [0.19, 0.58]];

/// The upright walls over the sides of a foot, and a lid.
fn box_over(foot: [[f64; 2]; 4], [low, high]: [f64; 2]) -> Vec<Quad> {
    let at = |k: usize, y: f64| [foot[k % 4][0], y, foot[k % 4][1]];
    let wall = |k: usize| [at(k, low), at(k + 1, low), at(k + 1, high), at(k, high)];
    (0..4).map(wall).chain([[0, 1, 2, 3].map(|k| at(k, high))]).collect()
}

fn foot_area() -> f64 {
    let cross = |k: usize| {
        let ([x, z], [next_x, next_z]) = (FOOT[k], FOOT[(k + 1) % 4]);
        0.5 * (x * next_z - z * next_x)
    };
    (0..4).map(cross).sum::<f64>().abs()
}

fn cut<'s>(tracer: &Tracer<'s>, count: usize) -> Patches<'s> {
    let size = PatchSize::Count(count);
    Patches::new(tracer, &Tessellation { size, ..Default::default() }).unwrap()
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
    for walls in boxes {
        let scene = with_box(walls);
        let tracer = Tracer::new(&scene);
        for count in [200, 3000] {
            let patches = cut(&tracer, count);
            let lit = lit_floor(&patches);
            assert!((lit + foot_area() - 1.0).abs() < 1e-6, "{count}: {lit} and {}", foot_area());
        }
    }
}

#[test]
fn no_patch_straddles_the_foot_of_a_box() {
    let scene = with_box(|foot| box_over(foot, [0.0, 0.3]));
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
        let scene = Scene::load(format!("{}/meshes/{name}.obj", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let tracer = Tracer::new(&scene);
        for count in [2000, 8000] {
            let share = cut(&tracer, count).len() as f64 / count as f64;
            assert!((share - 1.0).abs() < 0.2, "{name}: {share} of {count}");
        }
    }
}
