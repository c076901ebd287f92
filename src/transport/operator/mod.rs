//! The transport operator K = R F, one bounce of light: R turns what arrives into what leaves, and is diag(ρ)
//! but for sheets that let light through.

mod solvable;

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::DMatrix;

use super::TransportError;
use super::exchange::{Exchange, Mass};
use super::form_factors::FormFactors;
use super::reflection::Reflection;
use crate::patches::{Basis, Patches, Sheets};

/// What rounding may add to shares that come to 1.
const ROUNDING: f64 = 1e-12;

/// The transport operator K: form factors with a reflectance for every patch and channel, and with what comes
/// through sheets.
///
/// It acts on coefficients, N × c: N is the number of patches n, or 3n for linear elements, where F stands
/// for M⁻¹S. Clones share what is large.
#[derive(Clone, Debug)]
pub struct Transport {
    factors: FormFactors,
    /// By coefficients.
    reflection: Arc<Reflection>,
}

impl Transport {
    /// Joins form factors and what patches do with light: reflectances ρ (n × c), perhaps with sheets.
    ///
    /// # Errors
    /// `Unsolvable` if some set of patches sees only itself and reflects everything; the sets' patches are
    /// named by number.
    ///
    /// # Panics
    /// If there are not n reflectances, if a ρ or τ lies outside 0 to 1, or if they come to more than 1.
    pub fn new(factors: &FormFactors, reflection: impl Into<Reflection>) -> Result<Self, TransportError> {
        Self::named(factors, reflection.into(), |i| format!("patch {i}"))
    }

    /// The operator of a scene's own reflectances and sheets.
    ///
    /// # Errors
    /// `Unsolvable`, naming the materials of a set of patches that sees only itself and reflects everything.
    pub fn of(factors: &FormFactors, patches: &Patches) -> Result<Self, TransportError> {
        let name = |i: usize| patches.scene().material_of(patches.place(i).face).name.clone();
        Self::named(factors, Reflection::of(patches), name)
    }

    fn named(
        factors: &FormFactors,
        reflection: Reflection,
        name: impl Fn(usize) -> String,
    ) -> Result<Self, TransportError> {
        let Reflection { reflectance, sheets } = &reflection;
        assert_eq!(reflectance.nrows(), factors.len(), "one row per patch");
        let transmittance = sheets.iter().flat_map(|sheets| &sheets.transmittance);
        let mut parts = reflectance.iter().chain(transmittance);
        assert!(parts.all(|part| (0.0..=1.0).contains(part)), "reflectances lie between 0 and 1");
        let fits = reflection.passed_on().iter().all(|&part| part <= 1.0 + ROUNDING);
        assert!(fits, "reflectance and transmittance come to no more than 1");
        let basis = factors.basis();
        let each = basis.coefficients();
        let reflection = Arc::new(reflection.by_coefficients(basis));
        let k = Self { factors: factors.clone(), reflection };
        if let Some(trapped) = solvable::trapped(&k) {
            let mut materials: Vec<String> = trapped.into_iter().map(|i| name(i / each)).collect();
            materials.sort();
            materials.dedup();
            return Err(TransportError::Unsolvable { materials });
        }
        Ok(k)
    }

    /// Number of unknowns N.
    pub fn len(&self) -> usize {
        self.exchange().len()
    }

    /// Whether there are no unknowns.
    pub fn is_empty(&self) -> bool {
        self.exchange().is_empty()
    }

    /// Number of channels c.
    pub fn channels(&self) -> usize {
        self.reflection.reflectance.ncols()
    }

    /// The form factors.
    pub fn factors(&self) -> &FormFactors {
        &self.factors
    }

    /// Exchange areas S; of the first channel, where coloured carriers make channels differ.
    pub fn exchange(&self) -> &Exchange {
        self.factors.exchange()
    }

    /// Exchange areas S of a channel.
    pub fn exchange_of(&self, channel: usize) -> &Exchange {
        self.factors.exchange_of(channel)
    }

    /// A number that channels with the same exchange areas share.
    pub fn tone_of(&self, channel: usize) -> usize {
        self.factors.tone_of(channel)
    }

    /// y ← S x, each channel by its own exchange areas, overwriting y; N × c, in the unit of the mass.
    pub(crate) fn through(&self, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
        if let [exchange] = self.factors.exchanges() {
            return exchange.apply(x, y);
        }
        for (tone, exchange) in self.factors.exchanges().iter().enumerate() {
            let channels: Vec<usize> = (0..x.ncols()).filter(|&c| self.tone_of(c) == tone).collect();
            let own = x.select_columns(&channels);
            let mut found = DMatrix::zeros(own.nrows(), own.ncols());
            exchange.apply(&own, &mut found);
            channels.iter().zip(found.column_iter()).for_each(|(&c, column)| y.set_column(c, &column));
        }
    }

    /// The mass M of the basis functions.
    pub fn mass(&self) -> &Mass {
        self.exchange().mass()
    }

    /// How light varies over a patch.
    pub fn basis(&self) -> Basis {
        self.exchange().basis()
    }

    /// Reflectances ρ, N × c.
    pub fn reflectance(&self) -> &DMatrix<f64> {
        &self.reflection.reflectance
    }

    /// What comes through sheets, by coefficients; none where nothing does.
    pub fn sheets(&self) -> Option<&Sheets> {
        self.reflection.sheets.as_ref()
    }

    /// The part of what arrives that goes on, ρ + τ, N × c; the rest is absorbed.
    pub fn passed_on(&self) -> DMatrix<f64> {
        self.reflection.passed_on()
    }

    /// Irradiance H = π M⁻¹ S L of radiance L, N × c, W·m⁻².
    pub fn irradiance(&self, radiance: &DMatrix<f64>) -> DMatrix<f64> {
        let mut irradiance = DMatrix::zeros(self.len(), self.channels());
        self.through(radiance, &mut irradiance);
        self.mass().solve(&mut irradiance, PI);
        irradiance
    }

    /// Radiance that leaves where irradiance H arrives, N × c: ρ H / π, and τ H / π on the other side of a
    /// sheet; see [`Reflection`].
    pub fn reflect(&self, irradiance: &DMatrix<f64>) -> DMatrix<f64> {
        self.reflection.reflect(irradiance)
    }

    /// y ← K x, overwriting y; N × c.
    pub fn apply(&self, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
        y.copy_from(&self.reflect(&self.irradiance(x)));
    }

    /// The largest entry of K·1 per channel: the largest share of what arrives anywhere, from all sides
    /// alike, that goes on. For constant elements K ≥ 0, and this is ‖K‖∞.
    pub fn norm(&self) -> Vec<f64> {
        let mut sums = DMatrix::zeros(self.len(), self.channels());
        self.apply(&DMatrix::repeat(self.len(), self.channels(), 1.0), &mut sums);
        sums.column_iter().map(|column| column.amax()).collect()
    }
}
