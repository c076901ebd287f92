//! Colour: as settings give it.

use serde::Deserialize;

use super::list::Vector;

/// One number for every channel, or one each.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "a colour is one number, or three in brackets")]
pub(crate) enum Colour {
    Grey(f64),
    Rgb(Vector),
}

impl Colour {
    pub fn channels(&self) -> Vec<f64> {
        match self {
            Colour::Grey(value) => vec![*value; 3],
            Colour::Rgb(values) => values.0.to_vec(),
        }
    }
}
