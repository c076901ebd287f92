//! The path tracer against closed forms and against another renderer, judged by its own standard errors.

use std::f64::consts::PI;

use radiosity::patches::{PatchSize, Patches, Tessellation};
use radiosity::reference::{Budget, Estimate, PathError, PathOptions, PathTraced, PathTracer, ReferenceRow};
use radiosity::scene::{Material, Scene, Side};
use radiosity::solve;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions, Transport};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use crate::scenes::{cut, cut_into, grey, load, on_threads, paths, quads, reference, room};

/// Faces as they are, each a patch.
fn faces<'s>(tracer: &Tracer<'s>) -> Patches<'s> {
    cut(tracer, PatchSize::Edge(1e6))
}

/// A closed cube in which everything reflects ρ and emits 1.
fn furnace(rho: f64) -> Scene {
    let wall = Material::lamp("wall", &[rho], &[1.0]);
    quads(&room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0)), vec![wall])
}

/// The mean over all patches, weighted by area.
fn over_all(traced: &PathTraced, value: impl Fn(usize) -> Estimate) -> Estimate {
    let whole: f64 = (0..traced.len()).map(|i| traced.area(i)).sum();
    let (mut mean, mut variance) = (0.0, 0.0);
    for i in 0..traced.len() {
        let part = value(i);
        mean += traced.area(i) / whole * part.mean;
        variance += (traced.area(i) / whole * part.standard_error).powi(2);
    }
    Estimate { mean, standard_error: variance.sqrt() }
}

/// What |z| stays below with probability 99.73 %, three standard errors, for the largest of `count`.
fn three_sigma(count: usize) -> f64 {
    let single = 1.0 - 0.9973f64.powf(1.0 / count as f64);
    Normal::standard().inverse_cdf(1.0 - 0.5 * single)
}

/// Traces every face of a scene to a standard error, and judges those known to 5 % against another renderer's
/// table, channel by channel.
fn agrees_with_another_renderer(name: &str, error: f64, least_faces: usize) {
    let scene = load(&format!("tests/data/{name}.obj"));
    let tracer = Tracer::new(&scene);
    let patches = faces(&tracer);
    let budget = Budget { standard_error: Some(error), ..Budget::default() };
    let options = PathOptions { budget, ..Default::default() };
    let traced = PathTracer::new(&tracer).irradiance(&patches, &options).unwrap();
    assert!(traced.relative_standard_error() <= error);
    let rows = traced.by_face(&patches);
    for channel in 0..3 {
        let z: Vec<f64> = reference(name)
            .iter()
            .filter_map(|theirs| {
                let ours = rows.iter().find(|row| (row.face, row.side) == (theirs.face, theirs.side))?;
                let known = |row: &ReferenceRow| (row.mean[channel], row.standard_error[channel]);
                let ((a, error_a), (b, error_b)) = (known(ours), known(theirs));
                let sharp = error_a < 0.05 * a && error_b < 0.05 * b;
                sharp.then(|| (a - b) / error_a.hypot(error_b))
            })
            .collect();
        let n = z.len() as f64;
        assert!(z.len() >= least_faces, "{name}: {n} faces");
        let mean = z.iter().sum::<f64>() / n;
        assert!(mean.abs() <= 3.0 / n.sqrt(), "{name} channel {channel}: mean z {mean} of {n} faces");
        // At the 0.1 % level from above: all three channels together, from below too.
        let squares: f64 = z.iter().map(|z| z * z).sum();
        let chi = ChiSquared::new(n).unwrap();
        let (above, below) = (chi.sf(squares), chi.cdf(squares));
        assert!(
            above > 1e-3 / 3.0 && below > 1e-3 / 3.0,
            "{name} channel {channel}: χ² {squares} of {n} faces"
        );
    }
}

#[test]
fn the_cornell_box_is_as_another_renderer_finds_it() {
    agrees_with_another_renderer("cornell", 0.003, 36);
}

#[test]
fn every_small_face_of_the_cornell_box_is_as_another_renderer_finds_it() {
    agrees_with_another_renderer("cornell_fine", 0.0125, 2800);
}

#[test]
fn two_rooms_joined_by_a_door_are_as_another_renderer_finds_them() {
    agrees_with_another_renderer("gallery", 0.0125, 800);
}

