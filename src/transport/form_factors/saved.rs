//! Saved form factors: a file that spares tracing and balancing anew.
//!
//! It holds the rows of rays, the balanced exchange areas, and what they are tied to: a hash of the geometry,
//! the cut, and which faces could send out light. Reflectances and emissions are not part of it. Numbers are
//! little-endian. There are two sections, each with its length in front and its checksum behind: the exchange
//! areas, which are always read, and the rows, which are read only when something must be traced or balanced
//! anew.

use std::io::{self, Read, Seek, Write};

use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::options::Keep;
use super::saved_exchange::{read_exchange, write_exchange};
use super::sections::{Content, FactorsFileError, Section, VERSION, ends_with_section, read_section};
use super::{FormFactors, sound};
use crate::patches::{Basis, Fineness, Patches, Tessellation};
use crate::scene::{FaceState, Scene, Side, Surface};
use crate::trace::{Lamps, Tracer};
use crate::transport::TransportError;
use crate::transport::exchange::{Exchange, ExchangeParts, Mass, StorageKind};
use crate::transport::rows::{
    BATCHES, Caustic, Caustics, LampShare, Look, RayCount, Recipe, Row, Rows, Spot, Tones,
};

const MAGIC: &[u8; 8] = b"radiosFF";

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
        to.write_all(MAGIC)?;
        to.write_all(&VERSION.to_le_bytes())?;
        let mut section = Section::default();
        section.some(&[geometry_hash(patches.scene()), light_hash(patches.scene())]);
        let Fineness { edge, around: [near, growth], .. } = patches.fineness();
        section.some(&[edge, near, growth]);
        section.one(rows.recipe.seed);
        section.some(&[rows.recipe.count.rays, rows.recipe.count.lamp_rays]);
        section.one(rows.recipe.basis.coefficients() as u32);
        section.list(&rows.lamp_faces);
        section.one(rows.all().len() as u64);
        section.list(&(0..patches.len()).map(|i| patches.slot_of_patch(i)).collect::<Vec<_>>());
        section.one(self.exchanges().len() as u32);
        self.exchanges().iter().for_each(|exchange| write_exchange(exchange, &mut section));
        section.write(to)?;
        rows_section(rows).write(to)
    }
    /// Reads form factors of a scene whose lamps, powers and reflectances may have changed since, and traces
    /// what is missing: rows of sides that light newly reaches, columns of lamps that are newly lit. Cut,
    /// rays, basis and seed are the file's.
    ///
    /// # Errors
    /// `File`, and those of [`FormFactors::trace`].
    pub fn load<'s>(
        file: &mut (impl Read + Seek),
        tracer: &Tracer<'s>,
        options: &Tessellation,
        storage: StorageKind,
        keep: Keep,
    ) -> Result<(Patches<'s>, Self, Reuse), TransportError> {
        let progress = options.progress;
        progress.at("load", 0.0)?;
        let scene = tracer.scene();
        let saved = Saved::read(file, scene)?;
        let RayCount { rays: per_patch, lamp_rays } = saved.recipe.count;
        let held = saved.held;
        // Where the same faces may send out light and the same are lamps, all is as it was.
        let same_light = saved.light == light_hash(scene);
        let known = same_light.then_some(saved.slots.as_slice());
        let mut patches = Patches::recut(tracer, saved.fineness, known, options)?;
        saved.check(&patches, known)?;
        if patches.is_empty() {
            return Err(TransportError::Dark);
        }
        let lamps = Lamps::of_interest(tracer, lamp_rays);
        if same_light && lamps.faces().eq(saved.lamp_faces.iter().copied()) {
            let rows = (keep == Keep::Rays).then(|| saved.read_rows(file, &patches)).transpose()?;
            if rows.as_ref().is_some_and(|rows| !sound::has_all(rows, &patches)) {
                return Err(FactorsFileError::Unsound { part: "rows" }.into());
            }
            let mass = Mass::of(saved.recipe.basis, &patches);
            let exchange = |parts| Exchange::from_parts(parts, mass.clone());
            let exchanges: Vec<Exchange> = saved.exchanges.into_iter().map(exchange).collect();
            if !exchanges.iter().all(sound::is_exchange) {
                return Err(FactorsFileError::Unsound { part: "exchange areas" }.into());
            }
            let reuse = Reuse { traced: 0, held, balanced: true };
            return Ok((patches, Self::from_parts((exchanges, saved.tones), per_patch, rows), reuse));
        }
        progress.at("trace", 0.0)?;
        let mut rows = saved.read_rows(file, &patches)?;
        rows.adapt(tracer, &mut patches, progress)?;
        let reuse = Reuse { traced: rows.all().len() - held, held, balanced: false };
        let factors = Self::balance(rows, &patches, storage, keep, progress)?;
        Ok((patches, factors, reuse))
    }
}

