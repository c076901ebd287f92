//! Lights: lights without area and the sky, as seen from points of the scene.
//!
//! A *beam* is a direction from which a light may reach a point, drawn at random where the light has many;
//! what it brings is known once a shadow ray has told whether anything stands in its way.

use glam::DVec3;

use super::sky::{SkySampler, SkyView};
use crate::scene::Light;
use crate::scene::triangle;
use crate::trace::sampling::{frame_around, uniform_disc, uniform_spherical_triangle, uniform_triangle};
use crate::trace::solid_angle::solid_angle;
use crate::trace::{IN_PLANE, Interaction, Through, Tracer};

/// A triangle that fills more than this, sr, seen from a light over it by less than this part of the root of
/// its area, is lit so unevenly that points of it are drawn by solid angle.
const NEAR_ANGLE: f64 = 0.05;
const NEAR_HEIGHT: f64 = 0.05;

/// No point of a triangle is farther from a light near it, normalised lengths.
const FARTHEST: f64 = 8.0;

/// The lights without area of a scene, and its sky.
#[derive(Clone, Debug)]
pub struct Lights {
    lamps: Vec<Source>,
    sky: Option<SkySampler>,
}

/// One light, in the normalised frame.
#[derive(Clone, Debug)]
struct Source {
    light: Light,
    place: Place,
    /// Irradiance at unit density and share, per channel, W·m⁻².
    power: Vec<f64>,
}

/// Where a light is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    /// Here.
    At(DVec3),
    /// Infinitely far in this direction, within a disc whose radius has this sine.
    Towards(DVec3, f64),
}

/// Where light arrives, and how the sky is looked for from there, as [`Lights::sky_over`] has it.
pub(crate) struct Arrival<'a> {
    pub place: Interaction<'a>,
    pub sky: Option<&'a SkyView>,
}

/// A way on which light may reach a point.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// Towards the light, a unit vector.
    pub direction: DVec3,
    /// How far the light is, normalised; infinite for the sun.
    pub distance: f64,
    /// Irradiance that faces it, as a part of the light's power, by geometry alone: r⁻² for lights that have
    /// a place, 1 on average for the sun.
    pub density: f64,
    /// The share of the light's power that it sends this way.
    pub share: f64,
}

impl Lights {
    /// The lights of a scene; none where it has none, so that nothing is spent on them.
    pub fn new(tracer: &Tracer) -> Option<Self> {
        let frame = tracer.frame();
        let source = |light: &Light| {
            let (place, unit) = match *light {
                Light::Point { position, .. }
                | Light::Spot { position, .. }
                | Light::Ies { position, .. } => {
                    (Place::At(frame.from_world(position)), frame.scale().powi(-2))
                }
                Light::Sun { direction, diameter, .. } => {
                    (Place::Towards(-direction, (0.5 * diameter).to_radians().sin()), 1.0)
                }
            };
            Source { light: light.clone(), place, power: light.power().iter().map(|x| x * unit).collect() }
        };
        let scene = tracer.scene();
        let lamps: Vec<Source> = scene.lights().map(source).collect();
        let sky = scene.sky().map(SkySampler::new);
        (!lamps.is_empty() || sky.is_some()).then_some(Self { lamps, sky })
    }

    /// Number of lights, the sky not counted.
    pub fn len(&self) -> usize {
        self.lamps.len()
    }

    /// Whether there is nothing but sky.
    pub fn is_empty(&self) -> bool {
        self.lamps.is_empty()
    }

    /// The sky.
    pub fn sky(&self) -> Option<&SkySampler> {
        self.sky.as_ref()
    }

    /// Irradiance that a light causes at unit density and share, per channel.
    pub fn power(&self, light: usize) -> &[f64] {
        &self.lamps[light].power
    }

    /// A light, and where it is in the normalised frame.
    pub(crate) fn light(&self, light: usize) -> (&Light, Place) {
        let source = &self.lamps[light];
        (&source.light, source.place)
    }

    /// Whether a light is a sun, which has no place.
    pub fn is_sun(&self, light: usize) -> bool {
        matches!(self.lamps[light].place, Place::Towards(..))
    }

    /// A beam from a light to a point, by two random numbers.
    #[inline]
    pub fn beam(&self, light: usize, point: DVec3, random: [f64; 2]) -> Beam {
        let Source { light, place, .. } = &self.lamps[light];
        match *place {
            Place::At(position) => {
                let between = position - point;
                let distance = between.length();
                let direction = between / distance;
                let density = distance.powi(-2);
                Beam { direction, distance, density, share: light.share_towards(-direction) }
            }
            Place::Towards(middle, 0.0) => {
                Beam { direction: middle, distance: f64::INFINITY, density: 1.0, share: 1.0 }
            }
            // A disc of even radiance sends the same through each part of its projection on the plane that
            // faces it.
            Place::Towards(middle, sine) => {
                let [x, y] = uniform_disc(random).map(|x| x * sine);
                let height = (1.0 - x * x - y * y).max(0.0).sqrt();
                let direction = frame_around(middle) * DVec3::new(x, y, height);
                Beam { direction, distance: f64::INFINITY, density: 1.0 / height, share: 1.0 }
            }
        }
    }

