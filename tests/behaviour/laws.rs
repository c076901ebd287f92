//! Laws that every answer obeys, whatever the mesh, the storage and the solver.

use glam::{DQuat, DVec3};
use nalgebra::{DMatrix, DVector};
use radiosity::measure::{Energy, RelativeRms};
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::scene::{Material, Scene};
use radiosity::solve::{
    self, Certainty, CgOptions, DirectOptions, Method, NeumannOptions, Problem, Solution, SolveOptions,
};
use radiosity::transport::{Exchange, FormFactors, Sources, StorageKind, Transport};

use crate::scenes::{
    BASES, STORAGES, difference, every_solver_to, factors_of, kinds, load, mesh, moved, on_threads, quads,
    reference, room,
};

const MESHES: [&str; 6] =
    ["cornell_box", "furnace_cube", "furnace_sphere", "facing_plates", "two_rooms", "furnished_room"];

fn factors<'s>(
    scene: &'s Scene,
    count: usize,
    rays: u32,
    storage: StorageKind,
) -> (Patches<'s>, FormFactors) {
    factors_of(scene, PatchSize::Count(count), rays, (Basis::Constant, storage))
}

/// Every solver's answer, to a residual of 1e-10 or better.
fn every_solver(k: &Transport, e: &DMatrix<f64>) -> [Solution; 3] {
    every_solver_to(1e-10, k, e)
}

/// The largest over channels of √(∫ (a − b)² dA / ∫ b² dA).
fn difference_in_mean_square(k: &Transport, a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    let norm = |x: &DMatrix<f64>, c: usize| k.mass().root_mean_square(x.column(c));
    (0..b.ncols()).map(|c| norm(&(a - b), c) / norm(b, c)).fold(0.0, f64::max)
}

/// n numbers between 0 and 1 without pattern.
fn numbers(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    (0..n)
        .map(|_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        })
        .collect()
}

#[test]
fn a_furnace_is_exact_in_every_patch_and_at_every_order() {
    for name in ["furnace_cube", "furnace_sphere"] {
        let scene = mesh(name);
        let (rho, emitted) = (scene.materials()[0].reflectance[0], scene.materials()[0].emission[0]);
        for (basis, storage) in kinds() {
            let (patches, factors) = factors_of(&scene, PatchSize::Count(600), 64, (basis, storage));
            let k = Transport::of(&factors, &patches).unwrap();
            let e = basis.coefficients_of(&patches.emitted_radiance());
            let exact = emitted / (1.0 - rho);
            for solution in every_solver(&k, &e) {
                let worst = solution.radiance.iter().map(|l| (l / exact - 1.0).abs()).fold(0.0, f64::max);
                assert!(worst < 1e-8, "{name} {basis:?} {storage:?} {}: {worst}", solution.report.name);
            }
            for order in 0..12 {
                let options = NeumannOptions { order, tolerance: 0.0, ..Default::default() };
                let series = solve::neumann(&k, &e, &options).unwrap();
                let exact = emitted * (1.0 - rho.powi(order as i32 + 1)) / (1.0 - rho);
                let worst =
                    series.solution.radiance.iter().map(|l| (l / exact - 1.0).abs()).fold(0.0, f64::max);
                assert!(series.order() == order && worst < 1e-11, "{name} {basis:?} order {order}: {worst}");
            }
        }
    }
}

