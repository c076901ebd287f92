//! Effects left out: what each loses, and that nothing else changes.

use std::f64::consts::PI;

use nalgebra::DMatrix;
use radiosity::measure::Energy;
use radiosity::patches::Basis;
use radiosity::scene::{Feature, Material, Scene, SceneParts, Side, Sky, SkyKind, luminance};
use radiosity::solve::{Problem, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, Shots, Sources, Switches, TraceOptions};

use crate::scenes::{BASES, cut_into, facing, flipped, lit_quads, mesh, parts_of, quads, room, unit_square};

fn switched(scene: Scene, switches: &str) -> (Scene, Vec<String>) {
    let (scene, _, told) = switches.parse::<Switches>().unwrap().apply(scene);
    (scene, told)
}

/// The same faces of other materials.
fn with_materials(scene: &Scene, materials: Vec<Material>) -> Scene {
    Scene::new(SceneParts { materials, ..parts_of(scene) }).unwrap()
}

/// Irradiance of every patch, by means, with all effects the scene has.
fn irradiance(scene: &Scene, options: &TraceOptions) -> DMatrix<f64> {
    let tracer = Tracer::new(scene);
    let mut patches = cut_into(&tracer, 400);
    let factors = FormFactors::trace(&tracer, &mut patches, options).unwrap();
    let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
    problem.solve(&SolveOptions::default()).unwrap().means().irradiance
}

#[test]
fn without_interreflection_there_is_what_lamps_send_straight_and_what_of_it_is_reflected() {
    let plates = [(unit_square(0.0), 0), (flipped(unit_square(1.0)), 1)];
    let lamp = Material::lamp("lamp", &[0.9], &[2.0]);
    let scene =
        quads(&plates, vec![lamp, Material::diffuse("plate", &[0.8])]).without(Feature::Interreflection);
    let tracer = Tracer::new(&scene);
    for (basis, are_traced) in BASES.into_iter().flat_map(|basis| [false, true].map(|traced| (basis, traced)))
    {
        let mut patches = cut_into(&tracer, 200);
        let factors = if are_traced {
            let options = TraceOptions { basis, ..Default::default() };
            FormFactors::trace(&tracer, &mut patches, &options).unwrap()
        } else {
            FormFactors::none(&patches, basis)
        };
        let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
        let solution = problem.solve(&SolveOptions::default()).unwrap();
        assert!(solution.report.residual == 0.0 && problem.factors().exchange().closure_error() == 0.0);
        // The plate gets F of the lamp's light, and the lamp nothing back.
        let k = problem.operator();
        let areas = k.mass().areas();
        let arrived = areas.dot(&solution.irradiance.column(0));
        let plate: f64 =
            (0..patches.len()).filter(|&i| patches.place(i).face > 1).map(|i| patches.area(i)).sum();
        let form_factor = arrived / (PI * 2.0 * plate);
        assert!((form_factor / facing(1.0) - 1.0).abs() < 2e-3, "{basis:?}: {form_factor}");
        // Each place reflects of it what it reflects.
        let reflected = k.reflect(&solution.irradiance) + &problem.sources().emitted;
        assert!((reflected - &solution.radiance).amax() < 1e-14);
        let energy = Energy::of(&problem, &solution.radiance);
        assert!((energy.lost[0] / (energy.lost[0] + energy.absorbed[0]) - 0.8).abs() < 1e-12, "{energy:?}");
    }
}

/// The energy of direct light in a scene that is cut into some 400 patches, under a seed.
fn direct_energy(scene: &Scene, basis: Basis, seed: u64) -> Energy {
    let tracer = Tracer::new(scene);
    let patches = cut_into(&tracer, 400);
    let factors = FormFactors::none(&patches, basis);
    let light = LightOptions { seed, ..Default::default() };
    let sources = Sources::trace(&tracer, &patches, basis, &light).unwrap();
    let sources = sources.with_lamps(&tracer, &patches, basis, &light).unwrap();
    let problem = Problem::unlit(&patches, &factors).unwrap().under(sources);
    Energy::of(&problem, problem.right_hand_side())
}

#[test]
fn direct_light_in_a_closed_room_balances_within_its_noise() {
    let sides = room([0.0; 3], [2.0, 1.0, 3.0]).map(|side| (side, 0));
    let lamp = flipped([[0.5, 0.9, 0.5], [0.5, 0.9, 0.8], [0.8, 0.9, 0.8], [0.8, 0.9, 0.5]]);
    let quads_and_lamp: Vec<_> = sides.into_iter().chain([(flipped(lamp), 1)]).collect();
    let materials = vec![Material::diffuse("wall", &[0.5]), Material::lamp("lamp", &[0.2], &[3.0])];
    let scene = quads(&quads_and_lamp, materials).without(Feature::Interreflection);
    for (basis, seed) in BASES.into_iter().flat_map(|basis| [0, 1, 2, 3].map(|seed| (basis, seed))) {
        let energy = direct_energy(&scene, basis, seed);
        // Two estimates that know nothing of each other: some noise is left, and no more than they say.
        assert!(energy.imbalance != 0.0 && energy.imbalance < 4.0 * energy.imbalance_error, "{energy:?}");
        assert!(energy.imbalance_error < 0.03, "{energy:?}");
        assert_eq!([energy.escaped[0], energy.carriers[0]], [0.0; 2], "{energy:?}");
    }
}

