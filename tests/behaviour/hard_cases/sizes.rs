//! Flat boxes, and tiny faces beside large ones.

use radiosity::patches::PatchSize;
use radiosity::scene::{Material, Scene};

use super::hold_to_the_laws;
use crate::scenes::{Quad, quads, room};

fn furnace(low: [f64; 3], high: [f64; 3]) -> Scene {
    quads(&room(low, high).map(|quad| (quad, 0)), vec![Material::lamp("wall", &[0.5], &[1.0])])
}

#[test]
fn a_flat_box_closes() {
    let means = hold_to_the_laws(&furnace([0.0; 3], [1.0, 0.02, 1.0]), PatchSize::Count(800));
    assert!(means.iter().all(|mean| (mean - 2.0).abs() < 1e-9), "{means:?}");
}

#[test]
fn area_ratios_of_ten_billion_do_no_harm() {
    // A speck of 10 µm stands in a room of 1 m and one patch a wall.
    let s = 1e-5;
    let speck: Quad = [[0.5, 0.2, 0.5], [0.5 + s, 0.2, 0.5], [0.5 + s, 0.2, 0.5 + s], [0.5, 0.2, 0.5 + s]];
    let mut all: Vec<(Quad, u32)> = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0)).to_vec();
    all.push((speck, 1));
    let materials = vec![Material::lamp("wall", &[0.5], &[1.0]), Material::diffuse("speck", &[0.5])];
    let scene = quads(&all, materials);
    let means = hold_to_the_laws(&scene, PatchSize::Edge(0.4));
    // The speck receives the furnace's light and reflects half.
    assert!((means[6] - 1.0).abs() < 1e-3, "{means:?}");
}
