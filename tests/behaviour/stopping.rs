//! When iterations stop, and what a series that ends before says of itself.

use std::path::Path;

use nalgebra::DMatrix;
use radiosity::measure::{Energy, ErrorBars, ErrorPart};
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::progress::Progress;
use radiosity::scene::{Material, Scene};
use radiosity::solve::{self, CgOptions, DirectOptions, NeumannOptions, Problem, Solution, SolveError};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, TraceOptions, Transport};

use crate::program::{radiosity, text};
use crate::scenes::{BASES, direct, flipped, lit_quads, load, mesh, point, quads, room, traced};
use crate::scratch::Scratch;

/// What conjugate gradients and the series are asked for; 0 is all that rounding leaves.
const TOLERANCES: [f64; 4] = [1e-3, 1e-6, 1e-9, 0.0];

/// What is asked of tolerance 0.
const ROUNDING: f64 = 1e-11;

fn factors<'s>(scene: &'s Scene, count: usize, (basis, rays): (Basis, u32)) -> (Patches<'s>, FormFactors) {
    let options = TraceOptions { rays: Some(rays), basis, keep: Keep::Rays, ..Default::default() };
    traced(scene, PatchSize::Count(count), &options)
}

/// max |ΔH| / max(H, H_rms/1000), the largest over channels.
fn worst(k: &Transport, found: &DMatrix<f64>, exact: &DMatrix<f64>) -> f64 {
    let of = |c: usize| {
        let typical = k.mass().root_mean_square(exact.column(c));
        let off = |(a, b): (&f64, &f64)| (a - b).abs() / b.max(1e-3 * typical);
        found.column(c).iter().zip(&exact.column(c)).map(off).fold(0.0, f64::max)
    };
    (0..exact.ncols()).map(of).fold(0.0, f64::max)
}

/// Holds every iterative solver against the direct one, at all tolerances.
#[track_caller]
fn agree(k: &Transport, e: &DMatrix<f64>, what: &str) {
    let exact = direct(k, e).irradiance;
    for tolerance in TOLERANCES {
        let cg = CgOptions { tolerance, ..Default::default() };
        let cg = solve::conjugate_gradients(k, e, &cg).unwrap_or_else(|error| panic!("{what}: {error}"));
        let series = NeumannOptions { tolerance, order: 700, ..Default::default() };
        let series = solve::neumann(k, e, &series).unwrap().solution;
        for Solution { irradiance, report, .. } in [cg, series] {
            let (off, allowed) = (worst(k, &irradiance, &exact), 10.0 * tolerance.max(ROUNDING));
            assert!(off <= allowed, "{what}, {} at {tolerance}: {off} {report:?}", report.name);
            assert!(
                report.remaining_flux <= tolerance.max(ROUNDING) && !report.truncated,
                "{what}: {report:?}"
            );
        }
    }
}

/// A room of this length with a square lamp under its ceiling, and their reflectances.
fn lit_room(length: f64, lamp: f64, [walls, of_lamp]: [f64; 2]) -> Scene {
    let (low, high) = (0.45 * length, 0.45 * length + lamp.min(0.5 * length));
    let height = 0.98 * length;
    let panel = [[low, low, height], [low, high, height], [high, high, height], [high, low, height]];
    let mut all: Vec<_> = room([0.0; 3], [length; 3]).map(|quad| (quad, 0)).into();
    all.push((panel, 1));
    let power = 10.0 / (lamp * lamp);
    quads(&all, vec![Material::diffuse("wall", &[walls]), Material::lamp("lamp", &[of_lamp], &[power])])
}

#[test]
fn solvers_agree_whatever_the_size_of_lamps_and_rooms() {
    for length in [1.0, 10.0, 100.0] {
        for lamp in [1e-3, 0.03, 1.0] {
            for reflectances in [[0.0, 0.0], [0.9, 0.0], [0.0, 0.9], [0.9, 0.9]] {
                let scene = lit_room(length, lamp, reflectances);
                for basis in BASES {
                    let (patches, factors) = factors(&scene, 150, (basis, 64));
                    let k = Transport::of(&factors, &patches).unwrap();
                    let e = basis.coefficients_of(&patches.emitted_radiance());
                    agree(&k, &e, &format!("{lamp} m in {length} m of {reflectances:?}, {basis:?}"));
                }
            }
        }
    }
}

