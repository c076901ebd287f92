//! Openings: light that comes in through little.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::scene::{Face, FaceState, Light, Material, Scene, SceneParts, Sky, SkyKind};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, Sources, TraceOptions};

/// Numbers in [0, 1) that are always the same.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// How the wall around an opening is divided.
#[derive(Clone, Copy, Debug)]
enum Wall {
    /// Strips, whose corners lie on other strips' edges.
    Strips,
    /// Four trapezoids from the wall's corners to those of the opening.
    Trapezoids,
}

/// A black room of this size, fronts inward, with an opening of this place and size in its top; turned.
fn room(size: DVec3, [x, z, w, d]: [f64; 4], wall: Wall, turn: DMat3) -> Vec<[DVec3; 4]> {
    let DVec3 { x: a, y: h, z: b } = size;
    let p = DVec3::new;
    let top = |x: f64, z: f64| p(x, h, z);
    let mut quads = vec![
        [p(0.0, 0.0, 0.0), p(0.0, 0.0, b), p(a, 0.0, b), p(a, 0.0, 0.0)],
        [p(0.0, 0.0, 0.0), p(a, 0.0, 0.0), p(a, h, 0.0), p(0.0, h, 0.0)],
        [p(0.0, 0.0, b), p(0.0, h, b), p(a, h, b), p(a, 0.0, b)],
        [p(0.0, 0.0, 0.0), p(0.0, h, 0.0), p(0.0, h, b), p(0.0, 0.0, b)],
        [p(a, 0.0, 0.0), p(a, 0.0, b), p(a, h, b), p(a, h, 0.0)],
    ];
    let strip = |x0: f64, x1: f64, z0: f64, z1: f64| [top(x0, z0), top(x1, z0), top(x1, z1), top(x0, z1)];
    match wall {
        Wall::Strips => quads.extend([
            strip(0.0, x, 0.0, b),
            strip(x + w, a, 0.0, b),
            strip(x, x + w, 0.0, z),
            strip(x, x + w, z + d, b),
        ]),
        Wall::Trapezoids => {
            let outer = [top(0.0, 0.0), top(a, 0.0), top(a, b), top(0.0, b)];
            let inner = [top(x, z), top(x + w, z), top(x + w, z + d), top(x, z + d)];
            quads.extend((0..4).map(|k| {
                let next = (k + 1) % 4;
                [outer[k], outer[next], inner[next], inner[k]]
            }));
        }
    }
    quads.into_iter().map(|quad| quad.map(|p| turn * p)).collect()
}

fn black(quads: &[[DVec3; 4]], lights: Vec<Light>, sky: Option<Sky>) -> Scene {
    of_reflectance(0.0, quads, lights, sky)
}

fn of_reflectance(reflectance: f64, quads: &[[DVec3; 4]], lights: Vec<Light>, sky: Option<Sky>) -> Scene {
    let mut parts = SceneParts {
        name: "room".into(),
        materials: vec![Material::diffuse("wall", &[reflectance])],
        objects: vec!["room".into()],
        lights,
        sky,
        ..Default::default()
    };
    for quad in quads {
        let first = parts.vertices.len() as u32;
        parts.vertices.extend(quad);
        for k in [1, 2] {
            let vertices = [first, first + k, first + k + 1];
            parts.faces.push(Face {
                vertices,
                normals: None,
                material: 0,
                object: 0,
                state: FaceState::Kept,
            });
        }
    }
    Scene::new(parts).unwrap()
}

/// The flux that lights without area bring to the fronts of all faces.
fn flux_inside(scene: &Scene) -> f64 {
    let tracer = Tracer::new(scene);
    let options = Tessellation { size: PatchSize::Count(600), ..Default::default() };
    let patches = Patches::new(&tracer, &options).unwrap();
    let options = LightOptions::default();
    let direct = Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap().direct.unwrap();
    let is_front = |&i: &usize| patches.place(i).side == radiosity::scene::Side::Front;
    (0..patches.len()).filter(is_front).map(|i| patches.area(i) * direct[i]).sum()
}

