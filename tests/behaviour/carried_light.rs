//! Lights without area and skies by way of mirrors, metals and glass: closed forms, light paths, energy.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::measure::Energy;
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::reference::{Budget, PathOptions, PathTracer};
use radiosity::render::{self, RenderOptions, Shading};
use radiosity::scene::{Camera, Environment, Light, Material, Pixels, Receiver, Scene, Side, Sky, SkyKind};
use radiosity::solve::{DirectOptions, Problem};
use radiosity::trace::{Tracer, fresnel, solid_angle};
use radiosity::transport::{FormFactors, LightOptions, Plan, ReceiverRows, Shots, Sources, TraceOptions};

use crate::scenes::{flipped, lit_quads, room};

const BASES: [Basis; 2] = [Basis::Constant, Basis::Linear];

fn point(position: [f64; 3], intensity: &[f64]) -> Light {
    Light::Point { position: position.into(), intensity: intensity.to_vec() }
}

fn sun(direction: [f64; 3], irradiance: f64, diameter: f64) -> Light {
    Light::Sun { direction: DVec3::from(direction).normalize(), irradiance: vec![irradiance], diameter }
}

fn sky(kind: SkyKind, zenith: f64) -> Sky {
    Sky { kind, up: DVec3::Y, zenith: vec![zenith], ground: 0.0 }
}

/// A square of this half-width at this height, facing up.
fn square(y: f64, half: f64) -> [[f64; 3]; 4] {
    [[-half, y, -half], [-half, y, half], [half, y, half], [half, y, -half]]
}

fn cut<'s>(tracer: &Tracer<'s>, size: PatchSize) -> Patches<'s> {
    Patches::new(tracer, &Tessellation { size, ..Default::default() }).unwrap()
}

fn trace(tracer: &Tracer, patches: &Patches, basis: Basis, rays: u32) -> Sources {
    Sources::trace(tracer, patches, basis, &LightOptions { rays, ..Default::default() }).unwrap()
}

/// Irradiance by way of carriers, by means over patches.
fn carried(tracer: &Tracer, patches: &Patches, basis: Basis, rays: u32) -> DMatrix<f64> {
    basis.means(&trace(tracer, patches, basis, rays).carried.unwrap().irradiance)
}

/// Standard errors of H₀ of constant elements, by its eight parts.
fn standard_errors(sources: &Sources) -> DMatrix<f64> {
    let direct = sources.direct.as_ref().unwrap();
    let variance = |i: usize, c: usize| {
        sources.spread.iter().map(|more| more[(i, c)].powi(2)).sum::<f64>() / (8.0 * 7.0)
    };
    DMatrix::from_fn(direct.nrows(), direct.ncols(), |i, c| variance(i, c).sqrt())
}

/// Flux (W) that a face's side catches of an irradiance.
fn flux(patches: &Patches, field: &DMatrix<f64>, face: usize, side: Side) -> f64 {
    patches.patches_of(face, side).map(|i| patches.area(i) * field[i]).sum()
}

#[test]
fn a_point_light_over_a_mirror_is_two_lights() {
    // A ceiling at height 2 that faces down, a light at height 1, and its image below a mirror at height 0.
    let light = DVec3::new(0.2, 1.0, -0.1);
    let scene = lit_quads(
        &[(flipped(square(2.0, 1.0)), 0), (square(0.0, 1.0), 1)],
        vec![Material::diffuse("ceiling", &[0.5]), Material::mirror("mirror", &[0.8])],
        vec![point(light.to_array(), &[20.0])],
        None,
    );
    assert_eq!(scene.warnings(), [""; 0]);
    let tracer = Tracer::new(&scene);
    let image = DVec3::new(light.x, -light.y, light.z);
    let patches = cut(&tracer, PatchSize::Count(200));
    for basis in BASES {
        let found = carried(&tracer, &patches, basis, 1024);
        for face in [0, 1] {
            let exact = 0.8 * 20.0 * solid_angle(image, &scene.corners(face));
            let off = flux(&patches, &found, face, Side::Front) / exact - 1.0;
            assert!(off.abs() < 6e-3, "{basis:?} {face}: {off}");
        }
    }
    // Patch by patch within the noise that the parts tell.
    let sources = trace(&tracer, &patches, Basis::Constant, 8192);
    let (found, errors) = (&sources.carried.as_ref().unwrap().irradiance, standard_errors(&sources));
    let mut squares = 0.0;
    for i in 0..patches.len() {
        let between = image - patches.centre(i);
        let exact = 0.8 * 20.0 * between.y.abs() / between.length().powi(3);
        assert!(errors[i] < 0.1 * exact, "{i}: {} ± {}", found[i], errors[i]);
        squares += ((found[i] - exact) / errors[i]).powi(2) / patches.len() as f64;
    }
    // A square of Student's t with 7 degrees of freedom is 7/5 in the mean.
    assert!((0.9..2.0).contains(&squares), "{squares}");
}

