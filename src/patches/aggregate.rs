//! Aggregation: from patches up to faces.

use nalgebra::DMatrix;

use super::Patches;
use crate::scene::Side;

/// The average of a field over one side of a face.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceRow {
    /// The face's number.
    pub face: usize,
    /// Front or back.
    pub side: Side,
    /// The face's area, m².
    pub area: f64,
    /// The field's average per channel; parts that no light reaches count as zero.
    pub mean: Vec<f64>,
}

impl Patches<'_> {
    /// Averages a field (n × c) over faces, weighted by area: a row per face and side that has patches, in order of face
    /// and side.
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
                let area = self.face_area(face);
                let mean =
                    |c: usize| patches.clone().map(|i| self.areas[i] * field[(i, c)]).sum::<f64>() / area;
                let mean = (0..field.ncols()).map(mean).collect();
                FaceRow { face, side, area: area * self.frame.scale().powi(2), mean }
            })
            .collect()
    }
}
