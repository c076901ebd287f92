//! Direct light by light sampling: without bias to speak of, and no worse than rays where everything emits.

use radiosity::patches::{PatchSize, Patches, Tessellation};
use radiosity::scene::{Material, Scene};
use radiosity::solve;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions, Transport};

use crate::scenes::{Quad, cut, flipped, quads, room};

fn sheet(low: [f64; 2], high: [f64; 2], y: f64) -> Quad {
    [[low[0], y, low[1]], [low[0], y, high[1]], [high[0], y, high[1]], [high[0], y, low[1]]]
}

/// A small receiver in a grey room under a near lamp, part of which a blocker hides.
fn shaded(blocker: Option<Quad>) -> Scene {
    let walls = room([-1.0, 0.0, -1.0], [1.0, 1.0, 1.0]).map(|quad| (quad, 0));
    let receiver = (sheet([-0.1, -0.1], [0.1, 0.1], 0.1), 0);
    let lamp = (flipped(sheet([-0.5, -0.5], [0.5, 0.5], 0.6)), 1);
    let blocker = blocker.map(|quad| (quad, 0));
    let all: Vec<(Quad, u32)> = walls.into_iter().chain([receiver, lamp]).chain(blocker).collect();
    quads(&all, vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.0], &[1.0])])
}

/// Direct irradiance of the receiver.
fn irradiance(scene: &Scene, rays: u32, lamp_rays: u32, seed: u64) -> f64 {
    let tracer = Tracer::new(scene);
    let mut patches = cut(&tracer, PatchSize::Edge(2.5));
    let options = TraceOptions { rays: Some(rays), lamp_rays: Some(lamp_rays), seed, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let k = Transport::of(&factors, &patches).unwrap();
    let h = k.irradiance(&patches.emitted_radiance());
    let faces = patches.average_by_face(&h);
    faces.iter().filter(|f| [12, 13].contains(&f.face)).map(|f| f.mean[0]).sum::<f64>() / 2.0
}

#[test]
fn partly_hidden_lamps_are_seen_without_bias() {
    // Nothing, a corner, half and nearly all of the lamp is hidden.
    let blockers = [
        None,
        Some(sheet([0.2, 0.2], [0.5, 0.5], 0.55)),
        Some(sheet([0.0, -0.6], [0.6, 0.6], 0.5)),
        Some(sheet([-0.4, -0.6], [0.6, 0.6], 0.5)),
    ];
    let scenes = blockers.map(shaded);
    let exact = scenes.each_ref().map(|scene| irradiance(scene, 1 << 14, 1 << 17, 999));
    let unhidden = exact[0];
    for (case, (scene, exact)) in scenes.iter().zip(exact).enumerate() {
        const SEEDS: usize = 160;
        let values: Vec<f64> = (0..SEEDS).map(|seed| irradiance(scene, 512, 256, seed as u64)).collect();
        let mean = values.iter().sum::<f64>() / SEEDS as f64;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (SEEDS - 1) as f64;
        let standard_error = (variance / SEEDS as f64).sqrt() / unhidden;
        let bias = (mean - exact) / unhidden;
        assert!(standard_error < 1e-3, "case {case}: too noisy to tell: {standard_error}");
        assert!(bias.abs() < 1e-3 + 2.0 * standard_error, "case {case}: bias {bias} ± {standard_error}");
    }
}

#[test]
fn where_everything_emits_light_sampling_changes_nothing() {
    let walls = room([0.0; 3], [1.0, 2.0, 1.5]);
    let materials = vec![Material::lamp("dim", &[0.5], &[1.0]), Material::lamp("bright", &[0.3], &[1.4])];
    let scene = quads(&[0, 1, 0, 1, 0, 1].map(|m| (walls[m as usize], m)), materials);
    let solved = |lamp_rays: u32| {
        let tracer = Tracer::new(&scene);
        let mut patches = Patches::new(&tracer, &Tessellation::default()).unwrap();
        let options = TraceOptions { rays: Some(64), lamp_rays: Some(lamp_rays), ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let k = Transport::of(&factors, &patches).unwrap();
        solve::solve(&k, &patches.emitted_radiance(), &Default::default()).unwrap().radiance
    };
    assert_eq!(solved(0), solved(64));
}
