//! Media: in which dielectric a place lies, told by the surfaces around it.
//!
//! A ray from the place meets some solids from outside and leaves them again. The first that it leaves
//! without having entered it is the innermost around the place: its index of refraction is the one that holds
//! there. So a ball of glass in water bends light by 1.5/1.33, and solids that lie in each other need no
//! order in the file. Each face of a dielectric has one medium before it, the one at its centre; where solids
//! overlap, the one that is left first counts. Solids of one material are taken to lie beside each other, or
//! to be hollow.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::scene::{Scene, Side, Surface};
use crate::trace::limits::MOST_CROSSED;
use crate::trace::sampling::{Stream, cosine_hemisphere, frame_around};
use crate::trace::{Ray, Tracer};

/// A box around the solids of one material: its lowest and highest corner, normalised frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds([DVec3; 2]);

impl Bounds {
    fn meets(&self, Self([low, high]): &Self) -> bool {
        self.0[0].cmple(*high).all() && low.cmple(self.0[1]).all()
    }

    fn holds(&self, point: DVec3) -> bool {
        self.meets(&Self([point; 2]))
    }
}

/// The dielectrics of a scene, and what lies around them.
#[derive(Debug, Default)]
pub(crate) struct Media {
    /// Around each material.
    bounds: Vec<Bounds>,
    /// Per face, the index of refraction before it; empty where all is outside.
    before: Vec<f64>,
}

impl Media {
    /// Looks around from the faces of dielectrics that may lie in each other.
    pub fn new(tracer: &Tracer) -> Self {
        let solids = solids(tracer.scene());
        let around = |faces: &Vec<u32>| {
            let corners = faces.iter().flat_map(|&face| tracer.corners(face as usize));
            let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            Bounds(corners.fold(nothing, |[low, high], &p| [low.min(p), high.max(p)]))
        };
        let bounds: Vec<Bounds> = solids.iter().map(around).collect();
        let meets_another = |k: usize| (0..bounds.len()).any(|l| l != k && bounds[k].meets(&bounds[l]));
        let faces: Vec<u32> =
            (0..solids.len()).filter(|&k| meets_another(k)).flat_map(|k| &solids[k]).copied().collect();
        let centre = |face: u32| tracer.corners(face as usize).iter().sum::<DVec3>() / 3.0;
        let index_before =
            |&face: &u32| tracer.looked_around(centre(face), face, tracer.normals[face as usize]);
        let found: Vec<f64> = faces.par_iter().map(index_before).collect();
        if found.iter().all(|&index| index == 1.0) {
            return Self { bounds, before: Vec::new() };
        }
        let mut before = vec![1.0; tracer.scene().faces().len()];
        faces.iter().zip(found).for_each(|(&face, index)| before[face as usize] = index);
        Self { bounds, before }
    }

    /// Index of refraction behind a face of a dielectric of this index, relative to what lies before it.
    #[inline]
    pub fn relative(&self, face: usize, index: f64) -> f64 {
        self.before.get(face).map_or(index, |before| index / before)
    }
}

/// The faces of each dielectric material.
fn solids(scene: &Scene) -> Vec<Vec<u32>> {
    let mut solids: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let is_dielectric = |face: usize| {
        scene.is_carrier(face) && matches!(scene.material_of(face).surface, Surface::Dielectric { .. })
    };
    for face in (0..scene.faces().len()).filter(|&face| is_dielectric(face)) {
        solids.entry(scene.faces()[face].material).or_default().push(face as u32);
    }
    solids.into_values().collect()
}

impl Tracer<'_> {
    /// Index of refraction of the medium at a point of a face, on the side to which `normal` points: that of
    /// the innermost dielectric around it, 1 outside of all.
    pub fn medium_at(&self, point: DVec3, face: u32, normal: DVec3) -> f64 {
        if self.media.bounds.iter().any(|bounds| bounds.holds(point)) {
            self.looked_around(point, face, normal)
        } else {
            1.0
        }
    }

    /// Whether there are solids of glass or water.
    pub fn has_dielectrics(&self) -> bool {
        !self.media.bounds.is_empty()
    }

    /// The medium on which two of three looks agree, for one may graze an edge.
    fn looked_around(&self, point: DVec3, face: u32, normal: DVec3) -> f64 {
        let frame = frame_around(normal);
        let sequence = Stream::Media.sequence(0, 0, 0);
        let look = |k: u32| {
            let [u, v, ..] = sequence.point(k);
            self.medium_along(Ray { origin: point, direction: frame * cosine_hemisphere([u, v]), from: face })
        };
        let [first, second] = [look(0), look(1)];
        if first == second { first } else { look(2) }
    }

    /// The index of the first dielectric that a ray leaves without having entered it.
    fn medium_along(&self, mut ray: Ray) -> f64 {
        let mut entered = Vec::new();
        for _ in 0..MOST_CROSSED {
            let Some(hit) = self.closest_hit(&ray) else { return 1.0 };
            let number = self.scene.faces()[hit.face as usize].material;
            if let Surface::Dielectric { index, .. } = self.scene.materials()[number as usize].surface {
                match (hit.side, entered.iter().rposition(|&other| other == number)) {
                    (Side::Front, _) => entered.push(number),
                    (Side::Back, Some(place)) => {
                        entered.remove(place);
                    }
                    (Side::Back, None) => return index,
                }
            }
            ray = Ray { origin: self.point(&hit), direction: ray.direction, from: hit.face };
        }
        1.0
    }
}
