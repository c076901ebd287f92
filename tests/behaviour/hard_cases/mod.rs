//! Hard cases that must stay stable, each with every solver, both ways of storage and, where it matters, both
//! bases.

mod isolated; // surfaces that see little or nothing
mod overlaps; // duplicates, crossing faces, tangles, lamps flush with a ceiling
mod reflectance; // from black to almost white
mod sides; // winding, sheets lit from both sides
mod sizes; // flat boxes, tiny faces

use nalgebra::DMatrix;
use radiosity::measure::Energy;
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::scene::{Material, Scene};
use radiosity::solve::{self, Certainty, CgOptions, NeumannOptions, Solution};
use radiosity::transport::{FormFactors, StorageKind, Transport};

use crate::scenes::{Quad, direct, factors_of, kinds, quads, room};

fn factors<'s>(scene: &'s Scene, size: PatchSize, storage: StorageKind) -> (Patches<'s>, FormFactors) {
    factors_of(scene, size, 64, (Basis::Constant, storage))
}

fn iterative(k: &Transport, e: &DMatrix<f64>) -> [Solution; 2] {
    let cg = CgOptions { tolerance: 1e-9, ..Default::default() };
    let series = NeumannOptions { tolerance: 1e-9, ..Default::default() };
    [solve::conjugate_gradients(k, e, &cg).unwrap(), solve::neumann(k, e, &series).unwrap().solution]
}

/// What holds of every scene: finite and non-negative light, rows that close, energy that balances, solvers
/// that agree as closely as their bounds say. Answers the mean radiance per quad of constant elements.
fn hold_to_the_laws(scene: &Scene, size: PatchSize) -> Vec<f64> {
    let mut constant = Vec::new();
    // That both storages hold the same linear elements is a law of its own.
    for (basis, storage) in kinds().filter(|&kind| kind != (Basis::Linear, StorageKind::Dense)) {
        let (patches, factors) = factors_of(scene, size, 64, (basis, storage));
        assert!(factors.exchange().closure_error() < 1e-12, "{:?}", factors.exchange().closure());
        let k = Transport::of(&factors, &patches).unwrap();
        assert!(k.norm().iter().all(|&q| q <= 1.0 + 1e-12));
        let e = basis.coefficients_of(&patches.emitted_radiance());
        let exact = direct(&k, &e);
        assert!(exact.radiance.iter().all(|l| l.is_finite()));
        let energy = Energy::new(&k, &e, &exact.radiance);
        assert!(energy.imbalance < 1e-10, "{basis:?} {energy:?}");
        for other in iterative(&k, &e) {
            let (off, report) = (&other.radiance - &exact.radiance, &other.report);
            let (off, most) = match report.certainty {
                Certainty::Guaranteed => (off.amax() / exact.radiance.amax(), report.bound * 1.001),
                Certainty::Estimated => (
                    k.mass().root_mean_square(off.column(0))
                        / k.mass().root_mean_square(exact.radiance.column(0)),
                    report.bound * 2.0,
                ),
            };
            assert!(off <= most + 1e-13, "{}: {off} {report:?}", report.name);
        }
        let by_patch = basis.means(&exact.radiance);
        let mut sums = vec![(0.0, 0.0); scene.faces().len() / 2];
        for i in 0..patches.len() {
            let sum = &mut sums[patches.place(i).face / 2];
            sum.0 += patches.area(i) * by_patch[i];
            sum.1 += patches.area(i);
        }
        let means: Vec<f64> =
            sums.into_iter().map(|(flux, area)| if area > 0.0 { flux / area } else { 0.0 }).collect();
        assert!(means.iter().all(|&mean| mean >= 0.0), "{basis:?}: {means:?}");
        match basis {
            Basis::Constant => {
                assert!(exact.radiance.iter().all(|&l| l >= 0.0));
                constant = means;
            }
            // The same rays tell of the same light.
            Basis::Linear => {
                let brightest = constant.iter().copied().fold(0.0, f64::max);
                let apart = |(a, b): (&f64, &f64)| (a - b).abs() < 0.05 * a + 0.005 * brightest;
                assert!(constant.iter().zip(&means).all(apart), "{constant:?} {means:?}");
            }
        }
    }
    constant
}

/// A grey room with a lamp panel that hangs below the ceiling, and whatever else.
fn lit_room(rho: f64, more: &[Quad]) -> Scene {
    let lamp = [[0.3, 0.95, 0.3], [0.7, 0.95, 0.3], [0.7, 0.95, 0.7], [0.3, 0.95, 0.7]];
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let more = more.iter().map(|&quad| (quad, 0));
    let all: Vec<(Quad, u32)> = walls.into_iter().chain([(lamp, 1)]).chain(more).collect();
    quads(&all, vec![Material::diffuse("grey", &[rho]), Material::lamp("lamp", &[0.0], &[10.0])])
}
