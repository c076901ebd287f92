//! Painted: the solution on surfaces whose textures are shown, L = Lₑ(u, v) + ρ(u, v) H/π.
//!
//! Patches know L̄ = L̄ₑ + ρ̄H/π, with means over the patch. What they reflect and ρ̄ are laid over the surface in the same way, and
//! H/π is the one by the other: so pictures neither blur textures nor show the patches that averaged them.

use glam::DVec3;
use nalgebra::DMatrix;

use super::super::to_rgb;
use super::field::Field;
use crate::patches::{Basis, Patches};
use crate::scene::{Scene, Side};
use crate::trace::Hit;

/// The light on textured surfaces.
pub(super) struct Painted<'a, 's> {
    scene: &'s Scene,
    /// ρ̄H/π.
    reflected: Field<'a, 's>,
    /// ρ̄.
    reflectance: Field<'a, 's>,
}

impl<'a, 's> Painted<'a, 's> {
    /// Takes radiance (N × c) apart; `spread` lays coefficients over surfaces. None where no face has a texture.
    pub fn new(
        patches: &Patches<'s>,
        radiance: &DMatrix<f64>,
        spread: impl Fn(&DMatrix<f64>) -> Field<'a, 's>,
    ) -> Option<Self> {
        let scene = patches.scene();
        if !scene.has_textures() {
            return None;
        }
        let basis = Basis::of(patches, radiance);
        let emitted = basis.coefficients_of(&patches.sources());
        let reflected = radiance.zip_map(&emitted, |all, own| (all - own).max(0.0));
        let reflectance = spread(&basis.coefficients_of(&patches.reflectances()));
        Some(Self { scene, reflected: spread(&reflected), reflectance })
    }

    /// Radiance at a point of a textured face; none where the face has no texture.
    pub fn at(&self, patch: usize, hit: &Hit) -> Option<DVec3> {
        let (face, point) = (hit.face as usize, hit.barycentrics);
        let [reflectance, emission] =
            [self.scene.reflectance_texture(face), self.scene.emission_texture(face)];
        if reflectance.is_none() && emission.is_none() {
            return None;
        }
        let material = self.scene.material_of(face);
        let factors = reflectance.map_or(DVec3::ONE, |texture| texture.at(point).into());
        let reflectance = DVec3::from(to_rgb(&material.reflectance)) * factors;
        let emitted = match hit.side {
            Side::Front => {
                let factors = emission.map_or(DVec3::ONE, |texture| texture.at(point).into());
                DVec3::from(to_rgb(&material.emission)) * factors
            }
            Side::Back => DVec3::ZERO,
        };
        let (light, mean) = (self.reflected.at(patch, point), self.reflectance.at(patch, point));
        // Where nothing around reflects, nothing is reflected.
        let reflected = |c: usize| if mean[c] > 0.0 { reflectance[c] * light[c] / mean[c] } else { 0.0 };
        Some(emitted + DVec3::new(reflected(0), reflected(1), reflected(2)))
    }
}
