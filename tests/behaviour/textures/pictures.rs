//! Renderings show the texture in full, however large patches are.

use glam::{DVec2, DVec3};
use nalgebra::DMatrix;
use radiosity::patches::{Basis, PatchSize};
use radiosity::render::{self, Picture, RenderOptions, Shading, Surfaces};
use radiosity::scene::Camera;
use radiosity::trace::Tracer;

use super::{case, gallery};
use crate::scenes::cut;

/// The floor from above.
fn from_above() -> Camera {
    Camera { position: DVec3::new(1.9, 1.3, 1.9), target: DVec3::new(0.9, 0.0, 0.9), up: DVec3::Y, fov: 50.0 }
}

/// Relative root mean square difference of two pictures beside lamps.
fn apart(a: &Picture, b: &Picture) -> f64 {
    let (mut squares, mut whole) = (0.0, 0.0);
    for (k, (p, q)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        if a.lamps[k].share == 0.0 {
            for c in 0..3 {
                squares += f64::from(p[c] - q[c]).powi(2);
                whole += f64::from(q[c]).powi(2);
            }
        }
    }
    (squares / whole).sqrt()
}

#[test]
fn every_way_of_shading_shows_the_picture_under_the_light() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    let mut truth = None;
    for basis in [Basis::Constant, Basis::Linear] {
        // Patches are larger than what the picture shows.
        let case = case(&tracer, 250, basis);
        let radiance = case.solve().radiance;
        let seen = |shading: Shading, surfaces: Surfaces, samples: u32| {
            let options =
                RenderOptions { width: 64, height: 48, shading, surfaces, samples, ..Default::default() };
            render::picture(&tracer, &case.patches, &radiance, &from_above(), &options).unwrap()
        };
        let paths = truth.get_or_insert_with(|| seen(Shading::Path, Surfaces::Textured, 512));
        let averaged = apart(&seen(Shading::Flat, Surfaces::Averaged, 1), paths);
        assert!(averaged > 0.15, "{averaged}: the picture shows");
        for (shading, most) in [(Shading::Flat, 0.1), (Shading::Smooth, 0.1), (Shading::Gather, 0.05)] {
            let textured = apart(&seen(shading, Surfaces::Textured, 256), paths);
            assert!(textured < most, "{basis:?} {shading:?}: {textured}, averaged {averaged}");
        }
    }
}

#[test]
fn even_light_on_a_picture_shows_the_picture() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.5));
    // Under H = π everywhere, L = Lₑ + ρ.
    let radiance: DMatrix<f64> = patches.emitted_radiance() + patches.reflectances();
    let camera = Camera {
        position: DVec3::new(1.0, 1.0, 1.0),
        target: DVec3::new(1.0, 0.0, 1.0001),
        up: DVec3::Z,
        fov: 20.0,
    };
    for shading in [Shading::Flat, Shading::Smooth] {
        let options = RenderOptions { width: 40, height: 40, shading, ..Default::default() };
        let picture = render::picture(&tracer, &patches, &radiance, &camera, &options).unwrap();
        // The middle of the floor: compare with the picture there, by hand.
        let hit_colour = picture.pixels[20 * 40 + 20];
        let texture = scene.material_of(2).textures.reflectance.clone().unwrap();
        let place = |face: usize| {
            let [a, b, c] = scene.corners(face).map(|p| DVec2::new(p.x, p.z));
            let w = glam::DMat2::from_cols(b - a, c - a).inverse() * (DVec2::new(1.0, 1.0) - a);
            [w.x, w.y]
        };
        let exact = scene.reflectance_texture(2).unwrap().at(place(2));
        assert_eq!(exact, texture.at(DVec2::splat(0.5)));
        for c in 0..3 {
            assert!(
                (f64::from(hit_colour[c]) - 0.9 * exact[c]).abs() < 0.06,
                "{shading:?} {hit_colour:?} {exact:?}"
            );
        }
    }
}
