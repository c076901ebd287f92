//! Plastic, a diffuse base under a clear coat: furnaces, closed forms, the path tracer's own route, pictures,
//! files.

use std::f64::consts::PI;
use std::io::Cursor;

use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::reference::PathTracer;
use radiosity::scene::{Light, Material, Scene, SceneError, Sky, SkyKind, Surface};
use radiosity::solve::{self, SolveOptions};
use radiosity::trace::{Tracer, fresnel};
use radiosity::transport::{
    FactorsFileError, Forecast, FormFactors, Keep, LightOptions, Plan, Solving, Sources, StorageKind,
    Switches, TraceOptions, Transport, TransportError, Work,
};

use crate::finishes::{
    Look, at_the_highlight, balanced, difference_in_a_room, furnace_with, in_the_furnace, lamp_over,
    light_paths_from_two, simulated,
};
use crate::scenes::{BASES, cut, lit_quads, paths, quads, room};
use crate::scratch::Scratch;

/// Coats by roughness and index.
const COATS: [(f64, f64); 3] = [(0.0, 1.5), (0.4, 1.5), (1.0, 2.0)];

/// 1 − Ē of a smooth coat, by the midpoint rule over μ².
fn passed_of_all(index: f64) -> f64 {
    let n = 200_000;
    let at = |k: i32| 1.0 - fresnel(((f64::from(k) + 0.5) / f64::from(n)).sqrt(), index);
    (0..n).map(at).sum::<f64>() / f64::from(n)
}

#[test]
fn a_furnace_stays_a_furnace_around_white_plastic_of_any_roughness() {
    for coat in COATS {
        let scene = furnace_with(Material::plastic("plastic", coat, &[1.0]));
        assert_eq!(scene.warnings(), [""; 0]);
        let tracer = Tracer::new(&scene);
        for basis in BASES {
            let mut patches = cut(&tracer, PatchSize::Count(300));
            let options = TraceOptions { rays: Some(256), basis, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let exchange = factors.exchange();
            assert_eq!(exchange.reciprocity_error(), 0.0);
            assert!(exchange.closure_error() < 1e-9, "{}", exchange.closure_error());
            let (solution, energy) = balanced(&patches, &factors);
            assert_eq!([energy.carriers[0], energy.escaped[0], energy.lost[0]], [0.0; 3], "{energy:?}");
            let off = solution.radiance.map(|l| (l - 2.0).abs()).max();
            assert!(off < 1e-9, "{coat:?} {basis:?}: {off}");
            // The light is even, and counts under a coat as it does beside it.
            let off = solution.irradiance.map(|h| (h - 2.0 * PI).abs()).max();
            assert!(off < 1e-8, "{coat:?} {basis:?}: {off}");
        }
        // And by the path tracer's own route, which looks at lamps from the coat and from under it.
        let z = light_paths_from_two(&tracer, 100_000);
        assert!(z.abs() < 4.0, "{coat:?}: {z}");
    }
}

#[test]
fn a_coat_lets_a_patch_exchange_as_much_less_as_it_keeps_of_even_light() {
    let scene = furnace_with(Material::plastic("plastic", (0.0, 1.5), &[0.5]));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(100));
    for (i, (area, etendue)) in patches.areas().iter().zip(patches.etendues()).enumerate() {
        let is_plastic = scene.material_of(patches.place(i).face).name == "plastic";
        let expected = if is_plastic { passed_of_all(1.5) } else { 1.0 };
        assert!((etendue / area - expected).abs() < 2e-4, "{i}: {etendue} of {area}");
    }
}

/// A small sheet that looks up, and a small lamp far from it whose light arrives at this angle.
fn sheet_and_lamp(angle: f64, material: Material) -> Scene {
    let sheet = [[-0.01, 0.0, -0.01], [-0.01, 0.0, 0.01], [0.01, 0.0, 0.01], [0.01, 0.0, -0.01]];
    let (sine, cosine) = angle.sin_cos();
    // The lamp faces the sheet.
    let corner = |s: f64, t: f64| {
        let [along, across] = [0.05 * s, 0.05 * t];
        [sine + along * cosine, cosine - along * sine, across]
    };
    let lamp = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    // Black ground, so that the lamp is small beside all else.
    let ground = [[-1.0, -0.5, -1.0], [-1.0, -0.5, 1.0], [1.0, -0.5, 1.0], [1.0, -0.5, -1.0]];
    let materials =
        vec![material, Material::lamp("lamp", &[0.0], &[100.0]), Material::diffuse("ground", &[0.0])];
    quads(&[(sheet, 0), (lamp, 1), (ground, 2)], materials)
}

