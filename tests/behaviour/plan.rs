//! The plan: what it foretells against what comes of it.

use radiosity::patches::{Basis, PatchSize, Tessellation};
use radiosity::scene::{Material, Scene, SkyKind};
use radiosity::trace::Tracer;
use radiosity::transport::{
    Cost, Forecast, FormFactors, LightOptions, Plan, Solving, StorageKind, TraceOptions, Work,
};

use crate::scenes::{Quad, cut, flipped, grey, lit_quads, mesh, quads, room, sky, square};

fn forecast(tracer: &Tracer, size: PatchSize, trace: &TraceOptions, solving: Solving) -> Forecast {
    let work = Work {
        tessellation: &Tessellation { size, ..Default::default() },
        trace,
        light: &LightOptions::default(),
        solving,
        memory: 4 << 30,
        tolerance: 1e-6,
        order: 1000,
        pixels: 0,
    };
    Forecast::new(tracer, &work).unwrap()
}

fn stage(forecast: &Forecast, name: &str) -> Cost {
    forecast.stages.iter().find(|stage| stage.name == name).map_or(Cost::default(), |stage| stage.cost)
}

#[test]
fn patches_and_bytes_come_out_about_as_predicted() {
    // To a tenth where nothing stands in the way, else to a third; where many small things hide each other,
    // what is foretold is up to half too much.
    let (open, furnished, crowded) = (0.1, 1.0 / 3.0, 0.55);
    for (name, basis, within) in [
        ("cornell_box", Basis::Constant, furnished),
        ("facing_plates", Basis::Constant, open),
        ("furnace_sphere", Basis::Constant, open),
        ("furnished_room", Basis::Constant, crowded),
        ("two_rooms", Basis::Constant, furnished),
        ("cornell_box", Basis::Linear, furnished),
        ("furnace_sphere", Basis::Linear, open),
    ] {
        let scene = mesh(name);
        let tracer = Tracer::new(&scene);
        let size = PatchSize::Count(2000);
        let trace =
            TraceOptions { rays: Some(128), basis, storage: StorageKind::Sparse, ..Default::default() };
        let foretold = forecast(&tracer, size, &trace, Solving::Either);
        let mut patches = cut(&tracer, size);
        let factors = FormFactors::trace(&tracer, &mut patches, &trace).unwrap();
        let count = foretold.patches as f64 / patches.len() as f64;
        // Where things pass through each other, the number of patches grows in larger steps.
        let of_patches = if name == "furnished_room" { 0.15 } else { 0.1 };
        assert!(
            (count - 1.0).abs() < of_patches,
            "{name}: {} patches of {}",
            foretold.patches,
            patches.len()
        );
        let bytes = stage(&foretold, "balance").bytes as f64 / factors.exchange().bytes() as f64;
        assert!((bytes - 1.0).abs() < within, "{name} {basis:?}: {bytes} of the bytes");
    }
}

#[test]
fn a_given_edge_and_a_given_solver_have_their_costs() {
    let scene = mesh("furnace_cube");
    let tracer = Tracer::new(&scene);
    let size = PatchSize::Edge(0.1);
    let patches = cut(&tracer, size);
    let trace = TraceOptions { rays: Some(100), ..Default::default() };
    let factored = forecast(&tracer, size, &trace, Solving::Factored);
    assert_eq!((factored.patches, factored.rays), (patches.len(), 104));
    assert_eq!(stage(&factored, "factor").bytes, 8 * (patches.len() as u64).pow(2));
    // Everything emits: nothing is a lamp, and all rays are those of rows.
    assert_eq!(stage(&factored, "trace").rays, 104 * patches.len() as u64);
    let iterated = forecast(&tracer, size, &trace, Solving::Iterated);
    assert_eq!(stage(&iterated, "factor"), Cost::default());
    assert!(iterated.total().bytes < factored.total().bytes);
}

