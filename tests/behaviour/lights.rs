//! Lights without area and skies: closed forms, the path tracer, energy, and what their settings mean.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::measure::{Energy, RelativeRms};
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::reference::{Budget, PathOptions, PathTracer};
use radiosity::scene::{Light, Material, Scene, SceneError, Side, Sky, SkyKind};
use radiosity::solve::{self, CgOptions, DirectOptions, NeumannOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, Sources, TraceOptions};

use crate::scenes::{BASES, cut, lit_quads, room, sky, sun};
use crate::scratch::Scratch;

/// A square of this half-width on the ground, facing up.
fn ground(half: f64) -> [[f64; 3]; 4] {
    [[-half, 0.0, -half], [-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half]]
}

fn grey(reflectance: f64) -> Vec<Material> {
    vec![Material::diffuse("grey", &[reflectance])]
}

fn point(position: [f64; 3], intensity: f64) -> Light {
    Light::Point { position: position.into(), intensity: vec![intensity] }
}

/// H₀ of every patch of a scene, by means over patches.
fn direct_light(tracer: &Tracer, patches: &Patches, basis: Basis, rays: u32) -> DMatrix<f64> {
    let sources =
        Sources::trace(tracer, patches, basis, &LightOptions { rays, ..Default::default() }).unwrap();
    basis.means(&sources.direct.unwrap())
}

/// A room with a hole in its front wall (z = 0), 1 m wide from x = 1 and 1 m high from y = 1; 3 m each way.
fn room_with_window() -> Vec<([[f64; 3]; 4], u32)> {
    let [left, bottom, front, right, top, back] = room([0.0; 3], [3.0; 3]);
    let strip = |x: [f64; 2], y: [f64; 2]| {
        [[x[0], y[0], 0.0], [x[1], y[0], 0.0], [x[1], y[1], 0.0], [x[0], y[1], 0.0]]
    };
    assert_eq!(front[2][2], 0.0);
    let around = [
        strip([0.0, 3.0], [0.0, 1.0]),
        strip([0.0, 3.0], [2.0, 3.0]),
        strip([0.0, 1.0], [1.0, 2.0]),
        strip([2.0, 3.0], [1.0, 2.0]),
    ];
    [left, bottom, right, top, back].into_iter().chain(around).map(|quad| (quad, 0)).collect()
}

#[test]
fn a_point_light_over_a_plane_obeys_the_inverse_square_and_cosine_laws() {
    let light = DVec3::new(0.3, 1.2, -0.4);
    let scene = lit_quads(&[(ground(1.0), 0)], grey(0.5), vec![point(light.to_array(), 20.0)], None);
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.02));
    assert!(patches.len() > 9000);
    for basis in BASES {
        let found = direct_light(&tracer, &patches, basis, 64);
        for i in 0..patches.len() {
            let between = light - patches.centre(i);
            let exact = 20.0 * between.y / between.length().powi(3);
            assert!((found[i] / exact - 1.0).abs() < 1e-4, "{basis:?} {i}: {} {exact}", found[i]);
        }
    }
}

#[test]
fn unhidden_point_lights_are_exact_over_patches_of_any_size() {
    let light = DVec3::new(0.3, 0.2, -0.4);
    let scene = lit_quads(&[(ground(1.0), 0)], grey(0.5), vec![point(light.to_array(), 1.0)], None);
    let tracer = Tracer::new(&scene);
    let whole = |edge: f64, rays: u32| {
        let patches = cut(&tracer, PatchSize::Edge(edge));
        let h = direct_light(&tracer, &patches, Basis::Constant, rays);
        (0..patches.len()).map(|i| patches.area(i) * h[i]).sum::<f64>()
    };
    // The flux that a square of half-width a catches at the side of its axis: four corners' solid angles.
    let corner = |x: f64, z: f64| (x * z / (light.y * (x * x + z * z + light.y * light.y).sqrt())).atan();
    let [x, z] = [light.x, light.z];
    let exact: f64 = [(1.0 - x, 1.0 - z), (1.0 - x, 1.0 + z), (1.0 + x, 1.0 - z), (1.0 + x, 1.0 + z)]
        .map(|(x, z)| corner(x, z))
        .iter()
        .sum();
    for (edge, rays) in [(2.0, 8), (0.5, 32), (0.1, 8)] {
        let off = whole(edge, rays) / exact - 1.0;
        assert!(off.abs() < 1e-12, "{edge}: {off}");
    }
}

