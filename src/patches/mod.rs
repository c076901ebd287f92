//! Patches: the scene's faces cut into pieces, and the index space of every vector and matrix.
//!
//! Each face is cut into *cells*; a cell's side is a *slot*: a patch that could be. Light reaches some slots
//! and not others (the backs of a closed room's walls, say). The slots it reaches are the *patches*, the
//! unknowns of the problem, numbered by face, then side, then cell. Everything that has one value a patch
//! uses that order.
//!
//! Where other surfaces touch a face, pass through it or end close before it, it is cut along the line: light
//! changes by a step there, and a patch on both sides of the foot of a box would carry light into the box. So
//! no patch is larger than the size asked for, and some are smaller.

mod bright;
mod cut;
mod facet;
mod fields;
mod reach;

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::progress::{Cancelled, Progress};
use crate::scene::{FaceTexture, Feature, Scene, Side, triangle};
use crate::trace::{Frame, Tracer};
pub use bright::{BrightParts, BrightPoint, BrightView};
pub(crate) use cut::Fineness;
pub use cut::{Barycentrics, Cutter, Outlook, Stretch};
use cut::{Cuts, Parting, Parts};
pub(crate) use facet::Facet;
pub use fields::{Basis, Clusters, FaceRow, Group, GroupBy, Groups, Sheets};
pub use reach::{Reach, seeing_sides};

/// How finely to cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PatchSize {
    /// About so many patches in all. Faces are never merged, so a mesh of many faces has at least as many
    /// patches; even then half the count goes to cutting its larger faces. Wide faces with nothing over or
    /// under them, such as the ground around a house, are not counted: they have a sixth as many more,
    /// that grow with their distance from all else.
    Count(usize),
    /// No leg of a patch longer than this, metres.
    Edge(f64),
}

/// How to cut a scene into patches.
#[derive(Clone, Copy, Debug)]
pub struct Tessellation<'a> {
    /// How finely.
    pub size: PatchSize,
    /// Which sides become patches.
    pub reach: Reach,
    /// Number of the random sequence that looks for sides that light reaches.
    pub seed: u64,
    /// The most bytes that finding those sides may take.
    pub memory: u64,
    /// Where to report progress, as stage `patch`.
    pub progress: Progress<'a>,
}

impl Default for Tessellation<'_> {
    /// 8000 patches where light reaches, 4 GiB.
    fn default() -> Self {
        Self {
            size: PatchSize::Count(8000),
            reach: Reach::Light,
            seed: 0,
            memory: 4 << 30,
            progress: Progress::default(),
        }
    }
}

/// Why a scene could not be cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PatchError {
    /// The wanted size makes no sense.
    #[error("the patch size must be positive: {0}")]
    Size(String),
    /// More patches than fit.
    #[error(
        "{slots} patches, both sides counted, are more than the {most} that fit; use a longer --edge, a smaller --patches or more --memory"
    )]
    TooMany {
        /// How many it would be, both sides counted.
        slots: u64,
        /// How many there may be.
        most: u64,
    },
    /// Faces lie on each other in such numbers that which is on top is not worked out.
    #[error(
        "too many faces lie on one another in one plane to say which is on top, face {face} of object {object:?} among them; remove copies of faces, then try again"
    )]
    TooManyOverlaps {
        /// One of the faces.
        face: usize,
        /// Its object.
        object: String,
    },
    /// The observer asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The scene in pieces: what every index of a vector or matrix means.
#[derive(Clone, Debug)]
pub struct Patches<'s> {
    scene: &'s Scene,
    frame: Frame,
    reach: Reach,
    parts: Arc<Parts>,
    cuts: Cuts,
    /// Per face, and one more: its first slot. Front cells come first, then as many back cells.
    first_slot: Vec<u32>,
    /// Per slot: its patch, or [`NONE`].
    patch_of_slot: Vec<u32>,
    /// Per patch: its slot, ascending.
    slot_of_patch: Vec<u32>,
    /// Per patch, normalised frame.
    areas: Vec<f64>,
    /// Per slot, étendue by π per area; empty where all are 1.
    per_area: Vec<f64>,
    /// Per patch, normalised frame; empty where they are the areas.
    etendues: Vec<f64>,
    fineness: Fineness,
    /// Whether light comes through any face.
    is_translucent: bool,
    /// Per slot, whether another face covers it; empty where no faces coincide.
    covered: Vec<bool>,
    /// What textures of reflectance and of emission are on each patch, once that was asked for.
    means: [OnceLock<Means>; 2],
}

