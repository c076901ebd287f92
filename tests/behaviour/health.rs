//! What `check` finds: each finding is good on a sound scene, and not on one that is broken in just that way.

use std::path::Path;
use std::process::Output;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use radiosity::measure::{Finding, Grade, mesh_health, operator_health};
use radiosity::patches::{PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Face, FaceState, Material, Scene, SceneParts};
use radiosity::trace::Tracer;
use radiosity::transport::{Exchange, FormFactors, Storage, TraceOptions};
use serde_json::Value;

use crate::scenes::{Quad, flipped, quads, room};
use crate::scratch::{Scratch, names};

/// The operator's findings.
const OPERATOR: [&str; 5] = ["closure", "reciprocity", "row sums", "‖K‖∞", "condition"];

/// All findings about a scene.
fn check(scene: &Scene) -> Vec<Finding> {
    let tracer = Tracer::new(scene);
    let reach = if scene.require_light().is_ok() { Reach::Light } else { Reach::Everything };
    let cut = Tessellation { size: PatchSize::Count(300), reach, ..Default::default() };
    let mut patches = Patches::new(&tracer, &cut).unwrap();
    let mut findings = mesh_health(&tracer, &patches, 0);
    if !patches.is_empty() {
        let options = TraceOptions { rays: Some(128), ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        findings.extend(operator_health(&factors, &patches, Progress::default()).unwrap());
    }
    findings
}

fn find<'f>(findings: &'f [Finding], name: &str) -> &'f Finding {
    findings.iter().find(|f| f.name == name).unwrap_or_else(|| panic!("no finding {name}: {findings:?}"))
}

/// The finding of this name about a scene, which must be judged like this and say what to do unless it is
/// good.
#[track_caller]
fn judged(scene: &Scene, name: &str, verdict: Grade) -> Finding {
    among(&check(scene), name, verdict)
}

/// The same where nothing else may be bad.
#[track_caller]
fn only(scene: &Scene, name: &str, verdict: Grade) -> Finding {
    let findings = check(scene);
    let others: Vec<_> = findings.iter().filter(|f| f.name != name && f.verdict == Grade::Bad).collect();
    assert!(others.is_empty(), "{others:#?}");
    among(&findings, name, verdict)
}

#[track_caller]
fn among(findings: &[Finding], name: &str, verdict: Grade) -> Finding {
    let finding = find(findings, name);
    assert_eq!(finding.verdict, verdict, "{findings:#?}");
    assert_eq!(finding.remedy.is_some(), verdict != Grade::Good, "{finding:?}");
    finding.clone()
}

fn materials() -> Vec<Material> {
    vec![Material::diffuse("wall", &[0.5]), Material::lamp("lamp", &[0.5], &[1.0])]
}

/// Material 0 on walls, 1 on lamps.
fn scene(walls: &[Quad], lamps: &[Quad]) -> Scene {
    let with = |quads: &[Quad], material: u32| quads.iter().map(|&q| (q, material)).collect::<Vec<_>>();
    quads(&[with(walls, 0), with(lamps, 1)].concat(), materials())
}

/// A closed room of which the last wall glows, each wall moved by `change`.
fn closed_room(change: impl Fn(usize, Quad) -> Quad) -> Scene {
    let mut walls = room([0.0; 3], [1.0, 1.2, 1.1]);
    walls.iter_mut().enumerate().for_each(|(k, wall)| *wall = change(k, *wall));
    scene(&walls[..5], &walls[5..])
}

fn shifted(quad: Quad, by: [f64; 3]) -> Quad {
    quad.map(|p| [0, 1, 2].map(|k| p[k] + by[k]))
}

/// A room with a square lamp below its ceiling that shines down from this height.
fn room_with_lamp(height: f64) -> (Vec<Quad>, Quad) {
    let at = |x: f64, z: f64| [x, height, z];
    (room([0.0; 3], [1.0; 3]).to_vec(), [at(0.4, 0.4), at(0.6, 0.4), at(0.6, 0.6), at(0.4, 0.6)])
}

