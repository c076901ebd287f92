//! Lamps and lights whose light is missing from the answer.

use radiosity::measure::{Cause, Level, Verdict};
use radiosity::patches::Basis;
use radiosity::scene::Side;
use radiosity::solve::Method;

use super::{Case, lit_room, materials, only};
use crate::scenes::{lit_quads, point, room};

#[test]
fn a_dropped_lamp_is_missed_even_where_everything_else_adds_up() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    let lamp = case.patch_of(12);
    case.sources.emitted[(lamp, 0)] = 0.0;
    let solution = case.solve(Method::Direct);
    let reason = only(&case.judge(&solution), Cause::MissingLamps, Level::Bad);
    assert_eq!(reason.faces, [12]);
    assert!(reason.power_share.is_some_and(|share| share > 0.05));
}

#[test]
fn a_lamp_that_shines_from_its_other_side_is_missed() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    let [front, back] = Side::BOTH.map(|side| case.patches.patches_of(12, side));
    assert!(!back.is_empty());
    for (front, back) in front.zip(back) {
        case.sources.emitted.swap_rows(front, back);
    }
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::MissingLamps, Level::Bad);
    assert_eq!(reason.faces, [12]);
}

#[test]
fn lights_without_area_that_were_left_out_are_missed() {
    let walls = room([0.0; 3], [2.0; 3]).map(|wall| (wall, 0));
    let light = point([1.0; 3], &[5.0]);
    let scene = lit_quads(&walls, materials(), vec![light], None);
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    assert_eq!(case.judge(&case.solve(Method::Direct)), Verdict::default());
    case.sources.direct = None;
    only(&case.judge(&case.solve(Method::Direct)), Cause::MissingLamps, Level::Bad);
}
