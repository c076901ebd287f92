//! Textured: what textures say of a scene's faces, and which faces do not know what of a picture they show.

use glam::DVec2;

use super::texture::FaceTexture;
use crate::scene::grouped::count;
use crate::scene::{Face, FaceState, Material, Scene};

impl Scene {
    /// Whether the reflectance or emission of any face varies over it.
    pub fn has_textures(&self) -> bool {
        !self.texture_coordinates.is_empty()
    }

    /// What varies the reflectance of a face, if anything does.
    #[inline]
    pub fn reflectance_texture(&self, face: usize) -> Option<FaceTexture<'_>> {
        let corners = *self.texture_coordinates.get(face)?;
        let texture = self.material_of(face).textures.reflectance.as_ref()?;
        Some(FaceTexture { texture, corners })
    }

    /// What varies the emission of a face's front, if anything does.
    #[inline]
    pub fn emission_texture(&self, face: usize) -> Option<FaceTexture<'_>> {
        let corners = *self.texture_coordinates.get(face)?;
        let texture = self.material_of(face).textures.emission.as_ref()?;
        Some(FaceTexture { texture, corners })
    }

    /// Emitted radiance of a face's front in the mean over the face, per channel, W·sr⁻¹·m⁻².
    pub fn mean_emission(&self, face: usize) -> Vec<f64> {
        let mut emission = self.material_of(face).emission.clone();
        if let Some(texture) = self.emission_texture(face) {
            emission.iter_mut().zip(texture.mean()).for_each(|(e, factor)| *e *= factor);
        }
        emission
    }
}

/// Says which textured materials have faces that do not know what of the picture they show.
pub(crate) fn warn_of_missing_coordinates(
    faces: &[Face],
    coordinates: &[Option<[DVec2; 3]>],
    materials: &[Material],
    warnings: &mut Vec<String>,
) {
    for (number, material) in (0u32..).zip(materials).filter(|(_, material)| material.is_textured()) {
        let lacks = |(face, coordinates): &(&Face, &Option<[DVec2; 3]>)| {
            face.material == number && face.state == FaceState::Kept && coordinates.is_none()
        };
        let lacking = faces.iter().zip(coordinates).filter(lacks).count();
        if lacking > 0 {
            warnings.push(format!(
                "material {}: {} without texture coordinates (vt) take the mean of the picture; unwrap the mesh to show it",
                material.name,
                count(lacking, "face")
            ));
        }
    }
}