/// The patches of the sheet's front.
fn sheet_of(patches: &Patches) -> Vec<usize> {
    let is_lit = |&i: &usize| patches.place(i).face < 2 && patches.place(i).side.name() == "front";
    let sheet: Vec<usize> = (0..patches.len()).filter(is_lit).collect();
    assert_eq!(sheet.len(), 2);
    sheet
}

#[test]
fn light_from_a_lamp_gets_under_a_smooth_coat_by_fresnels_formulas() {
    for angle in [0.1f64, 0.9, 1.3] {
        let passed = (1.0 - fresnel(angle.cos(), 1.5)) / passed_of_all(1.5);
        let coated = sheet_and_lamp(angle, Material::plastic("sheet", (0.0, 1.5), &[0.7]));
        // By form factors: beside a bare sheet, whose lamp is closed by the same rays.
        let bare = sheet_and_lamp(angle, Material::diffuse("sheet", &[0.7]));
        for basis in BASES {
            let [under, beside] = [&coated, &bare].map(|scene| {
                let tracer = Tracer::new(scene);
                let mut patches = cut(&tracer, PatchSize::Edge(0.5));
                let options =
                    TraceOptions { rays: Some(64), lamp_rays: Some(1024), basis, ..Default::default() };
                let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
                let k = Transport::of(&factors, &patches).unwrap();
                let e = basis.coefficients_of(&patches.emitted_radiance());
                let solution = solve::solve(&k, &e, &SolveOptions::default()).unwrap();
                let irradiance = solution.means().irradiance;
                sheet_of(&patches).iter().map(|&i| irradiance[(i, 0)]).sum::<f64>()
            });
            let off = under / beside / passed - 1.0;
            assert!(off.abs() < 0.005, "{angle} {basis:?}: {off}");
        }
        // By direct light alone, and by light paths.
        let exact = 100.0 * 0.01 * angle.cos() * passed;
        let tracer = Tracer::new(&coated);
        let patches = cut(&tracer, PatchSize::Edge(0.5));
        let (basis, light) = (Basis::Constant, LightOptions::default());
        let lights = Sources::trace(&tracer, &patches, basis, &light).unwrap();
        let direct = lights.with_lamps(&tracer, &patches, basis, &light).unwrap().direct.unwrap();
        let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(100_000)).unwrap();
        // The mean of two triangles, each of which lies to one side of the middle.
        let [a, b] = [0, 1].map(|k| sheet_of(&patches)[k]);
        let found = 0.5 * (direct[(a, 0)] + direct[(b, 0)]);
        assert!((found / exact - 1.0).abs() < 0.01, "{angle}: {found} {exact}");
        let [a, b] = [a, b].map(|i| traced.irradiance(i, 0));
        let off = (0.5 * (a.mean + b.mean) - exact).abs();
        let error = 0.5 * a.standard_error.hypot(b.standard_error);
        assert!(off < 0.01 * exact + 4.0 * error, "{angle}: {a:?} {b:?} {exact}");
    }
}