/// A scene of triangles; each with its material.
fn triangles(faces: &[([[f64; 3]; 3], u32)]) -> Scene {
    let mut parts = SceneParts {
        name: "triangles".into(),
        materials: materials(),
        objects: vec!["all".into()],
        ..Default::default()
    };
    for (corners, material) in faces {
        let first = parts.vertices.len() as u32;
        parts.vertices.extend(corners.map(DVec3::from));
        let vertices = [first, first + 1, first + 2];
        parts.faces.push(Face {
            vertices,
            normals: None,
            material: *material,
            object: 0,
            state: FaceState::Kept,
        });
    }
    Scene::new(parts).unwrap()
}

#[test]
fn a_sound_closed_room_is_good_in_every_way() {
    let findings = check(&closed_room(|_, wall| wall));
    let bad: Vec<_> = findings.iter().filter(|f| f.verdict != Grade::Good || f.remedy.is_some()).collect();
    assert!(bad.is_empty(), "{bad:#?}");
    assert_eq!(find(&findings, "leaks").value, 0.0);
    assert_eq!(find(&findings, "reciprocity").value, 0.0);
    assert!(OPERATOR.iter().all(|name| find(&findings, name).value.is_finite()));
}

#[test]
fn the_meshes_of_this_project_have_nothing_bad() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes");
    for name in names(&folder).iter().filter(|name| name.ends_with(".obj")) {
        let findings = check(&Scene::load(folder.join(name)).unwrap());
        let wrong: Vec<_> = findings.iter().filter(|f| f.verdict > Grade::Note).collect();
        assert!(wrong.is_empty(), "{name}: {wrong:#?}");
        assert_eq!(find(&findings, "lamps").verdict, Grade::Good, "{name}");
        assert_eq!(find(&findings, "leaks").verdict, Grade::Good, "{name}");
    }
}

#[test]
fn a_ceiling_that_does_not_reach_the_walls_leaks() {
    let cracked = closed_room(|k, wall| if k == 4 { shifted(wall, [0.0, 0.005, 0.0]) } else { wall });
    let leaks = only(&cracked, "leaks", Grade::Bad);
    assert!(leaks.value > 1e-4 && leaks.value < 0.01, "{leaks:?}");
    assert!(!leaks.faces.is_empty() && leaks.faces.len() <= Finding::MOST_FACES);
    let cracks = judged(&cracked, "cracks", Grade::Note);
    assert!((cracks.value - 0.005).abs() < 1e-9, "{cracks:?}");
    assert_eq!(cracks.count, Some(8), "four edges on either side");
}

#[test]
fn a_leak_is_found_where_the_light_that_escapes_meets_an_outside() {
    let walls = room([0.0; 3], [1.0; 3]);
    let mut walls: Vec<Quad> = walls
        .iter()
        .enumerate()
        .map(|(k, &w)| if k == 3 { shifted(w, [0.005, 0.0, 0.0]) } else { w })
        .collect();
    let ground = [[-3.0, -0.1, -3.0], [-3.0, -0.1, 3.0], [3.0, -0.1, 3.0], [3.0, -0.1, -3.0]];
    let lamp = walls.remove(5);
    walls.push(ground);
    let leaks = judged(&scene(&walls, &[lamp]), "leaks", Grade::Bad);
    assert!(
        !leaks.faces.contains(&10) && !leaks.faces.contains(&11),
        "the ground is not at fault: {leaks:?}"
    );
}

#[test]
fn vertices_off_by_rounding_are_cracks_but_no_leak() {
    let off = closed_room(|k, wall| if k == 4 { shifted(wall, [0.0, 1e-8, 0.0]) } else { wall });
    judged(&off, "cracks", Grade::Note);
    judged(&off, "leaks", Grade::Good);
    judged(&off, "open edges", Grade::Note);
}

