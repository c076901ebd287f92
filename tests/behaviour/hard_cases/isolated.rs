//! Surfaces that see little or nothing of the rest of the scene.

use radiosity::patches::{PatchSize, Patches, Reach, Tessellation};
use radiosity::scene::{Material, Scene, SceneParts};
use radiosity::trace::Tracer;
use radiosity::transport::Transport;

use super::{factors, hold_to_the_laws, iterative, lit_room};
use crate::scenes::{Quad, STORAGES, direct, grey, quads, room, unit_square};

#[test]
fn a_single_lamp_in_empty_space_keeps_its_light_to_none() {
    let lamp = unit_square(0.0);
    let scene = quads(&[(lamp, 0)], vec![Material::lamp("lamp", &[0.5], &[2.0])]);
    for size in [PatchSize::Edge(10.0), PatchSize::Count(100)] {
        let means = hold_to_the_laws(&scene, size);
        assert_eq!(means, [2.0]);
    }
}

#[test]
fn two_patches_solve_their_two_equations() {
    // Two triangles face each other; each is one patch.
    let mut parts = SceneParts { name: "pair".into(), objects: vec!["pair".into()], ..Default::default() };
    parts.materials = vec![Material::lamp("lamp", &[0.6], &[1.0]), Material::diffuse("grey", &[0.8])];
    let both = quads(
        &[(unit_square(0.0), 0), ([[0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [1.0, 0.5, 1.0], [0.0, 0.5, 1.0]], 1)],
        parts.materials.clone(),
    );
    parts.vertices = both.vertices().to_vec();
    parts.faces = vec![both.faces()[0].clone(), both.faces()[2].clone()];
    parts.faces.iter_mut().for_each(|face| face.object = 0);
    let scene = Scene::new(parts).unwrap();
    for storage in STORAGES {
        let (patches, factors) = factors(&scene, PatchSize::Edge(10.0), storage);
        assert_eq!(patches.len(), 2);
        let f = factors.exchange().form_factor(0, 1);
        assert!(f > 0.1 && f < 0.9);
        let k = Transport::of(&factors, &patches).unwrap();
        let e = patches.emitted_radiance();
        // L1 = 1 + 0.6 f L2 and L2 = 0.8 f L1, for equal areas.
        let first = 1.0 / (1.0 - 0.6 * 0.8 * f * f);
        for solution in iterative(&k, &e).into_iter().chain([direct(&k, &e)]) {
            assert!((solution.radiance[0] - first).abs() < 1e-8);
            assert!((solution.radiance[1] - 0.8 * f * first).abs() < 1e-8);
        }
    }
}

#[test]
fn a_room_without_light_stays_black_beside_one_with_light() {
    let lit = lit_room(0.7, &[]);
    let both = lit_room(0.7, &room([2.0, 0.0, 0.0], [3.0, 1.0, 1.0]));
    let alone = hold_to_the_laws(&lit, PatchSize::Edge(0.2));
    let beside = hold_to_the_laws(&both, PatchSize::Edge(0.2));
    assert!(beside[7..].iter().all(|&mean| mean == 0.0));
    for (a, b) in alone.iter().zip(&beside) {
        assert!((a - b).abs() < 0.05 * a, "{alone:?} {beside:?}");
    }
}

#[test]
fn rooms_that_never_see_each_other_solve_each_by_itself() {
    let mut all: Vec<(Quad, u32)> = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0)).to_vec();
    all.extend(room([5.0, 0.0, 0.0], [5.5, 2.0, 1.0]).map(|quad| (quad, 1)));
    let materials = vec![Material::lamp("half", &[0.5], &[1.0]), Material::lamp("bright", &[0.9], &[3.0])];
    let means = hold_to_the_laws(&quads(&all, materials), PatchSize::Count(400));
    assert!(means[..6].iter().all(|mean| (mean - 2.0).abs() < 1e-9), "{means:?}");
    assert!(means[6..].iter().all(|mean| (mean - 30.0).abs() < 1e-8), "{means:?}");
}

#[test]
fn nothing_is_a_patch_where_nothing_sees_anything() {
    let wall: Quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let scene = quads(&[(wall, 0)], grey(0.5));
    let tracer = Tracer::new(&scene);
    for reach in [Reach::Light, Reach::Everything] {
        let options = Tessellation { size: PatchSize::Count(50), reach, ..Default::default() };
        assert!(Patches::new(&tracer, &options).unwrap().is_empty());
    }
}
