//! Reach: which sides light reaches, and so which cells become patches.

mod carried;
mod facing;
mod sides;
mod through;

pub use facing::seeing_sides;
pub(crate) use facing::{FaceSide, Facing, Members};
pub use sides::Reach;
pub(crate) use sides::{GLANCE, LOOK};
