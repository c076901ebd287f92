//! Scene: what the world is, before any ray is cast.
//!
//! A [`Scene`] is a list of triangles with materials, checked on the way in: whatever holds a `Scene`
//! may rely on finite vertices, valid indices and physical materials. Read one with [`Scene::load`],
//! take the built-in [`Scene::cornell_box`], or make one from your own triangles with [`Scene::new`].

mod camera;
mod degenerate;
mod feature;
mod files;
mod grouped;
mod lifted;
mod light;
mod material;
mod photometry;
mod receiver;
mod spelled;
pub(crate) mod triangle;

use std::io::Read;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

pub use camera::Camera;
pub use feature::Feature;
pub use light::{Environment, GeneralSky, IntensityTable, Light, Sky, SkyKind, SkyShares};
pub use material::{Beyond, FaceTexture, Material, Pixels, Sheet, Surface, Texture, Textures};
pub use photometry::{EFFICACY, luminance};
pub use receiver::{Measure, Receiver};

use degenerate::drop_degenerate;
pub(crate) use lifted::distance_to;
use lifted::lift_lights;

/// No coordinate may be farther than this from the origin, metres; products of four of them are still
/// numbers.
pub(crate) const FARTHEST: f64 = 1e30;

/// Whether a point is one that a scene may have.
pub(crate) fn is_near(point: DVec3) -> bool {
    point.to_array().iter().all(|x| x.abs() <= FARTHEST)
}

/// No power, radiance or other quantity of light may be more than this, in its unit.
pub(crate) const LARGEST: f64 = 1e30;

/// No texture coordinate, and no factor of one, may be more than this: beyond it f64 no longer tells texels
/// apart.
pub(crate) const FARTHEST_ON_PICTURE: f64 = 1e12;

/// One of the two sides of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Side {
    /// The side from which the vertices run counter-clockwise; the one that emits.
    Front,
    /// The other side.
    Back,
}

impl Side {
    /// Both sides, front first.
    pub const BOTH: [Side; 2] = [Side::Front, Side::Back];

    /// The side across.
    pub fn other(self) -> Self {
        match self {
            Side::Front => Side::Back,
            Side::Back => Side::Front,
        }
    }

    /// `front` or `back`, as tables spell it.
    pub fn name(self) -> &'static str {
        match self {
            Side::Front => "front",
            Side::Back => "back",
        }
    }
}

/// Whether a face takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceState {
    /// It does.
    Kept,
    /// Dropped: its corners lie on a line or a point.
    ZeroArea,
    /// Dropped: an earlier face has the same three corners in the same winding.
    Duplicate,
    /// Left out with the feature it belongs to.
    LeftOut,
}

/// A triangle. Its number is its place in [`Scene::faces`], which is file order.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Corners, as indices into [`Scene::vertices`], counter-clockwise seen from the front.
    pub vertices: [u32; 3],
    /// Shading normals at the corners, as indices into [`Scene::normals`]; they smooth pictures only.
    pub normals: Option<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Index into [`Scene::objects`].
    pub object: u32,
    /// Whether it takes part. A dropped face keeps its number.
    pub state: FaceState,
}

/// A validated world: triangles, materials, lights, camera.
#[derive(Clone, Debug)]
pub struct Scene {
    name: String,
    vertices: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Per face, or none at all.
    texture_coordinates: Vec<Option<[DVec2; 3]>>,
    /// Per face, or none at all.
    polygons: Vec<u32>,
    faces: Vec<Face>,
    materials: Vec<Material>,
    objects: Vec<String>,
    camera: Option<Camera>,
    lights: Vec<Light>,
    sky: Option<Sky>,
    receivers: Vec<Receiver>,
    efficacy: f64,
    channels: usize,
    warnings: Vec<String>,
    inputs: Vec<PathBuf>,
    left_out: Vec<Feature>,
}

/// How to read a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Loading {
    /// Whether files that the scene names may lie outside of its folder.
    pub allow_outside: bool,
}

