//! Sheet: a thin surface that lets light through diffusely, as blinds, lampshades and leaves do, or whose
//! back is of another colour.
//!
//! Of what arrives on a side it reflects ρ of that side, lets τ through and absorbs 1 − ρ − τ. What comes
//! through leaves the other side equally in every direction; τ is the same from either side (reciprocity).

use super::{Material, Side, Texture};

/// What a surface has beside the reflectance of its front, per channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Diffuse reflectance of the back, 0 to 1.
    pub reflectance_back: Vec<f64>,
    /// Diffuse transmittance τ from either side to the other, 0 to 1.
    pub transmittance: Vec<f64>,
}

impl Sheet {
    /// All of its colours.
    pub(super) fn colours(&self) -> [&Vec<f64>; 2] {
        [&self.reflectance_back, &self.transmittance]
    }

    pub(super) fn colours_mut(&mut self) -> [&mut Vec<f64>; 2] {
        [&mut self.reflectance_back, &mut self.transmittance]
    }

    /// What is not physical about it, with this reflectance on its front and this picture on both sides, if
    /// anything.
    pub(super) fn check(&self, front: &[f64], texture: Option<&Texture>) -> Result<(), String> {
        for (what, values) in
            [("reflectance_back", &self.reflectance_back), ("transmittance", &self.transmittance)]
        {
            if let Some(value) = values.iter().find(|x| !(0.0..=1.0).contains(*x)) {
                return Err(format!("{what} {value} must lie between 0 and 1"));
            }
        }
        let highest = texture.map_or([1.0; 3], |texture| texture.pixels.highest());
        for (what, reflectance) in [("reflectance", front), ("reflectance_back", &self.reflectance_back)] {
            for ((rho, factor), tau) in reflectance.iter().zip(highest).zip(&self.transmittance) {
                let reflected = rho * factor;
                if reflected + tau > 1.0 {
                    let sum = reflected + tau;
                    return Err(format!(
                        "{what} {reflected} and transmittance {tau} come to {sum}: no more than 1 of the light that arrives can go on; lower one of them"
                    ));
                }
            }
        }
        Ok(())
    }
}

impl Material {
    /// Makes a diffuse surface a sheet that lets this part of the light through, and whose back reflects this
    /// part, per channel.
    #[must_use]
    pub fn with_sheet(self, reflectance_back: &[f64], transmittance: &[f64]) -> Self {
        let sheet =
            Sheet { reflectance_back: reflectance_back.to_vec(), transmittance: transmittance.to_vec() };
        Self { sheet: Some(sheet), ..self }
    }

    /// Diffuse reflectance of a side, per channel; what a texture says multiplies it on both.
    #[inline]
    pub fn reflectance_of(&self, side: Side) -> &[f64] {
        match (&self.sheet, side) {
            (Some(sheet), Side::Back) => &sheet.reflectance_back,
            _ => &self.reflectance,
        }
    }

    /// Diffuse transmittance τ per channel; none where no light comes through.
    #[inline]
    pub fn transmittance(&self) -> Option<&[f64]> {
        let tau = self.sheet.as_ref().map(|sheet| sheet.transmittance.as_slice());
        tau.filter(|tau| tau.iter().any(|&t| t > 0.0))
    }

    /// The most of what arrives on a side that goes on from there, over all channels: what is reflected and
    /// what comes through.
    pub fn highest_albedo(&self, side: Side) -> f64 {
        let through = |c: usize| self.transmittance().map_or(0.0, |tau| tau[c]);
        let of = |(c, rho): (usize, &f64)| rho + through(c);
        self.reflectance_of(side).iter().enumerate().map(of).fold(0.0, f64::max)
    }
}
