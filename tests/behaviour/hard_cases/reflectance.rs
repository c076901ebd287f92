//! Reflectance from 0 to almost 1: furnaces, energy, the cap of the series.

use nalgebra::DMatrix;
use radiosity::measure::Energy;
use radiosity::patches::{Basis, PatchSize};
use radiosity::scene::{Material, Scene};
use radiosity::solve::{self, CgOptions, NeumannOptions};
use radiosity::transport::{StorageKind, Transport};

use super::{factors, iterative, lit_room};
use crate::scenes::{Quad, STORAGES, direct, factors_of, kinds, quads, room};

/// A room whose walls are strips of widths from 1e-5 to 1: slivers of aspect 10⁵ beside large faces,
/// T-junctions at every corner.
fn striped_furnace() -> Scene {
    let [west, south, floor, east, north, ceiling] = room([0.0; 3], [1.0; 3]);
    let cuts = [0.0, 1e-5, 1e-3, 0.1, 0.35, 1.0];
    let mut all: Vec<(Quad, u32)> = [west, south, east, north].map(|quad| (quad, 0)).to_vec();
    for pair in cuts.windows(2) {
        let strip = |quad: Quad| quad.map(|[x, y, z]| [pair[0] + (pair[1] - pair[0]) * x, y, z]);
        all.extend([(strip(floor), 0), (strip(ceiling), 0)]);
    }
    quads(&all, vec![Material::lamp("wall", &[0.5], &[1.0])])
}

#[test]
fn a_furnace_of_mixed_sizes_stays_exact_as_reflectance_nears_one() {
    let scene = striped_furnace();
    for (basis, storage) in kinds() {
        let count = if basis == Basis::Constant { 1600 } else { 900 };
        let (patches, factors) = factors_of(&scene, PatchSize::Count(count), 64, (basis, storage));
        assert!(patches.len() > count / 2);
        let areas = patches.areas();
        let ratio = areas.iter().copied().fold(0.0, f64::max) / areas.iter().copied().fold(1.0, f64::min);
        assert!(ratio > 1e3, "sizes are mixed: {ratio}");
        assert!(factors.exchange().closure_error() < 1e-12);
        let e = basis.coefficients_of(&patches.emitted_radiance());
        for (rho, precise) in [(0.5, 1e-10), (0.9, 1e-10), (0.999, 1e-8), (0.999999, 1e-6)] {
            let k = Transport::new(&factors, DMatrix::repeat(patches.len(), 1, rho)).unwrap();
            let exact = direct(&k, &e);
            let worst = exact.radiance.map(|l| l * (1.0 - rho) - 1.0).amax();
            assert!(worst < precise, "{basis:?} ρ = {rho}: {worst}");
            let imbalance = Energy::new(&k, &e, &exact.radiance).imbalance;
            assert!(imbalance < if rho < 0.9999 { 1e-10 } else { 1e-8 }, "ρ = {rho}: imbalance {imbalance}");
            // What rounding leaves of a residual is some 1/(1 − ρ) units in the last place, and five times
            // that where M⁻¹ mixes the corners: ‖4I − J‖∞ = 5.
            let tolerance = if basis == Basis::Constant { 2e-9 } else { 1e-8 };
            let cg = solve::conjugate_gradients(&k, &e, &CgOptions { tolerance, ..Default::default() });
            let worst = cg.unwrap().radiance.map(|l| l * (1.0 - rho) - 1.0).amax();
            assert!(worst < 1e-6 + 1e-10 / (1.0 - rho), "{basis:?} ρ = {rho}: {worst}");
            // Every order of the series, and the bound at its cap.
            let options = NeumannOptions { order: 40, tolerance: 0.0, ..Default::default() };
            let series = solve::neumann(&k, &e, &options).unwrap();
            let sum: f64 = (0..=40).map(|j| rho.powi(j)).sum();
            assert!(series.solution.radiance.map(|l| l / sum - 1.0).amax() < 1e-9);
            // Everything is the same everywhere, and so are both norms but for rounding.
            let missing = (&series.solution.radiance - &exact.radiance).amax() / sum;
            assert!(
                missing <= series.solution.report.bound * 1.01 + 1e-12,
                "{missing} {:?}",
                series.solution.report
            );
        }
    }
}

#[test]
fn a_lit_room_balances_its_energy_at_any_reflectance() {
    for (rho, most) in [(0.0, 1e-12), (0.5, 1e-10), (0.9, 1e-10), (0.999, 1e-10), (0.999999, 1e-8)] {
        let scene = lit_room(rho, &[]);
        for (basis, storage) in kinds() {
            let (patches, factors) = factors_of(&scene, PatchSize::Count(600), 64, (basis, storage));
            assert!(factors.exchange().closure_error() < 1e-12);
            let k = Transport::of(&factors, &patches).unwrap();
            let e = basis.coefficients_of(&patches.emitted_radiance());
            let imbalance = Energy::new(&k, &e, &direct(&k, &e).radiance).imbalance;
            assert!(imbalance < most, "{basis:?} ρ = {rho}: {imbalance}");
        }
    }
}

#[test]
fn black_surfaces_give_back_nothing() {
    let scene = lit_room(0.0, &[]);
    for storage in STORAGES {
        let (patches, factors) = factors(&scene, PatchSize::Count(300), storage);
        let k = Transport::of(&factors, &patches).unwrap();
        let e = patches.emitted_radiance();
        assert_eq!(direct(&k, &e).radiance, e);
        for solution in iterative(&k, &e) {
            assert_eq!(solution.radiance, e);
            assert!(solution.irradiance.max() > 0.0);
        }
    }
}

#[test]
fn the_series_stops_at_its_cap_and_says_how_far_it_came() {
    let scene = lit_room(0.999, &[]);
    let (patches, factors) = factors(&scene, PatchSize::Count(300), StorageKind::Auto);
    let k = Transport::of(&factors, &patches).unwrap();
    let e = patches.emitted_radiance();
    let exact = direct(&k, &e);
    let series = solve::neumann(&k, &e, &NeumannOptions { order: 50, ..Default::default() }).unwrap();
    let report = &series.solution.report;
    assert!(series.order() == 50 && report.residual > 1e-6);
    let off = (&series.solution.radiance - &exact.radiance).amax() / series.solution.radiance.amax();
    assert!(off > 0.05 && off < report.bound && report.bound < 100.0 * off, "{off} {report:?}");
}
