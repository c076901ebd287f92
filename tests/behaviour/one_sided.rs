//! Form factors of one side over its whole area: known values, closure, reciprocity, bounds on what no ray
//! found, which sides are meant.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use glam::DVec3;
use radiosity::output::{FactorEntry, FactorTable};
use radiosity::patches::{GroupBy, Groups, PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Face, FaceState, Material, Scene, SceneParts, Side};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, TraceOptions};
use serde_json::Value;

use crate::scenes::{flipped, quads, room};
use crate::scratch::Scratch;

/// How finely a table is found.
#[derive(Clone, Copy)]
struct Effort {
    patches: usize,
    rays: u32,
    seed: u64,
}

/// Form factors from the fronts of objects, and from their backs too where everything is reached.
fn by_object(scene: &Scene, reach: Reach, effort: Effort, then: impl FnOnce(&FactorTable)) {
    let Effort { patches, rays, seed } = effort;
    let tracer = Tracer::new(scene);
    let options = Tessellation { size: PatchSize::Count(patches), reach, seed, ..Default::default() };
    let mut patches = Patches::new(&tracer, &options).unwrap();
    let options =
        TraceOptions { rays: Some(rays), lamp_rays: Some(0), seed, keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let sends = |_: usize, side: Side| reach == Reach::Everything || side == Side::Front;
    let groups = Groups::new(&patches, GroupBy::Object, sends);
    let between = factors.between_groups(&patches, groups.of_patch(), Progress::default()).unwrap();
    then(&FactorTable::between_groups(&patches, &groups, &between, rays));
}

const FRONTS: Reach = Reach::OneSide(Side::Front);

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/view_factors").join(format!("{name}.obj"))
}

/// The place of a group in a table.
fn place(table: &FactorTable, name: &str) -> usize {
    table.groups().all().iter().position(|group| group.name == name).unwrap()
}

fn factor(table: &FactorTable, from: &str, to: &str) -> FactorEntry {
    table.full_row(place(table, from))[place(table, to)]
}

