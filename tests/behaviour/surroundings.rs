//! Surroundings: a wide ground takes few patches, and changes nothing that a ground cut by hand does not.

use glam::{DMat3, DVec3};
use radiosity::measure::ErrorBars;
use radiosity::patches::{FaceRow, Patches};
use radiosity::progress::Progress;
use radiosity::scene::{Light, Material, Scene, SceneParts, Side, Sky, SkyKind};
use radiosity::solve::{CgOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, TraceOptions};

use crate::scenes::{Quad, cut_into, flipped, lit_quads, moved, parts_of, point, room, sky, square};

/// Quads of the room, first in every scene.
const ROOM: usize = 9;

/// A room of six by four by three metres with a window of two by one metre, on its own a hand above the
/// ground.
fn walls() -> Vec<Quad> {
    let (low, high) = ([0.0, 0.2, 0.0], [6.0, 3.0, 4.0]);
    let [_, floor, back, left, ceiling, _] = room(low, high);
    let right = room(low, high)[0];
    let front = |x: [f64; 2], y: [f64; 2]| {
        let z = high[2];
        [[x[0], y[0], z], [x[0], y[1], z], [x[1], y[1], z], [x[1], y[0], z]]
    };
    let window = [
        front([0.0, 2.0], [low[1], high[1]]),
        front([4.0, 6.0], [low[1], high[1]]),
        front([2.0, 4.0], [low[1], 1.0]),
        front([2.0, 4.0], [2.0, high[1]]),
    ];
    [vec![floor, back, left, ceiling, right], window.to_vec()].concat()
}

/// A square ground of this half-width around the room, as one quad.
fn ground(half: f64) -> Vec<Quad> {
    vec![square(0.0, half).map(|[x, y, z]| [x + 3.0, y, z + 2.0])]
}

/// The same in squares that grow with their distance.
fn ground_by_hand(half: f64) -> Vec<Quad> {
    let mut lines = vec![0.0f64];
    while lines[lines.len() - 1] < half {
        let last = lines[lines.len() - 1];
        lines.push((last + (0.5 * (last - 3.0)).max(1.0)).min(half));
    }
    let lines: Vec<f64> = lines.iter().rev().map(|x| -x).chain(lines[1..].iter().copied()).collect();
    let strips = || lines.windows(2);
    let quad = |x: &[f64], z: &[f64]| {
        let (x, z) = ([x[0] + 3.0, x[1] + 3.0], [z[0] + 2.0, z[1] + 2.0]);
        [[x[0], 0.0, z[0]], [x[0], 0.0, z[1]], [x[1], 0.0, z[1]], [x[1], 0.0, z[0]]]
    };
    strips().flat_map(|x| strips().map(move |z| quad(x, z))).collect()
}

/// The room and what is around it under an overcast sky.
fn scene(around: &[Quad], lights: Vec<Light>) -> Scene {
    let quads: Vec<(Quad, u32)> =
        walls().into_iter().map(|quad| (quad, 0)).chain(around.iter().map(|&quad| (quad, 1))).collect();
    let materials = vec![Material::diffuse("wall", &[0.6]), Material::diffuse("ground", &[0.2])];
    lit_quads(&quads, materials, lights, Some(sky(SkyKind::Overcast, 1.0)))
}

/// How many patches the room has, and the rest.
fn counts(patches: &Patches) -> [usize; 2] {
    let room = (0..patches.len()).filter(|&i| patches.place(i).face < 2 * ROOM).count();
    [room, patches.len() - room]
}