#[test]
fn a_spot_lights_what_is_in_its_cone_as_a_point_does_and_nothing_else() {
    let position = DVec3::new(0.0, 1.0, 0.0);
    let spot =
        Light::Spot { position, direction: DVec3::NEG_Y, intensity: vec![3.0], cone: 30.0, penumbra: 10.0 };
    let scene = lit_quads(&[(ground(1.0), 0)], grey(0.0), vec![spot], None);
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.02));
    let found = direct_light(&tracer, &patches, Basis::Constant, 64);
    let [mut inside, mut edge] = [0; 2];
    for i in 0..patches.len() {
        let between = position - patches.centre(i);
        let angle = between.angle_between(DVec3::Y).to_degrees();
        let point = 3.0 * between.y / between.length().powi(3);
        if angle < 19.0 {
            inside += 1;
            assert!((found[i] / point - 1.0).abs() < 1e-4, "{i}: {}", found[i]);
        } else if (21.0..29.0).contains(&angle) {
            edge += 1;
            assert!(found[i] > 0.0 && found[i] < point);
        } else if angle > 31.0 {
            assert_eq!(found[i], 0.0);
        }
    }
    assert!(inside > 500 && edge > 500);
    // What the cone's end never reaches is no patch at all.
    let corner = patches.len() as f64 * 0.02 * 0.02 / 2.0;
    assert!(corner < 0.5 * 4.0, "{corner} m² of 4 m² are reached");
}

#[test]
fn the_sun_through_a_window_casts_its_patch_where_geometry_says() {
    let direction = DVec3::new(0.2, -1.0, 0.9);
    let scene = lit_quads(&room_with_window(), grey(0.5), vec![sun(direction.to_array(), 100.0, 0.0)], None);
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.05));
    let found = direct_light(&tracer, &patches, Basis::Constant, 64);
    let cosine = -direction.normalize().y;
    let [mut lit, mut dark] = [0; 2];
    for i in 0..patches.len() {
        let place = patches.place(i);
        let [p, q, r] = patches.corners(i).map(|corner| patches.point(place.face, corner));
        if patches.centre(i).y > 1e-9 || place.side == Side::Back {
            continue;
        }
        // Back along the ray to the plane of the window.
        let seen = [p, q, r].map(|p| p - direction * (p.z / direction.z));
        let within = |p: &DVec3| {
            let low = (p.x - 1.0).min(p.y - 1.0);
            low.min(2.0 - p.x).min(2.0 - p.y)
        };
        let margins = seen.iter().map(within);
        if margins.clone().fold(f64::INFINITY, f64::min) > 1e-9 {
            lit += 1;
            assert!((found[i] / (100.0 * cosine) - 1.0).abs() < 1e-12, "{i}: {}", found[i]);
        } else if seen.iter().all(|p| p.x < 1.0 - 1e-9)
            || seen.iter().all(|p| p.x > 2.0 + 1e-9)
            || seen.iter().all(|p| p.y < 1.0 - 1e-9)
            || seen.iter().all(|p| p.y > 2.0 + 1e-9)
        {
            dark += 1;
            assert_eq!(found[i], 0.0, "{i}");
        }
    }
    assert!(lit > 200 && dark > 500, "{lit} {dark}");
    // All the flux that comes through the window is found.
    let inside = (0..patches.len()).filter(|&i| patches.place(i).side == Side::Front);
    let flux: f64 = inside.map(|i| patches.area(i) * found[i]).sum();
    let through = 100.0 * direction.normalize().z;
    assert!((flux / through - 1.0).abs() < 2e-3, "{flux} {through}");
}

#[test]
fn open_ground_under_a_sky_has_its_closed_form() {
    for (kind, exact) in [
        // ∫ (1 + 2 cos θ)/3 cos θ dω over the hemisphere.
        (SkyKind::Overcast, 7.0 * PI / 9.0),
        (SkyKind::Constant, PI),
    ] {
        let scene = lit_quads(&[(ground(1.0), 0)], grey(0.5), vec![], Some(sky(kind.clone(), 100.0)));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, PatchSize::Count(200));
        for basis in BASES {
            let found = direct_light(&tracer, &patches, basis, 4096);
            let mean = (0..patches.len()).map(|i| patches.area(i) * found[i]).sum::<f64>()
                / (0..patches.len()).map(|i| patches.area(i)).sum::<f64>();
            // The back of the ground sees nothing of an overcast sky, and all of a constant one.
            assert!((mean / (100.0 * exact) - 1.0).abs() < 1e-3, "{kind:?} {basis:?}: {mean}");
            let worst = found.iter().map(|h| (h / (100.0 * exact) - 1.0).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-3, "{kind:?} {basis:?}: {worst}");
        }
    }
}

