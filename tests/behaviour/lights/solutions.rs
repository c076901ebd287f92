//! Rooms under lights and skies, solved: reflected light, energy, light paths, the same bits.

use glam::DVec3;
use radiosity::measure::{Energy, RelativeRms};
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::reference::PathTracer;
use radiosity::scene::{Light, Scene, Sky, SkyKind};
use radiosity::solve::{self, CgOptions, DirectOptions, NeumannOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, Sources, TraceOptions};

use super::room_with_window;
use crate::scenes::{BASES, cut, grey, lit_quads, on_threads, paths, point, sky, sun};

/// A room with a window under every kind of light.
fn daylit_room() -> Scene {
    let towards = [0.2, 0.8, -0.9];
    let lights = vec![
        sun(towards.map(|x| -x), 30.0, 4.0),
        point([1.0, 2.0, 2.5], &[2.0]),
        Light::Spot {
            position: DVec3::new(2.5, 2.9, 2.0),
            direction: DVec3::new(-0.4, -1.0, 0.0).normalize(),
            intensity: vec![9.0],
            cone: 40.0,
            penumbra: 15.0,
        },
    ];
    let kind = SkyKind::Clear { sun: DVec3::from(towards).normalize() };
    lit_quads(&room_with_window(), grey(0.6), lights, Some(Sky { ground: 0.2, ..sky(kind, 5.0) }))
}

fn problem(scene: &Scene, count: usize, basis: Basis) -> (Tracer<'_>, Patches<'_>, Problem) {
    let tracer = Tracer::new(scene);
    let mut patches = cut(&tracer, PatchSize::Count(count));
    let options = TraceOptions { rays: Some(128), basis, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
    (tracer, patches, problem)
}

#[test]
fn radiance_is_emission_and_reflected_irradiance_under_lights_without_area_too() {
    let scene = daylit_room();
    for basis in BASES {
        let (_, _, problem) = problem(&scene, 400, basis);
        let cg = CgOptions { tolerance: 1e-11, ..Default::default() };
        let answers =
            [problem.direct(&DirectOptions::default()).unwrap(), problem.conjugate_gradients(&cg).unwrap()];
        let orders = (0..4).map(|order| {
            let options = NeumannOptions { order, tolerance: 0.0, ..Default::default() };
            problem.neumann(&options).unwrap().solution
        });
        for solution in answers.iter().cloned().chain(orders) {
            let composed = &problem.sources().emitted + problem.operator().reflect(&solution.irradiance);
            let off = (&composed - &solution.radiance).amax() / solution.radiance.amax();
            assert!(off < 1e-14, "{basis:?} {}: {off}", solution.report.name);
        }
        let energy = Energy::of(&problem, &answers[0].radiance);
        assert!(energy.imbalance < 1e-9 && energy.emitted[0] > 0.0, "{basis:?} {energy:?}");
        let order_0 = NeumannOptions { order: 0, tolerance: 0.0, ..Default::default() };
        let order_0 = problem.neumann(&order_0).unwrap().solution;
        assert_eq!(Some(order_0.irradiance), problem.sources().direct);
    }
}

#[test]
fn the_path_tracer_finds_the_same_light_by_its_own_samples() {
    let scene = daylit_room();
    let (tracer, patches, problem) = problem(&scene, 6000, Basis::Constant);
    let solution = problem.conjugate_gradients(&CgOptions::default()).unwrap();
    let faces = patches.average_by_face(&solution.irradiance);
    let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(1_500_000)).unwrap();
    let rms = RelativeRms::of(&faces, &traced.by_face(&patches));
    assert!(rms.compared >= 18 && rms.value < 0.01, "{rms:?}");
    // And bounce by bounce: bounce 1 is what E sends.
    let k = problem.operator();
    for bounce in 1..=2 {
        let terms = solve::bounces(k, problem.right_hand_side(), bounce - 1);
        let h = k.irradiance(&terms[bounce - 1]);
        let whole =
            |of: &dyn Fn(usize) -> f64| (0..patches.len()).map(|i| patches.area(i) * of(i)).sum::<f64>();
        let by_paths = whole(&|i| traced.irradiance_by_bounce(bounce, i, 0).mean);
        let by_matrix = whole(&|i| h[i]);
        assert!((by_paths / by_matrix - 1.0).abs() < 0.01, "bounce {bounce}: {by_paths} {by_matrix}");
    }
}

#[test]
fn scenes_without_such_lights_have_no_direct_irradiance() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(300));
    let sources = Sources::trace(&tracer, &patches, Basis::Constant, &LightOptions::default()).unwrap();
    assert_eq!((sources.direct, sources.emitted), (None, patches.emitted_radiance()));
}

#[test]
fn the_same_seed_gives_the_same_light_on_any_number_of_threads() {
    let scene = daylit_room();
    let answer = |threads: usize| {
        on_threads(threads, || BASES.map(|basis| problem(&scene, 300, basis).2.sources().clone()))
    };
    assert!(answer(1) == answer(3));
}
