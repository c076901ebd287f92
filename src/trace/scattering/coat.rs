//! Coat: what the clear layer over a diffuse base, such as that of plastic, keeps from it.
//!
//! It has the facets of rough conductors and reflects by Fresnel's formulas F, at once and white. With μ =
//! cos θ its lobe is
//!
//! f₁(o, i) = F D(h) G₂(o, i) / (4 μₒ μᵢ),
//!
//! the part E(μₒ) of what comes from direction o. All the rest gets under it, and what the base sends out
//! gets away in the same measure (after Ashikhmin & Shirley 2000, eq. 5; Kelemen & Szirmay-Kalos 2001, eq.
//! 8):
//!
//! f₂(o, i) = ρ (1 − E(μₒ)) (1 − E(μᵢ)) / (π (1 − Ē)),  Ē = 2 ∫ E μ dμ.
//!
//! Both are the same from i to o as from o to i, and a base of ρ = 1 sends back all that is not reflected:
//! nothing is lost.
//!
//! *Under the coat* the base has one radiance b; towards direction o it sends b (1 − E(μₒ)), the flux π A (1
//! − Ē) b in all. So light is exchanged as between bare surfaces, with A (1 − Ē) in the place of A, by rays
//! whose directions have density (1 − E) μ / (π (1 − Ē)) and of which those that arrive from o land with
//! probability 1 − E(μₒ).

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;

use super::fresnel::fresnel;
use super::gloss::{Albedo, EVENEST, escape, facets, hiding, visible_facet};

/// Steps of either random number over which E is integrated.
const STEPS: usize = 48;

/// The clear layer over a diffuse base. Directions are unit vectors in a frame whose z is the normal, and
/// point away from the surface.
#[derive(Debug)]
pub struct Coat {
    alpha: f64,
    index: f64,
    /// White, per channel.
    pub(crate) white: Vec<f64>,
    /// E.
    albedo: Albedo,
}

impl Coat {
    /// A coat of this roughness, the root of α, and of this index of refraction.
    pub(crate) fn new(roughness: f64, index: f64, channels: usize) -> Self {
        let alpha = (roughness * roughness).max(EVENEST);
        let albedo = Albedo::of(|cosine| reflected(alpha, index, cosine));
        Self { alpha, index, white: vec![1.0; channels], albedo }
    }

    /// 1 − E(μ), the part of light from this angle that gets under it; and the part of the base's radiance
    /// that leaves by this angle.
    #[inline]
    pub fn passed(&self, cosine: f64) -> f64 {
        1.0 - self.albedo.at(cosine)
    }

    /// 1 − Ē, the part of even light that gets under it.
    #[inline]
    pub fn passed_of_all(&self) -> f64 {
        1.0 - self.albedo.mean
    }

    /// (1 − E(μ)) / (1 − Ē): light from this angle counts so much more than even light does.
    #[inline]
    pub fn weight(&self, cosine: f64) -> f64 {
        self.passed(cosine) / self.passed_of_all()
    }

    /// A direction in which the base sends light, with density [`Coat::leaving_pdf`].
    #[inline]
    pub fn leaving(&self, [s, t]: [f64; 2]) -> DVec3 {
        let cosine = self.albedo.sample_rest(s);
        let across = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (y, x) = (TAU * t).sin_cos();
        DVec3::new(across * x, across * y, cosine)
    }

    /// Density of [`Coat::leaving`] per unit solid angle: (1 − E(μ)) μ / (π (1 − Ē)).
    #[inline]
    pub fn leaving_pdf(&self, cosine: f64) -> f64 {
        cosine.max(0.0) * FRAC_1_PI * self.weight(cosine)
    }

    /// A direction in which light from `o` is reflected, by a facet drawn among those that `o` sees; and the
    /// part that is, F G₂/G₁, E(μₒ) on average.
    #[inline]
    pub(crate) fn reflect(&self, o: DVec3, square: [f64; 2]) -> (DVec3, f64) {
        let h = visible_facet(self.alpha, o, square);
        let i = 2.0 * o.dot(h) * h - o;
        (i, fresnel(o.dot(h).clamp(0.0, 1.0), self.index) * escape(self.alpha, o, i))
    }

    /// f₁(o, i) μᵢ.
    pub(crate) fn lobe(&self, o: DVec3, i: DVec3) -> f64 {
        if o.z <= 0.0 || i.z <= 0.0 {
            return 0.0;
        }
        let h = (o + i).normalize_or(DVec3::Z);
        let fresnel = fresnel(o.dot(h).clamp(0.0, 1.0), self.index);
        fresnel * facets(self.alpha, h) * hiding(self.alpha, o, i) / (4.0 * o.z)
    }
}