/// Per patch, the mean of a texture over it, where it has one.
type Means = Vec<Option<[f64; 3]>>;

/// The patch of a slot that is none.
const NONE: u32 = u32::MAX;

/// What a slot takes while sides are looked for: its patch, and what it sees.
pub(crate) const BYTES_PER_SLOT: u64 = 40;

/// The most slots of a cut: one bit of a 32-bit slot number is left for other purposes.
pub(crate) const MOST_SLOTS: u64 = 1 << 31;

/// The place of a slot: face, side and cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// The face's number.
    pub face: usize,
    /// Front or back.
    pub side: Side,
    /// The cell's number within the face.
    pub cell: u32,
}

impl<'s> Patches<'s> {
    /// Cuts the scene and finds the sides that light reaches.
    ///
    /// # Errors
    /// `Size`, `TooMany`, `TooManyOverlaps` or `Cancelled`.
    pub fn new(tracer: &Tracer<'s>, options: &Tessellation) -> Result<Self, PatchError> {
        Cutter::new(tracer)?.cut(options)
    }

    /// Cuts every face; no slot is a patch yet.
    fn cut(
        tracer: &Tracer<'s>,
        fineness: Fineness,
        parting: &mut Parting,
        options: &Tessellation,
    ) -> Result<Self, PatchError> {
        let scene = tracer.scene();
        // Carriers are on the way between patches and no patches themselves.
        let kept = |f: usize| scene.is_diffuse(f);
        let faces = scene.faces().len();
        let parts = parting.at(fineness.edge);
        let cells = (0..faces).filter(|&f| kept(f)).map(|f| parts.cells(f, tracer.corners(f), fineness));
        let slots = 2 * cells.sum::<u64>();
        let most = (options.memory / BYTES_PER_SLOT).min(MOST_SLOTS);
        if slots > most {
            return Err(PatchError::TooMany { slots, most });
        }
        let cuts = Cuts::new(faces, |f, mut each| {
            if kept(f) {
                parts.visit(f, tracer.corners(f), fineness, &mut each);
            }
        });
        let mut first_slot = vec![0];
        for face in 0..faces {
            first_slot.push(first_slot[face] + 2 * cuts.cells(face));
        }
        let mut patches = Self {
            scene,
            frame: *tracer.frame(),
            reach: options.reach,
            parts,
            cuts,
            patch_of_slot: vec![NONE; slots as usize],
            first_slot,
            slot_of_patch: Vec::new(),
            areas: Vec::new(),
            per_area: Vec::new(),
            etendues: Vec::new(),
            fineness,
            is_translucent: (0..faces).any(|f| kept(f) && scene.material_of(f).transmittance().is_some()),
            covered: Vec::new(),
            means: Default::default(),
        };
        patches.covered = patches.covered_slots(tracer);
        patches.per_area = patches.etendues_per_area(tracer);
        Ok(patches)
    }

    /// Cuts as finely as is known; the patches are the given slots, or those that light reaches.
    pub(crate) fn recut(
        tracer: &Tracer<'s>,
        fineness: Fineness,
        slots: Option<&[u32]>,
        options: &Tessellation,
    ) -> Result<Self, PatchError> {
        if !fineness.is_sound() {
            return Err(PatchError::Size("that of the saved form factors is not".into()));
        }
        let mut patches = Self::cut(tracer, fineness, &mut Parting::new(tracer)?, options)?;
        match slots {
            // Of a file: what the cut does not have is no patch.
            Some(slots) => {
                let all = patches.slots() as u32;
                patches.activate_just(slots.iter().copied().filter(|&slot| slot < all));
            }
            None => patches.reach(tracer, options, reach::LOOK)?,
        }
        Ok(patches)
    }

    /// Makes the given slots patches too, and those on the other side of sheets where light is looked for;
    /// numbers all patches anew.
    pub(crate) fn activate(&mut self, slots: &[u32]) {
        let across: Vec<u32> = match self.reach {
            Reach::Light => slots.iter().filter_map(|&slot| self.across(slot)).collect(),
            Reach::Everything | Reach::OneSide(_) => Vec::new(),
        };
        self.activate_just(slots.iter().copied().chain(across));
    }

