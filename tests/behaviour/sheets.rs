//! Sheets that let light through: closed forms, energy, every solver, light paths, bad input.

use std::f64::consts::PI;
use std::io::Cursor;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use radiosity::measure::{Energy, ErrorBars};
use radiosity::patches::{Basis, PatchSize, Patches, Reach, Sheets, Tessellation};
use radiosity::progress::Progress;
use radiosity::reference::{Budget, PathOptions, PathTracer};
use radiosity::render::{self, RenderOptions, Shading};
use radiosity::scene::{Camera, Material, Pixels, Scene, SceneError, SceneParts, Side, Texture, Textures};
use radiosity::solve::{self, CgOptions, DirectOptions, NeumannOptions, Problem, Solution};
use radiosity::trace::Tracer;
use radiosity::transport::{
    Exchange, FormFactors, Keep, LightOptions, Plan, Reflection, Storage, StorageKind, Switches,
    TraceOptions, Transport, TransportError,
};

use crate::scenes::{flipped, quads, room};
use crate::scratch::Scratch;

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

/// Two cubes of 1 m that share a wall, the first with material 0 and a lamp 2 in its ceiling, the second with
/// material 1; the shared wall has material 3 and fronts the first.
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

/// Two spheres, each of a wall and a window that joins them, with even exchange within each: patches wall,
/// window front, window back, wall, in the order given. A channel for each set of reflectances and
/// transmittance.
fn joined_spheres(order: [usize; 4], channels: &[([f64; 4], f64)]) -> (FormFactors, Reflection) {
    const AREAS: [f64; 4] = [3.0, 0.5, 0.5, 2.0];
    let at = |i: usize| order.iter().position(|&k| k == i).unwrap();
    let whole = |i: usize| AREAS[2 * (i / 2)] + AREAS[2 * (i / 2) + 1];
    let exchange = |a: usize, b: usize| {
        let [i, j] = [order[a], order[b]];
        if i / 2 == j / 2 { (AREAS[i] * AREAS[j] / whole(i)) as f32 } else { 0.0 }
    };
    let areas = DVector::from_fn(4, |a, _| AREAS[order[a]]);
    let storage = Storage::Dense(DMatrix::from_fn(4, 4, exchange));
    let exchange =
        Exchange::new(storage, DVector::zeros(4), areas, &[false; 4], Progress::default()).unwrap();
    let reflectance = DMatrix::from_fn(4, channels.len(), |a, c| channels[c].0[order[a]]);
    let transmittance = DMatrix::from_fn(1, channels.len(), |_, c| channels[c].1);
    let sheets = Some(Sheets { pairs: vec![[at(1), at(2)]], transmittance });
    (exchange.into(), Reflection { reflectance, sheets })
}

/// Radiance of the four patches where the first wall emits 1. In irradiance, what each sphere gets is what it
/// loses and what goes through: H₁ (A₁(1 − ρ₁) + a(1 − ρ_f)) − aτ H₂ = A₁πE, H₂ (A₂(1 − ρ₂) + a(1 − ρ_b)) =
/// aτ H₁.
fn in_joined_spheres(&(rho, tau): &([f64; 4], f64)) -> [f64; 4] {
    let first = 3.0 * (1.0 - rho[0]) + 0.5 * (1.0 - rho[1]);
    let second = 2.0 * (1.0 - rho[3]) + 0.5 * (1.0 - rho[2]);
    let through = 0.5 * tau;
    let h1 = 3.0 * PI / (first - through * through / second);
    let h2 = through / second * h1;
    [1.0 + rho[0] * h1 / PI, (rho[1] * h1 + tau * h2) / PI, (rho[2] * h2 + tau * h1) / PI, rho[3] * h2 / PI]
}

