//! Receivers: closed forms at points that are no patches, and what the program reports of them.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::output::Levels;
use radiosity::patches::Basis;
use radiosity::scene::{Material, Measure, Receiver, Scene, Sky, SkyKind};
use radiosity::trace::{Tracer, form_factor_to_triangle};
use radiosity::transport::{LightOptions, Received, Sources};

use crate::program::{radiosity, text};
use crate::scenes::{cut_into, flipped, lit_quads, point, square};
use crate::scratch::Scratch;

/// Points on the square of half-width 0.5 at a height, facing up.
fn desk(y: f64) -> Receiver {
    Receiver::grid("desk", DVec3::new(-0.5, y, -0.5), [DVec3::Z, DVec3::X], [4, 3])
}

#[test]
fn under_a_lamp_receivers_see_lamberts_formula() {
    let materials = vec![Material::diffuse("floor", &[0.0]), Material::lamp("lamp", &[0.0], &[7.0])];
    let quads = [(square(0.0, 2.0), 0), (flipped(square(1.0, 0.4)), 1)];
    let scene = lit_quads(&quads, materials, vec![], None);
    let tracer = Tracer::new(&scene);
    let patches = cut_into(&tracer, 300);
    for basis in [Basis::Constant, Basis::Linear] {
        let emitted = basis.coefficients_of(&patches.emitted_radiance());
        for height in [0.2, 0.7, 0.95] {
            let receiver = desk(height);
            let options = LightOptions { rays: 4096, ..Default::default() };
            let found = Received::trace(&tracer, &patches, &emitted, &receiver, &options).unwrap().irradiance;
            for (i, point) in receiver.points().enumerate() {
                let at = tracer.frame().from_world(point);
                let seen = |f: usize| form_factor_to_triangle(at, DVec3::Y, tracer.corners(f));
                let exact = 7.0 * PI * (seen(2) + seen(3));
                assert!(
                    (found[i] / exact - 1.0).abs() < 3e-3,
                    "{basis:?} {height} {i}: {} {exact}",
                    found[i]
                );
            }
        }
    }
}

#[test]
fn lights_without_area_reach_receivers_and_lit_ground_shines_back() {
    let light = DVec3::new(0.2, 2.0, 0.1);
    let sky = Sky { kind: SkyKind::Overcast, up: DVec3::Y, zenith: vec![10.0], ground: 0.0 };
    let materials = vec![Material::diffuse("ground", &[0.5])];
    let lamp = point(light, &[30.0]);
    let scene = lit_quads(&[(square(0.0, 1.0), 0)], materials, vec![lamp], Some(sky));
    let tracer = Tracer::new(&scene);
    let patches = cut_into(&tracer, 500);
    let options = LightOptions { rays: 4096, ..Default::default() };
    let sources = Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap();
    // The ground reflects half of what arrives, and sees nothing but the sky.
    let radiance = sources.direct.unwrap() * (0.5 / PI);
    let trace = |receiver: &Receiver| {
        Received::trace(&tracer, &patches, &radiance, receiver, &options).unwrap().irradiance
    };
    let up = desk(1.0);
    let found = trace(&up);
    for (i, point) in up.points().enumerate() {
        let between = light - point;
        let exact = 30.0 * between.y / between.length().powi(3) + 10.0 * 7.0 * PI / 9.0;
        assert!((found[i] / exact - 1.0).abs() < 1e-3, "{i}: {} {exact}", found[i]);
    }
    // Just above the ground, facing down, it is half of what the ground gets.
    let down = Receiver { edges: [DVec3::X, DVec3::Z], ..desk(1e-3) };
    assert_eq!(down.normal(), DVec3::NEG_Y);
    let found = trace(&down);
    for (i, point) in down.points().enumerate() {
        let between = light - point;
        let exact = 0.5 * (30.0 * between.y / between.length().powi(3) + 10.0 * 7.0 * PI / 9.0);
        assert!((found[i] / exact - 1.0).abs() < 5e-3, "{i}: {} {exact}", found[i]);
    }
}

