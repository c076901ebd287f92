//! Pixels: a picture in linear light, read between its texels and averaged over triangles.
//!
//! Texel (i, j) lies at (i + ½, j + ½), rows from the top. In between the picture is bilinear, and so exactly
//! integrable: over a cell between four texels its mean is theirs, and where a triangle covers a part of a
//! cell that part is cut into triangles, over which, as the picture is quadratic along any line, the mean of
//! the middles of the edges is exact.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec2;

use crate::scene::photometry::luminance;

/// Triangles that cover more texels than this are averaged on a picture half as fine.
const MOST_TEXELS: f64 = 16384.0;

/// What lies beyond an edge of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// The picture again.
    Repeat,
    /// What is at the edge.
    Clamp,
}

impl Beyond {
    fn place(self, k: i64, count: usize) -> usize {
        match self {
            Self::Repeat => k.rem_euclid(count as i64) as usize,
            Self::Clamp => k.clamp(0, count as i64 - 1) as usize,
        }
    }
}

/// A picture of linear red, green and blue.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    width: usize,
    height: usize,
    /// Row by row, from the top.
    texels: Vec<[f32; 3]>,
    /// The largest value in each channel, and the mean.
    highest: [f64; 3],
    mean: [f64; 3],
    /// The same half as fine; none for a single texel.
    coarser: Option<Arc<Pixels>>,
}

impl Pixels {
    /// Takes `width` × `height` texels, row by row from the top.
    ///
    /// # Panics
    /// If there are not so many of them, or none.
    pub fn new(width: usize, height: usize, texels: Vec<[f32; 3]>) -> Self {
        assert!(width * height == texels.len() && !texels.is_empty(), "{width} x {height} texels");
        let sum = |c: usize| texels.iter().map(|texel| f64::from(texel[c])).sum::<f64>();
        let mean = [0, 1, 2].map(|c| sum(c) / texels.len() as f64);
        let most = |c: usize| texels.iter().map(|texel| f64::from(texel[c])).fold(0.0, f64::max);
        let highest = [0, 1, 2].map(most);
        let mut pixels = Self { width, height, texels, highest, mean, coarser: None };
        pixels.coarser = (pixels.texels.len() > 1).then(|| Arc::new(pixels.halved()));
        pixels
    }

    /// The same in tones of grey, each as bright as its colour.
    pub fn grey(&self) -> Self {
        let grey = |texel: &[f32; 3]| [luminance(&texel.map(f64::from)) as f32; 3];
        Self::new(self.width, self.height, self.texels.iter().map(grey).collect())
    }

    /// Texels across and down.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// All texels, row by row from the top.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// Whether red, green and blue agree everywhere.
    pub fn is_grey(&self) -> bool {
        self.texels.iter().all(|[r, g, b]| r == g && g == b)
    }

    /// The largest value in each channel.
    pub fn highest(&self) -> [f64; 3] {
        self.highest
    }

    /// The mean over all of it.
    pub fn mean(&self) -> [f64; 3] {
        self.mean
    }

    /// The picture at a place, in texels from the left and from the top; `beyond` is for what lies beside and
    /// what above and below it.
    #[inline]
    pub fn at(&self, place: DVec2, beyond: [Beyond; 2]) -> [f64; 3] {
        let place = place - 0.5;
        let cell = place.floor();
        self.in_cell(cell, self.corners(cell, beyond), place)
    }

