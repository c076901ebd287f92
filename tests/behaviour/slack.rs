//! Rows of form factors that cannot be closed: they fail by themselves, and what they lack is accounted for.

use std::io::Cursor;

use nalgebra::{DMatrix, DVector};
use radiosity::measure::{Answer, Cause, Energy, ErrorBars, ErrorPart, Grade, Verdict, operator_health};
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Material, Scene};
use radiosity::solve::{self, DirectOptions, Problem, Solution};
use radiosity::trace::Tracer;
use radiosity::transport::{
    Exchange, FormFactors, Keep, LightOptions, Mass, Storage, StorageKind, TraceOptions, Transport,
};

use crate::scenes::{cut, quads, room, traced};

/// A room with a lamp below its ceiling, the only faces of the second scene; the first has a flat closed box
/// 20 m away, whose floor is there twice, in one plane.
fn beside_a_pocket() -> [Scene; 2] {
    let level =
        |[x, y]: [[f64; 2]; 2], z: f64| [[x[0], y[0], z], [x[1], y[0], z], [x[1], y[1], z], [x[0], y[1], z]];
    let [a, b, c, d] = level([[1.5, 2.5], [1.0, 2.0]], 2.4);
    let lamp = [a, d, c, b];
    let [a, b, c, d] = level([[21.9, 22.1], [1.4, 1.6]], 0.1);
    let small_lamp = [a, d, c, b];
    let mut all: Vec<_> = room([0.0; 3], [4.0, 3.0, 2.5]).map(|wall| (wall, 0)).to_vec();
    all.push((lamp, 1));
    let alone = all.clone();
    all.extend(room([20.0, 0.0, 0.0], [24.0, 3.0, 0.2]).map(|wall| (wall, 0)));
    all.push((level([[20.3, 23.7], [0.2, 2.8]], 0.0), 0));
    all.push((small_lamp, 1));
    [all, alone].map(|faces| {
        quads(&faces, vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.0], &[10.0])])
    })
}

