//! Reflection: the one function by which surfaces turn the light that arrives into the light that leaves.
//!
//! On a patch of reflectance ρ what arrives leaves as L = ρH/π. On the two sides of a sheet of transmittance
//! τ it leaves as
//!
//! L_front = (ρ_front H_front + τ H_back)/π and L_back = (ρ_back H_back + τ H_front)/π.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use crate::patches::{Basis, Clusters, Patches, Sheets};

/// What patches, or coefficients, do with light that arrives.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflection {
    /// Reflectance ρ, a row each and a column per channel, 0 to 1.
    pub reflectance: DMatrix<f64>,
    /// Where light comes through; none where it does nowhere.
    pub sheets: Option<Sheets>,
}

impl Reflection {
    /// That of a scene's patches.
    pub fn of(patches: &Patches) -> Self {
        Self { reflectance: patches.reflectances(), sheets: patches.sheets() }
    }

    /// The same by coefficients of a basis.
    pub fn by_coefficients(&self, basis: Basis) -> Self {
        Self {
            reflectance: basis.coefficients_of(&self.reflectance),
            sheets: self.sheets.as_ref().map(|sheets| sheets.by_coefficients(basis)),
        }
    }

    /// The mean over clusters of patches.
    ///
    /// # Panics
    /// If it is not by patch.
    pub fn merged(&self, patches: &Patches, clusters: &Clusters) -> Self {
        Self {
            reflectance: patches.average_by(clusters, &self.reflectance),
            sheets: self.sheets.as_ref().map(|sheets| sheets.merged(clusters)),
        }
    }

    /// Radiance that leaves where irradiance H arrives, of the same shape.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn reflect(&self, irradiance: &DMatrix<f64>) -> DMatrix<f64> {
        let mut radiance = irradiance.zip_map(&self.reflectance, |h, rho| rho * h / PI);
        if let Some(sheets) = &self.sheets {
            // Add what comes through, each way.
            for (c, tau) in sheets.transmittance.column_iter().enumerate() {
                for (&[front, back], tau) in sheets.pairs.iter().zip(&tau) {
                    radiance[(front, c)] += tau * irradiance[(back, c)] / PI;
                    radiance[(back, c)] += tau * irradiance[(front, c)] / PI;
                }
            }
        }
        radiance
    }

    /// The part of what arrives that goes on, ρ + τ; the rest is absorbed.
    pub fn passed_on(&self) -> DMatrix<f64> {
        let mut part = self.reflectance.clone();
        if let Some(Sheets { pairs, transmittance }) = &self.sheets {
            for (mut part, tau) in part.column_iter_mut().zip(transmittance.column_iter()) {
                pairs.iter().zip(&tau).for_each(|(pair, tau)| pair.iter().for_each(|&i| part[i] += tau));
            }
        }
        part
    }
}

impl From<DMatrix<f64>> for Reflection {
    /// Of reflectances alone.
    fn from(reflectance: DMatrix<f64>) -> Self {
        Self { reflectance, sheets: None }
    }
}
