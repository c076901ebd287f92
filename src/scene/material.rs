//! Material: how a surface reflects and emits.

/// What a surface does with light beside reflecting it diffusely.
///
/// Only diffuse reflection and emission are simulated today; the other kinds are recognised so that
/// a run can name them as not yet simulated, and act by their diffuse reflectance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// Lambertian: radiance leaves equally in every direction.
    Diffuse,
    /// Perfect mirror (`illum 3`).
    Mirror,
    /// Smooth glass or water (`illum 4`, `6`, `7` or `9`).
    Dielectric,
    /// Rough conductor or plastic (`Pr`, `Pm`, or `illum 5`).
    Glossy,
}

/// A surface's reflectance and emission, one value per channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, as faces refer to it.
    pub name: String,
    /// Diffuse reflectance (albedo) ρ of both sides, per channel, 0 to 1.
    pub reflectance: Vec<f64>,
    /// Emitted radiance Lₑ of the front side, per channel, W·sr⁻¹·m⁻².
    pub emission: Vec<f64>,
    /// What the surface does beside reflecting diffusely.
    pub surface: Surface,
    /// Whether the file gives the reflectance or emission as a picture.
    pub textured: bool,
}

impl Material {
    /// A diffuse surface with the given reflectance that emits nothing.
    pub fn diffuse(name: impl Into<String>, reflectance: &[f64]) -> Self {
        Self {
            name: name.into(),
            reflectance: reflectance.to_vec(),
            emission: vec![0.0; reflectance.len()],
            surface: Surface::Diffuse,
            textured: false,
        }
    }

    /// A diffuse lamp: reflectance and emitted radiance (W·sr⁻¹·m⁻²) per channel.
    pub fn lamp(name: impl Into<String>, reflectance: &[f64], emission: &[f64]) -> Self {
        Self { emission: emission.to_vec(), ..Self::diffuse(name, reflectance) }
    }

    /// Whether the front side emits in any channel.
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&e| e > 0.0)
    }

    /// Whether some light is reflected in some channel.
    pub fn reflects(&self) -> bool {
        self.reflectance.iter().any(|&r| r > 0.0)
    }

    /// What is not physical about it, if anything.
    pub(super) fn check(&self) -> Result<(), String> {
        if let Some(r) = self.reflectance.iter().find(|r| !(0.0..=1.0).contains(*r)) {
            return Err(format!("reflectance {r} (Kd in MTL files) must lie between 0 and 1"));
        }
        if let Some(e) = self.emission.iter().find(|e| !(e.is_finite() && **e >= 0.0)) {
            return Err(format!("emission {e} (Ke in MTL files) must be finite and not negative"));
        }
        Ok(())
    }

    /// Whether all channels agree.
    pub(super) fn is_grey(&self) -> bool {
        let flat = |v: &[f64]| v.iter().all(|&x| x == v[0]);
        flat(&self.reflectance) && flat(&self.emission)
    }
}
