//! Lamps, lights and receivers that are where they cannot be meant to be.

use glam::DVec3;
use radiosity::measure::odd_placement;
use radiosity::scene::{Light, Material, Receiver, Scene, SceneParts, Sky, SkyKind};
use radiosity::trace::Tracer;

use crate::scenes::{Quad, flipped, lit_quads, parts_of, point, room};
use crate::scratch::Scratch;

const LAMP: Quad = [[0.4, 0.9, 0.4], [0.6, 0.9, 0.4], [0.6, 0.9, 0.6], [0.4, 0.9, 0.6]];

/// A room of a metre with a closed box in it, a lamp, and these lights and receivers.
fn scene(lamp: Quad, lights: Vec<Light>, receivers: Vec<Receiver>, sky: Option<Sky>) -> Scene {
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let mut all: Vec<(Quad, u32)> = walls.into_iter().chain([(lamp, 1)]).collect();
    all.extend(room([0.1; 3], [0.3; 3]).map(|quad| (flipped(quad), 0)));
    let materials = vec![Material::diffuse("grey", &[0.5]), Material::lamp("lamp", &[0.0], &[10.0])];
    let whole = lit_quads(&all, materials, lights, sky);
    // The box is one object.
    let mut faces = whole.faces().to_vec();
    faces.iter_mut().filter(|face| face.object >= 7).for_each(|face| face.object = 7);
    let parts = SceneParts {
        faces,
        lights: whole.lights().cloned().collect(),
        sky: whole.sky().cloned(),
        receivers,
        ..parts_of(&whole)
    };
    Scene::new(parts).unwrap()
}

fn desk(corner: [f64; 3], edges: [[f64; 3]; 2]) -> Receiver {
    Receiver::grid("desk", corner.into(), edges.map(DVec3::from), [3, 3])
}

fn odd(scene: &Scene) -> Vec<String> {
    odd_placement(&Tracer::new(scene), 0)
}

const UP: [[f64; 3]; 2] = [[0.0, 0.0, 0.2], [0.2, 0.0, 0.0]];

#[test]
fn nothing_is_said_of_what_is_where_it_should_be() {
    let lights = vec![point([0.5, 0.7, 0.5], &[1.0]), point([0.05, 0.05, 0.05], &[1.0])];
    let receivers = vec![desk([0.5, 0.4, 0.5], UP), desk([0.5, 0.4, 0.5], [UP[1], UP[0]])];
    assert_eq!(odd(&scene(LAMP, lights, receivers, None)), [""; 0]);
}

#[test]
fn a_lamp_that_faces_away_is_named_with_what_to_do() {
    // Over the room, of which its back sees the ceiling.
    let up = flipped(LAMP).map(|[x, _, z]| [x, 1.2, z]);
    let odd = odd(&scene(up, Vec::new(), Vec::new(), None));
    assert!(odd.len() == 1 && odd[0].contains("lamps (faces 12, 13)") && odd[0].contains("flip"), "{odd:?}");
}

#[test]
fn lights_and_receivers_outside_or_in_solids_are_named() {
    let says = |lights: Vec<Light>, receivers: Vec<Receiver>, wanted: &[&str]| {
        let odd = odd(&scene(LAMP, lights, receivers, None));
        assert!(odd.len() == 1 && wanted.iter().all(|word| odd[0].contains(word)), "{odd:?}");
    };
    says(
        vec![point([0.5; 3], &[1.0]), point([0.2; 3], &[1.0])],
        Vec::new(),
        &["light 2", "within object quad 7"],
    );
    let away = Light::Spot {
        position: DVec3::new(0.5, 3.0, 0.5),
        direction: DVec3::Y,
        intensity: vec![1.0],
        cone: 30.0,
        penumbra: 0.0,
    };
    says(vec![away], Vec::new(), &["light 1", "meets nothing", "unit"]);
    // Of a thousand directions none lies within a beam as narrow as this one.
    let beam = |direction: DVec3| Light::Spot {
        position: DVec3::new(0.5, 0.5, -1.0),
        direction,
        intensity: vec![1.0],
        cone: 0.01,
        penumbra: 0.0,
    };
    says(vec![beam(-DVec3::Z)], Vec::new(), &["light 1", "meets nothing"]);
    // On the walls from without, where a room has no fronts; to the same spot from within nothing is odd.
    says(vec![beam(DVec3::Z)], Vec::new(), &["light 1", "backs of faces alone", "outside"]);
    says(Vec::new(), vec![desk([0.5, -0.001, 0.5], UP)], &["receiver desk", "backs of faces alone"]);
    says(Vec::new(), vec![desk([0.5, 1000.0, 0.5], UP)], &["receiver desk", "meets nothing"]);
    says(
        Vec::new(),
        vec![desk([0.15; 3], UP.map(|edge| edge.map(|x| 0.2 * x)))],
        &["receiver desk", "within object quad 7"],
    );
}

#[test]
fn under_a_sky_a_receiver_may_see_no_surface() {
    let sky = Sky { kind: SkyKind::Constant, up: DVec3::Y, zenith: vec![1.0], ground: 0.0 };
    assert_eq!(odd(&scene(LAMP, Vec::new(), vec![desk([0.5, 3.0, 0.5], UP)], Some(sky))), [""; 0]);
}

#[test]
fn receivers_behind_planes_beside_the_scene_and_partly_in_solids_are_named() {
    let says = |receivers: Vec<Receiver>, sky: Option<Sky>, wanted: &str| {
        let odd = odd(&scene(LAMP, Vec::new(), receivers, sky));
        assert!(odd.len() == 1 && odd[0].contains(wanted), "{wanted}: {odd:?}");
    };
    let even = || Some(Sky { kind: SkyKind::Constant, up: DVec3::Y, zenith: vec![1.0], ground: 0.0 });
    // A millimetre under the floor, under a sky.
    says(vec![desk([0.6, -0.001, 0.6], UP)], even(), "lies right behind object quad 1");
    // Far beside the room.
    says(vec![desk([5.0, 0.5, 5.0], UP)], even(), "lies outside of the box around the scene");
    // A row of three points in the box, the other two over it.
    let upright = [[0.0, 0.0, 0.1], [0.0, 0.3, 0.0]];
    says(vec![desk([0.2, 0.15, 0.15], upright)], None, "(about 3 of its 9 points) lies within object quad 7");
    // Right over the roof is no fault.
    let over = vec![desk([0.5, 1.01, 0.5], UP)];
    assert_eq!(odd(&scene(LAMP, Vec::new(), over, even())), [""; 0]);
}

#[test]
fn a_scene_as_long_as_a_street_is_asked_for_its_unit() {
    let text = "v 0 0 0\nv 4000 0 0\nv 0 3000 0\nf 1 2 3\n";
    let said = |files: &[(&str, &str)]| {
        Scene::load(Scratch::with(files).path("a.obj")).unwrap().warnings().join("\n")
    };
    assert!(
        said(&[("a.obj", text)]).contains("4000 m long")
            && said(&[("a.obj", text)]).contains("unit = \"mm\"")
    );
    assert!(!said(&[("a.obj", text), ("a.toml", "unit = \"mm\"\n")]).contains("long"));
    assert!(!said(&[("a.obj", text), ("a.toml", "unit = 1.0\n")]).contains("long"));
}
