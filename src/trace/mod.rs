//! Trace: rays against the scene's faces.
//!
//! A [`Tracer`] answers two questions, [`Tracer::closest_hit`] and [`Tracer::unoccluded`], exactly enough
//! that a closed mesh lets no ray out. It knows faces and nothing of patches, so the cost of a ray does not
//! grow with the number of patches.
//!
//! Everything here happens in the *normalised frame*: the scene is moved to the origin and scaled to fit
//! the cube [-1, 1]³, so that neither its size nor its place can matter. [`Frame`] converts.

mod apertures;
mod bvh;
mod convex;
mod emitters;
mod facing;
mod interaction;
mod lambert;
mod layers;
mod limits;
pub mod sampling;
mod scattering;
mod solid_angle;
mod watertight;

use std::sync::Arc;

use glam::DVec3;

use crate::scene::{FaceState, Scene, Side, Surface, triangle};
use apertures::Apertures;
pub use apertures::Through;
use bvh::Bvh;
pub use convex::{Enclosure, NotConvex};
pub(crate) use emitters::{Arrival, NarrowCone};
pub use emitters::{
    Beam, LampPoint, LampView, Lamps, Lights, Shot, SkyBeam, SkySampler, SkyShot, SkyView, Targets,
};
pub use facing::{IN_PLANE, can_face};
pub(crate) use interaction::Interaction;
pub(crate) use lambert::form_factor_estimate;
pub use lambert::{form_factor_between, form_factor_to_triangle, geometry_term};
use layers::Layers;
pub use layers::{Overlap, OverlapKind};
pub(crate) use limits::{MOST_CARRIERS_OF_BRANCHES, MOST_CARRIERS_OF_PATHS, MOST_CROSSINGS, OUTSIDE};
pub(crate) use scattering::SpecularPath;
pub use scattering::{Coat, Destination, Glossy, Scattered, Tint, fresnel};
use scattering::{Gloss, Media};
pub use solid_angle::solid_angle;
pub(crate) use solid_angle::{Target, target, towards_triangle, triangle_pdf};

/// Hits nearer than this to the origin are the surface the ray starts on, in normalised lengths.
///
/// Rays start on a face to within rounding (10⁻¹⁶); a coplanar neighbour or a lamp flush with a wall must
/// not stop them. A wall that is met this close at a corner is missed by one ray in some 10¹¹.
const SKIN: f64 = 1e-13;

/// The map between scene coordinates (metres) and the normalised frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    centre: DVec3,
    scale: f64,
}

impl Frame {
    fn around(points: impl Iterator<Item = DVec3>) -> Self {
        let everything = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.fold(everything, |(low, high), p| (low.min(p), high.max(p)));
        Self { centre: 0.5 * (low + high), scale: (0.5 * (high - low)).max_element() }
    }

    /// Metres per normalised unit of length.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// From metres to the normalised frame.
    pub fn from_world(&self, p: DVec3) -> DVec3 {
        (p - self.centre) / self.scale
    }

    /// From the normalised frame to metres.
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        self.centre + p * self.scale
    }
}

/// A half-line from a point, normalised frame.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Start.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// The face it starts on, which it can't hit; [`Ray::FREE`] for rays that start in the open.
    pub from: u32,
}

impl Ray {
    /// The `from` of a ray that starts on no face.
    pub const FREE: u32 = u32::MAX;
}

/// Where a ray meets a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The face's number.
    pub face: u32,
    /// The side that was met.
    pub side: Side,
    /// Distance from the ray's origin, normalised.
    pub distance: f64,
    /// Barycentric weights of the second and third corner.
    pub barycentrics: [f64; 2],
}

/// A ray, and where it has met a face.
#[derive(Clone, Copy, Debug)]
pub struct RayHit {
    /// The ray.
    pub ray: Ray,
    /// Where it ends.
    pub hit: Hit,
}

/// What becomes of a ray that meets a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encounter {
    /// It ends there.
    Ends,
    /// It goes on, as from a mirror.
    GoesOn,
    /// It goes on or ends, by chance, as on plastic.
    Either,
}

