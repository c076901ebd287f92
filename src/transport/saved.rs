//! Saved form factors: a file that spares tracing and balancing anew.
//!
//! It holds the rows of rays, the balanced exchange areas, and what they are tied to: a hash of the geometry, the cut, and which
//! faces could send out light. Reflectances and emissions are not part of it. Numbers are little-endian; the file ends with
//! a checksum of all before.

use std::io::{self, Write};

use bytemuck::Pod;
use nalgebra::{DMatrix, DVector};
use sprs::CsMatI;
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::exchange::{Exchange, Storage};
use super::lamp_columns::LampShare;
use super::rays::{RayCount, Recipe, Row, Rows};
use super::{Closure, FormFactors, StorageKind, TransportError};
use crate::patches::{Patches, Tessellation};
use crate::scene::{FaceState, Scene};
use crate::trace::Tracer;

const MAGIC: &[u8; 8] = b"radiosFF";

/// Files of another version are refused.
const VERSION: u32 = 1;

/// Why a file of form factors can't be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FactorsFileError {
    /// It is something else.
    #[error("this is no file of form factors; make one with --save-factors")]
    Foreign,
    /// Another version of the program wrote it.
    #[error("the file has format version {found}, this program reads {VERSION}; save the form factors anew")]
    Version {
        /// The file's version.
        found: u32,
    },
    /// Some of it is missing or altered.
    #[error("the file is damaged: it is cut off or its checksum does not match; save the form factors anew")]
    Damaged,
    /// It belongs to another scene.
    #[error(
        "the file belongs to other geometry: vertices or faces differ from the scene's; save the form factors anew"
    )]
    OtherScene,
}

/// How much of a file could be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reuse {
    /// Rows that were traced now.
    pub traced: usize,
    /// Rows that the file held.
    pub held: usize,
    /// Whether the balanced exchange areas were good as they were.
    pub balanced: bool,
}

impl FormFactors {
    /// Writes the form factors, to be read by [`FormFactors::load`].
    ///
    /// # Errors
    /// `NoRays` unless the rays were kept, as an error of kind `InvalidInput`; else what `to` says.
    pub fn save(&self, patches: &Patches, to: &mut dyn Write) -> io::Result<()> {
        let rows =
            self.rows().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, TransportError::NoRays))?;
        let mut file = Writer { to, hash: Xxh3::new() };
        file.all(MAGIC)?;
        file.one(VERSION)?;
        file.one(geometry_hash(patches.scene()))?;
        file.one(light_hash(patches.scene()))?;
        file.one(patches.normalised_edge())?;
        file.one(rows.recipe.seed)?;
        file.all(&[rows.recipe.count.rays, rows.recipe.count.lamp_rays])?;
        file.list(&rows.lamp_faces)?;
        // The rows, one property after another.
        let all = rows.all();
        file.list(&all.iter().map(|row| row.slot).collect::<Vec<_>>())?;
        all.iter().try_for_each(|row| file.all(&row.landings))?;
        file.all(&all.iter().map(|row| row.lamp_shares.len() as u32).collect::<Vec<_>>())?;
        for row in all {
            file.all(
                &row.lamp_shares
                    .iter()
                    .map(|s| (s.slot, s.batch))
                    .flat_map(|(a, b)| [a, b])
                    .collect::<Vec<_>>(),
            )?;
            file.all(&row.lamp_shares.iter().map(|s| s.share).collect::<Vec<_>>())?;
        }
        // Which slots are patches, and their exchange areas.
        file.list(&(0..patches.len()).map(|i| patches.slot_of_patch(i)).collect::<Vec<_>>())?;
        let (storage, scale) = self.exchange().raw();
        match storage {
            Storage::Dense(m) => {
                file.one(0u32)?;
                file.list(m.as_slice())?;
            }
            Storage::Sparse(m) => {
                file.one(1u32)?;
                file.list(&m.proper_indptr().iter().map(|&start| start as u64).collect::<Vec<_>>())?;
                file.list(m.indices())?;
                file.list(m.data())?;
            }
        }
        file.list(scale.as_slice())?;
        file.list(self.exchange().escape().as_slice())?;
        let Closure { before, after, iterations } = *self.exchange().closure();
        file.all(&[before, after])?;
        file.one(iterations as u64)?;
        let checksum = file.hash.digest();
        file.one(checksum)
    }

    /// Reads form factors of a scene whose lamps, powers and reflectances may have changed since, and traces what is missing: rows of
    /// sides that light newly reaches, columns of lamps that are newly lit. Cut, rays and seed are the file's.
    ///
    /// # Errors
    /// `File`, and those of [`FormFactors::trace`].
    pub fn load<'s>(
        file: &[u8],
        tracer: &Tracer<'s>,
        options: &Tessellation,
        storage: StorageKind,
    ) -> Result<(Patches<'s>, Self, Reuse), TransportError> {
        let progress = options.progress;
        progress.at("load", 0.0)?;
        let scene = tracer.scene();
        let saved = Saved::read(file, scene)?;
        let held = saved.rows.all().len();
        let same_light = saved.light == light_hash(scene);
        let known = same_light.then_some(saved.slots.as_slice());
        let mut patches = Patches::recut(tracer, saved.edge, known, options)?;
        if patches.is_empty() {
            return Err(TransportError::Dark);
        }
        let mut rows = saved.rows;
        progress.at("trace", 0.0)?;
        let changed = rows.adapt(tracer, &mut patches, progress)?;
        let traced = rows.all().len() - held;
        let same_patches = patches.len() == saved.slots.len()
            && (0..patches.len()).all(|i| patches.slot_of_patch(i) == saved.slots[i]);
        let balanced = !changed && same_patches;
        let exchange = if balanced {
            let areas = DVector::from_row_slice(patches.areas());
            Exchange::from_raw(saved.storage, saved.scale, saved.escape, areas, saved.closure)
        } else {
            progress.at("balance", 0.0)?;
            Exchange::from_rows(&rows, &patches, storage, None, progress)?
        };
        Ok((patches, Self::from_parts(exchange, rows), Reuse { traced, held, balanced }))
    }
}

