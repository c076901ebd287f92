//! Answers that are damaged or cut short: numbers that are not finite, energy, the equation, truncation.

use radiosity::measure::{Cause, ErrorBars, Level, Verdict};
use radiosity::patches::Basis;
use radiosity::progress::Progress;
use radiosity::scene::Side;
use radiosity::solve::Method;

use super::{Case, lit_room, only};

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