/// The raw parts of a [`Scene`], before they are checked.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Name, used for the output folder.
    pub name: String,
    /// Vertices, metres.
    pub vertices: Vec<DVec3>,
    /// Shading normals; may be empty.
    pub normals: Vec<DVec3>,
    /// Per face, texture coordinates of its corners where it has some; may be empty.
    pub texture_coordinates: Vec<Option<[DVec2; 3]>>,
    /// Per face, the number of the polygon that it is part of; may be empty.
    pub polygons: Vec<u32>,
    /// Triangles.
    pub faces: Vec<Face>,
    /// Materials, all with the same number of channels.
    pub materials: Vec<Material>,
    /// Object names.
    pub objects: Vec<String>,
    /// The camera the scene asks for.
    pub camera: Option<Camera>,
    /// Lights without area, with as many channels as the materials.
    pub lights: Vec<Light>,
    /// The sky around it, with as many channels as the materials.
    pub sky: Option<Sky>,
    /// Where to measure light beside the faces.
    pub receivers: Vec<Receiver>,
    /// Lumens per watt; 683 if not given.
    pub efficacy: Option<f64>,
    /// What the reader noticed and the user should know.
    pub warnings: Vec<String>,
    /// The files that were read.
    pub inputs: Vec<PathBuf>,
}

/// Why a scene could not be read or does not make sense.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file can't be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A line of a file does not say what it should.
    #[error("{}:{line}: {message}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong and what to do.
        message: String,
    },
    /// The scene has no triangle.
    #[error(
        "{name}: the scene has no faces; check that the file holds `f` lines with at least three corners"
    )]
    NoFaces {
        /// The scene.
        name: String,
    },
    /// All faces were dropped.
    #[error("{name}: every face has zero area; check the unit and the vertices")]
    NoArea {
        /// The scene.
        name: String,
    },
    /// A face refers to something that is not there, or to a vertex that is not finite.
    #[error("face {face}: {message}")]
    Face {
        /// Its number, from 0.
        face: usize,
        /// What is wrong.
        message: String,
    },
    /// A material is not physical.
    #[error("material {material}: {message}")]
    Material {
        /// Its name.
        material: String,
        /// What is wrong and what to do.
        message: String,
    },
    /// A light or the sky makes no sense.
    #[error("{light}: {message}")]
    Light {
        /// Which.
        light: String,
        /// What is wrong and what to do.
        message: String,
    },
    /// A receiver makes no sense.
    #[error("receiver {receiver}: {message}")]
    Receiver {
        /// Its name.
        receiver: String,
        /// What is wrong and what to do.
        message: String,
    },
    /// The camera can't make a picture.
    #[error(
        "camera: position and target must differ, up must not be zero, fov must lie between 0 and 180 degrees, and no number may be beyond 1e30"
    )]
    Camera,
    /// Nothing emits, so there is nothing to solve.
    #[error(
        "{name}: no light at all; give a material an emission (Ke in the MTL file, or `emission` in the scene's .toml), or add a [[light]] or a [sky] there"
    )]
    NoLight {
        /// The scene.
        name: String,
    },
}

