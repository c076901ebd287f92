//! Form factors known from closed forms and integrals.

use radiosity::scene::Scene;

use super::{Effort, FRONTS, by_object, data, factor};

/// Form factors of fronts over the whole front area, from closed forms and integrals.
const KNOWN: [(&str, &str, &str, f64); 14] = [
    ("box_in_box", "inner", "outer", 1.0),
    ("box_in_box", "outer", "inner", 0.08666666666666667),
    ("cube_inside", "bottom", "top", 0.19982489569838746),
    ("cube_inside", "bottom", "x0", 0.20004377607540316),
    ("far_small", "a", "b", 3.183096739773802e-07),
    ("ratio_1e6", "sensor", "plate", 0.5541262780829919),
    ("raystrack_canyon", "road", "east2", 0.02611759774068142),
    ("raystrack_canyon", "east0", "west0", 0.13331095314066324),
    ("raystrack_canyon", "east0", "west4", 0.00769084427065149),
    ("slit_boxes", "a", "b", 0.000147544),
    ("slot", "bottom", "top", 0.9041979180566159),
    ("slot", "y0", "y1", 3.1829883060323753e-06),
    ("v3d_square_obstruction", "zeq0", "zeq1", 0.14986867177379062),
    ("wedge_5deg", "a", "b", 0.920261908111222),
];

#[test]
fn known_form_factors_lie_within_four_standard_errors_and_below_the_bound_of_zeros() {
    for (name, from, to, exact) in KNOWN {
        let scene = Scene::load(data(name)).unwrap();
        by_object(&scene, FRONTS, Effort { patches: 1000, rays: 128, seed: 0 }, |table| {
            let found = factor(table, from, to);
            let z = (found.form_factor - exact) / found.standard_error.unwrap();
            assert!(z.abs() < 4.0, "{name}: {from} to {to} is {exact}: {found:?}, z = {z}");
            let is_below = found.upper95.unwrap() >= exact;
            assert!(is_below || found.form_factor > 0.0, "{name}: {from} to {to} is {exact}: {found:?}");
        });
    }
}