/// E(μ) by the midpoint rule over facets.
fn reflected(alpha: f64, index: f64, cosine: f64) -> f64 {
    let o = DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let mut sum = 0.0;
    for s in 0..STEPS {
        for t in 0..STEPS {
            // One half of the facets mirrors the other.
            let [u, v] = [0.5 * (s as f64 + 0.5), t as f64 + 0.5].map(|x| x / STEPS as f64);
            let h = visible_facet(alpha, o, [u, v]);
            let fresnel = fresnel(o.dot(h).clamp(0.0, 1.0), index);
            sum += fresnel * escape(alpha, o, 2.0 * o.dot(h) * h - o);
        }
    }
    sum / (STEPS * STEPS) as f64
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::trace::sampling::{Stream, cosine_hemisphere};

    const COATS: [(f64, f64); 6] = [(0.0, 1.5), (0.0, 2.5), (0.2, 1.5), (0.5, 1.5), (1.0, 1.33), (1.0, 2.0)];
    const COSINES: [f64; 7] = [0.003, 0.02, 0.1, 0.3, 0.6, 0.9, 1.0];

    fn from(cosine: f64) -> DVec3 {
        DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine)
    }

    #[test]
    fn a_smooth_coat_reflects_by_fresnels_formulas() {
        for index in [1.33, 1.5, 2.5] {
            let coat = Coat::new(0.0, index, 1);
            for cosine in COSINES {
                let exact = fresnel(cosine, index);
                assert!((1.0 - coat.passed(cosine) - exact).abs() < 2e-3, "{index} {cosine}");
            }
            // Ē is known in closed form (Duntley 1942); here by the midpoint rule over μ².
            let n = 100_000;
            let mean: f64 =
                (0..n).map(|k| fresnel(((f64::from(k) + 0.5) / f64::from(n)).sqrt(), index)).sum();
            let off = 1.0 - coat.passed_of_all() - mean / f64::from(n);
            assert!(off.abs() < 2e-4, "{index}: {off}");
        }
    }

    #[test]
    fn what_a_coat_reflects_and_a_white_base_sends_back_is_all_there_is_at_any_angle() {
        for (roughness, index) in COATS {
            let coat = Coat::new(roughness, index, 1);
            for o in COSINES.map(from) {
                let n = 1 << 14;
                let (mut by_facets, mut by_base) = (0.0, 0.0);
                for k in 0..n {
                    let [u, v, s, t] = Stream::Callers.sequence(5, 0, 0).point(k);
                    by_facets += coat.reflect(o, [u, v]).1 / f64::from(n);
                    // f₂ μᵢ by its integral over directions of density μ/π.
                    let i = cosine_hemisphere([s, t]);
                    let f = coat.passed(o.z) * coat.passed(i.z) / coat.passed_of_all();
                    by_base += f / f64::from(n);
                }
                let all = by_facets + by_base;
                assert!((all - 1.0).abs() < 3e-3, "{roughness} {index} {o}: {by_facets} + {by_base}");
            }
        }
    }

    #[test]
    fn directions_are_drawn_with_their_densities() {
        let tests: [fn(DVec3) -> f64; 4] = [|_| 1.0, |d| d.x, |d| d.y * d.y, |d| d.x * d.z];
        for (roughness, index) in COATS {
            let coat = Coat::new(roughness, index, 1);
            for f in tests {
                let n = 1 << 14;
                let (mut drawn, mut integral) = (0.0, 0.0);
                for k in 0..n {
                    let [u, v, s, t] = Stream::Callers.sequence(9, 0, 0).point(k);
                    drawn += f(coat.leaving([u, v])) / f64::from(n);
                    let d = cosine_hemisphere([s, t]);
                    integral += f(d) * coat.leaving_pdf(d.z) / (d.z * FRAC_1_PI) / f64::from(n);
                }
                assert!((drawn - integral).abs() < 2e-3, "{roughness} {index}: {drawn} {integral}");
            }
            // The lobe of a rough coat, over directions drawn by its facets and over all alike.
            if roughness < 0.5 {
                continue;
            }
            for (o, f) in COSINES[2..].iter().map(|&c| from(c)).flat_map(|o| tests.map(|f| (o, f))) {
                let n = 1 << 15;
                let (mut drawn, mut integral) = (0.0, 0.0);
                for k in 0..n {
                    let [u, v, s, t] = Stream::Callers.sequence(9, 1, 0).point(k);
                    let (i, part) = coat.reflect(o, [u, v]);
                    drawn += part * f(i) / f64::from(n);
                    let i = cosine_hemisphere([s, t]);
                    integral += coat.lobe(o, i) * f(i) * PI / i.z / f64::from(n);
                }
                assert!((drawn - integral).abs() < 4e-3, "{roughness} {index} {o}: {drawn} {integral}");
            }
        }
    }

    #[test]
    fn the_lobe_is_reciprocal() {
        let coat = Coat::new(0.7, 1.5, 1);
        for k in 0..1000 {
            let [s, t, u, v] = Stream::Callers.sequence(8, 0, 0).point(k);
            let [o, i] = [[s, t], [u, v]].map(cosine_hemisphere);
            let (there, back) = (coat.lobe(o, i) / i.z, coat.lobe(i, o) / o.z);
            assert!((there - back).abs() <= 1e-9 * there, "{o} {i}: {there} {back}");
        }
    }

    #[test]
    fn a_coat_as_thin_as_air_is_not_there() {
        let coat = Coat::new(0.5, 1.0, 1);
        assert!((coat.passed_of_all() - 1.0).abs() < 1e-12);
        assert!((coat.leaving_pdf(0.7) - 0.7 * FRAC_1_PI).abs() < 1e-12);
    }
}
