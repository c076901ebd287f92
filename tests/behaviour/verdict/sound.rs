//! Answers on sound scenes are good, by every solver.

use radiosity::measure::{ErrorBars, Verdict};
use radiosity::patches::Basis;
use radiosity::progress::Progress;
use radiosity::solve::Method;

use super::Case;
use crate::scenes::{mesh, meshes};

const METHODS: [Method; 3] = [Method::Direct, Method::ConjugateGradients, Method::Neumann];

#[test]
fn answers_on_sound_scenes_are_good_and_give_no_reasons() {
    for name in meshes() {
        let scene = mesh(&name);
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
                    assert_eq!(verdict, Verdict::default(), "{name} {basis:?} {rays} {method:?}");
                }
            }
        }
    }
}
