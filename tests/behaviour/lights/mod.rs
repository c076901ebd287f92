//! Lights without area and skies: closed forms, the path tracer, energy, and what their settings mean.

mod closed_forms; // point lights, spots, suns and skies
mod narrow; // spots of any width
mod settings; // units, lengths, bad ones
mod solutions; // what is reflected, energy, light paths, the same bits

use crate::scenes::room;

/// A room with a hole in its front wall (z = 0), 1 m wide from x = 1 and 1 m high from y = 1; 3 m each way.
fn room_with_window() -> Vec<([[f64; 3]; 4], u32)> {
    let [left, bottom, front, right, top, back] = room([0.0; 3], [3.0; 3]);
    let strip = |x: [f64; 2], y: [f64; 2]| {
        [[x[0], y[0], 0.0], [x[1], y[0], 0.0], [x[1], y[1], 0.0], [x[0], y[1], 0.0]]
    };
    assert_eq!(front[2][2], 0.0);
    let around = [
        strip([0.0, 3.0], [0.0, 1.0]),
        strip([0.0, 3.0], [2.0, 3.0]),
        strip([0.0, 1.0], [1.0, 2.0]),
        strip([2.0, 3.0], [1.0, 2.0]),
    ];
    [left, bottom, right, top, back].into_iter().chain(around).map(|quad| (quad, 0)).collect()
}
