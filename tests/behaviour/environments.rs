//! Environments: skies from pictures against skies and suns of known light, the path tracer, pictures, and
//! what files say.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::measure::{Difference, Energy};
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::reference::{PathOptions, PathTracer};
use radiosity::render::{self, RenderOptions, Shading};
use radiosity::scene::{Camera, Environment, Light, Material, Pixels, Scene, Sky, SkyKind, luminance};
use radiosity::solve::Problem;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, Sources, TraceOptions};

use crate::picture_files::exr;
use crate::scenes::{cut, cut_into, lit_quads, paths, room};
use crate::scratch::Scratch;

/// Ground, and on it a block without a bottom.
fn yard() -> Vec<([[f64; 3]; 4], u32)> {
    let ground = [[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0]];
    let block = room([-0.4, 0.0, -0.4], [0.4, 1.0, 0.4]).map(|[a, b, c, d]| [a, d, c, b]);
    let upright = block.into_iter().enumerate().filter(|&(k, _)| k != 1).map(|(_, quad)| quad);
    std::iter::once(ground).chain(upright).map(|quad| (quad, 0)).collect()
}

fn environment(pixels: Pixels, up: DVec3, turn: f64, channels: usize) -> Sky {
    let kind = SkyKind::Environment(Arc::new(Environment::new(pixels, up, turn)));
    Sky { kind, up, zenith: vec![1.0; channels], ground: 0.0 }
}

fn under(sky: Option<Sky>, lights: Vec<Light>, reflectance: &[f64]) -> Scene {
    lit_quads(&yard(), vec![Material::diffuse("stone", reflectance)], lights, sky)
}

/// H₀ of faces, front sides first of all.
fn direct(scene: &Scene, basis: Basis, rays: u32) -> Vec<f64> {
    let tracer = Tracer::new(scene);
    let patches = cut(&tracer, PatchSize::Edge(0.25));
    let options = LightOptions { rays, ..Default::default() };
    let found = Sources::trace(&tracer, &patches, basis, &options).unwrap().direct.unwrap();
    patches.average_by_face(&basis.means(&found)).iter().map(|row| row.mean[0]).collect()
}

/// An even picture but for one texel.
fn one_bright(size: [usize; 2], texel: [usize; 2], bright: f32) -> Pixels {
    let at = |k: usize| if [k % size[0], k / size[0]] == texel { [bright; 3] } else { [0.0; 3] };
    Pixels::new(size[0], size[1], (0..size[0] * size[1]).map(at).collect())
}

#[test]
fn an_even_picture_is_a_constant_sky() {
    let even = environment(Pixels::new(8, 4, vec![[3.0; 3]; 32]), DVec3::Y, 0.0, 1);
    let constant = Sky { kind: SkyKind::Constant, up: DVec3::Y, zenith: vec![3.0], ground: 0.0 };
    let [even, constant] = [even, constant].map(|sky| under(Some(sky), vec![], &[0.5]));
    for basis in [Basis::Constant, Basis::Linear] {
        let [ours, theirs] = [&even, &constant].map(|scene| direct(scene, basis, 2048));
        assert_eq!(ours.len(), theirs.len());
        // The top of the block sees nothing but sky.
        let top = theirs.iter().position(|h| (h / (3.0 * PI) - 1.0).abs() < 1e-6).unwrap();
        assert!((ours[top] / (3.0 * PI) - 1.0).abs() < 1e-3, "{basis:?} {}", ours[top]);
        for (a, b) in ours.iter().zip(&theirs) {
            assert!((a - b).abs() <= 4e-3 * b, "{basis:?}: {a} {b}");
        }
    }
}

#[test]
fn one_bright_texel_is_a_sun_of_the_same_irradiance() {
    let ([width, height], [i, j]) = ([512, 256], [330, 80]);
    // ∫ over the tent that interpolation makes of the texel: its solid angle, to second order.
    let angle = (j as f64 + 0.5) / height as f64 * PI;
    let step = PI / height as f64;
    let solid_angle = TAU / width as f64 * angle.sin() * step * (2.0 * (1.0 - step.cos()) / (step * step));
    let pixels = one_bright([width, height], [i, j], 1e4);
    let sky = environment(pixels, DVec3::Y, 25.0, 1);
    let SkyKind::Environment(around) = &sky.kind else { unreachable!() };
    let towards = around.direction((i as f64 + 0.5) / width as f64, angle.cos());
    let sun = Light::Sun { direction: -towards, irradiance: vec![1e4 * solid_angle], diameter: 0.7 };
    let [ours, theirs] = [under(Some(sky), vec![], &[0.5]), under(None, vec![sun], &[0.5])]
        .map(|scene| direct(&scene, Basis::Constant, 4096));
    assert!(ours.len() == theirs.len() && theirs.iter().any(|h| *h > 0.5), "{theirs:?}");
    let brightest = theirs.iter().copied().fold(0.0, f64::max);
    for (a, b) in ours.iter().zip(&theirs) {
        assert!((a - b).abs() < 4e-3 * brightest, "{ours:?} {theirs:?}");
    }
}

