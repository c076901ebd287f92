//! Faces that coincide, cross, tangle or almost touch.

use glam::DVec3;
use radiosity::patches::{PatchError, PatchSize, Patches, Reach, Tessellation};
use radiosity::scene::{Material, Scene, SceneParts};
use radiosity::trace::Tracer;
use radiosity::trace::sampling::Stream;

use super::{hold_to_the_laws, lit_room};
use crate::scenes::{Quad, flipped, grey, push_triangle, quads, room};

#[test]
fn duplicates_act_once() {
    let shelf: Quad = [[0.2, 0.4, 0.2], [0.8, 0.4, 0.2], [0.8, 0.4, 0.8], [0.2, 0.4, 0.8]];
    let size = PatchSize::Edge(0.15);
    let once = hold_to_the_laws(&lit_room(0.5, &[shelf]), size);
    let twice = lit_room(0.5, &[shelf, shelf]);
    assert!(twice.warnings().iter().any(|w| w.contains("dropped 2 faces")), "{:?}", twice.warnings());
    assert_eq!(once, hold_to_the_laws(&twice, size)[..once.len()]);
}

#[test]
fn overlapping_and_interpenetrating_faces_stay_finite_and_balanced() {
    let shelf = |low: f64, high: f64, y: f64| -> Quad {
        [[low, y, low], [high, y, low], [high, y, high], [low, y, high]]
    };
    let upright: Quad = [[0.5, 0.1, 0.1], [0.5, 0.7, 0.1], [0.5, 0.7, 0.9], [0.5, 0.1, 0.9]];
    let more = [shelf(0.2, 0.7, 0.4), shelf(0.4, 0.9, 0.4), upright, shelf(-0.2, 0.5, 0.2)];
    hold_to_the_laws(&lit_room(0.8, &more), PatchSize::Edge(0.1));
}

/// `count` triangles with corners drawn in the unit square of the floor, or in the unit cube.
fn soup(count: u32, flat: bool) -> Scene {
    let mut parts = SceneParts { materials: grey(0.5), ..Default::default() };
    parts.objects.push("soup".into());
    for k in 0..count {
        let corners = [0, 1, 2].map(|corner| {
            let [x, y, z, _] = Stream::Callers.sequence(1, k, 0).point(corner);
            DVec3::new(x, y, if flat { 0.0 } else { z })
        });
        push_triangle(&mut parts, corners, 0, 0);
    }
    Scene::new(parts).unwrap()
}

#[test]
fn a_tangle_of_triangles_is_cut_no_finer_than_its_size_allows() {
    let scene = soup(800, false);
    let options =
        Tessellation { size: PatchSize::Count(100), reach: Reach::Everything, ..Default::default() };
    let patches = Patches::new(&Tracer::new(&scene), &options).unwrap();
    // Every face twice, each in some hundred lines and what they cross.
    assert!((1600..3_000_000).contains(&patches.len()), "{}", patches.len());
}

#[test]
fn faces_that_all_lie_on_one_another_are_refused_at_once() {
    let scene = soup(3000, true);
    let tracer = Tracer::new(&scene);
    let refused = Patches::new(&tracer, &Tessellation::default()).unwrap_err();
    assert!(matches!(&refused, PatchError::TooManyOverlaps { object, .. } if object == "soup"), "{refused}");
}

#[test]
fn a_lamp_flush_with_the_ceiling_or_almost_touching_it_shines() {
    let panel = |y: f64| -> Quad { [[0.3, y, 0.3], [0.7, y, 0.3], [0.7, y, 0.7], [0.3, y, 0.7]] };
    let lit = |lamp: Quad| {
        let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
        let all: Vec<(Quad, u32)> = walls.into_iter().chain([(lamp, 1)]).collect();
        let materials = vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.0], &[10.0])];
        hold_to_the_laws(&quads(&all, materials), PatchSize::Edge(0.12))
    };
    let hanging = lit(panel(0.99));
    for y in [1.0, 1.0 - 1e-12, 1.0 - 1e-9, 1.0 - 1e-5] {
        let means = lit(panel(y));
        assert!((means[1] / hanging[1] - 1.0).abs() < 0.05, "at {y}: {means:?}, hanging: {hanging:?}");
    }
    // Turned towards the ceiling it almost touches, all its light stays there.
    let turned = lit(flipped(panel(1.0 - 1e-5)));
    assert!(turned[1] < 0.2 * hanging[1], "{turned:?}");
}
