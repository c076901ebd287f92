//! Form factors that are wrong: rows that do not close, light that escapes, patches without rays, directions
//! that disagree.

use radiosity::measure::{Cause, Level, Verdict};
use radiosity::patches::Basis;
use radiosity::scene::Side;
use radiosity::solve::Method;
use radiosity::transport::Disagreement;

use super::{Case, LAMP, lit_room, materials, only};
use crate::scenes::{flipped, quads, room};

#[test]
fn one_row_of_form_factors_that_does_not_close_is_named() {
    let scene = lit_room();
    for factor in [0.5, 0.99, 1.01] {
        let mut case = Case::new(&scene, 400, 64, Basis::Constant);
        let (mut areas, escape) = case.exchange();
        case.put_back((areas.clone(), escape.clone()));
        assert_eq!(case.judge(&case.solve(Method::Direct)), Verdict::default(), "rounded, but sound");
        // Of a patch's exchange with all others; the others lack as little as it is of what they see.
        let patch = case.patch_of(6);
        for j in 0..areas.ncols() {
            areas[(patch, j)] *= factor;
            areas[(j, patch)] = areas[(patch, j)];
        }
        case.put_back((areas, escape));
        let verdict = case.judge(&case.solve(Method::Direct));
        let closure = verdict.reasons.iter().find(|reason| reason.cause == Cause::Closure);
        assert!(closure.is_some_and(|reason| reason.faces.contains(&6)), "{factor}: {verdict:#?}");
        assert!(verdict.level >= Level::Doubtful);
    }
}

#[test]
fn form_factors_that_lose_a_tenth_of_all_light_are_bad() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 400, 64, Basis::Constant);
    let (areas, escape) = case.exchange();
    case.put_back((areas * 0.9, escape));
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::Closure, Level::Bad);
    assert!(reason.power_share.is_some_and(|share| share > 0.1) && reason.faces.len() == 14);
}

#[test]
fn rays_that_escape_from_a_closed_room_are_a_fault_and_through_a_window_are_none() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 400, 64, Basis::Constant);
    let (mut areas, mut escape) = case.exchange();
    areas *= 0.95;
    escape.axpy(0.05, &case.factors.exchange().areas(), 1.0);
    case.put_back((areas, escape));
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::Escape, Level::Bad);
    assert_eq!(reason.faces.len(), 14);

    let walls = room([0.0; 3], [2.0, 3.0, 2.5]).map(|wall| (wall, 0));
    // Without its ceiling, and with a closed box inside, whose outside sees the sky.
    let body = room([0.5, 0.5, 0.2], [1.0, 1.0, 1.0]).map(|side| (flipped(side), 0));
    let open = quads(&[&walls[..5], &[(LAMP, 1)], &body[..]].concat(), materials());
    let case = Case::new(&open, 400, 64, Basis::Constant);
    let solution = case.solve(Method::Direct);
    assert!(case.energy(&solution).escaped[0] > 0.0);
    assert_eq!(case.judge(&solution), Verdict::default());
}

#[test]
fn a_patch_without_rays_is_named() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 400, 64, Basis::Constant);
    let patch = case.patch_of(6);
    // Its area is that of nothing else, so that the others close without it.
    let (mut areas, mut escape) = case.exchange();
    for j in (0..areas.ncols()).filter(|&j| j != patch) {
        let lost = f64::from(std::mem::take(&mut areas[(j, patch)]));
        areas[(j, j)] += lost as f32;
        areas[(patch, j)] = 0.0;
    }
    areas[(patch, patch)] = 0.0;
    escape[patch] = 0.0;
    case.put_back((areas.clone(), escape.clone()));
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::NoRays, Level::Doubtful);
    assert_eq!(reason.faces, [6]);
    // The same where all that the patch sends out is said to escape, from a closed room.
    escape[patch] = case.factors.exchange().areas()[patch];
    case.put_back((areas, escape));
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::NoRays, Level::Doubtful);
    assert_eq!(reason.faces, [6]);
}

#[test]
fn directions_that_disagree_are_doubtful() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    assert!(case.factors.disagreements().is_empty());
    let pair = Disagreement { sides: [(7, Side::Front), (2, Side::Front)], z: 6.0 };
    case.factors = case.factors.clone().with_disagreements(vec![pair]);
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::Directions, Level::Doubtful);
    assert!(reason.faces.contains(&7) && reason.faces.contains(&2) && reason.faces.len() == 2);
}
