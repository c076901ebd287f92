//! Render: pictures of a solution.
//!
//! [`picture()`] looks at a radiance field through a camera and gives a [`Picture`] of linear radiance; an
//! [`Exposure`] makes it fit for a screen.

mod image;
mod limiter;
mod picture;
mod smooth;
#[cfg(test)]
pub(crate) mod test_scenes;
mod tone;
mod view;

pub use image::{Outlines, RenderOptions, Shading, Surfaces, picture};
pub(crate) use limiter::limited;
pub(crate) use picture::write_rgb_png;
pub use picture::{LampPart, Picture};
pub use smooth::SmoothField;
pub use tone::{Exposure, srgb, to_rgb};
pub(crate) use tone::{luminance, to_byte};
pub use view::default_camera;

use crate::progress::Cancelled;

/// Why a picture could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A picture of this size can't be made.
    #[error(
        "a picture can't be {width} x {height}; both must be at least 1 and at most 32768, and pixels at most 2²⁷ in all"
    )]
    Size {
        /// Pixels across.
        width: usize,
        /// Pixels down.
        height: usize,
    },
    /// So many random samples can't be taken.
    #[error("a pixel can't have {samples} samples; take 1 to 1048576")]
    Samples {
        /// Samples per pixel.
        samples: u32,
    },
    /// The camera can't make a picture.
    #[error(
        "camera: position and target must differ, up must not be zero, fov must lie between 0 and 180 degrees, and no number may be beyond 1e30"
    )]
    Camera,
    /// The observer asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