    fn activate_just(&mut self, slots: impl Iterator<Item = u32>) {
        for slot in slots {
            if self.is_wanted(slot) {
                self.patch_of_slot[slot as usize] = 0;
            }
        }
        self.means = Default::default();
        self.slot_of_patch = (0..self.patch_of_slot.len() as u32)
            .filter(|&s| self.patch_of_slot[s as usize] != NONE)
            .collect();
        for (patch, &slot) in self.slot_of_patch.iter().enumerate() {
            self.patch_of_slot[slot as usize] = patch as u32;
        }
        self.areas = self
            .slot_of_patch
            .iter()
            .map(|&slot| self.cell_share(slot) * self.face_area(self.slot(slot).face))
            .collect();
        if !self.per_area.is_empty() {
            let per_area = self.slot_of_patch.iter().map(|&slot| self.per_area[slot as usize]);
            self.etendues = self.areas.iter().zip(per_area).map(|(area, each)| area * each).collect();
        }
    }

    /// The share of its face that a slot's cell has: the area of its barycentric triangle.
    fn cell_share(&self, slot: u32) -> f64 {
        let Slot { face, cell, .. } = self.slot(slot);
        let [a, b, c] = self.cuts.corners(face, cell);
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
    }

    /// Number of patches n.
    pub fn len(&self) -> usize {
        self.slot_of_patch.len()
    }

    /// Whether light reaches nothing at all.
    pub fn is_empty(&self) -> bool {
        self.slot_of_patch.is_empty()
    }

    /// The scene that was cut.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// The longest leg a patch may have, metres; but on surroundings, see [`PatchSize::Count`], where it may
    /// be longer.
    pub fn edge(&self) -> f64 {
        self.fineness.edge * self.frame.scale()
    }

    pub(crate) fn fineness(&self) -> Fineness {
        self.fineness
    }

    /// The patch in which a point of a face's side lies; none where light does not reach, and on mirrors and
    /// glass.
    #[inline]
    pub fn patch_at(&self, face: usize, side: Side, point: Barycentrics) -> Option<usize> {
        if self.first_slot[face] == self.first_slot[face + 1] {
            return None;
        }
        let patch = self.patch_of_slot[self.slot_at(face, side, point) as usize];
        (patch != NONE).then_some(patch as usize)
    }

    /// A patch of each piece of a face's side that has a point inside or on its rim.
    pub(crate) fn patches_meeting(&self, face: usize, side: Side, point: Barycentrics) -> Vec<usize> {
        let first = self.first_slot_of(face, side);
        let cells = self.cuts.cells_meeting(face, point).into_iter();
        cells.filter_map(|cell| self.patch_of_slot(first + cell)).map(|patch| patch as usize).collect()
    }

    /// Number of pieces of a face, each with a grid of patches of its own.
    pub(crate) fn pieces(&self, face: usize) -> usize {
        self.cuts.pieces(face).len()
    }

    /// The slot in which a point of a diffuse face's side lies.
    #[inline]
    pub(crate) fn slot_at(&self, face: usize, side: Side, point: Barycentrics) -> u32 {
        self.first_slot_of(face, side) + self.cuts.cell_at(face, point)
    }

    /// Where in a slot's cell a point of the slot's face lies: weights of the cell's second and third corner.
    pub(crate) fn weights_in(&self, slot: u32, point: Barycentrics) -> Barycentrics {
        let Slot { face, cell, .. } = self.slot(slot);
        self.cuts.weights_in(face, cell, point)
    }

    /// The patches of a face's side; they follow one another.
    pub fn patches_of(&self, face: usize, side: Side) -> Range<usize> {
        let slots = self.slots_of(face, side);
        let place = |slot: u32| self.slot_of_patch.partition_point(|&s| s < slot);
        place(slots.start)..place(slots.end)
    }

    /// The slots of a face's side.
    pub(crate) fn slots_of(&self, face: usize, side: Side) -> Range<u32> {
        let first = self.first_slot_of(face, side);
        first..first + self.cuts.cells(face)
    }

    fn first_slot_of(&self, face: usize, side: Side) -> u32 {
        let (first, end) = (self.first_slot[face], self.first_slot[face + 1]);
        first + if side == Side::Back { (end - first) / 2 } else { 0 }
    }

