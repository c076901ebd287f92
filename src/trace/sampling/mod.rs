//! Sampling: random points and directions, each sampler beside its density.
//!
//! Samples come from 4-D Owen-scrambled Sobol sequences (Burley 2020), which end at 2¹⁶ points: rays are
//! drawn in *batches*, each with a scrambling of its own, so that the spread between batches measures the
//! error. [`Stream`] lists what they are for.

mod discrete;
mod streams;

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::{DMat3, DVec3};

pub use discrete::{Discrete, DiscreteTable};
pub use streams::Stream;

/// The most points a scrambling has.
pub const SEQUENCE_END: u32 = 1 << 16;

/// One scrambling of the four-dimensional Sobol sequence; [`Stream`]s have them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sequence(u32);

impl Sequence {
    /// The scrambling with number `index` of stream number `stream` under a user's seed.
    fn of(seed: u64, stream: u64, index: u64) -> Self {
        // Three rounds of SplitMix64 (Steele, Lea & Flood 2014).
        let mixed = [seed, stream, index].iter().fold(0u64, |state, &word| split_mix(state ^ word));
        Self((mixed >> 32) as u32)
    }

    /// Point `k` of the sequence, strictly inside the unit cube; k < [`SEQUENCE_END`].
    #[inline]
    pub fn point(self, k: u32) -> [f64; 4] {
        self.dimensions(k, 0)
    }

    /// Dimensions 4·`set` to 4·`set` + 3 of point `k`, for points of many dimensions; [`Sequence::point`] is
    /// set 0.
    #[inline]
    pub fn dimensions(self, k: u32, set: u32) -> [f64; 4] {
        // The sequence has 24 bits; half a step more keeps it off the edges.
        const HALF_STEP: f64 = 1.0 / (1u32 << 25) as f64;
        const SETS: u32 = sobol_burley::NUM_DIMENSION_SETS_4D;
        // Beyond its last dimension the sequence begins again under another scrambling.
        let seed =
            if set < SETS { self.0 } else { split_mix((self.0 as u64) << 32 | (set / SETS) as u64) as u32 };
        sobol_burley::sample_4d(k, set % SETS, seed).map(|x| f64::from(x) + HALF_STEP)
    }
}

/// Random numbers for a path: a point of a sequence, four dimensions at a time from set `set` on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampler {
    pub sequence: Sequence,
    pub point: u32,
    pub set: u32,
}

impl Sampler {
    #[inline]
    pub fn next(&mut self) -> [f64; 4] {
        self.set += 1;
        self.sequence.dimensions(self.point, self.set - 1)
    }
}