/// The rows, one property after another.
fn rows_section(rows: &Rows) -> Section {
    let mut section = Section::default();
    let all = rows.all();
    section.some(&all.iter().map(|row| row.slot).collect::<Vec<_>>());
    section.some(&all.iter().map(|row| row.lamps.shares.len() as u32).collect::<Vec<_>>());
    for row in all {
        section.some(&row.landings);
        section.some(&row.survivors);
        section.some(&row.spots);
        section.some(&row.lamps.shares.iter().map(|share| [share.slot, share.batch]).collect::<Vec<_>>());
        section.some(&row.lamps.shares.iter().map(|share| share.share).collect::<Vec<_>>());
        section.some(&row.lamps.moments);
        section.some(&row.lamps.excess);
    }
    let (shots, caustics) = rows.caustics.parts();
    section.one(shots);
    section.list(caustics);
    section
}

/// What the first section of a file says, checked for consistency.
struct Saved {
    light: u64,
    fineness: Fineness,
    recipe: Recipe,
    lamp_faces: Vec<u32>,
    /// Number of rows in the second section.
    held: usize,
    slots: Vec<u32>,
    tones: Tones,
    /// One for each tone.
    exchanges: Vec<ExchangeParts>,
}

impl Saved {
    fn read(file: &mut (impl Read + Seek), scene: &Scene) -> Result<Self, FactorsFileError> {
        use FactorsFileError::{Damaged, Foreign, OtherScene, Version};
        let mut magic = [0; MAGIC.len()];
        if file.read_exact(&mut magic).is_err() || magic != *MAGIC {
            return Err(Foreign);
        }
        let mut version = [0; 4];
        file.read_exact(&mut version)?;
        let found = u32::from_le_bytes(version);
        if found != VERSION {
            return Err(Version { found });
        }
        let section = read_section(file)?;
        ends_with_section(file)?;
        let mut from = Content(&section);
        if from.one::<u64>()? != geometry_hash(scene) {
            return Err(OtherScene);
        }
        let light = from.one()?;
        let fineness = Fineness::new(from.one()?, [from.one()?, from.one()?]);
        let seed = from.one()?;
        let count = RayCount { rays: from.one()?, lamp_rays: from.one()? };
        let basis = match from.one::<u32>()? {
            1 => Basis::Constant,
            3 => Basis::Linear,
            _ => return Err(Damaged),
        };
        let lamp_faces = from.list()?;
        let held = from.one::<u64>()? as usize;
        let slots = from.list::<u32>()?;
        let tones = Tones::of(scene);
        if from.one::<u32>()? as usize != tones.len() {
            return Err(Damaged);
        }
        let read = |_| read_exchange(&mut from, basis, slots.len());
        let exchanges = (0..tones.len()).map(read).collect::<Result<_, _>>()?;
        let recipe = Recipe { count, seed, basis };
        Ok(Self { light, fineness, recipe, lamp_faces, held, slots, tones, exchanges })
    }

