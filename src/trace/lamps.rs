//! Lamps: where to look for light, seen from a given place.
//!
//! Points are drawn on the brightest emitting faces, each face chosen by what it would contribute if nothing stood in
//! between, and the point uniform on it. What they would contribute in all is known exactly, by Lambert's formula.

use std::f64::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::DVec3;

use super::sampling::uniform_triangle;
use super::{IN_PLANE, Tracer, can_face};
use crate::scene::{FaceState, Side};

/// Lamps are the brightest faces that together give this share of the emitted power...
const POWER_SHARE: f64 = 0.95;

/// ...unless they cover more than this share of all surfaces: then rays find them well enough.
const MOST_AREA: f64 = 0.25;

/// With more lamp faces than this, what they would contribute is estimated and not integrated...
const MOST_EXACT: usize = 256;

/// ...and with more than this, chances go by power alone.
const MOST_PLACED: usize = 2000;

/// The faces that give most of a scene's light.
#[derive(Clone, Debug)]
pub struct Lamps {
    faces: Vec<LampFace>,
    /// Per face of the scene: its place in `faces`, or `NONE`.
    lamp_of_face: Vec<u32>,
    /// Cumulative chances by power alone.
    by_power: Arc<[f64]>,
}

const NONE: u32 = u32::MAX;

#[derive(Clone, Debug)]
struct LampFace {
    face: u32,
    corners: [DVec3; 3],
    normal: DVec3,
    area: f64,
    /// Emitted radiance, averaged over channels and the face.
    brightness: f64,
}

/// The lamps as a small surface sees them.
#[derive(Clone, Debug, Default)]
pub struct LampView {
    /// How likely each lamp is to be drawn: cumulative, ending with 1; all zero where no lamp is above the horizon.
    chances: Arc<[f64]>,
    /// What lamps would contribute if nothing stood in between: Σ F·Lₑ over lamps with brightness Lₑ; where it is known.
    pub unoccluded: Option<f64>,
}

/// A point on a lamp.
#[derive(Clone, Copy, Debug)]
pub struct LampPoint {
    /// The face it lies on.
    pub face: u32,
    /// Where, normalised frame.
    pub point: DVec3,
    /// Where, as weights of the face's second and third corner.
    pub barycentrics: [f64; 2],
    /// The face's normal.
    pub normal: DVec3,
    /// Density with which it was drawn, per unit of normalised area.
    pub pdf: f64,
    /// The face's brightness: emitted radiance averaged over channels.
    pub brightness: f64,
}

impl Lamps {
    /// Chooses the lamps of a scene; there may be none.
    pub fn new(tracer: &Tracer) -> Self {
        let scene = tracer.scene();
        let kept = |f: &u32| scene.faces()[*f as usize].state == FaceState::Kept;
        let total_area: f64 = (0..scene.faces().len() as u32).filter(kept).map(|f| area(tracer, f)).sum();
        let mut faces = emitting(tracer);
        // Keep the brightest, and equally bright ones with them.
        faces.sort_by(|a, b| b.brightness.total_cmp(&a.brightness));
        let total_power: f64 = faces.iter().map(|l| l.brightness * l.area).sum();
        let mut power = 0.0;
        let mut last = f64::INFINITY;
        faces.retain(|l| {
            let keep = power < POWER_SHARE * total_power || l.brightness == last;
            power += l.brightness * l.area;
            last = if keep { l.brightness } else { last };
            keep
        });
        if faces.iter().map(|l| l.area).sum::<f64>() > MOST_AREA * total_area {
            faces.clear();
        }
        faces.sort_by_key(|l| l.face);
        Self::of(tracer, faces)
    }

    /// Every face that emits, however dim or large, for where there are no rays to find the rest.
    pub fn all(tracer: &Tracer) -> Self {
        Self::of(tracer, emitting(tracer))
    }

    fn of(tracer: &Tracer, faces: Vec<LampFace>) -> Self {
        let mut lamp_of_face = vec![NONE; tracer.scene().faces().len()];
        for (k, lamp) in faces.iter().enumerate() {
            lamp_of_face[lamp.face as usize] = k as u32;
        }
        let by_power = accumulate(faces.iter().map(|l| l.brightness * l.area));
        Self { faces, lamp_of_face, by_power }
    }

    /// The lamps of a scene; none where no rays are to be sent to them.
    pub fn of_interest(tracer: &Tracer, rays: u32) -> Self {
        if rays > 0 { Self::new(tracer) } else { Self::none(tracer) }
    }

    fn none(tracer: &Tracer) -> Self {
        let lamp_of_face = vec![NONE; tracer.scene().faces().len()];
        Self { faces: Vec::new(), lamp_of_face, by_power: Arc::default() }
    }

    /// The lamps' face numbers, ascending.
    pub fn faces(&self) -> impl Iterator<Item = u32> {
        self.faces.iter().map(|lamp| lamp.face)
    }