/// A coloured sky with a bright spot and a dark ground.
fn coloured(channels: usize) -> Sky {
    let (width, height) = (48, 24);
    let texel = |k: usize| {
        let (i, j) = (k % width, k / width);
        let sky = if j < 12 { 1.0 - 0.03 * j as f32 } else { 0.15 };
        let spot = if (30..32).contains(&i) && (5..7).contains(&j) { 120.0 } else { 0.0 };
        [0.5 * sky + spot, 0.7 * sky + 0.8 * spot, sky + 0.5 * spot]
    };
    let pixels = Pixels::new(width, height, (0..width * height).map(texel).collect());
    environment(pixels, DVec3::Y, 10.0, channels)
}

struct Solved<'s> {
    patches: Patches<'s>,
    irradiance: DMatrix<f64>,
    radiance: DMatrix<f64>,
}

fn solved<'s>(tracer: &Tracer<'s>, count: usize) -> (Solved<'s>, f64) {
    let mut patches = cut_into(tracer, count);
    let factors = FormFactors::trace(tracer, &mut patches, &TraceOptions::default()).unwrap();
    let options = LightOptions { rays: 1024, ..Default::default() };
    let problem = Problem::new(tracer, &patches, &factors, &options).unwrap();
    let solution = problem.solve(&Default::default()).unwrap();
    let imbalance = Energy::of(&problem, &solution.radiance).imbalance;
    (Solved { patches, irradiance: solution.irradiance, radiance: solution.radiance }, imbalance)
}

#[test]
fn light_paths_that_draw_from_the_picture_themselves_agree() {
    let scene = under(Some(coloured(3)), vec![], &[0.6, 0.5, 0.4]);
    let tracer = Tracer::new(&scene);
    let (solved, imbalance) = solved(&tracer, 3000);
    assert!(imbalance < 1e-5, "{imbalance}");
    let options = PathOptions { seed: 5, ..paths(600_000) };
    let truth = PathTracer::new(&tracer).irradiance(&solved.patches, &options).unwrap();
    let difference = Difference::new(&solved.irradiance, &truth);
    assert!(difference.bias.abs() < 0.001 + 3.0 * difference.bias_error, "{difference:?}");
    assert!(difference.bias_error < 0.003 && difference.rms < 0.03, "{difference:?}");
}

#[test]
fn the_picture_is_seen_behind_the_scene() {
    let scene = under(Some(coloured(3)), vec![], &[0.6, 0.5, 0.4]);
    let tracer = Tracer::new(&scene);
    let (solved, _) = solved(&tracer, 400);
    let SkyKind::Environment(around) = &scene.sky().unwrap().kind else { unreachable!() };
    let camera = Camera {
        position: DVec3::new(0.0, 1.5, 0.0),
        target: DVec3::new(3.0, 3.0, 1.0),
        up: DVec3::Y,
        fov: 1e-3,
    };
    let towards = (camera.target - camera.position).normalize();
    for shading in [Shading::Flat, Shading::Smooth, Shading::Gather, Shading::Path] {
        let options = RenderOptions { width: 1, height: 1, shading, samples: 4, ..Default::default() };
        let seen =
            render::picture(&tracer, &solved.patches, &solved.radiance, &camera, &options).unwrap().pixels[0];
        for (seen, exact) in seen.iter().zip(around.from(towards)) {
            assert!((f64::from(*seen) / exact - 1.0).abs() < 1e-3, "{shading:?}: {seen} {exact}");
        }
    }
}

const OBJ: &str = "mtllib a.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nusemtl m\nf 1 2 3\n";