#[test]
fn the_sun_off_a_mirror_lands_where_geometry_says() {
    // A mirror on the ground, half a metre wide, and a wall at x = 2 that faces it; the sun from the other
    // side.
    let wall = [[2.0, 0.0, -2.0], [2.0, 0.0, 2.0], [2.0, 4.0, 2.0], [2.0, 4.0, -2.0]];
    let down = DVec3::new(1.0, -1.0, 0.0).normalize();
    let scene = lit_quads(
        &[(wall, 0), (square(0.0, 0.25), 1)],
        vec![Material::diffuse("wall", &[0.5]), Material::mirror("mirror", &[0.9])],
        vec![sun(down.to_array(), 100.0, 0.0)],
        None,
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.05));
    let found = carried(&tracer, &patches, Basis::Constant, 64);
    // At 45° the mirror's picture on the wall is as high as the mirror is long, from y = 1.75 to 2.25.
    let exact = 0.9 * 100.0 * (0.5f64).sqrt();
    let mut inside = 0;
    for i in 0..patches.len() {
        let DVec3 { y, z, .. } = patches.centre(i);
        let beyond = (y - 2.0).abs().max(z.abs()) - 0.25;
        if patches.place(i).side == Side::Back || beyond > 0.05 {
            assert_eq!(found[i], 0.0, "{i}: {y} {z}");
        } else if beyond < -0.05 {
            inside += 1;
            assert!((found[i] / exact - 1.0).abs() < 0.1, "{i}: {} {exact}", found[i]);
        }
    }
    assert!(inside > 100, "{inside}");
    let whole: f64 = [0, 1]
        .map(|face| flux(&patches, &found, face, Side::Back) + flux(&patches, &found, face, Side::Front))
        .iter()
        .sum();
    assert!((whole / (exact * 0.25) - 1.0).abs() < 1e-3, "{whole}");
}

#[test]
fn the_sun_through_a_solid_slab_is_dimmed_as_its_surfaces_do() {
    // A wide slab over a small ground.
    let slab = room([-1.2, 1.0, -1.2], [1.2, 1.2, 1.2]).map(|quad| (flipped(quad), 1));
    let quads: Vec<_> = std::iter::once((square(0.0, 0.3), 0)).chain(slab).collect();
    for diameter in [0.0, 2.0] {
        let down = DVec3::new(0.5, -1.0, 0.2).normalize();
        let scene = lit_quads(
            &quads,
            vec![Material::diffuse("ground", &[0.5]), Material::dielectric("glass", 1.5, &[1.0])],
            vec![sun(down.to_array(), 100.0, diameter)],
            None,
        );
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, PatchSize::Count(32));
        let found = carried(&tracer, &patches, Basis::Constant, 1 << 16);
        let once = fresnel(-down.y, 1.5);
        let exact = 100.0 * -down.y * (1.0 - once) / (1.0 + once) * 0.36;
        let whole: f64 = (0..2).map(|face| flux(&patches, &found, face, Side::Front)).sum();
        assert!((whole / exact - 1.0).abs() < 4e-3, "{diameter}: {whole} {exact}");
    }
}

