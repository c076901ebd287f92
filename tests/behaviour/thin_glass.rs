//! Sheets of thin glass: both surfaces at once, and the light of lamps, sun and sky that comes straight
//! through.

use glam::DVec3;
use radiosity::measure::Energy;
use radiosity::patches::{Basis, PatchSize};
use radiosity::progress::Progress;
use radiosity::reference::PathTracer;
use radiosity::render::{self, RenderOptions, Shading};
use radiosity::scene::{Camera, Light, Material, Scene, Sky, SkyKind, Surface};
use radiosity::solve::{self, Problem, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, Plan, Sources, TraceOptions, Transport};

use crate::finishes::simulated;
use crate::scenes::{BASES, cut, flipped, lit_quads, paths, point, quads, room, square};
use crate::scratch::Scratch;

#[test]
fn a_sheet_passes_and_reflects_what_both_surfaces_of_a_slab_do() {
    let between = |glass: Vec<([[f64; 3]; 4], u32)>, material: Material| {
        let plates = [(square(0.0, 0.5), 0), (flipped(square(1.0, 0.5)), 2)];
        let lamp = Material::lamp("below", &[0.5], &[1.0]);
        let scene = quads(&[&plates[..], &glass].concat(), vec![lamp.clone(), material, lamp]);
        let tracer = Tracer::new(&scene);
        let mut patches = cut(&tracer, PatchSize::Edge(0.3));
        let options =
            TraceOptions { rays: Some(4096), lamp_rays: Some(0), keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let below = |i: usize| usize::from(scene.faces()[patches.place(i).face].material == 0);
        let groups: Vec<usize> = (0..patches.len()).map(below).collect();
        let found = factors.between_groups(&patches, &groups, Progress::default()).unwrap();
        let of = |to| {
            let f = found.iter().find(|f| f.from == 1 && f.to == Some(to)).unwrap();
            [f.form_factor, f.standard_error]
        };
        [of(0), of(1)]
    };
    // Of clear glass: what is absorbed, a sheet absorbs between its surfaces and a slab at them.
    let sheet = between(vec![(square(0.5, 0.9), 1)], Material::pane("pane", 1.5, &[1.0]));
    let slab = room([-0.9, 0.4999, -0.9], [0.9, 0.5001, 0.9]).map(|quad| (flipped(quad), 1));
    let slab = between(slab.to_vec(), Material::dielectric("slab", 1.5, &[1.0]));
    for (thin, thick) in sheet.into_iter().zip(slab) {
        let error = thin[1].hypot(thick[1]);
        assert!((thin[0] - thick[0]).abs() < 4.0 * error, "{thin:?} {thick:?}");
        assert!(error < 0.03 * thin[0], "{thin:?} {thick:?}");
    }
}

#[test]
fn a_furnace_stays_a_furnace_around_a_clear_sheet() {
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let sheet = [[0.2, 0.2, 0.3], [0.2, 0.9, 0.3], [0.8, 0.9, 0.6], [0.8, 0.2, 0.6]];
    let materials = vec![Material::lamp("wall", &[0.5], &[1.0]), Material::pane("pane", 1.5, &[1.0])];
    let scene = quads(&[&walls[..], &[(sheet, 1)]].concat(), materials);
    assert_eq!(scene.warnings(), [""; 0]);
    let tracer = Tracer::new(&scene);
    for basis in BASES {
        let mut patches = cut(&tracer, PatchSize::Count(200));
        let options = TraceOptions { rays: Some(128), basis, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let k = Transport::of(&factors, &patches).unwrap();
        let e = basis.coefficients_of(&patches.emitted_radiance());
        let solution = solve::solve(&k, &e, &SolveOptions::default()).unwrap();
        let energy = Energy::new(&k, &e, &solution.radiance);
        assert_eq!([energy.carriers[0], energy.escaped[0], energy.lost[0]], [0.0; 3], "{energy:?}");
        assert!(solution.radiance.iter().all(|l| (l - 2.0).abs() < 1e-5));
    }
}

#[test]
fn lights_shine_through_a_sheet_dimmed_as_it_passes_light() {
    // Straight down: R = 0.04 once, (1 − R)/(1 + R) through.
    let (once, colour) = (0.04, [0.9, 0.5, 1.0]);
    let lights = vec![
        point([0.0, 20.0, 0.0], &[800.0; 3]),
        Light::Sun { direction: -DVec3::Y, irradiance: vec![3.0; 3], diameter: 0.0 },
    ];
    let irradiance = |material: Material| {
        let faces = [(square(0.0, 0.1), 0), (square(0.5, 1.0), 1)];
        let materials = vec![Material::diffuse("floor", &[0.5; 3]), material];
        let scene = lit_quads(&faces, materials, lights.clone(), None);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, PatchSize::Edge(1.0));
        let sources = Sources::trace(&tracer, &patches, Basis::Constant, &LightOptions::default()).unwrap();
        let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(100)).unwrap();
        let direct = sources.direct.unwrap();
        [0, 1, 2].map(|c| {
            [
                direct.column(c).mean(),
                (0..traced.len()).map(|i| traced.irradiance(i, c).mean).sum::<f64>() / 2.0,
            ]
        })
    };
    for (found, part) in irradiance(Material::pane("pane", 1.5, &colour)).into_iter().zip(colour) {
        for found in found {
            let exact = (3.0 + 800.0 / 400.0) * part * (1.0 - once) / (1.0 + once);
            assert!((found / exact - 1.0).abs() < 1e-3, "{found} {exact}");
        }
    }
}

