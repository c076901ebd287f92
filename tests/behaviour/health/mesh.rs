//! Faces and edges: winding, slivers, zero area, duplicates, non-manifold edges, T-junctions, size.

use radiosity::measure::Grade;

use super::{closed_room, judged, materials, only, room_with_lamp, scene, triangles};
use crate::scenes::{flipped, quads, room};

#[test]
fn a_flipped_wall_is_noted_with_its_faces() {
    let turned = closed_room(|k, wall| if k == 1 { flipped(wall) } else { wall });
    let winding = only(&turned, "winding", Grade::Note);
    assert_eq!((winding.value, winding.count, winding.faces), (2.0, Some(4), vec![2, 3]));
}

#[test]
fn slivers_are_noted_and_needles_bad() {
    let with = |width: f64| {
        let (walls, lamp) = room_with_lamp(0.9);
        let thin = [[0.1, 0.5, 0.5], [0.9, 0.5, 0.5], [0.9, 0.5, 0.5 + width], [0.1, 0.5, 0.5 + width]];
        scene(&[walls, vec![thin]].concat(), &[lamp])
    };
    judged(&with(0.1), "slivers", Grade::Good);
    let slivers = only(&with(1e-4), "slivers", Grade::Note);
    assert!((slivers.value / 8e3 - 1.0).abs() < 1e-3 && slivers.count == Some(2), "{slivers:?}");
    assert_eq!(slivers.faces, [12, 13]);
    only(&with(1e-8), "slivers", Grade::Bad);
}

#[test]
fn zero_area_faces_and_duplicates_are_noted() {
    let walls = room([0.0; 3], [1.0; 3]);
    let mut faces: Vec<_> = walls.iter().flat_map(|&[a, b, c, d]| [([a, b, c], 0), ([a, c, d], 0)]).collect();
    faces[11].1 = 1;
    faces.push(([[0.1; 3], [0.5; 3], [0.9; 3]], 0));
    faces.push(faces[2]);
    let both = triangles(&faces);
    let flat = only(&both, "zero-area faces", Grade::Note);
    assert_eq!((flat.value, flat.faces), (1.0, vec![12]));
    let twice = only(&both, "duplicate faces", Grade::Note);
    assert_eq!((twice.value, twice.faces), (1.0, vec![13]));
    assert_eq!(judged(&both, "open edges", Grade::Good).value, 0.0, "dropped faces open and close nothing");
}

#[test]
fn light_lost_with_a_duplicate_is_bad() {
    let walls = room([0.0; 3], [1.0; 3]);
    let lamp = room([0.0; 3], [1.0; 3])[4];
    let shadowed = quads(&[(walls[5], 1), (walls[4], 0), (lamp, 1)], materials());
    let found = judged(&shadowed, "duplicate faces", Grade::Bad);
    assert_eq!(found.faces, [4, 5]);
    // Two lamps back to back both shine; the same lamp twice shines once.
    let [a, b, c, d] = lamp;
    let sides = [([a, b, c], 1), ([a, c, d], 1), ([a, c, b], 1), (walls[0][..3].try_into().unwrap(), 0)];
    assert_eq!(judged(&triangles(&sides), "duplicate faces", Grade::Good).value, 0.0);
    judged(&triangles(&[sides[0], sides[0], sides[3]]), "duplicate faces", Grade::Note);
}

#[test]
fn walls_that_branch_are_noted_as_non_manifold() {
    let (mut walls, lamp) = room_with_lamp(0.9);
    // A fin from one corner of the room into its middle.
    walls.push([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 1.0, 0.3], [0.3, 0.0, 0.3]]);
    let found = only(&scene(&walls, &[lamp]), "non-manifold edges", Grade::Note);
    assert_eq!(found.value, 1.0);
}

#[test]
fn corners_along_an_edge_are_t_junctions() {
    let mut walls = room([0.0; 3], [1.0; 3]).to_vec();
    let lamp = walls.pop().unwrap();
    judged(&scene(&walls, &[lamp]), "T-junctions", Grade::Good);
    // The floor in two halves; each of two walls has a corner of theirs along its lower edge.
    let [a, b, c, d] = walls.remove(1);
    let middle = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
    walls.extend([[a, middle(a, b), middle(d, c), d], [middle(a, b), b, c, middle(d, c)]]);
    let split = scene(&walls, &[lamp]);
    assert_eq!(only(&split, "T-junctions", Grade::Note).value, 2.0);
    judged(&split, "leaks", Grade::Good);
    judged(&split, "cracks", Grade::Good);
}

#[test]
fn a_room_in_millimetres_is_noted() {
    let walls = room([0.0; 3], [4000.0; 3]);
    let size = only(&scene(&walls[..5], &walls[5..]), "size", Grade::Note);
    assert!(size.value == 4000.0 && size.remedy.is_some_and(|remedy| remedy.contains("unit")));
}
