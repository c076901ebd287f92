//! Subdivision: how a face is cut into patches, and which patch a point of it lies in.
//!
//! A face is cut by lines parallel to its shortest edge into *rows*, and each row into triangles, so that a
//! well-shaped face falls into similar triangles and a sliver is cut along its long side only. A flat, obtuse
//! sliver is first cut in two at its altitude. A face that others touch comes in parts, and each part is cut
//! like a face. The arithmetic here is all there is: [`Cuts::cell_at`] finds the cell of a point in constant
//! time, [`Cuts::corners`] the corners of a cell.

use glam::{DMat2, DVec2};

use super::grid::{Grid, divide};
use super::locator::Locator;
use super::part::Part;

/// Barycentric weights of a face's second and third corner.
pub type Barycentrics = [f64; 2];

/// How every face of a scene is cut.
#[derive(Clone, Debug)]
pub(crate) struct Cuts {
    grids: Vec<Grid>,
    pieces: Vec<Piece>,
    /// Per face, and one more: its first piece.
    first_piece: Vec<u32>,
    /// For the faces of more than two pieces, in order of faces.
    locators: Vec<(u32, Locator)>,
}

/// A face, a part or the half of one, with its grid.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// The corner opposite the shortest edge, then that edge's ends, as points of the face.
    corners: [DVec2; 3],
    /// From points of the face to weights of the piece's second and third corner.
    inverse: DMat2,
    grid: u32,
    /// Number of the face's cells before this piece's.
    first_cell: u32,
}

impl Piece {
    /// A point's weights of the second and third corner.
    #[inline]
    fn weights(&self, point: DVec2) -> DVec2 {
        self.inverse * (point - self.corners[0])
    }

    /// A point's least weight: how deep inside it lies, negative outside.
    #[inline]
    fn depth(&self, point: DVec2) -> f64 {
        let weights = self.weights(point);
        weights.min_element().min(1.0 - weights.x - weights.y)
    }
}

impl Cuts {
    /// Cuts faces whose parts `visit` tells, each with how long legs of its patches may be.
    pub fn new(faces: usize, visit: impl Fn(usize, &mut dyn FnMut(&Part, f64))) -> Self {
        let mut cuts =
            Self { grids: Vec::new(), pieces: Vec::new(), first_piece: vec![0], locators: Vec::new() };
        let mut known = std::collections::HashMap::new();
        for face in 0..faces {
            let mut first_cell = 0;
            visit(face, &mut |part, legs| {
                let [p, q, r] = part.on_face;
                for (corners, rows, columns) in divide(&part.corners, legs) {
                    let grid = *known.entry((rows, columns)).or_insert_with(|| {
                        cuts.grids.push(Grid::new(rows, columns));
                        cuts.grids.len() - 1
                    });
                    let corners = corners.map(|w| p + (q - p) * w.x + (r - p) * w.y);
                    let [a, b, c] = corners;
                    let inverse = DMat2::from_cols(b - a, c - a).inverse();
                    cuts.pieces.push(Piece { corners, inverse, grid: grid as u32, first_cell });
                    first_cell += cuts.grids[grid].cells();
                }
            });
            cuts.first_piece.push(cuts.pieces.len() as u32);
            let pieces = cuts.pieces(face);
            if pieces.len() > 2 {
                let locator = Locator::new(pieces.iter().map(|piece| piece.corners));
                cuts.locators.push((face as u32, locator));
            }
        }
        cuts
    }

    /// The triangles of a face that have a grid each.
    pub fn pieces(&self, face: usize) -> &[Piece] {
        &self.pieces[self.first_piece[face] as usize..self.first_piece[face + 1] as usize]
    }

    /// Number of cells of a face.
    pub fn cells(&self, face: usize) -> u32 {
        self.pieces(face).last().map_or(0, |p| p.first_cell + self.grids[p.grid as usize].cells())
    }

    /// The cell of a face in which a point lies.
    #[inline]
    pub fn cell_at(&self, face: usize, point: Barycentrics) -> u32 {
        let pieces = self.pieces(face);
        let point = DVec2::from(point);
        let piece = match pieces {
            [piece] => piece,
            // Of two pieces take the one in which the point lies deeper.
            [first, second] if second.depth(point) > first.depth(point) => second,
            [first, _] => first,
            _ => self.piece_at(face, point),
        };
        self.cell_in(piece, point)
    }

    /// The piece in which a point of a face of many lies.
    #[inline(never)]
    fn piece_at(&self, face: usize, point: DVec2) -> &Piece {
        let pieces = self.pieces(face);
        let mut deepest = (0, f64::NEG_INFINITY);
        for &piece in self.pieces_near(face, point) {
            let depth = pieces[piece as usize].depth(point);
            if depth >= deepest.1 {
                deepest = (piece as usize, depth);
            }
        }
        &pieces[deepest.0]
    }

    /// The pieces of a face of many in which a point may lie.
    fn pieces_near(&self, face: usize, point: DVec2) -> &[u32] {
        let place = self.locators.partition_point(|&(known, _)| (known as usize) < face);
        self.locators[place].1.near(point)
    }