impl Scene {
    /// Reads an OBJ file, the MTL files and pictures it names, and the `.toml` beside it if there is one.
    /// Files that lie outside of its folder are not read.
    ///
    /// # Errors
    /// Any [`SceneError`] but `NoLight`; each names the file and line, the face or the material.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::load_with(path, Loading::default())
    }

    /// The same, with options.
    ///
    /// # Errors
    /// Those of [`Scene::load`].
    pub fn load_with(path: impl AsRef<Path>, options: Loading) -> Result<Self, SceneError> {
        files::load(path.as_ref(), options)
    }

    /// Reads an OBJ text from a stream; the files it names are looked for in `folder`. There are no settings.
    ///
    /// # Errors
    /// Those of [`Scene::load`].
    pub fn read(stream: impl Read, folder: impl AsRef<Path>, options: Loading) -> Result<Self, SceneError> {
        files::read(stream, folder.as_ref(), options)
    }

    /// The Cornell box as measured at Cornell University, built into the library.
    pub fn cornell_box() -> Self {
        files::cornell_box()
    }

    /// Checks the parts and makes a scene of them.
    ///
    /// Zero-area and duplicate faces are marked as dropped and counted in a warning; where all channels of
    /// all materials and lights agree the scene keeps one channel. A light that lies on faces, within a
    /// millionth of half of the scene's longest side, is moved as far in front of them, and a warning names
    /// it.
    ///
    /// # Errors
    /// `NoFaces`, `NoArea`, `Face`, `Material`, `Light`, `Receiver` or `Camera`.
    pub fn new(parts: SceneParts) -> Result<Self, SceneError> {
        let SceneParts { name, vertices, normals, mut faces, mut materials, objects, .. } = parts;
        let SceneParts { camera, mut lights, mut sky, receivers, efficacy, mut warnings, inputs, .. } = parts;
        let SceneParts { mut texture_coordinates, polygons, .. } = parts;
        let efficacy = efficacy.unwrap_or(EFFICACY);
        if faces.is_empty() {
            return Err(SceneError::NoFaces { name });
        }
        check_faces(&faces, &vertices, &normals, materials.len(), objects.len())?;
        let mut channels = check_materials(&materials)?;
        check_lights(&lights, sky.as_ref(), channels)?;
        for receiver in &receivers {
            let error = |message| SceneError::Receiver { receiver: receiver.name.clone(), message };
            receiver.check().map_err(error)?;
        }
        let powers = || lights.iter().map(Light::power).chain(sky.as_ref().map(|sky| sky.zenith.as_slice()));
        if materials.iter().all(Material::is_grey)
            && sky.as_ref().is_none_or(Sky::is_colourless)
            && powers().all(|power| power.iter().all(|x| *x == power[0]))
        {
            channels = 1;
            materials.iter_mut().for_each(Material::keep_one_channel);
            lights.iter_mut().for_each(|light| light.power_mut().truncate(1));
            sky.iter_mut().for_each(|sky| sky.zenith.truncate(1));
        }
        if camera.is_some_and(|camera| !camera.is_valid()) {
            return Err(SceneError::Camera);
        }
        drop_degenerate(&mut faces, &vertices, &materials, &mut warnings);
        if faces.iter().all(|face| face.state != FaceState::Kept) {
            return Err(SceneError::NoArea { name });
        }
        lift_lights(&mut lights, (&faces, &vertices), &objects, &mut warnings);
        if materials.iter().any(Material::is_textured) {
            texture_coordinates.resize(faces.len(), None);
            material::warn_of_missing_coordinates(&faces, &texture_coordinates, &materials, &mut warnings);
        } else {
            texture_coordinates = Vec::new();
        }
        material::warn_of_missing_insides(&faces, &vertices, &materials, &mut warnings);
        Ok(Self {
            name,
            vertices,
            normals,
            texture_coordinates,
            polygons,
            faces,
            materials,
            objects,
            camera,
            lights,
            sky,
            receivers,
            efficacy,
            channels,
            warnings,
            inputs,
            left_out: Vec::new(),
        })
    }

    /// Name, from the file's.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All vertices, metres.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Shading normals, of any length; faces that have some refer to them.
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// All triangles, dropped ones included, in file order.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The number of the polygon that a face is part of, in file order; that of the face where nothing else
    /// is known.
    pub fn polygon_of(&self, face: usize) -> usize {
        self.polygons.get(face).map_or(face, |&polygon| polygon as usize)
    }

    /// All materials.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Object names.
    pub fn objects(&self) -> &[String] {
        &self.objects
    }

    /// The camera the scene asks for.
    pub fn camera(&self) -> Option<&Camera> {
        self.camera.as_ref()
    }

    /// Lights without area that shine.
    pub fn lights(&self) -> impl Iterator<Item = &Light> {
        self.lights.iter().filter(|light| light.shines())
    }

    /// The sky, if one shines.
    pub fn sky(&self) -> Option<&Sky> {
        self.sky.as_ref().filter(|sky| sky.shines())
    }

    /// Where light is measured beside the faces.
    pub fn receivers(&self) -> &[Receiver] {
        &self.receivers
    }

    /// Lumens per watt, lm·W⁻¹.
    pub fn efficacy(&self) -> f64 {
        self.efficacy
    }

    /// How many channels reflectance and radiance have: 1 where all agree, else those of the materials.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// What reading the scene brought to light and its author should know.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The files that were read: the OBJ file, its settings, and all that they name.
    pub fn inputs(&self) -> &[PathBuf] {
        &self.inputs
    }

    /// The material of a face.
    pub fn material_of(&self, face: usize) -> &Material {
        &self.materials[self.faces[face].material as usize]
    }

    /// Whether a face takes part and is a carrier: a mirror, glass or a rough conductor.
    pub fn is_carrier(&self, face: usize) -> bool {
        self.faces[face].state == FaceState::Kept && self.material_of(face).surface.is_carrier()
    }

    /// Whether a face takes part and some light goes on from it without being spread diffusely: from carriers
    /// and plastic.
    pub fn passes_on(&self, face: usize) -> bool {
        self.faces[face].state == FaceState::Kept && self.material_of(face).surface.passes_on()
    }

    /// Whether a face takes part and spreads light diffusely: then it is cut into patches.
    pub fn is_diffuse(&self, face: usize) -> bool {
        self.faces[face].state == FaceState::Kept && !self.material_of(face).surface.is_carrier()
    }

    /// The corners of a face, metres.
    pub fn corners(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].vertices.map(|v| self.vertices[v as usize])
    }

    /// A face's corners as a key that duplicates share: the same corners in the same winding.
    pub(crate) fn oriented_corners(&self, face: usize) -> [[u64; 3]; 3] {
        degenerate::oriented(self.corners(face))
    }

    /// Makes sure that something emits.
    ///
    /// # Errors
    /// `NoLight`.
    pub fn require_light(&self) -> Result<(), SceneError> {
        let kept = |face: &&Face| face.state == FaceState::Kept;
        let lit = self.faces.iter().filter(kept).any(|f| self.materials[f.material as usize].emits());
        let lit = lit || self.lights().next().is_some() || self.sky().is_some();
        if lit { Ok(()) } else { Err(SceneError::NoLight { name: self.name.clone() }) }
    }
}

