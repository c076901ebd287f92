//! Numbers: the random points of a pixel's samples.
//!
//! Pixels of a square share one scrambled sequence, each taking a stretch of it, in Morton order (Ahmed &
//! Wonka 2020): every pixel is stratified by itself, and so is every aligned block of 2 × 2, 4 × 4, … pixels.
//! Noise is then finer grained, and the eye averages most of it out.

use super::RenderOptions;
use crate::trace::sampling::{SEQUENCE_END, Sequence, Stream};

/// Where a pixel finds its random points.
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    seed: u64,
    /// The square's number.
    square: u64,
    /// Where the pixel's stretch starts.
    first: u32,
}

impl Numbers {
    pub fn of_pixel(options: &RenderOptions, x: usize, y: usize) -> Self {
        let &RenderOptions { width, samples, seed, .. } = options;
        // Take the largest square whose points one sequence has; one pixel, where not even that fits.
        let pixels = (SEQUENCE_END / samples).max(1);
        let side = 1 << (pixels.ilog2() / 2);
        let square = (y / side * width.div_ceil(side) + x / side) as u64;
        Self { seed, square, first: morton((x % side) as u32, (y % side) as u32) * samples }
    }

    /// The sequence of sample `k`, and the number of its point there.
    pub fn of_sample(&self, k: u32) -> (Sequence, u32) {
        let (batch, point) = self.place(k);
        (Stream::Pixels.sequence(self.seed, batch, self.square), point)
    }

    fn place(&self, k: u32) -> (u32, u32) {
        ((self.first + k) / SEQUENCE_END, (self.first + k) % SEQUENCE_END)
    }
}

/// The bits of x and y in turn.
fn morton(x: u32, y: u32) -> u32 {
    let spread = |v: u32| (0..16).map(|bit| (v >> bit & 1) << (2 * bit)).sum::<u32>();
    spread(x) | spread(y) << 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_samples_of_a_picture_share_a_point() {
        for samples in [1, 3, 64, 1000, 1 << 16, (1 << 16) + 5] {
            let options = RenderOptions { width: 11, height: 7, samples, ..Default::default() };
            let mut points = Vec::new();
            for (x, y) in (0..7).flat_map(|y| (0..11).map(move |x| (x, y))) {
                let numbers = Numbers::of_pixel(&options, x, y);
                for k in [0, samples / 2, samples - 1] {
                    points.push((numbers.square, numbers.place(k), k));
                }
            }
            points.sort_unstable();
            points.dedup();
            let all = points.len();
            points.dedup_by_key(|&mut (square, place, _)| (square, place));
            assert_eq!(points.len(), all, "{samples}");
        }
    }

    #[test]
    fn blocks_of_pixels_are_stratified_together() {
        let options = RenderOptions { width: 40, height: 40, samples: 4, ..Default::default() };
        for (left, top) in [(0, 0), (6, 2), (38, 38)] {
            // Four pixels of four samples each: one in each sixteenth of the square.
            let pixels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| (left + x, top + y));
            let point = |(x, y), k| {
                let (sequence, place) = Numbers::of_pixel(&options, x, y).of_sample(k);
                sequence.dimensions(place, 1)
            };
            let points = pixels.map(|pixel| [0, 1, 2, 3].map(|k| point(pixel, k)));
            let mut cells: Vec<_> =
                points.iter().flatten().map(|p| [p[0], p[1]].map(|x| (4.0 * x) as u32)).collect();
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), 16, "{left} {top}");
        }
    }
}
