//! Gloss: what a rough conductor reflects, by facets too small to see.
//!
//! The normals h of its facets have the GGX distribution D (Walter et al. 2007, eq. 33), and facets hide each
//! other by Smith's height-correlated masking G₂ (Heitz 2014, eq. 99). Of what comes from direction o, with μ
//! = cos θ, one reflection sends on
//!
//! f₁(o, i) = F D(h) G₂(o, i) / (4 μₒ μᵢ).
//!
//! For F = 1 that is the part E(μₒ) of all; the rest meets further facets. It leaves by a lobe of its own
//! (Kulla & Conty 2017),
//!
//! f₂(o, i) = F₂ (1 − E(μₒ)) (1 − E(μᵢ)) / (π (1 − Ē)),  Ē = 2 ∫ E μ dμ,
//!
//! so that a white conductor reflects all there is, and both are the same from i to o as from o to i. F is
//! Schlick's (1994); with its mean F̄ over the hemisphere F₂ = F̄² Ē / (1 − F̄ (1 − Ē)).
//!
//! *Sampling.* A facet is drawn among those that o sees. With probability G₂/G₁ the ray gets away from it:
//! that happens in the part E(μₒ) of all cases, so that what remains is just what f₂ is to have, whose
//! direction is drawn by itself. The directions of a white conductor have density (f₁ + f₂) μᵢ, and its rays
//! keep all their weight.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::DVec3;

use super::tint::Tint;

/// Facets as even as this, in terms of α, are a mirror to the eye; evener ones are taken as this.
pub(crate) const EVENEST: f64 = 1e-4;

/// Stretches of the table of E.
const STRETCHES: usize = 64;

/// Steps of either random number over which E is integrated.
const STEPS: usize = 96;

/// What a rough conductor does with light. Directions are unit vectors in a frame whose z is the normal, and
/// point away from the surface.
#[derive(Debug)]
pub(crate) struct Gloss<'s> {
    alpha: f64,
    /// F at normal incidence, per channel.
    reflectance: &'s [f64],
    /// F₂, per channel.
    further: Vec<f64>,
    albedo: Albedo,
}

/// A direction, and the part of the light that goes on there.
pub(crate) type Way<'t> = (DVec3, Tint<'t>);

impl<'s> Gloss<'s> {
    /// A conductor of this roughness, the root of α, and of this reflectance at normal incidence.
    pub fn new(roughness: f64, reflectance: &'s [f64]) -> Self {
        let alpha = (roughness * roughness).max(EVENEST);
        let albedo = Albedo::of(|cosine| single_albedo(alpha, cosine));
        let further = |f: &f64| {
            // The mean of (1 − μ)⁵ over the hemisphere is 1/21.
            let mean = f + (1.0 - f) / 21.0;
            mean * mean * albedo.mean / (1.0 - mean * (1.0 - albedo.mean))
        };
        Self { alpha, reflectance, further: reflectance.iter().map(further).collect(), albedo }
    }

    /// Where a ray goes on that came from `o`, with density [`Gloss::density`]. `more` gives further random
    /// numbers where these do not suffice.
    pub fn sample<'t>(
        &'t self,
        o: DVec3,
        [chance, u, v]: [f64; 3],
        more: impl FnOnce() -> [f64; 4],
    ) -> Way<'t> {
        let h = visible_facet(self.alpha, o, [u, v]);
        let i = 2.0 * o.dot(h) * h - o;
        if chance < escape(self.alpha, o, i) {
            return (i, self.tint(o, h));
        }
        // Leave by what further facets reflect.
        let [s, t, ..] = more();
        let cosine = self.albedo.sample_rest(s);
        let across = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (y, x) = (TAU * t).sin_cos();
        (DVec3::new(across * x, across * y, cosine), Tint::of(&self.further))
    }

    /// Density of [`Gloss::sample`] per unit solid angle: (f₁ + f₂) μᵢ of the white conductor.
    pub fn density(&self, o: DVec3, i: DVec3) -> f64 {
        self.parts(o, i).iter().map(|(density, _)| density).sum()
    }

    /// What goes from `o` to `i`: the densities f₁ μᵢ and f₂ μᵢ of the white conductor, and the part of each
    /// that goes on.
    pub fn parts<'t>(&'t self, o: DVec3, i: DVec3) -> [(f64, Tint<'t>); 2] {
        let h = (o + i).normalize_or(DVec3::Z);
        let once = if o.z > 0.0 && i.z > 0.0 {
            facets(self.alpha, h) * hiding(self.alpha, o, i) / (4.0 * o.z)
        } else {
            0.0
        };
        let again = (1.0 - self.albedo.at(o.z)) * self.albedo.rest_pdf(i.z);
        [(once, self.tint(o, h)), (again, Tint::of(&self.further))]
    }

    /// F = F₀ + (1 − F₀)(1 − o·h)⁵ (Schlick 1994).
    fn tint(&self, o: DVec3, h: DVec3) -> Tint<'_> {
        Tint::towards_white(self.reflectance, (1.0 - o.dot(h)).clamp(0.0, 1.0).powi(5))
    }
}

