//! Small scenes, made on the spot, the scenes of the project, and what many tests do with either.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::reference::{Budget, PathOptions, ReferenceRow};
use radiosity::scene::{Face, FaceState, Light, Material, Scene, SceneParts, Sky, SkyKind};
use radiosity::solve::{self, CgOptions, DirectOptions, NeumannOptions, Solution};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, StorageKind, TraceOptions, Transport};

use crate::scratch::names;

/// The corners of a quadrilateral, counter-clockwise seen from the front.
pub type Quad = [[f64; 3]; 4];

pub const BASES: [Basis; 2] = [Basis::Constant, Basis::Linear];
pub const STORAGES: [StorageKind; 2] = [StorageKind::Dense, StorageKind::Sparse];

/// Every way to hold every kind of elements.
pub fn kinds() -> impl Iterator<Item = (Basis, StorageKind)> {
    BASES.into_iter().flat_map(|basis| STORAGES.map(|storage| (basis, storage)))
}

/// A scene by its path in the project.
pub fn load(path: &str) -> Scene {
    Scene::load(format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// What another renderer found in a scene of `tests/data`.
pub fn reference(name: &str) -> Vec<ReferenceRow> {
    ReferenceRow::read(format!("{}/tests/data/{name}.csv", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// One of the example scenes.
pub fn mesh(name: &str) -> Scene {
    load(&format!("meshes/{name}.obj"))
}

/// The names of all example scenes.
pub fn meshes() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes");
    names(&folder).iter().filter_map(|name| name.strip_suffix(".obj")).map(str::to_owned).collect()
}

/// Quadrilaterals by their corners, counter-clockwise seen from the front, each an object of its own with the
/// material of the given index.
pub fn quads(quads: &[(Quad, u32)], materials: Vec<Material>) -> Scene {
    lit_quads(quads, materials, Vec::new(), None)
}

/// The same with lights without area and a sky.
pub fn lit_quads(
    quads: &[(Quad, u32)],
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

/// What a scene is made of; without lights, sky and camera.
pub fn parts_of(scene: &Scene) -> SceneParts {
    SceneParts {
        name: scene.name().into(),
        vertices: scene.vertices().to_vec(),
        faces: scene.faces().to_vec(),
        materials: scene.materials().to_vec(),
        objects: scene.objects().to_vec(),
        ..Default::default()
    }
}

/// The same with every vertex where `f` puts it.
pub fn moved(scene: &Scene, f: impl Fn(DVec3) -> DVec3) -> Scene {
    let vertices = scene.vertices().iter().map(|&p| f(p)).collect();
    Scene::new(SceneParts { vertices, ..parts_of(scene) }).unwrap()
}

/// Adds a triangle with vertices of its own.
pub fn push_triangle(parts: &mut SceneParts, corners: [DVec3; 3], material: u32, object: u32) {
    let first = parts.vertices.len() as u32;
    parts.vertices.extend(corners);
    let vertices = [first, first + 1, first + 2];
    parts.faces.push(Face { vertices, normals: None, material, object, state: FaceState::Kept });
}

/// The box from `low` to `high` seen from inside: quads x, y, z at the low end, then at the high end.
pub fn room(low: [f64; 3], high: [f64; 3]) -> [Quad; 6] {
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
pub fn flipped([a, b, c, d]: Quad) -> Quad {
    [a, d, c, b]
}

/// A square of this half-width at this height, facing up.
pub fn square(y: f64, half: f64) -> Quad {
    [[-half, y, -half], [-half, y, half], [half, y, half], [half, y, -half]]
}

/// The unit square at this height between the axes, facing up.
pub fn unit_square(y: f64) -> Quad {
    [[0.0, y, 0.0], [0.0, y, 1.0], [1.0, y, 1.0], [1.0, y, 0.0]]
}

/// One material of this reflectance.
pub fn grey(reflectance: f64) -> Vec<Material> {
    vec![Material::diffuse("grey", &[reflectance])]
}

/// A light without area that sends the same everywhere, W·sr⁻¹ by channel.
pub fn point(position: impl Into<DVec3>, intensity: &[f64]) -> Light {
    Light::Point { position: position.into(), intensity: intensity.to_vec() }
}

/// A sun that shines along `direction`, as wide as `diameter` degrees.
pub fn sun(direction: [f64; 3], irradiance: f64, diameter: f64) -> Light {
    Light::Sun { direction: DVec3::from(direction).normalize(), irradiance: vec![irradiance], diameter }
}

/// A sky over black ground, up along y.
pub fn sky(kind: SkyKind, zenith: f64) -> Sky {
    Sky { kind, up: DVec3::Y, zenith: vec![zenith], ground: 0.0 }
}

/// The patches of a scene that light can reach.
pub fn cut<'s>(tracer: &Tracer<'s>, size: PatchSize) -> Patches<'s> {
    Patches::new(tracer, &Tessellation { size, ..Default::default() }).unwrap()
}

/// The same into about this many patches.
pub fn cut_into<'s>(tracer: &Tracer<'s>, count: usize) -> Patches<'s> {
    cut(tracer, PatchSize::Count(count))
}

/// A scene's patches and the form factors between them.
pub fn traced<'s>(scene: &'s Scene, size: PatchSize, options: &TraceOptions) -> (Patches<'s>, FormFactors) {
    let tracer = Tracer::new(scene);
    let mut patches = cut(&tracer, size);
    let factors = FormFactors::trace(&tracer, &mut patches, options).unwrap();
    (patches, factors)
}

/// The same by this many rays per patch for elements of one kind.
pub fn factors_of<'s>(
    scene: &'s Scene,
    size: PatchSize,
    rays: u32,
    (basis, storage): (Basis, StorageKind),
) -> (Patches<'s>, FormFactors) {
    traced(scene, size, &TraceOptions { rays: Some(rays), basis, storage, ..Default::default() })
}