#[test]
fn a_room_behind_a_glazed_window_agrees_with_light_paths() {
    let mut walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0)).to_vec();
    // The wall at z = 1 is a window.
    walls[5].1 = 1;
    let materials = vec![Material::diffuse("wall", &[0.6]), Material::pane("pane", 1.5, &[0.8])];
    let sun = Light::Sun {
        direction: DVec3::new(0.3, -0.5, -0.8).normalize(),
        irradiance: vec![5.0],
        diameter: 0.5,
    };
    let sky = Sky { kind: SkyKind::Constant, zenith: vec![1.0], ground: 0.0, up: DVec3::Y };
    let scene = lit_quads(&walls, materials, vec![sun], Some(sky));
    assert_eq!(scene.warnings(), [""; 0]);
    let plan = Plan::new(&scene);
    let on = simulated(&plan);
    assert!(on.contains(&"thin glass") && on.contains(&"lights"), "{on:?}");
    let tracer = Tracer::new(&scene);
    for basis in BASES {
        let mut patches = cut(&tracer, PatchSize::Count(800));
        let options = TraceOptions { basis, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
        let solution = problem.solve(&SolveOptions::default()).unwrap();
        let energy = Energy::of(&problem, &solution.radiance);
        assert!(energy.imbalance < 1e-5 && energy.carriers[0] > 0.0, "{energy:?}");
        let irradiance = solution.means().irradiance;
        let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(200_000)).unwrap();
        let sum = |f: &dyn Fn(usize) -> f64| (0..traced.len()).map(f).sum::<f64>();
        let known = |i: usize| traced.irradiance(i, 0);
        let whole = sum(&|i| traced.area(i) * known(i).mean);
        let off = sum(&|i| traced.area(i) * (irradiance[(i, 0)] - known(i).mean)) / whole;
        let error = sum(&|i| (traced.area(i) * known(i).standard_error).powi(2)).sqrt() / whole;
        assert!(off.abs() < 0.002 + 3.0 * error, "{basis:?}: {off} {error}");
    }
}

#[test]
fn every_shading_shows_the_sky_behind_a_sheet() {
    let materials = vec![Material::pane("pane", 1.5, &[0.5]), Material::diffuse("floor", &[0.5])];
    let pane = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let sky = Sky { kind: SkyKind::Constant, zenith: vec![2.0], ground: 0.0, up: DVec3::Y };
    let scene = lit_quads(&[(pane, 0), (square(-3.0, 0.5), 1)], materials, Vec::new(), Some(sky));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.5));
    let camera = Camera { position: DVec3::Z * 2.0, target: DVec3::ZERO, up: DVec3::Y, fov: 10.0 };
    // Seen through it the sky is dimmed; what it reflects of the sky before it comes on top.
    let (once, filter) = (0.04, 0.5);
    let through = filter * (1.0 - once) * (1.0 - once) / (1.0 - (filter * once) * (filter * once));
    let back = once + filter * once * through;
    let exact = 2.0 * (through + back);
    for (shading, samples) in
        [(Shading::Flat, 1), (Shading::Smooth, 1), (Shading::Gather, 1024), (Shading::Path, 1024)]
    {
        let options = RenderOptions { width: 4, height: 4, shading, samples, ..Default::default() };
        let picture =
            render::picture(&tracer, &patches, &patches.emitted_radiance(), &camera, &options).unwrap();
        let mean = picture.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / 16.0;
        assert!((mean / exact - 1.0).abs() < 0.005, "{shading:?}: {mean} {exact}");
    }
}

#[test]
fn glass_is_thin_where_the_settings_say_so() {
    let read = |settings: &str, mtl: &str| {
        let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
        let scratch = Scratch::with(&[("a.obj", obj), ("a.mtl", mtl), ("a.toml", settings)]);
        Scene::load(scratch.path("a.obj"))
    };
    let glass = "newmtl m\nillum 4\nNi 1.5\nTf 0.8\n";
    let scene = read("[material.m]\nthin = true\n", glass).unwrap();
    let Surface::Pane { index, filter } = &scene.materials()[0].surface else { panic!() };
    assert!(*index == 1.5 && (filter[0] - 0.64).abs() < 1e-15);
    assert_eq!(scene.warnings(), [""; 0]);
    let open = read("", glass).unwrap().warnings().join("\n");
    assert!(open.contains("thin = true") && open.contains("material.m"), "{open}");
    let wrong = read("[material.m]\nthin = true\n", "newmtl m\nKd 0.5\n").unwrap_err().to_string();
    assert!(wrong.contains("a.toml:2") && wrong.contains("only glass is thin"), "{wrong}");
}
