//! Which side of a surface a light is on is geometry: however lamps are turned they light neither their own
//! backs nor their insides, and a light without area on a surface gives all its light to the side in front of
//! it.

mod lamps; // turned lamps, their backs and insides
mod lights; // lights without area on surfaces and beside them

use crate::scenes::room;

/// A closed room of 3 × 2.5 × 3 m, twelve faces.
fn walls() -> Vec<([[f64; 3]; 4], u32)> {
    room([0.0; 3], [3.0, 2.5, 3.0]).map(|quad| (quad, 0)).to_vec()
}