#[test]
fn each_bounce_of_a_furnace_has_its_closed_form() {
    for rho in [0.3, 0.8] {
        let scene = furnace(rho);
        let tracer = Tracer::new(&scene);
        let patches = faces(&tracer);
        let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(400_000)).unwrap();
        let limit = three_sigma(7);
        let judge = |what: &str, found: Estimate, exact: f64| {
            let z = (found.mean - exact) / found.standard_error;
            assert!(
                found.standard_error < 0.02 * exact && z.abs() < limit,
                "{rho} {what}: {found:?} {exact}"
            );
        };
        // Bounce k of radiance is Lₑ ρᵏ; it comes from irradiance π Lₑ ρᵏ⁻¹.
        for k in 1..=6 {
            let found = over_all(&traced, |i| traced.irradiance_by_bounce(k, i, 0));
            judge(&format!("bounce {k}"), found, PI * rho.powi(k as i32 - 1));
        }
        judge("all bounces", over_all(&traced, |i| traced.irradiance(i, 0)), PI / (1.0 - rho));
    }
}

#[test]
fn bounces_add_up_to_the_whole() {
    let scene = furnace(0.5);
    let tracer = Tracer::new(&scene);
    let patches = faces(&tracer);
    let traced = |longest| {
        let options = PathOptions { bounces: 4, longest, ..paths(2_000) };
        PathTracer::new(&tracer).irradiance(&patches, &options).unwrap()
    };
    let cut = traced(Some(3));
    for i in 0..patches.len() {
        let sum: f64 = (1..=4).map(|k| cut.irradiance_by_bounce(k, i, 0).mean).sum();
        assert!((sum / cut.irradiance(i, 0).mean - 1.0).abs() < 1e-12);
        assert!(sum < traced(None).irradiance(i, 0).mean);
    }
}

#[test]
fn each_bounce_of_the_cornell_box_meets_its_term_of_the_series_the_better_the_finer_the_mesh() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let coarse = faces(&tracer);
    let traced = PathTracer::new(&tracer).irradiance(&coarse, &paths(1_000_000)).unwrap();
    // Per bounce 1 to 6: relative root mean square over fronts of faces, the noise of paths taken off, and
    // that noise.
    let errors = |count: usize| -> Vec<[f64; 2]> {
        let mut patches = cut_into(&tracer, count);
        let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap();
        let k = Transport::of(&factors, &patches).unwrap();
        let terms = solve::bounces(&k, &patches.emitted_radiance(), 5);
        let bounce = |(before, term)| {
            let rows = patches.average_by_face(&k.irradiance(term));
            let (mut squares, mut noise, mut whole) = (0.0, 0.0, 0.0);
            for row in rows.iter().filter(|row| row.side == Side::Front) {
                let i = coarse.patches_of(row.face, row.side).start;
                for c in 0..3 {
                    let found = traced.irradiance_by_bounce(before + 1, i, c);
                    squares += row.area * (row.mean[c] - found.mean).powi(2);
                    noise += row.area * found.standard_error.powi(2);
                    whole += row.area * found.mean.powi(2);
                }
            }
            [((squares - noise).max(0.0) / whole).sqrt(), (noise / whole).sqrt()]
        };
        terms.iter().enumerate().map(bounce).collect()
    };
    let [coarse, middle, fine] = [150, 1500, 15_000].map(errors);
    for k in 0..6 {
        let ([a, _], [b, noise], [c, _]) = (coarse[k], middle[k], fine[k]);
        let bounce = k + 1;
        // Each cut has patches a third as long.
        assert!(b < 0.7 * a + noise && c < 0.7 * b + noise, "bounce {bounce}: {a} {b} {c}, noise {noise}");
        assert!(c < 0.02, "bounce {bounce}: {c}");
    }
}

#[test]
fn russian_roulette_is_unbiased_and_of_finite_variance_where_almost_nothing_is_absorbed() {
    let scene = furnace(0.98);
    let tracer = Tracer::new(&scene);
    let patches = faces(&tracer);
    let tracing = PathTracer::new(&tracer);
    let whole = |traced: &PathTraced| over_all(traced, |i| traced.irradiance(i, 0));
    let options = paths(20_000);
    let mut traced = tracing.irradiance(&patches, &options).unwrap();
    let few = whole(&traced).standard_error;
    tracing.refine(&patches, &mut traced, &PathOptions { budget: paths(300_000).budget, ..options }).unwrap();
    let many = whole(&traced);
    let z = (many.mean - PI / 0.02) / many.standard_error;
    assert!(z.abs() < 3.0 && many.standard_error < 0.01 * many.mean, "{many:?}: {z}");
    // Sixteen times the paths: a quarter of the error.
    assert!((3.0..5.3).contains(&(few / many.standard_error)), "{few} {many:?}");
}