    /// The cell of a piece in which a point lies, or to which it is next.
    #[inline]
    fn cell_in(&self, piece: &Piece, point: DVec2) -> u32 {
        let weights = piece.weights(point).max(DVec2::ZERO);
        let h = (weights.x + weights.y).min(1.0);
        piece.first_cell + self.grids[piece.grid as usize].cell_at(h, weights.y.min(h))
    }

    /// A cell of each piece of a face that has a point inside or on its rim.
    pub fn cells_meeting(&self, face: usize, point: Barycentrics) -> Vec<u32> {
        /// How far outside a point may lie for rounding, as a weight.
        const RIM: f64 = 1e-9;
        let pieces = self.pieces(face);
        let point = DVec2::from(point);
        let cell = |piece: &Piece| (piece.depth(point) >= -RIM).then(|| self.cell_in(piece, point));
        match pieces.len() {
            ..=2 => pieces.iter().filter_map(cell).collect(),
            _ => self.pieces_near(face, point).iter().filter_map(|&k| cell(&pieces[k as usize])).collect(),
        }
    }

    /// The corners of a cell, as points of its face, counter-clockwise seen from the front.
    pub fn corners(&self, face: usize, cell: u32) -> [Barycentrics; 3] {
        let pieces = self.pieces(face);
        let piece = &pieces[pieces.partition_point(|p| p.first_cell <= cell) - 1];
        let [a, b, c] = piece.corners;
        let corners = self.grids[piece.grid as usize].corners(cell - piece.first_cell);
        corners.map(|(h, w)| (a + (b - a) * (h - w) + (c - a) * w).to_array())
    }

    /// Where in a cell a point of its face lies: weights of the cell's second and third corner. A point
    /// beside the cell is moved to its rim.
    pub fn weights_in(&self, face: usize, cell: u32, point: Barycentrics) -> Barycentrics {
        let [a, b, c] = self.corners(face, cell).map(DVec2::from);
        let weights = DMat2::from_cols(b - a, c - a).inverse() * (DVec2::from(point) - a);
        if !weights.is_finite() {
            return [1.0 / 3.0; 2];
        }
        let weights = weights.max(DVec2::ZERO);
        (weights / (weights.x + weights.y).max(1.0)).to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::cells_for;
    use glam::DVec3;

    use super::*;
    use crate::scene::triangle;
    use crate::trace::sampling::{Stream, uniform_triangle};

    fn shapes() -> Vec<[DVec3; 3]> {
        [
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.4, 0.9, 0.3]],
            [[0.0, 0.0, 0.0], [1e-4, 0.0, 0.0], [0.0, 3.0, 0.0]],
            [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.9, 0.01, 0.0]],
            [[0.0, 0.0, 0.0], [1.9, 0.2, 0.0], [1.0, 0.7, 0.0]],
        ]
        .map(|corners| corners.map(DVec3::from))
        .to_vec()
    }

    fn whole(corners: &[DVec3; 3], edge: f64) -> Cuts {
        Cuts::new(1, |_, each| each(&Part::whole(corners), edge))
    }

    #[test]
    fn cells_tile_the_face_without_gap_or_overlap() {
        for corners in shapes() {
            for edge in [10.0, 1.0, 0.31, 0.1] {
                let cuts = whole(&corners, edge);
                assert_eq!(cuts.cells(0) as u64, cells_for(&corners, edge));
                let cell_area =
                    |cell| triangle::area(&cuts.corners(0, cell).map(|at| triangle::point(&corners, at)));
                let total: f64 = (0..cuts.cells(0)).map(cell_area).sum();
                assert!((total / triangle::area(&corners) - 1.0).abs() < 1e-9, "{corners:?} {edge}: {total}");
                // Area alone could hide an overlap: every cell's points must be found in that cell.
                for cell in 0..cuts.cells(0) {
                    let [a, b, c] = cuts.corners(0, cell).map(DVec2::from);
                    for k in 0..8 {
                        let [x, y, ..] = Stream::Callers.sequence(1, cell, 0).point(k);
                        let [u, v] = uniform_triangle([x, y]);
                        let point = a + (b - a) * u + (c - a) * v;
                        assert_eq!(cuts.cell_at(0, point.to_array()), cell, "{corners:?} {edge}");
                        let [found_u, found_v] = cuts.weights_in(0, cell, point.to_array());
                        assert!((found_u - u).abs().max((found_v - v).abs()) < 1e-6, "{corners:?} {edge}");
                    }
                }
            }
        }
    }

    #[test]
    fn cells_keep_the_orientation_of_their_face() {
        for corners in shapes() {
            let across = triangle::across(&corners);
            let cuts = whole(&corners, 0.2);
            for cell in 0..cuts.cells(0) {
                let cell = cuts.corners(0, cell).map(|at| triangle::point(&corners, at));
                assert!(triangle::across(&cell).dot(across) > 0.0);
            }
        }
    }

    #[test]
    fn slivers_are_cut_along_their_long_side_only() {
        let [_, _, needle, cap, _] = shapes()[..] else { unreachable!() };
        for sliver in [needle, cap] {
            let cells = cells_for(&sliver, 0.1);
            assert!((20..=80).contains(&cells), "{cells}");
        }
    }
}