#[test]
fn a_room_keeps_its_patches_on_a_square_kilometre_of_ground() {
    let count = |scene: &Scene| counts(&cut_into(&Tracer::new(scene), 4000));
    let [alone, _] = count(&scene(&[], Vec::new()));
    let grounds = [ground(500.0), ground(50_000.0), ground(50.0)];
    for around in grounds {
        let whole = scene(&around, Vec::new());
        // However it lies.
        let turn = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(0.7) * DMat3::from_rotation_y(0.3);
        let above = Sky { up: turn * DVec3::Y, ..sky(SkyKind::Overcast, 1.0) };
        let turned = SceneParts { sky: Some(above), ..parts_of(&moved(&whole, |p| turn * p)) };
        for scene in [whole, Scene::new(turned).unwrap()] {
            let [room, rest] = count(&scene);
            assert!(room as f64 >= 0.9 * alone as f64, "{room} of {alone}");
            assert!(rest <= alone / 4, "{rest} on the ground, {alone} alone");
        }
    }
}

/// Irradiance of the fronts of the room's faces, and how far it may be off at 95 %.
fn solved(scene: &Scene) -> Vec<[f64; 2]> {
    let tracer = Tracer::new(scene);
    let mut patches = cut_into(&tracer, 4000);
    let options = TraceOptions { rays: Some(512), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
    let solution = problem.conjugate_gradients(&CgOptions::default()).unwrap();
    let bars = ErrorBars::of(&patches, &problem, &solution, Progress::default()).unwrap();
    let rows = patches.average_by_face(&solution.means().irradiance);
    let of_room = |row: &FaceRow| row.face < 2 * ROOM && row.side == Side::Front;
    let inside = rows.iter().zip(&bars.faces).filter(|(row, _)| of_room(row));
    inside.map(|(row, bar)| [row.mean[0], 1.96 * bar.mean[0]]).collect()
}

#[test]
fn a_room_on_one_wide_ground_is_lit_as_on_one_that_is_cut_by_hand() {
    let [wide, by_hand] =
        [ground(500.0), ground_by_hand(500.0)].map(|around| solved(&scene(&around, vec![])));
    assert_eq!(wide.len(), 2 * ROOM);
    for (face, ([wide, bar], [by_hand, other])) in wide.into_iter().zip(by_hand).enumerate() {
        let apart = (wide - by_hand).abs();
        assert!(
            apart <= f64::hypot(bar, other).max(0.01 * by_hand),
            "{face}: {wide} {by_hand} ± {bar} {other}"
        );
    }
}

/// The longest leg on a face, metres.
fn longest_leg(patches: &Patches, face: usize) -> f64 {
    let of_face = (0..patches.len()).filter(|&i| patches.place(i).face == face);
    of_face.map(|i| (2.0 * patches.area(i)).sqrt()).fold(0.0, f64::max)
}

#[test]
fn a_plane_that_is_not_wide_is_cut_evenly() {
    // A ball's worth of box on a plane, and a room without anything around it.
    let small = room([-0.5, 0.01, -0.5], [0.5, 1.01, 0.5]).map(flipped);
    let quads: Vec<(Quad, u32)> = small.into_iter().chain([square(0.0, 3.0)]).map(|quad| (quad, 0)).collect();
    let materials = vec![Material::diffuse("all", &[0.5])];
    let scene = lit_quads(&quads, materials, Vec::new(), Some(sky(SkyKind::Overcast, 1.0)));
    let tracer = Tracer::new(&scene);
    let patches = cut_into(&tracer, 2000);
    let (plane, block) = (longest_leg(&patches, 12), longest_leg(&patches, 2));
    assert!(plane < 1.5 * block, "{plane} {block}");
}

#[test]
fn a_ground_that_lights_without_area_stand_on_is_cut_evenly() {
    let lamps: Vec<Light> =
        (0..4).map(|k| point([100.0 + 20.0 * f64::from(k), 8.0, 50.0], &[100.0])).collect();
    let scene = scene(&ground(200.0), lamps);
    let tracer = Tracer::new(&scene);
    let patches = cut_into(&tracer, 4000);
    let [room, rest] = counts(&patches);
    assert!(rest > 3000, "{room} {rest}");
    let leg = longest_leg(&patches, 2 * ROOM);
    assert!(leg <= 1.5 * patches.edge(), "{leg} {}", patches.edge());
}
