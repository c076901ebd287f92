//! Lamps that face the wrong way, and scenes without any.

use radiosity::measure::Grade;

use super::{OPERATOR, check, find, judged, only, room_with_lamp, scene, triangles};
use crate::scenes::{flipped, room, unit_square};

#[test]
fn a_flipped_lamp_is_bad() {
    let floor = unit_square(0.0);
    let (_, lamp) = room_with_lamp(1.0);
    only(&scene(&[floor], &[lamp]), "lamps", Grade::Good);
    let found = only(&scene(&[floor], &[flipped(lamp)]), "lamps", Grade::Bad);
    assert_eq!((found.value, found.faces), (2.0, vec![2, 3]));
    assert!(found.remedy.is_some_and(|remedy| remedy.contains("flip")));
}

#[test]
fn a_lamp_that_lights_the_ceiling_it_hangs_from_is_noted() {
    let (walls, lamp) = room_with_lamp(0.995);
    judged(&scene(&walls, &[lamp]), "lamps", Grade::Good);
    judged(&scene(&walls, &[flipped(lamp)]), "lamps", Grade::Note);
    let (walls, uplight) = room_with_lamp(0.7);
    judged(&scene(&walls, &[flipped(uplight)]), "lamps", Grade::Good);
}

#[test]
fn a_bulb_turned_inside_out_is_bad_and_a_furnace_is_not() {
    let walls = room([0.0; 3], [1.0; 3]);
    let bulb = room([0.4; 3], [0.6; 3]);
    only(&scene(&walls, &bulb.map(flipped)), "lamps", Grade::Good);
    let found = only(&scene(&walls, &bulb), "lamps", Grade::Bad);
    assert_eq!((found.value, found.faces.len()), (12.0, 10), "at most ten are named");
    only(&scene(&[], &walls), "lamps", Grade::Good);
}

#[test]
fn a_lamp_of_which_one_half_is_flipped_is_bad() {
    let (walls, lamp) = room_with_lamp(0.5);
    let [a, b, c, d] = lamp;
    let wall_faces = walls.iter().flat_map(|&[a, b, c, d]| [([a, b, c], 0), ([a, c, d], 0)]);
    let with_lamp = |halves: [[[f64; 3]; 3]; 2]| {
        triangles(&wall_faces.clone().chain(halves.map(|half| (half, 1))).collect::<Vec<_>>())
    };
    judged(&with_lamp([[a, b, c], [a, c, d]]), "lamps", Grade::Good);
    judged(&with_lamp([[a, b, c], [a, d, c]]), "lamps", Grade::Bad);
}

#[test]
fn a_scene_without_a_lamp_is_checked_and_told_so() {
    let dark = scene(&room([0.0; 3], [1.0; 3]), &[]);
    only(&dark, "lamps", Grade::Note);
    let findings = check(&dark);
    OPERATOR.iter().for_each(|name| assert_eq!(find(&findings, name).verdict, Grade::Good));
    // Nothing sees anything: there is no operator to look at.
    let plate = scene(&room([0.0; 3], [1.0; 3])[..1], &[]);
    assert!(check(&plate).iter().all(|f| f.verdict <= Grade::Note && f.name != "closure"));
}