#[test]
fn the_ideal_sphere_has_its_closed_form_at_every_order() {
    let areas = DVector::from_vec(numbers(40, 1)).add_scalar(0.05);
    let emitted = numbers(40, 2);
    let mean = areas.iter().zip(&emitted).map(|(a, e)| a * e).sum::<f64>() / areas.sum();
    let sphere = FormFactors::from(Exchange::ideal_sphere(areas));
    for rho in [0.0, 0.3, 0.9, 0.999] {
        let k = Transport::new(&sphere, DMatrix::repeat(40, 1, rho)).unwrap();
        let e = DMatrix::from_column_slice(40, 1, &emitted);
        let exact = e.map(|e| e + rho * mean / (1.0 - rho));
        let direct = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&e);
        // The matrix is stored in f32; what that costs is amplified by 1/(1 − ρ) at most.
        assert!(difference(&direct.radiance, &exact) < 1e-6);
        for order in [0, 1, 2, 7] {
            let options = NeumannOptions { order, tolerance: 0.0, ..Default::default() };
            let series = solve::neumann(&k, &e, &options).unwrap();
            let missing = mean * rho.powi(order as i32 + 1) / (1.0 - rho);
            let error = &exact - &series.solution.radiance;
            assert!(
                error.iter().all(|x| (x - missing).abs() < 1e-6 * exact.amax()),
                "ρ = {rho}, order {order}"
            );
        }
    }
}

#[test]
fn the_solvers_agree_and_energy_balances_on_every_mesh() {
    for name in MESHES {
        let scene = mesh(name);
        for (basis, storage) in kinds() {
            let (patches, factors) = factors_of(&scene, PatchSize::Count(500), 128, (basis, storage));
            let k = Transport::of(&factors, &patches).unwrap();
            let e = basis.coefficients_of(&patches.emitted_radiance());
            let [direct, cg, series] = every_solver(&k, &e);
            for other in [&cg, &series] {
                let off = difference(&other.radiance, &direct.radiance);
                assert!(off < 1e-8, "{name} {basis:?} {storage:?} {}: {off}", other.report.name);
                let report = &other.report;
                // A guaranteed bound is tight in a furnace and holds in exact arithmetic: allow for rounding.
                let (off, most) = match report.certainty {
                    Certainty::Guaranteed => (off, report.bound * (1.0 + 1e-4) + 1e-14),
                    Certainty::Estimated => {
                        (difference_in_mean_square(&k, &other.radiance, &direct.radiance), 2.0 * report.bound)
                    }
                };
                assert_eq!(report.certainty == Certainty::Guaranteed, basis == Basis::Constant);
                assert!(off <= most, "{name} {basis:?} {}: {off} exceeds its bound {report:?}", report.name);
            }
            let energy = Energy::new(&k, &e, &direct.radiance);
            assert!(energy.imbalance < 1e-9, "{name} {basis:?} {storage:?}: {energy:?}");
            assert!(energy.emitted.iter().all(|&x| x > 0.0));
        }
    }
}

#[test]
fn radiance_is_emission_and_reflected_irradiance_row_by_row() {
    let scene = mesh("cornell_box");
    for basis in BASES {
        let (patches, factors) = factors_of(&scene, PatchSize::Count(400), 64, (basis, StorageKind::Auto));
        let k = Transport::of(&factors, &patches).unwrap();
        let e = basis.coefficients_of(&patches.emitted_radiance());
        for solution in every_solver(&k, &e) {
            let composed = &e + k.reflect(&solution.irradiance);
            assert!(difference(&composed, &solution.radiance) < 1e-15);
        }
    }
}

#[test]
fn light_of_two_lamps_is_the_sum_of_either() {
    let scene = mesh("furnished_room");
    let (patches, factors) = factors(&scene, 800, 64, StorageKind::Auto);
    let k = Transport::of(&factors, &patches).unwrap();
    let n = patches.len();
    let lamps = [3, 4].map(|seed| DMatrix::from_vec(n, 3, numbers(3 * n, seed)));
    for (one, other, both) in [every_solver(&k, &lamps[0])]
        .into_iter()
        .zip([every_solver(&k, &lamps[1])])
        .zip([every_solver(&k, &(&lamps[0] + &lamps[1]))])
        .flat_map(|((a, b), c)| a.into_iter().zip(b).zip(c).map(|((a, b), c)| (a, b, c)))
    {
        assert!(difference(&(one.radiance + other.radiance), &both.radiance) < 1e-8, "{}", both.report.name);
    }
}

