//! Unoccluded form factors: what two surfaces exchange where nothing stands in between, by Lambert's formula
//! (1760).

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::IN_PLANE;
use super::facing::can_face;
use super::sampling::{TRIANGLE_RULE_3, TRIANGLE_RULE_7};
use crate::scene::distance_to;
use crate::scene::triangle;

/// Parts whose radius is less than this part of their distance need few points: then they are off by less
/// than 10⁻⁴ (the tests measure it).
const SMALL: f64 = 1.0 / 16.0;

/// Parts whose radius is more than this part of their distance are split in four...
const LARGE: f64 = 0.25;

/// ...at most so often: parts that touch the other surface would be split for ever.
const SPLITS: u32 = 5;

/// Form factor from a point with a normal to the front of a triangle, where nothing stands in between:
/// Lambert's formula (1760), (1/2π) Σ θ_k n·Γ_k over the edges of what is above the horizon. 0 where the
/// triangle can't be faced, see [`can_face`].
pub fn form_factor_to_triangle(point: DVec3, normal: DVec3, corners: &[DVec3; 3]) -> f64 {
    let corners = corners.map(|corner| corner - point);
    let across = triangle::across(&corners);
    let is_above = |corner: DVec3| normal.dot(corner) > IN_PLANE;
    if -across.dot(corners[0]) <= IN_PLANE * across.length() || !corners.into_iter().any(is_above) {
        return 0.0;
    }
    // Clip at the horizon: at most four corners remain.
    let (seen, count) = in_front(&corners, DVec3::ZERO, normal);
    let seen = &seen[..count];
    let edge = |k: usize| {
        let (from, to) = (seen[k], seen[(k + 1) % count]);
        let across = from.cross(to);
        let length = across.length();
        if length == 0.0 { 0.0 } else { length.atan2(from.dot(to)) * normal.dot(across) / length }
    };
    // Seen from the front, the corners run clockwise around the view.
    (-(0..count).map(edge).sum::<f64>() * 0.5 * FRAC_1_PI).max(0.0)
}

/// Form factor from one side of a triangle to one side of another, on average over the first, where nothing
/// stands in between: corners, in either order, and unit normals of the sides, normalised.
///
/// Lambert's formula is exact for points. It is averaged over the smaller of the two, by reciprocity: from
/// there the other looks much the same everywhere. Of the smaller one what is not in front of the other's
/// plane is cut off, and what is near is split.
pub fn form_factor_between(here: (&[DVec3; 3], DVec3), there: (&[DVec3; 3], DVec3)) -> f64 {
    if !can_face((here.0, here.1), (there.0, there.1)) {
        return 0.0;
    }
    let [area, other] = [here, there].map(|(corners, _)| triangle::area(corners));
    let ((small, normal), (large, facing)) = if other < area { (there, here) } else { (here, there) };
    let large = &wound_around(facing, *large);
    let (front, count) = in_front(small, large[0], facing);
    let flux: f64 =
        (2..count).map(|k| flux_between([front[0], front[k - 1], front[k]], normal, large, SPLITS)).sum();
    flux / area
}

/// The corners of a triangle in that order in which its front has this normal.
fn wound_around(normal: DVec3, [a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    if triangle::across(&[a, b, c]).dot(normal) < 0.0 { [a, c, b] } else { [a, b, c] }
}

/// The part of a triangle in front of the plane through a point with a unit normal, and its number of
/// corners.
#[inline]
fn in_front(corners: &[DVec3; 3], plane: DVec3, normal: DVec3) -> ([DVec3; 4], usize) {
    let mut kept = [DVec3::ZERO; 4];
    let mut count = 0;
    let height = |p: DVec3| normal.dot(p - plane);
    for k in 0..3 {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let (high, next) = (height(from), height(to));
        if high > 0.0 {
            kept[count] = from;
            count += 1;
        }
        if (high > 0.0) != (next > 0.0) {
            kept[count] = from + (to - from) * (high / (high - next));
            count += 1;
        }
    }
    (kept, count)
}

/// ∫ F dA over a part of the smaller triangle, with F the form factor from a point of it to the larger.
fn flux_between(part: [DVec3; 3], normal: DVec3, large: &[DVec3; 3], splits: u32) -> f64 {
    let [a, b, c] = part;
    let centre = (a + b + c) / 3.0;
    let radius = part.map(|corner| corner.distance(centre)).into_iter().fold(0.0, f64::max);
    let size = radius / distance_to(centre, large, f64::INFINITY);
    if size > LARGE && splits > 0 {
        let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
        let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]];
        return parts.into_iter().map(|part| flux_between(part, normal, large, splits - 1)).sum();
    }
    let rule = if size < SMALL { &TRIANGLE_RULE_3[..] } else { &TRIANGLE_RULE_7[..] };
    let from = |&(at, share): &([f64; 2], f64)| {
        share * form_factor_to_triangle(triangle::point(&part, at), normal, large)
    };
    triangle::area(&part) * rule.iter().map(from).sum::<f64>()
}

/// Cosine by which [`form_factor_estimate`] looks below horizons; a pure number. Chosen, not fitted: a
/// surface's parts see a little below its centre's horizon, and a triangle's parts see a little beside it.
const MARGIN: f64 = 0.05;

/// The part of a triangle's area that it adds to the square of its distance; a pure number. Chosen, not
/// fitted: near the triangle what counts is its size.
const SIZE: f64 = 0.1;

