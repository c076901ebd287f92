//! Aggregation: from patches up to faces, and over to the patches of another cut.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::patches::Patches;
use crate::scene::Side;
use crate::trace::sampling::{Stream, uniform_triangle};

/// Less than this part of a face is rounding.
const ROUNDING: f64 = 1e-9;

/// Points of a patch at which the field of another cut is read.
const POINTS: u32 = 64;

/// The average of a field over one side of a face.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceRow {
    /// The face's number.
    pub face: usize,
    /// Front or back.
    pub side: Side,
    /// Area of what no other face covers of it, m².
    pub area: f64,
    /// The field's average per channel over that; parts that no light reaches count as zero.
    pub mean: Vec<f64>,
}

impl Patches<'_> {
    /// Averages a field (n × c) over faces, weighted by area: a row per face and side that has patches, in
    /// order of face and side.
    ///
    /// # Panics
    /// If `field` has not n rows.
    pub fn average_by_face(&self, field: &DMatrix<f64>) -> Vec<FaceRow> {
        assert_eq!(field.nrows(), self.len(), "one row per patch");
        let faces = 0..self.scene.faces().len();
        let sides = faces.flat_map(|face| Side::BOTH.map(|side| (face, side, self.patches_of(face, side))));
        sides
            .filter(|(_, _, patches)| !patches.is_empty())
            .map(|(face, side, patches)| {
                let area = self.bare_area(face, side);
                let mean =
                    |c: usize| patches.clone().map(|i| self.areas[i] * field[(i, c)]).sum::<f64>() / area;
                let mean = (0..field.ncols()).map(mean).collect();
                FaceRow { face, side, area: area * self.frame.scale().powi(2), mean }
            })
            .collect()
    }

    /// Area (m²) that no light reaches on sides of faces that have patches: a row per face and side, where
    /// there is any.
    pub fn dark_areas(&self) -> Vec<(usize, Side, f64)> {
        let faces = 0..self.scene.faces().len();
        let sides = faces.flat_map(|face| Side::BOTH.map(|side| (face, side)));
        let dark = |(face, side): (usize, Side)| {
            let patches = self.patches_of(face, side);
            let bare = self.bare_area(face, side);
            let dark = bare - patches.clone().map(|i| self.areas[i]).sum::<f64>();
            let is_dark = !patches.is_empty() && dark > ROUNDING * bare;
            is_dark.then(|| (face, side, dark * self.frame.scale().powi(2)))
        };
        sides.filter_map(dark).collect()
    }

    /// Averages a field over the patches of another cut of the same scene (m × c) over these patches, n × c:
    /// each by 64 points. Where the other cut has no patch the field is zero.
    ///
    /// # Panics
    /// If `field` has not m rows.
    pub fn resample(&self, other: &Patches, field: &DMatrix<f64>) -> DMatrix<f64> {
        assert_eq!(field.nrows(), other.len(), "one row per patch");
        let channels = field.ncols();
        let mut means = vec![0.0; self.len() * channels];
        means.par_chunks_mut(channels.max(1)).enumerate().for_each(|(i, mean)| {
            let place = self.place(i);
            let [a, b, c] = self.corners(i);
            let (sequence, points) = Stream::Resampling.stretch(0, self.slot_of_patch(i), 0, POINTS);
            for k in points {
                let [x, y, ..] = sequence.point(k);
                let [s, t] = uniform_triangle([x, y]);
                let point = [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * s + (c[axis] - a[axis]) * t);
                if let Some(j) = other.patch_at(place.face, place.side, point) {
                    mean.iter_mut()
                        .enumerate()
                        .for_each(|(c, sum)| *sum += field[(j, c)] / f64::from(POINTS));
                }
            }
        });
        DMatrix::from_row_slice(self.len(), channels, &means)
    }
}