#[test]
fn windows_are_no_cracks_and_open_scenes_do_not_leak() {
    let mut walls = room([0.0; 3], [1.0; 3]).to_vec();
    let lamp = walls.pop().unwrap();
    let back = walls.remove(3);
    // The wall x = 1 around a window.
    let piece = |z: [f64; 2], y: [f64; 2]| {
        [[1.0, y[0], z[0]], [1.0, y[0], z[1]], [1.0, y[1], z[1]], [1.0, y[1], z[0]]]
    };
    assert_eq!(back, piece([0.0, 1.0], [0.0, 1.0]));
    let around = [
        piece([0.0, 1.0], [0.0, 0.3]),
        piece([0.0, 1.0], [0.7, 1.0]),
        piece([0.0, 0.3], [0.3, 0.7]),
        piece([0.7, 1.0], [0.3, 0.7]),
    ];
    let with_window = scene(&[walls.clone(), around.to_vec()].concat(), &[lamp]);
    let leaks = only(&with_window, "leaks", Grade::Note);
    assert!(leaks.remedy.is_some_and(|remedy| remedy.contains("window")));
    judged(&with_window, "cracks", Grade::Good);
    let open = scene(&walls, &[lamp]);
    let leaks = only(&open, "leaks", Grade::Good);
    assert!(leaks.value > 0.1, "{leaks:?}");
    let edges = judged(&open, "open edges", Grade::Note);
    assert_eq!((edges.value, edges.faces.len()), (4.0, 1), "one rim of four edges");
}

#[test]
fn ribbons_are_no_cracks() {
    let (walls, lamp) = room_with_lamp(0.9);
    let ribbon = [[0.1, 0.1, 0.5], [0.9, 0.1, 0.5], [0.9, 0.1, 0.503], [0.1, 0.1, 0.503]];
    judged(&scene(&[walls, vec![ribbon]].concat(), &[lamp]), "cracks", Grade::Good);
}

#[test]
fn a_flipped_wall_is_noted_with_its_faces() {
    let turned = closed_room(|k, wall| if k == 1 { flipped(wall) } else { wall });
    let winding = only(&turned, "winding", Grade::Note);
    assert_eq!((winding.value, winding.count, winding.faces), (2.0, Some(4), vec![2, 3]));
}

#[test]
fn a_flipped_lamp_is_bad() {
    let floor = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let (_, lamp) = room_with_lamp(1.0);
    only(&scene(&[floor], &[lamp]), "lamps", Grade::Good);
    let found = only(&scene(&[floor], &[flipped(lamp)]), "lamps", Grade::Bad);
    assert_eq!((found.value, found.faces), (2.0, vec![2, 3]));
    assert!(found.remedy.is_some_and(|remedy| remedy.contains("flip")));
}

#[test]
fn a_lamp_that_lights_the_ceiling_it_hangs_from_is_noted() {
    let (walls, lamp) = room_with_lamp(0.995);
    judged(&scene(&walls, &[lamp]), "lamps", Grade::Good);
    judged(&scene(&walls, &[flipped(lamp)]), "lamps", Grade::Note);
    let (walls, uplight) = room_with_lamp(0.7);
    judged(&scene(&walls, &[flipped(uplight)]), "lamps", Grade::Good);
}

#[test]
fn a_bulb_turned_inside_out_is_bad_and_a_furnace_is_not() {
    let walls = room([0.0; 3], [1.0; 3]);
    let bulb = room([0.4; 3], [0.6; 3]);
    only(&scene(&walls, &bulb.map(flipped)), "lamps", Grade::Good);
    let found = only(&scene(&walls, &bulb), "lamps", Grade::Bad);
    assert_eq!((found.value, found.faces.len()), (12.0, 10), "at most ten are named");
    only(&scene(&[], &walls), "lamps", Grade::Good);
}

