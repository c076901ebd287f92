//! The transport operator K = R F, one bounce of light: R turns what arrives into what leaves, and is diag(ρ) but for sheets that let light through.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::exchange::Exchange;
use super::mass::Mass;
use super::{FormFactors, TransportError, solvable};
use crate::patches::{Basis, Patches, Sheets};

/// What rounding may add to shares that come to 1.
const ROUNDING: f64 = 1e-12;

/// The transport operator K: form factors with a reflectance for every patch and channel, and with what comes through sheets.
///
/// On a patch of reflectance ρ what arrives leaves as L = ρH/π. On the two sides of a sheet of transmittance τ it leaves as
///
/// L_front = (ρ_front H_front + τ H_back)/π and L_back = (ρ_back H_back + τ H_front)/π.
///
/// It acts on coefficients, N × c: N is the number of patches n, or 3n for linear elements, where F stands for M⁻¹S.
#[derive(Clone, Debug)]
pub struct Transport<'f> {
    factors: &'f FormFactors,
    /// ρ, N × c.
    reflectance: DMatrix<f64>,
    /// By coefficients.
    sheets: Option<Sheets>,
}

impl<'f> Transport<'f> {
    /// Joins form factors and reflectances ρ (n × c, each 0 to 1).
    ///
    /// # Errors
    /// `Unsolvable` if some set of patches sees only itself and reflects everything; the sets' patches are named by number.
    ///
    /// # Panics
    /// If `reflectance` has not n rows or a value lies outside 0 to 1.
    pub fn new(factors: &'f FormFactors, reflectance: DMatrix<f64>) -> Result<Self, TransportError> {
        Self::with_sheets(factors, reflectance, None)
    }

    /// Joins form factors, reflectances ρ (n × c, each 0 to 1) and pairs of patches between which light comes through.
    ///
    /// # Errors
    /// As [`Transport::new`].
    ///
    /// # Panics
    /// As [`Transport::new`], and if a transmittance τ, or the sum of ρ and τ, lies outside 0 to 1.
    pub fn with_sheets(
        factors: &'f FormFactors,
        reflectance: DMatrix<f64>,
        sheets: Option<Sheets>,
    ) -> Result<Self, TransportError> {
        Self::named(factors, (reflectance, sheets), |i| format!("patch {i}"))
    }

    /// The operator of a scene's own reflectances and sheets.
    ///
    /// # Errors
    /// `Unsolvable`, naming the materials of a set of patches that sees only itself and reflects everything.
    pub fn of(factors: &'f FormFactors, patches: &Patches) -> Result<Self, TransportError> {
        let name = |i: usize| patches.scene().material_of(patches.place(i).face).name.clone();
        Self::named(factors, (patches.reflectances(), patches.sheets()), name)
    }

    fn named(
        factors: &'f FormFactors,
        (reflectance, sheets): (DMatrix<f64>, Option<Sheets>),
        name: impl Fn(usize) -> String,
    ) -> Result<Self, TransportError> {
        assert_eq!(reflectance.nrows(), factors.len(), "one row per patch");
        assert!(reflectance.iter().all(|r| (0.0..=1.0).contains(r)), "reflectances lie between 0 and 1");
        let exchange = factors.exchange();
        let each = exchange.basis().coefficients();
        let reflectance = exchange.basis().coefficients_of(&reflectance);
        let sheets = sheets.map(|sheets| sheets.by_coefficients(exchange.basis()));
        let k = Self { factors, reflectance, sheets };
        assert!(k.passed_on().iter().all(|&part| part <= 1.0 + ROUNDING), "ρ and τ come to no more than 1");
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
        self.reflectance.ncols()
    }

    /// Exchange areas S; of the first channel, where coloured carriers make channels differ.
    pub fn exchange(&self) -> &'f Exchange {
        self.factors.exchange()
    }

    /// Exchange areas S of a channel.
    pub fn exchange_of(&self, channel: usize) -> &'f Exchange {
        self.factors.exchange_of(channel)
    }

    /// A number that channels with the same exchange areas share.
    pub fn tone_of(&self, channel: usize) -> usize {
        self.factors.tone_of(channel)
    }

    /// y ← S x, each channel by its own exchange areas, overwriting y; N × c.
    pub fn through(&self, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
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

    /// The mass M of the basis functions, normalised frame.
    pub fn mass(&self) -> &Mass {
        self.exchange().mass()
    }

    /// How light varies over a patch.
    pub fn basis(&self) -> Basis {
        self.exchange().basis()
    }

    /// Reflectances ρ, N × c.
    pub fn reflectance(&self) -> &DMatrix<f64> {
        &self.reflectance
    }

    /// What comes through sheets, by coefficients; none where nothing does.
    pub fn sheets(&self) -> Option<&Sheets> {
        self.sheets.as_ref()
    }

    /// The part of what arrives that goes on, ρ + τ, N × c; the rest is absorbed.
    pub fn passed_on(&self) -> DMatrix<f64> {
        let mut part = self.reflectance.clone();
        if let Some(Sheets { pairs, transmittance }) = &self.sheets {
            for (mut part, tau) in part.column_iter_mut().zip(transmittance.column_iter()) {
                pairs.iter().zip(&tau).for_each(|(pair, tau)| pair.iter().for_each(|&i| part[i] += tau));
            }
        }
        part
    }

    /// Irradiance H = π M⁻¹ S L of radiance L, N × c, W·m⁻².
    pub fn irradiance(&self, radiance: &DMatrix<f64>) -> DMatrix<f64> {
        let mut irradiance = DMatrix::zeros(self.len(), self.channels());
        self.through(radiance, &mut irradiance);
        self.mass().solve(&mut irradiance, PI);
        irradiance
    }

    /// Radiance ρ H / π that leaves where irradiance H arrives, N × c, and τ H / π more on the other side of a sheet: the one place where
    /// surfaces turn what arrives into what leaves.
    pub fn reflect(&self, irradiance: &DMatrix<f64>) -> DMatrix<f64> {
        let mut radiance = irradiance.zip_map(&self.reflectance, |h, rho| rho * h / PI);
        if let Some(sheets) = &self.sheets {
            self.let_through(sheets, irradiance, &mut radiance);
        }
        radiance
    }

    /// Adds what comes through sheets.
    fn let_through(&self, sheets: &Sheets, irradiance: &DMatrix<f64>, radiance: &mut DMatrix<f64>) {
        for (c, tau) in sheets.transmittance.column_iter().enumerate() {
            for (&[front, back], tau) in sheets.pairs.iter().zip(&tau) {
                radiance[(front, c)] += tau * irradiance[(back, c)] / PI;
                radiance[(back, c)] += tau * irradiance[(front, c)] / PI;
            }
        }
    }

    /// y ← K x, overwriting y; N × c.
    pub fn apply(&self, x: &DMatrix<f64>, y: &mut DMatrix<f64>) {
        y.copy_from(&self.reflect(&self.irradiance(x)));
    }

    /// The largest entry of K·1 per channel: the largest share of what arrives anywhere, from all sides alike, that goes on. For
    /// constant elements K ≥ 0, and this is ‖K‖∞.
    pub fn norm(&self) -> Vec<f64> {
        let mut sums = DMatrix::zeros(self.len(), self.channels());
        self.apply(&DMatrix::repeat(self.len(), self.channels(), 1.0), &mut sums);
        sums.column_iter().map(|column| column.amax()).collect()
    }
}
