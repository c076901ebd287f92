//! Sheets that let light through: closed forms, energy, every solver, light paths, bad input.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use radiosity::measure::{Budget, Energy, ErrorBars, PathOptions, PathTracer};
use radiosity::patches::{Basis, PatchSize, Patches, Reach, Sheets, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Material, Scene, Side};
use radiosity::solve::{self, CgOptions, DirectOptions, NeumannOptions, Solution};
use radiosity::trace::Tracer;
use radiosity::transport::{
    Exchange, FormFactors, Keep, Reflection, Sources, Storage, StorageKind, TraceOptions, Transport,
};

use crate::scenes::{quads, room};

const BASES: [Basis; 2] = [Basis::Constant, Basis::Linear];

/// Every solver's answer, to a residual of 1e-11.
fn every_solver(k: &Transport, e: &DMatrix<f64>) -> [Solution; 3] {
    let cg = CgOptions { tolerance: 1e-11, ..Default::default() };
    let neumann = NeumannOptions { tolerance: 1e-11, ..Default::default() };
    [
        solve::direct(k, &DirectOptions::default()).unwrap().solve(e),
        solve::conjugate_gradients(k, e, &cg).unwrap(),
        solve::neumann(k, e, &neumann).unwrap().solution,
    ]
}

fn difference(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    (a - b).amax() / b.amax()
}

/// Two cubes of 1 m that share a wall, the first with material 0 and a lamp 2 in its ceiling, the second with material 1; the shared wall has material 3
/// and fronts the first.
fn two_cubes(materials: [Material; 4]) -> Scene {
    let mut faces: Vec<_> = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0)).to_vec();
    // Of the second cube without the wall at x = 1.
    faces.extend(room([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]).into_iter().skip(1).map(|quad| (quad, 1)));
    // The wall at x = 1 of the first.
    faces[3].1 = 3;
    let lamp = [[0.3, 0.8, 0.3], [0.7, 0.8, 0.3], [0.7, 0.8, 0.7], [0.3, 0.8, 0.7]];
    faces.push((lamp, 2));
    quads(&faces, materials.to_vec())
}

/// Two cubes as they usually are here, around this wall.
fn around(wall: Material) -> Scene {
    let first = Material::diffuse("first", &[0.7, 0.5, 0.3]);
    let second = Material::diffuse("second", &[0.4, 0.6, 0.8]);
    two_cubes([first, second, Material::lamp("lamp", &[0.0; 3], &[3.0, 2.0, 1.0]), wall])
}

fn paper() -> Material {
    Material::diffuse("paper", &[0.5, 0.4, 0.3]).with_sheet(&[0.2, 0.4, 0.6], &[0.25, 0.3, 0.2])
}

/// Lets through more than it reflects.
fn gauze() -> Material {
    Material::diffuse("gauze", &[0.1, 0.0, 0.2]).with_sheet(&[0.0, 0.05, 0.2], &[0.8, 0.7, 0.6])
}

