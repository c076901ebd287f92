//! Lens: from places in the picture to rays, and back.

use glam::{DVec2, DVec3};

use crate::scene::Camera;
use crate::trace::{Ray, Tracer};

/// The camera in the normalised frame; a pixel's place to a direction.
pub(super) struct Lens {
    origin: DVec3,
    /// Unit vectors right, up and forward.
    axes: [DVec3; 3],
    /// Middle of the picture, pixels.
    middle: DVec2,
    /// Size of a pixel on the plane at distance 1.
    pixel: f64,
}

impl Lens {
    pub fn new(tracer: &Tracer, camera: &Camera, width: usize, height: usize) -> Self {
        Self {
            origin: tracer.frame().from_world(camera.position),
            axes: camera.axes(),
            middle: 0.5 * DVec2::new(width as f64, height as f64),
            pixel: 2.0 * (0.5 * camera.fov.to_radians()).tan() / height as f64,
        }
    }

    /// The ray through a point of the picture (pixels, down from the top left corner).
    pub fn ray(&self, point: DVec2) -> Ray {
        let [right, up, forward] = self.axes;
        let at = (point - self.middle) * self.pixel;
        Ray {
            origin: self.origin,
            direction: (forward + right * at.x - up * at.y).normalize(),
            from: Ray::FREE,
        }
    }

    /// How far a point of the picture lies from the image of the line through p and q, pixels.
    pub fn distance_to_line(&self, point: DVec2, p: DVec3, q: DVec3) -> f64 {
        let [right, up, forward] = self.axes;
        // The line and the pinhole span a plane, which cuts the picture in the line's image.
        let normal = (p - self.origin).cross(q - self.origin);
        let (x, y) = (normal.dot(right), -normal.dot(up));
        let at = (point - self.middle) * self.pixel;
        (at.x * x + at.y * y + normal.dot(forward)).abs() / (x.hypot(y).max(1e-300) * self.pixel)
    }
}