    /// The mean over a triangle of density · cos θ of a light's beams, where that is known without sampling:
    /// for a light with a place the solid angle that the triangle fills, per area; for the sun the cosine,
    /// where all of it is above the horizon.
    pub fn mean_density(&self, light: usize, corners: &[DVec3; 3], normal: DVec3) -> Option<f64> {
        match self.lamps[light].place {
            Place::At(position) if normal.dot(position - corners[0]) <= IN_PLANE => Some(0.0),
            Place::At(position) => Some(solid_angle(position, corners) / triangle::area(corners)),
            Place::Towards(middle, sine) => {
                let cosine = normal.dot(middle);
                match sine {
                    _ if cosine <= IN_PLANE - sine => Some(0.0),
                    _ if cosine >= sine => Some(cosine),
                    _ => None,
                }
            }
        }
    }

    /// Whether a triangle of this [`Lights::mean_density`] is so near a light that its points are drawn by
    /// [`Lights::point_near`].
    pub fn is_near(&self, light: usize, corners: &[DVec3; 3], normal: DVec3, mean: f64) -> bool {
        let Place::At(position) = self.lamps[light].place else { return false };
        let (a, area) = (corners[0], triangle::area(corners));
        mean * area > NEAR_ANGLE && normal.dot(position - a).powi(2) < NEAR_HEIGHT * NEAR_HEIGHT * area
    }

    /// A point of a triangle, as weights of its second and third corner, uniform in solid angle seen from a
    /// light with a place. It must stand over the triangle's plane.
    pub fn point_near(
        &self,
        light: usize,
        corners: &[DVec3; 3],
        normal: DVec3,
        square: [f64; 2],
    ) -> [f64; 2] {
        let Place::At(position) = self.lamps[light].place else { return uniform_triangle(square) };
        let [a, b, c] = *corners;
        let foot = position - normal * normal.dot(position - a);
        // Over the triangle, divide it at the foot: three narrow parts are drawn from exactly where one of
        // half a sphere is not.
        let parts = [[foot, a, b], [foot, b, c], [foot, c, a]];
        let angles = parts.map(|part| solid_angle(position, &part));
        let whole: f64 = angles.iter().sum();
        let [mut u, v] = square;
        let mut drawn = *corners;
        if whole <= solid_angle(position, corners) * (1.0 + 1e-9) {
            u *= whole;
            let mut part = 0;
            while part < 2 && u >= angles[part] {
                u -= angles[part];
                part += 1;
            }
            (u, drawn) = ((u / angles[part]).clamp(0.0, 1.0), parts[part]);
        }
        let towards = drawn.map(|corner| (corner - position).normalize_or_zero());
        let direction = uniform_spherical_triangle(towards, [u, v]);
        // Where it meets the plane, within the triangle but for rounding.
        let slope = -normal.dot(direction);
        let distance = if slope > 0.0 { (normal.dot(position - a) / slope).min(FARTHEST) } else { 0.0 };
        let drawn = position + direction * distance;
        let point = if drawn.is_finite() { drawn } else { foot };
        let across = triangle::across(corners);
        let weight = |p: DVec3, q: DVec3| (p.cross(q).dot(across) / across.length_squared()).clamp(0.0, 1.0);
        let s = weight(point - a, c - a);
        [s, weight(b - a, point - a).min(1.0 - s)]
    }

    /// The sky as it is looked for from a flat surface with these corners, or this one point, and this
    /// normal.
    pub fn sky_over(&self, tracer: &Tracer, corners: &[DVec3], normal: DVec3) -> Option<SkyView> {
        self.sky.as_ref().map(|_| SkyView::over(tracer.apertures(), corners, normal))
    }

