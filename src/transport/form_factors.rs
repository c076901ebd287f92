//! Form factors: F_ij, the fraction of what patch i sends out that lands on patch j.

use super::TransportError;
use super::blocks::Blocks;
use super::exchange::Exchange;
use super::rays::Rows;
use super::recipe::{BATCHES, RayCount, Recipe};
use super::storage::StorageKind;
use crate::patches::{Basis, Patches};
use crate::progress::Progress;
use crate::trace::{Tracer, sampling};

/// What to keep of the rays once they have become exchange areas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Keep {
    /// Nothing.
    #[default]
    Nothing,
    /// All: 4 bytes a ray (6 for linear elements), for standard errors and for saving.
    Rays,
}

/// How to trace form factors.
#[derive(Clone, Copy, Debug)]
pub struct TraceOptions<'a> {
    /// Rays per patch, rounded up to a multiple of 8; `None` for [`TraceOptions::usual_rays`]. Noise falls about as
    /// rays^-0.6, time grows in proportion.
    pub rays: Option<u32>,
    /// Shadow rays per patch towards lamps, rounded up to a multiple of 8; `None` for half of `rays`, 0 for none. They
    /// settle direct light.
    pub lamp_rays: Option<u32>,
    /// Number of the random sequence. The same seed gives the same bits.
    pub seed: u64,
    /// How light varies over a patch. Linear elements take the same rays, thrice the unknowns, and two to four times the bytes
    /// and the time per pass of constant ones.
    pub basis: Basis,
    /// How to store exchange areas.
    pub storage: StorageKind,
    /// The most bytes the exchange areas may take.
    pub memory: u64,
    /// What to keep of the rays.
    pub keep: Keep,
    /// Where to report progress, as stages `trace` and `balance`.
    pub progress: Progress<'a>,
}

impl Default for TraceOptions<'_> {
    /// The usual rays, constant elements, the smaller storage, 4 GiB.
    fn default() -> Self {
        Self {
            rays: None,
            lamp_rays: None,
            seed: 0,
            basis: Basis::Constant,
            storage: StorageKind::Auto,
            memory: 4 << 30,
            keep: Keep::Nothing,
            progress: Progress::default(),
        }
    }
}

impl TraceOptions<'_> {
    /// Shadow rays that go with so many rays.
    fn lamp_rays_for(&self, rays: u32) -> u32 {
        let most = BATCHES * sampling::SEQUENCE_END;
        self.lamp_rays.unwrap_or(rays / 2).min(most).next_multiple_of(BATCHES)
    }

    /// How rows of so many patches are traced.
    pub(super) fn recipe(&self, patches: usize) -> Result<Recipe, TransportError> {
        self.check(patches)?;
        let rays = self.rays.unwrap_or(Self::usual_rays(patches)).next_multiple_of(BATCHES);
        let count = RayCount { rays, lamp_rays: self.lamp_rays_for(rays) };
        Ok(Recipe { count, seed: self.seed, basis: self.basis })
    }

    /// Refuses what can't be done with so many patches, before any time is spent on it.
    ///
    /// # Errors
    /// `Rays` or `Memory`.
    pub fn check(&self, patches: usize) -> Result<(), TransportError> {
        self.check_rays(patches, self.rays.unwrap_or(Self::usual_rays(patches)))
    }

    /// The same for so many rays.
    pub(super) fn check_rays(&self, patches: usize, rays: u32) -> Result<(), TransportError> {
        let most = BATCHES * sampling::SEQUENCE_END;
        if !(BATCHES..=most).contains(&rays) {
            return Err(TransportError::Rays { rays, most });
        }
        let (n, rays) = (patches as u64, rays as u64);
        let (matrix, per_ray) = match self.basis {
            // Landings, 4 bytes each twice over while they are sorted; at most two entries of 8 bytes a landing while a
            // sparse matrix is put together.
            Basis::Constant => {
                let (dense, sparse) = (4 * n * n, 16 * n * rays.min(n));
                let matrix = match self.storage {
                    StorageKind::Dense => dense,
                    StorageKind::Sparse => sparse,
                    StorageKind::Auto => dense.min(sparse),
                };
                (matrix, 8)
            }
            // A full matrix is made from blocks.
            Basis::Linear => {
                let dense = if self.storage == StorageKind::Dense { 36 * n * n } else { 0 };
                (Blocks::bytes_for(n, rays) + dense, 8)
            }
        };
        let needed = matrix + per_ray * n * rays;
        if needed > self.memory {
            return Err(TransportError::Memory { patches, needed, limit: self.memory });
        }
        Ok(())
    }

    /// Rays per patch where none are asked for: 512, and fewer from 16384 patches on, but never less than 64, for a face that is
    /// cut into many patches averages their noise.
    pub fn usual_rays(patches: usize) -> u32 {
        ((1 << 22) / patches.max(1) as u32).clamp(64, 512).next_power_of_two()
    }
}

/// The form factors between patches: geometry, without reflectances and sources.
#[derive(Clone, Debug)]
pub struct FormFactors {
    exchange: Exchange,
    rays: u32,
    rows: Option<Rows>,
}

impl FormFactors {
    /// Traces form factors by cosine-distributed rays and balances them.
    ///
    /// Sides that no probe found but a ray now lands on are added to `patches`.
    ///
    /// # Errors
    /// `Rays`, `Dark`, `Memory` or `Cancelled`.
    pub fn trace(
        tracer: &Tracer,
        patches: &mut Patches,
        options: &TraceOptions,
    ) -> Result<Self, TransportError> {
        if patches.is_empty() {
            return Err(TransportError::Dark);
        }
        let recipe = options.recipe(patches.len())?;
        let rays = recipe.count.rays;
        options.progress.at("trace", 0.0)?;
        let rows = Rows::trace(tracer, patches, recipe, options.progress)?;
        options.progress.at("balance", 0.0)?;
        let exchange = Exchange::from_rows(&rows, patches, options.storage, None, options.progress)?;
        let rows = (options.keep == Keep::Rays).then_some(rows);
        Ok(Self { exchange, rays, rows })
    }

    /// How light varies over a patch.
    pub fn basis(&self) -> Basis {
        self.exchange.basis()
    }

    /// Symmetric exchange areas S_ij = A_i F_ij, normalised frame.
    pub fn exchange(&self) -> &Exchange {
        &self.exchange
    }

    /// Form factors that are known already, perhaps with their rays.
    pub(super) fn from_parts(exchange: Exchange, rays: u32, rows: Option<Rows>) -> Self {
        Self { exchange, rays, rows }
    }

    /// The rays, if they were kept.
    pub(super) fn rows(&self) -> Option<&Rows> {
        self.rows.as_ref()
    }

    /// The rays alone, if they were kept.
    pub(super) fn into_rows(self) -> Option<Rows> {
        self.rows
    }

    /// Rays per patch.
    pub fn rays(&self) -> u32 {
        self.rays
    }

    /// Number of patches n.
    pub fn len(&self) -> usize {
        self.exchange.len() / self.basis().coefficients()
    }

    /// Whether there are no patches.
    pub fn is_empty(&self) -> bool {
        self.exchange.is_empty()
    }
}

impl From<Exchange> for FormFactors {
    /// Form factors that come from elsewhere than rays.
    fn from(exchange: Exchange) -> Self {
        Self { exchange, rays: 0, rows: None }
    }
}
