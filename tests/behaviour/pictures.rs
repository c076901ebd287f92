//! Pictures: other ways to look at one scene agree, and those of nothing are black.

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::measure::Undershoot;
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::render::{self, Picture, RenderOptions, Shading};
use radiosity::scene::{Camera, Material, Scene};
use radiosity::solve;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions, Transport};

use crate::scenes::{cut, cut_into, flipped, quads, room};

const SHADINGS: [Shading; 4] = [Shading::Flat, Shading::Smooth, Shading::Gather, Shading::Path];

/// What an ordinary room comes out within.
const ACCURACY: f64 = 0.01;

/// Mean of each channel over all pixels that show no lamp in either of two pictures.
fn means(pictures: [&Picture; 2]) -> [[f64; 3]; 2] {
    let [a, b] = pictures;
    let beside_lamps: Vec<usize> =
        (0..a.pixels.len()).filter(|&k| a.lamps[k].share == 0.0 && b.lamps[k].share == 0.0).collect();
    let mean = |p: &Picture, c: usize| {
        beside_lamps.iter().map(|&k| f64::from(p.pixels[k][c])).sum::<f64>() / beside_lamps.len() as f64
    };
    [a, b].map(|p| [0, 1, 2].map(|c| mean(p, c)))
}

#[test]
fn gathered_light_agrees_with_the_patches_and_with_light_paths() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let mut patches = cut_into(&tracer, 4000);
    let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap();
    let k = Transport::of(&factors, &patches).unwrap();
    let radiance =
        solve::direct(&k, &Default::default()).unwrap().solve(&patches.emitted_radiance()).radiance;
    let camera = scene.camera().copied().unwrap();
    let seen = |shading: Shading, seed: u64| {
        let options =
            RenderOptions { width: 64, height: 48, shading, samples: 64, seed, ..Default::default() };
        render::picture(&tracer, &patches, &radiance, &camera, &options).unwrap()
    };
    let gathered = seen(Shading::Gather, 0);
    for other in [Shading::Flat, Shading::Path] {
        let [ours, theirs] = means([&gathered, &seen(other, 1)]);
        for (a, b) in ours.iter().zip(theirs) {
            assert!((a / b - 1.0).abs() < ACCURACY, "{other:?}: {ours:?} {theirs:?}");
        }
    }
}

/// Patches for a scene and its radiance by coefficients, and how far that falls below zero.
fn solved<'s>(tracer: &Tracer<'s>, count: usize, basis: Basis) -> (Patches<'s>, DMatrix<f64>, Undershoot) {
    let mut patches = cut_into(tracer, count);
    let factors =
        FormFactors::trace(tracer, &mut patches, &TraceOptions { basis, ..Default::default() }).unwrap();
    let k = Transport::of(&factors, &patches).unwrap();
    let e = basis.coefficients_of(&patches.emitted_radiance());
    let radiance = solve::conjugate_gradients(&k, &e, &Default::default()).unwrap().radiance;
    let undershoot = Undershoot::of(k.mass(), &radiance);
    (patches, radiance, undershoot)
}

#[test]
fn linear_elements_look_more_like_light_paths_than_as_many_constant_ones() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let camera = scene.camera().copied().unwrap();
    let options = RenderOptions { width: 64, height: 48, samples: 256, ..Default::default() };
    let [constant, linear] = [Basis::Constant, Basis::Linear].map(|basis| solved(&tracer, 300, basis));
    let seen = |(patches, radiance, _): &(Patches, DMatrix<f64>, Undershoot), shading: Shading| {
        let options = RenderOptions { shading, ..options };
        render::picture(&tracer, patches, radiance, &camera, &options).unwrap()
    };
    let paths = seen(&constant, Shading::Path);
    let apart = |picture: Picture| {
        let pairs = picture.pixels.iter().zip(&paths.pixels).zip(&paths.lamps);
        let beside_lamps =
            pairs.filter(|(_, lamp)| lamp.share == 0.0).flat_map(|((a, b), _)| a.iter().zip(b));
        beside_lamps.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
    };
    for shading in [Shading::Flat, Shading::Smooth] {
        let [constant, linear] = [&constant, &linear].map(|solution| apart(seen(solution, shading)));
        println!("{shading:?}: {constant} constant, {linear} linear");
        assert!(linear < 0.75 * constant, "{shading:?}: {constant} constant, {linear} linear");
    }
}

#[test]
fn where_linear_elements_fall_below_zero_pictures_are_dark_but_not_black() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let camera = Camera { fov: 24.0, ..scene.camera().copied().unwrap() };
    let (patches, radiance, undershoot) = solved(&tracer, 300, Basis::Linear);
    assert!(undershoot.share > 0.01 && undershoot.depth > 1e-3, "{undershoot:?}");
    for (shading, factor) in SHADINGS.into_iter().flat_map(|s| [(s, 1.0), (s, 0.5)]) {
        let options = RenderOptions { width: 160, height: 120, shading, samples: 2, ..Default::default() };
        // Half of the light is less than lamps emit.
        let picture = render::picture(&tracer, &patches, &(&radiance * factor), &camera, &options).unwrap();
        let pixels = || picture.pixels.iter().flatten();
        assert!(pixels().all(|&x| x.is_finite() && x >= 0.0), "{shading:?} {factor}");
        if matches!(shading, Shading::Flat | Shading::Smooth) {
            assert!(pixels().all(|&x| x > 0.0), "{shading:?} {factor}");
        }
    }
}

#[derive(PartialEq)]
enum Seen {
    Nothing,
    Light,
}

/// A lit room with a closed box in the middle, which no light enters.
fn room_with_a_closed_box() -> Scene {
    let inside = room([0.0; 3], [3.0; 3]).map(|wall| (wall, 0));
    let closed = room([1.0; 3], [2.0; 3]).map(|wall| (flipped(wall), 1));
    let materials = vec![Material::lamp("wall", &[0.5], &[1.0]), Material::diffuse("box", &[0.5])];
    quads(&[inside, closed].concat(), materials)
}

#[test]
fn pictures_of_nothing_lit_are_black_and_all_others_are_finite() {
    let scene = room_with_a_closed_box();
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.6));
    let look = |position: [f64; 3], target: [f64; 3], expected: Seen| {
        let camera = Camera { position: position.into(), target: target.into(), up: DVec3::Y, fov: 90.0 };
        for (shading, [width, height]) in SHADINGS.into_iter().flat_map(|s| [(s, [1, 1]), (s, [7, 5])]) {
            let options = RenderOptions { width, height, shading, samples: 4, ..Default::default() };
            let picture =
                render::picture(&tracer, &patches, &patches.emitted_radiance(), &camera, &options).unwrap();
            assert_eq!(picture.is_black(), expected == Seen::Nothing, "{shading:?} from {position:?}");
            assert!(picture.pixels.iter().flatten().all(|x| x.is_finite()), "{shading:?} from {position:?}");
        }
    };
    // Within the box; outside everything and looking away. Then in the room, in its wall, and in its corner.
    look([1.5; 3], [1.5, 1.5, 2.0], Seen::Nothing);
    look([9.0, 1.0, 1.0], [10.0, 1.0, 1.0], Seen::Nothing);
    look([0.5; 3], [2.9, 0.5, 0.5], Seen::Light);
    look([0.0, 0.5, 0.5], [2.9, 0.5, 0.5], Seen::Light);
    look([0.0; 3], [2.9, 2.9, 0.5], Seen::Light);
}