#[test]
fn sharing_paths_out_by_variance_does_not_bias_the_mean() {
    let scene = furnace(0.7);
    let tracer = Tracer::new(&scene);
    let patches = cut_into(&tracer, 200);
    let tracing = PathTracer::new(&tracer);
    let exact = PI / 0.3;
    let z: Vec<f64> = (0..60)
        .map(|seed| {
            let options = PathOptions { seed, ..paths(256 * patches.len() as u64) };
            let traced = tracing.irradiance(&patches, &options).unwrap();
            let found = over_all(&traced, |i| traced.irradiance(i, 0));
            (found.mean - exact) / found.standard_error
        })
        .collect();
    let n = z.len() as f64;
    let (mean, square) = (z.iter().sum::<f64>() / n, z.iter().map(|z| z * z).sum::<f64>() / n);
    assert!(mean.abs() < 3.0 / n.sqrt(), "mean z {mean}");
    assert!((square - 1.0).abs() < 3.0 * (2.0 / n).sqrt(), "mean z² {square}");
}

#[test]
fn patches_that_vary_more_get_more_paths() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let patches = faces(&tracer);
    let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(200_000)).unwrap();
    // What a patch adds to the error of the whole, per path, is √A σ = √A se √n.
    let worth = |i: usize| {
        let error: f64 = (0..3).map(|c| traced.irradiance(i, c).standard_error.powi(2)).sum();
        (traced.area(i) * error * traced.paths_of(i) as f64).sqrt()
    };
    let by_worth = |pick: fn(f64, f64) -> bool| {
        (1..patches.len()).fold(0, |best, i| if pick(worth(i), worth(best)) { i } else { best })
    };
    let (most, least) = (by_worth(|a, b| a > b), by_worth(|a, b| a < b));
    assert!(traced.paths_of(most) > 3 * traced.paths_of(least));
    assert_eq!((0..patches.len()).map(|i| traced.paths_of(i)).sum::<u64>(), traced.paths());
    assert!((150_000..300_000).contains(&traced.paths()), "{}", traced.paths());
}

#[test]
fn more_paths_continue_the_same_estimate() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let patches = faces(&tracer);
    let tracing = PathTracer::new(&tracer);
    let budget = Budget { standard_error: Some(0.04), ..Budget::default() };
    let options = PathOptions { budget, ..Default::default() };
    let mut traced = tracing.irradiance(&patches, &options).unwrap();
    let (before, paths) = (traced.relative_standard_error(), traced.paths());
    assert!(before <= 0.04);
    let budget = Budget { standard_error: Some(0.01), ..Budget::default() };
    tracing.refine(&patches, &mut traced, &PathOptions { budget, ..options }).unwrap();
    assert!(traced.relative_standard_error() <= 0.01 && traced.paths() > 8 * paths);
    // All that was known is still in it: one and the same face moves by no more than it was unsure.
    let again = tracing.irradiance(&patches, &PathOptions { budget, ..options }).unwrap();
    let apart = (traced.means() - again.means()).norm() / again.means().norm();
    assert!(apart < 0.05, "{apart}");
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let patches = cut_into(&tracer, 200);
    let on = |threads: usize, seed: u64| {
        let options = PathOptions { seed, ..paths(30_000) };
        on_threads(threads, || PathTracer::new(&tracer).irradiance(&patches, &options)).unwrap().means()
    };
    assert_eq!(on(1, 3), on(3, 3));
    assert_ne!(on(1, 3), on(1, 4));
}

#[test]
fn no_budget_is_an_error_and_no_light_is_none() {
    let dark = quads(&[(room([0.0; 3], [1.0; 3])[1], 0)], grey(0.5));
    let tracer = Tracer::new(&dark);
    let reach = radiosity::patches::Reach::Everything;
    let size = PatchSize::Count(20);
    let patches = Patches::new(&tracer, &Tessellation { size, reach, ..Default::default() }).unwrap();
    let tracing = PathTracer::new(&tracer);
    let zero = |x| Budget { standard_error: Some(x), ..Budget::default() };
    let time = |x| Budget { seconds: Some(x), ..Budget::default() };
    for budget in [Budget::default(), paths(0).budget, zero(0.0), zero(-1.0), zero(f64::NAN), time(0.0)] {
        let refused = tracing.irradiance(&patches, &PathOptions { budget, ..Default::default() });
        assert!(matches!(refused, Err(PathError::Budget)), "{budget:?}");
    }
    let traced = tracing.irradiance(&patches, &PathOptions::default()).unwrap();
    assert!(traced.means().iter().all(|&h| h == 0.0) && traced.relative_standard_error() == 0.0);
}