#[test]
fn a_lamp_of_which_one_half_is_flipped_is_bad() {
    let (walls, lamp) = room_with_lamp(0.5);
    let [a, b, c, d] = lamp;
    let wall_faces = walls.iter().flat_map(|&[a, b, c, d]| [([a, b, c], 0), ([a, c, d], 0)]);
    let with_lamp = |halves: [[[f64; 3]; 3]; 2]| {
        triangles(&wall_faces.clone().chain(halves.map(|half| (half, 1))).collect::<Vec<_>>())
    };
    judged(&with_lamp([[a, b, c], [a, c, d]]), "lamps", Grade::Good);
    judged(&with_lamp([[a, b, c], [a, d, c]]), "lamps", Grade::Bad);
}

#[test]
fn a_scene_without_a_lamp_is_checked_and_told_so() {
    let dark = scene(&room([0.0; 3], [1.0; 3]), &[]);
    only(&dark, "lamps", Grade::Note);
    let findings = check(&dark);
    OPERATOR.iter().for_each(|name| assert_eq!(find(&findings, name).verdict, Grade::Good));
    // Nothing sees anything: there is no operator to look at.
    let plate = scene(&room([0.0; 3], [1.0; 3])[..1], &[]);
    assert!(check(&plate).iter().all(|f| f.verdict <= Grade::Note && f.name != "closure"));
}

#[test]
fn slivers_are_noted_and_needles_bad() {
    let with = |width: f64| {
        let (walls, lamp) = room_with_lamp(0.9);
        let thin = [[0.1, 0.5, 0.5], [0.9, 0.5, 0.5], [0.9, 0.5, 0.5 + width], [0.1, 0.5, 0.5 + width]];
        scene(&[walls, vec![thin]].concat(), &[lamp])
    };
    judged(&with(0.1), "slivers", Grade::Good);
    let slivers = only(&with(1e-4), "slivers", Grade::Note);
    assert!((slivers.value / 8e3 - 1.0).abs() < 1e-3 && slivers.count == Some(2), "{slivers:?}");
    assert_eq!(slivers.faces, [12, 13]);
    only(&with(1e-8), "slivers", Grade::Bad);
}

#[test]
fn zero_area_faces_and_duplicates_are_noted() {
    let walls = room([0.0; 3], [1.0; 3]);
    let mut faces: Vec<_> = walls.iter().flat_map(|&[a, b, c, d]| [([a, b, c], 0), ([a, c, d], 0)]).collect();
    faces[11].1 = 1;
    faces.push(([[0.1; 3], [0.5; 3], [0.9; 3]], 0));
    faces.push(faces[2]);
    let both = triangles(&faces);
    let flat = only(&both, "zero-area faces", Grade::Note);
    assert_eq!((flat.value, flat.faces), (1.0, vec![12]));
    let twice = only(&both, "duplicate faces", Grade::Note);
    assert_eq!((twice.value, twice.faces), (1.0, vec![13]));
    assert_eq!(judged(&both, "open edges", Grade::Good).value, 0.0, "dropped faces open and close nothing");
}

#[test]
fn light_lost_with_a_duplicate_is_bad() {
    let walls = room([0.0; 3], [1.0; 3]);
    let lamp = room([0.0; 3], [1.0; 3])[4];
    let shadowed = quads(&[(walls[5], 1), (walls[4], 0), (lamp, 1)], materials());
    let found = judged(&shadowed, "duplicate faces", Grade::Bad);
    assert_eq!(found.faces, [4, 5]);
    // Two lamps back to back both shine; the same lamp twice shines once.
    let [a, b, c, d] = lamp;
    let sides = [([a, b, c], 1), ([a, c, d], 1), ([a, c, b], 1), (walls[0][..3].try_into().unwrap(), 0)];
    assert_eq!(judged(&triangles(&sides), "duplicate faces", Grade::Good).value, 0.0);
    judged(&triangles(&[sides[0], sides[0], sides[3]]), "duplicate faces", Grade::Note);
}

