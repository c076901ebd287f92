//! Form factors: F_ij, the fraction of what patch i sends out that lands on patch j.

mod agreement;
mod constants;
mod groups;
mod more_rays;
mod options;
mod saved;
mod saved_exchange;
mod sections;
mod sound;
mod spread;
mod variation;

use std::sync::Arc;

use super::TransportError;
use super::exchange::{Exchange, Mass, Selection, StorageKind, exact};
use super::rows::{RowOptions, Rows, Tones};
use crate::patches::{Basis, Patches};
use crate::progress::{Cancelled, Progress};
use crate::trace::Tracer;
pub use agreement::Disagreement;
use agreement::disagreements;
pub use constants::DISAGREE;
pub use groups::{GroupFactor, Unmet};
pub use options::{Keep, Occlusion, TraceOptions};
pub use saved::Reuse;
pub use sections::FactorsFileError;
pub use spread::{Merged, Spread};

/// The form factors between patches: geometry, without reflectances and sources. Clones share what is large.
#[derive(Clone, Debug)]
pub struct FormFactors {
    /// One for each tone.
    exchanges: Arc<[Exchange]>,
    tones: Tones,
    rays: u32,
    rows: Option<Arc<Rows>>,
    disagreements: Vec<Disagreement>,
}

impl FormFactors {
    /// Traces form factors by cosine-distributed rays and balances them; in an empty convex scene finds them
    /// exactly, without rays ([`Occlusion`]).
    ///
    /// Sides that no probe found but a ray now lands on are added to `patches`.
    ///
    /// # Errors
    /// `Rays`, `Dark`, `Memory`, `Tones` or `Cancelled`.
    pub fn trace(
        tracer: &Tracer,
        patches: &mut Patches,
        options: &TraceOptions,
    ) -> Result<Self, TransportError> {
        if patches.is_empty() {
            return Err(TransportError::Dark);
        }
        if let Ok(enclosure) = options.without_rays(tracer, patches.len()) {
            let exchange = exact(tracer, patches, enclosure, options.progress)?;
            return Ok(exchange.into());
        }
        let tones = Tones::of(tracer.scene());
        tones.check()?;
        let recipe = options.recipe(patches.len(), &tones)?;
        options.progress.at("trace", 0.0)?;
        let &TraceOptions { caustics: shots, progress, .. } = options;
        let rows = Rows::trace(tracer, patches, RowOptions { recipe, tones, shots, progress })?;
        Ok(Self::balance(rows, patches, options.storage, options.keep, options.progress)?)
    }

    /// Makes exchange areas of rays, for every tone.
    pub(crate) fn balance(
        rows: Rows,
        patches: &Patches,
        storage: StorageKind,
        keep: Keep,
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        progress.at("balance", 0.0)?;
        let exchange = |tone: usize| {
            let selection = Selection { rows: &rows, patches, tone, left_out: None };
            Exchange::from_rows(&selection, storage, progress)
        };
        let exchanges = (0..rows.tones.len()).map(exchange).collect::<Result<_, _>>()?;
        let (rays, tones) = (rows.recipe.count.rays, rows.tones.clone());
        let disagreements = disagreements(&rows, patches);
        let rows = (keep == Keep::Rays).then(|| Arc::new(rows));
        Ok(Self { exchanges, tones, rays, rows, disagreements })
    }

    /// How light varies over a patch.
    pub fn basis(&self) -> Basis {
        self.exchange().basis()
    }

    /// Symmetric exchange areas S_ij = A_i F_ij, m²; of the first channel, where coloured carriers make
    /// channels differ.
    pub fn exchange(&self) -> &Exchange {
        &self.exchanges[0]
    }

    /// Exchange areas of a channel.
    pub fn exchange_of(&self, channel: usize) -> &Exchange {
        &self.exchanges[self.tones.of_channel(channel)]
    }

    /// The exchange areas that differ: one where carriers have no colour.
    pub fn exchanges(&self) -> &[Exchange] {
        &self.exchanges
    }

    /// Which of [`FormFactors::exchanges`] a channel has.
    pub fn tone_of(&self, channel: usize) -> usize {
        self.tones.of_channel(channel)
    }

    /// The form factors between groups of patches, each as one larger patch; see [`Exchange::merged`].
    ///
    /// # Panics
    /// If there is not one group per coefficient, or one is `groups` or more.
    pub fn merged(&self, group_of: &[usize], groups: usize) -> Self {
        let exchanges = self.exchanges.iter().map(|exchange| exchange.merged(group_of, groups)).collect();
        Self { exchanges, tones: self.tones.clone(), rays: self.rays, rows: None, disagreements: Vec::new() }
    }

    /// The form factors between patches with constant elements on each, as a mean over what linear ones find;
    /// `None` where they are that already.
    pub fn by_patch(&self) -> Option<Self> {
        let each = self.basis().coefficients();
        let patch_of: Vec<usize> = (0..self.exchange().len()).map(|k| k / each).collect();
        (each > 1).then(|| self.merged(&patch_of, self.len()))
    }

    /// Bytes that all exchange areas take.
    pub fn bytes(&self) -> u64 {
        self.exchanges.iter().map(Exchange::bytes).sum()
    }

    /// Those of patches between which no light goes: everything escapes. For runs without interreflection.
    pub fn none(patches: &Patches, basis: Basis) -> Self {
        Exchange::none(Mass::of(basis, patches)).into()
    }

    /// Form factors that are known already, perhaps with their rays.
    pub(crate) fn from_parts(
        (exchanges, tones): (Vec<Exchange>, Tones),
        rays: u32,
        rows: Option<Rows>,
    ) -> Self {
        let (exchanges, rows) = (exchanges.into(), rows.map(Arc::new));
        Self { exchanges, tones, rays, rows, disagreements: Vec::new() }
    }

    /// The rays, if they were kept.
    pub(crate) fn rows(&self) -> Option<&Rows> {
        self.rows.as_deref()
    }

    /// Whether lamps were found to shine by way of carriers; only told where rays were kept.
    pub(crate) fn has_caustics(&self) -> bool {
        self.rows().is_some_and(|rows| !rows.caustics.parts().1.is_empty())
    }

    /// The rays alone, if they were kept.
    pub(crate) fn into_rows(self) -> Option<Rows> {
        self.rows.map(Arc::unwrap_or_clone)
    }

    /// The pairs of face sides whose two directions found different exchange areas, by more than
    /// [`DISAGREE`] standard errors, the worst first: something is wrong with the mesh
    /// there. None where rays were not traced.
    pub fn disagreements(&self) -> &[Disagreement] {
        &self.disagreements
    }

    /// The same form factors with other pairs of face sides that disagree.
    pub fn with_disagreements(self, disagreements: Vec<Disagreement>) -> Self {
        Self { disagreements, ..self }
    }

    /// Rays per patch; 0 where they were found without.
    pub fn rays(&self) -> u32 {
        self.rays
    }

    /// Number of patches n.
    pub fn len(&self) -> usize {
        self.exchange().len() / self.basis().coefficients()
    }

    /// Whether there are no patches.
    pub fn is_empty(&self) -> bool {
        self.exchange().is_empty()
    }
}

impl From<Exchange> for FormFactors {
    /// Form factors that come from elsewhere than rays.
    fn from(exchange: Exchange) -> Self {
        let exchanges = Arc::new([exchange]);
        Self { exchanges, tones: Tones::one(), rays: 0, rows: None, disagreements: Vec::new() }
    }
}
