//! Sheets: which patches lie back to back on surfaces that let light through, and how much comes through
//! them.
//!
//! Both sides of a face share its cut, so that the two patches of a pair have the same area, the same corners
//! in the same order and the same basis functions: coefficient a of the one lies on coefficient a of the
//! other.

use nalgebra::DMatrix;

use super::basis::Basis;
use super::clusters::Clusters;
use crate::patches::Patches;
use crate::scene::Side;

/// Pairs of patches, or of coefficients, between which light goes by coming through a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheets {
    /// Front and back of each pair; no index is in two.
    pub pairs: Vec<[usize; 2]>,
    /// Transmittance τ of each pair, pairs × c, 0 to 1.
    pub transmittance: DMatrix<f64>,
}

impl Sheets {
    /// The same by coefficients of a basis.
    pub fn by_coefficients(&self, basis: Basis) -> Self {
        let each = basis.coefficients();
        let pairs = |&[front, back]: &[usize; 2]| (0..each).map(move |a| [each * front + a, each * back + a]);
        Self {
            pairs: self.pairs.iter().flat_map(pairs).collect(),
            transmittance: basis.coefficients_of(&self.transmittance),
        }
    }

    /// Those of clusters: the τ of a pair is that of its patches, which are of one material.
    ///
    /// # Panics
    /// If a pair of clusters has patches that are no pairs.
    pub fn merged(&self, clusters: &Clusters) -> Self {
        let mut found: Vec<([usize; 2], usize)> = Vec::new();
        for (p, pair) in self.pairs.iter().enumerate() {
            found.push((pair.map(|patch| clusters.of_patch[patch]), p));
        }
        found.sort_unstable();
        found.dedup_by_key(|(pair, _)| *pair);
        let mut fronts: Vec<usize> = found.iter().map(|(pair, _)| pair[0]).collect();
        fronts.dedup();
        assert_eq!(fronts.len(), found.len(), "a cluster of fronts has one of backs");
        let channels = self.transmittance.ncols();
        Self {
            pairs: found.iter().map(|(pair, _)| *pair).collect(),
            transmittance: DMatrix::from_fn(found.len(), channels, |p, c| {
                self.transmittance[(found[p].1, c)]
            }),
        }
    }
}

impl Patches<'_> {
    /// The pairs of patches between which light comes through sheets; none where no sheet lets light through,
    /// or is a patch on both sides.
    pub fn sheets(&self) -> Option<Sheets> {
        if !self.is_translucent {
            return None;
        }
        let fronts = (0..self.len()).filter(|&i| self.place(i).side == Side::Front);
        let pair = |front: usize| {
            let back = self.patch_of_slot(self.across(self.slot_of_patch(front))?)?;
            Some([front, back as usize])
        };
        let pairs: Vec<[usize; 2]> = fronts.filter_map(pair).collect();
        let tau = |p: usize, c: usize| {
            let material = self.scene.material_of(self.place(pairs[p][0]).face);
            material.transmittance().map_or(0.0, |tau| tau[c])
        };
        let transmittance = DMatrix::from_fn(pairs.len(), self.scene.channels(), tau);
        (!pairs.is_empty()).then_some(Sheets { pairs, transmittance })
    }

    /// Transmittance τ of each patch, n × c; none where no sheet lets light through.
    pub fn transmittances(&self) -> Option<DMatrix<f64>> {
        let of_face: Vec<usize> = (0..self.len()).map(|i| self.place(i).face).collect();
        let tau =
            |i: usize, c: usize| self.scene.material_of(of_face[i]).transmittance().map_or(0.0, |tau| tau[c]);
        self.is_translucent.then(|| DMatrix::from_fn(self.len(), self.scene.channels(), tau))
    }

    /// The slot on the other side, where light comes through.
    pub(crate) fn across(&self, slot: u32) -> Option<u32> {
        if !self.is_translucent {
            return None;
        }
        let place = self.slot(slot);
        self.scene.material_of(place.face).transmittance()?;
        let cells = self.cuts.cells(place.face);
        Some(if place.side == Side::Front { slot + cells } else { slot - cells })
    }
}