#[test]
fn a_clear_sky_sends_what_its_own_integral_says() {
    let towards = DVec3::new(0.6, 0.5, -0.3).normalize();
    let clear = sky(SkyKind::Clear { sun: towards }, 10.0);
    let exact = 10.0 * clear.horizontal();
    let scene = lit_quads(&[(ground(1.0), 0)], grey(0.5), vec![], Some(clear));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(200));
    let found = direct_light(&tracer, &patches, Basis::Constant, 4096);
    let worst = found.iter().map(|h| (h / exact - 1.0).abs()).fold(0.0, f64::max);
    assert!(worst < 3e-3, "{worst}");
}

/// A room with a window under every kind of light.
fn daylit_room() -> Scene {
    let towards = [0.2, 0.8, -0.9];
    let lights = vec![
        sun(towards.map(|x| -x), 30.0, 4.0),
        point([1.0, 2.0, 2.5], 2.0),
        Light::Spot {
            position: DVec3::new(2.5, 2.9, 2.0),
            direction: DVec3::new(-0.4, -1.0, 0.0).normalize(),
            intensity: vec![9.0],
            cone: 40.0,
            penumbra: 15.0,
        },
    ];
    let kind = SkyKind::Clear { sun: DVec3::from(towards).normalize() };
    lit_quads(&room_with_window(), grey(0.6), lights, Some(Sky { ground: 0.2, ..sky(kind, 5.0) }))
}

fn problem(scene: &Scene, count: usize, basis: Basis) -> (Tracer<'_>, Patches<'_>, Problem) {
    let tracer = Tracer::new(scene);
    let mut patches = cut(&tracer, PatchSize::Count(count));
    let options = TraceOptions { rays: Some(128), basis, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
    (tracer, patches, problem)
}

#[test]
fn radiance_is_emission_and_reflected_irradiance_under_lights_without_area_too() {
    let scene = daylit_room();
    for basis in BASES {
        let (_, _, problem) = problem(&scene, 400, basis);
        let cg = CgOptions { tolerance: 1e-11, ..Default::default() };
        let answers =
            [problem.direct(&DirectOptions::default()).unwrap(), problem.conjugate_gradients(&cg).unwrap()];
        let orders = (0..4).map(|order| {
            let options = NeumannOptions { order, tolerance: 0.0, ..Default::default() };
            problem.neumann(&options).unwrap().solution
        });
        for solution in answers.iter().cloned().chain(orders) {
            let composed = &problem.sources().emitted + problem.operator().reflect(&solution.irradiance);
            let off = (&composed - &solution.radiance).amax() / solution.radiance.amax();
            assert!(off < 1e-14, "{basis:?} {}: {off}", solution.report.name);
        }
        let energy = Energy::of(&problem, &answers[0].radiance);
        assert!(energy.imbalance < 1e-9 && energy.emitted[0] > 0.0, "{basis:?} {energy:?}");
        let order_0 = NeumannOptions { order: 0, tolerance: 0.0, ..Default::default() };
        let order_0 = problem.neumann(&order_0).unwrap().solution;
        assert_eq!(Some(order_0.irradiance), problem.sources().direct);
    }
}

#[test]
fn the_path_tracer_finds_the_same_light_by_its_own_samples() {
    let scene = daylit_room();
    let (tracer, patches, problem) = problem(&scene, 6000, Basis::Constant);
    let solution = problem.conjugate_gradients(&CgOptions::default()).unwrap();
    let faces = patches.average_by_face(&solution.irradiance);
    let budget = Budget { paths: Some(1_500_000), ..Default::default() };
    let options = PathOptions { budget, ..Default::default() };
    let traced = PathTracer::new(&tracer).irradiance(&patches, &options).unwrap();
    let rms = RelativeRms::of(&faces, &traced.by_face(&patches));
    assert!(rms.compared >= 18 && rms.value < 0.01, "{rms:?}");
    // And bounce by bounce: bounce 1 is what E sends.
    let k = problem.operator();
    for bounce in 1..=2 {
        let terms = solve::bounces(k, problem.right_hand_side(), bounce - 1);
        let h = k.irradiance(&terms[bounce - 1]);
        let whole =
            |of: &dyn Fn(usize) -> f64| (0..patches.len()).map(|i| patches.area(i) * of(i)).sum::<f64>();
        let by_paths = whole(&|i| traced.irradiance_by_bounce(bounce, i, 0).mean);
        let by_matrix = whole(&|i| h[i]);
        assert!((by_paths / by_matrix - 1.0).abs() < 0.01, "bounce {bounce}: {by_paths} {by_matrix}");
    }
}

#[test]
fn scenes_without_such_lights_have_no_direct_irradiance() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(300));
    let sources = Sources::trace(&tracer, &patches, Basis::Constant, &LightOptions::default()).unwrap();
    assert_eq!((sources.direct, sources.emitted), (None, patches.emitted_radiance()));
}

