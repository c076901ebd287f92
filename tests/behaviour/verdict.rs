//! The verdict on an answer: good on sound scenes, and raised, by its cause, by each fault that is put in on
//! purpose.

use nalgebra::{DMatrix, DVector};
use radiosity::measure::{Answer, Cause, Energy, ErrorBars, ErrorBudget, Level, Reason, Verdict};
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Light, Material, Scene, Side};
use radiosity::solve::{Method, Problem, Solution, SolveOptions};
use radiosity::trace::{OverlapKind, Tracer};
use radiosity::transport::{
    Disagreement, Exchange, FormFactors, Keep, LightOptions, Sources, Storage, TraceOptions,
};

use crate::scenes::{flipped, lit_quads, quads, room};

/// An answer and all that it was made from; tests damage one of them at a time.
struct Case<'s> {
    tracer: Tracer<'s>,
    patches: Patches<'s>,
    factors: FormFactors,
    sources: Sources,
    tolerance: f64,
    order: usize,
    budget: Option<ErrorBudget>,
}

impl<'s> Case<'s> {
    fn new(scene: &'s Scene, patches: usize, rays: u32, basis: Basis) -> Self {
        let tracer = Tracer::new(scene);
        let size = PatchSize::Count(patches);
        let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() }).unwrap();
        let options = TraceOptions { rays: Some(rays), basis, keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let light = LightOptions { rays, ..Default::default() };
        let sources = Sources::trace(&tracer, &patches, basis, &light).unwrap();
        Self { tracer, patches, factors, sources, tolerance: 1e-6, order: 1000, budget: None }
    }

    fn problem(&self) -> Problem {
        Problem::unlit(&self.patches, &self.factors).unwrap().under(self.sources.clone())
    }

    fn solve(&self, method: Method) -> Solution {
        let options =
            SolveOptions { method, order: self.order, tolerance: self.tolerance, ..Default::default() };
        self.problem().solve(&options).unwrap()
    }

    fn energy(&self, solution: &Solution) -> Energy {
        Energy::of(&self.problem(), &solution.radiance)
    }

    fn judge(&self, solution: &Solution) -> Verdict {
        self.judge_with(solution, &self.energy(solution))
    }

    fn judge_with(&self, solution: &Solution, energy: &Energy) -> Verdict {
        Verdict::of(&Answer {
            tracer: &self.tracer,
            patches: &self.patches,
            problem: &self.problem(),
            solution,
            energy,
            budget: self.budget.as_ref(),
            tolerance: self.tolerance,
        })
    }

    /// Exchange areas and escape in full, to be damaged.
    fn exchange(&self) -> (DMatrix<f32>, DVector<f64>) {
        let exchange = self.factors.exchange();
        let n = exchange.len();
        let areas = DMatrix::from_fn(n, n, |i, j| exchange.exchange_area(i, j) as f32);
        (areas, DVector::from_fn(n, |i, _| exchange.escape(i)))
    }

    fn put_back(&mut self, (areas, escape): (DMatrix<f32>, DVector<f64>)) {
        let mass = self.factors.exchange().mass().clone();
        self.factors = Exchange::unbalanced(Storage::Dense(areas), escape, mass).into();
    }

    /// A patch of the front of this face.
    fn patch_of(&self, face: usize) -> usize {
        (0..self.patches.len()).find(|&i| self.patches.place(i).face == face).unwrap()
    }
}

/// The one reason of a verdict, which must be of this cause and level and say where and what to do.
#[track_caller]
fn only(verdict: &Verdict, cause: Cause, level: Level) -> Reason {
    assert_eq!(verdict.level, level, "{verdict:#?}");
    let [reason] = &verdict.reasons[..] else { panic!("one reason: {verdict:#?}") };
    assert_eq!((reason.cause, reason.level), (cause, level), "{verdict:#?}");
    assert!(!reason.remedy.is_empty() && reason.to_string().starts_with(cause.name()), "{reason}");
    reason.clone()
}

/// A closed room of 12 faces with a small lamp, faces 12 and 13, below its ceiling.
fn lit_room() -> Scene {
    let walls = room([0.0; 3], [2.0, 3.0, 2.5]).map(|wall| (wall, 0));
    quads(&[&walls[..], &[(LAMP, 1)]].concat(), materials())
}

