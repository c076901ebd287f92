//! Coloured mirrors, metals and glass, which make exchange areas differ by channel.

use std::io::Cursor;

use nalgebra::DMatrix;
use radiosity::measure::Energy;
use radiosity::patches::{PatchSize, Patches, Reach, Tessellation};
use radiosity::reference::PathTracer;
use radiosity::scene::{Material, Receiver, Scene};
use radiosity::solve::{self, Method, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{
    FormFactors, Keep, LightOptions, Received, StorageKind, TraceOptions, Transport, TransportError,
};

use crate::scenes::{BASES, cut_into as cut, flipped, paths, quads, room};

/// A closed room with a wall of this material and a lamp under the ceiling; grey all over but for that wall.
fn room_with(wall: Material) -> Scene {
    let channels = wall.reflectance.len();
    let grey = |x: f64| vec![x; channels];
    let mut walls = room([0.0; 3], [1.0, 0.8, 0.9]).map(|quad| (quad, 0));
    walls[2].1 = 1;
    walls[3].1 = 1;
    let lamp = [[0.3, 0.79, 0.2], [0.6, 0.79, 0.2], [0.6, 0.79, 0.4], [0.3, 0.79, 0.4]];
    let materials =
        vec![Material::diffuse("wall", &grey(0.6)), wall, Material::lamp("lamp", &grey(0.0), &grey(10.0))];
    quads(&[&walls[..], &[(lamp, 2)]].concat(), materials)
}

#[test]
fn every_channel_agrees_with_light_paths_in_a_room_of_coloured_mirrors_or_metal() {
    let gold = [0.95, 0.6, 0.2];
    for wall in [Material::mirror("gold", &gold), Material::conductor("gold", 0.5, &gold)] {
        let scene = room_with(wall);
        let tracer = Tracer::new(&scene);
        for basis in BASES {
            let mut patches = cut(&tracer, 1000);
            let factors =
                FormFactors::trace(&tracer, &mut patches, &TraceOptions { basis, ..Default::default() })
                    .unwrap();
            assert_eq!(factors.exchanges().len(), 3);
            let k = Transport::of(&factors, &patches).unwrap();
            let e = basis.coefficients_of(&patches.emitted_radiance());
            let solution = solve::solve(&k, &e, &SolveOptions::default()).unwrap();
            let energy = Energy::new(&k, &e, &solution.radiance);
            assert!(energy.imbalance < 1e-5 && energy.carriers[2] > 1.5 * energy.carriers[0], "{energy:?}");
            // All solvers are of one mind.
            let by = |method| {
                let options = SolveOptions { method, tolerance: 1e-9, ..Default::default() };
                solve::solve(&k, &e, &options).unwrap()
            };
            let [direct, series] = [Method::Direct, Method::Neumann].map(by);
            let apart = (&direct.radiance - &series.radiance).amax() / direct.radiance.amax();
            assert!(apart < 1e-7 && direct.report.bound < 1e-9, "{apart} {:?}", direct.report);
            let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(400_000)).unwrap();
            let irradiance = solution.means().irradiance;
            // Channel by channel: the mean of their colours would be off by more than a tenth.
            for c in 0..3 {
                let sum = |f: &dyn Fn(usize) -> f64| (0..traced.len()).map(f).sum::<f64>();
                let known = |i: usize| traced.irradiance(i, c);
                let whole = sum(&|i| traced.area(i) * known(i).mean);
                let off = sum(&|i| traced.area(i) * (irradiance[(i, c)] - known(i).mean)) / whole;
                let error = sum(&|i| (traced.area(i) * known(i).standard_error).powi(2)).sqrt() / whole;
                assert!(off.abs() < 0.003 + 3.0 * error, "{basis:?} {c}: {off} {error}");
            }
        }
    }
}