#[test]
fn walls_that_branch_are_noted_as_non_manifold() {
    let (mut walls, lamp) = room_with_lamp(0.9);
    // A fin from one corner of the room into its middle.
    walls.push([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 1.0, 0.3], [0.3, 0.0, 0.3]]);
    let found = only(&scene(&walls, &[lamp]), "non-manifold edges", Grade::Note);
    assert_eq!(found.value, 1.0);
}

#[test]
fn corners_along_an_edge_are_t_junctions() {
    let mut walls = room([0.0; 3], [1.0; 3]).to_vec();
    let lamp = walls.pop().unwrap();
    judged(&scene(&walls, &[lamp]), "T-junctions", Grade::Good);
    // The floor in two halves; each of two walls has a corner of theirs along its lower edge.
    let [a, b, c, d] = walls.remove(1);
    let middle = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
    walls.extend([[a, middle(a, b), middle(d, c), d], [middle(a, b), b, c, middle(d, c)]]);
    let split = scene(&walls, &[lamp]);
    assert_eq!(only(&split, "T-junctions", Grade::Note).value, 2.0);
    judged(&split, "leaks", Grade::Good);
    judged(&split, "cracks", Grade::Good);
}

#[test]
fn a_room_in_millimetres_is_noted() {
    let walls = room([0.0; 3], [4000.0; 3]);
    let size = only(&scene(&walls[..5], &walls[5..]), "size", Grade::Note);
    assert!(size.value == 4000.0 && size.remedy.is_some_and(|remedy| remedy.contains("unit")));
}

#[test]
fn a_closed_room_that_absorbs_nothing_has_no_condition_and_one_that_absorbs_little_a_bad_one() {
    let with = |reflectance: f64| {
        let walls = room([0.0; 3], [1.0; 3]).map(|wall| (wall, 1));
        let materials =
            vec![Material::diffuse("grey", &[0.5]), Material::lamp("snow", &[reflectance], &[1.0])];
        quads(&walls, materials)
    };
    let trapped = only(&with(1.0), "condition", Grade::Bad);
    assert!(trapped.value.is_infinite());
    assert_eq!(serde_json::to_value(&trapped).unwrap()["value"], Value::Null);
    assert!(trapped.remedy.is_some_and(|remedy| remedy.contains("snow")));
    only(&with(0.9), "condition", Grade::Good);
    let fair = only(&with(0.999), "condition", Grade::Fair);
    assert!((1e3..3e3).contains(&fair.value) && fair.remedy.is_some_and(|remedy| remedy.contains("snow")));
    only(&with(0.9999999), "condition", Grade::Bad);
}

#[test]
fn damaged_exchange_areas_are_bad() {
    let facing = triangles(&[
        ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 1),
        ([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]], 0),
    ]);
    let tracer = Tracer::new(&facing);
    let cut = Tessellation { size: PatchSize::Edge(10.0), ..Default::default() };
    let patches = Patches::new(&tracer, &cut).unwrap();
    assert_eq!(patches.len(), 2);
    let health = |entries: [f32; 2], areas: [f64; 2], escape: f64| {
        let storage = Storage::Dense(DMatrix::from_column_slice(2, 2, &[0.0, entries[0], entries[1], 0.0]));
        let (escape, areas) = (DVector::repeat(2, escape), DVector::from_row_slice(&areas));
        let exchange = Exchange::new(storage, escape, areas, &[false; 2], Progress::default()).unwrap();
        operator_health(&FormFactors::from(exchange), &patches, Progress::default()).unwrap()
    };
    let sound = health([0.5, 0.5], [1.0, 2.0], 0.5);
    assert!(sound.iter().all(|f| f.verdict == Grade::Good), "{sound:#?}");
    // What the small one sends can't be all that the large one gets, if nothing escapes.
    let unclosed = health([1.0, 1.0], [1.0, 2.0], 0.0);
    let closure = find(&unclosed, "closure");
    assert!(closure.verdict == Grade::Bad && closure.value > 0.1 && !closure.faces.is_empty(), "{closure:?}");
    let lopsided = health([0.5, 0.4], [1.0, 1.0], 0.5);
    let reciprocity = find(&lopsided, "reciprocity");
    assert!(reciprocity.verdict == Grade::Bad && reciprocity.value > 0.01, "{reciprocity:?}");
}

