//! Polygons: exact exchange areas between triangles that see all of each other, without a ray.
//!
//! A_i F_ij = ∫∫ cos θ cos θ′ / (π r²) dA dA. Well apart the integrand is smooth, and Gauss' rules on both
//! triangles (Dunavant 1985) do. Near each other the double contour integral is taken (Lambert 1760; Schröder
//! & Hanrahan 1993),
//!
//! A_i F_ij = 1/2π ∮∮ ln r dr·dr′,
//!
//! along the edges of both: over the second edge in closed form, over the first by Gauss' rule on pieces that
//! shrink towards the ends of the second, where the integrand has a kink if edges touch.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::Exchange;
use super::mass::Mass;
use super::storage::Storage;
use crate::patches::{Basis, Facet, Patches};
use crate::progress::{Cancelled, Progress};
use crate::scene::Side;
use crate::scene::triangle;
use crate::trace::{Enclosure, Tracer};

/// Distances between centres, by the sum of both radii, from which on three and six points a triangle do.
const THREE_DO: f64 = 12.0;
const SIX_DO: f64 = 4.0;

/// Points of the rules as weights of the triangle's last two corners, and what each is worth; exact to degree
/// 2 and 4.
const THREE: [[f64; 3]; 3] = {
    let (a, b, w) = (1.0 / 6.0, 2.0 / 3.0, 1.0 / 3.0);
    [[a, a, w], [a, b, w], [b, a, w]]
};
const SIX: [[f64; 3]; 6] = {
    let (a, v) = (0.445_948_490_915_964_9, 0.223_381_589_678_011_47);
    let (b, w) = (0.091_576_213_509_770_74, 0.109_951_743_655_321_87);
    let (c, d) = (1.0 - 2.0 * a, 1.0 - 2.0 * b);
    [[a, a, v], [a, c, v], [c, a, v], [b, b, w], [b, d, w], [d, b, w]]
};

/// Gauss' rule of eight points on [−1, 1]: the positive half, and what each point is worth.
const EIGHT: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_26],
];

/// How often a piece of an edge is halved at most.
const HALVINGS: u32 = 14;

/// Columns between two reports of progress.
const CHUNK: usize = 128;

/// A front, ready to be integrated over.
struct Polygon {
    face: u32,
    corners: [DVec3; 3],
    normal: DVec3,
    centre: DVec3,
    radius: f64,
    area: f64,
    three: [DVec3; 3],
    six: [DVec3; 6],
}

impl Polygon {
    fn new(facet: &Facet, area: f64) -> Self {
        let [a, b, c] = facet.corners;
        let at = |[u, v, _]: [f64; 3]| triangle::point(&facet.corners, [u, v]);
        let centre = facet.centre();
        let radius = [a, b, c].iter().fold(0.0f64, |most, p| most.max(p.distance(centre)));
        let &Facet { face, normal, .. } = facet;
        Self {
            face,
            corners: [a, b, c],
            normal,
            centre,
            radius,
            area,
            three: THREE.map(at),
            six: SIX.map(at),
        }
    }

    /// A F between two that lie in front of each other.
    fn exchange_area(&self, other: &Self) -> f64 {
        if self.face == other.face {
            return 0.0;
        }
        let apart = self.centre.distance(other.centre);
        let radii = self.radius + other.radius;
        if apart > THREE_DO * radii {
            self.by_rule(other, (&self.three, &other.three), &THREE)
        } else if apart > SIX_DO * radii {
            self.by_rule(other, (&self.six, &other.six), &SIX)
        } else if self.is_in_plane_of(other) {
            0.0
        } else {
            self.by_contours(other)
        }
    }

    fn by_rule<const N: usize>(
        &self,
        other: &Self,
        (here, there): (&[DVec3; N], &[DVec3; N]),
        rule: &[[f64; 3]; N],
    ) -> f64 {
        let mut sum = 0.0;
        for (p, [.., v]) in here.iter().zip(rule) {
            for (q, [.., w]) in there.iter().zip(rule) {
                let between = *q - *p;
                let squared = between.length_squared();
                let cosines = -self.normal.dot(between) * other.normal.dot(between);
                sum += v * w * cosines / (squared * squared);
            }
        }
        // Where one lies in the plane of the other all of it is rounding.
        (FRAC_1_PI * self.area * other.area * sum).max(0.0)
    }

    fn is_in_plane_of(&self, other: &Self) -> bool {
        let flat = 1e-12 + 1e-9 * self.radius.min(other.radius);
        self.corners.iter().all(|p| other.normal.dot(*p - other.centre).abs() < flat)
    }

