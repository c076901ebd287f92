//! Scattering: what surfaces that are not diffuse do with a ray: mirrors, glass, rough metal, coats.

mod coat;
mod fresnel;
mod gloss;
mod media;
mod scatter;
mod specular_path;
mod tint;

pub use coat::Coat;
pub use fresnel::fresnel;
pub(crate) use gloss::Gloss;
pub(crate) use media::Media;
pub use scatter::{Glossy, Scattered};
pub use specular_path::Destination;
pub(crate) use specular_path::SpecularPath;
pub use tint::Tint;
