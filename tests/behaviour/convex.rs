//! Empty convex scenes: exact form factors between polygons, without a ray.

use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::scene::{Material, Scene, Side};
use radiosity::solve::{self, NeumannOptions, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{
    Forecast, FormFactors, LightOptions, Occlusion, Plan, Solving, TraceOptions, Transport, Work,
};

use crate::scenes::{flipped, mesh, quads, room, traced};

fn factors<'s>(scene: &'s Scene, count: usize, options: &TraceOptions) -> (Patches<'s>, FormFactors) {
    traced(scene, PatchSize::Count(count), options)
}

/// A grey room with a lamp in a wall of its own, in the middle of the ceiling's plane but beside its faces.
fn lit_room() -> Scene {
    let [left, floor, back, right, ceiling, front] = room([0.0; 3], [2.0, 1.0, 1.5]);
    let walls = [left, floor, back, right, front].map(|quad| (quad, 0));
    let split = |x: [f64; 2]| ceiling.map(|[cx, y, z]| [if cx == 0.0 { x[0] } else { x[1] }, y, z]);
    let strips = [(split([0.0, 0.8]), 0), (split([0.8, 1.2]), 1), (split([1.2, 2.0]), 0)];
    let materials = vec![Material::diffuse("wall", &[0.6]), Material::lamp("lamp", &[0.2], &[5.0])];
    quads(&[&walls[..], &strips].concat(), materials)
}

/// Form factor from all patches of these faces to all of those, by the operator.
fn between(patches: &Patches, factors: &FormFactors, from: &[usize], to: &[usize]) -> f64 {
    let of = |faces: &[usize]| -> Vec<usize> {
        (0..patches.len()).filter(|&i| faces.contains(&patches.place(i).face)).collect()
    };
    let (from, to) = (of(from), of(to));
    let area: f64 = from.iter().map(|&i| patches.area(i)).sum();
    let sum = |&i: &usize| to.iter().map(|&j| factors.exchange().exchange_area(i, j)).sum::<f64>();
    from.iter().map(sum).sum::<f64>() / area
}

#[test]
fn closed_forms_are_met_to_a_millionth_however_fine_the_cut() {
    let scene = mesh("facing_plates");
    let cube = mesh("furnace_cube");
    for count in [4, 60, 1500] {
        // Howell C-11 with X = Y = 1.
        let (patches, exact) = factors(&scene, count, &TraceOptions::default());
        assert_eq!(exact.rays(), 0);
        let off = between(&patches, &exact, &[0, 1], &[2, 3]) / 0.199_824_895_698_387 - 1.0;
        assert!(off.abs() < 1e-6, "{} patches: {off}", patches.len());
        // Howell C-14 with three equal sides, between neighbouring walls of a cube.
        let (patches, exact) = factors(&cube, count, &TraceOptions::default());
        let neighbour = 0.200_043_776_075_403_95;
        let off = between(&patches, &exact, &[0, 1], &[4, 5]) / neighbour - 1.0;
        assert!(off.abs() < 1e-6, "{} patches: {off}", patches.len());
    }
}

#[test]
fn a_furnace_without_rays_is_exact_at_every_order() {
    for name in ["furnace_cube", "furnace_sphere"] {
        let scene = mesh(name);
        let (patches, exact) = factors(&scene, 600, &TraceOptions::default());
        assert_eq!(exact.rays(), 0, "{name}");
        // What rows lack before they are balanced is all that integration leaves.
        let closure = exact.exchange().closure();
        assert!(closure.before < 1e-5 && closure.after < 1e-11, "{name}: {closure:?}");
        assert_eq!(exact.exchange().reciprocity_error(), 0.0);
        let k = Transport::of(&exact, &patches).unwrap();
        let e = patches.emitted_radiance();
        let (rho, emitted) = (k.reflectance()[0], e[0]);
        let solution =
            solve::solve(&k, &e, &SolveOptions { tolerance: 1e-12, ..Default::default() }).unwrap();
        let off = solution.radiance.map(|l| (l * (1.0 - rho) / emitted - 1.0).abs()).max();
        assert!(off < 1e-10, "{name}: {off}");
        let options = NeumannOptions { order: 5, tolerance: 0.0, ..Default::default() };
        let sum = solve::neumann(&k, &e, &options).unwrap().solution.radiance;
        let expected = emitted * (1.0 - rho.powi(6)) / (1.0 - rho);
        assert!(sum.map(|l| (l / expected - 1.0).abs()).max() < 1e-10, "{name}");
    }
}