#[test]
fn solvers_agree_through_sheets_and_in_the_dark_behind_them() {
    // A bright small lamp in front of a sheet that lets through more than it reflects, and a white room that
    // little of it reaches.
    let sheets = [
        Material::diffuse("gauze", &[0.1, 0.0, 0.2]).with_sheet(&[0.0, 0.05, 0.2], &[0.8, 0.7, 0.6]),
        Material::diffuse("foil", &[0.3, 0.5, 0.1]).with_sheet(&[0.3, 0.5, 0.1], &[1e-4, 1e-3, 0.6]),
    ];
    for sheet in sheets {
        let mut all: Vec<_> = room([0.0; 3], [2.0, 1.0, 1.0]).map(|quad| (quad, 0)).into();
        all.push(([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]], 1));
        let lamp = [[0.5, 0.5, 0.9], [0.5, 0.504, 0.9], [0.504, 0.504, 0.9], [0.504, 0.5, 0.9]];
        all.push((lamp, 2));
        let walls = Material::diffuse("wall", &[0.8, 0.5, 0.2]);
        let scene = quads(&all, vec![walls, sheet, Material::lamp("lamp", &[0.0; 3], &[3e4, 2e4, 1e4])]);
        for basis in BASES {
            let (patches, factors) = factors(&scene, 300, (basis, 64));
            let k = Transport::of(&factors, &patches).unwrap();
            let e = basis.coefficients_of(&patches.emitted_radiance());
            agree(&k, &e, &format!("{basis:?}"));
            let report = solve::conjugate_gradients(&k, &e, &CgOptions::default()).unwrap().report;
            assert_eq!(report.name, "minres");
        }
    }
}

#[test]
fn a_room_with_one_tiny_lamp_is_lit_to_its_end() {
    let scene = load("tests/data/led.obj");
    let (patches, factors) = factors(&scene, 1000, (Basis::Constant, 128));
    let k = Transport::of(&factors, &patches).unwrap();
    let e = patches.emitted_radiance();
    let series = solve::neumann(&k, &e, &NeumannOptions::default()).unwrap();
    assert!((40..100).contains(&series.order()), "{}", series.order());
    let cg = solve::conjugate_gradients(&k, &e, &CgOptions::default()).unwrap();
    assert!(cg.report.iterations < 25, "{:?}", cg.report);
    for solution in [series.solution, cg] {
        let energy = Energy::new(&k, &e, &solution.radiance);
        assert!((energy.emitted[0] - 9.896).abs() < 0.01 && energy.imbalance < 2e-6, "{energy:?}");
        let wall = &patches.average_by_face(&solution.irradiance)[0];
        assert!((wall.mean[0] - 0.472).abs() < 0.005, "{wall:?}");
    }
}

#[test]
fn refined_iterations_are_never_said_to_have_converged_where_they_have_not() {
    let scene = lit_room(3.0, 0.1, [0.9, 0.0]);
    let (patches, factors) = factors(&scene, 150, (Basis::Constant, 64));
    let k = Transport::of(&factors, &patches).unwrap();
    let e = patches.emitted_radiance();
    for iterations in [2, 4, 6] {
        let options = CgOptions { iterations, tolerance: 1e-9, ..Default::default() };
        let Err(SolveError::NotConverged { best, .. }) = solve::conjugate_gradients(&k, &e, &options) else {
            panic!("{iterations} passes are too few");
        };
        assert!(best.report.iterations <= iterations && best.report.remaining_flux > 1e-9, "{best:?}");
    }
    // Light that is no number is refused, not passed on.
    let odd = e.map(|l| if l > 0.0 { f64::NAN } else { l });
    for refused in [
        solve::conjugate_gradients(&k, &odd, &CgOptions::default()).err(),
        solve::neumann(&k, &odd, &NeumannOptions::default()).err(),
        solve::solve(&k, &odd, &Default::default()).err(),
    ] {
        assert!(matches!(refused, Some(SolveError::NotFinite { .. })), "{refused:?}");
    }
}