    /// Face, side and cell of a patch.
    pub fn place(&self, patch: usize) -> Slot {
        self.slot(self.slot_of_patch[patch])
    }

    pub(crate) fn slot_of_patch(&self, patch: usize) -> u32 {
        self.slot_of_patch[patch]
    }

    pub(crate) fn patch_of_slot(&self, slot: u32) -> Option<u32> {
        let patch = self.patch_of_slot[slot as usize];
        (patch != NONE).then_some(patch)
    }

    pub(crate) fn slots(&self) -> usize {
        self.patch_of_slot.len()
    }

    pub(crate) fn slot(&self, slot: u32) -> Slot {
        let face = self.first_slot.partition_point(|&first| first <= slot) - 1;
        let cells = self.cuts.cells(face);
        let cell = slot - self.first_slot[face];
        if cell < cells {
            Slot { face, side: Side::Front, cell }
        } else {
            Slot { face, side: Side::Back, cell: cell - cells }
        }
    }

    /// Whether a slot sends out light once light reaches it or its other side: it reflects, lets light
    /// through, or is the front of a lamp. Where everything is to be reached, all do.
    pub(crate) fn is_bright(&self, slot: u32) -> bool {
        if self.reach != Reach::Light {
            return true;
        }
        let Slot { face, side, .. } = self.slot(slot);
        let material = self.scene.material_of(face);
        let goes_on = material.reflects_on(side) || material.transmittance().is_some();
        let sends_on = goes_on && !self.scene.is_without(Feature::Interreflection);
        (sends_on && self.is_wanted(slot)) || (side == Side::Front && material.emits())
    }

    /// Patch areas A, n values, m².
    pub fn areas(&self) -> Vec<f64> {
        (0..self.len()).map(|patch| self.area(patch)).collect()
    }

    /// Étendues by π, n values, m²: A n² (1 − Ē) in a medium of index of refraction n and under a coat of
    /// plastic that reflects Ē, elsewhere the areas.
    pub fn etendues(&self) -> Vec<f64> {
        (0..self.len()).map(|patch| self.etendue(patch)).collect()
    }

    /// Patch areas in the normalised frame.
    pub(crate) fn normalised_areas(&self) -> &[f64] {
        &self.areas
    }

    /// Étendues by π in the normalised frame, n values: A n² (1 − Ē) in a medium of index of refraction n and
    /// under a [coat](crate::trace::Coat), elsewhere the area. What a patch of radiance L, by n², sends out
    /// is π L times this.
    pub(crate) fn normalised_etendues(&self) -> &[f64] {
        if self.per_area.is_empty() { &self.areas } else { &self.etendues }
    }

    /// The unit of area of the normalised frame, m².
    pub(crate) fn unit_of_area(&self) -> f64 {
        self.frame.scale().powi(2)
    }

    /// Area of a patch, m².
    pub fn area(&self, patch: usize) -> f64 {
        self.areas[patch] * self.frame.scale().powi(2)
    }

    /// Étendue of a patch by π, m²: see [`Patches::etendues`].
    pub fn etendue(&self, patch: usize) -> f64 {
        self.normalised_etendues()[patch] * self.frame.scale().powi(2)
    }

    /// For each slot whether another face covers it, told at its centre; nothing at all where no faces
    /// coincide.
    fn covered_slots(&self, tracer: &Tracer) -> Vec<bool> {
        if tracer.overlaps().is_empty() {
            return Vec::new();
        }
        let is_covered = |slot: u32| {
            let Slot { face, side, .. } = self.slot(slot);
            !tracer.covers(face, side).is_empty()
                && tracer.is_covered(face as u32, side, self.facet(tracer, slot).centre())
        };
        (0..self.slots() as u32).into_par_iter().map(is_covered).collect()
    }

    /// Whether another face covers a slot, so that it is met by nothing and never becomes a patch.
    pub(crate) fn is_covered(&self, slot: u32) -> bool {
        self.covered.get(slot as usize).is_some_and(|&covered| covered)
    }

    /// Area of what no other face covers of a face's side, normalised frame.
    fn bare_area(&self, face: usize, side: Side) -> f64 {
        let all = self.face_area(face);
        if self.covered.is_empty() {
            return all;
        }
        let covered = self.slots_of(face, side).filter(|&slot| self.is_covered(slot));
        all * (1.0 - covered.map(|slot| self.cell_share(slot)).sum::<f64>()).max(0.0)
    }