/// Spheres around the origin, of 128 faces each: radius, and whether fronts are outside.
fn spheres(all: &[(f64, bool)]) -> Scene {
    let mut parts = SceneParts {
        name: "spheres".into(),
        materials: vec![Material::diffuse("grey", &[0.5])],
        ..Default::default()
    };
    for (object, &(radius, outwards)) in all.iter().enumerate() {
        parts.objects.push(format!("sphere {object}"));
        let mut faces: Vec<[DVec3; 3]> = Vec::new();
        for signs in 0..8 {
            let sign = |k: u32| if (signs >> k) & 1 == 0 { 1.0 } else { -1.0 };
            let [x, y, z] = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
            faces.push(if sign(0) * sign(1) * sign(2) > 0.0 { [x, y, z] } else { [x, z, y] });
        }
        for _ in 0..2 {
            faces = faces
                .iter()
                .flat_map(|&[a, b, c]| {
                    let [p, q, r] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                    [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
                })
                .collect();
        }
        for [a, b, c] in faces {
            let first = parts.vertices.len() as u32;
            parts.vertices.extend([a, b, c].map(|p| p * radius));
            let vertices =
                if outwards { [first, first + 1, first + 2] } else { [first, first + 2, first + 1] };
            parts.faces.push(Face {
                vertices,
                normals: None,
                material: 0,
                object: object as u32,
                state: FaceState::Kept,
            });
        }
    }
    Scene::new(parts).unwrap()
}

// What they are.

#[test]
fn a_form_factor_is_of_one_side_over_its_whole_area() {
    // Similar polyhedra: F = 1 from the inner one, by the ratio of areas back.
    let scene = spheres(&[(1.0, true), (2.0, false)]);
    by_object(&scene, FRONTS, Effort { patches: 500, rays: 64, seed: 0 }, |table| {
        assert_eq!(table.groups().len(), 2, "backs that nothing reaches have no group");
        let known =
            [("sphere 0", "sphere 1", 1.0), ("sphere 1", "sphere 0", 0.25), ("sphere 1", "sphere 1", 0.75)];
        for (from, to, exact) in known {
            let found = factor(table, from, to);
            assert!((found.form_factor - exact).abs() < 1e-6, "{from} to {to}: {found:?}");
            let error = found.standard_error.unwrap();
            assert!(error > 1e-7 && error < 1e-3, "at least what a ray is worth: {found:?}");
        }
        let alone = factor(table, "sphere 0", "sphere 0");
        assert_eq!(
            (alone.form_factor, alone.upper95),
            (0.0, Some(0.0)),
            "a convex body provably sees nothing of itself"
        );
    });
}

#[test]
fn a_back_is_a_row_of_its_own() {
    let scene = spheres(&[(1.0, true), (2.0, false)]);
    by_object(&scene, Reach::Everything, Effort { patches: 800, rays: 64, seed: 0 }, |table| {
        let names: Vec<&str> = table.groups().all().iter().map(|group| group.name.as_str()).collect();
        assert_eq!(names, ["sphere 0", "sphere 0 (back)", "sphere 1"], "the outer back sees nothing");
        for (name, exact) in [("sphere 0", 1.0), ("sphere 1", 0.25)] {
            let other = if name == "sphere 0" { "sphere 1" } else { "sphere 0" };
            assert!((factor(table, name, other).form_factor - exact).abs() < 1e-6);
        }
        let inside = factor(table, "sphere 0 (back)", "sphere 0 (back)");
        assert!((inside.form_factor - 1.0).abs() < 1e-6, "{inside:?}");
    });
}

#[test]
fn faces_that_see_nothing_count_in_the_area() {
    // One of two floor tiles lies face down: the tiles' front is twice as large as what sees the ceiling.
    let tile = |x: f64| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0]];
    let ceiling = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
    let scene = quads(
        &[(tile(0.0), 0), (flipped(tile(5.0)), 0), (ceiling, 1)],
        vec![Material::diffuse("floor", &[0.5]), Material::diffuse("ceiling", &[0.5])],
    );
    let tracer = Tracer::new(&scene);
    let options = Tessellation { size: PatchSize::Count(300), reach: FRONTS, ..Default::default() };
    let mut patches = Patches::new(&tracer, &options).unwrap();
    let options =
        TraceOptions { rays: Some(256), lamp_rays: Some(0), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let groups = Groups::new(&patches, GroupBy::Material, |_, side| side == Side::Front);
    let between = factors.between_groups(&patches, groups.of_patch(), Progress::default()).unwrap();
    let table = FactorTable::between_groups(&patches, &groups, &between, 256);
    let found = factor(&table, "floor", "ceiling");
    assert!((table.groups().all()[0].area - 2.0).abs() < 1e-12);
    let z = (found.form_factor - 0.5 * 0.199824895698387) / found.standard_error.unwrap();
    assert!(z.abs() < 4.0, "{found:?}, z = {z}");
    let row: f64 = table.full_row(0).iter().map(|entry| entry.form_factor).sum();
    assert!((row + table.escape(0).form_factor - 1.0).abs() < 1e-9);
    let alone = quads(&[(tile(0.0), 0)], vec![Material::diffuse("floor", &[0.5])]);
    assert_eq!(radiosity::patches::seeing_sides(&Tracer::new(&alone)), [[false; 2]; 2]);
}

