//! Hard cases that must stay stable, each with every solver, both ways of storage and, where it matters, both
//! bases.

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::measure::Energy;
use radiosity::patches::{Basis, PatchError, PatchSize, Patches, Reach, Tessellation};
use radiosity::scene::{Face, FaceState, Material, Scene, SceneParts};
use radiosity::solve::{self, Certainty, CgOptions, NeumannOptions, Solution};
use radiosity::trace::Tracer;
use radiosity::trace::sampling::Stream;
use radiosity::transport::{FormFactors, StorageKind, TraceOptions, Transport};

use crate::scenes::{Quad, STORAGES, direct, flipped, kinds, quads, room, traced};

fn factors<'s>(scene: &'s Scene, size: PatchSize, storage: StorageKind) -> (Patches<'s>, FormFactors) {
    factors_of(scene, size, 64, (Basis::Constant, storage))
}

fn factors_of<'s>(
    scene: &'s Scene,
    size: PatchSize,
    rays: u32,
    (basis, storage): (Basis, StorageKind),
) -> (Patches<'s>, FormFactors) {
    traced(scene, size, &TraceOptions { rays: Some(rays), basis, storage, ..Default::default() })
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

fn furnace(low: [f64; 3], high: [f64; 3]) -> Scene {
    quads(&room(low, high).map(|quad| (quad, 0)), vec![Material::lamp("wall", &[0.5], &[1.0])])
}

/// A grey room with a lamp panel that hangs below the ceiling, and whatever else.
fn lit_room(rho: f64, more: &[Quad]) -> Scene {
    let lamp = [[0.3, 0.95, 0.3], [0.7, 0.95, 0.3], [0.7, 0.95, 0.7], [0.3, 0.95, 0.7]];
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let more = more.iter().map(|&quad| (quad, 0));
    let all: Vec<(Quad, u32)> = walls.into_iter().chain([(lamp, 1)]).chain(more).collect();
    quads(&all, vec![Material::diffuse("grey", &[rho]), Material::lamp("lamp", &[0.0], &[10.0])])
}

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
fn a_single_lamp_in_empty_space_keeps_its_light_to_none() {
    let lamp = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let scene = quads(&[(lamp, 0)], vec![Material::lamp("lamp", &[0.5], &[2.0])]);
    for size in [PatchSize::Edge(10.0), PatchSize::Count(100)] {
        let means = hold_to_the_laws(&scene, size);
        assert_eq!(means, [2.0]);
    }
}

#[test]
fn two_patches_solve_their_two_equations() {
    // Two triangles face each other; each is one patch.
    let mut parts = SceneParts { name: "pair".into(), objects: vec!["pair".into()], ..Default::default() };
    parts.materials = vec![Material::lamp("lamp", &[0.6], &[1.0]), Material::diffuse("grey", &[0.8])];
    let both = quads(
        &[
            ([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]], 0),
            ([[0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [1.0, 0.5, 1.0], [0.0, 0.5, 1.0]], 1),
        ],
        parts.materials.clone(),
    );
    parts.vertices = both.vertices().to_vec();
    parts.faces = vec![both.faces()[0].clone(), both.faces()[2].clone()];
    parts.faces.iter_mut().for_each(|face| face.object = 0);
    let scene = Scene::new(parts).unwrap();
    for storage in STORAGES {
        let (patches, factors) = factors(&scene, PatchSize::Edge(10.0), storage);
        assert_eq!(patches.len(), 2);
        let f = factors.exchange().form_factor(0, 1);
        assert!(f > 0.1 && f < 0.9);
        let k = Transport::of(&factors, &patches).unwrap();
        let e = patches.emitted_radiance();
        // L1 = 1 + 0.6 f L2 and L2 = 0.8 f L1, for equal areas.
        let first = 1.0 / (1.0 - 0.6 * 0.8 * f * f);
        for solution in iterative(&k, &e).into_iter().chain([direct(&k, &e)]) {
            assert!((solution.radiance[0] - first).abs() < 1e-8);
            assert!((solution.radiance[1] - 0.8 * f * first).abs() < 1e-8);
        }
    }
}

#[test]
fn a_room_without_light_stays_black_beside_one_with_light() {
    let lit = lit_room(0.7, &[]);
    let both = lit_room(0.7, &room([2.0, 0.0, 0.0], [3.0, 1.0, 1.0]));
    let alone = hold_to_the_laws(&lit, PatchSize::Edge(0.2));
    let beside = hold_to_the_laws(&both, PatchSize::Edge(0.2));
    assert!(beside[7..].iter().all(|&mean| mean == 0.0));
    for (a, b) in alone.iter().zip(&beside) {
        assert!((a - b).abs() < 0.05 * a, "{alone:?} {beside:?}");
    }
}

#[test]
fn rooms_that_never_see_each_other_solve_each_by_itself() {
    let mut all: Vec<(Quad, u32)> = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0)).to_vec();
    all.extend(room([5.0, 0.0, 0.0], [5.5, 2.0, 1.0]).map(|quad| (quad, 1)));
    let materials = vec![Material::lamp("half", &[0.5], &[1.0]), Material::lamp("bright", &[0.9], &[3.0])];
    let means = hold_to_the_laws(&quads(&all, materials), PatchSize::Count(400));
    assert!(means[..6].iter().all(|mean| (mean - 2.0).abs() < 1e-9), "{means:?}");
    assert!(means[6..].iter().all(|mean| (mean - 30.0).abs() < 1e-8), "{means:?}");
}