/// √(ΣA Δ² / ΣA H²) by face, over all channels.
fn apart(patches: &Patches, found: &DMatrix<f64>, exact: &DMatrix<f64>) -> f64 {
    let sum = |field: &DMatrix<f64>| -> f64 {
        let rows = patches.average_by_face(field);
        rows.iter().map(|row| row.area * row.mean.iter().map(|x| x * x).sum::<f64>()).sum()
    };
    (sum(&(found - exact)) / sum(exact)).sqrt()
}

#[test]
fn what_a_truncated_series_lacks_is_no_more_than_it_says() {
    for scene in [Scene::cornell_box(), mesh("two_rooms")] {
        for basis in BASES {
            let (patches, factors) = factors(&scene, 500, (basis, 64));
            let emitted = basis.coefficients_of(&patches.emitted_radiance());
            let problem = Problem::unlit(&patches, &factors).unwrap().under(emitted);
            let exact = problem.direct(&DirectOptions::default()).unwrap();
            let budget = |solution: &Solution| {
                ErrorBars::of(&patches, &problem, solution, Progress::default()).unwrap().budget
            };
            let of_all = budget(&exact);
            assert_eq!(of_all.part(ErrorPart::TRUNCATION), 0.0);
            for order in 0..=8 {
                let options = NeumannOptions { order, ..Default::default() };
                let solution = problem.neumann(&options).unwrap().solution;
                assert!(solution.report.truncated);
                let told = budget(&solution);
                let truncation = told.part(ErrorPart::TRUNCATION);
                let [found, exact] = [&solution, &exact].map(|one| basis.means(&one.irradiance));
                let off = apart(&patches, &found, &exact);
                let what = format!("{} {basis:?} order {order}: {off} {told:?}", scene.name());
                assert!(off <= truncation && truncation <= told.upper95 && truncation < 20.0 * off, "{what}");
                let noise = |told: &radiosity::measure::ErrorBudget| {
                    told.part(ErrorPart::RAYS).hypot(told.part(ErrorPart::LAMPS))
                };
                // What later orders add counts neither as error of the mesh nor as noise, and errors of order
                // 1 are of direct light.
                assert!(
                    told.part(ErrorPart::MESH) <= 2.0 * of_all.part(ErrorPart::MESH),
                    "{what} {of_all:?}"
                );
                assert!(noise(&told) <= 2.0 * noise(&of_all), "{what} {of_all:?}");
                assert!(!serde_json::to_string(&told).unwrap().contains("null"), "{what}");
                if order == 0 {
                    assert_eq!((truncation, told.irradiance), (1.0, 0.0));
                }
            }
        }
    }
}

/// What the program prints, and the numbers it writes.
fn solved(folder: &Path, arguments: &str) -> (String, serde_json::Value) {
    let small = "--patches 200 --rays 64 --size 80x60 -o out";
    let output = radiosity(folder, &format!("solve {arguments} {small}"));
    assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
    let json = std::fs::read_to_string(folder.join("out/solution.json")).unwrap();
    (text(&output.stdout).to_owned(), serde_json::from_str(&json).unwrap())
}

/// Whether some number is none.
fn is_odd(text: &str) -> bool {
    let mut words = text.split(|c: char| !c.is_ascii_alphanumeric());
    words.any(|word| ["inf", "NaN"].contains(&word))
}

