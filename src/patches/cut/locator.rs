//! Locator: which of many triangles of a face a point may lie in.
//!
//! A square grid over the barycentrics of the face, about as many bins as triangles; each bin knows the
//! triangles that reach into it, or has a grid of its own where they are many: parts of the ground
//! around a house differ in size by more than a thousand.

use glam::DVec2;

/// By how much triangles are widened, so that no rounding can lose one, as a share of a bin.
const PAD: f64 = 1e-6;

/// A bin of more triangles has a grid of its own; a number. Chosen: about what is looked through in the time
/// that a grid takes.
const CROWDED: usize = 16;

/// Triangles of a face, by bins.
#[derive(Clone, Debug)]
pub(crate) struct Locator {
    /// Where the square begins, and how many bins there are to a unit of length.
    corner: DVec2,
    per_unit: f64,
    /// Bins along each axis.
    bins: usize,
    contents: Vec<Bin>,
}

/// What reaches into a bin.
#[derive(Clone, Debug)]
enum Bin {
    /// Few triangles, ascending.
    Few(Box<[u32]>),
    /// Many.
    Many(Box<Locator>),
}

impl Locator {
    /// Over triangles that fill a face, their corners as points of the face.
    pub fn new(triangles: impl Iterator<Item = [DVec2; 3]>) -> Self {
        let triangles: Vec<[DVec2; 3]> = triangles.collect();
        // Half of the square lies outside the face.
        let bins = (2.0 * triangles.len() as f64).sqrt().ceil() as usize;
        let all: Vec<u32> = (0..triangles.len() as u32).collect();
        Self::over((DVec2::ZERO, 1.0), bins, (&triangles, &all))
    }

    /// Over a square of so much a side, for some of the triangles.
    fn over(
        (corner, side): (DVec2, f64),
        bins: usize,
        (triangles, members): (&[[DVec2; 3]], &[u32]),
    ) -> Self {
        let per_unit = bins as f64 / side;
        let place = |at: f64| (at.max(0.0) as usize).min(bins - 1);
        let mut contents = vec![Vec::new(); bins * bins];
        for &k in members {
            let at = triangles[k as usize].map(|end| (end - corner) * per_unit);
            let (low, high) = (at[0].min(at[1]).min(at[2]) - PAD, at[0].max(at[1]).max(at[2]) + PAD);
            for row in place(low.y)..=place(high.y) {
                let meets = |&column: &usize| meets_bin(&at, DVec2::new(column as f64, row as f64));
                let columns = (place(low.x)..=place(high.x)).filter(meets);
                columns.for_each(|column| contents[row * bins + column].push(k));
            }
        }
        let content = |(bin, within): (usize, Vec<u32>)| {
            // Where triangles meet in a point no grid parts them.
            if within.len() <= CROWDED || 2 * within.len() > members.len() {
                return Bin::Few(within.into());
            }
            let at = DVec2::new((bin % bins) as f64, (bin / bins) as f64);
            let square = (corner + at / per_unit, 1.0 / per_unit);
            let finer = ((within.len() as f64).sqrt().ceil() as usize).max(4);
            Bin::Many(Box::new(Self::over(square, finer, (triangles, &within))))
        };
        let contents = contents.into_iter().enumerate().map(content).collect();
        Self { corner, per_unit, bins, contents }
    }

    /// The triangles in which a point of the face may lie, ascending.
    #[inline]
    pub fn near(&self, point: DVec2) -> &[u32] {
        let at = (point - self.corner) * self.per_unit;
        let bin = |at: f64| (at as usize).min(self.bins - 1);
        match &self.contents[bin(at.y) * self.bins + bin(at.x)] {
            Bin::Few(triangles) => triangles,
            Bin::Many(finer) => finer.near(point),
        }
    }
}

/// Whether a triangle reaches into the bin whose corner this is, or touches it: not where all of the bin lies
/// beyond one of its sides.
fn meets_bin(at: &[DVec2; 3], corner: DVec2) -> bool {
    let turn = (at[1] - at[0]).perp_dot(at[2] - at[0]).signum();
    (0..3).all(|k| {
        let inward = turn * (at[(k + 1) % 3] - at[k]).perp();
        let farthest = corner + DVec2::select(inward.cmpgt(DVec2::ZERO), DVec2::ONE, DVec2::ZERO);
        inward.dot(farthest - at[k]) >= -PAD * inward.length()
    })
}
