//! Rows: what the rays of each patch found, before it becomes a matrix.
//!
//! A [`Recipe`] tells which rays a patch sends. Each ends on a side, by way of carriers or straight, or
//! leaves: an [`End`]. Lamps are looked for besides ([`Look`]), and lamps that shine by way of carriers shoot
//! [`Caustics`]. Channels that carriers treat alike are one of the [`Tones`].

mod caustics;
mod lamp_columns;
mod landing;
mod rays;
mod recipe;
mod tones;

pub(super) use caustics::{Caustic, Caustics};
pub(super) use lamp_columns::{LampShare, Look};
pub(super) use landing::{ABSORBED, ESCAPED, End, LOST, Landing, Spot};
pub(super) use rays::{Row, Rows, origins};
pub(crate) use recipe::BATCHES;
pub use recipe::Shots;
pub(super) use recipe::{RAYS_PER_SHOT, RayCount, Recipe, RowOptions};
pub(super) use tones::Tones;