#[test]
fn what_lamps_send_past_all_surfaces_is_measured_and_no_remainder() {
    let plates = [(unit_square(0.0), 0), (flipped(unit_square(1.0)), 1)];
    let lamp = Material::lamp("lamp", &[0.9], &[2.0]);
    let scene = quads(&plates, vec![lamp, Material::diffuse("plate", &[0.8])]);
    for (basis, seed) in BASES.into_iter().flat_map(|basis| [0, 1, 2, 3].map(|seed| (basis, seed))) {
        let energy = direct_energy(&scene, basis, seed);
        let off = energy.escaped[0] / energy.emitted[0] - (1.0 - facing(1.0));
        assert!(off != 0.0 && off.abs() < 4.0 * energy.imbalance_error, "{off} {energy:?}");
        assert!(energy.imbalance < 4.0 * energy.imbalance_error, "{energy:?}");
    }
}

#[test]
fn direct_light_among_carriers_and_textures_balances_in_every_channel() {
    for name in ["mirror_room", "glass_balls", "glossy_floor", "plastic_toys", "textured_room"] {
        let scene = mesh(name);
        for basis in BASES {
            let energy = direct_energy(&scene, basis, 0);
            assert!(energy.imbalance < 4.0 * energy.imbalance_error, "{name} {basis:?}: {energy:?}");
            assert!(energy.imbalance_error < 0.01, "{name} {basis:?}: {energy:?}");
        }
    }
    let energy = direct_energy(&mesh("mirror_room"), Basis::Constant, 0);
    assert!(energy.carriers[0] > 0.0, "{energy:?}");
}

#[test]
fn without_interreflection_light_is_as_among_black_surfaces() {
    let scene = mesh("two_rooms");
    let black = |m: &Material| Material { reflectance: vec![0.0; m.reflectance.len()], ..m.clone() };
    let dark = with_materials(&scene, scene.materials().iter().map(black).collect());
    let options = TraceOptions { lamp_rays: Some(512), ..Default::default() };
    let expected = irradiance(&dark, &options);
    let tracer = Tracer::new(&dark);
    let patches = cut_into(&tracer, 400);
    let light = LightOptions { lamp_rays: options.lamp_rays, ..Default::default() };
    let lights = Sources::trace(&tracer, &patches, Basis::Constant, &light).unwrap();
    let direct = lights.with_lamps(&tracer, &patches, Basis::Constant, &light).unwrap().direct.unwrap();
    let off = (&direct - &expected).norm() / expected.norm();
    assert!(off < 0.01, "{off}");
}

#[test]
fn direct_light_arrives_in_every_one_of_many_bands() {
    let plates = [(unit_square(0.0), 0), (flipped(unit_square(1.0)), 1)];
    let lamp = Material::lamp("lamp", &[0.5; 5], &[1.0, 2.0, 3.0, 4.0, 5.0]);
    let scene = quads(&plates, vec![lamp, Material::diffuse("plate", &[0.8; 5])]);
    let tracer = Tracer::new(&scene);
    let patches = cut_into(&tracer, 50);
    let light = LightOptions::default();
    let lights = Sources::trace(&tracer, &patches, Basis::Constant, &light).unwrap();
    let direct = lights.with_lamps(&tracer, &patches, Basis::Constant, &light).unwrap().direct.unwrap();
    for c in 1..5 {
        let off = (direct.column(c) - direct.column(0) * (c + 1) as f64).amax();
        assert!(off < 1e-12 * direct.amax(), "band {c}: {off}");
    }
}

#[test]
fn without_colour_a_scene_is_the_grey_one_of_the_same_luminance() {
    let scene = mesh("cornell_box");
    let grey: Vec<Material> = scene
        .materials()
        .iter()
        .map(|m| {
            let [r, e] = [&m.reflectance, &m.emission].map(|colour| vec![luminance(colour)]);
            Material::lamp(m.name.clone(), &r, &e)
        })
        .collect();
    let grey = with_materials(&scene, grey);
    let (without, told) = switched(scene, "-colour");
    assert_eq!((without.channels(), told.len()), (1, 1));
    let options = TraceOptions { rays: Some(64), ..Default::default() };
    assert_eq!(irradiance(&without, &options), irradiance(&grey, &options));
}

