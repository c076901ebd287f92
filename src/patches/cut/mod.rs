//! Cut: how faces are cut into cells, along the lines where others touch them, and how finely.

mod contacts;
mod cutter;
mod fineness;
mod grid;
mod lit_share;
mod locator;
mod outlook;
mod part;
mod parts;
mod size;
mod subdivide;
mod surroundings;

pub use cutter::Cutter;
pub(crate) use fineness::Fineness;
pub use outlook::{Outlook, Stretch};
pub(crate) use parts::{Parting, Parts};
pub use subdivide::Barycentrics;
pub(crate) use subdivide::Cuts;
