//! Where carried light shows: at receivers, in pictures, and nowhere without carriers.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::patches::{Basis, PatchSize};
use radiosity::render::{self, RenderOptions, Shading};
use radiosity::scene::{Camera, Material, Receiver, SkyKind};
use radiosity::trace::Tracer;
use radiosity::transport::{LightOptions, Plan, Received};

use super::trace;
use crate::scenes::{cut, grey, lit_quads, point, sky, square, sun};

#[test]
fn scenes_without_anything_that_carries_light_have_none_carried() {
    let scene = lit_quads(&[(square(0.0, 1.0), 0)], grey(0.5), vec![point([0.0, 1.0, 0.0], &[1.0])], None);
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(8));
    assert_eq!(trace(&tracer, &patches, Basis::Constant, 64).carried, None);
    let caustics = Plan::new(&scene).effects.into_iter().find(|effect| effect.effect == "caustics").unwrap();
    assert!(!caustics.on);
}

#[test]
fn receivers_get_what_mirrors_send_them() {
    let down = DVec3::new(1.0, -1.0, 0.0).normalize();
    let receiver = |corner: [f64; 3], edges: [[f64; 3]; 2]| {
        Receiver::grid("grid", corner.into(), edges.map(DVec3::from), [4, 2])
    };
    // It looks down at a mirror from within the beam; a second one is above it and looks up.
    let facing = receiver([-0.1, 0.5, -0.1], [[0.2, 0.0, 0.0], [0.0, 0.0, 0.2]]);
    assert_eq!(facing.normal(), -DVec3::Y);
    let averted = receiver([-0.1, 0.5, -0.1], [[0.0, 0.0, 0.2], [0.2, 0.0, 0.0]]);
    let scene = lit_quads(
        &[(square(0.0, 2.0), 0), (square(5.0, 0.1), 1)],
        vec![Material::mirror("mirror", &[0.8]), Material::diffuse("far", &[0.5])],
        vec![sun(down.to_array(), 100.0, 0.0)],
        Some(sky(SkyKind::Constant, 3.0)),
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(2));
    let options = LightOptions { rays: 4096, ..Default::default() };
    let dark = DMatrix::zeros(patches.len(), 1);
    let found = |receiver: &Receiver| {
        Received::trace(&tracer, &patches, &dark, receiver, &options).unwrap().irradiance
    };
    // A little sky passes beside the mirror, straight, and a little is hidden.
    let exact = 0.8 * 100.0 * (0.5f64).sqrt() + 0.8 * 3.0 * PI;
    let below = found(&facing);
    for h in below.iter() {
        assert!((h / exact - 1.0).abs() < 0.1, "{h} {exact}");
    }
    assert!((below.mean() / exact - 1.0).abs() < 0.02, "{below} {exact}");
    let above = found(&averted).mean();
    let exact = 100.0 * (0.5f64).sqrt() + 3.0 * PI;
    assert!((above / exact - 1.0).abs() < 0.01, "{above} {exact}");
}

#[test]
fn gathered_pictures_show_light_off_mirrors_as_solved_ones_do() {
    let wall = [[2.0, 0.0, -2.0], [2.0, 0.0, 2.0], [2.0, 4.0, 2.0], [2.0, 4.0, -2.0]];
    let scene = lit_quads(
        &[(wall, 0), (square(0.0, 0.25), 1)],
        vec![Material::diffuse("wall", &[0.5]), Material::mirror("mirror", &[0.9])],
        vec![sun([1.0, -1.0, 0.0], 100.0, 0.0)],
        None,
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.05));
    let sources = trace(&tracer, &patches, Basis::Constant, 64);
    let radiance = sources.direct.as_ref().unwrap() * (0.5 / PI);
    let camera = Camera {
        position: DVec3::new(-1.0, 2.0, 0.0),
        target: DVec3::new(2.0, 2.0, 0.0),
        up: DVec3::Y,
        fov: 20.0,
    };
    let carried = sources.carried.as_ref().map(|light| &light.irradiance);
    let mean = |shading: Shading, carried| {
        let options =
            RenderOptions { width: 60, height: 60, shading, carried, samples: 8, ..Default::default() };
        let picture = render::picture(&tracer, &patches, &radiance, &camera, &options).unwrap();
        picture.pixels.iter().map(|rgb| f64::from(rgb[0])).sum::<f64>()
    };
    let [solved, gathered] = [mean(Shading::Smooth, None), mean(Shading::Gather, carried)];
    assert!((gathered / solved - 1.0).abs() < 0.02, "{gathered} {solved}");
    assert!(mean(Shading::Gather, None) < 0.9 * solved);
}
