//! Lamps: where to look for light, seen from a given place.
//!
//! Points are drawn on the brightest emitting faces, each face chosen by what it would contribute if nothing
//! stood in between, and the point uniform on it. What they would contribute in all is known exactly, by
//! Lambert's formula.

use glam::DVec3;

use crate::scene::{FaceState, Side, triangle};
use crate::trace::sampling::{Discrete, uniform_triangle};
use crate::trace::{Tracer, can_face, form_factor_between, form_factor_estimate, form_factor_to_triangle};

/// Lamps are the brightest faces that together give this share of the emitted power...
const POWER_SHARE: f64 = 0.95;

/// ...unless they cover more than this share of all surfaces: then rays find them well enough.
const MOST_AREA: f64 = 0.25;

/// With more lamp faces than this, what those would contribute that are not near is estimated and not
/// integrated...
const MOST_EXACT: usize = 256;

/// ...and with more than this, chances go by power alone.
const MOST_PLACED: usize = 2000;

/// What is nearer to a surface than so many times its radius can't be told from its centre.
const NEAR: f64 = 3.0;

/// The part of a lamp's estimate that is added to its exact contribution, as chances go; a pure number.
/// Chosen, not fitted: it leaves some chance to what other points of the surface may see.
const LEAST_CHANCE: f64 = 0.05;

/// The faces that give most of a scene's light.
#[derive(Clone, Debug)]
pub struct Lamps {
    faces: Vec<LampFace>,
    /// Per face of the scene: its place in `faces`, or `NONE`.
    lamp_of_face: Vec<u32>,
    /// Chances by power alone.
    by_power: Discrete,
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
    /// How likely each lamp is to be drawn; all zero where no lamp is above the horizon.
    chances: Discrete,
    /// What lamps would contribute if nothing stood in between: Σ F·Lₑ over lamps with brightness Lₑ; where
    /// it is known.
    pub unoccluded: Option<f64>,
}

/// A point on a lamp.
#[derive(Clone, Copy, Debug)]
pub struct LampPoint {
    /// Which lamp, as they were given or in the order of faces.
    pub lamp: usize,
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

    /// Parts of faces as lamps: per part its face and side, its corners and its radiance, averaged over
    /// channels. They are drawn as lamps are, with corners wound as their side is seen; [`Lamps::contains`]
    /// and [`Lamps::pdf`] know nothing of them.
    pub fn of_parts(tracer: &Tracer, parts: impl Iterator<Item = ((usize, Side), [DVec3; 3], f64)>) -> Self {
        let lamp = |((face, side), corners, brightness): ((usize, Side), [DVec3; 3], f64)| {
            let [a, b, c] = corners;
            let corners = if side == Side::Back { [a, c, b] } else { corners };
            let (normal, area) = (tracer.normal(face, side), triangle::area(&corners));
            LampFace { face: face as u32, corners, normal, area, brightness }
        };
        let faces: Vec<LampFace> = parts.map(lamp).collect();
        let by_power = Discrete::new(faces.iter().map(|l| l.brightness * l.area)).normalised();
        Self { faces, by_power, ..Self::none(tracer) }
    }

    fn of(tracer: &Tracer, faces: Vec<LampFace>) -> Self {
        let mut lamp_of_face = vec![NONE; tracer.scene().faces().len()];
        for (k, lamp) in faces.iter().enumerate() {
            lamp_of_face[lamp.face as usize] = k as u32;
        }
        let by_power = Discrete::new(faces.iter().map(|l| l.brightness * l.area)).normalised();
        Self { faces, lamp_of_face, by_power }
    }

    /// The lamps of a scene; none where no rays are to be sent to them.
    pub fn of_interest(tracer: &Tracer, rays: u32) -> Self {
        if rays > 0 { Self::new(tracer) } else { Self::none(tracer) }
    }