#[test]
fn a_light_within_clear_glass_delivers_all_its_flux() {
    // A light within a block, whose filter takes one channel's part at every crossing, within a black room.
    let walls = room([0.0; 3], [3.0; 3]).map(|quad| (quad, 0));
    let block = room([1.0, 1.1, 0.9], [1.9, 2.0, 2.1]).map(|quad| (flipped(quad), 1));
    let scene = lit_quads(
        &[walls, block].concat(),
        vec![Material::diffuse("wall", &[0.0; 2]), Material::dielectric("glass", 1.5, &[1.0, 0.7])],
        vec![point([1.3, 1.4, 1.6], &[1.0, 2.0])],
        None,
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(300));
    let sources = trace(&tracer, &patches, Basis::Constant, 512);
    let light = sources.carried.as_ref().unwrap();
    let arrived =
        |c: usize| (0..patches.len()).map(|i| patches.area(i) * light.irradiance[(i, c)]).sum::<f64>();
    // Black walls send nothing on: all that is absorbed and lost is on the way from the light.
    let factors = FormFactors::none(&patches, Basis::Constant);
    let problem = Problem::unlit(&patches, &factors).unwrap().under(sources.clone());
    let energy = Energy::of(&problem, problem.right_hand_side());
    // Light that total reflection holds in the block for ever is given up.
    let [clear, held] = [arrived(0), energy.lost[0]];
    assert_eq!(energy.carriers[0], 0.0);
    assert!(((clear + held) / (4.0 * PI) - 1.0).abs() < 1e-3, "{clear} {held}");
    assert!(held > 0.1 * clear, "{held}");
    // Whatever leaves the block crosses its surface just once.
    let [dim, kept] = [arrived(1), energy.carriers[1]];
    assert!((dim / (2.0 * 0.7 * clear) - 1.0).abs() < 1e-12, "{dim} {clear}");
    assert!((kept / (2.0 * 0.3 * clear) - 1.0).abs() < 1e-12, "{kept} {clear}");
}

/// F between parallel unit squares at this distance (Howell C-11).
fn facing(distance: f64) -> f64 {
    let x: f64 = 1.0 / distance;
    let root = (1.0 + x * x).sqrt();
    let logarithm = ((1.0 + x * x) / (1.0 + 2.0 * x * x).sqrt()).ln();
    2.0 / (PI * x * x) * (logarithm + 2.0 * x * root * (x / root).atan() - 2.0 * x * x.atan())
}

#[test]
fn a_plate_over_a_mirror_sees_the_sky_in_it_but_for_itself() {
    let scene = lit_quads(
        &[(flipped(square(0.6, 0.5)), 0), (square(0.0, 400.0), 1)],
        vec![Material::diffuse("plate", &[0.0]), Material::mirror("mirror", &[0.7])],
        Vec::new(),
        Some(sky(SkyKind::Constant, 3.0)),
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.2));
    let exact = 0.7 * 3.0 * PI * (1.0 - facing(1.2));
    for basis in BASES {
        let found = carried(&tracer, &patches, basis, 1024);
        let mean: f64 = (0..2).map(|face| flux(&patches, &found, face, Side::Front)).sum();
        assert!((mean / exact - 1.0).abs() < 3e-3, "{basis:?}: {mean} {exact}");
    }
}

#[test]
fn under_an_even_sky_a_closed_shell_of_clear_glass_is_as_if_it_were_not_there() {
    let outer = room([-1.0; 3], [1.0; 3]).map(|quad| (flipped(quad), 1));
    let inner = room([-0.8; 3], [0.8; 3]).map(|quad| (quad, 1));
    let quads: Vec<_> = std::iter::once((square(-0.2, 0.3), 0)).chain(outer).chain(inner).collect();
    let materials = vec![Material::diffuse("plate", &[0.5]), Material::dielectric("glass", 1.5, &[1.0])];
    let scene = lit_quads(&quads, materials.clone(), Vec::new(), Some(sky(SkyKind::Constant, 2.0)));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(16));
    let found = trace(&tracer, &patches, Basis::Constant, 4096).direct.unwrap();
    let mean = found.sum() / found.nrows() as f64;
    assert!((mean / (2.0 * PI) - 1.0).abs() < 5e-3, "{mean}");
}

/// A ball of facets around the origin.
fn ball(radius: f64) -> Vec<[[f64; 3]; 4]> {
    let (columns, rows) = (48, 24);
    let at = |i: usize, j: usize| {
        let (phi, theta) = (2.0 * PI * i as f64 / columns as f64, PI * j as f64 / rows as f64);
        [radius * theta.sin() * phi.sin(), radius * theta.cos(), radius * theta.sin() * phi.cos()]
    };
    let quad = |k: usize| {
        let (i, j) = (k % columns, k / columns);
        [at(i, j), at(i, j + 1), at((i + 1) % columns, j + 1), at((i + 1) % columns, j)]
    };
    (0..columns * rows).map(quad).collect()
}