fn split_mix(state: u64) -> u64 {
    let z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Barycentric weights of the second and third corner, uniform over a triangle (Heitz 2019).
#[inline]
pub fn uniform_triangle([u, v]: [f64; 2]) -> [f64; 2] {
    if u < v { [0.5 * u, v - 0.5 * u] } else { [u - 0.5 * v, 0.5 * v] }
}

/// A point of a rule for means over a triangle: barycentric weights of the second and third corner, and the
/// part that it counts.
pub type RulePoint = ([f64; 2], f64);

/// A rule that is exact for polynomials of degree two (Hammer, Marlowe & Stroud 1956).
pub const TRIANGLE_RULE_3: [RulePoint; 3] = {
    const PART: f64 = 1.0 / 3.0;
    [([1.0 / 6.0, 1.0 / 6.0], PART), ([2.0 / 3.0, 1.0 / 6.0], PART), ([1.0 / 6.0, 2.0 / 3.0], PART)]
};

/// One that is exact for polynomials of degree five (Radon 1948).
pub const TRIANGLE_RULE_7: [RulePoint; 7] = {
    const ROOT_OF_15: f64 = 3.872_983_346_207_417;
    const FAR: f64 = (6.0 - ROOT_OF_15) / 21.0;
    const NEAR: f64 = (6.0 + ROOT_OF_15) / 21.0;
    const OF_FAR: f64 = (155.0 - ROOT_OF_15) / 1200.0;
    const OF_NEAR: f64 = (155.0 + ROOT_OF_15) / 1200.0;
    [
        ([1.0 / 3.0, 1.0 / 3.0], 9.0 / 40.0),
        ([FAR, FAR], OF_FAR),
        ([1.0 - 2.0 * FAR, FAR], OF_FAR),
        ([FAR, 1.0 - 2.0 * FAR], OF_FAR),
        ([NEAR, NEAR], OF_NEAR),
        ([1.0 - 2.0 * NEAR, NEAR], OF_NEAR),
        ([NEAR, 1.0 - 2.0 * NEAR], OF_NEAR),
    ]
};

/// A direction within a spherical triangle, uniform, given by the unit vectors of its corners (Arvo 1995):
/// its density is the inverse of the solid angle α + β + γ − π.
#[inline]
pub fn uniform_spherical_triangle([a, b, c]: [DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
    // Take the angles at the corners.
    let across = |p: DVec3, q: DVec3| p.cross(q).normalize_or_zero();
    let [ab, bc, ca] = [across(a, b), across(b, c), across(c, a)];
    let [alpha, beta, gamma] = [ab.angle_between(-ca), bc.angle_between(-ab), ca.angle_between(-bc)];
    let area = alpha + beta + gamma - PI;
    // Move the third corner along its side to a, so that a share u of the area is left.
    let (sine, cosine) = (u * area - alpha).sin_cos();
    let (x, y) = (cosine - alpha.cos(), sine + alpha.sin() * a.dot(b));
    let q = ((y * cosine - x * sine) * alpha.cos() - y) / ((y * sine + x * cosine) * alpha.sin());
    let third = towards(a, c, q.clamp(-1.0, 1.0));
    // Choose a point between it and b.
    towards(b, third, 1.0 - v * (1.0 - third.dot(b)))
}

/// The unit vector on the great circle from one to another, at this cosine from the first.
#[inline]
fn towards(from: DVec3, to: DVec3, cosine: f64) -> DVec3 {
    let across = (to - from * to.dot(from)).normalize_or_zero();
    from * cosine + across * (1.0 - cosine * cosine).max(0.0).sqrt()
}

/// A point of the unit disc, uniform (Shirley & Chiu 1997).
#[inline]
pub fn uniform_disc(square: [f64; 2]) -> [f64; 2] {
    concentric(square).0
}

/// A direction within a cone of this axis and solid angle, uniform in solid angle.
#[inline]
pub fn uniform_cone(axis: DVec3, angle: f64, [u, v]: [f64; 2]) -> DVec3 {
    let height = 1.0 - u * angle / TAU;
    let radius = (1.0 - height * height).max(0.0).sqrt();
    let (sine, cosine) = (v * TAU).sin_cos();
    frame_around(axis) * DVec3::new(radius * cosine, radius * sine, height)
}

/// A direction over the plane z = 0 with density [`cosine_hemisphere_pdf`].
#[inline]
pub fn cosine_hemisphere(square: [f64; 2]) -> DVec3 {
    let ([x, y], radius) = concentric(square);
    DVec3::new(x, y, (1.0 - radius * radius).max(0.0).sqrt())
}

/// The square mapped onto the disc, circle by circle: a point, and its distance from the middle, perhaps with
/// a minus (Shirley & Chiu 1997).
#[inline]
fn concentric([u, v]: [f64; 2]) -> ([f64; 2], f64) {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    // Which is the larger is a matter of chance: both are chosen from rather than branched on.
    let is_upright = x.abs() <= y.abs();
    let (radius, other) = if is_upright { (y, x) } else { (x, y) };
    if radius == 0.0 {
        return ([0.0; 2], 0.0);
    }
    let [sine, cosine] = sine_and_cosine(PI / 4.0 * (other / radius));
    let (along, across) = (radius * cosine, radius * sine);
    (if is_upright { [across, along] } else { [along, across] }, radius)
}

/// Sine and cosine of an angle of at most π/4, to the last bit or two: the polynomials of fdlibm (Sun
/// Microsystems 1993). Those of the system's library, for angles of any size, took a twentieth of all time.
#[inline]
fn sine_and_cosine(angle: f64) -> [f64; 2] {
    const SINE: [f64; 6] = [
        -1.666_666_666_666_663_2e-1,
        8.333_333_333_322_49e-3,
        -1.984_126_982_985_795e-4,
        2.755_731_370_707_006_8e-6,
        -2.505_076_025_340_686_3e-8,
        1.589_690_995_211_55e-10,
    ];
    const COSINE: [f64; 6] = [
        4.166_666_666_666_66e-2,
        -1.388_888_888_887_411e-3,
        2.480_158_728_947_673e-5,
        -2.755_731_435_139_066_3e-7,
        2.087_572_321_298_175e-9,
        -1.135_964_755_778_819_5e-11,
    ];
    let z = angle * angle;
    let polynomial = |of: &[f64; 6]| of.iter().rev().fold(0.0, |sum, coefficient| sum * z + coefficient);
    [angle + angle * z * polynomial(&SINE), 1.0 - (0.5 * z - z * z * polynomial(&COSINE))]
}

/// Density of [`cosine_hemisphere`] per unit solid angle: cos θ / π.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f64) -> f64 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// The power heuristic with exponent 2 (Veach 1997, eq. 9.13): the weight of a sample that was drawn with
/// density `pdf` where another way of sampling would draw it with density `other`, in the same unit.
#[inline]
pub fn power_heuristic(pdf: f64, other: f64) -> f64 {
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}

/// Columns tangent, bitangent and normal: a right-handed frame around a unit normal (Duff et al. 2017).
#[inline]
pub fn frame_around(normal: DVec3) -> DMat3 {
    let sign = 1.0f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    DMat3::from_cols(
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
        normal,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::triangle;

    /// Checks that a sampler has its density: the mean of f under it is ∫ f·pdf, for several f at once.
    #[test]
    fn cosine_hemisphere_has_its_density() {
        let tests: [fn(DVec3) -> f64; 4] = [|_| 1.0, |d| d.z, |d| d.x * d.x, |d| d.z * d.z * d.y * d.y];
        let n = 1 << 14;
        let mut mean = [0.0; 4];
        for k in 0..n {
            let [u, v, ..] = Stream::Callers.sequence(7, 0, 0).point(k);
            let d = cosine_hemisphere([u, v]);
            assert!((d.length() - 1.0).abs() < 1e-12 && d.z >= 0.0);
            for (m, f) in mean.iter_mut().zip(tests) {
                *m += f(d) / n as f64;
            }
        }
        // Integrate the density itself by the midpoint rule over θ and φ.
        let steps = 400;
        let mut integral = [0.0; 4];
        for i in 0..steps {
            for j in 0..steps {
                let theta = (i as f64 + 0.5) / steps as f64 * PI / 2.0;
                let phi = (j as f64 + 0.5) / steps as f64 * 2.0 * PI;
                let (st, ct) = theta.sin_cos();
                let d = DVec3::new(st * phi.cos(), st * phi.sin(), ct);
                let cell = st * (PI / 2.0) * (2.0 * PI) / (steps * steps) as f64;
                for (m, f) in integral.iter_mut().zip(tests) {
                    *m += f(d) * cosine_hemisphere_pdf(d.z) * cell;
                }
            }
        }
        for (m, i) in mean.iter().zip(integral) {
            assert!((m - i).abs() < 5e-4, "{mean:?} {integral:?}");
        }
    }

    #[test]
    fn uniform_triangle_is_uniform_and_inside() {
        let n = 1 << 14;
        let mut moments = [0.0; 3];
        for k in 0..n {
            let [u, v, ..] = Stream::Callers.sequence(7, 1, 0).point(k);
            let [b, c] = uniform_triangle([u, v]);
            assert!(b > 0.0 && c > 0.0 && b + c < 1.0);
            for (m, x) in moments.iter_mut().zip([b, c, b * c]) {
                *m += x / n as f64;
            }
        }
        for (m, exact) in moments.iter().zip([1.0 / 3.0, 1.0 / 3.0, 1.0 / 12.0]) {
            assert!((m - exact).abs() < 1e-4, "{moments:?}");
        }
    }

    #[test]
    fn sines_and_cosines_are_right_to_the_last_bits() {
        for k in -1000..=1000 {
            let angle = PI / 4.0 * f64::from(k) / 1000.0;
            let [sine, cosine] = sine_and_cosine(angle);
            assert!(
                (sine - angle.sin()).abs() <= 1.5e-16 && (cosine - angle.cos()).abs() <= 2.5e-16,
                "{angle}"
            );
        }
    }

    #[test]
    fn rules_for_triangles_are_exact_to_their_degree() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for (rule, degree) in [(&TRIANGLE_RULE_3[..], 2), (&TRIANGLE_RULE_7, 5)] {
            for (i, j) in (0..=degree).flat_map(|i| (0..=degree - i).map(move |j| (i, j))) {
                let found: f64 = rule.iter().map(|&([u, v], part)| part * u.powi(i) * v.powi(j)).sum();
                // ∫ uⁱ vʲ over the unit triangle, by its area ½.
                let exact = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2);
                assert!((found - exact).abs() < 1e-15, "{i} {j}: {found} {exact}");
            }
        }
    }

    #[test]
    fn uniform_spherical_triangle_is_uniform_in_solid_angle() {
        let triangles = [
            [DVec3::X, DVec3::Y, DVec3::Z],
            [DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.3, 1.0, 0.4), DVec3::new(0.1, -0.8, 0.9)],
            [DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.0, 0.02, 0.0), DVec3::new(1.0, 0.01, 0.004)],
        ];
        for corners in triangles {
            let n = 1 << 14;
            let across = triangle::across(&corners);
            // The plane triangle by the midpoint rule: dω = cos θ/r² dA.
            let (mut exact, mut whole) = ([0.0; 4], 0.0);
            let steps = 300;
            let tests = |d: DVec3| [d.x, d.y, d.z, d.x * d.y];
            for k in 0..steps * steps {
                let [u, v] = [k / steps, k % steps].map(|k| (f64::from(k) + 0.5) / f64::from(steps));
                let p = triangle::point(&corners, uniform_triangle([u, v]));
                let solid = across.dot(p).abs() / p.length().powi(3);
                whole += solid;
                exact.iter_mut().zip(tests(p.normalize())).for_each(|(sum, f)| *sum += f * solid);
            }
            let mut mean = [0.0; 4];
            for k in 0..n {
                let [u, v, ..] = Stream::Callers.sequence(7, 2, 0).point(k);
                let d = uniform_spherical_triangle(corners.map(DVec3::normalize), [u, v]);
                assert!((d.length() - 1.0).abs() < 1e-12);
                mean.iter_mut().zip(tests(d)).for_each(|(m, f)| *m += f / f64::from(n));
            }
            for (m, e) in mean.iter().zip(exact) {
                assert!((m - e / whole).abs() < 3e-4, "{corners:?} {mean:?} {exact:?} {whole}");
            }
        }
    }

    #[test]
    fn the_frame_is_orthonormal_and_right_handed() {
        for k in 0..100 {
            let [a, b, ..] = Stream::Callers.sequence(1, 2, 3).point(k);
            let normal = cosine_hemisphere([a, b]) * if k % 2 == 0 { 1.0 } else { -1.0 };
            let frame = frame_around(normal);
            assert!((frame.determinant() - 1.0).abs() < 1e-12);
            assert!((frame.transpose() * frame).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        }
    }
}