/// A closed cube with a lamp for a ceiling, whose ceiling is lifted by this much.
fn cube(lifted: f64) -> Scratch {
    let high = 1.0 + lifted;
    let obj = format!(
        "mtllib cube.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n\
         v 0 {high} 0\nv 1 {high} 0\nv 1 {high} 1\nv 0 {high} 1\nusemtl wall\n\
         f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nusemtl lamp\nf 12 11 10 9\n"
    );
    let mtl = "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0.5 0.5 0.5\nKe 1 1 1\n";
    // The ceiling's front must face down, and the floor's up.
    Scratch::with(&[("cube.obj", obj.replace("f 12 11 10 9", "f 9 10 11 12")), ("cube.mtl", mtl.into())])
}

fn run(scratch: &Scratch, arguments: &str) -> (Option<i32>, String, String) {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("radiosity");
    let Output { status, stdout, stderr } =
        command.current_dir(scratch.folder()).args(arguments.split_whitespace()).output().unwrap();
    (status.code(), String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap())
}

#[test]
fn the_command_prints_a_table_answers_with_its_status_and_writes_nothing() {
    for (lifted, status, last) in [(0.0, 0, "good"), (0.005, 1, "bad: leaks")] {
        let scratch = cube(lifted);
        let (code, out, err) = run(&scratch, "check cube.obj --patches 200");
        assert_eq!((code, err.as_str()), (Some(status), ""), "{out}");
        for name in ["open edges", "winding", "lamps", "leaks"].iter().chain(&OPERATOR) {
            let line = out.lines().find(|line| line.trim_start().starts_with(name));
            assert!(
                line.is_some_and(|line| ["good", "note", "bad"].iter().any(|v| line.contains(v))),
                "{name}: {out}"
            );
        }
        assert_eq!(out.lines().last(), Some(last), "{out}");
        assert_eq!(names(scratch.folder()), ["cube.mtl", "cube.obj"]);
        assert_eq!(
            run(&scratch, "check cube.obj --patches 200 --quiet"),
            (Some(status), "".into(), "".into())
        );
    }
}

#[test]
fn the_command_prints_json_alone() {
    for (lifted, status, verdict) in [(0.0, 0, "good"), (0.005, 1, "bad")] {
        let (code, out, _) = run(&cube(lifted), "check cube.obj --patches 200 --json");
        let all: Value = serde_json::from_str(&out).unwrap();
        assert_eq!((code, &all["scene"], &all["verdict"]), (Some(status), &"cube".into(), &verdict.into()));
        let findings = all["findings"].as_array().unwrap();
        assert_eq!(findings.len(), 19);
        for finding in findings {
            assert!(finding["name"].is_string() && finding["value"].is_number(), "{finding}");
            assert!(finding["where"].as_array().is_some_and(|faces| faces.len() <= 10), "{finding}");
            assert_eq!(finding["remedy"].is_null(), finding["verdict"] == "good", "{finding}");
        }
    }
}

#[test]
fn the_command_needs_no_light_but_a_scene() {
    let scratch = cube(0.0);
    scratch.write("cube.mtl", "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0.5 0.5 0.5\n");
    let (code, out, _) = run(&scratch, "check cube.obj --patches 200");
    assert_eq!(code, Some(0));
    assert!(out.contains("nothing emits"), "{out}");
    let (code, out, err) = run(&scratch, "check nowhere.obj");
    assert_eq!((code, out.as_str()), (Some(1), ""));
    assert!(err.starts_with("error: ") && err.contains("nowhere.obj"), "{err}");
    assert_eq!(run(&scratch, "check cube.obj --out somewhere").0, Some(2));
}