#[test]
fn within_solid_glass_the_sky_is_as_bright_as_outside_by_the_square_of_the_index() {
    let glass = ball(1.0).into_iter().map(|quad| (quad, 1));
    let quads: Vec<_> = std::iter::once((square(0.0, 0.02), 0)).chain(glass).collect();
    let materials = vec![Material::diffuse("plate", &[0.5]), Material::dielectric("glass", 1.5, &[1.0])];
    let scene = lit_quads(&quads, materials, Vec::new(), Some(sky(SkyKind::Constant, 2.0)));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(4));
    let found = trace(&tracer, &patches, Basis::Constant, 1 << 14).direct.unwrap();
    let part = found.sum() / found.nrows() as f64 / (2.0 * PI);
    // No more is missing than what the surface reflects back to the plate.
    assert!((0.95..1.002).contains(&part), "{part}");
}

#[test]
fn skies_of_every_kind_agree_with_and_without_shots() {
    // A box of mirrors over a ground, open to one side.
    let sides = room([-0.5, 0.3, -0.5], [0.5, 1.3, 0.5]).map(|quad| (quad, 1));
    let quads: Vec<_> = std::iter::once((square(0.0, 1.0), 0)).chain(sides[2..5].iter().copied()).collect();
    for kind in
        [SkyKind::Constant, SkyKind::Overcast, SkyKind::Clear { sun: DVec3::new(0.6, 0.7, 0.2).normalize() }]
    {
        let materials = vec![Material::diffuse("ground", &[0.5]), Material::mirror("mirror", &[0.9])];
        let scene = lit_quads(&quads, materials, Vec::new(), Some(sky(kind, 1.0)));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, PatchSize::Count(64));
        let [with, without] = [Shots::Shot, Shots::Skipped].map(|caustics| {
            let options = LightOptions { rays: 4096, caustics, ..Default::default() };
            Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap()
        });
        let flux = |field: &DMatrix<f64>| (0..patches.len()).map(|i| patches.area(i) * field[i]).sum::<f64>();
        let [(ours, error), (theirs, other)] = [&with, &without].map(|sources| {
            let squares: f64 = sources.spread.iter().map(|more| flux(more).powi(2)).sum();
            (flux(sources.direct.as_ref().unwrap()), (squares / 56.0).sqrt())
        });
        let (z, noise) = ((ours - theirs) / error.hypot(other), error.hypot(other) / theirs);
        assert!(z.abs() < 4.0 && noise < 0.01, "{ours} ± {error}, {theirs} ± {other}");
        let errors = [&with, &without].map(standard_errors);
        let [with, without] = [with, without].map(|sources| sources.carried.unwrap().irradiance);
        let mut squares = 0.0;
        for i in 0..patches.len() {
            let variance = errors[0][i].powi(2) + errors[1][i].powi(2);
            squares += (with[i] - without[i]).powi(2) / variance.max(1e-12) / patches.len() as f64;
        }
        assert!(squares < 2.0, "{squares}");
    }
}

/// A room with such walls, a thick window in its roof, a mirror and a block of brushed metal in it, all
/// coloured, and every kind of light around and within.
fn hall(wall: Material) -> Scene {
    let [left, bottom, front, right, top, back] = room([0.0; 3], [3.0; 3]);
    let roof = |x: [f64; 2], z: [f64; 2]| {
        [[x[0], 3.0, z[0]], [x[1], 3.0, z[0]], [x[1], 3.0, z[1]], [x[0], 3.0, z[1]]]
    };
    assert_eq!(top[0][1], 3.0);
    let mut quads = [left, bottom, front, right, back].map(|quad| (quad, 0)).to_vec();
    quads.extend([roof([0.0, 1.0], [0.0, 3.0]), roof([2.0, 3.0], [0.0, 3.0])].map(|quad| (quad, 0)));
    quads.extend([roof([1.0, 2.0], [0.0, 1.0]), roof([1.0, 2.0], [2.0, 3.0])].map(|quad| (quad, 0)));
    quads.extend(room([1.0, 3.01, 1.0], [2.0, 3.1, 2.0]).map(|quad| (flipped(quad), 1)));
    quads.push(([[0.01, 0.5, 0.5], [0.01, 2.5, 0.5], [0.01, 2.5, 2.5], [0.01, 0.5, 2.5]], 2));
    quads.extend(room([1.8, 0.0, 0.4], [2.4, 0.6, 1.0]).map(|quad| (flipped(quad), 3)));
    let spot = Light::Spot {
        position: DVec3::new(2.6, 2.0, 1.4),
        direction: DVec3::new(-1.0, -0.2, 0.1).normalize(),
        intensity: vec![3.0, 2.0],
        cone: 30.0,
        penumbra: 10.0,
    };
    let sun = Light::Sun {
        direction: DVec3::new(-0.3, -1.0, 0.1).normalize(),
        irradiance: vec![20.0, 15.0],
        diameter: 1.0,
    };
    lit_quads(
        &quads,
        vec![
            wall,
            Material::dielectric("glass", 1.5, &[0.95, 0.9]),
            Material::mirror("mirror", &[0.9, 0.6]),
            Material::conductor("metal", 0.4, &[0.8, 0.5]),
        ],
        vec![point([1.2, 1.0, 2.0], &[1.0, 0.7]), spot, sun],
        Some(Sky { kind: SkyKind::Overcast, up: DVec3::Y, zenith: vec![2.0, 3.0], ground: 0.3 }),
    )
}