#[test]
fn two_spheres_joined_by_a_translucent_window_have_their_closed_form() {
    let channels = [
        ([0.6, 0.5, 0.3, 0.4], 0.25),
        ([0.6, 0.0, 0.0, 0.9], 1.0),
        ([0.9, 0.1, 0.3, 0.2], 0.7),
        ([0.5, 0.7, 0.0, 0.5], 0.3),
        ([0.5, 0.4, 0.4, 0.5], 0.4),
        ([0.5, 0.7, 0.1, 0.5], 0.0),
        ([0.5, 0.7, 0.1, 0.5], 0.2),
        // Shares the factor of the one before.
        ([0.5, 0.7, 0.1, 0.5], 0.2),
    ];
    // Definite alone, and with indefinite ones beside.
    for channels in [&channels[..1], &channels[..]] {
        for order in [[0, 1, 2, 3], [2, 0, 3, 1], [3, 2, 1, 0], [1, 3, 0, 2]] {
            let (factors, reflection) = joined_spheres(order, channels);
            let k = Transport::new(&factors, reflection).unwrap();
            let e = DMatrix::from_fn(4, channels.len(), |a, _| if order[a] == 0 { 1.0 } else { 0.0 });
            for solution in every_solver(&k, &e) {
                for (c, channel) in channels.iter().enumerate() {
                    let exact = in_joined_spheres(channel);
                    for (a, &i) in order.iter().enumerate() {
                        let found = solution.radiance[(a, c)];
                        // Exchange areas are stored in f32.
                        let off = (found - exact[i]).abs();
                        assert!(off < 1e-6, "{channel:?} {order:?} {}: {found}", solution.report.name);
                    }
                }
                let energy = Energy::new(&k, &e, &solution.radiance);
                assert!(energy.imbalance < 1e-9, "{energy:?}");
            }
            let solver = solve::direct(&k, &DirectOptions::default()).unwrap();
            assert_eq!(solver.factorizations(), if channels.len() > 1 { 7 } else { 1 });
        }
    }
}

#[test]
fn light_between_white_walls_and_a_sheet_that_absorbs_nothing_is_trapped() {
    // ρ + τ = 1 all around, also where it comes to 1 but for rounding.
    for (rho, tau) in [([1.0, 0.58, 0.58, 1.0], 0.42), ([1.0, 0.0, 0.0, 1.0], 1.0)] {
        let (factors, reflection) = joined_spheres([0, 1, 2, 3], &[(rho, tau)]);
        let refused = Transport::new(&factors, reflection);
        assert!(matches!(refused, Err(TransportError::Unsolvable { .. })), "{rho:?}");
    }
    // The second sphere absorbs, and the first sees it through the sheet.
    for (rho, tau) in [([1.0, 0.7, 0.7, 0.9], 0.3), ([1.0, 0.7, 0.6, 1.0], 0.3), ([1.0, 0.0, 0.0, 0.9], 1.0)]
    {
        let (factors, reflection) = joined_spheres([0, 1, 2, 3], &[(rho, tau)]);
        assert!(Transport::new(&factors, reflection).is_ok(), "{rho:?}");
    }
}

#[test]
fn bounds_hold_through_sheets() {
    let scene = around(gauze());
    let (patches, factors) = factors(&scene, PatchSize::Count(400), (Basis::Constant, 128));
    let k = Transport::of(&factors, &patches).unwrap();
    let e = patches.emitted_radiance();
    let exact = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&e).radiance;
    for order in 0..12 {
        let options = NeumannOptions { order, tolerance: 0.0, ..Default::default() };
        let series = solve::neumann(&k, &e, &options).unwrap().solution;
        let off = |c: usize| {
            (series.radiance.column(c) - exact.column(c)).amax() / series.radiance.column(c).amax()
        };
        let worst = (0..3).map(off).fold(0.0, f64::max);
        assert!(worst <= series.report.bound, "order {order}: {worst} {:?}", series.report);
        assert!(series.report.bound < 50.0 * worst, "order {order}: {worst} {:?}", series.report);
    }
    for tolerance in [1e-1, 1e-3, 1e-5] {
        let options = CgOptions { tolerance, ..Default::default() };
        let found = solve::conjugate_gradients(&k, &e, &options).unwrap();
        let off =
            |c: usize| (found.radiance.column(c) - exact.column(c)).amax() / found.radiance.column(c).amax();
        let worst = (0..3).map(off).fold(0.0, f64::max);
        assert_eq!(found.report.name, "minres");
        assert!(worst <= found.report.bound && found.report.residual <= tolerance, "{:?}", found.report);
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
            let e = basis.coefficients_of(&patches.emitted_radiance());
            let solutions = every_solver(&k, &e);
            for solution in &solutions {
                let off = difference(&solution.radiance, &solutions[0].radiance);
                assert!(off < 1e-9, "{basis:?} {storage:?} {}: {off}", solution.report.name);
                assert!(solution.report.residual < 1e-10, "{:?}", solution.report);
                let energy = Energy::new(&k, &e, &solution.radiance);
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
    let e = Basis::Linear.coefficients_of(&patches.emitted_radiance());
    let other = DMatrix::from_fn(e.nrows(), e.ncols(), |i, _| f64::from(i as u32 % 3));
    let cg = CgOptions { tolerance: 1e-12, ..Default::default() };
    let [whole, one, other] =
        [&e * 2.0 + &other, e, other].map(|e| solve::conjugate_gradients(&k, &e, &cg).unwrap().radiance);
    assert!(difference(&(2.0 * one + other), &whole) < 1e-10);
}

#[test]
fn the_same_bits_come_through_on_any_number_of_threads() {
    let scene = around(gauze());
    let answers = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (patches, factors) = factors(&scene, PatchSize::Count(600), (Basis::Constant, 64));
            let k = Transport::of(&factors, &patches).unwrap();
            let tracer = Tracer::new(&scene);
            let budget = Budget { paths: Some(20_000), ..Budget::default() };
            let options = PathOptions { budget, ..Default::default() };
            let traced = PathTracer::new(&tracer).irradiance(&patches, &options).unwrap();
            (every_solver(&k, &patches.emitted_radiance()).map(|solution| solution.radiance), traced.means())
        })
    });
    assert!(answers[0] == answers[1]);
}