    /// Number of lamp faces.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Whether a face's side is a lamp.
    #[inline]
    pub fn contains(&self, face: usize, side: Side) -> bool {
        side == Side::Front && self.lamp_of_face[face] != NONE
    }

    /// How lamps look from a flat surface with these corners and this normal, on average over points with these parts of it. For a
    /// single point it is its own corner.
    pub fn view_from(&self, corners: &[DVec3], normal: DVec3, points: &[(DVec3, f64)]) -> LampView {
        if self.faces.len() > MOST_PLACED {
            return LampView { chances: self.by_power.clone(), unoccluded: None };
        }
        let faces = |lamp: &LampFace| can_face((corners, normal), (&lamp.corners, lamp.normal));
        let centre = points.iter().map(|&(point, part)| part * point).sum();
        if self.faces.len() > MOST_EXACT {
            let chance = |lamp: &LampFace| if faces(lamp) { lamp.estimate(centre, normal) } else { 0.0 };
            let chances = accumulate(self.faces.iter().map(chance));
            return LampView { chances, unoccluded: None };
        }
        let mut unoccluded = 0.0;
        let chances = accumulate(self.faces.iter().map(|lamp| {
            if !faces(lamp) {
                return 0.0;
            }
            let from = |&(p, part): &(DVec3, f64)| part * form_factor_to_triangle(p, normal, &lamp.corners);
            let contribution = lamp.brightness * points.iter().map(from).sum::<f64>();
            unoccluded += contribution;
            // Leave some chance to what other points of the surface may see.
            contribution + 0.05 * lamp.estimate(centre, normal)
        }));
        LampView { chances, unoccluded: Some(unoccluded) }
    }

    /// A point drawn on a lamp; none where no lamp is above the horizon.
    #[inline]
    pub fn sample(
        &self,
        LampView { chances: cumulative, .. }: &LampView,
        [u, v]: [f64; 2],
    ) -> Option<LampPoint> {
        if cumulative.last().is_none_or(|&total| total == 0.0) {
            return None;
        }
        let k = cumulative.partition_point(|&upper| upper <= u).min(self.faces.len() - 1);
        let (lower, upper) = bounds(cumulative, k);
        let lamp = &self.faces[k];
        let [a, b, c] = lamp.corners;
        let barycentrics = uniform_triangle([((u - lower) / (upper - lower)).clamp(0.0, 1.0), v]);
        Some(LampPoint {
            face: lamp.face,
            point: a + (b - a) * barycentrics[0] + (c - a) * barycentrics[1],
            barycentrics,
            normal: lamp.normal,
            pdf: (upper - lower) / lamp.area,
            brightness: lamp.brightness,
        })
    }

    /// Density with which [`Lamps::sample`] draws a point of a face, per unit of normalised area; 0 if the face is no lamp.
    #[inline]
    pub fn pdf(&self, LampView { chances: cumulative, .. }: &LampView, face: usize) -> f64 {
        match self.lamp_of_face[face] {
            NONE => 0.0,
            k => {
                let (lower, upper) = bounds(cumulative, k as usize);
                (upper - lower) / self.faces[k as usize].area
            }
        }
    }
}

/// All faces that emit, by number.
fn emitting(tracer: &Tracer) -> Vec<LampFace> {
    let scene = tracer.scene();
    let emits = |&f: &u32| {
        scene.faces()[f as usize].state == FaceState::Kept && scene.material_of(f as usize).emits()
    };
    let lamp = |face: u32| {
        let emission = scene.mean_emission(face as usize);
        LampFace {
            face,
            corners: *tracer.corners(face as usize),
            normal: tracer.normal(face as usize, Side::Front),
            area: area(tracer, face),
            brightness: emission.iter().sum::<f64>() / emission.len() as f64,
        }
    };
    (0..scene.faces().len() as u32).filter(emits).map(lamp).collect()
}

fn area(tracer: &Tracer, face: u32) -> f64 {
    let [a, b, c] = tracer.corners(face as usize);
    0.5 * (b - a).cross(c - a).length()
}

impl LampFace {
    /// What the face may contribute at a point with a normal, roughly, and more rather than less.
    fn estimate(&self, point: DVec3, normal: DVec3) -> f64 {
        // A surface's parts see a little below its centre's horizon, and a lamp's parts see a little beside it.
        const MARGIN: f64 = 0.05;
        let [a, b, c] = self.corners;
        let looks = [a, b, c, (a + b + c) / 3.0].map(|q| {
            let to_lamp = q - point;
            // Near the lamp what counts is its size.
            let squared = to_lamp.length_squared() + 0.1 * self.area;
            let distance = squared.sqrt();
            let here = (normal.dot(to_lamp) / distance + MARGIN).max(0.0);
            let there = (MARGIN - self.normal.dot(to_lamp) / distance).max(0.0);
            here * there / squared
        });
        self.brightness * self.area * FRAC_1_PI * 0.25 * looks.iter().sum::<f64>()
    }
}