/// D(h) (Walter et al. 2007, eq. 33).
pub(crate) fn facets(alpha: f64, h: DVec3) -> f64 {
    let square = alpha * alpha;
    // tan²θ + α² times cos²θ, free of cancellation.
    let stretched = h.x * h.x + h.y * h.y + square * h.z * h.z;
    if stretched > 0.0 { square * FRAC_1_PI / (stretched * stretched) } else { 0.0 }
}

/// √(cos²θ + α² sin²θ) = cos θ · (1 + 2Λ), by which all masking is expressed here.
#[inline]
fn spread(alpha: f64, w: DVec3) -> f64 {
    (w.z * w.z + alpha * alpha * (w.x * w.x + w.y * w.y)).sqrt()
}

/// G₂(o, i) = 1 / (1 + Λ(o) + Λ(i)) (Heitz 2014, eq. 99).
pub(crate) fn hiding(alpha: f64, o: DVec3, i: DVec3) -> f64 {
    2.0 * o.z * i.z / (o.z * spread(alpha, i) + i.z * spread(alpha, o))
}

/// G₂(o, i) / G₁(o), how likely light from a facet that o sees gets away in direction i.
#[inline]
pub(crate) fn escape(alpha: f64, o: DVec3, i: DVec3) -> f64 {
    if i.z <= 0.0 {
        return 0.0;
    }
    let seen = (spread(alpha, o) + o.z) * i.z;
    seen / (seen + (spread(alpha, i) - i.z) * o.z)
}

/// The normal of a facet that `o` sees (Dupuy & Benyoub 2023), with density `visible_facet_pdf`.
pub(crate) fn visible_facet(alpha: f64, o: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    // Stretch the facets to a hemisphere, which o sees as reflected into a cap of the sphere.
    let o = DVec3::new(alpha * o.x, alpha * o.y, o.z.max(0.0)).normalize();
    let z = (1.0 - v) * (1.0 + o.z) - o.z;
    let across = (1.0 - z * z).max(0.0).sqrt();
    let (sine, cosine) = (TAU * u).sin_cos();
    let h = o + DVec3::new(across * cosine, across * sine, z);
    DVec3::new(alpha * h.x, alpha * h.y, h.z.max(0.0)).normalize_or(DVec3::Z)
}

/// Density of [`visible_facet`] per unit solid angle: G₁(o) D(h) (o·h)/μₒ (Heitz 2018, eq. 3).
#[cfg(test)]
fn visible_facet_pdf(alpha: f64, o: DVec3, h: DVec3) -> f64 {
    facets(alpha, h) * o.dot(h).max(0.0) * 2.0 / (o.z + spread(alpha, o))
}

/// E(μ), the part that one reflection of the white conductor sends on, by the midpoint rule over facets.
fn single_albedo(alpha: f64, cosine: f64) -> f64 {
    let o = DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let mut sum = 0.0;
    for s in 0..STEPS {
        for t in 0..STEPS {
            // One half of the facets mirrors the other; steep ones, for which v is near 1, are few but hold
            // light back most.
            let u = 0.5 * (s as f64 + 0.5) / STEPS as f64;
            let left = 1.0 - (t as f64 + 0.5) / STEPS as f64;
            let h = visible_facet(alpha, o, [u, 1.0 - left.powi(3)]);
            sum += escape(alpha, o, 2.0 * o.dot(h) * h - o) * 3.0 * left.powi(2);
        }
    }
    sum / (STEPS * STEPS) as f64
}

