//! Faces that lie on each other in one plane: the answer is that of faces a hair apart, and nothing is
//! decided by rounding.

use glam::{DQuat, DVec3};
use radiosity::measure::overlaps;
use radiosity::reference::{PathOptions, PathTracer};
use radiosity::scene::{Face, FaceState, Material, Scene, SceneParts, Side};
use radiosity::solve::{self, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Sources, TraceOptions, Transport};

use crate::scenes::{Quad, cut_into, flipped, room};

const WALL: u32 = 0;
const LAMP: u32 = 1;
const DARK: u32 = 2;
const SHEET: u32 = 3;

/// A room of 4 × 3 × 2.5 m, the corner at the origin, floor y = 0.
fn walls() -> Vec<(Quad, u32)> {
    room([0.0; 3], [4.0, 2.5, 3.0]).into_iter().map(|quad| (quad, WALL)).collect()
}

/// A level quad at height y, its front up.
fn level([x0, x1]: [f64; 2], [z0, z1]: [f64; 2], y: f64) -> Quad {
    [[x0, y, z0], [x0, y, z1], [x1, y, z1], [x1, y, z0]]
}

/// A lamp under the ceiling that shines down.
fn lamp(y: f64) -> (Quad, u32) {
    (flipped(level([1.6, 2.4], [1.1, 1.9], y)), LAMP)
}

/// The six sides of a box that stands upright, fronts outside.
fn solid(low: [f64; 3], high: [f64; 3]) -> Vec<(Quad, u32)> {
    room(low, high).into_iter().map(|quad| (flipped(quad), DARK)).collect()
}

/// A scene of quads, an object each, turned and moved; coordinates keep `digits` digits behind the point.
fn scene(quads: &[(Quad, u32)], turn: DQuat, digits: Option<i32>) -> Scene {
    let materials = vec![
        Material::diffuse("wall", &[0.5]),
        Material::lamp("lamp", &[0.2], &[10.0]),
        Material::diffuse("dark", &[0.2]),
        Material::diffuse("sheet", &[0.8]),
    ];
    let mut parts = SceneParts { name: "coincident".into(), materials, ..Default::default() };
    let round = |x: f64| digits.map_or(x, |digits| (x * 10f64.powi(digits)).round() / 10f64.powi(digits));
    for (object, (corners, material)) in quads.iter().enumerate() {
        let first = parts.vertices.len() as u32;
        parts.vertices.extend(corners.map(|p| (turn * DVec3::from(p)).map(round)));
        parts.objects.push(format!("quad {object}"));
        for k in [1, 2] {
            let vertices = [first, first + k, first + k + 1];
            let (material, object, state) = (*material, object as u32, FaceState::Kept);
            parts.faces.push(Face { vertices, normals: None, material, object, state });
        }
    }
    Scene::new(parts).unwrap()
}