    /// The mean over a triangle, corners in texels from the left and from the top. A triangle without area is
    /// the mean of its edges' middles.
    pub fn mean_over(&self, triangle: [DVec2; 3], beyond: [Beyond; 2]) -> [f64; 3] {
        let [a, b, c] = triangle;
        let area = 0.5 * (b - a).perp_dot(c - a);
        let longest = (b - a).abs().max((c - a).abs()).max_element();
        if let Some(coarser) = &self.coarser
            && (area.abs() > MOST_TEXELS || longest > MOST_TEXELS)
        {
            let shrunk = DVec2::new(coarser.width as f64, coarser.height as f64)
                / DVec2::new(self.width as f64, self.height as f64);
            return coarser.mean_over(triangle.map(|p| p * shrunk), beyond);
        }
        if let [texel] = self.texels[..] {
            return texel.map(f64::from);
        }
        if area.abs() < 1e-9 {
            let middles = [a + b, b + c, c + a].map(|sum| self.at(0.5 * sum, beyond));
            return [0, 1, 2].map(|k| (middles[0][k] + middles[1][k] + middles[2][k]) / 3.0);
        }
        // Cut the triangle into rows, and each of these into cells between four texels.
        let whole = Polygon::of(triangle.map(|p| p - 0.5));
        let mut sum = [0.0; 3];
        for row in whole.range(1) {
            let strip = whole.clipped(1, row);
            let inside = whole.cells_inside(row);
            let cells = self.sum_of_cells(row as i64, inside.clone(), beyond);
            sum.iter_mut().zip(cells).for_each(|(sum, cells)| *sum += cells * area.signum());
            for column in strip.range(0).filter(|&column| !inside.contains(&(column as i64))) {
                let cell = DVec2::new(column, row);
                let corners = self.corners(cell, beyond);
                let value = |place: DVec2| self.in_cell(cell, corners, place);
                let integral = strip.clipped(0, column).integral(value);
                sum.iter_mut().zip(integral).for_each(|(sum, part)| *sum += part);
            }
        }
        // Rounding must not carry a mean beyond what it is of.
        [0, 1, 2].map(|c| (sum[c] / area).clamp(0.0, self.highest[c]))
    }

    /// The integral over cells of a row.
    fn sum_of_cells(&self, row: i64, cells: Range<i64>, [beside, above]: [Beyond; 2]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        if cells.is_empty() {
            return sum;
        }
        let rows = [row, row + 1].map(|row| above.place(row, self.height) * self.width);
        let mut place = beside.place(cells.start, self.width);
        for column in cells.start..=cells.end {
            // Texels between two cells belong to both.
            let weight = if column == cells.start || column == cells.end { 0.25 } else { 0.5 };
            for texel in rows.map(|row| self.texels[row + place]) {
                sum.iter_mut().zip(texel).for_each(|(sum, value)| *sum += weight * f64::from(value));
            }
            place = match beside {
                Beyond::Repeat if place + 1 == self.width => 0,
                Beyond::Repeat => place + 1,
                Beyond::Clamp => beside.place(column + 1, self.width),
            };
        }
        sum
    }

    /// The four texels around a cell: upper left and right, lower left and right.
    #[inline]
    fn corners(&self, cell: DVec2, [beside, above]: [Beyond; 2]) -> [[f32; 3]; 4] {
        let (i, j) = (cell.x as i64, cell.y as i64);
        let columns = [beside.place(i, self.width), beside.place(i + 1, self.width)];
        let rows = [above.place(j, self.height), above.place(j + 1, self.height)];
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| self.texels[rows[y] * self.width + columns[x]])
    }

    #[inline]
    fn in_cell(&self, cell: DVec2, corners: [[f32; 3]; 4], place: DVec2) -> [f64; 3] {
        let DVec2 { x, y } = place - cell;
        let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
        [0, 1, 2].map(|c| (0..4).map(|k| weights[k] * f64::from(corners[k][c])).sum())
    }

    /// Half as many texels each way, each the mean of those it stands for.
    fn halved(&self) -> Self {
        let [width, height] = self.size().map(|count| count.div_ceil(2));
        let texel = |k: usize| {
            let place = |from: usize, all: usize| from..(from + 2).min(all);
            let (columns, rows) = (place(2 * (k % width), self.width), place(2 * (k / width), self.height));
            let count = (columns.len() * rows.len()) as f32;
            let under = rows.flat_map(|row| columns.clone().map(move |column| row * self.width + column));
            under.fold([0.0; 3], |sum, at| [0, 1, 2].map(|c| sum[c] + self.texels[at][c] / count))
        };
        Self::new(width, height, (0..width * height).map(texel).collect())
    }
}