#[test]
fn the_same_seed_gives_the_same_light_on_any_number_of_threads() {
    let scene = daylit_room();
    let answer = |threads: usize| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(|| BASES.map(|basis| problem(&scene, 300, basis).2.sources().clone()))
    };
    assert!(answer(1) == answer(3));
}

/// A floor with these settings beside it.
fn floor_with(settings: &str) -> Result<Scene, SceneError> {
    let obj = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n";
    let folder = Scratch::with(&[("floor.obj", obj), ("floor.toml", settings)]);
    Scene::load(folder.path("floor.obj"))
}

#[test]
fn watts_and_lumens_mean_the_same_light() {
    let power = |settings: &str| floor_with(settings).unwrap().lights().next().unwrap().power().to_vec();
    let point = |amount: &str| power(&format!("[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\n{amount}"));
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 1e-9);
    assert_eq!(point("intensity = 2"), [2.0]);
    assert!(close(&point("luminous_intensity = 1366"), &[2.0]));
    assert!(close(&point("flux = 25.132741228718345"), &[2.0]));
    assert!(close(&point("luminous_flux = 17165.662259214629"), &[2.0]));
    let tinted = point("luminous_intensity = 683\ncolour = [1.0, 0.5, 0.0]");
    assert!((radiosity::scene::luminance(&tinted) - 1.0).abs() < 1e-12 && tinted[0] == 2.0 * tinted[1]);
    let radiance =
        power("efficacy = 179\n[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nilluminance = 358\n");
    assert!(close(&radiance, &[2.0]));
    let overcast = floor_with("[sky]\nkind = \"overcast\"\nilluminance = 10000").unwrap();
    let zenith = overcast.sky().unwrap().zenith[0];
    assert!((683.0 * zenith * 7.0 * PI / 9.0 / 10000.0 - 1.0).abs() < 1e-12);
}

#[test]
fn lengths_of_lights_are_in_the_unit_of_the_scene() {
    let scene = floor_with(
        "unit = 0.01\n[[light]]\nkind = \"spot\"\nposition = [0, 100, 0]\ntarget = [0, 0, 0]\ncone = 30\nflux = 5\n",
    );
    let scene = scene.unwrap();
    let Some(Light::Spot { position, direction, .. }) = scene.lights().next() else { panic!("a spot") };
    assert_eq!((*position, *direction), (DVec3::Y, DVec3::NEG_Y));
}

#[test]
fn bad_lights_are_refused_with_their_line_and_a_remedy() {
    for (settings, line, words) in [
        ("[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\n", 1, "luminous_flux"),
        ("\n[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nflux = 1\nintensity = 1\n", 2, "one of"),
        ("[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nflux = -1\n", 4, "not negative"),
        ("[[light]]\nkind = \"point\"\nposition = [0, nan, 0]\nflux = 1\n", 3, "finite"),
        ("[[light]]\nkind = \"lava\"\nposition = [0, 1, 0]\nflux = 1\n", 2, "lava"),
        ("[[light]]\nkind = \"sun\"\ndirection = [0, 0, 0]\nirradiance = 1\n", 3, "no direction"),
        (
            "[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\ndiameter = 200\n",
            5,
            "diameter",
        ),
        (
            "[[light]]\nkind = \"spot\"\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\ncone = 20\npenumbra = 30\nflux = 1\n",
            1,
            "penumbra",
        ),
        ("[[light]]\nkind = \"spot\"\nposition = [0, 1, 0]\ncone = 20\nflux = 1\n", 1, "target"),
        (
            "[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nflux = 1\ncolour = [1, 0, 0]\n",
            1,
            "leave out colour",
        ),
        ("[sky]\nkind = \"overcast\"\n", 1, "illuminance"),
        ("[sky]\nkind = \"overcast\"\nradiance = 1\nground = 2\n", 4, "ground"),
        ("[sky]\nkind = \"clear\"\nradiance = 1\nsun = [0, -1, 0]\n", 4, "horizon"),
        ("efficacy = 0\n", 1, "efficacy"),
    ] {
        let error = floor_with(settings).unwrap_err();
        let SceneError::Parse { line: found, message, .. } = &error else { panic!("{error}") };
        assert!(*found == line && message.contains(words), "{settings}: {error}");
    }
}
