//! The operator: condition, closure, reciprocity.

use nalgebra::{DMatrix, DVector};
use radiosity::measure::{Grade, operator_health};
use radiosity::patches::{PatchSize, Patches, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::Material;
use radiosity::trace::Tracer;
use radiosity::transport::{Exchange, FormFactors, Storage};
use serde_json::Value;

use super::{find, only, triangles};
use crate::scenes::{quads, room};

#[test]
fn a_closed_room_that_absorbs_nothing_has_no_condition_and_one_that_absorbs_little_a_bad_one() {
    let with = |reflectance: f64| {
        let walls = room([0.0; 3], [1.0; 3]).map(|wall| (wall, 1));
        let materials =
            vec![Material::diffuse("grey", &[0.5]), Material::lamp("snow", &[reflectance], &[1.0])];
        quads(&walls, materials)
    };
    let trapped = only(&with(1.0), "condition", Grade::Bad);
    assert!(trapped.value.is_infinite());
    assert_eq!(serde_json::to_value(&trapped).unwrap()["value"], Value::Null);
    assert!(trapped.remedy.is_some_and(|remedy| remedy.contains("snow")));
    only(&with(0.9), "condition", Grade::Good);
    let fair = only(&with(0.999), "condition", Grade::Fair);
    assert!((1e3..3e3).contains(&fair.value) && fair.remedy.is_some_and(|remedy| remedy.contains("snow")));
    only(&with(0.9999999), "condition", Grade::Bad);
}

#[test]
fn damaged_exchange_areas_are_bad() {
    let facing = triangles(&[
        ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 1),
        ([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]], 0),
    ]);
    let tracer = Tracer::new(&facing);
    let cut = Tessellation { size: PatchSize::Edge(10.0), ..Default::default() };
    let patches = Patches::new(&tracer, &cut).unwrap();
    assert_eq!(patches.len(), 2);
    let health = |entries: [f32; 2], areas: [f64; 2], escape: f64| {
        let storage = Storage::Dense(DMatrix::from_column_slice(2, 2, &[0.0, entries[0], entries[1], 0.0]));
        let (escape, areas) = (DVector::repeat(2, escape), DVector::from_row_slice(&areas));
        let exchange = Exchange::new(storage, escape, areas, &[false; 2], Progress::default()).unwrap();
        operator_health(&FormFactors::from(exchange), &patches, Progress::default()).unwrap()
    };
    let sound = health([0.5, 0.5], [1.0, 2.0], 0.5);
    assert!(sound.iter().all(|f| f.verdict == Grade::Good), "{sound:#?}");
    // What the small one sends can't be all that the large one gets, if nothing escapes.
    let unclosed = health([1.0, 1.0], [1.0, 2.0], 0.0);
    let closure = find(&unclosed, "closure");
    assert!(closure.verdict == Grade::Bad && closure.value > 0.1 && !closure.faces.is_empty(), "{closure:?}");
    let lopsided = health([0.5, 0.4], [1.0, 1.0], 0.5);
    let reciprocity = find(&lopsided, "reciprocity");
    assert!(reciprocity.verdict == Grade::Bad && reciprocity.value > 0.01, "{reciprocity:?}");
}