#[test]
fn light_paths_and_photons_find_the_same_on_every_black_patch() {
    agree_on_black(hall(Material::diffuse("wall", &[0.0; 2])));
}

#[test]
fn light_paths_and_photons_find_the_same_under_coats() {
    agree_on_black(hall(Material::plastic("wall", (0.3, 1.5), &[0.0; 2])));
}

/// Holds light by way of carriers in a hall of black walls against light paths and photons.
fn agree_on_black(scene: Scene) {
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(200));
    let options =
        PathOptions { budget: Budget { paths: Some(2_000_000), ..Budget::default() }, ..Default::default() };
    let traced = PathTracer::new(&tracer).irradiance(&patches, &options).unwrap();
    let sources = trace(&tracer, &patches, Basis::Constant, 2048);
    let (found, errors) = (sources.direct.as_ref().unwrap(), standard_errors(&sources));
    let (mut squares, mut values) = (0.0, 0.0);
    let mut whole = [[0.0; 2]; 2];
    for (i, c) in (0..patches.len()).flat_map(|i| [(i, 0), (i, 1)]) {
        let truth = traced.irradiance(i, c);
        let error = truth.standard_error.hypot(errors[(i, c)]);
        if error > 0.0 {
            squares += ((found[(i, c)] - truth.mean) / error).powi(2);
            values += 1.0;
        }
        whole[c][0] += patches.area(i) * found[(i, c)];
        whole[c][1] += patches.area(i) * truth.mean;
    }
    let inside = (0..patches.len()).filter(|&i| errors[(i, 0)] < 0.1 * found[(i, 0)]).count();
    assert!(inside > patches.len() / 2, "{inside} of {}", patches.len());
    assert!(squares / values < 2.0, "{}", squares / values);
    for [ours, theirs] in whole {
        assert!((ours / theirs - 1.0).abs() < 4e-3, "{ours} {theirs}");
    }
    // Where most comes by way of carriers, too.
    let brought = &sources.carried.as_ref().unwrap().irradiance;
    for c in 0..2 {
        let dim = (0..patches.len()).filter(|&i| brought[(i, c)] > 0.5 * found[(i, c)]);
        let (mut ours, mut theirs, mut variance) = (0.0, 0.0, 0.0);
        for i in dim {
            let truth = traced.irradiance(i, c);
            ours += patches.area(i) * found[(i, c)];
            theirs += patches.area(i) * truth.mean;
            variance += patches.area(i).powi(2) * (truth.standard_error.powi(2) + errors[(i, c)].powi(2));
        }
        assert!(ours > 0.01 * whole[c][0], "{ours} of {}", whole[c][0]);
        println!("{ours} {theirs} ± {}", variance.sqrt());
        assert!((ours - theirs).abs() < 4.0 * variance.sqrt(), "{ours} {theirs} ± {}", variance.sqrt());
    }
    // It matters: without what carriers bring the inside of the room would be much darker.
    assert!(brought.sum() > 0.02 * found.sum(), "{} {}", brought.sum(), found.sum());
}