#[test]
fn lights_and_skies_get_under_a_coat_as_it_lets_them() {
    let sheet = [[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]];
    let up = [0.0, 1.0, 0.0].into();
    let of = |light: Option<Light>, sky: Option<Sky>| {
        let plastic = Material::plastic("plastic", (0.0, 1.5), &[0.7]);
        let scene = lit_quads(&[(sheet, 0)], vec![plastic], light.into_iter().collect(), sky);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, PatchSize::Edge(0.5));
        let sources = Sources::trace(&tracer, &patches, Basis::Constant, &LightOptions::default()).unwrap();
        let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(40_000)).unwrap();
        let front = (0..patches.len()).find(|&i| patches.place(i).side.name() == "front").unwrap();
        (sources.direct.unwrap()[(front, 0)], traced.irradiance(front, 0))
    };
    let slanted = [0.9, -(1.0f64 - 0.81).sqrt(), 0.0];
    let cosine = -slanted[1];
    let sun = Light::Sun { direction: slanted.into(), irradiance: vec![3.0], diameter: 0.0 };
    let under = 3.0 * cosine * (1.0 - fresnel(cosine, 1.5)) / passed_of_all(1.5);
    // Even light counts in full.
    let sky = Sky { kind: SkyKind::Constant, up, zenith: vec![2.0], ground: 0.0 };
    for (found, exact, rough) in [(of(Some(sun), None), under, 1e-3), (of(None, Some(sky)), 2.0 * PI, 5e-3)] {
        assert!((found.0 / exact - 1.0).abs() < rough, "{} {exact}", found.0);
        let off = (found.1.mean - exact).abs();
        assert!(off < 1e-3 * exact + 4.0 * found.1.standard_error, "{:?} {exact}", found.1);
    }
}

#[test]
fn the_matrix_agrees_with_light_paths_in_a_room_of_plastic() {
    for coat in COATS {
        let difference = difference_in_a_room(Material::plastic("plastic", coat, &[0.7]), true);
        assert!(difference.bias.abs() < 0.003 + 3.0 * difference.bias_error, "{difference:?}");
        assert!(difference.rms < 0.02 + 2.0 * difference.uncertainty, "{difference:?}");
    }
}

#[test]
fn without_their_coats_plastics_are_diffuse() {
    let scene = furnace_with(Material::plastic("plastic", (0.2, 1.5), &[0.3]));
    let (without, _, told) = "-plastic".parse::<Switches>().unwrap().apply(scene);
    assert!(told.len() == 1 && !Tracer::new(&without).has_carriers(), "{told:?}");
    let bare = furnace_with(Material::diffuse("plastic", &[0.3]));
    let irradiance = |scene: &Scene| {
        let tracer = Tracer::new(scene);
        let mut patches = cut(&tracer, PatchSize::Count(100));
        let options = TraceOptions { rays: Some(64), ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let k = Transport::of(&factors, &patches).unwrap();
        solve::solve(&k, &patches.emitted_radiance(), &SolveOptions::default()).unwrap().irradiance
    };
    assert_eq!(irradiance(&without), irradiance(&bare));
}

#[test]
fn every_shading_shows_a_furnace_in_white_plastic_as_bright_as_the_furnace() {
    let scene = furnace_with(Material::plastic("plastic", (0.5, 1.5), &[1.0]));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.5));
    let radiance = patches.emitted_radiance().map(|_| 2.0);
    let camera = in_the_furnace();
    Look { tracer: &tracer, patches: &patches, radiance: &radiance, camera }.is_of(2.0);
}

#[test]
fn a_lamp_shines_on_plastic_as_bright_in_every_shading() {
    // A small lamp over a sheet of plastic, seen by its highlight beside what comes from under the coat.
    for reflectance in [0.0, 0.5] {
        let scene = lamp_over(Material::plastic("plastic", (0.4, 1.6), &[reflectance]));
        let tracer = Tracer::new(&scene);
        let mut patches = cut(&tracer, PatchSize::Edge(0.1));
        let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap();
        let k = Transport::of(&factors, &patches).unwrap();
        let solution = solve::solve(&k, &patches.emitted_radiance(), &SolveOptions::default()).unwrap();
        let (radiance, camera) = (&solution.radiance, at_the_highlight());
        Look { tracer: &tracer, patches: &patches, radiance, camera }.is_as_light_paths_show_it(0.03);
    }
}

