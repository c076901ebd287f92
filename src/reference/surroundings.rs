//! Surroundings: directions into a picture around the scene; the path tracer's own way of drawing them.
//!
//! Half of them by the cosine, half by a list of all texels, each weighted by the brightest of it and its
//! neighbours; the two are one density, their mean (Veach & Guibas 1995: the balance heuristic).

use std::f64::consts::TAU;

use glam::DVec3;

use crate::scene::Environment;
use crate::trace::sampling::{Discrete, cosine_hemisphere, cosine_hemisphere_pdf, frame_around};

/// A picture around the scene, ready to be drawn from.
#[derive(Debug)]
pub(super) struct Surroundings {
    /// All texels in file order.
    texels: Discrete,
}

impl Surroundings {
    pub fn new(environment: &Environment) -> Self {
        let pixels = environment.pixels();
        let [width, height] = pixels.size();
        let strength =
            |i: usize, j: usize| pixels.texels()[j * width + i].iter().map(|&x| f64::from(x)).sum::<f64>();
        let weight = |texel: usize| {
            let (i, j) = (texel % width, texel / width);
            let [high, low] = environment.row(j);
            let rows = j.saturating_sub(1)..(j + 2).min(height);
            let around = rows.flat_map(|j| [i + width - 1, i, i + 1].map(|i| strength(i % width, j)));
            around.fold(0.0, f64::max) * (high - low)
        };
        Self { texels: Discrete::new((0..width * height).map(weight)) }
    }

    /// A direction over a surface, and the inverse of its density per unit of solid angle; 0 below the
    /// horizon.
    #[inline]
    pub fn sample(&self, environment: &Environment, normal: DVec3, [s, t]: [f64; 2]) -> (DVec3, f64) {
        let towards = if s < 0.5 {
            frame_around(normal) * cosine_hemisphere([2.0 * s, t])
        } else {
            self.by_texel(environment, [2.0 * s - 1.0, t])
        };
        let cosine = normal.dot(towards);
        if cosine <= 0.0 {
            return (towards, 0.0);
        }
        (towards, 2.0 / (cosine_hemisphere_pdf(cosine) + self.density(environment, towards)))
    }

    fn by_texel(&self, environment: &Environment, [s, t]: [f64; 2]) -> DVec3 {
        let width = environment.pixels().size()[0];
        let (k, along) = self.texels.draw(s);
        let [high, low] = environment.row(k / width);
        environment.direction(((k % width) as f64 + along) / width as f64, high + (low - high) * t)
    }

    fn density(&self, environment: &Environment, towards: DVec3) -> f64 {
        let [width, height] = environment.pixels().size();
        let place = environment.place(towards);
        let (i, j) = ((place.x as usize).min(width - 1), (place.y as usize).min(height - 1));
        let [high, low] = environment.row(j);
        let chance = self.texels.weight(j * width + i) / self.texels.total();
        chance / ((high - low) * TAU / width as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Pixels;
    use crate::trace::sampling::Stream;

    #[test]
    fn irradiance_under_a_bright_spot_on_an_even_ground_is_that_of_both() {
        let (width, height) = (64, 32);
        let at = |i: usize, j: usize| if (i, j) == (20, 6) { 5000.0 } else { 1.0 };
        let texels = (0..width * height).map(|k| [at(k % width, k / width) as f32; 3]).collect();
        let environment = Environment::new(Pixels::new(width, height, texels), DVec3::Y, 0.0);
        let surroundings = Surroundings::new(&environment);
        let n = 1 << 15;
        let one = |k: u32| {
            let [s, t, ..] = Stream::Callers.sequence(6, 2, 0).point(k);
            let (towards, worth) = surroundings.sample(&environment, DVec3::Y, [s, t]);
            environment.from(towards)[0] * towards.y * worth / f64::from(n)
        };
        let found: f64 = (0..n).map(one).sum();
        // The tent over the bright texel, whose solid angle is that of its rows, by the midpoint rule.
        let steps = 512;
        let exact = std::f64::consts::PI
            + (0..steps)
                .map(|k| {
                    let row = 5.5 + (f64::from(k) + 0.5) * 2.0 / f64::from(steps);
                    let angle = row / height as f64 * std::f64::consts::PI;
                    let tent = 1.0 - (row - 6.5).abs();
                    let step = 2.0 / f64::from(steps) * std::f64::consts::PI / height as f64;
                    4999.0 * tent * angle.cos() * angle.sin() * step * TAU / width as f64
                })
                .sum::<f64>();
        assert!((found / exact - 1.0).abs() < 2e-3, "{found} {exact}");
    }
}
