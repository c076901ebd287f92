//! Upper bounds on form factors that few rays or none have found.

use radiosity::scene::Scene;

use super::{Effort, FRONTS, by_object, data, factor, place};
use crate::scenes::{facing, flipped, grey, quads};

#[test]
fn zero_hits_have_an_upper_bound() {
    let scene = Scene::load(data("far_small")).unwrap();
    by_object(&scene, FRONTS, Effort { patches: 20, rays: 64, seed: 0 }, |table| {
        let found = factor(table, "a", "b");
        let rays = 64.0 * table.patches().len() as f64;
        assert_eq!(found.form_factor, 0.0);
        assert!(found.standard_error.unwrap() > 0.0);
        let bound = found.upper95.unwrap() * rays;
        assert!((1.0..10.0).contains(&bound), "3 by the number of rays from both: {bound}");
        assert_eq!(factor(table, "a", "a").upper95, Some(0.0), "a plane provably sees nothing of itself");
        let escape = table.escape(place(table, "a"));
        assert!(
            (escape.form_factor - 1.0).abs() < 1e-12 && escape.standard_error.unwrap() > 0.0,
            "{escape:?}"
        );
    });
}

#[test]
fn upper_bounds_of_rare_pairs_hold_in_95_cases_of_100() {
    // From none to a few hits in a run, at a distance of twelve sides.
    let low = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    const APART: f64 = 12.0;
    let high = flipped(low.map(|[x, y, _]| [x, y, APART]));
    let scene = quads(&[(low, 0), (high, 0)], grey(0.5));
    let exact = facing(APART);
    const RUNS: u64 = 200;
    let (mut exceeded, mut zeros) = (0, 0);
    for seed in 0..RUNS {
        by_object(&scene, FRONTS, Effort { patches: 8, rays: 64, seed }, |table| {
            let found = factor(table, "quad 0", "quad 1");
            exceeded += u32::from(found.upper95.unwrap() < exact);
            zeros += u32::from(found.form_factor == 0.0);
        });
    }
    assert!(zeros > 10 && zeros < 190, "hits are rare: {zeros} of {RUNS} runs had none");
    // 10 are expected at most; binomial, 3.5 standard deviations.
    assert!(exceeded < 21, "{exceeded} of {RUNS} exceed their bound");
}