/// Area (m²) and mean irradiance of each quad's front and back; nothing where it has no patches.
fn answer(scene: &Scene, count: usize, rays: u32) -> Vec<[Option<(f64, f64)>; 2]> {
    let tracer = Tracer::new(scene);
    let mut patches = cut_into(&tracer, count);
    let options = TraceOptions { rays: Some(rays), ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    assert!(factors.exchange().closure().after < 1e-12, "{:?}", factors.exchange().closure());
    assert_eq!(factors.disagreements(), [], "both directions of every pair agree");
    let k = Transport::of(&factors, &patches).unwrap();
    let sources: Sources = patches.emitted_radiance().into();
    let solution = solve::solve(&k, &sources.right_hand_side(&k), &SolveOptions::default()).unwrap();
    let mut sums = vec![[None; 2]; scene.faces().len() / 2];
    for row in patches.average_by_face(&solution.irradiance) {
        let sum: &mut Option<(f64, f64)> = &mut sums[row.face / 2][row.side as usize];
        let (area, flux) = sum.unwrap_or_default();
        *sum = Some((area + row.area, flux + row.area * row.mean[0]));
    }
    sums.into_iter().map(|sides| sides.map(|sum| sum.map(|(area, flux)| (area, flux / area)))).collect()
}

/// The lit side of a quad.
fn front(answer: &[[Option<(f64, f64)>; 2]], quad: usize) -> (f64, f64) {
    answer[quad][0].unwrap_or_else(|| panic!("quad {quad} has patches"))
}

fn turns() -> [(DQuat, Option<i32>); 3] {
    let turn = DQuat::from_axis_angle(DVec3::new(0.3, -0.8, 0.5).normalize(), 0.7);
    // As it is, turned in full precision, and turned and written with six digits behind the point.
    [(DQuat::IDENTITY, None), (turn, None), (turn, Some(6))]
}

#[test]
fn a_rug_in_the_floors_plane_is_as_one_a_hair_above_it() {
    let rug = |y: f64| [walls(), vec![lamp(2.3), (level([0.7, 2.9], [0.4, 2.1], y), SHEET)]].concat();
    let lifted = answer(&scene(&rug(1e-4), DQuat::IDENTITY, None), 1500, 256);
    for (turn, digits) in turns() {
        let flush = answer(&scene(&rug(0.0), turn, digits), 1500, 256);
        for quad in [2, 3, 4, 5, 7] {
            let (mine, theirs) = (front(&flush, quad).1, front(&lifted, quad).1);
            assert!((mine / theirs - 1.0).abs() < 5e-3, "{digits:?} {quad}: {mine} {theirs}");
        }
        // Quad 1 is the floor: what the rug covers counts in no area or mean, in the light and in the dark.
        let (bare, mean) = front(&flush, 1);
        let (whole, dimmed) = front(&lifted, 1);
        assert!((bare - (12.0 - 2.2 * 1.7)).abs() < 1e-5, "{bare}");
        assert!((mean * bare / (dimmed * whole) - 1.0).abs() < 5e-3, "{mean} {dimmed}");
        assert_eq!(flush[7][1], None, "nothing is below the rug");
    }
}

#[test]
fn a_finely_cut_floor_lies_under_a_rug_of_two_triangles() {
    let tiles = |y: f64| (0..24).map(move |k| ((k % 6) as f64, (k / 6) as f64, y));
    let tile = |(i, j, y): (f64, f64, f64)| {
        let (dx, dz) = (4.0 / 6.0, 0.75);
        (level([dx * i, dx * (i + 1.0)], [dz * j, dz * (j + 1.0)], y), WALL)
    };
    let with = |y: f64| {
        let others = walls().into_iter().enumerate().filter(|(k, _)| *k != 1).map(|(_, quad)| quad);
        let floor: Vec<_> = tiles(0.0).map(tile).collect();
        // The floor's tiles share their corners only by position; the rug is larger than any of them.
        [others.collect(), vec![lamp(2.3), (level([0.7, 2.9], [0.4, 2.1], y), SHEET)], floor].concat()
    };
    let flush = answer(&scene(&with(0.0), DQuat::IDENTITY, None), 1500, 256);
    let lifted = answer(&scene(&with(1e-4), DQuat::IDENTITY, None), 1500, 256);
    let (mine, theirs) = (front(&flush, 6), front(&lifted, 6));
    assert!(
        (mine.0 - 2.2 * 1.7).abs() < 1e-9 && (mine.1 / theirs.1 - 1.0).abs() < 5e-3,
        "{mine:?} {theirs:?}"
    );
}

#[test]
fn a_lamp_in_the_ceilings_plane_shines() {
    let with = |y: f64| [walls(), vec![lamp(y)]].concat();
    let below = answer(&scene(&with(2.4999), DQuat::IDENTITY, None), 1500, 256);
    for (turn, digits) in turns() {
        let flush = answer(&scene(&with(2.5), turn, digits), 1500, 256);
        for quad in [0, 1, 2, 3, 4, 5, 6] {
            let (mine, theirs) = (front(&flush, quad).1, front(&below, quad).1);
            // What lies between lamp and ceiling is dark: the mean of the whole ceiling is that much lower.
            let dark = if quad == 4 { 12.0 / (12.0 - 0.64) } else { 1.0 };
            assert!((mine / (dark * theirs) - 1.0).abs() < 5e-3, "{digits:?} {quad}: {mine} {theirs}");
        }
    }
}

#[test]
fn boxes_that_stand_in_each_other_answer_as_if_one_stood_higher() {
    for high in [[2.0, 0.9, 1.8], [2.3, 0.6, 1.8]] {
        let with = |y: f64| {
            [walls(), vec![lamp(2.3)], solid([0.6, 0.0, 0.5], [1.7, 0.6, 1.4]), solid([1.1, y, 0.9], high)]
        };
        let apart = answer(&scene(&with(1e-4).concat(), DQuat::IDENTITY, None), 1500, 256);
        let flush = answer(&scene(&with(0.0).concat(), turns()[1].0, None), 1500, 256);
        for quad in 0..6 {
            let (mine, theirs) = (front(&flush, quad).1, front(&apart, quad).1);
            assert!((mine / theirs - 1.0).abs() < 5e-3, "{quad}: {mine} {theirs}");
        }
    }
}

#[test]
fn sheets_back_to_back_keep_their_outer_sides() {
    let board = level([0.7, 2.9], [0.4, 2.1], 1.2);
    for y in [1.2, 1.2 - 1e-4] {
        let under = board.map(|[x, _, z]| [x, y, z]);
        let quads = [walls(), vec![lamp(2.3), (board, SHEET), (flipped(under), DARK)]].concat();
        let scene = scene(&quads, turns()[1].0, None);
        let found = answer(&scene, 1500, 256);
        let (above, below) = (front(&found, 7), front(&found, 8));
        assert!(above.1 > 3.0 * below.1, "{above:?} {below:?}");
        if y == 1.2 {
            assert_eq!([found[7][1], found[8][1]], [None; 2], "no light between them");
            assert_eq!(overlaps(&Tracer::new(&scene)), [], "nothing is hidden");
        }
    }
}

#[test]
fn of_equal_faces_the_first_is_on_top_whatever_their_order_and_corners() {
    let rug = level([0.7, 2.9], [0.4, 2.1], 0.5);
    let turned = [rug[1], rug[2], rug[3], rug[0]];
    for materials in [[SHEET, DARK], [DARK, SHEET]] {
        let twice = [walls(), vec![lamp(2.3), (rug, materials[0]), (turned, materials[1])]].concat();
        let below = (turned.map(|[x, y, z]| [x, y - 1e-4, z]), materials[1]);
        let apart = [walls(), vec![lamp(2.3), (rug, materials[0]), below]].concat();
        let [twice, apart] =
            [twice, apart].map(|quads| answer(&scene(&quads, DQuat::IDENTITY, None), 1500, 256));
        assert_eq!([twice[7][1], twice[8][0]], [None; 2], "no light between them");
        for quad in 0..8 {
            let (mine, theirs) = (front(&twice, quad).1, front(&apart, quad).1);
            assert!((mine / theirs - 1.0).abs() < 5e-3, "{quad}: {mine} {theirs}");
        }
    }
}

#[test]
fn a_lamp_that_is_covered_in_part_sends_out_the_rest() {
    let cover = flipped(level([2.0, 2.4], [1.1, 1.9], 2.3));
    let quads = [walls(), vec![lamp(2.3), (cover, DARK)]].concat();
    let half = (flipped(level([1.6, 2.0], [1.1, 1.9], 2.3)), LAMP);
    let alone = [walls(), vec![half, (cover, DARK)]].concat();
    let [covered, alone] = [quads, alone].map(|quads| answer(&scene(&quads, turns()[1].0, None), 1500, 256));
    for quad in 0..8 {
        let (mine, theirs) = (front(&covered, quad), front(&alone, quad));
        assert!((mine.0 - theirs.0).abs() < 1e-6, "{quad}: {mine:?} {theirs:?}");
        assert!((mine.1 / theirs.1 - 1.0).abs() < 5e-3, "{quad}: {mine:?} {theirs:?}");
    }
}

#[test]
fn light_paths_meet_the_same_faces_as_rows() {
    let rug = [walls(), vec![lamp(2.5), (level([0.7, 2.9], [0.4, 2.1], 0.0), SHEET)]].concat();
    let scene = scene(&rug, turns()[1].0, Some(6));
    let found = answer(&scene, 1500, 256);
    let tracer = Tracer::new(&scene);
    let patches = cut_into(&tracer, 300);
    let truth = PathTracer::new(&tracer).irradiance(&patches, &PathOptions::default()).unwrap();
    let (irradiance, errors) = (truth.means(), truth.standard_errors());
    for quad in [1, 4, 7] {
        let (mut area, mut flux, mut variance) = (0.0, 0.0, 0.0);
        let faces = [2 * quad, 2 * quad + 1].into_iter();
        for i in faces.flat_map(|face| patches.patches_of(face, Side::Front)) {
            area += patches.area(i);
            flux += patches.area(i) * irradiance[(i, 0)];
            variance += (patches.area(i) * errors[(i, 0)]).powi(2);
        }
        let (mine, theirs, error) = (front(&found, quad).1, flux / area, variance.sqrt() / area);
        assert!((mine - theirs).abs() < 4.0 * error + 5e-3 * theirs, "{quad}: {mine} {theirs} {error}");
    }
}

#[test]
fn overlaps_of_one_front_are_told_by_objects_with_their_area() {
    let quads = [walls(), vec![lamp(2.3), (level([0.7, 2.9], [0.4, 2.1], 0.0), SHEET)]].concat();
    let scene = scene(&quads, turns()[1].0, Some(6));
    let tracer = Tracer::new(&scene);
    let [told] = &overlaps(&tracer)[..] else { panic!("{:?}", overlaps(&tracer)) };
    assert_eq!(told.objects, ["quad 7", "quad 1"]);
    assert!((told.area - 2.2 * 1.7).abs() < 1e-5, "{told:?}");
    assert_eq!(told.faces, [2, 3]);
}

#[test]
fn neighbours_in_one_plane_and_faces_a_hair_apart_do_not_coincide() {
    let tile = |x: f64, y: f64| (level([x, x + 1.0], [0.0, 1.0], y), WALL);
    for quads in [
        // Neighbours, with a corner of one on the other's edge, and a gap below and above.
        vec![tile(0.0, 0.0), tile(1.0, 0.0), (level([0.3, 1.4], [1.0, 2.0], 0.0), WALL)],
        vec![tile(0.0, 0.0), tile(0.3, 1e-9)],
        vec![tile(0.0, 0.0), tile(0.3, -1e-9)],
    ] {
        for (turn, digits) in turns().into_iter().filter(|(_, digits)| digits.is_none() || quads.len() == 3) {
            assert_eq!(Tracer::new(&scene(&quads, turn, digits)).overlaps(), [], "{quads:?} {digits:?}");
        }
    }
}
