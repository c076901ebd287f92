//! What patches make of a picture: averages, the same light as light paths find, energy.

use radiosity::measure::{Difference, Energy, RelativeRms};
use radiosity::patches::{Basis, PatchSize, Patches, Reach, Tessellation};
use radiosity::reference::{PathOptions, PathTracer};
use radiosity::scene::{Material, Pixels, Side, Texture};
use radiosity::solve;
use radiosity::trace::Tracer;
use radiosity::transport::Transport;

use super::{case, gallery, painted, textured};
use crate::scenes::{paths, room};

#[test]
fn patches_average_the_picture_so_that_faces_have_its_mean() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    for edge in [3.0, 0.4, 0.13] {
        let (size, reach) = (PatchSize::Edge(edge), Reach::Everything);
        let patches = Patches::new(&tracer, &Tessellation { size, reach, ..Default::default() }).unwrap();
        for (field, lamp) in [(patches.reflectances(), false), (patches.emitted_radiance(), true)] {
            for row in patches.average_by_face(&field).iter().filter(|row| row.side == Side::Front) {
                let material = scene.material_of(row.face);
                let (plain, texture) = match lamp {
                    false => (&material.reflectance, scene.reflectance_texture(row.face)),
                    true => (&material.emission, scene.emission_texture(row.face)),
                };
                let factors = texture.map_or([1.0; 3], |texture| texture.mean());
                for c in 0..3 {
                    let exact = plain[c] * factors[c];
                    assert!((row.mean[c] - exact).abs() < 1e-9, "{edge} {row:?}: {exact}");
                }
            }
        }
        assert!(edge > 1.0 || patches.reflectances().column(1).max() > 0.85, "patches differ");
    }
}

#[test]
fn an_even_picture_is_as_good_as_its_colour() {
    let even = |x: [f32; 3]| Texture::new(Pixels::new(3, 2, vec![x; 6]));
    let lamp = Material::lamp("lamp", &[0.3; 3], &[5.0; 3]);
    let quads: Vec<_> = room([0.0; 3], [1.0; 3]).into_iter().zip([0, 0, 0, 0, 1, 0]).collect();
    let with = textured(&quads, vec![painted([0.8, 0.8, 0.4], even([0.5, 0.25, 1.0])), lamp.clone()]);
    let plain = textured(&quads, vec![Material::diffuse("plain", &[0.4, 0.2, 0.4]), lamp]);
    for basis in [Basis::Constant, Basis::Linear] {
        let [ours, theirs] =
            [&with, &plain].map(|scene| case(&Tracer::new(scene), 300, basis).solve().radiance);
        assert!((&ours - &theirs).amax() < 1e-9 * theirs.amax(), "{basis:?}");
    }
}

#[test]
fn light_paths_that_read_the_picture_itself_agree() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    let case = case(&tracer, 6000, Basis::Constant);
    let solution = case.solve();
    let options = PathOptions { seed: 3, ..paths(1_500_000) };
    let truth = PathTracer::new(&tracer).irradiance(&case.patches, &options).unwrap();
    let floor = case.patches.average_by_face(&solution.irradiance);
    let rms = RelativeRms::of(&floor, &truth.by_face(&case.patches));
    assert!(rms.compared > 30 && rms.value < 0.005, "{rms:?}");
    let difference = Difference::new(&solution.irradiance, &truth);
    assert!(difference.bias.abs() < 0.002 + 3.0 * difference.bias_error, "{difference:?}");
    // The lamp is no even one: neither is the light below it.
    let [left, right] = [2, 3].map(|face| floor.iter().find(|row| row.face == face).unwrap().mean[0]);
    assert!((left / right - 1.0).abs() > 0.02, "{left} {right}");
}

#[test]
fn energy_balances_where_reflectance_varies() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    let case = case(&tracer, 1500, Basis::Constant);
    let k = Transport::of(&case.factors, &case.patches).unwrap();
    let e = case.patches.emitted_radiance();
    let solution = solve::direct(&k, &Default::default()).unwrap().solve(&e);
    assert!(Energy::new(&k, &e, &solution.radiance).imbalance < 1e-9);
}