/// What facets a material has.
#[derive(Debug)]
enum Finish<'s> {
    /// None.
    Plain,
    /// Those of a rough conductor.
    Metal(Box<Gloss<'s>>),
    /// Those of a coat over a diffuse base.
    Coated(Arc<Coat>),
}

/// The scene's faces, ready to be met by rays.
#[derive(Debug)]
pub struct Tracer<'s> {
    scene: &'s Scene,
    frame: Frame,
    corners: Vec<[DVec3; 3]>,
    normals: Vec<DVec3>,
    /// Per face what becomes of rays that meet it; empty where all end.
    encounters: Vec<Encounter>,
    /// Per material its facets; empty where none has any.
    finishes: Vec<Finish<'s>>,
    /// Whether some face is of thin glass.
    has_panes: bool,
    /// What lies around solids of glass.
    media: Media,
    /// Which of coinciding faces is on top.
    layers: Layers,
    bvh: Bvh,
    /// Through which places inside see sun and sky.
    apertures: Apertures,
}

impl<'s> Tracer<'s> {
    /// Builds the bounding volume hierarchy over the faces that take part; where there is sun or sky, finds
    /// the openings through which these come in.
    pub fn new(scene: &'s Scene) -> Self {
        let kept: Vec<u32> = (0..scene.faces().len() as u32)
            .filter(|&f| scene.faces()[f as usize].state == FaceState::Kept)
            .collect();
        let frame = Frame::around(kept.iter().flat_map(|&f| scene.corners(f as usize)));
        let corners: Vec<[DVec3; 3]> =
            (0..scene.faces().len()).map(|f| scene.corners(f).map(|p| frame.from_world(p))).collect();
        let normals: Vec<DVec3> = corners.iter().map(triangle::normal).collect();
        let bvh = Bvh::new(&corners, &kept);
        let layers = Layers::new(scene, (&corners, &normals), &kept, frame.scale().powi(2));
        let is_pane = |&f: &u32| matches!(scene.material_of(f as usize).surface, Surface::Pane { .. });
        let has_panes = kept.iter().any(is_pane);
        let (encounters, finishes) = (encounters_of(scene), finishes_of(scene));
        let media = Media::default();
        let tracer = Self {
            scene,
            frame,
            corners,
            normals,
            encounters,
            finishes,
            has_panes,
            media,
            layers,
            bvh,
            apertures: Apertures::default(),
        };
        let tracer = Self { media: Media::new(&tracer), ..tracer };
        Self { apertures: Apertures::find(&tracer), ..tracer }
    }

    /// The scene whose faces these are.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// The openings through which places inside see sun and sky.
    pub(crate) fn apertures(&self) -> &Apertures {
        &self.apertures
    }

    /// The map to and from metres.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// A face's corners, normalised frame.
    pub fn corners(&self, face: usize) -> &[DVec3; 3] {
        &self.corners[face]
    }

    /// The unit normal of a face's side; zero for a face without area.
    pub fn normal(&self, face: usize, side: Side) -> DVec3 {
        match side {
            Side::Front => self.normals[face],
            Side::Back => -self.normals[face],
        }
    }

    /// Where a ray met a face, normalised frame.
    #[inline]
    pub(crate) fn point(&self, hit: &Hit) -> DVec3 {
        triangle::point(&self.corners[hit.face as usize], hit.barycentrics)
    }

    /// Whether a face passes light on as a mirror, glass or a rough conductor.
    #[inline]
    pub fn is_carrier(&self, face: u32) -> bool {
        self.encounters.get(face as usize) == Some(&Encounter::GoesOn)
    }

    /// Whether a ray that meets a face may go on from there: from carriers, and from coats over diffuse
    /// surfaces.
    #[inline]
    pub fn may_go_on(&self, face: u32) -> bool {
        self.encounters.get(face as usize).is_some_and(|&encounter| encounter != Encounter::Ends)
    }

    /// Whether rays may go on from any face.
    pub fn has_carriers(&self) -> bool {
        !self.encounters.is_empty()
    }

