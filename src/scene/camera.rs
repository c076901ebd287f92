//! Camera: a pinhole that looks at the scene.

use glam::DVec3;

use super::is_near;

/// A pinhole camera in scene coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the pinhole is, metres.
    pub position: DVec3,
    /// The point it looks at, metres.
    pub target: DVec3,
    /// Which way is up in the picture.
    pub up: DVec3,
    /// Vertical field of view, degrees.
    pub fov: f64,
}

impl Camera {
    /// Right, up and forward unit vectors of the picture.
    pub fn axes(&self) -> [DVec3; 3] {
        let forward = (self.target - self.position).normalize();
        let side = forward.cross(self.up);
        let right =
            if side.length_squared() > 1e-12 { side.normalize() } else { forward.any_orthonormal_vector() };
        [right, right.cross(forward), forward]
    }

    /// Whether position, target, up and field of view describe a picture at all.
    pub fn is_valid(&self) -> bool {
        let sound = [self.position, self.target, self.up].into_iter().all(is_near);
        sound && self.position != self.target && self.up != DVec3::ZERO && self.fov > 0.0 && self.fov < 180.0
    }
}
