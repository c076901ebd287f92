//! Photometric files: the light under a luminaire is that of its table, whichever way it hangs; flux,
//! settings, broken files.

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;
use radiosity::measure::{Difference, Energy};
use radiosity::patches::{Basis, PatchSize};
use radiosity::reference::PathTracer;
use radiosity::scene::{IntensityTable, Light, Material, Receiver, Scene};
use radiosity::solve::Problem;
use radiosity::trace::Tracer;
use radiosity::trace::sampling::Stream;
use radiosity::transport::{FormFactors, LightOptions, Received, Sources, TraceOptions};

use crate::scenes::{cut, cut_into, lit_quads, paths, room};
use crate::scratch::Scratch;

const FILES: [&str; 4] = ["downlight", "batwing", "wallwasher", "lopsided"];
const EFFICACY: f64 = 683.0;

fn text(name: &str) -> String {
    std::fs::read_to_string(format!("{}/tests/data/{name}.ies", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn table(name: &str) -> IntensityTable {
    IntensityTable::parse(&text(name), &mut Vec::new()).unwrap()
}

const OBJ: &str =
    "mtllib a.mtl\nv -0.7 0 -0.7\nv -0.7 0 0.7\nv 0.7 0 0.7\nv 0.7 0 -0.7\nusemtl m\nf 1 2 3\nf 1 3 4\n";

/// Ground of 1.4 x 1.4 m under a luminaire with these settings.
fn load(name: &str, settings: &str) -> Result<Scene, String> {
    let scratch = Scratch::with(&[("a.obj", OBJ), ("a.mtl", "newmtl m\nKd 0.5\n")]);
    scratch.write("lamp.ies", text(name));
    scratch.write("a.toml", format!("[[light]]\nkind = \"ies\"\nfile = \"lamp.ies\"\n{settings}\n"));
    Scene::load(scratch.path("a.obj")).map_err(|e| e.to_string())
}

/// Illuminance that a table says of a place that looks up; its C0 lies along x, so that C90 lies along −z.
fn by_table(table: &IntensityTable, between: DVec3) -> f64 {
    let below = between.y / between.length();
    let horizontal = between.z.atan2(-between.x).to_degrees();
    table.at(below.acos().to_degrees(), horizontal) * below / between.length_squared()
}

#[test]
fn illuminance_under_a_luminaire_is_that_of_its_table_by_the_inverse_square() {
    let position = DVec3::new(0.2, 1.5, -0.3);
    for name in FILES {
        let scene = load(name, "position = [0.2, 1.5, -0.3]\ndirection = [0, -1, 0]").unwrap();
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, PatchSize::Edge(0.02));
        let options = LightOptions { rays: 64, ..Default::default() };
        let table = table(name);
        // At points it is exact.
        let desk =
            Receiver::grid("desk", DVec3::new(-0.6, 0.5, -0.6), [DVec3::Z * 1.2, DVec3::X * 1.2], [12, 12]);
        let dark = DMatrix::zeros(patches.len(), 1);
        let found = Received::trace(&tracer, &patches, &dark, &desk, &options).unwrap().irradiance;
        for (i, point) in desk.points().enumerate() {
            let exact = by_table(&table, position - point);
            assert!((EFFICACY * found[i] / exact - 1.0).abs() < 1e-9, "{name} {point}: {} {exact}", found[i]);
        }
        // Over patches it is the mean, which differs from the middle's by their size squared, and by the
        // kinks of the table within them; along the axis some of these tables jump from one horizontal angle
        // to the next.
        let found = Sources::trace(&tracer, &patches, Basis::Constant, &options).unwrap().direct.unwrap();
        let (mut squares, mut whole) = (0.0, 0.0);
        for i in 0..patches.len() {
            let between = position - patches.centre(i);
            if between.angle_between(DVec3::Y).to_degrees() < 5.0 {
                continue;
            }
            let exact = by_table(&table, between);
            squares += (EFFICACY * found[i] - exact).powi(2);
            whole += exact * exact;
        }
        let apart = (squares / whole).sqrt();
        assert!(apart < 1e-3, "{name}: {apart}");
    }
}

#[test]
fn flux_is_what_the_file_implies_however_the_luminaire_hangs() {
    for name in FILES {
        let table = table(name);
        for (aim, up) in [("[0, -1, 0]", "[1, 0, 0]"), ("[1, 2, -0.5]", "[0.3, 0, 1]")] {
            let scene = load(name, &format!("position = [0, 1, 0]\ndirection = {aim}\nup = {up}")).unwrap();
            let light = scene.lights().next().unwrap();
            let n = 1 << 16;
            let sample = |k: u32| {
                let [u, v, ..] = Stream::Callers.sequence(3, 7, 0).point(k);
                let (z, angle) = (1.0 - 2.0 * u, std::f64::consts::TAU * v);
                let across = (1.0 - z * z).sqrt();
                light.share_towards(DVec3::new(across * angle.cos(), across * angle.sin(), z)) / f64::from(n)
            };
            let share: f64 = (0..n).map(sample).sum();
            let lumens = EFFICACY * light.power()[0] * share * 4.0 * std::f64::consts::PI;
            let numbers: Vec<f64> =
                aim.trim_matches(['[', ']']).split(',').map(|x| x.trim().parse().unwrap()).collect();
            let down = (-DVec3::from_slice(&numbers).normalize().y).acos().to_degrees();
            let wanted = table.flux() * table.tilt_factor(down);
            assert!((lumens / wanted - 1.0).abs() < 1e-3, "{name} {aim}: {lumens} {wanted}");
        }
    }
}

#[test]
fn a_luminaire_turns_with_its_axis_and_up() {
    let table = table("lopsided");
    let scene = |aim: DVec3, up: DVec3| {
        let settings = format!(
            "position = [0, 1, 0]\ndirection = [{}, {}, {}]\nup = [{}, {}, {}]",
            aim.x, aim.y, aim.z, up.x, up.y, up.z
        );
        load("lopsided", &settings).unwrap()
    };
    let hanging = scene(-DVec3::Y, DVec3::X);
    let hanging = hanging.lights().next().unwrap();
    // C0 along x; C90 is a quarter turn counter-clockwise seen from above: along −z.
    let towards = |vertical: f64, ahead: DVec3| {
        let angle = vertical.to_radians();
        -DVec3::Y * angle.cos() + ahead * angle.sin()
    };
    for (ahead, horizontal) in [(DVec3::X, 0.0), (-DVec3::Z, 90.0), (-DVec3::X, 180.0), (DVec3::Z, 270.0)] {
        let share = hanging.share_towards(towards(30.0, ahead));
        assert!((share * table.highest() / table.at(30.0, horizontal) - 1.0).abs() < 1e-9, "{horizontal}");
    }
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.1);
    let turned = scene(turn * -DVec3::Y, turn * DVec3::X);
    let turned = turned.lights().next().unwrap();
    for k in 0..50 {
        let [u, v, w, _] = Stream::Callers.sequence(1, 1, 0).point(k).map(|x| 2.0 * x - 1.0);
        let direction = DVec3::new(u, v, w).normalize();
        let (a, b) = (hanging.share_towards(direction), turned.share_towards(turn * direction));
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn light_paths_and_energy_agree_under_luminaires() {
    let walls: Vec<_> = room([0.0; 3], [3.0, 2.5, 3.0]).map(|quad| (quad, 0)).to_vec();
    let light = |name: &str, x: f64| {
        let table = table(name);
        let intensity = vec![table.highest() / EFFICACY];
        Light::Ies {
            position: DVec3::new(x, 2.2, 1.4),
            direction: -DVec3::Y,
            c0: DVec3::X,
            intensity,
            table: table.into(),
        }
    };
    let lights = vec![light("wallwasher", 0.8), light("batwing", 2.1)];
    let scene = lit_quads(&walls, vec![Material::diffuse("wall", &[0.6])], lights, None);
    let tracer = Tracer::new(&scene);
    let mut patches = cut_into(&tracer, 2000);
    let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap();
    let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
    let solution = problem.solve(&Default::default()).unwrap();
    let energy = Energy::of(&problem, &solution.radiance);
    assert!(energy.imbalance < 1e-5, "{energy:?}");
    // A closed room gets all that luminaires send.
    let sent = (table("wallwasher").flux() + table("batwing").flux()) / EFFICACY;
    assert!((energy.emitted[0] / sent - 1.0).abs() < 1e-3, "{} {sent}", energy.emitted[0]);
    let truth = PathTracer::new(&tracer).irradiance(&patches, &paths(200_000)).unwrap();
    let difference = Difference::new(&solution.irradiance, &truth);
    assert!(
        difference.rms < 0.01 && difference.bias.abs() < 0.001 + 3.0 * difference.bias_error,
        "{difference:?}"
    );
}

#[test]
fn settings_scale_colour_and_aim_a_luminaire() {
    let power = |settings: &str| {
        let scene = load("downlight", &format!("position = [0, 2, 0]\n{settings}")).unwrap();
        scene.lights().next().unwrap().power().to_vec()
    };
    let plain = power("direction = [0, -1, 0]");
    assert!((plain[0] * EFFICACY / table("downlight").highest() - 1.0).abs() < 1e-12);
    assert!((power("target = [0, 0, 0]\nscale = 2.5")[0] / plain[0] - 2.5).abs() < 1e-12);
    let lumens = table("downlight").flux();
    assert!((power("target = [0, 0, 0]\nluminous_flux = 500")[0] / plain[0] - 500.0 / lumens).abs() < 1e-9);
    let warm = power("target = [0, 0, 0]\ncolour = [1.0, 0.8, 0.5]");
    assert!((radiosity::scene::luminance(&warm) / plain[0] - 1.0).abs() < 1e-12 && warm[2] < 0.6 * warm[0]);
}

#[test]
fn broken_luminaires_are_named() {
    let refused = |settings: &str, line: usize, wanted: &[&str]| {
        let message = load("downlight", settings).unwrap_err();
        for word in wanted.iter().chain(&[format!("a.toml:{line}: light").as_str()]) {
            assert!(message.contains(word), "{word}: {message}");
        }
    };
    refused("position = [0, 1, 0]", 1, &["target or by direction"]);
    refused("position = [0, 1, 0]\ndirection = [0, 0, 0]", 5, &["direction"]);
    refused("position = [0, 1, 0]\ndirection = [0, -1, 0]\nup = [0, 2, 0]", 1, &["up"]);
    refused(
        "position = [0, 1, 0]\ndirection = [0, -1, 0]\nscale = 1\nluminous_flux = 1",
        1,
        &["one of the two"],
    );
    refused("position = [0, 1, 0]\ndirection = [0, -1, 0]\nscale = -1", 6, &["scale -1:", "not negative"]);
    let scratch = Scratch::with(&[("a.obj", OBJ), ("a.mtl", "newmtl m\nKd 0.5\n")]);
    let settings =
        "[[light]]\nkind = \"ies\"\nfile = \"lamp.ies\"\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\n";
    scratch.write("a.toml", settings);
    let message = || Scene::load(scratch.path("a.obj")).unwrap_err().to_string();
    assert!(message().contains("lamp.ies is not there; put it there"), "{}", message());
    scratch.write("lamp.ies", text("downlight").replace(" 1 2 0.1", " 4 2 0.1"));
    assert!(message().contains("lamp.ies:5: 4 is no type of photometry"), "{}", message());
    let lines: Vec<String> = text("downlight").lines().take(8).map(str::to_owned).collect();
    scratch.write("lamp.ies", lines.join("\n"));
    assert!(message().contains("the file ends where"), "{}", message());
}
