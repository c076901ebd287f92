//! Sound scenes: nothing is bad.

use radiosity::measure::Grade;

use super::{OPERATOR, check, closed_room, find};
use crate::scenes::{mesh, meshes};

#[test]
fn a_sound_closed_room_is_good_in_every_way() {
    let findings = check(&closed_room(|_, wall| wall));
    let bad: Vec<_> = findings.iter().filter(|f| f.verdict != Grade::Good || f.remedy.is_some()).collect();
    assert!(bad.is_empty(), "{bad:#?}");
    assert_eq!(find(&findings, "leaks").value, 0.0);
    assert_eq!(find(&findings, "reciprocity").value, 0.0);
    assert!(OPERATOR.iter().all(|name| find(&findings, name).value.is_finite()));
}

#[test]
fn the_meshes_of_this_project_have_nothing_bad() {
    for name in meshes() {
        let findings = check(&mesh(&name));
        let wrong: Vec<_> = findings.iter().filter(|f| f.verdict > Grade::Note).collect();
        assert!(wrong.is_empty(), "{name}: {wrong:#?}");
        assert_eq!(find(&findings, "lamps").verdict, Grade::Good, "{name}");
        assert_eq!(find(&findings, "leaks").verdict, Grade::Good, "{name}");
    }
}