/// The same with a rug in the floor's own plane.
fn room_with_rug() -> Scene {
    let walls = room([0.0; 3], [2.0, 3.0, 2.5]).map(|wall| (wall, 0));
    let rug = [[0.5, 0.5, 0.0], [1.5, 0.5, 0.0], [1.5, 2.0, 0.0], [0.5, 2.0, 0.0]];
    quads(&[&walls[..], &[(LAMP, 1), (rug, 0)]].concat(), materials())
}

/// A lamp that shines downwards.
const LAMP: [[f64; 3]; 4] = [[0.8, 1.2, 2.4], [0.8, 1.6, 2.4], [1.2, 1.6, 2.4], [1.2, 1.2, 2.4]];

fn materials() -> Vec<Material> {
    vec![Material::diffuse("wall", &[0.6]), Material::lamp("lamp", &[0.0], &[10.0])]
}

fn meshes() -> Vec<String> {
    let folder = format!("{}/meshes", env!("CARGO_MANIFEST_DIR"));
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> = entries.filter(|path| path.extension().is_some_and(|e| e == "obj")).collect();
    paths.sort();
    paths.into_iter().map(|path| path.display().to_string()).collect()
}

const METHODS: [Method; 3] = [Method::Direct, Method::ConjugateGradients, Method::Neumann];

#[test]
fn answers_on_sound_scenes_are_good_and_give_no_reasons() {
    for path in meshes() {
        let scene = Scene::load(&path).unwrap();
        for basis in [Basis::Constant, Basis::Linear] {
            for rays in [16, 64] {
                let mut case = Case::new(&scene, 400, rays, basis);
                // Meshes of many faces are not factored here.
                let (solved, methods) = match case.problem().operator().len() {
                    ..4000 => (Method::Direct, &METHODS[..]),
                    _ => (Method::ConjugateGradients, &METHODS[1..]),
                };
                let solution = case.solve(solved);
                let bars = ErrorBars::of(&case.patches, &case.problem(), &solution, Progress::default());
                case.budget = Some(bars.unwrap().budget);
                for method in methods {
                    let solution = case.solve(*method);
                    let verdict = case.judge(&solution);
                    assert_eq!(verdict, Verdict::default(), "{path} {basis:?} {rays} {method:?}");
                }
            }
        }
    }
}

#[test]
fn numbers_that_are_not_finite_are_bad_wherever_they_stand() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    let sound = case.solve(Method::Direct);
    let patch = case.patch_of(3);
    for wrong in [f64::NAN, f64::INFINITY] {
        for field in 0..2 {
            let mut solution = sound.clone();
            let damaged = if field == 0 { &mut solution.radiance } else { &mut solution.irradiance };
            damaged[(patch, 0)] = wrong;
            let reason =
                only(&case.judge_with(&solution, &case.energy(&sound)), Cause::NotFinite, Level::Bad);
            assert_eq!(reason.faces, [3]);
            assert_eq!((reason.objects, reason.power_share), (vec!["quad 1".to_owned()], None));
        }
        let mut energy = case.energy(&sound);
        energy.absorbed[0] = wrong;
        only(&case.judge_with(&sound, &energy), Cause::NotFinite, Level::Bad);
    }
    let mut solution = sound.clone();
    solution.report.bound = f64::NAN;
    only(&case.judge(&solution), Cause::NotFinite, Level::Bad);
    solution.report.bound = f64::INFINITY;
    only(&case.judge(&solution), Cause::Unbounded, Level::Doubtful);
    let bars = ErrorBars::of(&case.patches, &case.problem(), &sound, Progress::default());
    case.budget = Some(bars.unwrap().budget);
    case.budget.as_mut().unwrap().upper95 = f64::NAN;
    only(&case.judge(&sound), Cause::NotFinite, Level::Bad);
}

#[test]
fn a_dropped_lamp_is_missed_even_where_everything_else_adds_up() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    let lamp = case.patch_of(12);
    case.sources.emitted[(lamp, 0)] = 0.0;
    let solution = case.solve(Method::Direct);
    let reason = only(&case.judge(&solution), Cause::MissingLamps, Level::Bad);
    assert_eq!(reason.faces, [12]);
    assert!(reason.power_share.is_some_and(|share| share > 0.05));
}