    fn by_contours(&self, other: &Self) -> f64 {
        let edges = |corners: &[DVec3; 3]| [0, 1, 2].map(|k| [corners[k], corners[(k + 1) % 3]]);
        let mut sum = 0.0;
        for [a, b] in edges(&self.corners) {
            for [c, d] in edges(&other.corners) {
                let along = (b - a).normalize().dot((d - c).normalize());
                if along.abs() > 1e-15 {
                    sum += along * mean_logarithm([a, b], [c, d], HALVINGS);
                }
            }
        }
        (sum / TAU).max(0.0)
    }
}

/// ∫∫ ln r ds ds′ over two edges.
fn mean_logarithm([a, b]: [DVec3; 2], edge: [DVec3; 2], halvings: u32) -> f64 {
    let length = a.distance(b);
    let middle = 0.5 * (a + b);
    // Halve where a kink is near.
    let near = edge.iter().any(|&end| distance_to(end, [a, b]) < length);
    let beside = !near && distance_to(middle, edge) < length && !is_on_line(a, b, edge);
    if (near || beside) && halvings > 0 {
        return mean_logarithm([a, middle], edge, halvings - 1)
            + mean_logarithm([middle, b], edge, halvings - 1);
    }
    let half = 0.5 * (b - a);
    let at = |[x, w]: [f64; 2]| w * (logarithm(middle - half * x, edge) + logarithm(middle + half * x, edge));
    0.5 * length * EIGHT.map(at).iter().sum::<f64>()
}

/// Whether both points lie on the line through an edge, on which the integrand is smooth between its ends.
fn is_on_line(a: DVec3, b: DVec3, [c, d]: [DVec3; 2]) -> bool {
    let along = (d - c).normalize();
    [a, b].iter().all(|p| (*p - c).cross(along).length() < 1e-12)
}

fn distance_to(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    p.distance(a + along * t)
}

/// ∫ ln r ds over an edge, seen from a point.
fn logarithm(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let length = a.distance(b);
    let along = (b - a) / length;
    let start = (a - p).dot(along);
    let height = (a - p).cross(along).length();
    // The integral of ½ ln(h² + u²).
    let upto = |u: f64| {
        let squared = height * height + u * u;
        if squared == 0.0 { 0.0 } else { 0.5 * u * squared.ln() - u + height * u.atan2(height) }
    };
    upto(start + length) - upto(start)
}

