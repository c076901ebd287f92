//! A reason as text.

use radiosity::measure::{Cause, Level};
use radiosity::patches::Basis;
use radiosity::scene::Side;
use radiosity::solve::Method;
use radiosity::transport::Disagreement;

use super::{Case, lit_room, only};

#[test]
fn a_reason_is_told_in_one_line() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    let front = |face| (face, Side::Front);
    let pairs = [[0, 2], [4, 6], [1, 3], [5, 7]];
    let pairs = pairs.map(|pair| Disagreement { sides: pair.map(front), z: 9.0 });
    case.factors = case.factors.clone().with_disagreements(pairs.to_vec());
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::Directions, Level::Doubtful);
    let line = reason.to_string();
    let [a, b, c, ..] = reason.faces[..] else { panic!("{reason:?}") };
    assert!(line.starts_with("directions that disagree: "), "{line}");
    assert!(line.contains(&format!(" % of the light, at faces {a}, {b}, {c} and 5 more of quad ")), "{line}");
    assert!(line.ends_with(&format!(" and 1 more; {}", reason.remedy)) && !line.contains('\n'), "{line}");
}