#[test]
fn a_lamp_that_shines_from_its_other_side_is_missed() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    let [front, back] = Side::BOTH.map(|side| case.patches.patches_of(12, side));
    assert!(!back.is_empty());
    for (front, back) in front.zip(back) {
        case.sources.emitted.swap_rows(front, back);
    }
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::MissingLamps, Level::Bad);
    assert_eq!(reason.faces, [12]);
}

#[test]
fn lights_without_area_that_were_left_out_are_missed() {
    let walls = room([0.0; 3], [2.0; 3]).map(|wall| (wall, 0));
    let light = Light::Point { position: [1.0; 3].into(), intensity: vec![5.0] };
    let scene = lit_quads(&walls, materials(), vec![light], None);
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    assert_eq!(case.judge(&case.solve(Method::Direct)), Verdict::default());
    case.sources.direct = None;
    only(&case.judge(&case.solve(Method::Direct)), Cause::MissingLamps, Level::Bad);
}

#[test]
fn each_altered_term_of_energy_is_an_imbalance() {
    let scene = lit_room();
    let case = Case::new(&scene, 200, 64, Basis::Constant);
    let solution = case.solve(Method::Direct);
    let sound = case.energy(&solution);
    let emitted = sound.emitted[0];
    for (part, level) in [(1e-4, Level::Doubtful), (0.1, Level::Bad)] {
        for term in 0..6 {
            let mut energy = sound.clone();
            match term {
                0 => energy.emitted[0] += part * emitted,
                1 => energy.absorbed[0] += part * emitted,
                2 => energy.escaped[0] += part * emitted,
                3 => energy.carriers[0] += part * emitted,
                4 => energy.lost[0] += part * emitted,
                _ => energy.imbalance = part,
            }
            let reason = only(&case.judge_with(&solution, &energy), Cause::EnergyImbalance, level);
            let share = reason.power_share.unwrap();
            assert!((share / part - 1.0).abs() < 0.2, "{term}: {share}");
        }
    }
}

#[test]
fn one_wrong_row_of_an_answer_does_not_satisfy_the_equation() {
    let scene = lit_room();
    let case = Case::new(&scene, 400, 64, Basis::Constant);
    let sound = case.solve(Method::Direct);
    let patch = case.patch_of(4);
    for factor in [0.0, 0.98, 1.02] {
        let mut solution = sound.clone();
        solution.irradiance[(patch, 0)] *= factor;
        let reason = only(&case.judge(&solution), Cause::Unsolved, Level::Doubtful);
        assert_eq!(reason.faces, [4], "irradiance × {factor}");
        let mut solution = sound.clone();
        solution.radiance[(patch, 0)] *= factor;
        let verdict = case.judge_with(&solution, &case.energy(&sound));
        assert!(
            verdict.reasons.iter().any(|r| r.cause == Cause::Unsolved && r.faces[0] == 4),
            "{verdict:#?}"
        );
    }
}

#[test]
fn sides_of_a_lamp_that_changed_places_are_bad() {
    let scene = lit_room();
    let case = Case::new(&scene, 400, 64, Basis::Constant);
    let sound = case.solve(Method::Direct);
    let mut solution = sound.clone();
    let [front, back] = Side::BOTH.map(|side| case.patches.patches_of(12, side));
    front.zip(back).for_each(|(front, back)| solution.radiance.swap_rows(front, back));
    let verdict = case.judge_with(&solution, &case.energy(&sound));
    let reason = &verdict.reasons[0];
    assert_eq!(
        (reason.cause, reason.level, reason.faces[0]),
        (Cause::Unsolved, Level::Bad, 12),
        "{verdict:#?}"
    );
}

#[test]
fn an_answer_that_does_not_solve_the_equation_is_unsolved() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 400, 64, Basis::Constant);
    case.order = 8;
    let mut rough = case.solve(Method::Neumann);
    only(&case.judge(&rough), Cause::Truncation, Level::Truncated);
    // The same from a solver that claims to have ended by itself.
    rough.report.truncated = false;
    only(&case.judge(&rough), Cause::Unsolved, Level::Doubtful);
}

