//! Every solver finds the same light through sheets, loses none of it, and bounds its error.

use nalgebra::DMatrix;
use radiosity::measure::Energy;
use radiosity::patches::{Basis, PatchSize};
use radiosity::reference::PathTracer;
use radiosity::solve::{self, CgOptions, DirectOptions, NeumannOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, StorageKind, TraceOptions, Transport};

use super::{around, every_solver, factors, gauze, paper};
use crate::scenes::{cut_into, difference, on_threads, paths};

#[test]
fn bounds_hold_through_sheets() {
    let scene = around(gauze());
    let (patches, factors) = factors(&scene, PatchSize::Count(400), (Basis::Constant, 128));
    let k = Transport::of(&factors, &patches).unwrap();
    let e = patches.emitted_radiance();
    let exact = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&e).radiance;
    for order in 0..12 {
        let options = NeumannOptions { order, tolerance: 0.0, ..Default::default() };
        let series = solve::neumann(&k, &e, &options).unwrap().solution;
        let off = |c: usize| {
            (series.radiance.column(c) - exact.column(c)).amax() / series.radiance.column(c).amax()
        };
        let worst = (0..3).map(off).fold(0.0, f64::max);
        assert!(worst <= series.report.bound, "order {order}: {worst} {:?}", series.report);
        assert!(series.report.bound < 50.0 * worst, "order {order}: {worst} {:?}", series.report);
    }
    for tolerance in [1e-1, 1e-3, 1e-5] {
        let options = CgOptions { tolerance, ..Default::default() };
        let found = solve::conjugate_gradients(&k, &e, &options).unwrap();
        let off =
            |c: usize| (found.radiance.column(c) - exact.column(c)).amax() / found.radiance.column(c).amax();
        let worst = (0..3).map(off).fold(0.0, f64::max);
        assert_eq!(found.report.name, "minres");
        assert!(worst <= found.report.bound && found.report.residual <= tolerance, "{:?}", found.report);
    }
}

#[test]
fn every_solver_finds_the_same_light_through_sheets_and_none_of_it_is_lost() {
    for wall in [paper(), gauze()] {
        let scene = around(wall);
        for (basis, storage) in [
            (Basis::Constant, StorageKind::Dense),
            (Basis::Constant, StorageKind::Sparse),
            (Basis::Linear, StorageKind::Auto),
        ] {
            let tracer = Tracer::new(&scene);
            let mut patches = cut_into(&tracer, 500);
            let options = TraceOptions { rays: Some(128), basis, storage, ..Default::default() };
            let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
            let k = Transport::of(&factors, &patches).unwrap();
            let e = basis.coefficients_of(&patches.emitted_radiance());
            let solutions = every_solver(&k, &e);
            for solution in &solutions {
                let off = difference(&solution.radiance, &solutions[0].radiance);
                assert!(off < 1e-9, "{basis:?} {storage:?} {}: {off}", solution.report.name);
                assert!(solution.report.residual < 1e-10, "{:?}", solution.report);
                let energy = Energy::new(&k, &e, &solution.radiance);
                assert!(energy.imbalance < 1e-9, "{basis:?} {}: {energy:?}", solution.report.name);
            }
        }
    }
}

#[test]
fn light_through_sheets_adds_up() {
    let scene = around(gauze());
    let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Linear, 128));
    let k = Transport::of(&factors, &patches).unwrap();
    let e = Basis::Linear.coefficients_of(&patches.emitted_radiance());
    let other = DMatrix::from_fn(e.nrows(), e.ncols(), |i, _| f64::from(i as u32 % 3));
    let cg = CgOptions { tolerance: 1e-12, ..Default::default() };
    let [whole, one, other] =
        [&e * 2.0 + &other, e, other].map(|e| solve::conjugate_gradients(&k, &e, &cg).unwrap().radiance);
    assert!(difference(&(2.0 * one + other), &whole) < 1e-10);
}

#[test]
fn the_same_bits_come_through_on_any_number_of_threads() {
    let scene = around(gauze());
    let answers = [1, 3].map(|threads| {
        on_threads(threads, || {
            let (patches, factors) = factors(&scene, PatchSize::Count(600), (Basis::Constant, 64));
            let k = Transport::of(&factors, &patches).unwrap();
            let tracer = Tracer::new(&scene);
            let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(20_000)).unwrap();
            (every_solver(&k, &patches.emitted_radiance()).map(|solution| solution.radiance), traced.means())
        })
    });
    assert!(answers[0] == answers[1]);
}
