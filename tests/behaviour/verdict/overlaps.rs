//! Faces that overlap in one plane: mentioned where light depends on them, and not held against the answer.

use radiosity::measure::{Cause, Level, Verdict};
use radiosity::patches::Basis;
use radiosity::scene::Scene;
use radiosity::solve::Method;
use radiosity::trace::OverlapKind;

use super::{Case, LAMP, materials, only};
use crate::scenes::{flipped, quads, room};

/// The same with a rug in the floor's own plane.
fn room_with_rug() -> Scene {
    let walls = room([0.0; 3], [2.0, 3.0, 2.5]).map(|wall| (wall, 0));
    let rug = [[0.5, 0.5, 0.0], [1.5, 0.5, 0.0], [1.5, 2.0, 0.0], [0.5, 2.0, 0.0]];
    quads(&[&walls[..], &[(LAMP, 1), (rug, 0)]].concat(), materials())
}

#[test]
fn faces_that_overlap_are_told_and_do_no_harm() {
    let scene = room_with_rug();
    let case = Case::new(&scene, 200, 64, Basis::Constant);
    let verdict = case.judge(&case.solve(Method::Direct));
    let reason = only(&verdict, Cause::Overlap, Level::Good);
    assert!(reason.faces.iter().all(|face| [4, 5, 14, 15].contains(face)), "{reason:?}");
    assert!(["quad 2", "quad 7"].iter().all(|name| reason.objects.iter().any(|object| object == name)));
    // As much of the light as arrives on the floor and the rug.
    let solution = case.solve(Method::Direct);
    let areas = case.patches.areas();
    let flux = |i: usize| areas[i] * solution.irradiance[(i, 0)];
    let is_named = |i: &usize| reason.faces.contains(&case.patches.place(*i).face);
    let [named, all] =
        [0, 1].map(|k| (0..areas.len()).filter(|i| k == 1 || is_named(i)).map(flux).sum::<f64>());
    assert!((reason.power_share.unwrap() / (named / all) - 1.0).abs() < 1e-9, "{reason:?}");
}

#[test]
fn overlaps_that_no_light_has_to_do_with_are_not_told() {
    let standing = |underside: u32| {
        let walls = room([0.0; 3], [2.0, 3.0, 2.5]).map(|wall| (wall, 0));
        let boxes = [([0.4, 0.4], [1.0, 1.2], 0.5), ([0.7, 0.8], [1.6, 1.9], 0.8)];
        let sides = boxes.map(|([x, y], [to_x, to_y], height)| {
            let quads = room([x, y, 0.0], [to_x, to_y, height]).map(flipped);
            [0, 1, 2, 3, 4, 5].map(|side| (quads[side], if side == 2 { underside } else { 0 }))
        });
        quads(&[&walls[..], &[(LAMP, 1)], &sides[0], &sides[1]].concat(), materials())
    };
    let (dark, shining) = (standing(0), standing(1));
    let verdict = |scene: &Scene| {
        let case = Case::new(scene, 300, 64, Basis::Constant);
        assert!(case.tracer.overlaps().iter().any(|overlap| overlap.kind == OverlapKind::SameFront));
        case.judge(&case.solve(Method::Direct))
    };
    assert_eq!(verdict(&dark), Verdict::default());
    only(&verdict(&shining), Cause::Overlap, Level::Good);
}