#[test]
fn light_comes_through_a_translucent_wall_and_through_no_other() {
    let lit_behind = |wall: Material| {
        let scene = around(wall);
        let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Constant, 64));
        let k = Transport::of(&factors, &patches).unwrap();
        let solution =
            solve::direct(&k, &DirectOptions::default()).unwrap().solve(&patches.emitted_radiance());
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
    let faces = [(square(0.0), 1), (square(0.5), 0), (flipped(square(1.0)), 1)];
    let scene = quads(&faces, vec![card, lamp]);
    let (patches, factors) = factors(&scene, PatchSize::Edge(0.3), (Basis::Constant, 256));
    let k = Transport::of(&factors, &patches).unwrap();
    assert!(k.sheets().is_none());
    let solution = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&patches.emitted_radiance());
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
    let e = patches.emitted_radiance();
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
            let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
            let solution = problem.conjugate_gradients(&CgOptions::default()).unwrap();
            let bars = ErrorBars::of(&patches, &problem, &solution, Progress::default()).unwrap();
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

#[test]
fn every_way_of_shading_shows_the_light_through_a_sheet() {
    for wall in [paper(), gauze()] {
        let scene = around(wall);
        let (patches, factors) = factors(&scene, PatchSize::Count(16000), (Basis::Constant, 256));
        let tracer = Tracer::new(&scene);
        let k = Transport::of(&factors, &patches).unwrap();
        let cg = CgOptions::default();
        let radiance = solve::conjugate_gradients(&k, &patches.emitted_radiance(), &cg).unwrap().radiance;
        // Only the sheet is in the picture, from either side.
        for x in [0.6, 1.4] {
            let position = DVec3::new(x, 0.5, 0.5);
            let camera = Camera { position, target: DVec3::new(1.0, 0.5, 0.5), up: DVec3::Y, fov: 60.0 };
            let seen = |shading: Shading, seed: u64| {
                let options =
                    RenderOptions { width: 32, height: 32, shading, samples: 64, seed, ..Default::default() };
                let picture = render::picture(&tracer, &patches, &radiance, &camera, &options).unwrap();
                [0, 1, 2].map(|c| picture.pixels.iter().map(|rgb| f64::from(rgb[c])).sum::<f64>())
            };
            let paths: Vec<[f64; 3]> = (0..8).map(|seed| seen(Shading::Path, seed)).collect();
            for shading in [Shading::Flat, Shading::Smooth, Shading::Gather] {
                let found = seen(shading, 8);
                for c in 0..3 {
                    let mean = paths.iter().map(|path| path[c]).sum::<f64>() / 8.0;
                    let spread: f64 = paths.iter().map(|path| (path[c] - mean).powi(2)).sum();
                    let error = (spread / 56.0).sqrt();
                    // What an ordinary room comes out within, and the noise of the light paths.
                    let off = (found[c] - mean).abs();
                    assert!(
                        off < 0.01 * mean + 4.0 * error,
                        "{shading:?} x = {x} {c}: {off} of {mean} ± {error}"
                    );
                    assert!(error < 0.005 * mean, "{mean} ± {error}");
                }
            }
        }
    }
}