/// What a file says, checked for consistency.
struct Saved {
    light: u64,
    edge: f64,
    rows: Rows,
    slots: Vec<u32>,
    storage: Storage,
    scale: DVector<f64>,
    escape: DVector<f64>,
    closure: Closure,
}

impl Saved {
    fn read(file: &[u8], scene: &Scene) -> Result<Self, FactorsFileError> {
        use FactorsFileError::{Damaged, Foreign, OtherScene, Version};
        if !file.starts_with(MAGIC) {
            return Err(Foreign);
        }
        let mut from = Reader(&file[MAGIC.len()..]);
        let found = from.one::<u32>()?;
        if found != VERSION {
            return Err(Version { found });
        }
        let (content, checksum) = file.split_last_chunk::<8>().ok_or(Damaged)?;
        if xxh3_64(content) != u64::from_le_bytes(*checksum) {
            return Err(Damaged);
        }
        if from.one::<u64>()? != geometry_hash(scene) {
            return Err(OtherScene);
        }
        let light = from.one()?;
        let edge = from.one()?;
        let seed = from.one()?;
        let count = RayCount { rays: from.one()?, lamp_rays: from.one()? };
        let lamp_faces = from.list::<u32>()?;
        let row_slots = from.list::<u32>()?;
        let landings = from.some::<u32>(row_slots.len() * count.rays as usize)?;
        let shares = from.some::<u32>(row_slots.len())?;
        let mut rows = Vec::with_capacity(row_slots.len());
        for (k, (&slot, &shares)) in row_slots.iter().zip(&shares).enumerate() {
            let keys = from.some::<u32>(2 * shares as usize)?;
            let values = from.some::<f32>(shares as usize)?;
            let share = |(key, &share): (&[u32], &f32)| LampShare { slot: key[0], batch: key[1], share };
            rows.push(Row {
                slot,
                landings: landings[k * count.rays as usize..(k + 1) * count.rays as usize].to_vec(),
                lamp_shares: keys.chunks_exact(2).zip(&values).map(share).collect(),
            });
        }
        let slots = from.list::<u32>()?;
        let n = slots.len();
        let storage = match from.one::<u32>()? {
            0 => {
                let values = from.list::<f32>()?;
                if values.len() != n * n {
                    return Err(Damaged);
                }
                Storage::Dense(DMatrix::from_vec(n, n, values))
            }
            _ => {
                let starts = from.list::<u64>()?.into_iter().map(|start| start as usize).collect();
                let (indices, values) = (from.list::<u32>()?, from.list::<f32>()?);
                Storage::Sparse(CsMatI::try_new((n, n), starts, indices, values).map_err(|_| Damaged)?)
            }
        };
        let (scale, escape) = (from.list::<f64>()?, from.list::<f64>()?);
        if scale.len() != n || escape.len() != n {
            return Err(Damaged);
        }
        let (before, after, iterations) = (from.one()?, from.one()?, from.one::<u64>()? as usize);
        Ok(Self {
            light,
            edge,
            rows: Rows::new(Recipe { count, seed }, lamp_faces, rows),
            slots,
            storage,
            scale: DVector::from_vec(scale),
            escape: DVector::from_vec(escape),
            closure: Closure { before, after, iterations },
        })
    }
}

/// A hash of everything that rays can meet.
fn geometry_hash(scene: &Scene) -> u64 {
    let mut hash = Xxh3::new();
    for (k, face) in scene.faces().iter().enumerate() {
        hash.update(&[u8::from(face.state == FaceState::Kept)]);
        scene.corners(k).iter().for_each(|p| hash.update(bytemuck::cast_slice(&p.to_array())));
    }
    hash.digest()
}

/// A hash of which faces could send out light.
fn light_hash(scene: &Scene) -> u64 {
    let of = |k: usize| {
        let material = scene.material_of(k);
        u8::from(material.emits()) + 2 * u8::from(material.reflects())
    };
    xxh3_64(&(0..scene.faces().len()).map(of).collect::<Vec<_>>())
}

/// Writes numbers, and sums them up as it goes.
struct Writer<'a> {
    to: &'a mut dyn Write,
    hash: Xxh3,
}

impl Writer<'_> {
    fn all<T: Pod>(&mut self, values: &[T]) -> io::Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        self.hash.update(bytes);
        self.to.write_all(bytes)
    }

    fn one<T: Pod>(&mut self, value: T) -> io::Result<()> {
        self.all(&[value])
    }

    /// The length, then the values.
    fn list<T: Pod>(&mut self, values: &[T]) -> io::Result<()> {
        self.one(values.len() as u64)?;
        self.all(values)
    }
}

/// The part of a file that is still to be read.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn some<T: Pod>(&mut self, count: usize) -> Result<Vec<T>, FactorsFileError> {
        let bytes = count.checked_mul(size_of::<T>()).filter(|&bytes| bytes <= self.0.len());
        let (values, rest) = self.0.split_at(bytes.ok_or(FactorsFileError::Damaged)?);
        self.0 = rest;
        Ok(bytemuck::pod_collect_to_vec(values))
    }

    fn one<T: Pod>(&mut self) -> Result<T, FactorsFileError> {
        self.some(1).map(|values| values[0])
    }

    fn list<T: Pod>(&mut self) -> Result<Vec<T>, FactorsFileError> {
        let count = self.one::<u64>()?;
        self.some(count as usize)
    }
}