/// Form factors of fronts over the whole front area, from closed forms and integrals.
const KNOWN: [(&str, &str, &str, f64); 14] = [
    ("box_in_box", "inner", "outer", 1.0),
    ("box_in_box", "outer", "inner", 0.08666666666666667),
    ("cube_inside", "bottom", "top", 0.19982489569838746),
    ("cube_inside", "bottom", "x0", 0.20004377607540316),
    ("far_small", "a", "b", 3.183096739773802e-07),
    ("ratio_1e6", "sensor", "plate", 0.5541262780829919),
    ("raystrack_canyon", "road", "east2", 0.02611759774068142),
    ("raystrack_canyon", "east0", "west0", 0.13331095314066324),
    ("raystrack_canyon", "east0", "west4", 0.00769084427065149),
    ("slit_boxes", "a", "b", 0.000147544),
    ("slot", "bottom", "top", 0.9041979180566159),
    ("slot", "y0", "y1", 3.1829883060323753e-06),
    ("v3d_square_obstruction", "zeq0", "zeq1", 0.14986867177379062),
    ("wedge_5deg", "a", "b", 0.920261908111222),
];

#[test]
fn known_form_factors_lie_within_four_standard_errors_and_below_the_bound_of_zeros() {
    for (name, from, to, exact) in KNOWN {
        let scene = Scene::load(data(name)).unwrap();
        by_object(&scene, FRONTS, Effort { patches: 1000, rays: 128, seed: 0 }, |table| {
            let found = factor(table, from, to);
            let z = (found.form_factor - exact) / found.standard_error.unwrap();
            assert!(z.abs() < 4.0, "{name}: {from} to {to} is {exact}: {found:?}, z = {z}");
            let is_below = found.upper95.unwrap() >= exact;
            assert!(is_below || found.form_factor > 0.0, "{name}: {from} to {to} is {exact}: {found:?}");
        });
    }
}

// What holds between them.

#[test]
fn rows_and_what_escapes_sum_to_one_and_groups_are_reciprocal() {
    let sheet = [[0.2, 0.3, 0.5], [0.8, 0.3, 0.5], [0.8, 0.7, 0.5], [0.2, 0.7, 0.5]];
    let mut all: Vec<_> = room([0.0; 3], [1.0; 3])[..5].iter().map(|&quad| (quad, 0)).collect();
    all.push((sheet, 0));
    let open = quads(&all, vec![Material::diffuse("grey", &[0.5])]);
    for reach in [FRONTS, Reach::Everything] {
        by_object(&open, reach, Effort { patches: 300, rays: 64, seed: 1 }, |table| {
            let groups = table.groups().all();
            assert_eq!(groups.len(), 7, "light lands on the sheet's back");
            assert_eq!(table.senders().count(), if reach == FRONTS { 6 } else { 7 });
            assert_eq!(table.receivers().count(), 7);
            let onto_back = factor(table, "quad 2", "quad 5 (back)").form_factor;
            assert!(onto_back > 0.1, "the floor sees the sheet from below: {onto_back}");
            for a in table.senders() {
                let row = table.full_row(a);
                let sum: f64 = row.iter().map(|entry| entry.form_factor).sum();
                assert!((sum + table.escape(a).form_factor - 1.0).abs() < 1e-9, "{}", groups[a].name);
                for b in table.senders() {
                    let there = groups[a].area * row[b].form_factor;
                    let back = groups[b].area * table.full_row(b)[a].form_factor;
                    assert!((there - back).abs() <= 1e-9 * there, "{} {}", groups[a].name, groups[b].name);
                }
            }
        });
    }
}

#[test]
fn zero_hits_have_an_upper_bound() {
    let scene = Scene::load(data("far_small")).unwrap();
    by_object(&scene, FRONTS, Effort { patches: 20, rays: 64, seed: 0 }, |table| {
        let found = factor(table, "a", "b");
        let rays = 64.0 * table.patches().len() as f64;
        assert_eq!(found.form_factor, 0.0);
        assert!(found.standard_error.unwrap() > 0.0);
        let bound = found.upper95.unwrap() * rays;
        assert!((1.0..10.0).contains(&bound), "3 by the number of rays from both: {bound}");
        assert_eq!(factor(table, "a", "a").upper95, Some(0.0), "a plane provably sees nothing of itself");
        let escape = table.escape(place(table, "a"));
        assert!(
            (escape.form_factor - 1.0).abs() < 1e-12 && escape.standard_error.unwrap() > 0.0,
            "{escape:?}"
        );
    });
}