fn factors<'s>(scene: &'s Scene, size: PatchSize, (basis, rays): (Basis, u32)) -> (Patches<'s>, FormFactors) {
    let tracer = Tracer::new(scene);
    let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
    let options = TraceOptions { rays: Some(rays), basis, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    (patches, factors)
}

#[test]
fn a_furnace_is_exact_on_both_sides_of_a_sheet() {
    let passed_on = 0.8;
    for (front, back, through) in [(0.3, 0.3, 0.5), (0.0, 0.0, 0.8), (0.8, 0.8, 0.0), (0.7, 0.7, 0.1)] {
        let wall = Material::diffuse("wall", &[passed_on]);
        let lamp = Material::lamp("lamp", &[passed_on], &[1.0]);
        let sheet = Material::diffuse("sheet", &[front]).with_sheet(&[back], &[through]);
        let scene = two_cubes([wall.clone(), Material { name: "other wall".into(), ..wall }, lamp, sheet]);
        let tracer = Tracer::new(&scene);
        for basis in BASES {
            let options =
                Tessellation { size: PatchSize::Count(300), reach: Reach::Everything, ..Default::default() };
            let mut patches = Patches::new(&tracer, &options).unwrap();
            let options = TraceOptions { rays: Some(128), basis, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let k = Transport::of(&factors, &patches).unwrap();
            let e = DMatrix::repeat(k.len(), 1, 1.0);
            for solution in every_solver(&k, &e) {
                let name = solution.report.name;
                assert_eq!(name == "minres", name != "direct" && name != "neumann" && through > front);
                let exact = 1.0 / (1.0 - passed_on);
                let worst = solution.radiance.iter().map(|l| (l / exact - 1.0).abs()).fold(0.0, f64::max);
                assert!(worst < 1e-9, "{front} {back} {through} {basis:?} {name}: {worst}");
            }
        }
    }
}

/// Two spheres, each of a wall and a window that joins them, with even exchange within each: patches wall, window front, window back, wall, in
/// the order given.
fn joined_spheres(order: [usize; 4], rho: [f64; 4], tau: f64) -> (FormFactors, DMatrix<f64>, Sheets) {
    const AREAS: [f64; 4] = [3.0, 0.5, 0.5, 2.0];
    let at = |i: usize| order.iter().position(|&k| k == i).unwrap();
    let sphere = |i: usize| i / 2;
    let whole = |i: usize| AREAS[2 * sphere(i)] + AREAS[2 * sphere(i) + 1];
    let exchange = |a: usize, b: usize| {
        let [i, j] = [order[a], order[b]];
        if sphere(i) == sphere(j) { (AREAS[i] * AREAS[j] / whole(i)) as f32 } else { 0.0 }
    };
    let areas = DVector::from_fn(4, |a, _| AREAS[order[a]]);
    let storage = Storage::Dense(DMatrix::from_fn(4, 4, exchange));
    let exchange =
        Exchange::new(storage, DVector::zeros(4), areas, &[false; 4], Progress::default()).unwrap();
    let reflectance = DMatrix::from_fn(4, 1, |a, _| rho[order[a]]);
    let sheets = Sheets { pairs: vec![[at(1), at(2)]], transmittance: DMatrix::repeat(1, 1, tau) };
    (exchange.into(), reflectance, sheets)
}

#[test]
fn two_spheres_joined_by_a_translucent_window_have_their_closed_form() {
    for (rho, tau) in [
        ([0.6, 0.5, 0.3, 0.4], 0.25),
        ([0.6, 0.0, 0.0, 0.9], 1.0),
        ([0.9, 0.1, 0.3, 0.2], 0.7),
        ([0.5, 0.7, 0.0, 0.5], 0.3),
    ] {
        // What is lost in each sphere, and what goes through, per irradiance:
        // H₁ (A₁(1 − ρ₁) + a(1 − ρ_f)) − aτ H₂ = A₁πE, H₂ (A₂(1 − ρ₂) + a(1 − ρ_b)) = aτ H₁.
        let [first, second] =
            [3.0 * (1.0 - rho[0]) + 0.5 * (1.0 - rho[1]), 2.0 * (1.0 - rho[3]) + 0.5 * (1.0 - rho[2])];
        let through = 0.5 * tau;
        let h1 = 3.0 * PI / (first - through * through / second);
        let h2 = through / second * h1;
        let exact = [
            1.0 + rho[0] * h1 / PI,
            (rho[1] * h1 + tau * h2) / PI,
            (rho[2] * h2 + tau * h1) / PI,
            rho[3] * h2 / PI,
        ];
        for order in [[0, 1, 2, 3], [2, 0, 3, 1], [3, 2, 1, 0], [1, 3, 0, 2]] {
            let (factors, reflectance, sheets) = joined_spheres(order, rho, tau);
            let k = Transport::new(&factors, Reflection { reflectance, sheets: Some(sheets) }).unwrap();
            let e = DMatrix::from_fn(4, 1, |a, _| if order[a] == 0 { 1.0 } else { 0.0 });
            for solution in every_solver(&k, &e) {
                for (a, &i) in order.iter().enumerate() {
                    let found = solution.radiance[a];
                    assert!(
                        (found - exact[i]).abs() < 1e-7,
                        "{rho:?} {tau} {order:?} {}: {found} for {}",
                        solution.report.name,
                        exact[i]
                    );
                }
                let energy = Energy::new(&k, &e, &solution.radiance, 1.0);
                assert!(energy.imbalance < 1e-9, "{energy:?}");
            }
        }
    }
}

#[test]
fn every_solver_finds_the_same_light_through_sheets_and_none_of_it_is_lost() {
    for wall in [paper(), gauze()] {
        let scene = around(wall);
        for (basis, storage) in [
            (Basis::Constant, StorageKind::Dense),
            (Basis::Constant, StorageKind::Sparse),
            (Basis::Linear, StorageKind::Auto),
        ] {
            let tracer = Tracer::new(&scene);
            let size = PatchSize::Count(500);
            let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
            let options = TraceOptions { rays: Some(128), basis, storage, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let k = Transport::of(&factors, &patches).unwrap();
            let e = basis.coefficients_of(&patches.sources());
            let solutions = every_solver(&k, &e);
            for solution in &solutions {
                let off = difference(&solution.radiance, &solutions[0].radiance);
                assert!(off < 1e-9, "{basis:?} {storage:?} {}: {off}", solution.report.name);
                assert!(solution.report.residual < 1e-10, "{:?}", solution.report);
                let energy = Energy::new(&k, &e, &solution.radiance, 1.0);
                assert!(energy.imbalance < 1e-9, "{basis:?} {}: {energy:?}", solution.report.name);
            }
        }
    }
}

#[test]
fn light_through_sheets_adds_up() {
    let scene = around(gauze());
    let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Linear, 128));
    let k = Transport::of(&factors, &patches).unwrap();
    let e = Basis::Linear.coefficients_of(&patches.sources());
    let half = DMatrix::from_fn(e.nrows(), e.ncols(), |i, _| f64::from(i as u32 % 3));
    let solver = solve::direct(&k, &DirectOptions::default()).unwrap();
    let [whole, one, other] = [&e * 2.0 + &half, e, half].map(|e| solver.solve(&e).radiance);
    assert!(difference(&(2.0 * one + other), &whole) < 1e-12);
}

#[test]
fn light_comes_through_a_translucent_wall_and_through_no_other() {
    let lit_behind = |wall: Material| {
        let scene = around(wall);
        let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Constant, 64));
        let k = Transport::of(&factors, &patches).unwrap();
        let solution = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&patches.sources());
        let behind = |i: usize| {
            let place = patches.place(i);
            let material = &scene.material_of(place.face).name;
            material == "second" || (place.side == Side::Back && material != "lamp")
        };
        let behind: Vec<usize> = (0..patches.len()).filter(|&i| behind(i)).collect();
        let least = behind.iter().map(|&i| solution.irradiance[(i, 0)]).fold(f64::INFINITY, f64::min);
        (behind.len(), least)
    };
    let (patches, least) = lit_behind(paper());
    assert!(patches > 50 && least > 0.0, "{patches} {least}");
    for opaque in [
        Material::diffuse("card", &[0.5; 3]),
        Material::diffuse("card", &[0.5; 3]).with_sheet(&[0.9; 3], &[0.0; 3]),
    ] {
        assert_eq!(lit_behind(opaque).0, 0);
    }
}