    /// Whether any surface has facets, as rough metal and plastic.
    pub fn has_facets(&self) -> bool {
        !self.finishes.is_empty()
    }

    /// The coat over a diffuse face, if it has one.
    #[inline]
    pub fn coat_of(&self, face: u32) -> Option<&Coat> {
        if self.finishes.is_empty() {
            return None;
        }
        match self.finishes.get(self.scene.faces().get(face as usize)?.material as usize) {
            Some(Finish::Coated(coat)) => Some(coat),
            _ => None,
        }
    }

    /// The first face that the ray meets, if any: of coinciding faces the one on top, of equally near ones
    /// the lower number.
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        if self.layers.is_empty() {
            return self.bvh.closest_hit(ray, &[]);
        }
        self.bvh.closest_hit(ray, self.layers.twins(ray.from)).map(|hit| self.hit_on_top(hit))
    }

    /// Whether two points on two faces see each other, in front of or behind those faces alike. A point that
    /// another face covers sees nothing.
    pub fn unoccluded(&self, (p, from): (DVec3, u32), (q, to): (DVec3, u32)) -> bool {
        let distance = p.distance(q);
        let direction = (q - p) / distance;
        let ray = Ray { origin: p, direction, from };
        if self.layers.is_empty() {
            return !self.bvh.any_hit(&ray, (to, [&[]; 2]), distance - SKIN);
        }
        let covered =
            self.is_covered_towards((p, from), direction) || self.is_covered_towards((q, to), -direction);
        let skipped = [from, to].map(|face| self.layers.twins(face));
        !covered && !self.bvh.any_hit(&ray, (to, skipped), distance - SKIN)
    }

    /// Whether another face covers a point of a face on the side that looks in a direction.
    pub fn is_covered_towards(&self, (point, face): (DVec3, u32), direction: DVec3) -> bool {
        let Some(normal) = self.normals.get(face as usize) else { return false };
        let side = if normal.dot(direction) >= 0.0 { Side::Front } else { Side::Back };
        self.is_covered(face, side, point)
    }

    /// Whether a ray meets nothing nearer than `distance` (normalised, or infinite).
    pub fn is_clear(&self, ray: &Ray, distance: f64) -> bool {
        !self.bvh.any_hit(ray, (Ray::FREE, [self.layers.twins(ray.from), &[]]), distance - SKIN)
    }
}

/// What becomes of rays that meet each face; nothing at all where all end.
fn encounters_of(scene: &Scene) -> Vec<Encounter> {
    let encounter = |face: usize| match (scene.passes_on(face), scene.is_carrier(face)) {
        (true, true) => Encounter::GoesOn,
        (true, false) => Encounter::Either,
        (false, _) => Encounter::Ends,
    };
    let all: Vec<Encounter> = (0..scene.faces().len()).map(encounter).collect();
    if all.iter().all(|&encounter| encounter == Encounter::Ends) { Vec::new() } else { all }
}

/// The facets of each material; nothing at all where none has any.
fn finishes_of(scene: &Scene) -> Vec<Finish<'_>> {
    let mut coats: Vec<([f64; 2], Arc<Coat>)> = Vec::new();
    let mut all = Vec::with_capacity(scene.materials().len());
    for material in scene.materials() {
        all.push(match material.surface {
            Surface::Conductor { ref reflectance, roughness } => {
                Finish::Metal(Box::new(Gloss::new(roughness, reflectance)))
            }
            // Materials with the same coat share it.
            Surface::Plastic { index, roughness } => {
                let known = coats.iter().find(|(key, _)| *key == [roughness, index]);
                let coat = known.map(|(_, coat)| coat.clone());
                let coat = coat.unwrap_or_else(|| Arc::new(Coat::new(roughness, index, scene.channels())));
                coats.push(([roughness, index], coat.clone()));
                Finish::Coated(coat)
            }
            _ => Finish::Plain,
        });
    }
    if all.iter().all(|finish| matches!(finish, Finish::Plain)) { Vec::new() } else { all }
}