/// Sun from straight above on a square of so wide an edge at height 0 that reflects half.
fn sunlit(edge: f64) -> Scene {
    let sun =
        radiosity::scene::Light::Sun { direction: DVec3::NEG_Y, irradiance: vec![100.0], diameter: 0.0 };
    let materials = vec![Material::diffuse("spot", &[0.5])];
    lit_quads(&[(square(0.0, 0.5 * edge), 0)], materials, vec![sun], None)
}

#[test]
fn receivers_see_small_sunlit_spots_and_know_their_error() {
    let mut z = Vec::new();
    for edge in [0.02, 0.1, 0.5] {
        let scene = sunlit(edge);
        let tracer = Tracer::new(&scene);
        let patches = cut_into(&tracer, 100);
        let options = LightOptions { rays: 512, ..Default::default() };
        let sources = Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap();
        let radiance = sources.direct.unwrap() * (0.5 / PI);
        // A wall beside the spot.
        let receiver =
            Receiver::grid("wall", DVec3::new(1.0, 0.05, -0.5), [DVec3::Z, DVec3::Y * 2.0], [2, 4]);
        assert_eq!(receiver.normal(), DVec3::NEG_X);
        let found = Received::trace(&tracer, &patches, &radiance, &receiver, &options).unwrap();
        for (i, point) in receiver.points().enumerate() {
            let at = tracer.frame().from_world(point);
            let seen: f64 =
                (0..2).map(|f| form_factor_to_triangle(at, DVec3::NEG_X, tracer.corners(f))).sum();
            let exact = 50.0 * seen;
            let got = found.irradiance[i];
            assert!((got / exact - 1.0).abs() < 0.02, "{edge} {i}: {got} {exact}");
            let error = found.rows.noise().variance(|field| field[i]).sqrt();
            z.push((got - exact) / error);
        }
    }
    let rms = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
    assert!((0.6..1.5).contains(&rms), "{rms}: {z:?}");
}

#[test]
fn receivers_measure_on_planes_of_their_own_and_all_around() {
    let light = DVec3::new(0.3, 1.4, 1.0);
    let sky = Sky { kind: SkyKind::Constant, up: DVec3::Y, zenith: vec![2.0], ground: 0.0 };
    // A floor so small that it hides next to nothing.
    let quads = [(square(-9.0, 0.01), 0)];
    let black = || vec![Material::diffuse("black", &[0.0])];
    let lit = lit_quads(&quads, black(), vec![point(light, &[30.0])], None);
    let under_sky = lit_quads(&quads, black(), Vec::new(), Some(sky));
    let normal = DVec3::new(0.6, 0.0, 0.8);
    for measure in [Measure::Plane, Measure::Normal(normal), Measure::Cylinder(DVec3::Y)] {
        let receiver = Receiver { measure, maintenance: 0.5, ..desk(0.0) };
        let measured = |scene: &Scene| {
            let tracer = Tracer::new(scene);
            let patches = cut_into(&tracer, 2);
            let dark = DMatrix::zeros(patches.len(), 1);
            let options = LightOptions { rays: 4096, ..Default::default() };
            Received::trace(&tracer, &patches, &dark, &receiver, &options).unwrap().irradiance
        };
        let found = measured(&lit);
        for (i, at) in receiver.points().enumerate() {
            let between = light - at;
            let exact = 0.5 * 30.0 * receiver.response(between.normalize()) / between.length_squared();
            assert!((found[i] / exact - 1.0).abs() < 1e-3, "{measure:?} {i}: {} {exact}", found[i]);
        }
        // ∫ cos θ dω over a hemisphere is π, and so is ∫ sin θ dω / π over all directions.
        for h in measured(&under_sky).iter() {
            assert!((h / (0.5 * 2.0 * PI) - 1.0).abs() < 1e-3, "{measure:?}: {h}");
        }
    }
}

