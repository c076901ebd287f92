//! Painted: the solution on surfaces whose textures are shown, L = Lₑ(u, v) + ρ(u, v) H/π.
//!
//! Patches know L̄ = L̄ₑ + ρ̄H/π, with means over the patch. What they reflect and ρ̄ are laid over the
//! surface in the same way, and H/π is the one by the other: so pictures neither blur textures nor show the
//! patches that averaged them. On sheets ρ + τ stands for ρ, as if both sides were lit alike: right in the
//! mean over a patch, while the contrast of a texture that is lit from behind is shown too strong.

use glam::DVec3;
use nalgebra::DMatrix;

use super::field::Field;
use crate::patches::{Basis, Patches};
use crate::render::tone::to_rgb;
use crate::scene::{Scene, Side};
use crate::trace::Hit;
use crate::transport::Reflection;

/// The light on textured surfaces.
pub(super) struct Painted<'a, 's> {
    scene: &'s Scene,
    /// ρ̄H/π, and what comes through.
    reflected: Field<'a, 's>,
    /// ρ̄ + τ.
    passed_on: Field<'a, 's>,
}

impl<'a, 's> Painted<'a, 's> {
    /// Takes radiance (N × c) apart; `spread` lays coefficients over surfaces. None where no face has a
    /// texture.
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
        let emitted = basis.coefficients_of(&patches.emitted_radiance());
        let reflected = radiance.zip_map(&emitted, |all, own| (all - own).max(0.0));
        let passed_on = Reflection::of(patches).passed_on();
        let passed_on = spread(&basis.coefficients_of(&passed_on));
        Some(Self { scene, reflected: spread(&reflected), passed_on })
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
        let mut passed_on = DVec3::from(to_rgb(material.reflectance_of(hit.side))) * factors;
        if let Some(transmittance) = material.transmittance() {
            passed_on += DVec3::from(to_rgb(transmittance));
        }
        let emitted = match hit.side {
            Side::Front => {
                let factors = emission.map_or(DVec3::ONE, |texture| texture.at(point).into());
                DVec3::from(to_rgb(&material.emission)) * factors
            }
            Side::Back => DVec3::ZERO,
        };
        let (light, mean) = (self.reflected.at(patch, point), self.passed_on.at(patch, point));
        // Where nothing around reflects, nothing is reflected.
        let reflected = |c: usize| if mean[c] > 0.0 { passed_on[c] * light[c] / mean[c] } else { 0.0 };
        Some(emitted + DVec3::new(reflected(0), reflected(1), reflected(2)))
    }
}