#[test]
fn a_flat_box_closes() {
    let means = hold_to_the_laws(&furnace([0.0; 3], [1.0, 0.02, 1.0]), PatchSize::Count(800));
    assert!(means.iter().all(|mean| (mean - 2.0).abs() < 1e-9), "{means:?}");
}

#[test]
fn area_ratios_of_ten_billion_do_no_harm() {
    // A speck of 10 µm stands in a room of 1 m and one patch a wall.
    let s = 1e-5;
    let speck: Quad = [[0.5, 0.2, 0.5], [0.5 + s, 0.2, 0.5], [0.5 + s, 0.2, 0.5 + s], [0.5, 0.2, 0.5 + s]];
    let mut all: Vec<(Quad, u32)> = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0)).to_vec();
    all.push((speck, 1));
    let materials = vec![Material::lamp("wall", &[0.5], &[1.0]), Material::diffuse("speck", &[0.5])];
    let scene = quads(&all, materials);
    let means = hold_to_the_laws(&scene, PatchSize::Edge(0.4));
    // The speck receives the furnace's light and reflects half.
    assert!((means[6] - 1.0).abs() < 1e-3, "{means:?}");
}

#[test]
fn inverted_winding_of_walls_changes_nothing_and_of_lamps_turns_them_round() {
    let usual = lit_room(0.6, &[]);
    let size = PatchSize::Edge(0.1);
    let means = hold_to_the_laws(&usual, size);
    let flip = |which: &dyn Fn(usize) -> bool| {
        let mut parts = SceneParts {
            name: "flipped".into(),
            vertices: usual.vertices().to_vec(),
            faces: usual.faces().to_vec(),
            materials: usual.materials().to_vec(),
            objects: usual.objects().to_vec(),
            ..Default::default()
        };
        let faces = parts.faces.iter_mut().enumerate();
        faces.filter(|(k, _)| which(k / 2)).for_each(|(_, face)| face.vertices.swap(1, 2));
        hold_to_the_laws(&Scene::new(parts).unwrap(), size)
    };
    let walls_flipped = flip(&|quad| quad < 3);
    for (a, b) in means.iter().zip(&walls_flipped) {
        assert!((a - b).abs() < 0.03 * a, "{means:?} {walls_flipped:?}");
    }
    // Quad 1 is the floor, quad 4 the ceiling.
    let lamp_flipped = flip(&|quad| quad == 6);
    assert!(
        means[1] > 1.2 * lamp_flipped[1] && lamp_flipped[4] > 2.0 * means[4],
        "{means:?} {lamp_flipped:?}"
    );
}

#[test]
fn duplicates_act_once() {
    let shelf: Quad = [[0.2, 0.4, 0.2], [0.8, 0.4, 0.2], [0.8, 0.4, 0.8], [0.2, 0.4, 0.8]];
    let size = PatchSize::Edge(0.15);
    let once = hold_to_the_laws(&lit_room(0.5, &[shelf]), size);
    let twice = lit_room(0.5, &[shelf, shelf]);
    assert!(twice.warnings().iter().any(|w| w.contains("dropped 2 faces")), "{:?}", twice.warnings());
    assert_eq!(once, hold_to_the_laws(&twice, size)[..once.len()]);
}

#[test]
fn overlapping_and_interpenetrating_faces_stay_finite_and_balanced() {
    let shelf = |low: f64, high: f64, y: f64| -> Quad {
        [[low, y, low], [high, y, low], [high, y, high], [low, y, high]]
    };
    let upright: Quad = [[0.5, 0.1, 0.1], [0.5, 0.7, 0.1], [0.5, 0.7, 0.9], [0.5, 0.1, 0.9]];
    let more = [shelf(0.2, 0.7, 0.4), shelf(0.4, 0.9, 0.4), upright, shelf(-0.2, 0.5, 0.2)];
    hold_to_the_laws(&lit_room(0.8, &more), PatchSize::Edge(0.1));
}