/// Directional albedo E(μ), linear in μ² between nodes that lie close where light grazes.
#[derive(Debug)]
pub(crate) struct Albedo {
    /// E at the nodes μ² = (k/n)⁴.
    nodes: [f64; STRETCHES + 1],
    /// ∫ (1 − E) dμ² from 0 to each node.
    rest: [f64; STRETCHES + 1],
    /// Ē.
    pub mean: f64,
}

impl Albedo {
    pub fn of(albedo: impl Fn(f64) -> f64) -> Self {
        let nodes: [f64; STRETCHES + 1] = std::array::from_fn(|k| albedo(node(k).sqrt()).min(1.0));
        let mut rest = [0.0; STRETCHES + 1];
        for k in 0..STRETCHES {
            rest[k + 1] = rest[k] + (1.0 - 0.5 * (nodes[k] + nodes[k + 1])) * (node(k + 1) - node(k));
        }
        Self { nodes, rest, mean: 1.0 - rest[STRETCHES] }
    }

    /// E(μ).
    pub fn at(&self, cosine: f64) -> f64 {
        let place = (cosine.clamp(0.0, 1.0).sqrt() * STRETCHES as f64).min(STRETCHES as f64 - 1e-9);
        let k = place as usize;
        let part = (cosine * cosine - node(k)) / (node(k + 1) - node(k));
        self.nodes[k] + (self.nodes[k + 1] - self.nodes[k]) * part
    }

    /// A cosine with density [`Albedo::rest_pdf`].
    pub fn sample_rest(&self, chance: f64) -> f64 {
        let wanted = chance * self.rest[STRETCHES];
        let k = (self.rest.partition_point(|&sum| sum <= wanted).max(1) - 1).min(STRETCHES - 1);
        // Solve a x + (b − a) x²/2 = what is wanted of this stretch, for x from 0 to 1.
        let [a, b] = [1.0 - self.nodes[k], 1.0 - self.nodes[k + 1]];
        let length = node(k + 1) - node(k);
        let part = (wanted - self.rest[k]) / length;
        let root = a + (a * a + 2.0 * (b - a) * part).max(0.0).sqrt();
        let x = if root > 0.0 { (2.0 * part / root).clamp(0.0, 1.0) } else { 0.5 };
        (node(k) + length * x).sqrt()
    }

    /// Density per unit solid angle of the directions that [`Albedo::sample_rest`] belongs to: (1 − E) μ / (π
    /// (1 − Ē)).
    fn rest_pdf(&self, cosine: f64) -> f64 {
        let all = self.rest[STRETCHES];
        if cosine > 0.0 && all > 0.0 { (1.0 - self.at(cosine)) * cosine / (PI * all) } else { 0.0 }
    }
}

