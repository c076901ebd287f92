//! Form factors against closed forms, judged by their own standard errors.

use radiosity::patches::{PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::Scene;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, GroupFactor, Keep, TraceOptions};

use crate::scenes::{flipped, grey, quads, room};

/// Form factors between the quads of a scene.
fn between_quads(scene: &Scene, patches: usize, rays: u32, seed: u64) -> Vec<GroupFactor> {
    let tracer = Tracer::new(scene);
    let options = Tessellation {
        size: PatchSize::Count(patches),
        reach: Reach::Everything,
        seed,
        ..Default::default()
    };
    let mut patches = Patches::new(&tracer, &options).unwrap();
    let options = TraceOptions { rays: Some(rays), seed, keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let group_of: Vec<usize> = (0..patches.len()).map(|i| patches.place(i).face / 2).collect();
    factors.between_groups(&patches, &group_of, Progress::default()).unwrap()
}

fn find(factors: &[GroupFactor], from: usize, to: usize) -> GroupFactor {
    *factors.iter().find(|f| f.from == from && f.to == Some(to)).unwrap()
}

fn parallel(x: f64) -> Scene {
    let floor = [[0.0, 0.0, 0.0], [0.0, 0.0, x], [x, 0.0, x], [x, 0.0, 0.0]];
    let ceiling = [[0.0, 1.0, 0.0], [x, 1.0, 0.0], [x, 1.0, x], [0.0, 1.0, x]];
    quads(&[(floor, 0), (ceiling, 0)], grey(0.5))
}

/// Two rectangles of width 1 and lengths `x` that meet at a right angle along their width... scaled: edge 1,
/// legs x.
fn perpendicular(x: f64) -> Scene {
    let floor = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [x, 0.0, 1.0], [x, 0.0, 0.0]];
    let wall = [[0.0, 0.0, 0.0], [0.0, x, 0.0], [0.0, x, 1.0], [0.0, 0.0, 1.0]];
    quads(&[(floor, 0), (wall, 0)], grey(0.5))
}

fn obstructed() -> Scene {
    let lower = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let raised = |z: f64, s: f64| [[0.0, 0.0, z], [s, 0.0, z], [s, s, z], [0.0, s, z]];
    quads(&[(lower, 0), (flipped(raised(1.0, 1.0)), 0), (raised(0.5, 0.5), 0)], grey(0.5))
}

#[test]
fn faces_of_a_cube_see_each_other_as_closed_forms_say() {
    let cube = quads(&room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0)), grey(0.5));
    let factors = between_quads(&cube, 1200, 512, 0);
    for from in 0..6 {
        let mut sum = 0.0;
        for to in (0..6).filter(|&to| to != from) {
            let exact = if from % 3 == to % 3 { 0.199824895698387 } else { 0.200043776075403 };
            let GroupFactor { form_factor, standard_error, .. } = find(&factors, from, to);
            assert!(standard_error <= 4e-4, "{from} {to}: standard error {standard_error}");
            let z = (form_factor - exact) / standard_error;
            assert!(z.abs() < 3.0, "{from} {to}: {form_factor} ± {standard_error}, z = {z}");
            sum += form_factor;
        }
        assert!((sum - 1.0).abs() < 1e-12);
    }
}

/// Howell, *A Catalog of Radiation Heat Transfer Configuration Factors*, C-11 and C-14.
const RECTANGLES: [(f64, f64, f64); 5] = [
    (0.1, 0.003162056838754, 0.281887806787901),
    (0.4, 0.046137416744875, 0.250319555056282),
    (1.0, 0.199824895698387, 0.200043776075403),
    (4.0, 0.632036430013860, 0.101358700221681),
    (10.0, 0.826994522397256, 0.055023979528411),
];

#[test]
fn standard_errors_tell_how_far_form_factors_are_from_closed_forms() {
    let mut cases: Vec<(Scene, f64)> = vec![(obstructed(), 0.149868671774)];
    for (x, facing, meeting) in RECTANGLES {
        cases.push((parallel(x), facing));
        cases.push((perpendicular(x), meeting));
    }
    const SEEDS: u64 = 20;
    let mut scores = Vec::new();
    for (scene, exact) in &cases {
        let of_case = (0..SEEDS).map(|seed| {
            let factor = find(&between_quads(scene, 100, 128, seed), 0, 1);
            (factor.form_factor - exact) / factor.standard_error
        });
        let of_case: Vec<f64> = of_case.collect();
        let mean = of_case.iter().sum::<f64>() / SEEDS as f64;
        // 7 degrees of freedom: Student's t has variance 7/5.
        let expected = (1.4f64 / SEEDS as f64).sqrt();
        assert!(mean.abs() < 3.5 * expected, "exact {exact}: mean z {mean} of {of_case:?}");
        scores.extend(of_case);
    }
    let n = scores.len() as f64;
    let mean = scores.iter().sum::<f64>() / n;
    let deviation = (scores.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let beyond = scores.iter().filter(|z| z.abs() > 3.0).count() as f64 / n;
    assert!(mean.abs() < 0.25, "mean z {mean}");
    assert!((0.9..1.5).contains(&deviation), "deviation of z {deviation}");
    assert!(beyond < 0.06, "{beyond} of all beyond three standard errors");
}
