//! What `check` finds: each finding is good on a sound scene, and not on one that is broken in just that way.

mod command; // table, JSON, status
mod lamps; // lamps that face the wrong way, or are not there
mod leaks; // leaks, cracks, open edges
mod mesh; // winding, slivers, duplicates, edges, size
mod operator; // condition, closure, reciprocity
mod sound; // nothing bad where nothing is broken

use glam::DVec3;
use radiosity::measure::{Finding, Grade, mesh_health, operator_health};
use radiosity::patches::{PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Material, Scene, SceneParts};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions};

use crate::scenes::{Quad, push_triangle, quads, room};

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
        push_triangle(&mut parts, corners.map(DVec3::from), *material, 0);
    }
    Scene::new(parts).unwrap()
}
