//! Sheet: a thin surface that lets light through diffusely, as blinds, lampshades and leaves do, or whose
//! back is of another colour.
//!
//! Of what arrives on a side it reflects ρ of that side, lets τ through and absorbs 1 − ρ − τ. What comes
//! through leaves the other side equally in every direction; τ is the same from either side (reciprocity).

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
    pub(crate) fn colours(&self) -> [&Vec<f64>; 2] {
        [&self.reflectance_back, &self.transmittance]
    }

    pub(crate) fn colours_mut(&mut self) -> [&mut Vec<f64>; 2] {
        [&mut self.reflectance_back, &mut self.transmittance]
    }

    /// What is not physical about it, with this reflectance on its front and a picture of these highest
    /// factors on both sides, if anything.
    pub(crate) fn check(&self, front: &[f64], highest: [f64; 3]) -> Result<(), String> {
        for (what, values) in
            [("reflectance_back", &self.reflectance_back), ("transmittance", &self.transmittance)]
        {
            if let Some(value) = values.iter().find(|x| !(0.0..=1.0).contains(*x)) {
                return Err(format!("{what} {value} must lie between 0 and 1"));
            }
        }
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
