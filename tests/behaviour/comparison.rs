//! What the comparison with the path tracer says of right solvers, and of wrong ones.

use nalgebra::DMatrix;
use radiosity::measure::{Agreement, Comparison, Difference, MeshError, OrderOptions, OrderRow};
use radiosity::patches::{PatchSize, Patches, Tessellation};
use radiosity::reference::{PathOptions, PathTraced, PathTracer};
use radiosity::scene::Scene;
use radiosity::solve::{self, Amplification, CgOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions, Transport};

use crate::scenes::{mesh, paths};

/// What is compared, and what it was made from.
struct Case<'s> {
    tracer: Tracer<'s>,
    tessellation: Tessellation<'s>,
    trace: TraceOptions<'s>,
    patches: Patches<'s>,
    factors: FormFactors,
    reference: PathTraced,
}

impl<'s> Case<'s> {
    fn new(scene: &'s Scene, count: usize, light_paths: u64, seed: u64) -> Self {
        let tracer = Tracer::new(scene);
        let tessellation = Tessellation { size: PatchSize::Count(count), seed, ..Default::default() };
        let trace = TraceOptions { seed, ..Default::default() };
        let mut patches = Patches::new(&tracer, &tessellation).unwrap();
        let factors = FormFactors::trace(&tracer, &mut patches, &trace).unwrap();
        let reference = light_along_paths(&tracer, &patches, light_paths, seed);
        Self { tracer, tessellation, trace, patches, factors, reference }
    }

    /// The same but for the light paths.
    fn with_other_paths(self, light_paths: u64, seed: u64) -> Self {
        Self { reference: light_along_paths(&self.tracer, &self.patches, light_paths, seed), ..self }
    }

    fn mesh_error(&self) -> MeshError {
        let Self { tracer, patches, factors, tessellation, trace, .. } = self;
        MeshError::estimate(tracer, patches, factors, tessellation, trace).unwrap()
    }

    /// Irradiance with reflectances that are off by a factor.
    fn solve(&self, factor: f64) -> DMatrix<f64> {
        let k = Transport::new(&self.factors, self.patches.reflectances() * factor).unwrap();
        solve::conjugate_gradients(&k, &self.patches.emitted_radiance(), &CgOptions::default())
            .unwrap()
            .irradiance
    }

    fn compare(&self, irradiance: &DMatrix<f64>, mesh: &MeshError) -> Comparison {
        Comparison::new(&self.patches, irradiance, &self.reference, mesh)
    }
}

fn light_along_paths(tracer: &Tracer, patches: &Patches, light_paths: u64, seed: u64) -> PathTraced {
    let options = PathOptions { seed, ..paths(light_paths) };
    PathTracer::new(tracer).irradiance(patches, &options).unwrap()
}

#[test]
fn a_right_solver_agrees_on_the_furnace_whatever_the_seed() {
    for (name, seeds) in [("furnace_cube", 20), ("furnace_sphere", 8)] {
        let scene = mesh(name);
        let mut case = Case::new(&scene, 200, 40_000, 0);
        assert_eq!(case.factors.rays(), 0, "form factors are exact, whatever the seed");
        let (mesh, right) = (case.mesh_error(), case.solve(1.0));
        for seed in 0..seeds {
            case = case.with_other_paths(40_000, seed);
            let comparison = case.compare(&right, &mesh);
            assert_eq!(
                comparison.agreement,
                Agreement::WithinNoise,
                "{name} {seed}: {:?}",
                comparison.reasons
            );
            assert_eq!(comparison.verdict(), "agrees within noise");
        }
    }
}

#[test]
fn a_right_solver_is_never_called_wrong_on_the_cornell_box_whatever_the_seed() {
    let scene = Scene::cornell_box();
    for seed in 0..20 {
        let case = Case::new(&scene, 500, 100_000, seed);
        let comparison = case.compare(&case.solve(1.0), &case.mesh_error());
        assert!(comparison.agreement <= Agreement::MeshExplains, "{seed}: {:?}", comparison.reasons);
    }
}

