//! What tests of pictures and meshes look at.

use glam::DVec3;
use nalgebra::DMatrix;

use crate::patches::{PatchSize, Patches, Reach, Tessellation};
use crate::scene::{Face, FaceState, Material, Scene, SceneParts};
use crate::trace::Tracer;

/// A scene of triangles (three vertices each) with a material each.
pub(crate) fn triangles(corners: &[[[f64; 3]; 3]], material_of: &[u32], materials: Vec<Material>) -> Scene {
    let face = |k: u32| Face {
        vertices: [3 * k, 3 * k + 1, 3 * k + 2],
        normals: None,
        material: material_of[k as usize],
        object: 0,
        state: FaceState::Kept,
    };
    let parts = SceneParts {
        name: "test".into(),
        vertices: corners.iter().flatten().copied().map(DVec3::from).collect(),
        faces: (0..corners.len() as u32).map(face).collect(),
        materials,
        objects: vec!["object".into()],
        ..SceneParts::default()
    };
    Scene::new(parts).expect("a valid test scene")
}

/// Two triangles for the parallelogram from `p` along `u` and `v`.
pub(crate) fn quad(p: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [[[f64; 3]; 3]; 2] {
    let add = |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let far = add(add(p, u), v);
    [[p, add(p, u), far], [p, far, add(p, v)]]
}

/// The box [0, 1]³ seen from inside, all of one material.
pub(crate) fn room(material: Material) -> Scene {
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let o = [0.0; 3];
    let walls = [quad(o, z, x), quad(o, x, y), quad(o, y, z), quad(y, x, z), quad(z, y, x), quad(x, z, y)];
    triangles(&walls.concat(), &[0; 12], vec![material])
}

/// Linear elements with these values at the corners of every patch, in the first `channels`.
pub(crate) fn by_corners(
    patches: &Patches,
    channels: usize,
    value: impl Fn(usize, DVec3) -> DVec3,
) -> DMatrix<f64> {
    let corner = |k: usize| patches.point(patches.place(k / 3).face, patches.corners(k / 3)[k % 3]);
    DMatrix::from_fn(3 * patches.len(), channels, |k, c| value(k / 3, corner(k))[c])
}

/// Cuts for legs up to `edge` metres.
pub(crate) fn cut<'s>(tracer: &Tracer<'s>, edge: f64, reach: Reach) -> Patches<'s> {
    let options = Tessellation { size: PatchSize::Edge(edge), reach, ..Default::default() };
    Patches::new(tracer, &options).expect("a valid patch size")
}
