//! Light paths and pictures show the light through sheets that the matrix does.

use glam::DVec3;
use radiosity::measure::ErrorBars;
use radiosity::patches::{Basis, PatchSize};
use radiosity::progress::Progress;
use radiosity::reference::PathTracer;
use radiosity::render::{self, RenderOptions, Shading};
use radiosity::scene::Camera;
use radiosity::solve::{self, CgOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, TraceOptions, Transport};

use super::{around, factors, gauze, paper};
use crate::scenes::{BASES, cut_into, paths};

#[test]
fn light_paths_through_sheets_agree_with_the_matrix() {
    for wall in [paper(), gauze()] {
        let scene = around(wall);
        let tracer = Tracer::new(&scene);
        for basis in BASES {
            let mut patches = cut_into(&tracer, 2000);
            let options = TraceOptions { rays: Some(512), basis, keep: Keep::Rays, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
            let solution = problem.conjugate_gradients(&CgOptions::default()).unwrap();
            let bars = ErrorBars::of(&patches, &problem, &solution, Progress::default()).unwrap();
            let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(1_000_000)).unwrap();
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
            let by_paths: Vec<[f64; 3]> = (0..8).map(|seed| seen(Shading::Path, seed)).collect();
            for shading in [Shading::Flat, Shading::Smooth, Shading::Gather] {
                let found = seen(shading, 8);
                for c in 0..3 {
                    let mean = by_paths.iter().map(|path| path[c]).sum::<f64>() / 8.0;
                    let spread: f64 = by_paths.iter().map(|path| (path[c] - mean).powi(2)).sum();
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