/// The exact exchange areas of an empty convex scene. What fronts do not send to each other escapes through
/// its gaps; backs see nothing.
///
/// # Errors
/// `Cancelled`.
pub fn exact(
    tracer: &Tracer,
    patches: &Patches,
    enclosure: Enclosure,
    progress: Progress,
) -> Result<Exchange, Cancelled> {
    let n = patches.len();
    let areas = patches.normalised_areas();
    let polygon = |i: usize| {
        let slot = patches.slot_of_patch(i);
        let front = patches.place(i).side == Side::Front;
        front.then(|| Polygon::new(&patches.facet(tracer, slot), areas[i]))
    };
    let polygons: Vec<Option<Polygon>> = (0..n).map(polygon).collect();
    let mut matrix = DMatrix::<f32>::zeros(n, n);
    for (chunk, columns) in matrix.as_mut_slice().chunks_mut(CHUNK * n).enumerate() {
        // A column has as many entries as columns come before it.
        progress.at("trace", ((chunk * CHUNK) as f64 / n as f64).powi(2))?;
        columns.par_chunks_mut(n).enumerate().for_each(|(k, column)| {
            let i = chunk * CHUNK + k;
            let Some(here) = &polygons[i] else { return };
            for (there, entry) in polygons[..i].iter().zip(column) {
                *entry = there.as_ref().map_or(0.0, |there| here.exchange_area(there)) as f32;
            }
        });
    }
    for j in 0..n {
        for i in 0..j {
            matrix[(j, i)] = matrix[(i, j)];
        }
    }
    let escape = DVector::from_fn(n, |i, _| {
        let sent: f64 = matrix.column(i).iter().map(|&s| f64::from(s)).sum();
        match (&polygons[i], enclosure) {
            (Some(_), Enclosure::Closed) => 0.0,
            _ => (areas[i] - sent).max(0.0),
        }
    });
    progress.at("balance", 0.0)?;
    let mass = Mass::of(Basis::Constant, patches);
    Exchange::of_known(Storage::Dense(matrix), escape, mass, progress)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// A rectangle as two triangles, counter-clockwise seen from its front.
    fn rectangle(face: u32, [a, b, c, d]: [[f64; 3]; 4]) -> [Polygon; 2] {
        [[a, b, c], [a, c, d]].map(|corners| {
            let corners = corners.map(DVec3::from);
            let normal = triangle::normal(&corners);
            let facet = Facet { face, corners, normal, coat: None, side: Side::Front };
            Polygon::new(&facet, triangle::area(&corners))
        })
    }

    fn exchange_area(one: &[Polygon; 2], other: &[Polygon; 2]) -> f64 {
        one.iter().flat_map(|p| other.iter().map(|q| p.exchange_area(q))).sum()
    }

    /// Howell C-11: aligned parallel rectangles of sides x and y times their distance.
    fn parallel(x: f64, y: f64) -> f64 {
        let [p, q] = [x, y].map(|side| (1.0 + side * side).sqrt());
        let logarithm = (p * q / (1.0 + x * x + y * y).sqrt()).ln();
        let arctans = x * q * (x / q).atan() + y * p * (y / p).atan() - x * x.atan() - y * y.atan();
        2.0 / (PI * x * y) * (logarithm + arctans)
    }

    /// Howell C-14: rectangles at a right angle with a common edge; h and w are the sides of the second and
    /// the first by that edge.
    fn perpendicular(h: f64, w: f64) -> f64 {
        let (hh, ww) = (h * h, w * w);
        let both = hh + ww;
        let product = (1.0 + ww) * (1.0 + hh) / (1.0 + both)
            * (ww * (1.0 + both) / ((1.0 + ww) * both)).powf(ww)
            * (hh * (1.0 + both) / ((1.0 + hh) * both)).powf(hh);
        let arctans = w * (1.0 / w).atan() + h * (1.0 / h).atan() - both.sqrt() * (1.0 / both.sqrt()).atan();
        (arctans + 0.25 * product.ln()) / (PI * w)
    }

    #[test]
    fn parallel_rectangles_have_their_closed_form() {
        for (x, y) in [(1.0, 1.0), (0.05, 0.08), (0.3, 2.0), (10.0, 7.0), (50.0, 50.0)] {
            let low = rectangle(0, [[0.0, 0.0, 0.0], [x, 0.0, 0.0], [x, y, 0.0], [0.0, y, 0.0]]);
            let high = rectangle(1, [[0.0, 0.0, 1.0], [0.0, y, 1.0], [x, y, 1.0], [x, 0.0, 1.0]]);
            let off = exchange_area(&low, &high) / (x * y) / parallel(x, y) - 1.0;
            assert!(off.abs() < 1e-7, "{x} {y}: {off}");
        }
    }

    #[test]
    fn perpendicular_rectangles_with_a_common_edge_have_their_closed_form() {
        for (h, w) in [(1.0, 1.0), (0.1, 0.2), (3.0, 0.5), (0.02, 5.0)] {
            let floor = rectangle(0, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, w, 0.0], [0.0, w, 0.0]]);
            let wall = rectangle(1, [[0.0, 0.0, 0.0], [0.0, 0.0, h], [1.0, 0.0, h], [1.0, 0.0, 0.0]]);
            let off = exchange_area(&floor, &wall) / w / perpendicular(h, w) - 1.0;
            assert!(off.abs() < 1e-7, "{h} {w}: {off}");
        }
    }

    #[test]
    fn rules_agree_with_contours_where_they_take_over() {
        // Two triangles at every angle, just as far apart as each rule needs.
        for k in 0..64 {
            let turn = f64::from(k) * TAU / 64.0;
            let corner = |angle: f64| DVec3::new(angle.cos(), 1.4 * angle.sin(), 0.0);
            let corners = [0.1, 2.0, 4.5].map(|angle| corner(angle + turn));
            let low = Polygon::new(
                &Facet { face: 0, corners, normal: DVec3::Z, coat: None, side: Side::Front },
                triangle::area(&corners),
            );
            for factor in [1.01 * SIX_DO, 1.01 * THREE_DO] {
                let away = DVec3::new(turn.sin(), 0.3, 1.0).normalize() * factor * 2.0 * low.radius;
                let up = low.centre + away;
                let other = [0, 2, 1].map(|k: usize| up + (corners[k] - low.centre));
                let high = Polygon::new(
                    &Facet { face: 1, corners: other, normal: -DVec3::Z, coat: None, side: Side::Front },
                    low.area,
                );
                let off = low.exchange_area(&high) / low.by_contours(&high) - 1.0;
                assert!(off.abs() < 3e-6, "{factor} {k}: {off}");
            }
        }
    }
}
