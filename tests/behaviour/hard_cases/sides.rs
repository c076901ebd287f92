//! Which side is the front: winding, and sheets lit from both sides.

use radiosity::patches::PatchSize;
use radiosity::scene::{Material, Scene};
use radiosity::transport::{StorageKind, Transport};

use super::{factors, hold_to_the_laws, lit_room};
use crate::scenes::{Quad, direct, flipped, parts_of, quads};

#[test]
fn inverted_winding_of_walls_changes_nothing_and_of_lamps_turns_them_round() {
    let usual = lit_room(0.6, &[]);
    let size = PatchSize::Edge(0.1);
    let means = hold_to_the_laws(&usual, size);
    let flip = |which: &dyn Fn(usize) -> bool| {
        let mut parts = parts_of(&usual);
        let faces = parts.faces.iter_mut().enumerate();
        faces.filter(|(k, _)| which(k / 2)).for_each(|(_, face)| face.vertices.swap(1, 2));
        hold_to_the_laws(&Scene::new(parts).unwrap(), size)
    };
    let walls_flipped = flip(&|quad| quad < 3);
    for (a, b) in means.iter().zip(&walls_flipped) {
        assert!((a - b).abs() < 0.03 * a, "{means:?} {walls_flipped:?}");
    }
    // Quad 1 is the floor, quad 4 the ceiling.
    let lamp_flipped = flip(&|quad| quad == 6);
    assert!(
        means[1] > 1.2 * lamp_flipped[1] && lamp_flipped[4] > 2.0 * means[4],
        "{means:?} {lamp_flipped:?}"
    );
}

#[test]
fn an_open_sheet_is_lit_from_both_sides() {
    let sheet: Quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
    let above: Quad = [[0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [1.0, 0.5, 1.0], [0.0, 0.5, 1.0]];
    let below: Quad = flipped(above).map(|[x, _, z]| [x, -0.5, z]);
    let materials = vec![Material::diffuse("sheet", &[0.8]), Material::lamp("lamp", &[0.0], &[1.0])];
    let scene = quads(&[(sheet, 0), (above, 1), (below, 1)], materials);
    hold_to_the_laws(&scene, PatchSize::Count(600));
    let (patches, factors) = factors(&scene, PatchSize::Count(600), StorageKind::Auto);
    let k = Transport::of(&factors, &patches).unwrap();
    let rows = patches.average_by_face(&direct(&k, &patches.emitted_radiance()).irradiance);
    let sides: Vec<f64> = rows.iter().filter(|row| row.face < 2).map(|row| row.mean[0]).collect();
    assert_eq!(sides.len(), 4, "two faces, two sides each");
    assert!(sides.iter().all(|h| (h / sides[0] - 1.0).abs() < 0.05), "{sides:?}");
}