fn check_faces(
    faces: &[Face],
    vertices: &[DVec3],
    normals: &[DVec3],
    materials: usize,
    objects: usize,
) -> Result<(), SceneError> {
    for (number, face) in faces.iter().enumerate() {
        let error = |message: String| Err(SceneError::Face { face: number, message });
        for &v in &face.vertices {
            match vertices.get(v as usize) {
                None => return error(format!("vertex {v} does not exist; there are {}", vertices.len())),
                Some(p) if !is_near(*p) => {
                    return error(format!(
                        "vertex {v} is {p}; it must be finite, no coordinate beyond {FARTHEST:e} m"
                    ));
                }
                Some(_) => {}
            }
        }
        let bad_normal = face.normals.is_some_and(|n| n.iter().any(|&n| n as usize >= normals.len()));
        if bad_normal || face.material as usize >= materials || face.object as usize >= objects {
            return error("its normal, material or object does not exist".into());
        }
    }
    Ok(())
}

/// Returns the number of channels.
fn check_materials(materials: &[Material]) -> Result<usize, SceneError> {
    let channels = materials.first().map_or(1, |m| m.reflectance.len());
    for material in materials {
        let error = |message| SceneError::Material { material: material.name.clone(), message };
        if channels == 0 || !material.has_channels(channels) {
            let message =
                format!("every reflectance, emission and filter must have {} channels", channels.max(1));
            return Err(error(message));
        }
        material.check().map_err(error)?;
    }
    Ok(channels)
}

fn check_lights(lights: &[Light], sky: Option<&Sky>, channels: usize) -> Result<(), SceneError> {
    for (number, light) in lights.iter().enumerate() {
        let error = |message| SceneError::Light { light: format!("light {}", number + 1), message };
        light.check(channels).map_err(error)?;
    }
    let error = |message| SceneError::Light { light: "sky".into(), message };
    sky.map_or(Ok(()), |sky| sky.check(channels).map_err(error))
}
