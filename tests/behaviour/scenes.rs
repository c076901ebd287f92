//! Small scenes, made on the spot.

use glam::DVec3;
use radiosity::scene::{Face, FaceState, Light, Material, Scene, SceneParts, Sky};

/// Quadrilaterals by their corners, counter-clockwise seen from the front, each an object of its own with the
/// material of the given index.
pub fn quads(quads: &[([[f64; 3]; 4], u32)], materials: Vec<Material>) -> Scene {
    lit_quads(quads, materials, Vec::new(), None)
}

/// The same with lights without area and a sky.
pub fn lit_quads(
    quads: &[([[f64; 3]; 4], u32)],
    materials: Vec<Material>,
    lights: Vec<Light>,
    sky: Option<Sky>,
) -> Scene {
    let mut parts = SceneParts { name: "quads".into(), materials, lights, sky, ..Default::default() };
    for (object, (corners, material)) in quads.iter().enumerate() {
        let first = parts.vertices.len() as u32;
        parts.vertices.extend(corners.map(DVec3::from));
        parts.objects.push(format!("quad {object}"));
        for k in [1, 2] {
            parts.faces.push(Face {
                vertices: [first, first + k, first + k + 1],
                normals: None,
                material: *material,
                object: object as u32,
                state: FaceState::Kept,
            });
        }
    }
    Scene::new(parts).unwrap()
}

/// The box from `low` to `high` seen from inside: quads x, y, z at the low end, then at the high end.
pub fn room(low: [f64; 3], high: [f64; 3]) -> [[[f64; 3]; 4]; 6] {
    let [a, b] = [low, high];
    [
        [[a[0], a[1], a[2]], [a[0], b[1], a[2]], [a[0], b[1], b[2]], [a[0], a[1], b[2]]],
        [[a[0], a[1], a[2]], [a[0], a[1], b[2]], [b[0], a[1], b[2]], [b[0], a[1], a[2]]],
        [[a[0], a[1], a[2]], [b[0], a[1], a[2]], [b[0], b[1], a[2]], [a[0], b[1], a[2]]],
        [[b[0], a[1], a[2]], [b[0], a[1], b[2]], [b[0], b[1], b[2]], [b[0], b[1], a[2]]],
        [[a[0], b[1], a[2]], [b[0], b[1], a[2]], [b[0], b[1], b[2]], [a[0], b[1], b[2]]],
        [[a[0], a[1], b[2]], [a[0], b[1], b[2]], [b[0], b[1], b[2]], [b[0], a[1], b[2]]],
    ]
}

/// A quad's other side.
pub fn flipped([a, b, c, d]: [[f64; 3]; 4]) -> [[f64; 3]; 4] {
    [a, d, c, b]
}
