//! Locator: which of many triangles of a face a point may lie in.
//!
//! A square grid over the barycentrics of the face, about as many bins as triangles; each bin knows the
//! triangles whose boxes reach into it.

use glam::DVec2;

/// By how much boxes are widened, so that no rounding can lose a triangle.
const PAD: f64 = 1e-9;

/// Triangles of a face, by bins.
#[derive(Clone, Debug)]
pub(crate) struct Locator {
    /// Bins along each axis.
    bins: usize,
    /// Per bin, and one more: its first place in `triangles`.
    first: Vec<u32>,
    triangles: Vec<u32>,
}

impl Locator {
    /// Over triangles that fill a face, their corners as points of the face.
    pub fn new(triangles: impl ExactSizeIterator<Item = [DVec2; 3]>) -> Self {
        // Half of the square lies outside the face.
        let bins = (2.0 * triangles.len() as f64).sqrt().ceil() as usize;
        let bin = |at: f64| ((at * bins as f64) as usize).min(bins - 1);
        let mut members = vec![Vec::new(); bins * bins];
        for (k, [a, b, c]) in triangles.enumerate() {
            let (low, high) = (a.min(b).min(c) - PAD, a.max(b).max(c) + PAD);
            for row in bin(low.y)..=bin(high.y) {
                (bin(low.x)..=bin(high.x)).for_each(|column| members[row * bins + column].push(k as u32));
            }
        }
        let mut locator = Self { bins, first: vec![0], triangles: Vec::new() };
        for members in members {
            locator.triangles.extend(members);
            locator.first.push(locator.triangles.len() as u32);
        }
        locator
    }

    /// The triangles in which a point of the face may lie, ascending.
    #[inline]
    pub fn near(&self, point: DVec2) -> &[u32] {
        let bin = |at: f64| ((at * self.bins as f64) as usize).min(self.bins - 1);
        let bin = bin(point.y) * self.bins + bin(point.x);
        &self.triangles[self.first[bin] as usize..self.first[bin + 1] as usize]
    }
}