    fn none(tracer: &Tracer) -> Self {
        let lamp_of_face = vec![NONE; tracer.scene().faces().len()];
        Self { faces: Vec::new(), lamp_of_face, by_power: Discrete::default() }
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

    /// How lamps look from a point of a flat surface with these corners and this normal.
    pub fn view_from(&self, point: DVec3, (corners, normal): (&[DVec3], DVec3)) -> LampView {
        let from_here = |lamp: &LampFace| form_factor_to_triangle(point, normal, &lamp.corners);
        self.view(point, (corners, normal), from_here)
    }

    /// How lamps look from a triangle with this normal, on average.
    pub fn view_over(&self, corners: &[DVec3; 3], normal: DVec3) -> LampView {
        let centre = corners.iter().sum::<DVec3>() / 3.0;
        let from_all = |lamp: &LampFace| form_factor_between((corners, normal), (&lamp.corners, lamp.normal));
        self.view(centre, (corners, normal), from_all)
    }

    fn view(
        &self,
        centre: DVec3,
        (corners, normal): (&[DVec3], DVec3),
        form_factor: impl Fn(&LampFace) -> f64,
    ) -> LampView {
        if self.faces.len() > MOST_PLACED {
            return LampView { chances: self.by_power.clone(), unoccluded: None };
        }
        let faces = |lamp: &LampFace| can_face((corners, normal), (&lamp.corners, lamp.normal));
        let is_exact = self.faces.len() <= MOST_EXACT;
        let reach = NEAR * corners.iter().map(|corner| corner.distance(centre)).fold(0.0, f64::max);
        let is_near = |lamp: &LampFace| lamp.corners.iter().any(|corner| corner.distance(centre) < reach);
        let mut unoccluded = 0.0;
        let chance = |lamp: &LampFace| {
            if !faces(lamp) {
                return 0.0;
            }
            let estimate = lamp.estimate(centre, normal);
            if !is_exact && !is_near(lamp) {
                return estimate;
            }
            let contribution = lamp.brightness * form_factor(lamp);
            unoccluded += contribution;
            contribution + LEAST_CHANCE * estimate
        };
        let chances = Discrete::new(self.faces.iter().map(chance)).normalised();
        LampView { chances, unoccluded: is_exact.then_some(unoccluded) }
    }

    /// A point drawn on a lamp; none where no lamp is above the horizon.
    #[inline]
    pub fn sample(&self, view: &LampView, [u, v]: [f64; 2]) -> Option<LampPoint> {
        if view.chances.total() == 0.0 {
            return None;
        }
        let (k, fresh) = view.chances.draw(u);
        let lamp = &self.faces[k];
        let barycentrics = uniform_triangle([fresh, v]);
        Some(LampPoint {
            lamp: k,
            face: lamp.face,
            point: triangle::point(&lamp.corners, barycentrics),
            barycentrics,
            normal: lamp.normal,
            pdf: view.chances.weight(k) / lamp.area,
            brightness: lamp.brightness,
        })
    }

    /// Density with which [`Lamps::sample`] draws a point of a face, per unit of normalised area; 0 if the
    /// face is no lamp.
    #[inline]
    pub fn pdf(&self, view: &LampView, face: usize) -> f64 {
        match self.lamp_of_face[face] {
            NONE => 0.0,
            k => view.chances.weight(k as usize) / self.faces[k as usize].area,
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
    triangle::area(tracer.corners(face as usize))
}

impl LampFace {
    /// What the face may contribute at a point with a normal, roughly, and more rather than less.
    fn estimate(&self, point: DVec3, normal: DVec3) -> f64 {
        self.brightness * form_factor_estimate((point, normal), (&self.corners, self.normal, self.area))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::trace::geometry_term;
    use crate::trace::sampling::Stream;

    #[test]
    fn points_are_drawn_with_their_density() {
        let scene = Scene::cornell_box();
        let tracer = Tracer::new(&scene);
        let lamps = Lamps::new(&tracer);
        for (p, normal) in [(DVec3::new(0.3, -0.9, 0.2), DVec3::Y), (DVec3::new(-0.9, 0.7, 0.1), DVec3::X)] {
            let view = lamps.view_from(p, (&[p], normal));
            let n = 1 << 14;
            let sampled: f64 = (0..n)
                .map(|k| {
                    let [u, v, ..] = Stream::Callers.sequence(5, 0, 0).point(k);
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
    fn where_everything_emits_nothing_is_a_lamp() {
        let folder = env!("CARGO_MANIFEST_DIR");
        let scene = Scene::load(format!("{folder}/meshes/furnace_cube.obj")).unwrap();
        assert!(Lamps::new(&Tracer::new(&scene)).is_empty());
    }
}
