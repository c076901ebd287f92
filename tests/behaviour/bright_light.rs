//! Bright light: what a small spot of light sends on, by points drawn on it.

use glam::DVec3;
use radiosity::measure::{Energy, ErrorBars};
use radiosity::patches::{Basis, Patches};
use radiosity::progress::Progress;
use radiosity::scene::{Light, Material, Scene};
use radiosity::solve::{CgOptions, DirectOptions, NeumannOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, Sources, TraceOptions};

use crate::scenes::{cut_into, difference, flipped, lit_quads, room, square};

const SEEDS: u64 = 8;

/// A room with a table under which the light of a spot on the floor spreads; walls in two colours.
fn scene(intensity: f64) -> Scene {
    let table = square(1.0, 0.7).map(|[x, y, z]| [x + 2.6, y, z + 2.4]);
    let walls = room([0.0; 3], [4.0, 3.0, 4.0]).into_iter().zip([0, 1, 0, 1, 0, 0]);
    let quads = walls.chain([(table, 0), (flipped(table.map(|[x, y, z]| [x, y - 0.03, z])), 1)]);
    let materials =
        vec![Material::diffuse("white", &[0.7, 0.6, 0.5]), Material::diffuse("red", &[0.6, 0.2, 0.1])];
    let spot = Light::Spot {
        position: DVec3::new(1.0, 2.9, 1.0),
        direction: DVec3::new(0.1, -1.0, 0.05).normalize(),
        intensity: vec![intensity, 0.8 * intensity, 0.5 * intensity],
        cone: 6.0,
        penumbra: 2.0,
    };
    lit_quads(&quads.collect::<Vec<_>>(), materials, vec![spot], None)
}

/// The problem with what bright patches send, and the same without.
fn problems(scene: &Scene, basis: Basis, seed: u64, check: impl FnOnce(&Patches, [&Problem; 2])) {
    let tracer = Tracer::new(scene);
    let mut patches = cut_into(&tracer, if basis == Basis::Linear { 300 } else { 1200 });
    let options = TraceOptions { rays: Some(256), seed, basis, keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let light = LightOptions { seed, ..Default::default() };
    let problem = Problem::new(&tracer, &patches, &factors, &light).unwrap();
    let without = problem.under(Sources::trace(&tracer, &patches, basis, &light).unwrap());
    check(&patches, [&problem, &without]);
}

#[test]
fn a_small_spot_lights_the_room_the_same_with_a_fraction_of_the_noise() {
    let scene = scene(1.0);
    // Per kind, per seed: irradiance of patches but for the spot's own, and what bars say.
    let mut found = [Vec::new(), Vec::new()];
    let mut told = 0.0;
    for seed in 0..SEEDS {
        problems(&scene, Basis::Constant, seed, |patches, kinds| {
            assert!(kinds[0].sources().bright.is_some() && kinds[1].sources().bright.is_none());
            for (k, problem) in kinds.into_iter().enumerate() {
                let solution = problem.direct(&DirectOptions::default()).unwrap();
                // Light that has been reflected once: patches of all seeds are the same.
                let direct = problem.sources().direct.as_ref().unwrap();
                found[k].push((&solution.irradiance - direct).column(0).into_owned());
                if k == 0 {
                    let bars = ErrorBars::of(patches, problem, &solution, Progress::default()).unwrap();
                    told += bars.patches.column(0).norm_squared() / SEEDS as f64;
                }
            }
        });
    }
    let seeds = SEEDS as f64;
    let means = found.each_ref().map(|all| all.iter().sum::<nalgebra::DVector<f64>>() / seeds);
    let variance = |k: usize| {
        found[k].iter().map(|field| (field - &means[k]).norm_squared()).sum::<f64>() / (seeds - 1.0)
    };
    let [with, without] = [0, 1].map(variance);
    assert!(with < 0.1 * without, "{with} {without}");
    // Both are right: means differ by no more than the noise of these.
    let apart = (&means[0] - &means[1]).norm_squared();
    let expected = (with + without) / seeds;
    assert!((0.4..1.6).contains(&(apart / expected)), "{apart} {expected}");
    // Bars hold the noise that is left, and more: how coarse patches are.
    assert!(told > 0.7 * with, "{told} {with}");
}

#[test]
fn it_brings_no_power_and_all_solvers_agree() {
    for basis in [Basis::Constant, Basis::Linear] {
        problems(&scene(1.0), basis, 3, |_, [problem, _]| {
            let k = problem.operator();
            let correction = &problem.sources().bright.as_ref().unwrap().correction;
            let areas = k.mass().areas();
            let flux = correction.tr_mul(&areas).amax();
            assert!(flux < 1e-12 * correction.abs().tr_mul(&areas).amax(), "{basis:?}: {flux}");
            let exact = problem.direct(&DirectOptions::default()).unwrap();
            let energy = Energy::of(problem, &exact.radiance);
            assert!(energy.imbalance < 1e-9, "{basis:?} {energy:?}");
            let cg = CgOptions { tolerance: 1e-10, ..Default::default() };
            let series = NeumannOptions { tolerance: 1e-10, ..Default::default() };
            let others =
                [problem.conjugate_gradients(&cg).unwrap(), problem.neumann(&series).unwrap().solution];
            for other in others {
                let off = difference(&other.irradiance, &exact.irradiance);
                assert!(off < 1e-8, "{basis:?} {}: {off}", other.report.name);
            }
        });
    }
}

#[test]
fn it_arrives_at_order_1() {
    problems(&scene(1.0), Basis::Constant, 3, |_, [problem, without]| {
        let order = |problem: &Problem, order| {
            let options = NeumannOptions { order, tolerance: 0.0, ..Default::default() };
            problem.neumann(&options).unwrap()
        };
        let start = order(problem, 0).solution;
        assert!(difference(&start.irradiance, problem.sources().direct.as_ref().unwrap()) < 1e-12);
        assert!(difference(&start.radiance, &order(without, 0).solution.radiance) < 1e-12);
        // Terms by themselves come to the sum, and as much flux as is told.
        let series = order(problem, 4);
        let terms = problem.bounces(4);
        let sum: nalgebra::DMatrix<f64> = terms.iter().sum();
        assert!(difference(&sum, &series.solution.radiance) < 1e-12);
        let areas = problem.operator().mass().areas();
        for (term, bounce) in terms.iter().zip(&series.bounces) {
            let flux = std::f64::consts::PI * term.column(1).dot(&areas);
            assert!((flux / bounce.flux[1] - 1.0).abs() < 1e-9, "{}: {flux}", bounce.order);
        }
    });
}

#[test]
fn twice_the_light_is_twice_the_answer() {
    let irradiance = |intensity: f64| {
        let mut found = None;
        problems(&scene(intensity), Basis::Constant, 1, |_, [problem, _]| {
            found = Some(problem.direct(&DirectOptions::default()).unwrap().irradiance);
        });
        found.unwrap()
    };
    let (one, two) = (irradiance(1.0), irradiance(2.0));
    assert!(difference(&(0.5 * two), &one) < 1e-12);
}
