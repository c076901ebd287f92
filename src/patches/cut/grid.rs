//! Grid: a triangle cut into rows of smaller ones, and how a face falls into triangles that are cut so.

use glam::{DVec2, DVec3};

/// A triangle cut into rows; row i lies between lines i and i + 1 counted from the apex.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid {
    rows: u32,
    /// Into how many segments each line is divided, from the apex to the base, see `segments_of`, and how
    /// long these are; 0 at the apex.
    lines: Vec<(u32, f64)>,
    /// Per row, and one more: its first cell.
    first_cell: Vec<u32>,
}

impl Grid {
    pub fn new(rows: u32, columns: u32) -> Self {
        let line = |line: u32| match segments_of(line, rows, columns) {
            0 => (0, 0.0),
            segments => (segments, f64::from(line) / f64::from(rows) / f64::from(segments)),
        };
        let lines: Vec<(u32, f64)> = (0..=rows).map(line).collect();
        let mut first_cell = vec![0];
        for (row, ends) in lines.windows(2).enumerate() {
            first_cell.push(first_cell[row] + ends[0].0 + ends[1].0);
        }
        Self { rows, lines, first_cell }
    }

    pub fn cells(&self) -> u32 {
        self.first_cell[self.rows as usize]
    }

    /// The cell at height `h` below the apex (0 to 1) and distance `w` from the first side (0 to h).
    pub fn cell_at(&self, h: f64, w: f64) -> u32 {
        let rows = self.rows as f64;
        let row = ((h * rows) as u32).min(self.rows - 1);
        let [(inner, inner_step), (outer, outer_step)] = [0, 1].map(|k| self.lines[row as usize + k]);
        let f = h * rows - row as f64;
        // Lines from inner to outer vertex j stand `step` apart at this height; a diagonal leads on from each
        // inner vertex j to outer vertex j + 1.
        let step = inner_step + f * (outer_step - inner_step);
        let j = if step > 0.0 { ((w / step) as u32).min(outer - 1) } else { 0 };
        let past_diagonal = w > j as f64 * step + f * outer_step;
        self.first_cell[row as usize] + 2 * j + u32::from(past_diagonal && j < inner)
    }

    /// The corners of a cell as (h, w), counter-clockwise as the whole is.
    pub fn corners(&self, cell: u32) -> [(f64, f64); 3] {
        let row = self.first_cell.partition_point(|&first| first <= cell) as u32 - 1;
        let (j, second) =
            ((cell - self.first_cell[row as usize]) / 2, (cell - self.first_cell[row as usize]) % 2);
        let vertex = |line: u32, k: u32| {
            let h = line as f64 / self.rows as f64;
            (h, h * k as f64 / self.lines[line as usize].0.max(1) as f64)
        };
        match second {
            0 => [vertex(row, j), vertex(row + 1, j), vertex(row + 1, j + 1)],
            _ => [vertex(row, j), vertex(row + 1, j + 1), vertex(row, j + 1)],
        }
    }
}

/// Into how many segments line `line` of a triangle in so many rows is divided: none at the apex, `columns`
/// at the base.
fn segments_of(line: u32, rows: u32, columns: u32) -> u32 {
    let even = (2 * line as u64 * columns as u64 + rows as u64) / (2 * rows as u64);
    if line == 0 { 0 } else { (even as u32).max(1) }
}

/// Segments no longer than `edge` that a length is divided into.
fn segments(length: f64, edge: f64) -> u32 {
    (length / edge - 1e-9).ceil().clamp(1.0, 65536.0) as u32
}

/// The pieces of a face with these corners for patches of legs up to `edge`: corners, rows, columns.
pub(crate) fn divide(corners: &[DVec3; 3], edge: f64) -> impl Iterator<Item = ([DVec2; 3], u32, u32)> {
    let weights = [DVec2::ZERO, DVec2::X, DVec2::Y];
    let length = |k: usize| corners[(k + 1) % 3].distance(corners[(k + 2) % 3]);
    let lengths = [length(0), length(1), length(2)];
    let most = lengths[0].max(lengths[1]).max(lengths[2]);
    let longest = lengths.iter().position(|&l| l >= most * (1.0 - 1e-9)).unwrap_or(0);
    let (a, b) = ((longest + 1) % 3, (longest + 2) % 3);
    let base = corners[b] - corners[a];
    // Where the altitude on the longest edge meets it, and how high it is.
    let foot = (corners[longest] - corners[a]).dot(base) / base.length_squared();
    let height = corners[longest].distance(corners[a] + base * foot);
    let shorter = lengths[a].min(lengths[b]);
    let pieces: [Option<[usize; 3]>; 2] = if height < 0.5 * shorter && height < edge && shorter > edge {
        [Some([longest, a, 3]), Some([longest, 3, b])]
    } else {
        [Some([0, 1, 2]), None]
    };
    let at = [corners[0], corners[1], corners[2], corners[a] + base * foot];
    let on_face = [weights[0], weights[1], weights[2], weights[a].lerp(weights[b], foot)];
    pieces.into_iter().flatten().map(move |piece| {
        let side = |k: usize| at[piece[(k + 1) % 3]].distance(at[piece[(k + 2) % 3]]);
        let sides = [side(0), side(1), side(2)];
        let shortest = sides[0].min(sides[1]).min(sides[2]);
        // Of equal sides take the first, and let no rounding decide.
        let apex = sides.iter().position(|&s| s <= shortest * (1.0 + 1e-9)).unwrap_or(0);
        let middle = sides[(apex + 1) % 3].min(sides[(apex + 2) % 3]);
        let turned = [0, 1, 2].map(|k| on_face[piece[(apex + k) % 3]]);
        (turned, segments(middle, edge), segments(shortest, edge))
    })
}

/// Into how many cells a face is cut for patches of legs up to `edge`.
pub(crate) fn cells_for(corners: &[DVec3; 3], edge: f64) -> u64 {
    // In closed form up to rounding of the rows: a row of i/rows·columns segments inside and outside.
    divide(corners, edge).map(|(_, rows, columns)| Grid::count(rows, columns)).sum()
}

impl Grid {
    /// The number of cells of a grid, without making it.
    fn count(rows: u32, columns: u32) -> u64 {
        if rows == columns {
            return rows as u64 * rows as u64;
        }
        let segments = |line: u32| u64::from(segments_of(line, rows, columns));
        (0..rows).map(|row| segments(row) + segments(row + 1)).sum()
    }
}