/// Node k of μ².
fn node(k: usize) -> f64 {
    (k as f64 / STRETCHES as f64).powi(4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::sampling::{Stream, cosine_hemisphere};

    const ROUGHNESS: [f64; 5] = [0.05, 0.2, 0.5, 0.8, 1.0];
    const COSINES: [f64; 6] = [0.02, 0.1, 0.3, 0.6, 0.9, 1.0];

    fn from(cosine: f64) -> DVec3 {
        DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine)
    }

    /// ∫ f(h) dω over the hemisphere, by the midpoint rule over θ and φ, the former close where α has its
    /// peak.
    fn integrate(alpha: f64, f: impl Fn(DVec3) -> f64) -> f64 {
        const N: usize = 250;
        let mut sum = 0.0;
        for k in 0..N {
            // tan θ = α x / (1 − x) takes half of the steps up to where D falls off.
            let x = (k as f64 + 0.5) / N as f64;
            let tangent = alpha * x / (1.0 - x);
            let theta = tangent.atan();
            let width = alpha / ((1.0 - x) * (1.0 - x)) / (1.0 + tangent * tangent) / N as f64;
            for j in 0..2 * N {
                let phi = (j as f64 + 0.5) / (2 * N) as f64 * TAU;
                let (sine, cosine) = theta.sin_cos();
                let h = DVec3::new(sine * phi.cos(), sine * phi.sin(), cosine);
                sum += f(h) * sine * width * TAU / (2 * N) as f64;
            }
        }
        sum
    }

    /// The density of reflected directions, integrated by the facets that reflect there: dωᵢ = 4 (o·h) dωₕ.
    fn reflected(gloss: &Gloss, o: DVec3, f: impl Fn(DVec3) -> f64) -> f64 {
        let once = integrate(gloss.alpha, |h| {
            let i = 2.0 * o.dot(h) * h - o;
            if o.dot(h) <= 0.0 { 0.0 } else { gloss.parts(o, i)[0].0 * 4.0 * o.dot(h) * f(i) }
        });
        once + integrate(1.0, |i| gloss.parts(o, i)[1].0 * f(i))
    }

    #[test]
    fn a_white_conductor_of_any_roughness_reflects_all_light_from_any_angle() {
        for roughness in ROUGHNESS {
            let gloss = Gloss::new(roughness, &[1.0]);
            assert_eq!(gloss.further, [1.0]);
            for cosine in COSINES {
                let all = reflected(&gloss, from(cosine), |_| 1.0);
                assert!((all - 1.0).abs() < 1e-3, "{roughness} {cosine}: {all}");
            }
        }
    }

    #[test]
    fn directions_and_facets_are_drawn_with_their_densities() {
        let tests: [fn(DVec3) -> f64; 4] = [|d| d.z, |d| d.x, |d| d.y * d.y, |d| d.x * d.z];
        for roughness in ROUGHNESS {
            let gloss = Gloss::new(roughness, &[0.5]);
            for o in COSINES.map(from) {
                let n = 1 << 14;
                let mut means = [[0.0; 4]; 2];
                for k in 0..n {
                    let sequence = Stream::Callers.sequence(5, 0, 0);
                    let [chance, u, v, _] = sequence.point(k);
                    let (i, _) = gloss.sample(o, [chance, u, v], || sequence.dimensions(k, 1));
                    let h = visible_facet(gloss.alpha, o, [u, v]);
                    assert!((i.length() - 1.0).abs() < 1e-9 && i.z >= 0.0 && h.z >= 0.0);
                    for (mean, d) in means.iter_mut().zip([i, h]) {
                        mean.iter_mut().zip(tests).for_each(|(mean, f)| *mean += f(d) / f64::from(n));
                    }
                }
                for (k, f) in tests.into_iter().enumerate() {
                    let directions = reflected(&gloss, o, f);
                    let facets = integrate(gloss.alpha, |h| visible_facet_pdf(gloss.alpha, o, h) * f(h));
                    let offs = [means[0][k] - directions, means[1][k] - facets];
                    assert!(offs.iter().all(|off| off.abs() < 2e-3), "{roughness} {o} {k}: {offs:?}");
                }
            }
        }
    }

    #[test]
    fn reflection_is_reciprocal() {
        for roughness in ROUGHNESS {
            let gloss = Gloss::new(roughness, &[0.9, 0.3]);
            for k in 0..1000 {
                let [s, t, u, v] = Stream::Callers.sequence(8, 0, 0).point(k);
                let [o, i] = [[s, t], [u, v]].map(cosine_hemisphere);
                let value = |o: DVec3, i: DVec3, c: usize| -> f64 {
                    gloss.parts(o, i).iter().map(|(density, tint)| density * tint.part(c)).sum::<f64>() / i.z
                };
                for c in 0..2 {
                    let (there, back) = (value(o, i, c), value(i, o, c));
                    assert!((there - back).abs() <= 1e-9 * there, "{roughness} {o} {i}: {there} {back}");
                }
            }
        }
    }

    #[test]
    fn further_facets_take_the_more_the_darker_a_conductor_is() {
        // Against reflections one by one: facets reflect F̄ each time, and of what they reflect the part Ē
        // gets away.
        for f in [0.2, 0.5, 0.95] {
            let gloss = Gloss::new(1.0, std::slice::from_ref(&f));
            let mean = f + (1.0 - f) / 21.0;
            let escaping = gloss.albedo.mean;
            let series: f64 =
                (0..500).map(|k| mean * escaping * mean * (mean * (1.0 - escaping)).powi(k)).sum();
            assert!((gloss.further[0] - series).abs() < 1e-12, "{f}");
        }
    }
}