#[test]
fn channels_do_not_touch_each_other() {
    let scene = mesh("cornell_box");
    let (patches, factors) = factors(&scene, 400, 64, StorageKind::Auto);
    let all = Transport::of(&factors, &patches).unwrap();
    let e = patches.emitted_radiance();
    let together = every_solver(&all, &e);
    for c in 0..3 {
        let alone = Transport::new(&factors, patches.reflectances().columns(c, 1).into_owned()).unwrap();
        for (one, three) in every_solver(&alone, &e.columns(c, 1).into_owned()).iter().zip(&together) {
            assert!(difference(&three.radiance.columns(c, 1).into_owned(), &one.radiance) < 1e-8);
        }
    }
}

#[test]
fn reciprocity_holds_to_the_last_bit_and_rows_close() {
    for name in ["two_rooms", "cornell_box"] {
        let scene = mesh(name);
        for kind in kinds() {
            let (patches, factors) = factors_of(&scene, PatchSize::Count(500), 64, kind);
            let exchange = factors.exchange();
            let each = kind.0.coefficients();
            assert_eq!(exchange.len(), each * patches.len());
            for i in 0..exchange.len() {
                for j in 0..i {
                    let (there, back) = (exchange.exchange_area(i, j), exchange.exchange_area(j, i));
                    assert_eq!(there.to_bits(), back.to_bits());
                    assert!(there >= 0.0 && (there == 0.0 || i / each != j / each), "no patch sees itself");
                }
                assert_eq!(exchange.form_factor(i, i), 0.0, "a flat patch does not see itself");
            }
            assert_eq!(exchange.reciprocity_error(), 0.0);
            assert!(exchange.closure_error() < 1e-12);
            assert!(exchange.closure().before > 1e-3, "rays alone do not close");
        }
    }
}

#[test]
fn dense_and_sparse_hold_the_same_operator() {
    let scene = mesh("two_rooms");
    for basis in BASES {
        let [dense, sparse] =
            STORAGES.map(|storage| factors_of(&scene, PatchSize::Count(500), 64, (basis, storage)).1);
        let (dense, sparse) = (dense.exchange(), sparse.exchange());
        assert_eq!((dense.storage_name(), sparse.storage_name()), ("dense", "sparse"));
        // Of linear elements a single ray keeps more digits where it is kept as such; closing the rows passes
        // that on.
        let digits = if basis == Basis::Constant { 1e-12 } else { 1e-6 };
        let mut from_row = vec![0.0; dense.len()];
        for i in 0..dense.len() {
            from_row.fill(0.0);
            sparse.for_row(i, |j, s| from_row[j] = s);
            for (j, s) in from_row.iter().enumerate() {
                let (a, b) = (dense.exchange_area(i, j), sparse.exchange_area(i, j));
                assert!((a - b).abs() <= digits * a, "{basis:?}: {a} {b}");
                assert_eq!(*s, b);
            }
        }
        // The product knows the same numbers as the entries.
        let x = DMatrix::from_vec(dense.len(), 2, numbers(2 * dense.len(), 5));
        let through = sparse.times(&x);
        let mut summed = DMatrix::zeros(dense.len(), 2);
        for i in 0..dense.len() {
            sparse.for_row(i, |j, s| (0..2).for_each(|c| summed[(i, c)] += s * x[(j, c)]));
        }
        assert!(difference(&through, &summed) < 1e-13, "{basis:?}");
    }
}

#[test]
fn size_and_place_of_a_scene_do_not_matter() {
    let scene = mesh("two_rooms");
    let answer = |scene: &Scene| {
        let (patches, factors) = factors(scene, 500, 64, StorageKind::Auto);
        let k = Transport::of(&factors, &patches).unwrap();
        every_solver(&k, &patches.emitted_radiance())[0].radiance.clone()
    };
    let usual = answer(&scene);
    for scale in [1e-6, 1e6] {
        let off = difference(&answer(&moved(&scene, |p| p * scale)), &usual);
        assert!(off < 1e-6, "scaled by {scale}: {off}");
    }
    let far = DVec3::new(4e6, -7e6, 5e6);
    let off = difference(&answer(&moved(&scene, |p| p + far)), &usual);
    assert!(off < 1e-4, "moved: {off}");
}

