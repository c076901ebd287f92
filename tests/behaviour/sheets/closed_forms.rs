//! Furnaces and joined spheres: what comes through sheets by closed forms, and when light is trapped.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use radiosity::measure::Energy;
use radiosity::patches::{PatchSize, Patches, Reach, Sheets, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::Material;
use radiosity::solve::{self, DirectOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{
    Exchange, FormFactors, Reflection, Storage, TraceOptions, Transport, TransportError,
};

use super::{every_solver, two_cubes};
use crate::scenes::BASES;

#[test]
fn a_furnace_is_exact_on_both_sides_of_a_sheet() {
    let passed_on = 0.8;
    for (front, back, through) in [(0.3, 0.3, 0.5), (0.0, 0.0, 0.8), (0.8, 0.8, 0.0), (0.7, 0.7, 0.1)] {
        let wall = Material::diffuse("wall", &[passed_on]);
        let lamp = Material::lamp("lamp", &[passed_on], &[1.0]);
        let sheet = Material::diffuse("sheet", &[front]).with_sheet(&[back], &[through]);
        let scene = two_cubes([wall.clone(), Material { name: "other wall".into(), ..wall }, lamp, sheet]);
        let tracer = Tracer::new(&scene);
        for basis in BASES {
            let options =
                Tessellation { size: PatchSize::Count(300), reach: Reach::Everything, ..Default::default() };
            let mut patches = Patches::new(&tracer, &options).unwrap();
            let options = TraceOptions { rays: Some(128), basis, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let k = Transport::of(&factors, &patches).unwrap();
            let e = DMatrix::repeat(k.len(), 1, 1.0);
            for solution in every_solver(&k, &e) {
                let name = solution.report.name;
                assert_eq!(name == "minres", name != "direct" && name != "neumann" && through > front);
                let exact = 1.0 / (1.0 - passed_on);
                let worst = solution.radiance.iter().map(|l| (l / exact - 1.0).abs()).fold(0.0, f64::max);
                assert!(worst < 1e-9, "{front} {back} {through} {basis:?} {name}: {worst}");
            }
        }
    }
}

/// Two spheres, each of a wall and a window that joins them, with even exchange within each: patches wall,
/// window front, window back, wall, in the order given. A channel for each set of reflectances and
/// transmittance.
fn joined_spheres(order: [usize; 4], channels: &[([f64; 4], f64)]) -> (FormFactors, Reflection) {
    const AREAS: [f64; 4] = [3.0, 0.5, 0.5, 2.0];
    let at = |i: usize| order.iter().position(|&k| k == i).unwrap();
    let whole = |i: usize| AREAS[2 * (i / 2)] + AREAS[2 * (i / 2) + 1];
    let exchange = |a: usize, b: usize| {
        let [i, j] = [order[a], order[b]];
        if i / 2 == j / 2 { (AREAS[i] * AREAS[j] / whole(i)) as f32 } else { 0.0 }
    };
    let areas = DVector::from_fn(4, |a, _| AREAS[order[a]]);
    let storage = Storage::Dense(DMatrix::from_fn(4, 4, exchange));
    let exchange =
        Exchange::new(storage, DVector::zeros(4), areas, &[false; 4], Progress::default()).unwrap();
    let reflectance = DMatrix::from_fn(4, channels.len(), |a, c| channels[c].0[order[a]]);
    let transmittance = DMatrix::from_fn(1, channels.len(), |_, c| channels[c].1);
    let sheets = Some(Sheets { pairs: vec![[at(1), at(2)]], transmittance });
    (exchange.into(), Reflection { reflectance, sheets })
}

/// Radiance of the four patches where the first wall emits 1. In irradiance, what each sphere gets is what it
/// loses and what goes through: H₁ (A₁(1 − ρ₁) + a(1 − ρ_f)) − aτ H₂ = A₁πE, H₂ (A₂(1 − ρ₂) + a(1 − ρ_b)) =
/// aτ H₁.
fn in_joined_spheres(&(rho, tau): &([f64; 4], f64)) -> [f64; 4] {
    let first = 3.0 * (1.0 - rho[0]) + 0.5 * (1.0 - rho[1]);
    let second = 2.0 * (1.0 - rho[3]) + 0.5 * (1.0 - rho[2]);
    let through = 0.5 * tau;
    let h1 = 3.0 * PI / (first - through * through / second);
    let h2 = through / second * h1;
    [1.0 + rho[0] * h1 / PI, (rho[1] * h1 + tau * h2) / PI, (rho[2] * h2 + tau * h1) / PI, rho[3] * h2 / PI]
}

#[test]
fn two_spheres_joined_by_a_translucent_window_have_their_closed_form() {
    let channels = [
        ([0.6, 0.5, 0.3, 0.4], 0.25),
        ([0.6, 0.0, 0.0, 0.9], 1.0),
        ([0.9, 0.1, 0.3, 0.2], 0.7),
        ([0.5, 0.7, 0.0, 0.5], 0.3),
        ([0.5, 0.4, 0.4, 0.5], 0.4),
        ([0.5, 0.7, 0.1, 0.5], 0.0),
        ([0.5, 0.7, 0.1, 0.5], 0.2),
        // Shares the factor of the one before.
        ([0.5, 0.7, 0.1, 0.5], 0.2),
    ];
    // Definite alone, and with indefinite ones beside.
    for channels in [&channels[..1], &channels[..]] {
        for order in [[0, 1, 2, 3], [2, 0, 3, 1], [3, 2, 1, 0], [1, 3, 0, 2]] {
            let (factors, reflection) = joined_spheres(order, channels);
            let k = Transport::new(&factors, reflection).unwrap();
            let e = DMatrix::from_fn(4, channels.len(), |a, _| if order[a] == 0 { 1.0 } else { 0.0 });
            for solution in every_solver(&k, &e) {
                for (c, channel) in channels.iter().enumerate() {
                    let exact = in_joined_spheres(channel);
                    for (a, &i) in order.iter().enumerate() {
                        let found = solution.radiance[(a, c)];
                        // Exchange areas are stored in f32.
                        let off = (found - exact[i]).abs();
                        assert!(off < 1e-6, "{channel:?} {order:?} {}: {found}", solution.report.name);
                    }
                }
                let energy = Energy::new(&k, &e, &solution.radiance);
                assert!(energy.imbalance < 1e-9, "{energy:?}");
            }
            let solver = solve::direct(&k, &DirectOptions::default()).unwrap();
            assert_eq!(solver.factorizations(), if channels.len() > 1 { 7 } else { 1 });
        }
    }
}

#[test]
fn light_between_white_walls_and_a_sheet_that_absorbs_nothing_is_trapped() {
    // ρ + τ = 1 all around, also where it comes to 1 but for rounding.
    for (rho, tau) in [([1.0, 0.58, 0.58, 1.0], 0.42), ([1.0, 0.0, 0.0, 1.0], 1.0)] {
        let (factors, reflection) = joined_spheres([0, 1, 2, 3], &[(rho, tau)]);
        let refused = Transport::new(&factors, reflection);
        assert!(matches!(refused, Err(TransportError::Unsolvable { .. })), "{rho:?}");
    }
    // The second sphere absorbs, and the first sees it through the sheet.
    for (rho, tau) in [([1.0, 0.7, 0.7, 0.9], 0.3), ([1.0, 0.7, 0.6, 1.0], 0.3), ([1.0, 0.0, 0.0, 0.9], 1.0)]
    {
        let (factors, reflection) = joined_spheres([0, 1, 2, 3], &[(rho, tau)]);
        assert!(Transport::new(&factors, reflection).is_ok(), "{rho:?}");
    }
}