/// A convex polygon: what is left of a triangle between two lines each way.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec2; 8],
    count: usize,
}

impl Polygon {
    fn of([a, b, c]: [DVec2; 3]) -> Self {
        let mut corners = [a; 8];
        (corners[1], corners[2]) = (b, c);
        Self { corners, count: 3 }
    }

    fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// The whole numbers at which unit intervals begin that it reaches into along an axis.
    fn range(&self, axis: usize) -> impl Iterator<Item = f64> + use<> {
        let along = || self.corners().iter().map(|p| p[axis]);
        let (low, high) = (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
        let first = low.floor();
        let count = if high > low { (high.ceil() - first).max(1.0) as usize } else { 0 };
        (0..count).map(move |k| first + k as f64)
    }

    /// The cells of a row that lie within it as a whole.
    fn cells_inside(&self, row: f64) -> Range<i64> {
        let [[low, high], [from, to]] = [row, row + 1.0].map(|height| self.chord(height));
        let (first, end) = (low.max(from).ceil(), high.min(to).floor());
        if first < end { first as i64..end as i64 } else { 0..0 }
    }

    /// Where the line at a height enters and leaves it; where it misses the first is the greater.
    fn chord(&self, height: f64) -> [f64; 2] {
        let corners = self.corners();
        let mut chord = [f64::INFINITY, f64::NEG_INFINITY];
        for (k, from) in corners.iter().enumerate() {
            let to = corners[(k + 1) % corners.len()];
            let [here, there] = [from.y - height, to.y - height];
            if here * there <= 0.0 && here != there {
                let x = from.x + (to.x - from.x) * (here / (here - there));
                chord = [chord[0].min(x), chord[1].max(x)];
            }
        }
        chord
    }

    /// The part between `from` and `from` + 1 along an axis.
    fn clipped(&self, axis: usize, from: f64) -> Self {
        self.beyond(axis, 1.0, from).beyond(axis, -1.0, -(from + 1.0))
    }

    /// The part where sign · p ≥ limit.
    fn beyond(&self, axis: usize, sign: f64, limit: f64) -> Self {
        let mut kept = Self { corners: [DVec2::ZERO; 8], count: 0 };
        let mut push = |p: DVec2| {
            if kept.count < kept.corners.len() {
                kept.corners[kept.count] = p;
                kept.count += 1;
            }
        };
        let corners = self.corners();
        for (k, &from) in corners.iter().enumerate() {
            let to = corners[(k + 1) % corners.len()];
            let (here, there) = (sign * from[axis] - limit, sign * to[axis] - limit);
            if here >= 0.0 {
                push(from);
            }
            if (here >= 0.0) != (there >= 0.0) {
                push(from + (to - from) * (here / (here - there)));
            }
        }
        kept
    }

    /// The integral of what is quadratic over it.
    fn integral(&self, value: impl Fn(DVec2) -> [f64; 3]) -> [f64; 3] {
        let corners = self.corners();
        let mut sum = [0.0; 3];
        for k in 2..corners.len() {
            let [a, b, c] = [corners[0], corners[k - 1], corners[k]];
            let share = (b - a).perp_dot(c - a) / 6.0;
            for middle in [a + b, b + c, c + a] {
                let at = value(0.5 * middle);
                sum.iter_mut().zip(at).for_each(|(sum, x)| *sum += share * x);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AROUND: [Beyond; 2] = [Beyond::Repeat; 2];

    fn noise(width: usize, height: usize) -> Pixels {
        let texel = |k: usize| [(k * 37 % 101) as f32, (k * 53 % 97) as f32, (k * 71 % 89) as f32];
        Pixels::new(width, height, (0..width * height).map(texel).collect())
    }

    #[test]
    fn texels_have_their_own_value_in_their_middle_and_the_mean_of_four_in_between() {
        let pixels = noise(5, 4);
        let texel = |i: usize, j: usize| f64::from(pixels.texels()[5 * j + i][0]);
        assert_eq!(pixels.at(DVec2::new(3.5, 2.5), AROUND)[0], texel(3, 2));
        let four = [texel(1, 1), texel(2, 1), texel(1, 2), texel(2, 2)];
        assert_eq!(pixels.at(DVec2::new(2.0, 2.0), AROUND)[0], 0.25 * four.iter().sum::<f64>());
        // Left of the first column is the last one, or the first again.
        assert_eq!(pixels.at(DVec2::new(-0.5, 0.5), AROUND)[0], texel(4, 0));
        assert_eq!(pixels.at(DVec2::new(-0.5, 9.0), [Beyond::Clamp; 2])[0], texel(0, 3));
    }

    #[test]
    fn means_over_triangles_are_exact() {
        let pixels = noise(7, 5);
        let corners = [DVec2::new(-3.3, 1.2), DVec2::new(9.1, 0.4), DVec2::new(4.6, 11.7)];
        // The same by cutting the triangle into many small ones: error falls as their number.
        let mean_by = |n: usize| {
            let [a, b, c] = corners;
            let at = |u: f64, v: f64| pixels.at(a + (b - a) * u + (c - a) * v, AROUND)[1];
            let h = 1.0 / n as f64;
            let mut sum = 0.0;
            for i in 0..n {
                for j in 0..n - i {
                    let (u, v) = (i as f64 * h, j as f64 * h);
                    sum += at(u + h / 3.0, v + h / 3.0);
                    if j + 1 < n - i {
                        sum += at(u + h / 1.5, v + h / 1.5);
                    }
                }
            }
            sum * h * h
        };
        let exact = pixels.mean_over(corners, AROUND)[1];
        let [coarse, fine] = [mean_by(100), mean_by(1600)].map(|mean| (mean / exact - 1.0).abs());
        assert!(fine < 1e-6 && fine < 0.1 * coarse, "{coarse} {fine}");
        // Turned the other way round it is the same triangle.
        let [a, b, c] = corners;
        assert!((pixels.mean_over([a, c, b], AROUND)[1] / exact - 1.0).abs() < 1e-12);
    }

    #[test]
    fn two_triangles_over_a_whole_repeating_picture_have_its_mean() {
        for (width, height) in [(6, 9), (1, 1), (300, 200)] {
            let pixels = noise(width, height);
            let [x, y] = [DVec2::X * width as f64, DVec2::Y * height as f64];
            let from = DVec2::new(-0.7, 0.9);
            let halves = [[from, from + x, from + x + y], [from, from + x + y, from + y]];
            let [first, second] = halves.map(|half| pixels.mean_over(half, AROUND));
            for c in 0..3 {
                let mean = 0.5 * (first[c] + second[c]);
                assert!(
                    (mean - pixels.mean()[c]).abs() < 1e-6 * (1.0 + pixels.mean()[c]),
                    "{width} {height}"
                );
            }
        }
    }

    #[test]
    fn triangles_over_many_copies_have_the_mean_of_all() {
        let pixels = noise(50, 40);
        let corners = [DVec2::ZERO, DVec2::new(5e4, 0.0), DVec2::new(1e4, 4e4)];
        let mean = pixels.mean_over(corners, AROUND);
        assert!(
            (0..3).all(|c| (mean[c] / pixels.mean()[c] - 1.0).abs() < 1e-2),
            "{mean:?} {:?}",
            pixels.mean()
        );
    }

    #[test]
    fn footprints_without_area_have_a_mean_too() {
        let pixels = noise(4, 4);
        let point = DVec2::new(2.5, 1.5);
        assert_eq!(pixels.mean_over([point; 3], AROUND), pixels.at(point, AROUND));
    }
}