#[test]
fn closed_meshes_let_no_ray_out() {
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
    let far = DVec3::new(1000.0, -2000.0, 500.0);
    let turned = moved(&mesh("furnace_cube"), |p| turn * p + far);
    for scene in [mesh("furnace_cube"), mesh("furnace_sphere"), mesh("two_rooms"), turned] {
        let (patches, factors) = factors(&scene, 500, 2048, StorageKind::Auto);
        assert!(patches.len() >= 400);
        assert_eq!(factors.exchange().leaving().amax(), 0.0, "{}", scene.name());
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let scene = mesh("cornell_box");
    let answer = |threads: usize| {
        on_threads(threads, || {
            let answer = |kind: (Basis, StorageKind)| {
                let (patches, factors) = factors_of(&scene, PatchSize::Count(500), 64, kind);
                let k = Transport::of(&factors, &patches).unwrap();
                every_solver(&k, &kind.0.coefficients_of(&patches.emitted_radiance())).map(|s| s.radiance)
            };
            kinds().map(answer).collect::<Vec<_>>()
        })
    };
    let one = answer(1);
    for threads in [2, 5] {
        assert!(answer(threads) == one, "{threads} threads");
    }
}

#[test]
fn the_cornell_box_agrees_with_an_independent_path_tracer() {
    let scene = load("tests/data/cornell.obj");
    let (patches, factors) = factors(&scene, 20_000, 512, StorageKind::Auto);
    let k = Transport::of(&factors, &patches).unwrap();
    let solution =
        solve::conjugate_gradients(&k, &patches.emitted_radiance(), &CgOptions::default()).unwrap();
    let faces = patches.average_by_face(&solution.irradiance);
    let rms = RelativeRms::of(&faces, &reference("cornell"));
    assert!(rms.compared == 3 * 38 && rms.value < 0.005, "{rms:?}");
}

#[test]
fn lamp_groups_add_up_to_the_whole() {
    let panel = |x: f64| [[x, 0.9, 0.4], [x + 0.2, 0.9, 0.4], [x + 0.2, 0.9, 0.6], [x, 0.9, 0.6]];
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let all: Vec<_> = walls.into_iter().chain([(panel(0.1), 1), (panel(0.7), 2)]).collect();
    let lamp = |name: &str, emission: [f64; 3]| Material::lamp(name, &[0.2, 0.1, 0.0], &emission);
    let wall = Material::diffuse("wall", &[0.7, 0.5, 0.3]);
    let scene = quads(&all, vec![wall, lamp("warm", [5.0, 3.0, 1.0]), lamp("cold", [1.0, 3.0, 5.0])]);
    let (patches, factors) = factors(&scene, 400, 64, StorageKind::Auto);
    let problem = Problem::unlit(&patches, &factors).unwrap();
    let groups = patches.lamp_groups();
    assert_eq!(groups.iter().map(|g| g.material.as_str()).collect::<Vec<_>>(), ["warm", "cold"]);
    let sources = [&patches.emitted_radiance(), &groups[0].emitted, &groups[1].emitted];
    let [whole, warm, cold] = sources.map(|emitted| Sources::from(emitted.clone()));
    for method in [Method::Direct, Method::ConjugateGradients, Method::Neumann] {
        let options = SolveOptions { method, tolerance: 1e-10, ..Default::default() };
        let all = problem.solve_each(&[&whole, &warm, &cold], &options).unwrap();
        assert!(difference(&(&all[1].radiance + &all[2].radiance), &all[0].radiance) < 1e-8, "{method:?}");
        assert!(difference(&(&all[1].irradiance + &all[2].irradiance), &all[0].irradiance) < 1e-8);
    }
}