#[test]
fn what_is_not_called_for_costs_nothing() {
    let scene = mesh("cornell_box");
    let trace = TraceOptions::default();
    let foretold = forecast(&Tracer::new(&scene), PatchSize::Count(1000), &trace, Solving::Either);
    let plan = Plan::new(&scene).foretold(&foretold);
    let of = |name: &str| plan.effects.iter().find(|effect| effect.effect == name).unwrap();
    for name in ["mirror", "dielectric", "caustics", "lights", "sky", "receivers", "gloss", "textures"] {
        assert_eq!((of(name).on, of(name).cost), (false, Cost::default()), "{name}");
    }
    assert_eq!(of("interreflection").cost.rays, 512 * foretold.patches as u64);
    assert_eq!(of("lamps").cost.rays, 256 * foretold.patches as u64);
    assert!(of("colour").on && of("interreflection").cost.seconds > of("colour").cost.seconds);
    let lit = mesh("daylit_room");
    let foretold = forecast(&Tracer::new(&lit), PatchSize::Count(1000), &trace, Solving::Either);
    let plan = Plan::new(&lit).foretold(&foretold);
    let sky = plan.effects.iter().find(|effect| effect.effect == "sky").unwrap();
    assert_eq!(sky.cost.rays, 512 * foretold.patches as u64);
    assert_eq!(stage(&foretold, "light").rays, sky.cost.rays + 128 * foretold.patches as u64);
}

#[test]
fn a_sky_seen_through_a_small_hole_costs_more() {
    // A box of four by four by four with a hole in its top, and as many faces in the open.
    let strip = |a: [f64; 2], b: [f64; 2]| {
        flipped([[a[0], 2.0, a[1]], [a[0], 2.0, b[1]], [b[0], 2.0, b[1]], [b[0], 2.0, a[1]]])
    };
    let lid = [
        strip([-2.0, -2.0], [2.0, -0.2]),
        strip([-2.0, 0.2], [2.0, 2.0]),
        strip([-2.0, -0.2], [-0.2, 0.2]),
        strip([0.2, -0.2], [2.0, 0.2]),
    ];
    let mut walls = room([-2.0; 3], [2.0; 3]).to_vec();
    walls.remove(4);
    let ground = (0..9).map(|k| square(0.0, 1.0).map(|[x, y, z]| [x + 2.0 * f64::from(k), y, z]));
    let per_patch = |of: &[Quad]| {
        let all: Vec<(Quad, u32)> = of.iter().map(|&quad| (quad, 0)).collect();
        let scene = lit_quads(&all, grey(0.5), Vec::new(), Some(sky(SkyKind::Constant, 1.0)));
        let tracer = Tracer::new(&scene);
        let foretold = forecast(&tracer, PatchSize::Count(1000), &TraceOptions::default(), Solving::Either);
        ["light", "patch"].map(|name| stage(&foretold, name).seconds / foretold.patches as f64)
    };
    let [open, small] = [ground.collect(), [&walls[..], &lid[..]].concat()].map(|of| per_patch(&of));
    // Rays from inside are drawn towards the hole and weighed by it, and dark corners take longer to be found
    // dark than what lies open to be found lit.
    assert!(small[0] > 1.3 * open[0] && small[1] > 1.1 * open[1], "{open:?} {small:?}");
}

#[test]
fn the_inside_of_a_box_with_a_loose_lid_is_not_expected_to_be_lit() {
    // The lid stands out, so that no edge of it is one of the box: shape alone does not tell that it closes.
    let walls = room([-1.0; 3], [1.0; 3]);
    let mut all: Vec<(Quad, u32)> = walls.into_iter().map(|quad| (flipped(quad), 0)).collect();
    all[4] = (square(1.0, 1.2), 0);
    all.push((square(-1.5, 3.0), 0));
    let scene = lit_quads(&all, grey(0.5), Vec::new(), Some(sky(SkyKind::Constant, 1.0)));
    let tracer = Tracer::new(&scene);
    let size = PatchSize::Edge(0.2);
    let foretold = forecast(&tracer, size, &TraceOptions::default(), Solving::Either);
    let ratio = foretold.patches as f64 / cut(&tracer, size).len() as f64;
    assert!((ratio - 1.0).abs() < 0.15, "{} patches: {ratio}", foretold.patches);
}

#[test]
fn only_sheets_are_expected_to_have_backs_that_light_reaches() {
    let backs = |quads: Scene| {
        let trace = TraceOptions::default();
        let foretold = forecast(&Tracer::new(&quads), PatchSize::Count(500), &trace, Solving::Either);
        let plan = Plan::new(&quads).foretold(&foretold);
        plan.effects.into_iter().find(|effect| effect.effect == "back sides").unwrap().on
    };
    let glowing = || vec![Material::lamp("wall", &[0.5], &[1.0])];
    let closed = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    assert!(!backs(quads(&closed, glowing())));
    let sheet = ([[0.2, 0.2, 0.5], [0.8, 0.2, 0.5], [0.8, 0.8, 0.5], [0.2, 0.8, 0.5]], 0);
    assert!(backs(quads(&[&closed[..], &[sheet]].concat(), glowing())));
}