#[test]
fn uniformity_is_the_lowest_by_the_mean_and_by_the_highest() {
    let row = Levels::of([(100.0, 1.0), (300.0, 3.0)].into_iter()).unwrap();
    assert_eq!((row.mean, row.minimum, row.maximum), (250.0, 100.0, 300.0));
    assert_eq!((row.uniformity, row.diversity), (0.4, 1.0 / 3.0));
    let dark = Levels::of([(0.0, 1.0)].into_iter()).unwrap();
    assert_eq!((dark.uniformity, dark.diversity), (0.0, 0.0));
    assert_eq!(Levels::of(std::iter::empty()), None);
}

/// A floor under a point light of 100 cd, with these settings besides.
fn floor_with(settings: &str) -> Scratch {
    let obj = "mtllib floor.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\no floor\nusemtl black\nf 1 2 3 4\n";
    let light = "[[light]]\nkind = \"point\"\nposition = [0, 2, 0]\nluminous_intensity = 100\n";
    let settings = format!("{light}{settings}");
    let mtl = "newmtl black\nKd 0 0 0\n".to_owned();
    Scratch::with(&[("floor.obj", obj.to_owned()), ("floor.toml", settings), ("floor.mtl", mtl)])
}

const DESK: &str = "[[receiver]]\nname = \"desk\"\ncorner = [-0.5, 1, -0.5]\nedges = [[0, 0, 1], [1, 0, 0]]\npoints = [3, 3]\n";

/// Whether the floor could be solved with these arguments besides, and the message.
fn solved(folder: &Scratch, more: &str) -> (bool, String) {
    let usual = "solve floor.obj --patches 200 --rays 64 --size 80x60";
    let output = radiosity(folder.folder(), &format!("{usual} {more}"));
    (output.status.success(), text(&output.stderr).to_owned())
}