fn load(settings: &str, picture: Option<Vec<u8>>) -> Result<Scene, String> {
    let scratch = Scratch::with(&[("a.obj", OBJ), ("a.mtl", "newmtl m\nKd 0.5\n"), ("a.toml", settings)]);
    if let Some(picture) = picture {
        scratch.write("sky.exr", picture);
    }
    Scene::load(scratch.path("a.obj")).map_err(|e| e.to_string())
}

const SKY: &str = "[sky]\nkind = \"environment\"\nfile = \"sky.exr\"\n";

#[test]
fn what_is_wrong_with_an_environment_is_named() {
    let even = |_, _| [1.0; 3];
    let refused = |settings: &str, picture: Option<Vec<u8>>, line: usize, wanted: &[&str]| {
        let message = load(settings, picture).unwrap_err();
        for word in wanted.iter().chain(&[format!("a.toml:{line}: sky").as_str()]) {
            assert!(message.contains(word), "{word}: {message}");
        }
    };
    refused(SKY, None, 1, &["sky.exr", "is not there"]);
    refused(SKY, Some(b"nothing".to_vec()), 3, &["sky.exr", "cannot be read"]);
    let broken = exr(4, 2, |i, j| [if (i, j) == (3, 1) { f32::NAN } else { 1.0 }, 1.0, 1.0]);
    refused(SKY, Some(broken), 1, &["column 3, row 1", "NaN"]);
    refused(SKY, Some(exr(4, 2, |_, _| [0.0, -1.0, 0.0])), 1, &["not negative"]);
    refused(&format!("{SKY}up = [0, 0, 0]\n"), Some(exr(4, 2, even)), 4, &["up"]);
    refused(&format!("{SKY}scale = -1\n"), Some(exr(4, 2, even)), 4, &["scale -1:", "not negative"]);
    refused(&format!("{SKY}scale = 1\nluminance = 5\n"), Some(exr(4, 2, even)), 1, &["no more than one of"]);
    let below = exr(4, 2, |_, j| [j as f32; 3]);
    // What is interpolated reaches above the horizon; a single dark half does not.
    assert!(load(&format!("{SKY}illuminance = 5\n"), Some(below)).is_ok());
    let black = exr(4, 2, |_, _| [0.0; 3]);
    refused(&format!("{SKY}illuminance = 5\n"), Some(black.clone()), 4, &["nothing above the horizon"]);
    let scene = load(SKY, Some(black)).unwrap();
    assert!(scene.warnings()[0].contains("black") && scene.sky().is_none(), "{:?}", scene.warnings());
    let square = load(SKY, Some(exr(4, 4, even))).unwrap();
    assert!(square.warnings()[0].contains("4 x 4 pixels are stretched"), "{:?}", square.warnings());
}

#[test]
fn every_key_tells_the_unit_of_an_environment() {
    let picture = || exr(64, 32, |i, j| [1.0 + i as f32 / 64.0, 2.0, if j < 16 { 3.0 } else { 9.0 }]);
    let plain = load(SKY, Some(picture())).unwrap();
    assert_eq!(
        (plain.sky().unwrap().zenith.as_slice(), plain.warnings()),
        (&[1.0; 3][..], &[][..] as &[String])
    );
    for (key, wanted) in
        [("scale = 2.5", 2.5), ("luminance = 683", 1.0), ("luminance = 179\nturn = 30", 179.0 / 683.0)]
    {
        let scene = load(&format!("{SKY}{key}\n"), Some(picture())).unwrap();
        assert!((scene.sky().unwrap().zenith[0] / wanted - 1.0).abs() < 1e-12, "{key}");
    }
    // Open level ground gets the illuminance that was asked for.
    let scene = load(&format!("{SKY}illuminance = 12000\n"), Some(picture())).unwrap();
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(1.0));
    let options = LightOptions { rays: 16384, ..Default::default() };
    let direct = Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap().direct.unwrap();
    let row: Vec<f64> = direct.row(0).iter().copied().collect();
    assert!((683.0 * luminance(&row) / 12000.0 - 1.0).abs() < 1e-3, "{row:?}");
}

#[test]
fn grey_pictures_leave_one_channel() {
    assert_eq!(load(SKY, Some(exr(4, 2, |i, _| [i as f32; 3]))).unwrap().channels(), 1);
    assert_eq!(load(SKY, Some(exr(4, 2, |i, _| [i as f32, 1.0, 1.0]))).unwrap().channels(), 3);
}
