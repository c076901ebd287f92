//! Environment sampler: directions in which a picture around the scene is bright, beside their density.
//!
//! A row of texels is drawn by its luminance times its solid angle, then a texel of the row, then a direction
//! evenly within the texel. A texel's luminance is the mean over it of what is interpolated between it and
//! its neighbours, so that no direction that shines is left out.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::scene::{Environment, luminance};
use crate::trace::sampling::{Discrete, DiscreteTable};

/// Draws directions by a picture's brightness.
#[derive(Clone, Debug)]
pub(crate) struct EnvironmentSampler {
    width: usize,
    /// Chances of texels.
    texels: DiscreteTable,
    /// Per row, the cosines with up of its edges.
    edges: Vec<[f64; 2]>,
}

impl EnvironmentSampler {
    pub fn new(environment: &Environment) -> Self {
        let pixels = environment.pixels();
        let [width, height] = pixels.size();
        let bright: Vec<f64> = pixels.texels().iter().map(|t| luminance(&t.map(f64::from))).collect();
        let mean = |i: usize, j: usize| {
            // The interpolated picture's mean over a texel: 1, 6, 1 eighths of it and its neighbours, each
            // way.
            let beside = [(i + width - 1) % width, i, (i + 1) % width];
            let above = [j.saturating_sub(1), j, (j + 1).min(height - 1)];
            let row = |j: usize| {
                bright[j * width + beside[0]] + 6.0 * bright[j * width + i] + bright[j * width + beside[2]]
            };
            (row(above[0]) + 6.0 * row(j) + row(above[2])) / 64.0
        };
        let edges: Vec<[f64; 2]> = (0..height).map(|row| environment.row(row)).collect();
        let columns: Vec<Discrete> =
            (0..height).map(|j| Discrete::new((0..width).map(|i| mean(i, j)))).collect();
        let texels = DiscreteTable::new(columns, |row| edges[row][0] - edges[row][1]);
        Self { width, texels, edges }
    }

    /// A direction with density [`EnvironmentSampler::pdf`].
    #[inline]
    pub fn sample(&self, environment: &Environment, square: [f64; 2]) -> DVec3 {
        let ([row, column], [u, v]) = self.texels.draw(square);
        let [high, low] = self.edges[row];
        environment.direction((column as f64 + u) / self.width as f64, high + (low - high) * v)
    }

    /// Density of [`EnvironmentSampler::sample`], per unit of solid angle.
    #[inline]
    pub fn pdf(&self, environment: &Environment, direction: DVec3) -> f64 {
        let place = environment.place(direction);
        let row = (place.y as usize).min(self.edges.len() - 1);
        let column = (place.x as usize).min(self.width - 1);
        let [high, low] = self.edges[row];
        let solid_angle = (high - low) * TAU / self.width as f64;
        self.texels.weight([row, column]) / solid_angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Pixels;
    use crate::trace::sampling::Stream;

    /// Pictures with a smooth side, a dark side and one very bright texel.
    fn environment() -> Environment {
        let (width, height) = (32, 16);
        let texel = |k: usize| {
            let (i, j) = (k % width, k / width);
            let base = if i < 20 { 0.2 + 0.05 * (i + j) as f32 } else { 0.0 };
            let sun = if (i, j) == (9, 4) { 300.0 } else { 0.0 };
            [base + sun, base + 0.5 * sun, 0.3 * base]
        };
        let pixels = Pixels::new(width, height, (0..width * height).map(texel).collect());
        Environment::new(pixels, DVec3::new(0.2, 1.0, 0.1).normalize(), 40.0)
    }

    /// The integral of f over all directions by the midpoint rule over the picture.
    fn integral(environment: &Environment, f: impl Fn(DVec3) -> f64) -> f64 {
        let (columns, rows) = (32 * 24, 16 * 24);
        let at = |k: usize| {
            let (i, j) = (k % columns, k / columns);
            let edges = [j, j + 1].map(|edge| (std::f64::consts::PI * edge as f64 / rows as f64).cos());
            let angle = (j as f64 + 0.5) / rows as f64 * std::f64::consts::PI;
            let direction = environment.direction((i as f64 + 0.5) / columns as f64, angle.cos());
            f(direction) * (edges[0] - edges[1]) * TAU / columns as f64
        };
        (0..columns * rows).map(at).sum()
    }

    #[test]
    fn directions_are_drawn_with_their_density_which_integrates_to_one() {
        let environment = environment();
        let sampler = EnvironmentSampler::new(&environment);
        let whole = integral(&environment, |d| sampler.pdf(&environment, d));
        assert!((whole - 1.0).abs() < 1e-6, "{whole}");
        let tests: [fn(DVec3) -> f64; 3] = [|d| d.x, |d| d.y * d.y, |d| d.z * d.x + 0.3 * d.y];
        let n = 1 << 15;
        for f in tests {
            let drawn = |k: u32| {
                let [u, v, ..] = Stream::Callers.sequence(4, 9, 0).point(k);
                f(sampler.sample(&environment, [u, v])) / f64::from(n)
            };
            let mean: f64 = (0..n).map(drawn).sum();
            let exact = integral(&environment, |d| f(d) * sampler.pdf(&environment, d));
            assert!((mean - exact).abs() < 1e-3, "{mean} {exact}");
        }
    }

    #[test]
    fn every_direction_that_shines_can_be_drawn() {
        let environment = environment();
        let sampler = EnvironmentSampler::new(&environment);
        let dark = integral(&environment, |d| {
            f64::from(u8::from(environment.from(d)[0] > 0.0 && sampler.pdf(&environment, d) == 0.0))
        });
        assert_eq!(dark, 0.0);
    }
}
