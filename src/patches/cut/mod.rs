//! Cut: how faces are cut into cells, along the lines where others touch them, and how finely.

mod contacts;
mod cutter;
mod grid;
mod locator;
mod outlook;
mod parts;
mod size;
mod subdivide;

pub use cutter::Cutter;
pub use outlook::{Outlook, Stretch};
pub(crate) use parts::{Parting, Parts};
pub use subdivide::Barycentrics;
pub(crate) use subdivide::{Cuts, Uncut};