#[test]
fn truncated_series_say_how_much_light_is_missing() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 400, 64, Basis::Constant);
    for tolerance in [0.0, 1e-6] {
        case.tolerance = tolerance;
        let mut before = f64::INFINITY;
        for order in [0, 1, 2, 4, 8] {
            case.order = order;
            let solution = case.solve(Method::Neumann);
            let reason = only(&case.judge(&solution), Cause::Truncation, Level::Truncated);
            let share = reason.power_share.unwrap();
            assert!(share < before && share > 0.3 * 0.6f64.powi(order as i32 + 1), "{order}: {share}");
            before = share;
        }
        case.order = 200;
        assert_eq!(case.judge(&case.solve(Method::Neumann)), Verdict::default(), "tolerance {tolerance}");
    }
}

#[test]
fn one_row_of_form_factors_that_does_not_close_is_named() {
    let scene = lit_room();
    for factor in [0.5, 0.99, 1.01] {
        let mut case = Case::new(&scene, 400, 64, Basis::Constant);
        let (mut areas, escape) = case.exchange();
        case.put_back((areas.clone(), escape.clone()));
        assert_eq!(case.judge(&case.solve(Method::Direct)), Verdict::default(), "rounded, but sound");
        // Of a patch's exchange with all others; the others lack as little as it is of what they see.
        let patch = case.patch_of(6);
        for j in 0..areas.ncols() {
            areas[(patch, j)] *= factor;
            areas[(j, patch)] = areas[(patch, j)];
        }
        case.put_back((areas, escape));
        let verdict = case.judge(&case.solve(Method::Direct));
        let closure = verdict.reasons.iter().find(|reason| reason.cause == Cause::Closure);
        assert!(closure.is_some_and(|reason| reason.faces.contains(&6)), "{factor}: {verdict:#?}");
        assert!(verdict.level >= Level::Doubtful);
    }
}

#[test]
fn form_factors_that_lose_a_tenth_of_all_light_are_bad() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 400, 64, Basis::Constant);
    let (areas, escape) = case.exchange();
    case.put_back((areas * 0.9, escape));
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::Closure, Level::Bad);
    assert!(reason.power_share.is_some_and(|share| share > 0.1) && reason.faces.len() == 14);
}

#[test]
fn rays_that_escape_from_a_closed_room_are_a_fault_and_through_a_window_are_none() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 400, 64, Basis::Constant);
    let (mut areas, mut escape) = case.exchange();
    areas *= 0.95;
    escape.axpy(0.05, &case.factors.exchange().areas(), 1.0);
    case.put_back((areas, escape));
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::Escape, Level::Bad);
    assert_eq!(reason.faces.len(), 14);

    let walls = room([0.0; 3], [2.0, 3.0, 2.5]).map(|wall| (wall, 0));
    // Without its ceiling, and with a closed box inside, whose outside sees the sky.
    let body = room([0.5, 0.5, 0.2], [1.0, 1.0, 1.0]).map(|side| (flipped(side), 0));
    let open = quads(&[&walls[..5], &[(LAMP, 1)], &body[..]].concat(), materials());
    let case = Case::new(&open, 400, 64, Basis::Constant);
    let solution = case.solve(Method::Direct);
    assert!(case.energy(&solution).escaped[0] > 0.0);
    assert_eq!(case.judge(&solution), Verdict::default());
}

#[test]
fn a_patch_without_rays_is_named() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 400, 64, Basis::Constant);
    let patch = case.patch_of(6);
    // Its area is that of nothing else, so that the others close without it.
    let (mut areas, mut escape) = case.exchange();
    for j in (0..areas.ncols()).filter(|&j| j != patch) {
        let lost = f64::from(std::mem::take(&mut areas[(j, patch)]));
        areas[(j, j)] += lost as f32;
        areas[(patch, j)] = 0.0;
    }
    areas[(patch, patch)] = 0.0;
    escape[patch] = 0.0;
    case.put_back((areas.clone(), escape.clone()));
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::NoRays, Level::Doubtful);
    assert_eq!(reason.faces, [6]);
    // The same where all that the patch sends out is said to escape, from a closed room.
    escape[patch] = case.factors.exchange().areas()[patch];
    case.put_back((areas, escape));
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::NoRays, Level::Doubtful);
    assert_eq!(reason.faces, [6]);
}