/// Form factor from a point with a normal to the front of a triangle with this normal and area, roughly, and
/// more rather than less: for chances, not for light.
#[inline]
pub fn form_factor_estimate(
    (point, normal): (DVec3, DVec3),
    (&[a, b, c], other, area): (&[DVec3; 3], DVec3, f64),
) -> f64 {
    let looks = [a, b, c, (a + b + c) / 3.0].map(|q| {
        let between = q - point;
        let squared = between.length_squared() + SIZE * area;
        let distance = squared.sqrt();
        let here = (normal.dot(between) / distance + MARGIN).max(0.0);
        let there = (MARGIN - other.dot(between) / distance).max(0.0);
        here * there / squared
    });
    area * FRAC_1_PI * 0.25 * looks.iter().sum::<f64>()
}

/// cos θ cos θ′ / (π r²) between two points with their normals: the form factor per unit of area there; 0
/// where they can't face each other, see [`can_face`].
#[inline]
pub fn geometry_term((p, normal): (DVec3, DVec3), (q, other): (DVec3, DVec3)) -> f64 {
    let between = q - p;
    let squared = between.length_squared();
    let (here, there) = (normal.dot(between), -other.dot(between));
    // The products are the heights of either point over the other's plane.
    if here.min(there) <= IN_PLANE { 0.0 } else { here * there * FRAC_1_PI / (squared * squared) }
}

#[cfg(test)]
mod tests {
    use super::super::sampling::{Stream, uniform_triangle};
    use super::*;

    #[test]
    fn lamberts_formula_is_the_integral_of_the_geometry_term() {
        let n = 1 << 14;
        for place in 0..40 {
            let random = |k: u32| Stream::Callers.sequence(8, place, 0).point(k).map(|x| 2.0 * x - 1.0);
            let corners = [0, 1, 2].map(|k| DVec3::from_slice(&random(k)) + 1.2 * DVec3::Z);
            let area = triangle::area(&corners);
            let [x, y, z, _] = random(3);
            let normal = DVec3::new(x, y, z).normalize();
            let facing = triangle::normal(&corners);
            let integral: f64 = (0..n)
                .map(|k| {
                    let [u, v, ..] = Stream::Callers.sequence(6, place, 0).point(k);
                    let q = triangle::point(&corners, uniform_triangle([u, v]));
                    geometry_term((DVec3::ZERO, normal), (q, facing)) * area / n as f64
                })
                .sum();
            let exact = form_factor_to_triangle(DVec3::ZERO, normal, &corners);
            assert!((integral - exact).abs() < 1e-3 * (0.1 + exact), "{place}: {integral} {exact}");
        }
    }

    /// Form factor between two unit squares, each of two triangles.
    fn between_squares(squares: [[DVec3; 4]; 2]) -> f64 {
        let halves = squares.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let to_all = |here: [DVec3; 3]| {
            let to = |there: &[DVec3; 3]| {
                form_factor_between((&here, triangle::normal(&here)), (there, triangle::normal(there)))
            };
            halves[1].iter().map(to).sum::<f64>()
        };
        0.5 * halves[0].into_iter().map(to_all).sum::<f64>()
    }

    #[test]
    fn unit_squares_have_their_known_form_factors() {
        let floor = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[x, y]| DVec3::new(x.into(), y.into(), 0.0));
        let [a, b, c, d] = floor.map(|p| p + DVec3::Z);
        // Opposite each other at a distance of 1, and at right angles along an edge (Howell, C-11 and C-14).
        let ceiling = [d, c, b, a];
        assert!((between_squares([floor, ceiling]) - 0.199_824_9).abs() < 1e-6);
        let wall = [floor[0], a, b, floor[1]];
        assert!((between_squares([floor, wall]) - 0.200_043_8).abs() < 1e-4);
    }

    #[test]
    fn the_parts_of_a_triangle_get_what_the_whole_gets() {
        let between = |here: &[DVec3; 3], there: &[DVec3; 3]| {
            form_factor_between((here, triangle::normal(here)), (there, triangle::normal(there)))
        };
        let parts = |[a, b, c]: [DVec3; 3]| {
            let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
        };
        let mut seen = 0;
        for place in 0..2000 {
            let random = |k: u32| {
                let [x, y, z, w] = Stream::Callers.sequence(8, place, 0).point(k).map(|x| 2.0 * x - 1.0);
                (DVec3::new(x, y, z), w)
            };
            // From far apart to piercing each other, of like size to a thousandth.
            let (size, off) = (10f64.powf(1.5 * random(7).1 - 1.5), 10f64.powf(1.5 * random(8).1 - 0.5));
            let large = [0, 1, 2].map(|k| random(k).0);
            let small = [3, 4, 5].map(|k| size * random(k).0 + off * random(6).0);
            let whole = between(&small, &large);
            let of_parts = parts(small).map(|part| 0.25 * between(&part, &large)).iter().sum::<f64>();
            let to_parts = parts(large).map(|part| between(&small, &part)).iter().sum::<f64>();
            seen += usize::from(whole > 1e-3);
            let allowed = 1e-4 * whole + 1e-4;
            assert!((of_parts - whole).abs() < allowed, "{place}: {whole} {of_parts}");
            assert!((to_parts - whole).abs() < allowed, "{place}: {whole} {to_parts}");
            // A back has its normal and no winding of its own.
            for (here, there) in [(small, large), (large, small)] {
                let [p, q, r] = there;
                let other_order = form_factor_between(
                    (&here, triangle::normal(&here)),
                    (&[p, r, q], triangle::normal(&there)),
                );
                let [p, q, r] = here;
                let own_order = form_factor_between(
                    (&[p, r, q], triangle::normal(&here)),
                    (&there, triangle::normal(&there)),
                );
                let known = between(&here, &there);
                assert!(
                    (other_order - known).abs() < allowed && (own_order - known).abs() < allowed,
                    "{place}"
                );
            }
        }
        assert!(seen > 200, "{seen}");
    }
}
