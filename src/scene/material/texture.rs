//! Texture: a picture that varies a material's reflectance or emission over its faces.
//!
//! What it says at a place multiplies what the material says: ρ(u, v) = Kd · map_Kd(u, v), Lₑ(u, v) = Ke ·
//! map_Ke(u, v).

use std::sync::Arc;

use glam::DVec2;

use super::pixels::{Beyond, Pixels};

/// A picture, and how it is laid on texture coordinates: u runs to the right and v up, and from 0 to 1 they
/// cross the picture once.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The picture, in linear light.
    pub pixels: Arc<Pixels>,
    /// By what texture coordinates are multiplied (`-s`); 1 where nothing is said.
    pub scale: DVec2,
    /// What is added to them then (`-o`); 0 where nothing is said.
    pub offset: DVec2,
    /// What lies beyond the picture: by default the picture again.
    pub beyond: Beyond,
}

impl Texture {
    /// A picture as it is, repeated all over the plane.
    pub fn new(pixels: Pixels) -> Self {
        Self { pixels: Arc::new(pixels), scale: DVec2::ONE, offset: DVec2::ZERO, beyond: Beyond::Repeat }
    }

    /// From texture coordinates to texels, from the left and from the top.
    fn place(&self, coordinates: DVec2) -> DVec2 {
        let DVec2 { x, y } = coordinates * self.scale + self.offset;
        let [width, height] = self.pixels.size().map(|count| count as f64);
        DVec2::new(x * width, (1.0 - y) * height)
    }

    /// What it says at texture coordinates.
    #[inline]
    pub fn at(&self, coordinates: DVec2) -> [f64; 3] {
        self.pixels.at(self.place(coordinates), [self.beyond; 2])
    }

    /// The mean over a triangle of texture coordinates.
    pub fn mean_over(&self, triangle: [DVec2; 3]) -> [f64; 3] {
        self.pixels.mean_over(triangle.map(|p| self.place(p)), [self.beyond; 2])
    }
}

/// The textures of a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Textures {
    /// What multiplies its reflectance (`map_Kd`).
    pub reflectance: Option<Texture>,
    /// What multiplies its emission (`map_Ke`).
    pub emission: Option<Texture>,
}

impl Textures {
    /// Those that there are.
    pub fn all(&self) -> impl Iterator<Item = &Texture> {
        self.reflectance.iter().chain(&self.emission)
    }
}

/// A texture on a face.
#[derive(Clone, Copy, Debug)]
pub struct FaceTexture<'s> {
    pub(crate) texture: &'s Texture,
    /// Texture coordinates of the face's corners; the whole picture's mean acts everywhere where there are
    /// none.
    pub(crate) corners: Option<[DVec2; 3]>,
}

impl FaceTexture<'_> {
    /// What it says at a point of the face, given by the weights of its second and third corner: factors for
    /// red, green and blue, of which a single channel takes the first.
    #[inline]
    pub fn at(&self, point: [f64; 2]) -> [f64; 3] {
        match &self.corners {
            Some(corners) => self.texture.at(on(corners, point)),
            None => self.texture.pixels.mean(),
        }
    }

    /// The mean over a triangle of the face.
    pub fn mean_over(&self, triangle: [[f64; 2]; 3]) -> [f64; 3] {
        match &self.corners {
            Some(corners) => self.texture.mean_over(triangle.map(|point| on(corners, point))),
            None => self.texture.pixels.mean(),
        }
    }

    /// The mean over all of the face.
    pub fn mean(&self) -> [f64; 3] {
        self.mean_over([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    }
}

fn on([a, b, c]: &[DVec2; 3], [u, v]: [f64; 2]) -> DVec2 {
    a + (b - a) * u + (c - a) * v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two texels across and two down: red, green over blue, black.
    fn four() -> Texture {
        Texture::new(Pixels::new(2, 2, vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]))
    }

    #[test]
    fn u_runs_to_the_right_and_v_up() {
        for (u, v, texel) in
            [(0.25, 0.75, [1.0, 0.0, 0.0]), (0.75, 0.75, [0.0, 1.0, 0.0]), (0.25, 0.25, [0.0, 0.0, 1.0])]
        {
            assert_eq!(four().at(DVec2::new(u, v)), texel);
            assert_eq!(four().at(DVec2::new(u + 3.0, v - 2.0)), texel, "it repeats");
        }
    }

    #[test]
    fn scale_and_offset_move_coordinates_and_not_the_picture() {
        let moved = Texture { scale: DVec2::splat(0.5), offset: DVec2::new(0.25, 0.5), ..four() };
        assert_eq!(moved.at(DVec2::new(0.0, 0.5)), [1.0, 0.0, 0.0]);
        let clamped = Texture { beyond: Beyond::Clamp, ..four() };
        assert_eq!(clamped.at(DVec2::new(-7.0, 9.0)), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_face_without_coordinates_has_the_mean_of_the_picture() {
        let texture = four();
        let face = FaceTexture { texture: &texture, corners: None };
        assert_eq!(face.at([0.1, 0.2]), [0.25; 3]);
        assert_eq!(face.mean(), [0.25; 3]);
    }
}