#[test]
fn wrong_reflectances_a_dropped_row_and_a_wrong_pi_are_explained_by_nothing() {
    for (name, count) in [("furnace_cube", 300), ("cornell_box", 2000), ("two_rooms", 1000)] {
        let scene = mesh(name);
        for seed in 0..2 {
            let case = Case::new(&scene, count, 400_000, seed);
            let mesh = case.mesh_error();
            let right = case.solve(1.0);
            let mut dropped = right.clone();
            // Neither in the brightest light nor in the dark.
            let mut by_light: Vec<usize> = (0..case.patches.len()).collect();
            by_light.sort_by(|&a, &b| right[(a, 0)].total_cmp(&right[(b, 0)]));
            dropped.row_mut(by_light[by_light.len() / 2]).fill(0.0);
            let wrong = [
                ("2 % more reflectance", case.solve(1.02)),
                ("2 % less reflectance", case.solve(0.98)),
                ("a dropped row", dropped),
                ("π = 3.2", &right * (3.2 / std::f64::consts::PI)),
                ("no π", &right / std::f64::consts::PI),
            ];
            for (what, irradiance) in wrong {
                let comparison = case.compare(&irradiance, &mesh);
                let says = comparison.verdict();
                assert_eq!(comparison.agreement, Agreement::NothingExplains, "{name} {seed} {what}: {says}");
                assert!(says.starts_with("differs by ") && says.ends_with(", which nothing explains"));
            }
            assert!(case.compare(&right, &mesh).agreement <= Agreement::MeshExplains, "{name} {seed}");
        }
    }
}

#[test]
fn orders_come_within_their_bounds_of_the_direct_solution() {
    for name in ["cornell_box", "two_rooms", "facing_plates", "furnace_cube"] {
        let scene = mesh(name);
        let case = Case::new(&scene, 400, 10_000, 0);
        let problem =
            Problem::unlit(&case.patches, &case.factors).unwrap().under(case.patches.emitted_radiance());
        let direct = problem.direct(&Default::default()).unwrap().irradiance;
        let amplification = Amplification::new(problem.operator(), Default::default()).unwrap();
        let options = OrderOptions { tolerance: 1e-8, ..Default::default() };
        let rows = OrderRow::all(&problem, &direct, &case.reference, &amplification, &options).unwrap();
        assert!((rows[0].vs_direct - 1.0).abs() < 1e-12, "order 0 has no irradiance");
        assert!((rows[0].vs_reference.bias + 1.0).abs() < 1e-12);
        for row in &rows {
            assert!(row.vs_direct <= row.bound + 1e-12, "{name}: {row:?}");
        }
        for pair in rows.windows(2) {
            assert!(pair[1].vs_direct < pair[0].vs_direct && pair[1].seconds >= pair[0].seconds);
        }
        let last = rows.last().unwrap();
        assert!(last.bound <= 1e-8 && rows[rows.len() - 2].bound > 1e-8);
        // The bound is worth knowing, not just true.
        assert!(rows.iter().skip(12).all(|row| row.bound < 100.0 * row.vs_direct), "{name}");
    }
}

#[test]
fn a_difference_is_measured_with_the_noise_taken_off() {
    let scene = mesh("furnace_cube");
    let case = Case::new(&scene, 300, 200_000, 1);
    let right = case.solve(1.0);
    let noise = case.reference.relative_standard_error();
    for off in [0.0, 0.02, 0.1] {
        let difference = Difference::new(&(&right * (1.0 + off)), &case.reference);
        assert!(noise > 0.005 && difference.uncertainty < noise, "{noise} {difference:?}");
        let sure = 4.0 * difference.uncertainty;
        assert!((difference.rms - off).abs() < sure.max(0.2 * noise), "{off}: {difference:?}");
        assert!((difference.bias - off).abs() < 4.0 * difference.bias_error, "{off}: {difference:?}");
    }
}
