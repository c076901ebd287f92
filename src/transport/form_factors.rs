//! Form factors: F_ij, the fraction of what patch i sends out that lands on patch j.

use super::TransportError;
use super::agreement::{Disagreement, disagreements};
use super::blocks::Blocks;
use super::exchange::Exchange;
use super::polygons;
use super::rays::Rows;
use super::recipe::{BATCHES, RayCount, Recipe};
use super::storage::StorageKind;
use super::switches::Shots;
use super::tones::Tones;
use crate::patches::{Basis, Patches};
use crate::progress::{Cancelled, Progress};
use crate::trace::{Enclosure, Tracer, sampling};

/// What to keep of the rays once they have become exchange areas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Keep {
    /// Nothing.
    #[default]
    Nothing,
    /// All: 4 bytes a ray (6 for linear elements), for standard errors and for saving.
    Rays,
}

/// Whether rays look for what stands between surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Occlusion {
    /// Not where the scene is empty and convex seen from inside: there form factors between polygons are
    /// exact without rays. This is for constant elements of no more than 10 000 patches, stored densely, of
    /// which no number of rays is asked for and none are to be kept.
    #[default]
    WhereNeeded,
    /// In any case.
    Always,
}

/// How to trace form factors.
#[derive(Clone, Copy, Debug)]
pub struct TraceOptions<'a> {
    /// Rays per patch, rounded up to a multiple of 8; `None` for [`TraceOptions::usual_rays`]. Noise falls
    /// about as rays^-0.6, time grows in proportion.
    pub rays: Option<u32>,
    /// Shadow rays per patch towards lamps, rounded up to a multiple of 8; `None` for half of `rays`, 0 for
    /// none. They settle direct light.
    pub lamp_rays: Option<u32>,
    /// Number of the random sequence. The same seed gives the same bits.
    pub seed: u64,
    /// How light varies over a patch. Linear elements take the same rays, thrice the unknowns, and two to
    /// four times the bytes and the time per pass of constant ones.
    pub basis: Basis,
    /// Whether rays look for what stands between surfaces.
    pub occlusion: Occlusion,
    /// Whether lamps shoot caustics.
    pub caustics: Shots,
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
            occlusion: Occlusion::WhereNeeded,
            caustics: Shots::Shot,
            storage: StorageKind::Auto,
            memory: 4 << 30,
            keep: Keep::Nothing,
            progress: Progress::default(),
        }
    }
}

impl TraceOptions<'_> {
    /// Shadow rays that go with so many rays.
    pub(super) fn lamp_rays_for(&self, rays: u32) -> u32 {
        let most = BATCHES * sampling::SEQUENCE_END;
        self.lamp_rays.unwrap_or(rays / 2).min(most).next_multiple_of(BATCHES)
    }

    /// Shadow rays per patch towards lamps for so many patches.
    pub(super) fn lamp_rays_of(&self, patches: usize) -> u32 {
        self.lamp_rays_for(self.rays.unwrap_or(Self::usual_rays(patches))).max(BATCHES)
    }

    /// How an empty convex scene surrounds its inside, if rays are not needed for so many patches of it.
    ///
    /// # Errors
    /// Why rays are traced, in a few words.
    pub fn without_rays(&self, tracer: &Tracer, patches: usize) -> Result<Enclosure, String> {
        if self.occlusion == Occlusion::Always {
            return Err("they are asked for".into());
        }
        let enclosure =
            tracer.enclosure().map_err(|why| format!("the scene is not empty and convex: {why}"))?;
        let reason = match () {
            _ if self.basis == Basis::Linear => "exact form factors are for constant elements",
            _ if self.rays.is_some() => "a number of them is asked for",
            _ if self.keep == Keep::Rays => "they are to be kept",
            _ if self.storage == StorageKind::Sparse => "a sparse matrix is asked for",
            _ if patches > MOST_EXACT => "more than 10000 patches: rays are quicker",
            _ if 4 * (patches as u64).pow(2) > self.memory => "a full matrix takes more than --memory allows",
            _ => return Ok(enclosure),
        };
        Err(reason.into())
    }

    /// How rows of so many patches are traced.
    pub(super) fn recipe(&self, patches: usize, tones: &Tones) -> Result<Recipe, TransportError> {
        let rays = self.rays.unwrap_or(Self::usual_rays(patches));
        self.check_rays(patches, rays, tones.len())?;
        let rays = rays.next_multiple_of(BATCHES);
        let count = RayCount { rays, lamp_rays: self.lamp_rays_for(rays) };
        Ok(Recipe { count, seed: self.seed, basis: self.basis })
    }

    /// Refuses what can't be done with so many patches, before any time is spent on it.
    ///
    /// # Errors
    /// `Rays` or `Memory`.
    pub fn check(&self, patches: usize) -> Result<(), TransportError> {
        self.check_rays(patches, self.rays.unwrap_or(Self::usual_rays(patches)), 1)
    }

    /// The same for so many rays, and for carriers of so many tones, each with a matrix of its own.
    pub(super) fn check_rays(&self, patches: usize, rays: u32, tones: usize) -> Result<(), TransportError> {
        let most = BATCHES * sampling::SEQUENCE_END;
        if !(BATCHES..=most).contains(&rays) {
            return Err(TransportError::Rays { rays, most });
        }
        let (n, rays) = (patches as u64, rays as u64);
        let (matrix, per_ray) = match self.basis {
            // Landings, 4 bytes each twice over while they are sorted; at most two entries of 8 bytes a
            // landing while a sparse matrix is put together.
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
        let per_ray = if tones > 1 { per_ray + 2 } else { per_ray };
        let needed = tones as u64 * matrix + per_ray * n * rays;
        if needed > self.memory {
            return Err(TransportError::Memory { patches, needed, limit: self.memory });
        }
        Ok(())
    }

    /// Rays per patch where none are asked for: 512, and fewer from 16384 patches on, but never less than 64,
    /// for a face that is cut into many patches averages their noise.
    pub fn usual_rays(patches: usize) -> u32 {
        ((1 << 22) / patches.max(1)).clamp(64, 512).next_power_of_two() as u32
    }
}