/// Irradiance under the scene's lamps, by coefficients.
pub fn irradiance(patches: &Patches, factors: &FormFactors) -> DMatrix<f64> {
    let k = Transport::of(factors, patches).unwrap();
    let e = factors.basis().coefficients_of(&patches.emitted_radiance());
    solve::conjugate_gradients(&k, &e, &CgOptions::default()).unwrap().irradiance
}

/// As many light paths.
pub fn paths(count: u64) -> PathOptions<'static> {
    PathOptions { budget: Budget { paths: Some(count), ..Default::default() }, ..Default::default() }
}

/// What comes of it on so many threads.
pub fn on_threads<T: Send>(threads: usize, f: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(f)
}

/// The direct solver's answer.
pub fn direct(k: &Transport, e: &DMatrix<f64>) -> Solution {
    solve::direct(k, &DirectOptions::default()).unwrap().solve(e)
}

/// Every solver's answer, to this residual or better.
pub fn every_solver_to(tolerance: f64, k: &Transport, e: &DMatrix<f64>) -> [Solution; 3] {
    let cg = CgOptions { tolerance, ..Default::default() };
    let neumann = NeumannOptions { tolerance, ..Default::default() };
    [
        direct(k, e),
        solve::conjugate_gradients(k, e, &cg).unwrap(),
        solve::neumann(k, e, &neumann).unwrap().solution,
    ]
}

/// The largest |a − b| over the largest |b|.
pub fn difference(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    (a - b).amax() / b.amax()
}

/// F between parallel unit squares at this distance (Howell C-11).
pub fn facing(distance: f64) -> f64 {
    let x: f64 = 1.0 / distance;
    let root = (1.0 + x * x).sqrt();
    let logarithm = ((1.0 + x * x) / (1.0 + 2.0 * x * x).sqrt()).ln();
    2.0 / (PI * x * x) * (logarithm + 2.0 * x * root * (x / root).atan() - 2.0 * x * x.atan())
}