    /// The apertures through which a sun may reach a triangle with this normal.
    pub fn sun_through<'a>(
        &self,
        light: usize,
        tracer: &'a Tracer,
        corners: &[DVec3; 3],
        normal: DVec3,
    ) -> Through<'a> {
        match self.lamps[light].place {
            Place::At(_) => Through::default(),
            Place::Towards(axis, sine) => tracer.apertures().through((axis, sine), corners, normal),
        }
    }

    /// Adds to `irradiance` (per channel, W·m⁻²) what reaches a point of a face's side, by one beam from each
    /// light and one from the sky; unbiased. `random` gives numbers for each; `scratch` has a value a
    /// channel.
    pub(crate) fn add_irradiance(
        &self,
        tracer: &Tracer,
        Arrival { place, sky }: &Arrival,
        mut random: impl FnMut() -> [f64; 2],
        [irradiance, scratch]: [&mut [f64]; 2],
    ) {
        let normal = place.normal;
        for light in 0..self.len() {
            let beam = self.beam(light, place.point, random());
            let cosine = normal.dot(beam.direction);
            let weight = beam.density * beam.share * cosine * place.weight(cosine);
            scratch.fill(1.0);
            let is_above = cosine * beam.distance.min(1.0) > IN_PLANE;
            if is_above
                && weight > 0.0
                && weight.is_finite()
                && tracer.passes(&place.ray(beam.direction), beam.distance, scratch)
            {
                let powers = self.power(light).iter().zip(&*scratch);
                irradiance
                    .iter_mut()
                    .zip(powers)
                    .for_each(|(sum, (power, part))| *sum += weight * power * part);
            }
        }
        if let (Some(view), Some(sky)) = (sky, &self.sky) {
            let beam = view.sample(sky, place.point, random());
            scratch.fill(1.0);
            if beam.weight > 0.0 && tracer.passes(&place.ray(beam.direction), f64::INFINITY, scratch) {
                let weight = beam.weight * place.weight(normal.dot(beam.direction));
                let zenith = sky.zenith().iter().zip(&*scratch).enumerate();
                let sums = irradiance.iter_mut().zip(zenith);
                sums.for_each(|(sum, (c, (zenith, part)))| *sum += weight * beam.tint(c) * zenith * part);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::scene::{Material, Scene, SceneParts};
    use crate::trace::sampling::{Stream, uniform_triangle};

    fn scene(lights: Vec<Light>) -> Scene {
        let corners = [[-2.0, 0.0, -2.0], [0.0, 0.0, 2.0], [2.0, 0.0, -2.0]];
        Scene::new(SceneParts {
            name: "ground".into(),
            vertices: corners.map(DVec3::from).to_vec(),
            faces: vec![crate::scene::Face {
                vertices: [0, 1, 2],
                normals: None,
                material: 0,
                object: 0,
                state: crate::scene::FaceState::Kept,
            }],
            materials: vec![Material::diffuse("ground", &[0.5])],
            objects: vec!["ground".into()],
            lights,
            ..Default::default()
        })
        .unwrap()
    }

    /// The mean over points of a triangle, and over its beams, of density · cos θ.
    fn sampled(lights: &Lights, light: usize, corners: &[DVec3; 3], normal: DVec3) -> f64 {
        let n = 1 << 15;
        let one = |k: u32| {
            let [s, t, u, v] = Stream::Callers.sequence(2, light as u32, 0).point(k);
            let [s, t] = uniform_triangle([s, t]);
            let beam = lights.beam(light, triangle::point(corners, [s, t]), [u, v]);
            beam.density * normal.dot(beam.direction).max(0.0) / f64::from(n)
        };
        (0..n).map(one).sum()
    }

    #[test]
    fn beams_have_the_density_that_is_known_without_them() {
        let sun = |direction: DVec3, diameter: f64| Light::Sun {
            direction: direction.normalize(),
            irradiance: vec![1.0],
            diameter,
        };
        let scene = scene(vec![
            Light::Point { position: DVec3::new(0.4, 1.0, 0.3), intensity: vec![1.0] },
            Light::Point { position: DVec3::new(5.0, 0.4, 0.3), intensity: vec![1.0] },
            sun(DVec3::new(0.2, -1.0, 0.1), 0.0),
            sun(DVec3::new(0.2, -1.0, 0.1), 60.0),
            sun(DVec3::new(0.2, 1.0, 0.1), 60.0),
            Light::Point { position: DVec3::new(0.4, -1.0, 0.3), intensity: vec![1.0] },
        ]);
        let tracer = Tracer::new(&scene);
        let lights = Lights::new(&tracer).unwrap();
        let corners = tracer.corners(0);
        for light in 0..lights.len() {
            let exact = lights.mean_density(light, corners, DVec3::Y).unwrap();
            let found = sampled(&lights, light, corners, DVec3::Y);
            assert!((found - exact).abs() <= 2e-4 * exact, "{light}: {found} {exact}");
        }
    }

    #[test]
    fn a_rising_sun_lights_as_much_as_its_disc_says() {
        // The disc's middle is on the horizon.
        let diameter = 40.0f64;
        let light = Light::Sun { direction: DVec3::X, irradiance: vec![1.0], diameter };
        let scene = scene(vec![light]);
        let tracer = Tracer::new(&scene);
        let lights = Lights::new(&tracer).unwrap();
        assert_eq!(lights.mean_density(0, tracer.corners(0), DVec3::Y), None);
        let found = sampled(&lights, 0, tracer.corners(0), DVec3::Y);
        // ∫ over the upper half of the disc of sin γ sin φ dω, with dω = sin γ dγ dφ, over its projection π
        // sin²α.
        let alpha = 0.5 * diameter.to_radians();
        let exact = (alpha - alpha.sin() * alpha.cos()) / (PI * alpha.sin().powi(2));
        assert!((found / exact - 1.0).abs() < 1e-3, "{found} {exact}");
    }
}