#[test]
fn the_program_names_truncation_where_it_leads() {
    let folder = Scratch::new();
    for order in ["0", "1", "2", "8"] {
        let (text, json) = solved(folder.folder(), &format!("--solver neumann --order {order}"));
        let line = text.lines().find(|line| line.starts_with("error ")).unwrap();
        let leads = match order {
            "0" => "no light has arrived yet at order 0",
            "1" | "2" => "mostly truncation at order",
            _ => "mostly",
        };
        assert!(line.contains(leads), "{line}");
        assert!(line.contains("--order ") && line.contains("--solver auto") || order == "8", "{line}");
        assert!(!is_odd(line), "{line}");
        assert!(
            json["solver"]["truncated"].as_bool().unwrap() && json["series"]["truncated"].as_bool().unwrap()
        );
        let parts = json["error"]["parts"].as_array().unwrap();
        let truncation = parts.iter().find(|part| part["name"] == "truncation").unwrap();
        assert_eq!(truncation["kind"], "guaranteed");
        assert!(truncation["value"].as_f64().unwrap() > 0.0 && json["error"]["upper95"].is_f64());
        let shown = serde_json::to_string(&json).unwrap();
        assert!(!shown.contains("e-156") && !text.contains("e-156"));
        let flux = |k: usize| json["series"]["bounces"][k]["remaining_flux"].as_f64().unwrap();
        assert!(order == "0" || flux(1) < flux(0));
    }
    // The orders that it asks for are enough.
    let (text, _) = solved(folder.folder(), "--solver neumann --order 1");
    let line = text.lines().find(|line| line.starts_with("error ")).unwrap();
    let enough = line.split("--order ").nth(1).unwrap().split_whitespace().next().unwrap();
    let (text, _) = solved(folder.folder(), &format!("--solver neumann --order {enough}"));
    assert!(!text.contains("mostly truncation"), "{enough}: {text}");
    // An answer by another solver is not truncated, however short the series beside it.
    let (text, json) = solved(folder.folder(), "--order 1");
    assert!(!text.contains("truncation") && json["solver"]["truncated"] == false, "{text}");
}

#[test]
fn nothing_is_said_in_numbers_that_are_none_where_nothing_is_reflected() {
    // One light, and surfaces that are black: all radiance is zero.
    let wall: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let other = flipped(wall).map(|[x, y, z]| [x, y, z + 1.0]);
    let lights = vec![point([0.5, 0.5, 0.4], &[1.0])];
    let scene = lit_quads(&[(wall, 0), (other, 0)], vec![Material::diffuse("black", &[0.0])], lights, None);
    let (patches, factors) = factors(&scene, 60, (Basis::Constant, 64));
    let problem = Problem::new(&Tracer::new(&scene), &patches, &factors, &LightOptions::default()).unwrap();
    assert_eq!(problem.right_hand_side().amax(), 0.0);
    let direct = problem.direct(&DirectOptions::default()).unwrap();
    let cg = problem.conjugate_gradients(&CgOptions::default()).unwrap();
    let series = problem.neumann(&NeumannOptions::default()).unwrap();
    for solution in [direct, cg, series.solution.clone()] {
        let Solution { radiance, report, .. } = &solution;
        assert!(radiance.amax() == 0.0 && report.bound == 0.0 && report.remaining_flux == 0.0, "{report:?}");
        let summary = radiosity::output::SeriesSummary::new(&series, &solution);
        assert_eq!(summary.difference, 0.0);
        let budget = ErrorBars::of(&patches, &problem, &solution, Progress::default()).unwrap().budget;
        assert!(budget.upper95.is_finite() && budget.relative_rms.is_finite(), "{budget:?}");
    }
    let folder = Scratch::with(&[
        ("dark.mtl", "newmtl black\nKd 0 0 0\n"),
        (
            "dark.obj",
            "mtllib dark.mtl\nusemtl black\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n\
                      v 0 0 1\nv 0 1 1\nv 1 1 1\nv 1 0 1\nf 5 6 7 8\n",
        ),
        ("dark.toml", "[[light]]\nkind = \"point\"\nposition = [0.5, 0.5, 0.4]\nflux = 12\n"),
    ]);
    for solver in ["auto", "cg", "neumann"] {
        let (text, _) = solved(folder.folder(), &format!("dark.obj --solver {solver}"));
        assert!(!is_odd(&text), "{text}");
    }
}