/// Form factor from a point with a normal to the front of a triangle, where nothing stands in between: Lambert's formula
/// (1760), (1/2π) Σ θ_k n·Γ_k over the edges of what is above the horizon. 0 where the triangle can't be faced, see [`can_face`].
pub fn form_factor_to_triangle(point: DVec3, normal: DVec3, corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let across = (b - a).cross(c - a);
    let is_above = |corner: DVec3| normal.dot(corner) > IN_PLANE;
    if -across.dot(a) <= IN_PLANE * across.length() || ![a, b, c].into_iter().any(is_above) {
        return 0.0;
    }
    // Clip at the horizon: at most four corners remain.
    let mut seen = [DVec3::ZERO; 4];
    let mut count = 0;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let (high, next) = (normal.dot(from), normal.dot(to));
        if high > 0.0 {
            seen[count] = from;
            count += 1;
        }
        if (high > 0.0) != (next > 0.0) {
            seen[count] = from + (to - from) * (high / (high - next));
            count += 1;
        }
    }
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

/// cos θ cos θ′ / (π r²) between two points with their normals: the form factor per unit of area there; 0 where they can't face each
/// other, see [`can_face`].
#[inline]
pub fn geometry_term((p, normal): (DVec3, DVec3), (q, other): (DVec3, DVec3)) -> f64 {
    let between = q - p;
    let squared = between.length_squared();
    let (here, there) = (normal.dot(between), -other.dot(between));
    // The products are the heights of either point over the other's plane.
    if here.min(there) <= IN_PLANE { 0.0 } else { here * there * FRAC_1_PI / (squared * squared) }
}

fn bounds(cumulative: &[f64], k: usize) -> (f64, f64) {
    (if k == 0 { 0.0 } else { cumulative[k - 1] }, cumulative[k])
}

/// Running sums, scaled to end with 1; all zero if there is nothing to sum.
fn accumulate(weights: impl Iterator<Item = f64>) -> Arc<[f64]> {
    let mut total = 0.0;
    let mut sums: Vec<f64> = weights
        .map(|w| {
            total += w;
            total
        })
        .collect();
    if total > 0.0 {
        sums.iter_mut().for_each(|s| *s /= total);
    }
    sums.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::trace::sampling::Sequence;

    #[test]
    fn points_are_drawn_with_their_density() {
        let scene = Scene::cornell_box();
        let tracer = Tracer::new(&scene);
        let lamps = Lamps::new(&tracer);
        for (p, normal) in [(DVec3::new(0.3, -0.9, 0.2), DVec3::Y), (DVec3::new(-0.9, 0.7, 0.1), DVec3::X)] {
            let view = lamps.view_from(&[p], normal, &[(p, 1.0)]);
            let n = 1 << 14;
            let sampled: f64 = (0..n)
                .map(|k| {
                    let [u, v, ..] = Sequence::new(5, 0, 0).point(k);
                    let drawn = lamps.sample(&view, [u, v]).unwrap();
                    assert_eq!(lamps.pdf(&view, drawn.face as usize), drawn.pdf);
                    let g = geometry_term((p, normal), (drawn.point, drawn.normal));
                    drawn.brightness * g / drawn.pdf / n as f64
                })
                .sum();
            let exact = view.unoccluded.unwrap();
            assert!((sampled / exact - 1.0).abs() < 2e-3, "{sampled} {exact}");
        }
    }

    #[test]
    fn lamberts_formula_is_the_integral_of_the_geometry_term() {
        let n = 1 << 14;
        for place in 0..40 {
            let random = |k: u32| Sequence::new(8, place, 0).point(k).map(|x| 2.0 * x - 1.0);
            let corners = [0, 1, 2].map(|k| DVec3::from_slice(&random(k)) + 1.2 * DVec3::Z);
            let [a, b, c] = corners;
            let area = 0.5 * (b - a).cross(c - a).length();
            let [x, y, z, _] = random(3);
            let normal = DVec3::new(x, y, z).normalize();
            let facing = (b - a).cross(c - a).normalize();
            let integral: f64 = (0..n)
                .map(|k| {
                    let [u, v, ..] = Sequence::new(6, place, 0).point(k);
                    let [s, t] = uniform_triangle([u, v]);
                    let q = a + (b - a) * s + (c - a) * t;
                    geometry_term((DVec3::ZERO, normal), (q, facing)) * area / n as f64
                })
                .sum();
            let exact = form_factor_to_triangle(DVec3::ZERO, normal, &corners);
            assert!((integral - exact).abs() < 1e-3 * (0.1 + exact), "{place}: {integral} {exact}");
        }
    }

    #[test]
    fn where_everything_emits_nothing_is_a_lamp() {
        let folder = env!("CARGO_MANIFEST_DIR");
        let scene = Scene::load(format!("{folder}/meshes/furnace_cube.obj")).unwrap();
        assert!(Lamps::new(&Tracer::new(&scene)).is_empty());
    }
}