#[test]
fn a_channel_is_what_it_would_be_in_a_room_of_its_own_colour() {
    let solved = |colour: &[f64]| {
        let scene = room_with(Material::mirror("mirror", colour));
        let tracer = Tracer::new(&scene);
        // Chance must not decide which sides are patches.
        let (size, reach) = (PatchSize::Count(300), Reach::Everything);
        let mut patches = Patches::new(&tracer, &Tessellation { size, reach, ..Default::default() }).unwrap();
        let options = TraceOptions { rays: Some(64), ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let k = Transport::of(&factors, &patches).unwrap();
        let tones = factors.exchanges().len();
        (tones, solve::solve(&k, &patches.emitted_radiance(), &SolveOptions::default()).unwrap().irradiance)
    };
    let (three, all) = solved(&[0.9, 0.5, 0.9, 0.2]);
    assert_eq!(three, 3);
    for (channel, colour) in [0.9, 0.5, 0.9, 0.2].into_iter().enumerate() {
        let (one, alone) = solved(&[colour]);
        let apart = (all.column(channel) - alone.column(0)).amax() / alone.amax();
        assert!(one == 1 && apart < 1e-5, "{channel}: {apart}");
    }
}

#[test]
fn a_furnace_around_coloured_glass_balances_in_every_channel() {
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let block = room([0.3, 0.35, 0.25], [0.7, 0.6, 0.65]).map(|quad| (flipped(quad), 1));
    let glass = Material::dielectric("glass", 1.5, &[1.0, 0.8, 0.5]);
    let materials = vec![Material::lamp("wall", &[0.5; 3], &[1.0; 3]), glass];
    let scene = quads(&[walls, block].concat(), materials);
    let tracer = Tracer::new(&scene);
    for basis in BASES {
        let mut patches = cut(&tracer, 300);
        let options = TraceOptions { rays: Some(256), basis, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let k = Transport::of(&factors, &patches).unwrap();
        let e = basis.coefficients_of(&patches.emitted_radiance());
        let solution = solve::solve(&k, &e, &SolveOptions::default()).unwrap();
        let energy = Energy::new(&k, &e, &solution.radiance);
        assert!(energy.imbalance < 1e-6, "{energy:?}");
        let [clear, pale, dark] = [0, 1, 2].map(|c| energy.carriers[c]);
        assert!(clear == 0.0 && 0.0 < pale && pale < dark, "{energy:?}");
        let off = solution.radiance.column(0).map(|l| (l - 2.0).abs()).max();
        assert!(off < 1e-4 + 100.0 * energy.lost[0] / energy.emitted[0], "{off}");
        for (exchange, c) in factors.exchanges().iter().zip(0..) {
            assert!(exchange.closure_error() < 1e-9 && exchange.reciprocity_error() == 0.0, "{c}");
        }
    }
}

#[test]
fn saved_form_factors_hold_every_channel() {
    let scene = room_with(Material::mirror("gold", &[0.9, 0.6, 0.2]));
    let tracer = Tracer::new(&scene);
    for basis in BASES {
        let mut patches = cut(&tracer, 200);
        let options = TraceOptions { rays: Some(32), basis, keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let mut file = Vec::new();
        factors.save(&patches, &mut file).unwrap();
        let (mut file, cut) = (Cursor::new(&file), Tessellation::default());
        let (again, read, reuse) =
            FormFactors::load(&mut file, &tracer, &cut, StorageKind::Auto, Keep::Rays).unwrap();
        assert!(reuse.balanced && read.exchanges().len() == 3);
        let through = |factors: &FormFactors, patches: &Patches| {
            let k = Transport::of(factors, patches).unwrap();
            k.irradiance(&DMatrix::from_fn(k.len(), 3, |i, c| ((i * 7 + c) % 5) as f64))
        };
        assert_eq!(through(&factors, &patches), through(&read, &again));
        // Rays too: what is saved again is the same to the last bit.
        let mut second = Vec::new();
        read.save(&again, &mut second).unwrap();
        assert!(second == **file.get_ref());
    }
}

#[test]
fn a_receiver_takes_each_channel_as_the_mirror_colours_it() {
    // Between a wide lamp below and a mirror above, a point that looks up sees the lamp in the mirror alone.
    let square = |y: f64, half: f64| [[-half, y, -half], [-half, y, half], [half, y, half], [half, y, -half]];
    let colour = [0.9, 0.5, 0.1];
    let made = quads(
        &[(square(0.0, 50.0), 0), (flipped(square(1.0, 50.0)), 1)],
        vec![Material::lamp("lamp", &[0.0; 3], &[1.0; 3]), Material::mirror("mirror", &colour)],
    );
    let tracer = Tracer::new(&made);
    let mut patches = cut(&tracer, 200);
    FormFactors::trace(&tracer, &mut patches, &TraceOptions { rays: Some(64), ..Default::default() })
        .unwrap();
    let receiver = Receiver::grid(
        "desk",
        [-0.1, 0.5, -0.1].into(),
        [[0.0, 0.0, 0.2].into(), [0.2, 0.0, 0.0].into()],
        [2, 2],
    );
    let options = LightOptions { rays: 2048, ..Default::default() };
    let emitted = patches.emitted_radiance();
    let irradiance = Received::trace(&tracer, &patches, &emitted, &receiver, &options).unwrap().irradiance;
    for (c, part) in colour.into_iter().enumerate() {
        let mean = irradiance.column(c).mean() / std::f64::consts::PI;
        assert!((mean / part - 1.0).abs() < 0.005, "{c}: {mean}");
    }
}

#[test]
fn refuses_more_colours_than_a_ray_can_tell_apart() {
    let colour: Vec<f64> = (0..17).map(|k| f64::from(k) / 17.0).collect();
    let scene = room_with(Material::mirror("rainbow", &colour));
    let tracer = Tracer::new(&scene);
    let mut patches = cut(&tracer, 50);
    let refused = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap_err();
    assert_eq!(refused, TransportError::Tones { tones: 17, most: 16 });
    assert!(refused.to_string().contains("17"));
}