#[test]
fn saved_form_factors_know_the_coat_and_not_what_lies_under_it() {
    let scene =
        |roughness, index, base| furnace_with(Material::plastic("plastic", (roughness, index), &[base]));
    let first = scene(0.5, 1.5, 0.8);
    let tracer = Tracer::new(&first);
    for basis in BASES {
        let mut patches = cut(&tracer, PatchSize::Count(100));
        let options = TraceOptions { rays: Some(8), keep: Keep::Rays, basis, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let mut file = Vec::new();
        factors.save(&patches, &mut file).unwrap();
        let read = |scene: &Scene| {
            let (mut file, options) = (Cursor::new(&file), Tessellation::default());
            FormFactors::load(&mut file, &Tracer::new(scene), &options, StorageKind::Auto, Keep::Nothing)
                .map(|(_, factors, reuse)| (factors.exchange().areas(), reuse.balanced))
        };
        assert_eq!(read(&scene(0.5, 1.5, 0.3)), Ok((factors.exchange().areas(), true)));
        for other in [scene(0.4, 1.5, 0.8), scene(0.5, 1.6, 0.8)] {
            assert_eq!(read(&other).unwrap_err(), TransportError::File(FactorsFileError::OtherScene));
        }
    }
}

#[test]
fn an_empty_room_with_a_coat_takes_rays() {
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let of = |material| Tracer::new(&quads(&walls, vec![material])).enclosure().is_ok();
    assert!(of(Material::diffuse("wall", &[0.5])) && !of(Material::plastic("wall", (0.0, 1.5), &[0.5])));
}

#[test]
fn the_plan_simulates_plastic() {
    let plan = Plan::new(&furnace_with(Material::plastic("bakelite", (0.5, 1.5), &[0.8])));
    assert_eq!(
        simulated(&plan),
        ["interreflection", "occlusion rays", "back sides", "lamps", "caustics", "plastic"]
    );
    assert!(plan.effects.iter().any(|e| e.effect == "plastic" && e.reason == "bakelite"));
    let scene = furnace_with(Material::plastic("bakelite", (0.5, 1.5), &[0.8]));
    let work = Work {
        tessellation: &Tessellation::default(),
        trace: &TraceOptions::default(),
        light: &LightOptions::default(),
        solving: Solving::Either,
        memory: 1 << 30,
        tolerance: 1e-6,
        order: 100,
        pixels: 0,
    };
    let plan = plan.foretold(&Forecast::new(&Tracer::new(&scene), &work).unwrap());
    assert!(plan.effects.iter().all(|e| (e.effect == "plastic") <= (e.cost.rays > 0)));
}

/// The material of a scene file with these lines in its MTL and TOML files.
fn material(mtl: &str, toml: &str) -> Result<(Material, Vec<String>), SceneError> {
    let mtl = format!("newmtl m\n{mtl}\n");
    let scratch = Scratch::with(&[
        ("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"),
        ("a.mtl", mtl.as_str()),
        ("a.toml", toml),
    ]);
    let scene = Scene::load(scratch.path("a.obj"))?;
    Ok((scene.material_of(0).clone(), scene.warnings().to_vec()))
}

#[test]
fn files_say_how_rough_and_dense_a_coat_is() {
    let coat = |mtl: &str, toml: &str| match material(mtl, toml).unwrap().0.surface {
        Surface::Plastic { index, roughness } => [index, roughness],
        other => panic!("{other:?}"),
    };
    assert_eq!(coat("Kd 0.5\nPr 0.2\nNi 1.4", ""), [1.4, 0.2]);
    assert_eq!(coat("Kd 0.5\nillum 5", ""), [1.5, 0.3]);
    assert_eq!(coat("Kd 0.5\nillum 5\nNs 0", ""), [1.5, 1.0]);
    assert_eq!(coat("Kd 0.5\nPr 0.2", "[material.m]\nroughness = 0.7\n"), [1.5, 0.7]);
    // A base without Kd is grey as any surface, and what glows is a bare lamp; either is said.
    let (grey, warnings) = material("Pr 0.2", "").unwrap();
    assert!(grey.reflectance == [0.5] && warnings.len() == 1, "{grey:?} {warnings:?}");
    let (lamp, warnings) = material("Kd 0.5\nPr 0.2\nKe 3", "").unwrap();
    assert!(lamp.surface == Surface::Diffuse && lamp.emits() && warnings.len() == 1, "{lamp:?} {warnings:?}");
    let refused = |mtl: &str, toml: &str| material(mtl, toml).unwrap_err().to_string();
    assert!(refused("Kd 0.5\nPr 0.2\nNi 0.9", "").contains("between 1 and 10"));
    assert!(refused("Kd 0.5\nPr 0.2", "[material.m]\nemission = 3\n").contains("emits nothing"));
    assert!(refused("Kd 0.5\nPr 0.2", "[material.m]\nroughness = 3\n").contains("roughness 3"));
}
