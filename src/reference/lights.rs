//! Lights: points on everything that emits, drawn by power; the path tracer's own way of looking for lamps.

use glam::DVec3;

use crate::scene::{FaceState, Side, triangle};
use crate::trace::Tracer;
use crate::trace::sampling::{Discrete, uniform_triangle};

/// All faces that emit.
#[derive(Debug)]
pub(super) struct Lights {
    faces: Vec<Light>,
    /// Chances of faces.
    chances: Discrete,
    /// Per face of the scene: density of its points per unit of normalised area; 0 for those that do not
    /// emit.
    density: Vec<f64>,
}

#[derive(Debug)]
struct Light {
    face: u32,
    corners: [DVec3; 3],
    normal: DVec3,
}

/// A point on a light.
pub(super) struct LightPoint {
    pub face: u32,
    pub point: DVec3,
    /// Weights of the face's second and third corner.
    pub barycentrics: [f64; 2],
    pub normal: DVec3,
    /// Density per unit of normalised area.
    pub density: f64,
}

impl Lights {
    pub fn new(tracer: &Tracer) -> Self {
        let scene = tracer.scene();
        let emits = |&f: &usize| scene.faces()[f].state == FaceState::Kept && scene.material_of(f).emits();
        let emitting: Vec<usize> = (0..scene.faces().len()).filter(emits).collect();
        let power = |f: usize| triangle::area(tracer.corners(f)) * scene.mean_emission(f).iter().sum::<f64>();
        let total: f64 = emitting.iter().map(|&f| power(f)).sum();
        let chances = Discrete::new(emitting.iter().map(|&f| power(f) / total));
        let mut density = vec![0.0; scene.faces().len()];
        for &f in &emitting {
            density[f] = power(f) / total / triangle::area(tracer.corners(f));
        }
        let light = |&f: &usize| Light {
            face: f as u32,
            corners: *tracer.corners(f),
            normal: tracer.normal(f, Side::Front),
        };
        Self { faces: emitting.iter().map(light).collect(), chances, density }
    }

    /// A point with density [`Lights::density`]; none where nothing emits.
    #[inline]
    pub fn sample(&self, [u, v]: [f64; 2]) -> Option<LightPoint> {
        if self.faces.is_empty() {
            return None;
        }
        let (k, fresh) = self.chances.draw_at(u);
        let light = &self.faces[k];
        let barycentrics = uniform_triangle([fresh, v]);
        Some(LightPoint {
            face: light.face,
            point: triangle::point(&light.corners, barycentrics),
            barycentrics,
            normal: light.normal,
            density: self.density[light.face as usize],
        })
    }

    /// Density of [`Lights::sample`] on a face, per unit of normalised area.
    #[inline]
    pub fn density(&self, face: u32) -> f64 {
        self.density[face as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::trace::sampling::Stream;

    #[test]
    fn points_are_drawn_with_their_density() {
        let folder = env!("CARGO_MANIFEST_DIR");
        let scene = Scene::load(format!("{folder}/meshes/two_rooms.obj")).unwrap();
        let tracer = Tracer::new(&scene);
        let lights = Lights::new(&tracer);
        let n = 1 << 14;
        let mut drawn = vec![0.0; scene.faces().len()];
        let mut centre = vec![DVec3::ZERO; scene.faces().len()];
        for k in 0..n {
            let [u, v, ..] = Stream::Callers.sequence(3, 0, 0).point(k);
            let light = lights.sample([u, v]).unwrap();
            // Each point stands for 1/(n·density) of area.
            let area = 1.0 / (n as f64 * light.density);
            drawn[light.face as usize] += area;
            centre[light.face as usize] += light.point * area;
            assert_eq!(light.density, lights.density(light.face));
        }
        for f in 0..scene.faces().len() {
            let area = triangle::area(tracer.corners(f));
            let emits = scene.material_of(f).emits();
            assert_eq!(drawn[f] > 0.0, emits);
            if emits {
                assert!((drawn[f] / area - 1.0).abs() < 2e-3);
                assert!((centre[f] / area - tracer.corners(f).iter().sum::<DVec3>() / 3.0).length() < 2e-3);
            }
        }
    }
}
