//! Sound scenes: nothing is bad.

use std::path::Path;

use radiosity::measure::Grade;
use radiosity::scene::Scene;

use super::{OPERATOR, check, closed_room, find};
use crate::scratch::names;

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
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes");
    for name in names(&folder).iter().filter(|name| name.ends_with(".obj")) {
        let findings = check(&Scene::load(folder.join(name)).unwrap());
        let wrong: Vec<_> = findings.iter().filter(|f| f.verdict > Grade::Note).collect();
        assert!(wrong.is_empty(), "{name}: {wrong:#?}");
        assert_eq!(find(&findings, "lamps").verdict, Grade::Good, "{name}");
        assert_eq!(find(&findings, "leaks").verdict, Grade::Good, "{name}");
    }
}
