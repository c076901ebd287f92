//! Clusters: neighbouring patches taken together, the way a coarser cut would have them.
//!
//! Each face is cut anew with a longer edge, and the patches whose centres lie in the same cell of it form a
//! cluster. Where a face is too small to be cut any more coarsely, its patches are taken together with those
//! of other faces of the same object, material and side: these are halved again and again across the
//! direction in which their centres or their normals spread most. Where the light on them is known, what it
//! tells apart is not taken together: the two sides of a wall would leak into each other. On sheets that let
//! light through, the backs of a cluster's patches are a cluster too.

use std::collections::HashMap;

use glam::DVec3;
use nalgebra::DMatrix;

use crate::patches::cut::Cuts;
use crate::patches::{Patches, Slot};
use crate::scene::Side;
use crate::scene::triangle;

/// How far apart two opposite normals are taken to be, as a share of the scene's size: patches that face
/// elsewhere part first.
const TURN: f64 = 0.5;

/// Faces on which the light is more than so many times as strong as on others are not taken together with
/// them.
const UNLIKE: f64 = 4.0;

/// A way to take patches together.
#[derive(Clone, Debug, PartialEq)]
pub struct Clusters {
    /// Per patch, its cluster's number.
    pub of_patch: Vec<usize>,
    /// Number of clusters.
    pub count: usize,
}

impl Patches<'_> {
    /// Clusters of about `patches` patches each, on edges so many times longer as its root says. `light` is
    /// how strong it is on each patch, in any unit. Without it objects and materials of too few patches are
    /// taken together too.
    ///
    /// # Panics
    /// If `light` has not one value per patch.
    pub fn clusters(&self, patches: f64, light: Option<&[f64]>) -> Clusters {
        assert!(light.is_none_or(|light| light.len() == self.len()), "one value per patch");
        // Along the same contacts: no cluster has patches on both sides of one.
        let fineness = self.fineness.coarser(patches.sqrt());
        let coarse = Cuts::new(self.scene.faces().len(), |f, mut each| {
            if self.scene.is_diffuse(f) {
                let corners = self.scene.corners(f).map(|p| self.frame.from_world(p));
                self.parts.visit(f, &corners, fineness, &mut each);
            }
        });
        let mut cells: HashMap<(usize, bool, u32), (Slot, Vec<u32>)> = HashMap::new();
        let sheets = self.sheets();
        let mut is_mirrored = vec![false; self.len()];
        sheets.iter().flat_map(|sheets| &sheets.pairs).for_each(|&[_, back]| is_mirrored[back] = true);
        for i in (0..self.len()).filter(|&i| !is_mirrored[i]) {
            let place = self.place(i);
            let [a, b, c] = self.corners(i);
            let centre = [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0);
            let cell = coarse.cell_at(place.face, centre);
            let slot = Slot { cell, ..place };
            let key = (place.face, place.side == Side::Back, cell);
            cells.entry(key).or_insert((slot, Vec::new())).1.push(i as u32);
        }
        let mut cells: Vec<_> = cells.into_values().collect();
        cells.sort_by_key(|(_, members)| members[0]);
        let mut clusters = Clusters { of_patch: vec![0; self.len()], count: 0 };
        let mut small = Vec::new();
        for (slot, members) in cells {
            // Where a coarser cut is meant, what a face's border leaves over stays by itself, as it would
            // there; but surroundings are cut into parts of few patches each.
            let is_around = self.parts.is_around(slot.face, self.fineness);
            let count = match light {
                Some(_) if !is_around => self.patches_of(slot.face, slot.side).len(),
                _ => members.len(),
            };
            if count as f64 > 0.5 * patches {
                clusters.add(&members);
            } else {
                small.push((slot, members));
            }
        }
        self.pool(small, (patches, light), &mut clusters);
        if let Some(sheets) = sheets {
            clusters.mirror(&sheets.pairs);
        }
        clusters
    }

    /// Takes together the cells of faces that have too few patches each.
    fn pool(
        &self,
        cells: Vec<(Slot, Vec<u32>)>,
        (patches, light): (f64, Option<&[f64]>),
        clusters: &mut Clusters,
    ) {
        let centre_of = |members: &[u32]| {
            members.iter().map(|&i| self.centre(i as usize)).sum::<DVec3>() / members.len() as f64
        };
        let centres: Vec<DVec3> = cells.iter().map(|(_, members)| centre_of(members)).collect();
        let (low, high) = bounds(centres.iter().copied());
        let turn = TURN * 0.5 * (high - low).max_element();
        let normals: Vec<DVec3> = cells
            .iter()
            .map(|(slot, _)| {
                let front = triangle::normal(&self.scene.corners(slot.face));
                turn * if slot.side == Side::Back { -front } else { front }
            })
            .collect();
        let kind = |cell: usize| {
            let slot = cells[cell].0;
            let face = &self.scene.faces()[slot.face];
            (face.object, face.material, slot.side == Side::Back)
        };
        let mut order: Vec<usize> = (0..cells.len()).collect();
        order.sort_by_key(|&cell| (kind(cell), cell));
        let light_on = |members: &[u32]| {
            light.map_or(1.0, |light| {
                let sum: f64 = members.iter().map(|&i| light[i as usize]).sum();
                sum / members.len() as f64
            })
        };
        let lights: Vec<f64> = cells.iter().map(|(_, members)| light_on(members)).collect();
        let halving =
            Halving { cells: &cells, features: [&centres, &normals], light: &lights, most: patches };
        let mut few = Vec::new();
        for alike in order.chunk_by_mut(|&a, &b| kind(a) == kind(b)) {
            let members: usize = alike.iter().map(|&cell| cells[cell].1.len()).sum();
            // Where only a field is to be smoothed, what is too few by itself joins others nearby; fronts of
            // sheets would take backs with them.
            let is_sheet = self.scene.material_of(cells[alike[0]].0.face).transmittance().is_some();
            if light.is_none() && (members as f64) < 0.5 * patches && !is_sheet {
                few.extend_from_slice(alike);
            } else {
                halving.halve(alike, clusters);
            }
        }
        if !few.is_empty() {
            halving.halve(&mut few, clusters);
        }
    }

    /// Averages a field (n × c) over clusters, weighted by area: a row per cluster.
    ///
    /// # Panics
    /// If `field` has not n rows.
    pub fn average_by(&self, clusters: &Clusters, field: &DMatrix<f64>) -> DMatrix<f64> {
        assert_eq!(field.nrows(), self.len(), "one row per patch");
        let mut areas = vec![0.0; clusters.count];
        let mut sums = DMatrix::zeros(clusters.count, field.ncols());
        for (i, &cluster) in clusters.of_patch.iter().enumerate() {
            areas[cluster] += self.areas[i];
            (0..field.ncols()).for_each(|c| sums[(cluster, c)] += self.areas[i] * field[(i, c)]);
        }
        sums.column_iter_mut()
            .for_each(|mut sums| sums.iter_mut().zip(&areas).for_each(|(sum, area)| *sum /= area));
        sums
    }

    /// Gives each patch what its cluster has: from a row per cluster to one per patch.
    pub fn spread_over(&self, clusters: &Clusters, field: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.len(), field.ncols(), |i, c| field[(clusters.of_patch[i], c)])
    }
}

