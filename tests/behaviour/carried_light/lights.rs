//! A point light and the sun by way of mirrors and glass: closed forms.

use std::f64::consts::PI;

use glam::DVec3;
use radiosity::measure::Energy;
use radiosity::patches::{Basis, PatchSize};
use radiosity::scene::{Material, Side};
use radiosity::solve::Problem;
use radiosity::trace::{Tracer, fresnel, solid_angle};
use radiosity::transport::FormFactors;

use super::{carried, flux, standard_errors, trace};
use crate::scenes::{BASES, cut, flipped, lit_quads, point, room, square, sun};

#[test]
fn a_point_light_over_a_mirror_is_two_lights() {
    // A ceiling at height 2 that faces down, a light at height 1, and its image below a mirror at height 0.
    let light = DVec3::new(0.2, 1.0, -0.1);
    let scene = lit_quads(
        &[(flipped(square(2.0, 1.0)), 0), (square(0.0, 1.0), 1)],
        vec![Material::diffuse("ceiling", &[0.5]), Material::mirror("mirror", &[0.8])],
        vec![point(light.to_array(), &[20.0])],
        None,
    );
    assert_eq!(scene.warnings(), [""; 0]);
    let tracer = Tracer::new(&scene);
    let image = DVec3::new(light.x, -light.y, light.z);
    let patches = cut(&tracer, PatchSize::Count(200));
    for basis in BASES {
        let found = carried(&tracer, &patches, basis, 1024);
        for face in [0, 1] {
            let exact = 0.8 * 20.0 * solid_angle(image, &scene.corners(face));
            let off = flux(&patches, &found, face, Side::Front) / exact - 1.0;
            assert!(off.abs() < 6e-3, "{basis:?} {face}: {off}");
        }
    }
    // Patch by patch within the noise that the parts tell.
    let sources = trace(&tracer, &patches, Basis::Constant, 8192);
    let (found, errors) = (&sources.carried.as_ref().unwrap().irradiance, standard_errors(&sources));
    let mut squares = 0.0;
    for i in 0..patches.len() {
        let between = image - patches.centre(i);
        let exact = 0.8 * 20.0 * between.y.abs() / between.length().powi(3);
        assert!(errors[i] < 0.1 * exact, "{i}: {} ± {}", found[i], errors[i]);
        squares += ((found[i] - exact) / errors[i]).powi(2) / patches.len() as f64;
    }
    // A square of Student's t with 7 degrees of freedom is 7/5 in the mean.
    assert!((0.9..2.0).contains(&squares), "{squares}");
}

#[test]
fn the_sun_off_a_mirror_lands_where_geometry_says() {
    // A mirror on the ground, half a metre wide, and a wall at x = 2 that faces it; the sun from the other
    // side.
    let wall = [[2.0, 0.0, -2.0], [2.0, 0.0, 2.0], [2.0, 4.0, 2.0], [2.0, 4.0, -2.0]];
    let down = DVec3::new(1.0, -1.0, 0.0).normalize();
    let scene = lit_quads(
        &[(wall, 0), (square(0.0, 0.25), 1)],
        vec![Material::diffuse("wall", &[0.5]), Material::mirror("mirror", &[0.9])],
        vec![sun(down.to_array(), 100.0, 0.0)],
        None,
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.05));
    let found = carried(&tracer, &patches, Basis::Constant, 64);
    // At 45° the mirror's picture on the wall is as high as the mirror is long, from y = 1.75 to 2.25.
    let exact = 0.9 * 100.0 * (0.5f64).sqrt();
    let mut inside = 0;
    for i in 0..patches.len() {
        let DVec3 { y, z, .. } = patches.centre(i);
        let beyond = (y - 2.0).abs().max(z.abs()) - 0.25;
        if patches.place(i).side == Side::Back || beyond > 0.05 {
            assert_eq!(found[i], 0.0, "{i}: {y} {z}");
        } else if beyond < -0.05 {
            inside += 1;
            assert!((found[i] / exact - 1.0).abs() < 0.1, "{i}: {} {exact}", found[i]);
        }
    }
    assert!(inside > 100, "{inside}");
    let whole: f64 = [0, 1]
        .map(|face| flux(&patches, &found, face, Side::Back) + flux(&patches, &found, face, Side::Front))
        .iter()
        .sum();
    assert!((whole / (exact * 0.25) - 1.0).abs() < 1e-3, "{whole}");
}

#[test]
fn the_sun_through_a_solid_slab_is_dimmed_as_its_surfaces_do() {
    // A wide slab over a small ground.
    let slab = room([-1.2, 1.0, -1.2], [1.2, 1.2, 1.2]).map(|quad| (flipped(quad), 1));
    let quads: Vec<_> = std::iter::once((square(0.0, 0.3), 0)).chain(slab).collect();
    for diameter in [0.0, 2.0] {
        let down = DVec3::new(0.5, -1.0, 0.2).normalize();
        let scene = lit_quads(
            &quads,
            vec![Material::diffuse("ground", &[0.5]), Material::dielectric("glass", 1.5, &[1.0])],
            vec![sun(down.to_array(), 100.0, diameter)],
            None,
        );
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, PatchSize::Count(32));
        let found = carried(&tracer, &patches, Basis::Constant, 1 << 16);
        let once = fresnel(-down.y, 1.5);
        let exact = 100.0 * -down.y * (1.0 - once) / (1.0 + once) * 0.36;
        let whole: f64 = (0..2).map(|face| flux(&patches, &found, face, Side::Front)).sum();
        assert!((whole / exact - 1.0).abs() < 4e-3, "{diameter}: {whole} {exact}");
    }
}

#[test]
fn a_light_within_clear_glass_delivers_all_its_flux() {
    // A light within a block, whose filter takes one channel's part at every crossing, within a black room.
    let walls = room([0.0; 3], [3.0; 3]).map(|quad| (quad, 0));
    let block = room([1.0, 1.1, 0.9], [1.9, 2.0, 2.1]).map(|quad| (flipped(quad), 1));
    let scene = lit_quads(
        &[walls, block].concat(),
        vec![Material::diffuse("wall", &[0.0; 2]), Material::dielectric("glass", 1.5, &[1.0, 0.7])],
        vec![point([1.3, 1.4, 1.6], &[1.0, 2.0])],
        None,
    );
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(300));
    let sources = trace(&tracer, &patches, Basis::Constant, 512);
    let light = sources.carried.as_ref().unwrap();
    let arrived =
        |c: usize| (0..patches.len()).map(|i| patches.area(i) * light.irradiance[(i, c)]).sum::<f64>();
    // Black walls send nothing on: all that is absorbed and lost is on the way from the light.
    let factors = FormFactors::none(&patches, Basis::Constant);
    let problem = Problem::unlit(&patches, &factors).unwrap().under(sources.clone());
    let energy = Energy::of(&problem, problem.right_hand_side());
    // Light that total reflection holds in the block for ever is given up.
    let [clear, held] = [arrived(0), energy.lost[0]];
    assert_eq!(energy.carriers[0], 0.0);
    assert!(((clear + held) / (4.0 * PI) - 1.0).abs() < 1e-3, "{clear} {held}");
    assert!(held > 0.1 * clear, "{held}");
    // Whatever leaves the block crosses its surface just once.
    let [dim, kept] = [arrived(1), energy.carriers[1]];
    assert!((dim / (2.0 * 0.7 * clear) - 1.0).abs() < 1e-12, "{dim} {clear}");
    assert!((kept / (2.0 * 0.3 * clear) - 1.0).abs() < 1e-12, "{kept} {clear}");
}