/// A random black room with an opening, turned: its quadrilaterals, the opening's width and depth, the way
/// in, and what it is.
fn random_room(k: usize, numbers: &mut Numbers) -> (Vec<[DVec3; 4]>, [f64; 2], DVec3, String) {
    let size = DVec3::new(numbers.between(3.0, 8.0), numbers.between(2.5, 4.0), numbers.between(3.0, 8.0));
    let [w, d] = [(); 2].map(|()| numbers.between(0.05f64.ln(), 2.8f64.ln()).exp());
    let x = numbers.between(0.02, size.x - w - 0.02);
    let z = numbers.between(0.02, size.z - d - 0.02);
    let [around, over] = [(); 2].map(|()| numbers.between(0.0, 6.0));
    let turn = DMat3::from_rotation_y(around) * DMat3::from_rotation_x(over);
    let wall = if k.is_multiple_of(2) { Wall::Strips } else { Wall::Trapezoids };
    let told = format!("{wall:?} {w:.3} x {d:.3} at {x:.2} {z:.2} of {size:.2}");
    (room(size, [x, z, w, d], wall, turn), [w, d], turn * DVec3::NEG_Y, told)
}

/// Rooms whose openings are looked through; a number. Two hundred pass as well.
const ROOMS: usize = 24;

#[test]
fn what_sky_sends_through_a_small_opening_lands_inside() {
    let mut numbers = Numbers(7);
    for k in 0..ROOMS {
        let (quads, [w, d], _, told) = random_room(k, &mut numbers);
        let sky = Sky { kind: SkyKind::Constant, up: DVec3::Y, zenith: vec![1.0], ground: 0.0 };
        let flux = flux_inside(&black(&quads, Vec::new(), Some(sky)));
        assert!((flux / (PI * w * d) - 1.0).abs() < 0.005, "{told}: {flux} {}", PI * w * d);
    }
}

#[test]
fn what_sun_sends_through_a_small_opening_lands_inside() {
    let mut numbers = Numbers(7);
    for k in 0..ROOMS {
        let (quads, [w, d], inwards, told) = random_room(k, &mut numbers);
        let direction = (inwards + 0.8 * inwards.any_orthonormal_vector()).normalize();
        let diameter = if k % 3 == 0 { 0.53 } else { 0.0 };
        let sun = Light::Sun { direction, irradiance: vec![100.0], diameter };
        let flux = flux_inside(&black(&quads, vec![sun], None));
        let exact = 100.0 * direction.dot(inwards) * w * d;
        assert!((flux / exact - 1.0).abs() < 0.005, "{told}: {flux} {exact}");
    }
}

#[test]
fn what_an_even_sky_brings_is_what_form_factors_let_out() {
    let mut numbers = Numbers(11);
    let (mut squares, mut count) = (0.0, 0);
    for k in 0..8 {
        let (quads, _, _, told) = random_room(k, &mut numbers);
        let sky = Sky { kind: SkyKind::Constant, up: DVec3::Y, zenith: vec![1.0], ground: 0.0 };
        let scene = of_reflectance(0.5, &quads, Vec::new(), Some(sky));
        let tracer = Tracer::new(&scene);
        let options = Tessellation { size: PatchSize::Count(400), ..Default::default() };
        let mut patches = Patches::new(&tracer, &options).unwrap();
        let rays = 1024;
        let options = TraceOptions { rays: Some(rays), ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let options = LightOptions { rays: 1024, ..Default::default() };
        let direct = Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap().direct.unwrap();
        // H₀ = π L F_i∞ with L = 1; rays that leave by chance are counted.
        let (mut out, mut all, mut variance) = (0.0, 0.0, 0.0);
        for i in 0..patches.len() {
            let (area, exact) = (patches.area(i), direct[i] / PI);
            let counted = factors.exchange().escape(i);
            let by_chance = area * area * exact * (1.0 - exact).max(0.0) / f64::from(rays);
            out += counted;
            all += area * exact;
            variance += by_chance;
            if exact > 0.01 && exact < 0.99 {
                squares += (counted - area * exact).powi(2) / by_chance;
                count += 1;
            }
        }
        assert!((out - all).abs() < 4.0 * variance.sqrt() + 1e-3 * all, "{told}: {out} {all}");
    }
    // Stratified rays scatter less than by chance alone.
    let rms = (squares / f64::from(count)).sqrt();
    assert!(count > 30 && rms > 0.5 && rms < 1.0, "{count} patches, {rms} standard errors");
}