#[test]
fn upper_bounds_of_rare_pairs_hold_in_95_cases_of_100() {
    // From none to a few hits in a run, at a distance of twelve sides.
    let low = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    const APART: f64 = 12.0;
    let high = flipped(low.map(|[x, y, _]| [x, y, APART]));
    let scene = quads(&[(low, 0), (high, 0)], vec![Material::diffuse("grey", &[0.5])]);
    // Howell C-11.
    let x = 1.0 / APART;
    let q = (1.0 + x * x).sqrt();
    let logarithm = (q * q / (1.0 + 2.0 * x * x).sqrt()).ln();
    let exact =
        2.0 / (std::f64::consts::PI * x * x) * (logarithm + 2.0 * (x * q * (x / q).atan() - x * x.atan()));
    const RUNS: u64 = 200;
    let (mut exceeded, mut zeros) = (0, 0);
    for seed in 0..RUNS {
        by_object(&scene, FRONTS, Effort { patches: 8, rays: 64, seed }, |table| {
            let found = factor(table, "quad 0", "quad 1");
            exceeded += u32::from(found.upper95.unwrap() < exact);
            zeros += u32::from(found.form_factor == 0.0);
        });
    }
    assert!(zeros > 10 && zeros < 190, "hits are rare: {zeros} of {RUNS} runs had none");
    // 10 are expected at most; binomial, 3.5 standard deviations.
    assert!(exceeded < 21, "{exceeded} of {RUNS} exceed their bound");
}

// The command.

fn radiosity(scratch: &Scratch, arguments: &str) -> Output {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("radiosity");
    command.current_dir(scratch.folder()).args(arguments.split_whitespace()).output().expect("it runs")
}

/// The records of `form-factors`, by name of column, and what it warns of.
#[track_caller]
fn records(scratch: &Scratch, arguments: &str) -> (Vec<BTreeMap<String, String>>, String) {
    let output =
        radiosity(scratch, &format!("form-factors {arguments} -o f.csv --quiet --patches 400 --rays 64"));
    let quiet = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {quiet}");
    let told = radiosity(scratch, &format!("form-factors {arguments} -o g.csv --patches 20 --rays 8"));
    let text = fs::read_to_string(scratch.path("f.csv")).unwrap();
    let mut csv = csv::Reader::from_reader(text.as_bytes());
    let records = csv.deserialize().map(|record| record.unwrap()).collect();
    (records, String::from_utf8(told.stderr).unwrap())
}

fn senders(records: &[BTreeMap<String, String>]) -> Vec<String> {
    let mut names: Vec<String> = records.iter().map(|record| record["from"].clone()).collect();
    names.dedup();
    names
}

#[test]
fn rows_of_files_sum_to_one_with_what_escapes() {
    for name in ["slit_boxes", "raystrack_canyon", "ratio_1e6"] {
        for sides in ["front", "back", "both"] {
            let scratch = Scratch::new();
            let file = data(name);
            let (records, _) = records(&scratch, &format!("{} --by object --sides {sides}", file.display()));
            let mut sums: BTreeMap<String, f64> = BTreeMap::new();
            let number = |record: &BTreeMap<String, String>, key: &str| record[key].parse::<f64>().unwrap();
            for record in &records {
                let sum = sums.entry(record["from"].clone()).or_insert(number(record, "escape"));
                *sum += number(record, "form_factor");
                assert!(number(record, "upper95") >= number(record, "form_factor"));
                assert!(number(record, "from_area") > 0.0 && number(record, "escape_error") >= 0.0);
            }
            assert!(!sums.is_empty());
            for (from, sum) in sums {
                assert!((sum - 1.0).abs() < 1e-9, "{name} {sides}: {from}: {sum}");
            }
        }
    }
}