#[test]
fn each_side_reflects_by_itself() {
    // Two lamps of their own on both sides of an opaque card.
    let card = Material::diffuse("card", &[0.8]).with_sheet(&[0.1], &[0.0]);
    let lamp = Material::lamp("lamp", &[0.0], &[1.0]);
    let square = |y: f64| [[0.0, y, 0.0], [0.0, y, 1.0], [1.0, y, 1.0], [1.0, y, 0.0]];
    let faces = [(square(0.0), 1), (square(0.5), 0), (crate::scenes::flipped(square(1.0)), 1)];
    let scene = quads(&faces, vec![card, lamp]);
    let (patches, factors) = factors(&scene, PatchSize::Edge(0.3), (Basis::Constant, 256));
    let k = Transport::of(&factors, &patches).unwrap();
    assert!(k.sheets().is_none());
    let solution = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&patches.sources());
    for i in (0..patches.len()).filter(|&i| scene.material_of(patches.place(i).face).name == "card") {
        let rho = if patches.place(i).side == Side::Front { 0.8 } else { 0.1 };
        let found = solution.radiance[i] * PI / solution.irradiance[i];
        assert!((found - rho).abs() < 1e-12, "{found} {rho}");
    }
}

#[test]
fn radiance_is_what_is_reflected_and_what_comes_through() {
    let scene = around(paper());
    let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Constant, 64));
    let k = Transport::of(&factors, &patches).unwrap();
    let e = patches.sources();
    for solution in every_solver(&k, &e) {
        let Sheets { pairs, .. } = patches.sheets().unwrap();
        for [front, back] in pairs {
            for c in 0..3 {
                let [h, behind] = [front, back].map(|i| solution.irradiance[(i, c)]);
                let leaves = [
                    paper().reflectance[c] * h + paper().transmittance().unwrap()[c] * behind,
                    paper().reflectance_of(Side::Back)[c] * behind + paper().transmittance().unwrap()[c] * h,
                ];
                for (i, exact) in [front, back].into_iter().zip(leaves) {
                    let found = solution.radiance[(i, c)];
                    assert!((found * PI - exact).abs() < 1e-12, "{found} {exact}");
                }
            }
        }
    }
}

#[test]
fn light_paths_through_sheets_agree_with_the_matrix() {
    for wall in [paper(), gauze()] {
        let scene = around(wall);
        let tracer = Tracer::new(&scene);
        for basis in BASES {
            let size = PatchSize::Count(2000);
            let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
            let options = TraceOptions { rays: Some(512), basis, keep: Keep::Rays, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let k = Transport::of(&factors, &patches).unwrap();
            let sources: Sources = basis.coefficients_of(&patches.sources()).into();
            let e = sources.right_hand_side(&k);
            let solution = solve::conjugate_gradients(&k, &e, &CgOptions::default()).unwrap();
            let bars = ErrorBars::of(&patches, &factors, &sources, &solution, Progress::default()).unwrap();
            let budget = Budget { paths: Some(1_000_000), ..Budget::default() };
            let options = PathOptions { budget, ..Default::default() };
            let traced = PathTracer::new(&tracer).irradiance(&patches, &options).unwrap();
            let ours = patches.average_by_face(&basis.means(&solution.irradiance));
            for ((ours, bar), theirs) in ours.iter().zip(&bars.faces).zip(traced.by_face(&patches)) {
                for c in 0..3 {
                    let (mean, error) = (ours.mean[c], bar.mean[c].hypot(theirs.standard_error[c]));
                    let z = (mean - theirs.mean[c]) / error;
                    let place = (basis, ours.face, ours.side, c);
                    // Larger by chance in one of 60 000 cases, of which these are 300.
                    assert!(z.abs() < 4.3, "{place:?}: {mean} ± {error}, light paths {}", theirs.mean[c]);
                    assert!(error < 0.05 * mean, "{place:?}: {mean} ± {error}");
                }
            }
        }
    }
}
