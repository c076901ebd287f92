//! Colour: as settings give it.

use serde::Deserialize;

/// One number for every channel, or one each.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "a colour is one number, or three in brackets")]
pub(crate) enum Colour {
    Grey(f64),
    Rgb([f64; 3]),
}

impl Colour {
    pub fn channels(&self) -> Vec<f64> {
        match self {
            Colour::Grey(value) => vec![*value; 3],
            Colour::Rgb(values) => values.to_vec(),
        }
    }
}
