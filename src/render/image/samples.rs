//! Samples: what the rays of a pixel saw, and which pixels need more of them.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::render::picture::LampPart;

/// Samples of every pixel, and of those that need more.
pub(super) const FEW: u32 = 4;
pub(super) const MANY: u32 = 16;

/// Relative differences that call for more samples: among a pixel's samples, and to its neighbours.
const WITHIN: f64 = 0.04;
const BETWEEN: f64 = 0.12;

/// What one ray saw.
#[derive(Clone, Copy, Default)]
pub(super) struct Seen {
    pub radiance: DVec3,
    pub is_lamp: bool,
    /// The factor by which an outline dims it.
    pub outline: f64,
}

/// What the rays of one pixel saw.
#[derive(Clone, Copy)]
pub(super) struct Samples {
    count: u32,
    /// Sum over all samples.
    sum: DVec3,
    /// Sum over, and number of, those that met a lamp.
    lamp_sum: DVec3,
    lamps: u32,
    /// Sum, smallest and largest, channel by channel, as if there were no outlines: those need no more
    /// samples.
    plain: DVec3,
    low: DVec3,
    high: DVec3,
}

impl Default for Samples {
    fn default() -> Self {
        Self {
            count: 0,
            sum: DVec3::ZERO,
            lamp_sum: DVec3::ZERO,
            lamps: 0,
            plain: DVec3::ZERO,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        }
    }
}

impl Samples {
    pub fn add(&mut self, seen: Seen) {
        let radiance = seen.radiance * seen.outline;
        self.count += 1;
        self.sum += radiance;
        if seen.is_lamp {
            self.lamp_sum += radiance;
            self.lamps += 1;
        }
        self.plain += seen.radiance;
        self.low = self.low.min(seen.radiance);
        self.high = self.high.max(seen.radiance);
    }

    pub fn mean(&self) -> ([f32; 3], LampPart) {
        let count = self.count as f64;
        let part = LampPart {
            radiance: (self.lamp_sum / count).as_vec3().to_array(),
            share: self.lamps as f32 / self.count as f32,
        };
        ((self.sum / count).as_vec3().to_array(), part)
    }
}

/// The pixels that need more samples.
pub(super) fn rough_pixels(pixels: &[Samples], width: usize) -> Vec<bool> {
    let means: Vec<DVec3> = pixels.iter().map(|p| p.plain / p.count as f64).collect();
    let is_rough = |k: usize| {
        let (x, below) = (k % width, k + width);
        let beside = [(x > 0).then(|| k - 1), (x + 1 < width).then_some(k + 1)];
        let above_below = [k.checked_sub(width), (below < pixels.len()).then_some(below)];
        let mut neighbours = beside.into_iter().chain(above_below).flatten();
        differ(pixels[k].low, pixels[k].high, WITHIN)
            || neighbours.any(|n| differ(means[k], means[n], BETWEEN))
    };
    (0..pixels.len()).into_par_iter().with_min_len(4096).map(is_rough).collect()
}

/// Whether two radiances differ by more than this share of the brighter one's brightest channel.
fn differ(a: DVec3, b: DVec3, share: f64) -> bool {
    (a - b).abs().max_element() > share * a.abs().max(b.abs()).max_element()
}

/// Point k < 16 of a (0,2)-sequence in the unit square (Kollig & Keller 2002), moved to the middle of its
/// cell.
pub(super) fn stratified(k: u32) -> DVec2 {
    let mut second = 0u32;
    let mut direction = 1u32 << 31;
    let mut bits = k;
    while bits != 0 {
        if bits & 1 == 1 {
            second ^= direction;
        }
        direction ^= direction >> 1;
        bits >>= 1;
    }
    let unit = |x: u32| x as f64 / 2f64.powi(32) + 1.0 / 32.0;
    DVec2::new(unit(k.reverse_bits()), unit(second))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fall_one_into_each_cell() {
        let cell = |n: f64, k: u32| (stratified(k) * n).floor().to_array().map(|x| x as i32);
        for (n, count) in [(2.0, FEW), (4.0, MANY)] {
            let mut cells: Vec<_> = (0..count).map(|k| cell(n, k)).collect();
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), count as usize);
        }
    }
}
