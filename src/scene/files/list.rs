//! List: numbers of a settings file of which there are just so many.

use serde::de::{Deserialize, Deserializer, Error};

/// So many values; a list of any other length is refused.
#[derive(Clone, Copy, Debug)]
pub(super) struct List<T, const N: usize>(pub [T; N]);

/// Three numbers.
pub(super) type Vector = List<f64, 3>;

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for List<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let values = Vec::deserialize(deserializer)?;
        let wrong = |values: Vec<T>| D::Error::custom(format!("{} in place of {N} values", values.len()));
        values.try_into().map(Self).map_err(wrong)
    }
}