#[test]
fn a_picture_on_a_sheet_varies_what_it_reflects_and_not_what_comes_through() {
    let texels = (0..64).map(|k| [if k % 2 == 0 { 0.2 } else { 0.8 }; 3]).collect();
    let textures =
        Textures { reflectance: Some(Texture::new(Pixels::new(8, 8, texels))), ..Default::default() };
    let sheet = Material::diffuse("sheet", &[0.6; 3]).with_sheet(&[1.0; 3], &[0.19; 3]);
    let textured = |material: Material| Material { textures: textures.clone(), ..material };
    let scene = around(textured(sheet.clone()));
    let (patches, _) = factors(&scene, PatchSize::Count(100), (Basis::Constant, 64));
    let rho = patches.reflectances();
    let Sheets { pairs, transmittance } = patches.sheets().unwrap();
    for (p, &[front, back]) in pairs.iter().enumerate() {
        // Faces without texture coordinates have the mean of the picture.
        for (found, exact) in [(rho[(front, 0)], 0.3), (rho[(back, 0)], 0.5), (transmittance[(p, 0)], 0.19)] {
            assert!((found - exact).abs() < 1e-7, "{found} {exact}");
        }
    }
    let too_bright = sheet.with_sheet(&[1.0; 3], &[0.21; 3]);
    let refused = Scene::new(SceneParts {
        vertices: scene.vertices().to_vec(),
        faces: scene.faces().to_vec(),
        objects: scene.objects().to_vec(),
        materials: scene.materials()[..3].iter().cloned().chain([textured(too_bright)]).collect(),
        ..Default::default()
    });
    let message = refused.unwrap_err().to_string();
    assert!(
        ["material sheet", "reflectance_back 0.8", "0.21", "lower"].iter().all(|word| message.contains(word)),
        "{message}"
    );
}

#[test]
fn saved_form_factors_serve_when_a_wall_becomes_translucent() {
    let cut = Tessellation { size: PatchSize::Edge(0.2), ..Default::default() };
    let options = TraceOptions { rays: Some(64), keep: Keep::Rays, ..Default::default() };
    let traced = |scene: &Scene| {
        let tracer = Tracer::new(scene);
        let mut patches = Patches::new(&tracer, &cut).unwrap();
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let radiance = radiance(&patches, &factors);
        let mut file = Vec::new();
        factors.save(&patches, &mut file).unwrap();
        (file, radiance)
    };
    let card = Material::diffuse("card", &[0.5; 3]);
    for (before, after, all_there) in
        [(card.clone(), paper(), false), (paper(), gauze(), true), (gauze(), card, true)]
    {
        let (file, _) = traced(&around(before));
        let scene = around(after);
        let (_, fresh) = traced(&scene);
        let tracer = Tracer::new(&scene);
        let file = &mut Cursor::new(file);
        let (patches, factors, reuse) =
            FormFactors::load(file, &tracer, &cut, StorageKind::Auto, Keep::Nothing).unwrap();
        assert_eq!(reuse.traced == 0, all_there, "{reuse:?}");
        let reused = radiance(&patches, &factors);
        assert!(reused.len() == fresh.len() && difference(&reused, &fresh) < 1e-9);
    }
}

fn radiance(patches: &Patches, factors: &FormFactors) -> DMatrix<f64> {
    let k = Transport::of(factors, patches).unwrap();
    solve::direct(&k, &DirectOptions::default()).unwrap().solve(&patches.emitted_radiance()).radiance
}

#[test]
fn the_plan_names_sheets_and_can_leave_out_what_comes_through() {
    let effect = |plan: &Plan| plan.effects.iter().find(|e| e.effect == "transmission").unwrap().clone();
    assert!(!effect(&Plan::new(&Scene::cornell_box())).on);
    let planned = effect(&Plan::new(&around(paper())));
    assert!(planned.on && planned.reason.contains("paper"), "{}", planned.reason);
    let opaque = {
        let scene =
            around(Material::diffuse("paper", &[0.5, 0.4, 0.3]).with_sheet(&[0.2, 0.4, 0.6], &[0.0; 3]));
        let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Constant, 64));
        radiance(&patches, &factors)
    };
    for (switches, told_of) in [
        ("-transmission", vec!["transmission"]),
        ("-back-sides", vec!["back sides", "nothing comes through"]),
    ] {
        let (scene, plan, told) = switches.parse::<Switches>().unwrap().apply(around(paper()));
        assert!(
            !effect(&plan).on && told.iter().any(|line| told_of.iter().all(|word| line.contains(word))),
            "{told:?}"
        );
        let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Constant, 64));
        assert!(patches.sheets().is_none());
        if switches == "-transmission" {
            assert_eq!(radiance(&patches, &factors), opaque);
        }
    }
}