/// `count` triangles with corners drawn in the unit square of the floor, or in the unit cube.
fn soup(count: u32, flat: bool) -> Scene {
    let mut parts = SceneParts { materials: vec![Material::diffuse("grey", &[0.5])], ..Default::default() };
    parts.objects.push("soup".into());
    for k in 0..count {
        for corner in 0..3 {
            let [x, y, z, _] = Stream::Callers.sequence(1, k, 0).point(corner);
            parts.vertices.push(DVec3::new(x, y, if flat { 0.0 } else { z }));
        }
        parts.faces.push(Face {
            vertices: [0, 1, 2].map(|corner| 3 * k + corner),
            normals: None,
            material: 0,
            object: 0,
            state: FaceState::Kept,
        });
    }
    Scene::new(parts).unwrap()
}

#[test]
fn a_tangle_of_triangles_is_cut_no_finer_than_its_size_allows() {
    let scene = soup(1500, false);
    let options =
        Tessellation { size: PatchSize::Count(100), reach: Reach::Everything, ..Default::default() };
    let patches = Patches::new(&Tracer::new(&scene), &options).unwrap();
    // Every face twice, each in some hundred lines and what they cross.
    assert!((3000..3_000_000).contains(&patches.len()), "{}", patches.len());
}

#[test]
fn faces_that_all_lie_on_one_another_are_refused_at_once() {
    let scene = soup(3000, true);
    let tracer = Tracer::new(&scene);
    let refused = Patches::new(&tracer, &Tessellation::default()).unwrap_err();
    assert!(matches!(&refused, PatchError::TooManyOverlaps { object, .. } if object == "soup"), "{refused}");
}

#[test]
fn an_open_sheet_is_lit_from_both_sides() {
    let sheet: Quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
    let above: Quad = [[0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [1.0, 0.5, 1.0], [0.0, 0.5, 1.0]];
    let below: Quad = flipped(above).map(|[x, _, z]| [x, -0.5, z]);
    let materials = vec![Material::diffuse("sheet", &[0.8]), Material::lamp("lamp", &[0.0], &[1.0])];
    let scene = quads(&[(sheet, 0), (above, 1), (below, 1)], materials);
    hold_to_the_laws(&scene, PatchSize::Count(600));
    let (patches, factors) = factors(&scene, PatchSize::Count(600), StorageKind::Auto);
    let k = Transport::of(&factors, &patches).unwrap();
    let rows = patches.average_by_face(&direct(&k, &patches.emitted_radiance()).irradiance);
    let sides: Vec<f64> = rows.iter().filter(|row| row.face < 2).map(|row| row.mean[0]).collect();
    assert_eq!(sides.len(), 4, "two faces, two sides each");
    assert!(sides.iter().all(|h| (h / sides[0] - 1.0).abs() < 0.05), "{sides:?}");
}

#[test]
fn a_lamp_flush_with_the_ceiling_or_almost_touching_it_shines() {
    let panel = |y: f64| -> Quad { [[0.3, y, 0.3], [0.7, y, 0.3], [0.7, y, 0.7], [0.3, y, 0.7]] };
    let lit = |lamp: Quad| {
        let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
        let all: Vec<(Quad, u32)> = walls.into_iter().chain([(lamp, 1)]).collect();
        let materials = vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.0], &[10.0])];
        hold_to_the_laws(&quads(&all, materials), PatchSize::Edge(0.12))
    };
    let hanging = lit(panel(0.99));
    for y in [1.0, 1.0 - 1e-12, 1.0 - 1e-9, 1.0 - 1e-5] {
        let means = lit(panel(y));
        assert!((means[1] / hanging[1] - 1.0).abs() < 0.05, "at {y}: {means:?}, hanging: {hanging:?}");
    }
    // Turned towards the ceiling it almost touches, all its light stays there.
    let turned = lit(flipped(panel(1.0 - 1e-5)));
    assert!(turned[1] < 0.2 * hanging[1], "{turned:?}");
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

#[test]
fn nothing_is_a_patch_where_nothing_sees_anything() {
    let wall: Quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let scene = quads(&[(wall, 0)], vec![Material::diffuse("grey", &[0.5])]);
    let tracer = Tracer::new(&scene);
    for reach in [Reach::Light, Reach::Everything] {
        let options = Tessellation { size: PatchSize::Count(50), reach, ..Default::default() };
        assert!(Patches::new(&tracer, &options).unwrap().is_empty());
    }
}
