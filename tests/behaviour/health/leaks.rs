//! Leaks, cracks and open edges, and what looks like them.

use radiosity::measure::{Finding, Grade};
use radiosity::scene::Material;

use super::{closed_room, judged, only, room_with_lamp, scene, shifted};
use crate::scenes::{Quad, quads, room};

#[test]
fn a_ceiling_that_does_not_reach_the_walls_leaks() {
    let cracked = closed_room(|k, wall| if k == 4 { shifted(wall, [0.0, 0.005, 0.0]) } else { wall });
    let leaks = only(&cracked, "leaks", Grade::Bad);
    assert!(leaks.value > 1e-4 && leaks.value < 0.01, "{leaks:?}");
    assert!(!leaks.faces.is_empty() && leaks.faces.len() <= Finding::MOST_FACES);
    let cracks = judged(&cracked, "cracks", Grade::Note);
    assert!((cracks.value - 0.005).abs() < 1e-9, "{cracks:?}");
    assert_eq!(cracks.count, Some(8), "four edges on either side");
}

#[test]
fn a_leak_is_found_where_the_light_that_escapes_meets_an_outside() {
    let walls = room([0.0; 3], [1.0; 3]);
    let mut walls: Vec<Quad> = walls
        .iter()
        .enumerate()
        .map(|(k, &w)| if k == 3 { shifted(w, [0.005, 0.0, 0.0]) } else { w })
        .collect();
    let ground = [[-3.0, -0.1, -3.0], [-3.0, -0.1, 3.0], [3.0, -0.1, 3.0], [3.0, -0.1, -3.0]];
    let lamp = walls.remove(5);
    walls.push(ground);
    let leaks = judged(&scene(&walls, &[lamp]), "leaks", Grade::Bad);
    assert!(
        !leaks.faces.contains(&10) && !leaks.faces.contains(&11),
        "the ground is not at fault: {leaks:?}"
    );
}

#[test]
fn vertices_off_by_rounding_are_cracks_but_no_leak() {
    let off = closed_room(|k, wall| if k == 4 { shifted(wall, [0.0, 1e-8, 0.0]) } else { wall });
    judged(&off, "cracks", Grade::Note);
    judged(&off, "leaks", Grade::Good);
    judged(&off, "open edges", Grade::Note);
}

#[test]
fn windows_are_no_cracks_and_open_scenes_do_not_leak() {
    let mut walls = room([0.0; 3], [1.0; 3]).to_vec();
    let lamp = walls.pop().unwrap();
    let back = walls.remove(3);
    // The wall x = 1 around a window.
    let piece = |z: [f64; 2], y: [f64; 2]| {
        [[1.0, y[0], z[0]], [1.0, y[0], z[1]], [1.0, y[1], z[1]], [1.0, y[1], z[0]]]
    };
    assert_eq!(back, piece([0.0, 1.0], [0.0, 1.0]));
    let around = [
        piece([0.0, 1.0], [0.0, 0.3]),
        piece([0.0, 1.0], [0.7, 1.0]),
        piece([0.0, 0.3], [0.3, 0.7]),
        piece([0.7, 1.0], [0.3, 0.7]),
    ];
    let with_window = scene(&[walls.clone(), around.to_vec()].concat(), &[lamp]);
    let leaks = only(&with_window, "leaks", Grade::Note);
    assert!(leaks.remedy.is_some_and(|remedy| remedy.contains("window")));
    judged(&with_window, "cracks", Grade::Good);
    let open = scene(&walls, &[lamp]);
    let leaks = only(&open, "leaks", Grade::Good);
    assert!(leaks.value > 0.1, "{leaks:?}");
    let edges = judged(&open, "open edges", Grade::Note);
    assert_eq!((edges.value, edges.faces.len()), (4.0, 1), "one rim of four edges");
}

#[test]
fn the_open_sky_over_a_floor_is_too_wide_to_be_measured() {
    let floor = [[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0]];
    let lamp = [[0.0, 2.0, 0.0], [0.1, 2.0, 0.0], [0.1, 2.0, 0.1], [0.0, 2.0, 0.1]];
    let materials = vec![Material::diffuse("floor", &[0.05]), Material::lamp("lamp", &[0.0], &[1.0])];
    let leaks = judged(&quads(&[(floor, 0), (lamp, 1)], materials), "leaks", Grade::Note);
    let remedy = leaks.remedy.unwrap();
    assert!(remedy.contains("too wide to be measured") && !remedy.contains("inf"), "{remedy}");
}

#[test]
fn ribbons_are_no_cracks() {
    let (walls, lamp) = room_with_lamp(0.9);
    let ribbon = [[0.1, 0.1, 0.5], [0.9, 0.1, 0.5], [0.9, 0.1, 0.503], [0.1, 0.1, 0.503]];
    judged(&scene(&[walls, vec![ribbon]].concat(), &[lamp]), "cracks", Grade::Good);
}