    /// Area of a face, normalised frame.
    fn face_area(&self, face: usize) -> f64 {
        triangle::area(&self.scene.corners(face).map(|p| self.frame.from_world(p)))
    }

    /// Corners of a patch as points of its face, counter-clockwise seen from the front.
    pub fn corners(&self, patch: usize) -> [Barycentrics; 3] {
        let Slot { face, cell, .. } = self.place(patch);
        self.cuts.corners(face, cell)
    }

    /// The point of a face with these barycentrics, metres.
    pub fn point(&self, face: usize, point: Barycentrics) -> DVec3 {
        triangle::point(&self.scene.corners(face), point)
    }

    /// Centre of a patch, metres.
    pub fn centre(&self, patch: usize) -> DVec3 {
        let [a, b, c] = self.corners(patch);
        self.point(self.place(patch).face, [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0))
    }

    /// Reflectance ρ of each patch's side, n × c; where a texture varies it, its mean over the patch.
    pub fn reflectances(&self) -> DMatrix<f64> {
        let scene = self.scene;
        let places: Vec<Slot> = (0..self.len()).map(|i| self.place(i)).collect();
        let mut rho = DMatrix::from_fn(self.len(), scene.channels(), |i, c| {
            scene.material_of(places[i].face).reflectance_of(places[i].side)[c]
        });
        self.vary(&mut rho, &self.means[0], |i| scene.reflectance_texture(places[i].face));
        rho
    }

    /// Emitted radiance Lₑ, n × c, W·sr⁻¹·m⁻²; where a texture varies it, its mean over the patch.
    pub fn emitted_radiance(&self) -> DMatrix<f64> {
        let scene = self.scene;
        let places: Vec<Slot> = (0..self.len()).map(|i| self.place(i)).collect();
        let mut emission = DMatrix::from_fn(self.len(), scene.channels(), |i, c| match places[i].side {
            Side::Front => scene.material_of(places[i].face).emission[c],
            Side::Back => 0.0,
        });
        self.vary(&mut emission, &self.means[1], |i| scene.emission_texture(places[i].face));
        emission
    }

    /// Multiplies each patch's row by the mean over the patch of its texture, where it has one.
    fn vary<'t>(
        &self,
        rows: &mut DMatrix<f64>,
        means: &OnceLock<Means>,
        texture: impl Fn(usize) -> Option<FaceTexture<'t>> + Sync,
    ) {
        if !self.scene.has_textures() {
            return;
        }
        let mean = |i: usize| texture(i).map(|texture| texture.mean_over(self.corners(i)));
        // Not made under the lock: a thread that waits for others may take up work that asks for the same.
        let means = match means.get() {
            Some(known) => known,
            None => {
                let found = (0..self.len()).into_par_iter().map(mean).collect();
                means.get_or_init(|| found)
            }
        };
        for (mut row, factors) in rows.row_iter_mut().zip(means) {
            let factors = factors.unwrap_or([1.0; 3]);
            row.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
        }
    }

    /// Emitted radiance of each material's lamps by themselves; the sum over materials is
    /// [`Patches::emitted_radiance`].
    pub fn lamp_groups(&self) -> Vec<LampGroup> {
        let all = self.emitted_radiance();
        let material_of = |i: usize| self.scene.faces()[self.place(i).face].material as usize;
        let of_patch: Vec<usize> = (0..self.len()).map(material_of).collect();
        let emitting = (0..self.scene.materials().len()).filter(|&m| self.scene.materials()[m].emits());
        let group = |m: usize| {
            let only = |i: usize, c: usize| if of_patch[i] == m { all[(i, c)] } else { 0.0 };
            let emitted = DMatrix::from_fn(all.nrows(), all.ncols(), only);
            LampGroup { material: self.scene.materials()[m].name.clone(), emitted }
        };
        emitting.map(group).filter(|group| group.emitted.amax() > 0.0).collect()
    }
}

/// The lamps of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct LampGroup {
    /// The material's name.
    pub material: String,
    /// Emitted radiance Lₑ of these lamps alone, n × c, W·sr⁻¹·m⁻².
    pub emitted: DMatrix<f64>,
}
