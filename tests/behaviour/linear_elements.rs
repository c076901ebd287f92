//! Linear elements: the same rays, a third of the mesh error; and what keeps them stable.

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::measure::{Energy, RelativeRms};
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::scene::{Material, Side};
use radiosity::solve::{self, DirectOptions};
use radiosity::trace::sampling::{Stream, uniform_triangle};
use radiosity::trace::{Tracer, form_factor_to_triangle};
use radiosity::transport::{FormFactors, TraceOptions, Transport};

use crate::scenes::{BASES, cut, irradiance, load, quads, reference, room, unit_square};

fn factors<'s>(tracer: &Tracer<'s>, edge: f64, rays: u32, basis: Basis) -> (Patches<'s>, FormFactors) {
    let mut patches = cut(tracer, PatchSize::Edge(edge));
    let options = TraceOptions { rays: Some(rays), basis, ..Default::default() };
    let factors = FormFactors::trace(tracer, &mut patches, &options).unwrap();
    (patches, factors)
}

#[test]
fn around_corners_linear_elements_err_less_than_half_as_much_as_constant_ones() {
    let scene = load("tests/data/corridor.obj");
    let tracer = Tracer::new(&scene);
    let reference = reference("corridor");
    for edge in [1.0, 0.5] {
        let [constant, linear] = BASES.map(|basis| {
            let (patches, factors) = factors(&tracer, edge, 1024, basis);
            let means = basis.means(&irradiance(&patches, &factors));
            let rms = RelativeRms::of(&patches.average_by_face(&means), &reference);
            assert!(rms.compared == 3 * 76, "{rms:?}");
            rms.value
        });
        assert!(linear < 0.5 * constant, "edge {edge}: {constant} constant, {linear} linear");
    }
}

/// √(∫ (H − H_exact)² dA / ∫ H_exact² dA) over the floor below a lamp, by Lambert's formula at many points of
/// every patch.
fn field_error(tracer: &Tracer, patches: &Patches, basis: Basis, h: &DMatrix<f64>) -> f64 {
    let (mut difference, mut whole) = (0.0, 0.0);
    for i in patches.patches_of(0, Side::Front).chain(patches.patches_of(1, Side::Front)) {
        let place = patches.place(i);
        let [a, b, c] =
            patches.corners(i).map(|corner| tracer.frame().from_world(patches.point(place.face, corner)));
        for k in 0..64 {
            let [s, t, ..] = Stream::Callers.sequence(1, 2, 3).point(k);
            let [u, v] = uniform_triangle([s, t]);
            let point = a + (b - a) * u + (c - a) * v;
            let lamp = |face: usize| form_factor_to_triangle(point, DVec3::Y, tracer.corners(face));
            let exact = std::f64::consts::PI * (lamp(2) + lamp(3));
            let value = match basis {
                Basis::Constant => h[i],
                Basis::Linear => h[3 * i] * (1.0 - u - v) + h[3 * i + 1] * u + h[3 * i + 2] * v,
            };
            difference += patches.area(i) * (value - exact).powi(2);
            whole += patches.area(i) * exact * exact;
        }
    }
    (difference / whole).sqrt()
}

#[test]
fn the_error_of_linear_elements_falls_with_the_square_of_the_edge_and_of_constant_ones_with_the_edge() {
    let floor = unit_square(0.0);
    let lamp = [[0.3, 0.8, 0.3], [0.7, 0.8, 0.3], [0.7, 0.8, 0.7], [0.3, 0.8, 0.7]];
    let materials = vec![Material::diffuse("floor", &[0.5]), Material::lamp("lamp", &[0.0], &[1.0])];
    let scene = quads(&[(floor, 0), (lamp, 1)], materials);
    let tracer = Tracer::new(&scene);
    let slope = |basis: Basis| {
        let errors = [0.5, 0.25, 0.125].map(|edge| {
            let (patches, factors) = factors(&tracer, edge, 16384, basis);
            field_error(&tracer, &patches, basis, &irradiance(&patches, &factors))
        });
        println!("{basis:?}: {errors:?}");
        (errors[0] / errors[2]).log2() / 2.0
    };
    let [constant, linear] = BASES.map(slope);
    assert!((0.9..1.1).contains(&constant), "constant: {constant}");
    assert!((1.8..2.2).contains(&linear), "linear: {linear}");
}

#[test]
fn with_few_rays_what_varies_is_shrunk_until_no_bounce_adds_energy() {
    // Patches much wider than the gap between the walls, each with eight rays.
    let walls = room([0.0; 3], [1.0, 0.02, 1.0]).map(|quad| (quad, 0));
    let scene = quads(&walls, vec![Material::lamp("wall", &[0.5], &[1.0])]);
    let tracer = Tracer::new(&scene);
    let (patches, few) = factors(&tracer, 0.1, 8, Basis::Linear);
    let (_, many) = factors(&tracer, 0.1, 512, Basis::Linear);
    assert_eq!(many.exchange().shrinkage(), 1.0);
    let shrinkage = few.exchange().shrinkage();
    assert!((0.5..0.99).contains(&shrinkage), "{shrinkage}");
    assert!(few.exchange().closure_error() < 1e-12 && few.exchange().reciprocity_error() == 0.0);
    let rho = 0.999999;
    let k = Transport::new(&few, DMatrix::repeat(patches.len(), 1, rho)).unwrap();
    let e = Basis::Linear.coefficients_of(&patches.emitted_radiance());
    let solution = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&e);
    assert!(solution.radiance.map(|l| l * (1.0 - rho) - 1.0).amax() < 1e-6);
    // Light from one patch alone excites what varies: it must not grow.
    let mut spark = DMatrix::zeros(k.len(), 1);
    spark[0] = 1.0;
    let lit = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&spark);
    assert!(Energy::new(&k, &spark, &lit.radiance).imbalance < 1e-6);
    let mut now = spark.clone();
    for _ in 0..200 {
        let mut next = now.clone();
        k.apply(&now, &mut next);
        let norm = |x: &DMatrix<f64>| k.mass().root_mean_square(x.column(0));
        assert!(norm(&next) <= norm(&now) * (1.0 + 1e-6));
        now = next;
    }
}

#[test]
fn a_patch_whose_rays_all_leave_sends_all_its_light_away() {
    let scene = quads(&[(unit_square(0.0), 0)], vec![Material::lamp("lamp", &[0.5], &[2.0])]);
    let tracer = Tracer::new(&scene);
    let (patches, factors) = factors(&tracer, 0.5, 4096, Basis::Linear);
    let exchange = factors.exchange();
    // A third for each corner but for where the rays happened to start, and to the last digits once balanced.
    assert!(exchange.closure().before < 0.02, "{:?}", exchange.closure());
    for (escape, sum) in exchange.leaving().iter().zip(exchange.areas().iter()) {
        assert!((escape / sum - 1.0).abs() < 1e-13);
    }
    let h = irradiance(&patches, &factors);
    assert_eq!(h.amax(), 0.0);
}