/// A square of a material named paper with these lines in the MTL file and the settings.
fn square_with(mtl: &str, settings: &str) -> Result<Scene, SceneError> {
    let obj = "mtllib a.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nusemtl paper\nf 1 2 3 4\n";
    let mtl = format!("newmtl paper\n{mtl}\n");
    let folder = Scratch::with(&[("a.obj", obj), ("a.mtl", &mtl), ("a.toml", settings)]);
    Scene::load(folder.path("a.obj"))
}

#[test]
fn settings_make_sheets_of_materials() {
    let sheet = |settings: &str| {
        let scene = square_with("Kd 0.5 0.4 0.3\nd 0.2", &format!("[material.paper]\n{settings}")).unwrap();
        let material = scene.materials()[0].clone();
        let side = |side: Side| material.reflectance_of(side).to_vec();
        (side(Side::Front), side(Side::Back), material.transmittance().map(<[f64]>::to_vec))
    };
    let kd = vec![0.5, 0.4, 0.3];
    assert_eq!(sheet("transmittance = 0.25"), (kd.clone(), kd.clone(), Some(vec![0.25; 3])));
    assert_eq!(sheet("reflectance_back = [0.1, 0.2, 0.3]"), (kd.clone(), vec![0.1, 0.2, 0.3], None));
    assert_eq!(
        sheet("reflectance = 0.5\nreflectance_back = 0.3\ntransmittance = 0.25"),
        (vec![0.5], vec![0.3], Some(vec![0.25])),
        "one channel where all agree"
    );
    assert_eq!(
        sheet("reflectance = 0.5\ntransmittance = [0.25, 0.5, 0.1]"),
        (vec![0.5; 3], vec![0.5; 3], Some(vec![0.25, 0.5, 0.1]))
    );
    assert_eq!(sheet("emission = 0"), (kd.clone(), kd, None), "d is no transmittance");
    let glossy = square_with("Kd 0.5 0.5 0.5\nPr 0.5", "[material.paper]\ntransmittance = 0.25").unwrap();
    assert!(glossy.materials()[0].transmittance().is_some());
    assert!(glossy.warnings().iter().any(|line| line.contains("paper") && line.contains("matt")));
}

#[test]
fn bad_sheets_are_refused_with_their_line_and_a_remedy() {
    // A key that is named alone is told by its line, else the head.
    for (mtl, settings, at, words) in [
        ("Kd 0.5 0.5 0.5", "transmittance = 0.6", 3, ["reflectance 0.5", "transmittance 0.6", "lower"]),
        (
            "Kd 0.3 0.3 0.3",
            "reflectance_back = 0.8\ntransmittance = 0.3",
            2,
            ["reflectance_back 0.8", "0.3", "lower"],
        ),
        ("Kd 0.3 0.3 0.3", "transmittance = [0.1, 0.2, 0.8]", 3, ["transmittance 0.8", "0.3", "lower"]),
        ("Kd 0.3 0.3 0.3", "transmittance = -0.1", 3, ["transmittance -0.1", "between", "0 and 1"]),
        ("Kd 0.3 0.3 0.3", "reflectance_back = nan", 3, ["reflectance_back NaN", "between", "0 and 1"]),
        ("Ks 1 1 1\nillum 3", "transmittance = 0.1", 3, ["transmittance", "diffuse", "material of its own"]),
    ] {
        let error = square_with(mtl, &format!("\n[material.paper]\n{settings}")).unwrap_err();
        let SceneError::Parse { line, message, .. } = &error else { panic!("{error}") };
        assert!(*line == at && message.contains("material paper"), "{error}");
        assert!(words.iter().all(|word| message.contains(word)), "{settings}: {error}");
    }
}