/// With more patches than this rays are quicker than all pairs.
const MOST_EXACT: usize = 10_000;

/// The form factors between patches: geometry, without reflectances and sources.
#[derive(Clone, Debug)]
pub struct FormFactors {
    /// One for each tone.
    exchanges: Vec<Exchange>,
    tones: Tones,
    rays: u32,
    rows: Option<Rows>,
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
            let exchange = polygons::exchange(tracer, patches, enclosure, options.progress)?;
            return Ok(exchange.into());
        }
        let tones = Tones::of(tracer.scene());
        tones.check()?;
        let recipe = options.recipe(patches.len(), &tones)?;
        options.progress.at("trace", 0.0)?;
        let rows = Rows::trace(tracer, patches, (recipe, tones), options.caustics, options.progress)?;
        Ok(Self::balance(rows, patches, options.storage, options.keep, options.progress)?)
    }

    /// Makes exchange areas of rays, for every tone.
    pub(super) fn balance(
        rows: Rows,
        patches: &Patches,
        storage: StorageKind,
        keep: Keep,
        progress: Progress,
    ) -> Result<Self, Cancelled> {
        progress.at("balance", 0.0)?;
        let of = |tone: usize| Exchange::from_rows(&rows, (patches, tone), storage, None, progress);
        let exchanges = (0..rows.tones.len()).map(of).collect::<Result<_, _>>()?;
        let (rays, tones) = (rows.recipe.count.rays, rows.tones.clone());
        let disagreements = disagreements(&rows, patches);
        let rows = (keep == Keep::Rays).then_some(rows);
        Ok(Self { exchanges, tones, rays, rows, disagreements })
    }

    /// How light varies over a patch.
    pub fn basis(&self) -> Basis {
        self.exchange().basis()
    }

    /// Symmetric exchange areas S_ij = A_i F_ij, normalised frame; of the first channel, where coloured
    /// carriers make channels differ.
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
        Exchange::none(patches.etendues(), basis).into()
    }

    /// Form factors that are known already, perhaps with their rays.
    pub(super) fn from_parts(
        (exchanges, tones): (Vec<Exchange>, Tones),
        rays: u32,
        rows: Option<Rows>,
    ) -> Self {
        Self { exchanges, tones, rays, rows, disagreements: Vec::new() }
    }

    /// The rays, if they were kept.
    pub(super) fn rows(&self) -> Option<&Rows> {
        self.rows.as_ref()
    }

    /// Whether lamps were found to shine by way of carriers; only told where rays were kept.
    pub(crate) fn has_caustics(&self) -> bool {
        self.rows().is_some_and(|rows| !rows.caustics.parts().1.is_empty())
    }

    /// The rays alone, if they were kept.
    pub(super) fn into_rows(self) -> Option<Rows> {
        self.rows
    }

    /// The pairs of face sides whose two directions found different exchange areas, by more than
    /// [`DISAGREE`](super::DISAGREE) standard errors, the worst first: something is wrong with the mesh
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
        let exchanges = vec![exchange];
        Self { exchanges, tones: Tones::one(), rays: 0, rows: None, disagreements: Vec::new() }
    }
}