#[test]
fn rays_converge_to_what_needs_none() {
    let scene = lit_room();
    let solved = |options: &TraceOptions| {
        let (patches, factors) = factors(&scene, 600, options);
        let k = Transport::of(&factors, &patches).unwrap();
        let solution = solve::solve(&k, &patches.emitted_radiance(), &SolveOptions::default()).unwrap();
        (factors.rays(), solution.irradiance)
    };
    let (none, exact) = solved(&TraceOptions::default());
    assert_eq!(none, 0);
    let by_rays = |rays: u32| {
        let (used, irradiance) = solved(&TraceOptions { rays: Some(rays), ..Default::default() });
        assert_eq!(used, rays);
        (irradiance - &exact).norm() / exact.norm()
    };
    let (few, many) = (by_rays(64), by_rays(4096));
    // At least as one over the root of their number.
    assert!(many < few / 8.0, "{few} {many}");
}

#[test]
fn rays_are_traced_where_something_hides_overlaps_or_asks_for_them() {
    let rays = |scene: &Scene, options: &TraceOptions| factors(scene, 100, options).1.rays();
    let open = TraceOptions::default();
    assert_eq!(rays(&lit_room(), &open), 0);
    for options in [
        TraceOptions { occlusion: Occlusion::Always, ..open },
        TraceOptions { basis: Basis::Linear, ..open },
        TraceOptions { rays: Some(512), ..open },
    ] {
        assert_eq!(rays(&lit_room(), &options), 512);
    }
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let materials = || vec![Material::diffuse("wall", &[0.5]), Material::lamp("lamp", &[0.0], &[1.0])];
    let patch = |y: f64| flipped([[0.2, y, 0.2], [0.2, y, 0.8], [0.8, y, 0.8], [0.8, y, 0.2]]);
    // Flush with the ceiling, which goes on behind it; and a little below.
    for y in [1.0, 0.9] {
        let scene = quads(&[&walls[..], &[(patch(y), 1)]].concat(), materials());
        assert_eq!(rays(&scene, &open), 512, "{y}");
    }
    // Backs see nothing of it.
    let scene = lit_room();
    let (patches, _) = factors(&scene, 100, &open);
    assert!((0..patches.len()).all(|i| patches.place(i).side == Side::Front));
}

#[test]
fn the_plan_says_why_there_are_rays_or_none() {
    let occlusion = |scene: &Scene, trace: &TraceOptions, count: usize| {
        let work = Work {
            tessellation: &Tessellation { size: PatchSize::Count(count), ..Default::default() },
            trace,
            light: &LightOptions::default(),
            solving: Solving::Either,
            memory: 4 << 30,
            tolerance: 1e-6,
            order: 1000,
            pixels: 0,
        };
        let plan = Plan::new(scene).foretold(&Forecast::new(&Tracer::new(scene), &work).unwrap());
        let effect = plan.effects.into_iter().find(|effect| effect.effect == "occlusion rays").unwrap();
        (effect.on, effect.cost.rays, effect.reason)
    };
    let plain = TraceOptions::default();
    let (on, rays, reason) = occlusion(&lit_room(), &plain, 1000);
    assert!(!on && rays == 0 && reason.contains("exact"), "{reason}");
    for (trace, count, what) in [
        (TraceOptions { basis: Basis::Linear, ..plain }, 1000, "constant"),
        (TraceOptions { occlusion: Occlusion::Always, ..plain }, 1000, "asked"),
        (plain, 20_000, "quicker"),
    ] {
        let (on, rays, reason) = occlusion(&lit_room(), &trace, count);
        assert!(on && rays > 0 && reason.contains(what), "{what}: {reason}");
    }
    let (on, _, reason) = occlusion(&mesh("cornell_box"), &plain, 1000);
    assert!(on && reason.contains("not empty and convex"), "{reason}");
}