#[test]
fn faces_that_overlap_are_told_and_do_no_harm() {
    let scene = room_with_rug();
    let case = Case::new(&scene, 200, 64, Basis::Constant);
    let verdict = case.judge(&case.solve(Method::Direct));
    let reason = only(&verdict, Cause::Overlap, Level::Good);
    assert!(reason.faces.iter().all(|face| [4, 5, 14, 15].contains(face)), "{reason:?}");
    assert!(["quad 2", "quad 7"].iter().all(|name| reason.objects.iter().any(|object| object == name)));
    // As much of the light as arrives on the floor and the rug.
    let solution = case.solve(Method::Direct);
    let areas = case.patches.areas();
    let flux = |i: usize| areas[i] * solution.irradiance[(i, 0)];
    let is_named = |i: &usize| reason.faces.contains(&case.patches.place(*i).face);
    let [named, all] =
        [0, 1].map(|k| (0..areas.len()).filter(|i| k == 1 || is_named(i)).map(flux).sum::<f64>());
    assert!((reason.power_share.unwrap() / (named / all) - 1.0).abs() < 1e-9, "{reason:?}");
}

#[test]
fn overlaps_that_no_light_has_to_do_with_are_not_told() {
    let standing = |underside: u32| {
        let walls = room([0.0; 3], [2.0, 3.0, 2.5]).map(|wall| (wall, 0));
        let boxes = [([0.4, 0.4], [1.0, 1.2], 0.5), ([0.7, 0.8], [1.6, 1.9], 0.8)];
        let sides = boxes.map(|([x, y], [to_x, to_y], height)| {
            let quads = room([x, y, 0.0], [to_x, to_y, height]).map(flipped);
            [0, 1, 2, 3, 4, 5].map(|side| (quads[side], if side == 2 { underside } else { 0 }))
        });
        quads(&[&walls[..], &[(LAMP, 1)], &sides[0], &sides[1]].concat(), materials())
    };
    let (dark, shining) = (standing(0), standing(1));
    let verdict = |scene: &Scene| {
        let case = Case::new(scene, 300, 64, Basis::Constant);
        assert!(case.tracer.overlaps().iter().any(|overlap| overlap.kind == OverlapKind::SameFront));
        case.judge(&case.solve(Method::Direct))
    };
    assert_eq!(verdict(&dark), Verdict::default());
    only(&verdict(&shining), Cause::Overlap, Level::Good);
}

#[test]
fn directions_that_disagree_are_doubtful() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    assert!(case.factors.disagreements().is_empty());
    let pair = Disagreement { sides: [(7, Side::Front), (2, Side::Front)], z: 6.0 };
    case.factors = case.factors.clone().with_disagreements(vec![pair]);
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::Directions, Level::Doubtful);
    assert!(reason.faces.contains(&7) && reason.faces.contains(&2) && reason.faces.len() == 2);
}

#[test]
fn a_reason_is_told_in_one_line() {
    let scene = lit_room();
    let mut case = Case::new(&scene, 200, 64, Basis::Constant);
    let front = |face| (face, Side::Front);
    let pairs = [[0, 2], [4, 6], [1, 3], [5, 7]];
    let pairs = pairs.map(|pair| Disagreement { sides: pair.map(front), z: 9.0 });
    case.factors = case.factors.clone().with_disagreements(pairs.to_vec());
    let reason = only(&case.judge(&case.solve(Method::Direct)), Cause::Directions, Level::Doubtful);
    let line = reason.to_string();
    let [a, b, c, ..] = reason.faces[..] else { panic!("{reason:?}") };
    assert!(line.starts_with("directions that disagree: "), "{line}");
    assert!(line.contains(&format!(" % of the light, at faces {a}, {b}, {c} and 5 more of quad ")), "{line}");
    assert!(line.ends_with(&format!(" and 1 more; {}", reason.remedy)) && !line.contains('\n'), "{line}");
}