#[test]
fn light_that_goes_on_is_the_same_by_photons_and_by_the_operator_and_no_energy_is_lost() {
    let scene = hall(Material::diffuse("wall", &[0.5; 2]));
    let tracer = Tracer::new(&scene);
    let mut patches = cut(&tracer, PatchSize::Count(1500));
    let options = TraceOptions { rays: Some(256), ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let light = LightOptions { rays: 1024, ..Default::default() };
    let problem = Problem::new(&tracer, &patches, &factors, &light).unwrap();
    let solution = problem.direct(&DirectOptions::default()).unwrap();
    let energy = Energy::of(&problem, &solution.radiance);
    assert!(energy.imbalance < 1e-9, "{energy:?}");
    // Some of it on the way from lights: with what surfaces send out alone less is absorbed.
    let of_surfaces = Energy::new(problem.operator(), problem.right_hand_side(), &solution.radiance);
    for (all, of_surfaces) in energy.carriers.iter().zip(&of_surfaces.carriers) {
        assert!(all > of_surfaces, "{energy:?} {of_surfaces:?}");
    }
    let options =
        PathOptions { budget: Budget { paths: Some(400_000), ..Budget::default() }, ..Default::default() };
    let traced = PathTracer::new(&tracer).irradiance(&patches, &options).unwrap();
    for c in 0..2 {
        let (mut ours, mut theirs, mut variance) = (0.0, 0.0, 0.0);
        for i in 0..patches.len() {
            let truth = traced.irradiance(i, c);
            ours += patches.area(i) * solution.irradiance[(i, c)];
            theirs += patches.area(i) * truth.mean;
            variance += (patches.area(i) * truth.standard_error).powi(2);
        }
        assert!(
            (ours - theirs).abs() < 0.01 * theirs + 4.0 * variance.sqrt(),
            "{ours} {theirs} ± {}",
            variance.sqrt()
        );
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let scene = hall(Material::diffuse("wall", &[0.5; 2]));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(100));
    for basis in BASES {
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| trace(&tracer, &patches, basis, 256))
        });
        assert_eq!(one, three);
        let constant = trace(&tracer, &patches, Basis::Constant, 256).carried.unwrap().irradiance;
        let means = basis.means(&one.carried.unwrap().irradiance);
        assert!((means - &constant).amax() < 1e-12 * constant.amax());
    }
}

#[test]
fn scenes_without_anything_that_carries_light_have_none_carried() {
    let scene = lit_quads(
        &[(square(0.0, 1.0), 0)],
        vec![Material::diffuse("grey", &[0.5])],
        vec![point([0.0, 1.0, 0.0], &[1.0])],
        None,
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(8));
    assert_eq!(trace(&tracer, &patches, Basis::Constant, 64).carried, None);
    let caustics = Plan::new(&scene).effects.into_iter().find(|effect| effect.effect == "caustics").unwrap();
    assert!(!caustics.on);
}

#[test]
fn a_bright_spot_in_a_picture_of_the_sky_is_found_in_a_mirror() {
    // A sky of one bright texel and an even rest, over a wall that stands on a mirror.
    let (width, height) = (64, 32);
    let bright = (20, 6);
    let texel = |k: usize| if (k % width, k / width) == bright { [20000.0; 3] } else { [1.0; 3] };
    let pixels = Pixels::new(width, height, (0..width * height).map(texel).collect());
    let environment = Environment::new(pixels, DVec3::Y, 0.0);
    let sky =
        Sky { kind: SkyKind::Environment(environment.into()), up: DVec3::Y, zenith: vec![1.0], ground: 0.0 };
    let wall = [[1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [1.0, 2.0, 1.0], [1.0, 2.0, -1.0]];
    let scene = lit_quads(
        &[(wall, 0), (square(0.0, 1.0), 1)],
        vec![Material::diffuse("wall", &[0.0]), Material::mirror("mirror", &[0.8])],
        Vec::new(),
        Some(sky),
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(64));
    let of = |caustics: Shots, rays: u32| {
        let options = LightOptions { rays, caustics, ..Default::default() };
        let sources = Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap();
        let errors = standard_errors(&sources);
        (sources.carried.unwrap().irradiance, errors)
    };
    let (exact, _) = of(Shots::Skipped, 1 << 18);
    let (found, errors) = of(Shots::Shot, 1024);
    let off = (found.sum() / exact.sum() - 1.0).abs();
    assert!(off < 0.02, "{off}");
    // With much less noise than by as many rays of patches alone.
    let (_, noise) = of(Shots::Skipped, 1024);
    assert!(errors.norm() < 0.6 * noise.norm(), "{} {}", errors.norm(), noise.norm());
}

#[test]
fn receivers_get_what_mirrors_send_them() {
    let down = DVec3::new(1.0, -1.0, 0.0).normalize();
    let receiver = |corner: [f64; 3], edges: [[f64; 3]; 2]| Receiver {
        name: "grid".into(),
        corner: corner.into(),
        edges: edges.map(DVec3::from),
        counts: [4, 2],
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
        ReceiverRows::trace(&tracer, &patches, Basis::Constant, receiver, &options).unwrap().irradiance(&dark)
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