/// A box that is seen from inside, and in it a smaller one seen from outside.
const BOXES: &str = include_str!("../data/view_factors/box_in_box.obj");

#[test]
fn sides_are_the_front_unless_others_are_asked_for() {
    let scratch = Scratch::with(&[("a.obj", BOXES)]);
    for (sides, expected) in [
        ("", vec!["outer", "inner"]),
        ("--sides front", vec!["outer", "inner"]),
        ("--sides back", vec!["outer (back)", "inner (back)"]),
        ("--sides both", vec!["outer", "inner", "inner (back)"]),
    ] {
        let (records, told) = records(&scratch, &format!("a.obj {sides}"));
        assert_eq!(senders(&records), expected, "{sides}");
        assert!(!told.contains("both sides"), "{told}");
    }
    let refused = radiosity(&scratch, "form-factors a.obj --sides left");
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn where_winding_is_inconsistent_both_sides_are_taken_with_a_warning() {
    // One face of the inner box turned over.
    let lines: Vec<&str> = BOXES.lines().collect();
    let last = lines.last().unwrap().split(' ').collect::<Vec<_>>();
    let turned = format!("f {}", last[1..].iter().rev().copied().collect::<Vec<_>>().join(" "));
    let mixed = lines[..lines.len() - 1].join("\n") + "\n" + &turned + "\n";
    let scratch = Scratch::with(&[("a.obj", mixed)]);
    let (found, told) = records(&scratch, "a.obj");
    assert_eq!(senders(&found), ["outer", "inner", "inner (back)"]);
    assert!(told.contains("both sides of inner") && told.contains("wound"), "{told}");
    // A room inside out: its fronts see nothing.
    let cube = fs::read_to_string(data("cube_inside")).unwrap();
    let turn = |line: &str| match line.strip_prefix("f ") {
        Some(corners) => format!("f {}", corners.split(' ').rev().collect::<Vec<_>>().join(" ")),
        None => line.to_owned(),
    };
    scratch.write("b.obj", cube.lines().map(turn).collect::<Vec<_>>().join("\n"));
    let (found, told) = records(&scratch, "b.obj");
    assert_eq!(senders(&found).len(), 12);
    assert!(told.contains("fronts see nothing"), "{told}");
    let seen: f64 = found
        .iter()
        .filter(|record| record["from"] == "bottom (back)" && record["to"].ends_with("(back)"))
        .map(|record| record["form_factor"].parse::<f64>().unwrap())
        .sum();
    assert!((seen - 1.0).abs() < 1e-9, "{seen}");
}

#[test]
fn plan_and_check_need_no_lamp() {
    for name in ["cube_inside", "far_small", "raystrack_canyon"] {
        let scratch = Scratch::new();
        let file = data(name);
        let plan = radiosity(&scratch, &format!("plan {} --json --patches 500", file.display()));
        let told = String::from_utf8(plan.stderr).unwrap();
        assert!(plan.status.success() && told.contains("no light at all"), "{name}: {told}");
        let plan: Value = serde_json::from_slice(&plan.stdout).unwrap();
        assert!(plan["patches"].as_u64().unwrap() > 100, "{name}");
        let check = radiosity(&scratch, &format!("check {} --json --patches 200", file.display()));
        let told = String::from_utf8(check.stderr).unwrap();
        assert!(check.status.success(), "{name}: {told}");
        let check: Value = serde_json::from_slice(&check.stdout).unwrap();
        let findings = check["findings"].as_array().unwrap();
        assert!(findings.iter().any(|finding| finding["name"] == "closure"), "{name}: {findings:?}");
        // Solving still does.
        let solve = radiosity(&scratch, &format!("solve {}", file.display()));
        assert_eq!(solve.status.code(), Some(1));
        assert!(String::from_utf8(solve.stderr).unwrap().contains("no light at all"));
    }
}