impl Clusters {
    /// Makes a cluster of these patches.
    fn add(&mut self, patches: &[u32]) {
        patches.iter().for_each(|&i| self.of_patch[i as usize] = self.count);
        self.count += 1;
    }

    /// Takes backs together as their fronts are.
    fn mirror(&mut self, pairs: &[[usize; 2]]) {
        let mut mirrored: HashMap<usize, usize> = HashMap::new();
        for &[front, back] in pairs {
            let next = self.count + mirrored.len();
            self.of_patch[back] = *mirrored.entry(self.of_patch[front]).or_insert(next);
        }
        self.count += mirrored.len();
    }
}

/// Halving sets of cells until what is left makes a cluster.
struct Halving<'a> {
    cells: &'a [(Slot, Vec<u32>)],
    /// Centres and normals.
    features: [&'a [DVec3]; 2],
    light: &'a [f64],
    most: f64,
}

impl Halving<'_> {
    fn halve(&self, set: &mut [usize], clusters: &mut Clusters) {
        let patches = || set.iter().flat_map(|&cell| &self.cells[cell].1).copied();
        if set.len() == 1 || patches().count() as f64 <= self.most {
            return self.part_by_light(set, clusters);
        }
        let spread = self.features.map(|feature| {
            let (low, high) = bounds(set.iter().map(|&cell| feature[cell]));
            high - low
        });
        let widest = usize::from(spread[1].max_element() > spread[0].max_element());
        let axis = spread[widest].max_position();
        let place = |cell: usize| self.features[widest][cell][axis];
        set.sort_by(|&a, &b| place(a).total_cmp(&place(b)).then(a.cmp(&b)));
        // Positions are halved by number; normals in the middle, where the turn is.
        let half = match widest {
            0 => set.len() / 2,
            _ => {
                let middle = 0.5 * (place(set[0]) + place(set[set.len() - 1]));
                set.partition_point(|&cell| place(cell) <= middle).min(set.len() - 1)
            }
        };
        let (first, second) = set.split_at_mut(half);
        self.halve(first, clusters);
        self.halve(second, clusters);
    }

    /// Makes clusters of cells with like light.
    fn part_by_light(&self, set: &mut [usize], clusters: &mut Clusters) {
        set.sort_by(|&a, &b| self.light[a].total_cmp(&self.light[b]).then(a.cmp(&b)));
        let mut left = &set[..];
        while let Some(&darkest) = left.first() {
            let alike = left.partition_point(|&cell| self.light[cell] <= UNLIKE * self.light[darkest]);
            let (together, others) = left.split_at(alike);
            let members: Vec<u32> = together.iter().flat_map(|&cell| &self.cells[cell].1).copied().collect();
            clusters.add(&members);
            left = others;
        }
    }
}

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::{PatchSize, Tessellation};
    use crate::scene::Scene;
    use crate::trace::Tracer;

    #[test]
    fn what_light_tells_apart_is_not_taken_together() {
        // Faces of a patch or two each, every other one bright.
        let scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/gallery.obj")).unwrap();
        let tracer = Tracer::new(&scene);
        let size = PatchSize::Count(1000);
        let patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
        let light: Vec<f64> =
            (0..patches.len()).map(|i| if i % 2 == 0 { 1.0 } else { 2.0 * UNLIKE }).collect();
        let mixed = |clusters: &Clusters| {
            let mut seen: Vec<Option<f64>> = vec![None; clusters.count];
            (0..patches.len())
                .filter(|&i| *seen[clusters.of_patch[i]].get_or_insert(light[i]) != light[i])
                .count()
        };
        assert!(mixed(&patches.clusters(8.0, None)) > 0);
        let alike = patches.clusters(8.0, Some(&light));
        assert_eq!(mixed(&alike), 0);
        assert!(2 * alike.count < patches.len(), "{} of {}", alike.count, patches.len());
    }
}
