//! Part: a triangle of a face that is cut by itself.

use glam::{DVec2, DVec3};

/// A triangle of a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// As points of the face.
    pub on_face: [DVec2; 3],
    /// Normalised frame.
    pub corners: [DVec3; 3],
}

impl Part {
    /// A whole face.
    pub fn whole(corners: &[DVec3; 3]) -> Self {
        Self { on_face: [DVec2::ZERO, DVec2::X, DVec2::Y], corners: *corners }
    }

    /// The two parts left and right of the middle of the longest side.
    pub fn halves(&self) -> [Self; 2] {
        let length = |k: usize| self.corners[k].distance_squared(self.corners[(k + 1) % 3]);
        let a = (0..3).max_by(|&j, &k| length(j).total_cmp(&length(k))).unwrap_or(0);
        let b = (a + 1) % 3;
        let (on_face, corner) =
            (self.on_face[a].midpoint(self.on_face[b]), self.corners[a].midpoint(self.corners[b]));
        [a, b].map(|end| {
            let mut half = *self;
            (half.on_face[end], half.corners[end]) = (on_face, corner);
            half
        })
    }
}
