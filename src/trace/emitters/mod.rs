//! Emitters: lamps, lights without area and the sky, how they are sampled, and how they shoot at what passes
//! light on.

mod environment;
mod lamps;
mod lights;
mod narrow;
mod shots;
mod sky;

pub use lamps::{LampPoint, LampView, Lamps};
pub(crate) use lights::Arrival;
pub use lights::{Beam, Lights};
pub(crate) use narrow::NarrowCone;
pub use shots::{Shot, SkyShot, Targets};
pub use sky::{SkyBeam, SkySampler, SkyView};