/// Mean, lowest, highest and uniformity of the desk with these settings besides.
fn folder_levels(more: &str) -> Vec<f64> {
    let folder = floor_with(&format!("{DESK}{more}"));
    let (done, message) = solved(&folder, "--photometric");
    assert!(done, "{message}");
    let mut table = csv::Reader::from_path(folder.path("out/floor/photometry.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.unwrap()).collect();
    (4..8).map(|k| rows[3][k].parse().unwrap()).collect()
}

#[test]
fn the_program_reports_lux_at_receivers_and_on_surfaces() {
    let folder = floor_with(DESK);
    let (done, message) = solved(&folder, "--photometric");
    assert!(done, "{message}");
    let table = |name: &str| -> Vec<Vec<String>> {
        let mut table = csv::Reader::from_path(folder.path(&format!("out/floor/{name}"))).unwrap();
        table.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect()
    };
    let number = |row: &[String], k: usize| row[k].parse::<f64>().unwrap();
    // The picture has false colours: the floor is not grey.
    let picture = image::open(folder.path("out/floor/illuminance.png")).unwrap().into_rgb8();
    assert!(picture.pixels().any(|p| p.0[1] > p.0[2].saturating_add(40)));
    let points = table("receivers.csv");
    assert_eq!(points.len(), 9);
    // The middle of the desk is 1 m below 100 cd: 100 lx, 100/683 W/m².
    let middle = &points[4];
    assert_eq!((middle[0].as_str(), number(middle, 3)), ("desk", 1.0));
    assert!((number(middle, 8) - 100.0).abs() < 1e-6);
    assert!((number(middle, 5) - 100.0 / 683.0).abs() < 1e-9);
    let rows = table("photometry.csv");
    let names: Vec<&str> = rows.iter().map(|row| row[1].as_str()).collect();
    assert_eq!(names, ["black", "floor", "point 1", "desk"]);
    // 100 cd times the solid angle of the floor, over its 4 m².
    let exact = 100.0 * 4.0 * (1.0 / (2.0 * 6f64.sqrt())).atan() / 4.0;
    assert!((number(&rows[1], 4) / exact - 1.0).abs() < 1e-6, "{rows:?}");
    assert!((number(&rows[3], 6) - 100.0).abs() < 1e-6);
    // Without its edges the desk is its middle.
    let margin = folder_levels("margin = 0.25\nmaintenance = 0.5\n");
    assert!((margin[0] - 50.0).abs() < 1e-6 && margin[3] == 1.0, "{margin:?}");
    // The lamp sends its intensity in all directions; black surfaces have no luminance, and receivers none
    // either.
    assert!((number(&rows[2], 3) / (400.0 * PI) - 1.0).abs() < 1e-8);
    assert_eq!((rows[1][9].as_str(), rows[3][9].as_str(), rows[2][4].as_str()), ("0", "", ""));
}

#[test]
fn luminance_is_what_leaves_a_matt_surface_and_every_header_names_its_unit() {
    let folder = floor_with("");
    folder.write("floor.mtl", "newmtl black\nKd 0.5\nKe 0.02\n");
    let (done, message) = solved(&folder, "--photometric");
    assert!(done, "{message}");
    let table = |name: &str| {
        let mut table = csv::Reader::from_path(folder.path(&format!("out/floor/{name}"))).unwrap();
        let header: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
        let rows: Vec<csv::StringRecord> = table.records().map(|row| row.unwrap()).collect();
        (header, rows)
    };
    for (name, rows, keys) in
        [("faces_photometric.csv", 2, 4), ("patches_photometric.csv", 100, 3), ("photometry.csv", 3, 2)]
    {
        let (header, found) = table(name);
        assert!(found.len() >= rows, "{name}: {}", found.len());
        for column in &header[keys..] {
            let named = ["_m", "_m2", "_lx", "_lm", "_u0", "_ud", "_u0_error"]
                .iter()
                .any(|unit| column.ends_with(unit));
            assert!(named, "{name}: {column} has no unit");
        }
    }
    let (header, rows) = table("patches_photometric.csv");
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    for row in &rows {
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        // L = Lₑ + ρE/π on the front; the back gets nothing.
        let exact = 683.0 * 0.02 + 0.5 * number("illuminance_lx") / PI;
        assert!((number("luminance_cd_m2") / exact - 1.0).abs() < 1e-6, "{row:?}");
    }
    let (header, rows) = table("photometry.csv");
    let emitted = header.iter().position(|column| column == "emitted_lm").unwrap();
    assert!((rows[0][emitted].parse::<f64>().unwrap() / (683.0 * 0.02 * PI * 4.0) - 1.0).abs() < 1e-6);
    let picture = image::open(folder.path("out/floor/luminance.png")).unwrap().into_rgb8();
    assert!(picture.width() > 200);
}

#[test]
fn bad_receivers_are_refused() {
    for (settings, words) in [
        (DESK.replace("[1, 0, 0]", "[0, 0, 2]"), "span an area"),
        (DESK.replace("points = [3, 3]", "points = [0, 3]"), "points must be"),
        (format!("{DESK}{DESK}"), "another has this name"),
        (DESK.replace("-0.5, 1,", "-0.5, inf,"), "finite"),
        (format!("{DESK}maintenance = 1.5\n"), "maintenance 1.5"),
        (format!("{DESK}margin = 0.6\n"), "leave a point"),
        (format!("{DESK}axis = [0, 1, 0]\n"), "only a cylindrical one"),
        (format!("{DESK}normal = [0, 0, 0]\n"), "not all 0"),
    ] {
        let (done, message) = solved(&floor_with(&settings), "");
        assert!(!done && message.contains("receiver desk") && message.contains(words), "{message}");
    }
    for (settings, words) in [
        (
            DESK.replace("points = [3, 3]", "points = [3, 3, 3]"),
            "floor.toml:9: points: 3 in place of 2 values",
        ),
        (DESK.replace("[1, 0, 0]", "[1, 0, 0, 5]"), "floor.toml:8: edges: 4 in place of 3 values"),
    ] {
        let (done, message) = solved(&floor_with(&settings), "");
        assert!(!done && message.contains(words), "{message}");
    }
}

#[test]
fn receivers_that_do_not_fit_into_memory_are_refused_before_the_work() {
    let many = DESK.replace("points = [3, 3]", "points = [3000, 3000]");
    let (done, message) = solved(&floor_with(&many), "");
    let words = ["9000000 points", "GB", "more than the 4.3 GB allowed", "desk", "--memory"];
    assert!(!done && words.iter().all(|word| message.contains(word)), "{message}");
}