#[test]
fn a_room_beside_a_pocket_that_cannot_close_is_as_it_is_alone() {
    let answers = beside_a_pocket().map(|scene| {
        let tracer = Tracer::new(&scene);
        let mut patches = cut(&tracer, PatchSize::Edge(0.35));
        let options = TraceOptions { rays: Some(128), keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        assert!(factors.exchange().closure_error() < 1e-12 && factors.exchange().closure().iterations < 300);
        let light = LightOptions { rays: 128, ..Default::default() };
        let problem = Problem::new(&tracer, &patches, &factors, &light).unwrap();
        let solution = problem.direct(&DirectOptions::default()).unwrap();
        let energy = Energy::of(&problem, &solution.radiance);
        assert!(energy.imbalance < 1e-9, "{energy:?}");
        let bars = ErrorBars::of(&patches, &problem, &solution, Progress::default()).unwrap();
        let faces = patches.average_by_face(&solution.irradiance);
        faces
            .into_iter()
            .zip(bars.faces)
            .map(|(face, bar)| (face.face, face.mean[0], bar.mean[0]))
            .collect::<Vec<_>>()
    });
    let [beside, alone] = answers;
    assert!(alone.len() >= 14);
    for (one, other) in beside.iter().zip(&alone) {
        assert_eq!(one.0, other.0);
        assert!(
            (one.1 - other.1).abs() < 2.0 * one.2.hypot(other.2),
            "face {}: {one:?}, alone {other:?}",
            one.0
        );
    }
}

#[test]
fn saved_form_factors_keep_their_slack() {
    let [scene, _] = beside_a_pocket();
    let tracer = Tracer::new(&scene);
    let tessellation = Tessellation { size: PatchSize::Edge(0.8), ..Default::default() };
    let mut patches = Patches::new(&tracer, &tessellation).unwrap();
    let options = TraceOptions { rays: Some(64), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let mut file = Vec::new();
    factors.save(&patches, &mut file).unwrap();
    let (_, read, reuse) =
        FormFactors::load(&mut Cursor::new(&file), &tracer, &tessellation, StorageKind::Auto, Keep::Nothing)
            .unwrap();
    assert!(reuse.balanced);
    assert_eq!(read.exchange().slack(), factors.exchange().slack());
    assert_eq!(read.exchange().closure(), factors.exchange().closure());
}

/// A closed cube with a glowing ceiling.
fn cube() -> Scene {
    let walls: Vec<_> =
        room([0.0; 3], [1.0; 3]).into_iter().enumerate().map(|(k, wall)| (wall, u32::from(k == 5))).collect();
    quads(&walls, vec![Material::diffuse("grey", &[0.6]), Material::lamp("lamp", &[0.3], &[1.0])])
}

/// Exact form factors of a cube's patches.
fn exact(scene: &Scene) -> (Patches<'_>, FormFactors) {
    let (patches, factors) = traced(scene, PatchSize::Edge(0.2), &TraceOptions::default());
    assert!(factors.rays() == 0 && factors.exchange().slack().amax() == 0.0);
    (patches, factors)
}

/// The same with only a tenth found of what patches of face 0 exchange with others.
fn damaged(patches: &Patches, exact: &FormFactors) -> FormFactors {
    let exchange = exact.exchange();
    let n = exchange.len();
    let found = |i: usize, j: usize| {
        let touches = [i, j].into_iter().filter(|&k| patches.place(k).face == 0).count();
        (exchange.exchange_area(i, j) * 0.1f64.powi(touches as i32)) as f32
    };
    let storage = Storage::Dense(DMatrix::from_fn(n, n, found));
    let areas = exchange.areas();
    let damaged =
        Exchange::new(storage, exchange.leaving(), areas, &vec![false; n], Progress::default()).unwrap();
    assert!(damaged.closure_error() < 1e-12, "{:?}", damaged.closure());
    let lacks = |i: usize| damaged.slack()[i] > 0.1 * damaged.areas()[i];
    assert!((0..n).all(|i| lacks(i) == (patches.place(i).face == 0)));
    damaged.into()
}

fn solved(patches: &Patches, factors: &FormFactors) -> (Problem, Solution) {
    let problem = Problem::unlit(patches, factors).unwrap().under(patches.emitted_radiance());
    let solution = problem.direct(&DirectOptions::default()).unwrap();
    (problem, solution)
}

#[test]
fn missing_light_is_named_and_within_the_error_bars_of_what_sees_it() {
    let scene = cube();
    let (patches, exact) = exact(&scene);
    let damaged = damaged(&patches, &exact);
    let (sound, truth) = solved(&patches, &exact);
    let (problem, solution) = solved(&patches, &damaged);
    let energy = Energy::of(&problem, &solution.radiance);
    let judged = |problem: &Problem, solution: &Solution, energy: &Energy| {
        let (tracer, patches, budget, tolerance) = (&Tracer::new(&scene), &patches, None, 1e-6);
        Verdict::of(&Answer { tracer, patches, problem, solution, energy, budget, tolerance })
    };
    let verdict = judged(&problem, &solution, &energy);
    let [reason] = &verdict.reasons[..] else { panic!("one reason: {verdict:?}") };
    assert!(reason.cause == Cause::Slack && reason.faces == [0], "{reason:?}");
    assert!((energy.slack[0] / energy.emitted[0] - reason.power_share.unwrap()).abs() < 1e-6, "{reason:?}");
    let energy_of_sound = Energy::of(&sound, &truth.radiance);
    assert!(judged(&sound, &truth, &energy_of_sound).reasons.is_empty());

    let bars = ErrorBars::of(&patches, &problem, &solution, Progress::default()).unwrap();
    let sound = ErrorBars::of(&patches, &sound, &truth, Progress::default()).unwrap();
    assert!(bars.budget.part(ErrorPart::SLACK) > 0.01);
    assert!(sound.budget.parts.iter().all(|part| part.name != ErrorPart::SLACK));
    let [answer, truth] = [&solution, &truth].map(|solution| patches.average_by_face(&solution.irradiance));
    let (mut errors, mut squares) = (0.0, 0.0);
    for ((answer, truth), bar) in answer.iter().zip(&truth).zip(&bars.faces) {
        let error = (answer.mean[0] - truth.mean[0]).abs();
        assert!(error < 2.0 * bar.mean[0], "face {}: {error}, bar {}", answer.face, bar.mean[0]);
        errors += truth.area * error.powi(2);
        squares += truth.area * truth.mean[0].powi(2);
    }
    assert!((errors / squares).sqrt() < bars.budget.upper95, "{:?}", bars.budget);
    assert!((errors / squares).sqrt() > 0.2 * bars.budget.part(ErrorPart::SLACK), "{:?}", bars.budget);
}

#[test]
fn check_names_faces_that_cannot_close_and_does_not_ask_for_rays() {
    let scene = cube();
    let (patches, exact) = exact(&scene);
    let findings = operator_health(&damaged(&patches, &exact), &patches, Progress::default()).unwrap();
    let closure = findings.iter().find(|finding| finding.name == "closure").unwrap();
    assert!(closure.verdict == Grade::Bad && closure.faces == [0] && closure.value > 0.1, "{closure:?}");
    assert!(closure.remedy.as_ref().is_some_and(|remedy| !remedy.contains("--rays")), "{closure:?}");
}

#[test]
fn energy_is_kept_with_slack_for_constant_and_linear_elements() {
    let scene = cube();
    let (patches, exact) = exact(&scene);
    for basis in [Basis::Constant, Basis::Linear] {
        let each = basis.coefficients();
        let mass = Mass::new(basis, &patches.areas());
        let (n, areas) = (mass.len(), mass.areas());
        // Every coefficient takes part alike, and some find next to nothing.
        let found = |i: usize| if (i / each).is_multiple_of(7) { 0.05 } else { 1.0 };
        // Light that varies within patches is passed on unmixed, which needs shrinking.
        let entry = |i: usize, j: usize| {
            let area = exact.exchange().exchange_area(i / each, j / each) / each as f64;
            if i % each == j % each { (area * found(i) * found(j)) as f32 } else { 0.0 }
        };
        let storage = Storage::Dense(DMatrix::from_fn(n, n, entry));
        let escape = DVector::from_fn(n, |i, _| if i % 5 == 0 { 0.1 * areas[i] } else { 0.0 });
        let exchange = Exchange::new(storage, escape, mass, &vec![false; n], Progress::default()).unwrap();
        assert!(
            exchange.closure_error() < 1e-12 && exchange.slack().amax() > 0.0,
            "{:?}",
            exchange.closure()
        );
        assert_eq!(exchange.shrinkage() < 1.0, basis == Basis::Linear);
        let share = exchange.slack().sum() / exchange.areas().sum();
        assert!((exchange.closure().slack - share).abs() < 1e-12 * share);
        let merged =
            exchange.merged(&(0..n).map(|i| i / (3 * each)).collect::<Vec<_>>(), n.div_ceil(3 * each));
        assert!((merged.slack().sum() / exchange.slack().sum() - 1.0).abs() < 1e-12);
        assert!(merged.closure_error() < 1e-6, "{}", merged.closure_error());
        let factors: FormFactors = exchange.into();
        let k = Transport::of(&factors, &patches).unwrap();
        let e = basis.coefficients_of(&patches.emitted_radiance());
        let solution = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&e);
        let energy = Energy::new(&k, &e, &solution.radiance);
        assert!(energy.slack[0] > 1e-3 * energy.emitted[0] && energy.imbalance < 1e-9, "{energy:?}");
    }
}
