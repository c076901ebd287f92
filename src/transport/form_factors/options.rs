//! Options: how form factors are traced, and what is refused before any time is spent on it.

use super::constants::{MOST_EXACT, USUAL_RAYS, USUAL_RAYS_OF_PATCH};
use crate::patches::Basis;
use crate::progress::Progress;
use crate::trace::{Enclosure, Tracer, sampling};
use crate::transport::TransportError;
use crate::transport::exchange::{Blocks, StorageKind};
use crate::transport::rows::{BATCHES, RayCount, Recipe, Shots, Tones};

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
    /// a little faster than 1/√rays, time grows in proportion.
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
    pub(crate) fn lamp_rays_for(&self, rays: u32) -> u32 {
        let most = BATCHES * sampling::SEQUENCE_END;
        self.lamp_rays.unwrap_or(rays / 2).min(most).next_multiple_of(BATCHES)
    }

    /// Shadow rays per patch towards lamps for so many patches.
    pub(crate) fn lamp_rays_of(&self, patches: usize) -> u32 {
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
            _ if patches > MOST_EXACT => {
                return Err(format!("more than {MOST_EXACT} patches: rays are quicker"));
            }
            _ if 4 * (patches as u64).pow(2) > self.memory => "a full matrix takes more than --memory allows",
            _ => return Ok(enclosure),
        };
        Err(reason.into())
    }

    /// How rows of so many patches are traced.
    pub(crate) fn recipe(&self, patches: usize, tones: &Tones) -> Result<Recipe, TransportError> {
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
    pub(crate) fn check_rays(&self, patches: usize, rays: u32, tones: usize) -> Result<(), TransportError> {
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
        let [fewest, most] = USUAL_RAYS_OF_PATCH;
        (USUAL_RAYS / patches.max(1)).clamp(fewest, most).next_power_of_two() as u32
    }
}