#[test]
fn without_its_sky_and_lights_a_scene_is_the_one_without_them() {
    let walls = room([0.0; 3], [1.0; 3]);
    let open: Vec<_> = walls[..4].iter().chain(&walls[5..]).map(|&quad| (quad, 0)).collect();
    let lamp = || vec![Material::lamp("wall", &[0.5], &[1.0])];
    let sky = Sky { kind: SkyKind::Constant, up: [0.0, 1.0, 0.0].into(), zenith: vec![3.0], ground: 0.0 };
    let plain = quads(&open, lamp());
    let (without, told) = switched(lit_quads(&open, lamp(), Vec::new(), Some(sky)), "-sky,-lights");
    assert!(told[1].contains("the sky") || told[1].contains("outside"), "{told:?}");
    assert!(told[0].contains("lights is off anyway"), "{told:?}");
    let options = TraceOptions { rays: Some(64), ..Default::default() };
    assert_eq!(irradiance(&without, &options), irradiance(&plain, &options));
}

#[test]
fn without_back_sides_every_patch_is_a_front() {
    let count = |scene: &Scene, side: Side| {
        let tracer = Tracer::new(scene);
        let mut patches = cut_into(&tracer, 300);
        let options = TraceOptions { rays: Some(64), ..Default::default() };
        FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        (0..patches.len()).filter(|&i| patches.place(i).side == side).count()
    };
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let sheet = ([[0.2, 0.2, 0.5], [0.8, 0.2, 0.5], [0.8, 0.8, 0.5], [0.2, 0.8, 0.5]], 1);
    let materials = vec![Material::lamp("wall", &[0.5], &[1.0]), Material::diffuse("sheet", &[0.5])];
    let scene = quads(&[&walls[..], &[sheet]].concat(), materials);
    assert!(count(&scene, Side::Back) > 0);
    let (without, _) = switched(scene, "-back-sides");
    assert_eq!(count(&without, Side::Back), 0);
    assert!(count(&without, Side::Front) > 0);
}

#[test]
fn without_mirrors_and_glass_nothing_carries_light_on() {
    for (name, effect) in [("mirror_room", "-mirror"), ("glass_balls", "-dielectric")] {
        let (scene, told) = switched(mesh(name), effect);
        assert!(!Tracer::new(&scene).has_carriers(), "{name}");
        assert_eq!(told.len(), 1, "{told:?}");
    }
    // A mirror goes on to reflect as much; glass is gone, and what was behind it is what is met.
    let (scene, _) = switched(mesh("mirror_room"), "-mirror");
    let mirror = scene.materials().iter().find(|m| m.name.contains("mirror")).unwrap();
    assert!(mirror.reflects(), "{mirror:?}");
}

#[test]
fn without_caustics_the_same_light_is_found_by_rays_alone() {
    let scene = mesh("mirror_room");
    let with = irradiance(&scene, &TraceOptions::default());
    let options = "-caustics".parse::<Switches>().unwrap().trace(TraceOptions::default());
    assert_eq!(options.caustics, Shots::Skipped);
    let without = irradiance(&scene, &options);
    assert_ne!(with, without);
    let off = (&with - &without).norm() / with.norm();
    assert!(off < 0.05, "{off}");
}

#[test]
fn what_cannot_be_switched_is_said() {
    let error = |text: &str| text.parse::<Switches>().unwrap_err().to_string();
    for (text, what) in [("-fog", "fog"), ("mirror", "neither"), ("+sky,-sky", "both"), ("", "neither")] {
        let message = error(text);
        assert!(message.contains(what) && message.contains("back-sides"), "{message}");
    }
    assert_eq!("auto".parse::<Switches>(), Ok(Switches::default()));
    let (_, told) = switched(mesh("cornell_box"), "+mirror,+colour");
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("no mirror"), "{told:?}");
}

#[test]
fn where_nothing_reflects_or_emits_form_factors_are_not_asked_for() {
    let walls: Vec<_> = room([0.0; 3], [3.0; 3])[..5].iter().map(|&quad| (quad, 0)).collect();
    let under_sky = |reflectance: f64, emission: f64| {
        let material = Material::lamp("wall", &[reflectance], &[emission]);
        lit_quads(&walls, vec![material], vec![], Some(crate::scenes::sky(SkyKind::Overcast, 1.0)))
    };
    assert!(under_sky(0.1, 0.0).has_exchange() && under_sky(0.0, 0.1).has_exchange());
    assert!(!under_sky(0.1, 0.1).without(Feature::Interreflection).has_exchange());
    let black = under_sky(0.0, 0.0);
    assert!(!black.has_exchange());
    // With and without rows the answer has the same bits, and its energy balances.
    let tracer = Tracer::new(&black);
    for basis in BASES {
        let mut patches = cut_into(&tracer, 300);
        let options = TraceOptions { basis, ..Default::default() };
        let traced = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let answer = |factors: &FormFactors| {
            let problem = Problem::new(&tracer, &patches, factors, &LightOptions::default()).unwrap();
            let solution = problem.solve(&SolveOptions::default()).unwrap();
            let energy = Energy::of(&problem, &solution.radiance);
            assert!(energy.imbalance < 1e-12 && energy.emitted[0] > 0.0, "{basis:?} {energy:?}");
            solution.irradiance
        };
        assert_eq!(answer(&traced), answer(&FormFactors::none(&patches, basis)), "{basis:?}");
    }
}