    /// Holds what is known of patches against the cut; `known` are those that were taken from here.
    fn check(&self, patches: &Patches, known: Option<&[u32]>) -> Result<(), FactorsFileError> {
        let unsound = |part| Err(FactorsFileError::Unsound { part });
        if !sound::is_recipe(&self.recipe) {
            return unsound("number of rays");
        }
        let faces = patches.scene().faces().len() as u32;
        if !(self.lamp_faces.is_sorted_by(|a, b| a < b) && self.lamp_faces.iter().all(|&face| face < faces)) {
            return unsound("list of lamps");
        }
        let as_cut =
            |slots: &[u32]| slots.iter().copied().eq((0..patches.len()).map(|i| patches.slot_of_patch(i)));
        if !known.is_none_or(as_cut) {
            return unsound("list of patches");
        }
        Ok(())
    }

    /// Reads the second section.
    fn read_rows(&self, file: &mut (impl Read + Seek), patches: &Patches) -> Result<Rows, FactorsFileError> {
        let section = read_section(file)?;
        let mut from = Content(&section);
        let slots = from.some::<u32>(self.held)?;
        let shares = from.some::<u32>(self.held)?;
        let mut rows = Vec::with_capacity(self.held);
        for (slot, shares) in slots.into_iter().zip(shares) {
            let (rays, shares) = (self.recipe.count.rays as usize, shares as usize);
            let landings = from.some(rays)?;
            let more = |count: usize| if self.recipe.basis == Basis::Linear { count } else { 0 };
            let toned = if self.tones.len() > 1 { rays } else { 0 };
            let survivors = from.some(toned)?;
            let spots = from.some::<Spot>(more(rays))?;
            let keys = from.some::<[u32; 2]>(shares)?;
            let values = from.some::<f32>(shares)?;
            let share = |([slot, batch], share): ([u32; 2], f32)| LampShare { slot, batch, share };
            let (kept, moments) =
                (keys.into_iter().zip(values).map(share).collect(), from.some(more(shares))?);
            let mut excess = [0.0; BATCHES as usize];
            excess.copy_from_slice(&from.some::<f32>(BATCHES as usize)?);
            let lamps = Look { shares: kept, moments, excess };
            rows.push(Row { slot, landings, survivors, spots, lamps });
        }
        let caustics = Caustics::from_parts(from.one()?, from.list::<Caustic>()?);
        let rows = Rows::new((self.recipe, self.tones.clone()), self.lamp_faces.clone(), rows, caustics);
        if sound::is_rows(&rows, patches) {
            Ok(rows)
        } else {
            Err(FactorsFileError::Unsound { part: "rows" })
        }
    }
}

/// A hash of everything that rays can meet, and of what mirrors, metals, glass and coats do with them.
fn geometry_hash(scene: &Scene) -> u64 {
    let mut hash = Xxh3::new();
    for (k, face) in scene.faces().iter().enumerate() {
        hash.update(&[u8::from(face.state == FaceState::Kept)]);
        scene.corners(k).iter().for_each(|p| hash.update(bytemuck::cast_slice(&p.to_array())));
        let surface = &scene.material_of(k).surface;
        if let Surface::Plastic { index, roughness } = surface {
            hash.update(bytemuck::bytes_of(&[4.0, *index, *roughness]));
        }
        if let Some(colour) = surface.colour() {
            let number = match surface {
                Surface::Mirror { .. } | Surface::Diffuse | Surface::Plastic { .. } => [0.0, 0.0],
                Surface::Dielectric { index, .. } => [1.0, *index],
                Surface::Conductor { roughness, .. } => [2.0, *roughness],
                Surface::Pane { index, .. } => [3.0, *index],
            };
            hash.update(bytemuck::bytes_of(&number));
            hash.update(bytemuck::cast_slice(colour));
        }
    }
    hash.digest()
}

/// A hash of which faces could send out light.
fn light_hash(scene: &Scene) -> u64 {
    let flags = |k: usize| {
        let material = scene.material_of(k);
        let through = material.transmittance().is_some();
        let back = material.reflects_on(Side::Back) != material.reflects_on(Side::Front);
        u8::from(material.emits())
            + 2 * u8::from(material.reflects_on(Side::Front))
            + 4 * u8::from(back)
            + 8 * u8::from(through)
    };
    xxh3_64(&(0..scene.faces().len()).map(flags).collect::<Vec<_>>())
}
