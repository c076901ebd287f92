//! Smooth field: a field over patches, constant or linear over each, made continuous for the eye.
//!
//! A corner's value is the mean, weighted by angle, of the patches that meet there on the same smooth
//! surface: same material, and normals no more than 30° from one to the next. Of constant elements each gives
//! its one value, of linear ones its value at that place. Inside a patch the values of its three corners are
//! interpolated linearly. A corner in the middle of a neighbouring patch's edge counts that patch as meeting
//! there too, so that unlike cuts of two faces, or of two parts of one, leave no visible seam. Across
//! creases, materials and the two sides of a sheet nothing is mixed, nor where something stands between: of a
//! floor, what is in a room, under its wall and in the next room.

mod corners;
mod meeting;

use glam::{DMat2, DVec2, DVec3};
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::patches::{Barycentrics, Basis, Patches};
use crate::scene::triangle;
use crate::trace::Tracer;
use corners::{Corner, corners};
use meeting::for_each_point;

/// A field over patches, continuous within each smooth surface.
#[derive(Clone, Debug)]
pub struct SmoothField {
    channels: usize,
    /// Per patch, its corners as places in `points`.
    corners: Vec<[u32; 3]>,
    /// Normalised frame.
    points: Vec<DVec3>,
    /// Per point, `channels` values.
    values: Vec<f64>,
    /// Per patch: from points of its face to weights of the patch's second and third corner.
    weights: Vec<(DVec2, DMat2)>,
}

impl SmoothField {
    /// Averages `field` (N × c, N = n or 3n) to the corners of the patches.
    ///
    /// # Panics
    /// If `field` has neither n nor 3n rows.
    pub fn new(tracer: &Tracer, patches: &Patches, field: &DMatrix<f64>) -> Self {
        let basis = Basis::of(patches, field);
        let corners = corners(tracer, patches);
        let mut smooth = Self {
            channels: field.ncols(),
            corners: vec![[0; 3]; patches.len()],
            points: Vec::new(),
            values: Vec::new(),
            weights: (0..patches.len()).into_par_iter().map(|i| to_weights(patches.corners(i))).collect(),
        };
        for_each_point(tracer, patches, &corners, |members| {
            smooth.add_point(&corners, members, (basis, field));
        });
        smooth
    }

    /// Makes one point of `members`, a choice of `corners`.
    fn add_point(
        &mut self,
        corners: &[Corner],
        members: &mut Vec<u32>,
        (basis, field): (Basis, &DMatrix<f64>),
    ) {
        // Count each patch once, as a corner if it has one here.
        members
            .sort_unstable_by_key(|&m| (corners[m as usize].patch, corners[m as usize].number.is_none(), m));
        members.dedup_by_key(|m| corners[*m as usize].patch);
        let own =
            |m: &u32| corners[*m as usize].number.map(|k| (corners[*m as usize].patch as usize, k as usize));
        let mut owners = members.iter().filter_map(own).peekable();
        if owners.peek().is_none() {
            return;
        }
        for (patch, number) in owners {
            self.corners[patch][number] = self.points.len() as u32;
        }
        self.points.push(corners[members[0] as usize].position);
        let met = || members.iter().map(|&m| &corners[m as usize]);
        let total: f64 = met().map(|corner| corner.angle).sum();
        for c in 0..self.channels {
            let sum: f64 = met().map(|corner| corner.angle * corner.value(basis, field, c)).sum();
            self.values.push(sum / total);
        }
    }

    /// Number of channels c.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Where values are known, normalised frame; a place in space has a point for each surface that meets
    /// there.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The values at a point, c of them.
    pub fn value(&self, point: u32) -> &[f64] {
        &self.values[point as usize * self.channels..][..self.channels]
    }

    /// The points at the corners of a patch, in the order of [`Patches::corners`].
    pub fn corners(&self, patch: usize) -> [u32; 3] {
        self.corners[patch]
    }

    /// The field at a point of a patch, given as a point of the patch's face; c values.
    #[inline]
    pub fn at(&self, patch: usize, point: Barycentrics) -> impl Iterator<Item = f64> {
        let (origin, inverse) = self.weights[patch];
        let [u, v, w] = triangle::weights((inverse * (DVec2::from(point) - origin)).to_array());
        let [a, b, c] = self.corners[patch].map(|point| self.value(point));
        (0..self.channels).map(move |k| a[k] * u + b[k] * v + c[k] * w)
    }
}

fn to_weights(corners: [Barycentrics; 3]) -> (DVec2, DMat2) {
    let [a, b, c] = corners.map(DVec2::from);
    (a, DMat2::from_cols(b - a, c - a).inverse())
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{cut, quad, room, triangles};
    use super::*;
    use crate::patches::Reach;
    use crate::scene::{Face, FaceState, Material, Scene, SceneParts};

    const CENTRE: Barycentrics = [1.0 / 3.0; 2];

    fn from_centres(patches: &Patches, f: impl Fn(DVec3) -> f64) -> DMatrix<f64> {
        DMatrix::from_fn(patches.len(), 1, |i, _| f(patches.centre(i)))
    }

    #[test]
    fn a_constant_field_stays_constant() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.21, Reach::Light);
        let smooth = SmoothField::new(&tracer, &patches, &DMatrix::from_element(patches.len(), 2, 3.5));
        for patch in 0..patches.len() {
            for value in smooth.at(patch, patches.corners(patch)[1]) {
                assert!((value - 3.5).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_linear_field_on_a_flat_wall_is_reproduced_inside() {
        let wall = quad([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let scene = triangles(&wall, &[0, 0], vec![Material::diffuse("wall", &[0.5])]);
        let tracer = Tracer::new(&scene);
        let mut patches = cut(&tracer, 0.1, Reach::Everything);
        patches.activate(&(0..patches.slots() as u32).collect::<Vec<_>>());
        let linear = |p: DVec3| 2.0 + p.x - 3.0 * p.y;
        let smooth = SmoothField::new(&tracer, &patches, &from_centres(&patches, linear));
        let mut inside = 0;
        for patch in 0..patches.len() {
            let centre = patches.centre(patch);
            if (DVec3::new(0.5, 0.5, 0.0) - centre).abs().max_element() > 0.35 {
                continue;
            }
            inside += 1;
            for corner in patches.corners(patch) {
                let expected = linear(patches.point(patches.place(patch).face, corner));
                let value = smooth.at(patch, corner).next().unwrap();
                assert!((value - expected).abs() < 1e-9, "{value} {expected}");
            }
        }
        assert!(inside > 100);
    }

    #[test]
    fn smoothing_never_mixes_materials_sides_or_surfaces_that_meet_at_a_crease() {
        let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let walls = [quad([0.0; 3], x, y), quad(x, x, y), quad([0.0; 3], y, z)].concat();
        let materials = ["one", "two"].map(|name| Material::diffuse(name, &[0.5])).to_vec();
        let scene = triangles(&walls, &[0, 0, 1, 1, 0, 0], materials);
        let tracer = Tracer::new(&scene);
        let mut patches = cut(&tracer, 0.2, Reach::Everything);
        patches.activate(&(0..patches.slots() as u32).collect::<Vec<_>>());
        let group = |i: usize| patches.place(i).face / 2 * 2 + patches.place(i).side as usize;
        let field = DMatrix::from_fn(patches.len(), 1, |i, _| group(i) as f64);
        let smooth = SmoothField::new(&tracer, &patches, &field);
        for patch in 0..patches.len() {
            for point in smooth.corners(patch) {
                assert!((smooth.value(point)[0] - group(patch) as f64).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn parts_of_a_face_cut_unlike_each_other_share_what_they_know_at_their_edge() {
        // A sheet just above a floor: the floor's parts meet below it, and on one side only there are patches
        // with their corners there.
        let floor = quad([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let sheet = quad([0.2, 0.3, 0.01], [0.5, 0.1, 0.0], [0.0, 0.0, 0.5]);
        let scene =
            triangles(&[floor, sheet].concat(), &[0; 4], vec![Material::lamp("wall", &[0.5], &[1.0])]);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.07, Reach::Light);
        let beyond = |p: DVec3| p.y - 0.3 - 0.2 * (p.x - 0.2);
        let field = from_centres(&patches, |p| if beyond(p) > 0.0 { 1.0 } else { 0.0 });
        let smooth = SmoothField::new(&tracer, &patches, &field);
        let along_foot = |p: DVec3| beyond(p).abs() < 1e-9 && (0.2..=0.7).contains(&p.x);
        let mut found = 0;
        for patch in (0..patches.len()).filter(|&i| patches.place(i).face < 2) {
            for point in smooth.corners(patch) {
                if along_foot(tracer.frame().to_world(smooth.points()[point as usize])) {
                    let value = smooth.value(point)[0];
                    assert!(value > 0.0 && value < 1.0, "{patch}: {value}");
                    found += 1;
                }
            }
        }
        assert!(found > 10, "{found}");
    }

    #[test]
    fn nothing_is_mixed_across_what_stands_on_a_surface() {
        let floor = quad([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let sheet = quad([0.0, 0.3, 0.0], [1.0, 0.1, 0.0], [0.0, 0.0, 0.5]);
        let scene =
            triangles(&[floor, sheet].concat(), &[0; 4], vec![Material::lamp("wall", &[0.5], &[1.0])]);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.07, Reach::Light);
        let beyond = |p: DVec3| p.y - 0.3 - 0.1 * p.x;
        let field = from_centres(&patches, |p| if beyond(p) > 0.0 { 1.0 } else { 0.0 });
        let smooth = SmoothField::new(&tracer, &patches, &field);
        let mut at_the_foot = 0;
        for patch in (0..patches.len()).filter(|&i| patches.place(i).face < 2) {
            for point in smooth.corners(patch) {
                assert_eq!(smooth.value(point)[0], field[patch], "patch {patch}");
                let place = tracer.frame().to_world(smooth.points()[point as usize]);
                at_the_foot += usize::from(beyond(place).abs() < 1e-9);
            }
        }
        assert!(at_the_foot > 20, "{at_the_foot}");
    }

    /// The smoothed x + y along the line x + y = 1, as pairs of x and value.
    fn along_diagonal(faces: &[[[f64; 3]; 3]]) -> Vec<(f64, f64)> {
        let scene = triangles(faces, &vec![0; faces.len()], vec![Material::lamp("wall", &[0.5], &[1.0])]);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.07, Reach::Light);
        let smooth = SmoothField::new(&tracer, &patches, &from_centres(&patches, |p| p.x + p.y));
        let points = smooth.points().iter().map(|&p| tracer.frame().to_world(p));
        let mut found: Vec<(f64, f64)> = points
            .zip(0..)
            .filter(|(p, _)| (p.x + p.y - 1.0).abs() < 1e-9 && (0.1..0.9).contains(&p.x))
            .map(|(p, k)| (p.x, smooth.value(k)[0]))
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    }

    #[test]
    fn faces_cut_unlike_each_other_share_what_they_know_at_their_edge() {
        // Both have the edge from x to y; the second is smaller and cut into fewer rows.
        let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let faces = [[[0.0; 3], x, y], [x, [0.7, 0.6, 0.0], y]];
        let both = along_diagonal(&faces);
        let alone = [along_diagonal(&faces[..1]), along_diagonal(&faces[1..])];
        // One point a place, and the places of both cuts.
        assert!(both.windows(2).all(|pair| pair[1].0 - pair[0].0 > 1e-6), "{both:?}");
        assert!(both.len() > alone[0].len().max(alone[1].len()), "{both:?}");
        // Each side alone misses the value 1 towards itself; equal shares of both miss by at most half of the
        // worse.
        let miss =
            |line: &[(f64, f64)]| line.iter().map(|(_, value)| (value - 1.0).abs()).fold(0.0, f64::max);
        let worse = miss(&alone[0]).max(miss(&alone[1]));
        assert!(miss(&both) <= 0.5 * worse, "{} {worse}", miss(&both));
    }

    #[test]
    fn a_gentle_bend_is_smooth_and_both_halves_share_its_points() {
        let bend = 20f64.to_radians();
        let up = [0.0, bend.cos(), bend.sin()];
        let walls =
            [quad([0.0; 3], [1.0, 0.0, 0.0], up), quad([0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])];
        let scene = triangles(&walls.concat(), &[0; 4], vec![Material::diffuse("wall", &[0.5])]);
        let tracer = Tracer::new(&scene);
        let mut patches = cut(&tracer, 2.0, Reach::Everything);
        patches.activate(&(0..patches.slots() as u32).collect::<Vec<_>>());
        let smooth = SmoothField::new(&tracer, &patches, &from_centres(&patches, |p| p.y));
        // Six places, each with a front and a back.
        assert_eq!(smooth.points().len(), 12);
        assert!(smooth.at(0, CENTRE).next().unwrap().is_finite());
    }

    /// Corner k < 8 of the unit cube.
    fn cube_corner(k: usize) -> DVec3 {
        DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64)
    }

    /// Number of points of a cube's smooth field; each of its walls is cut into four by four cells.
    fn points_of_cube(normals: &[DVec3]) -> usize {
        let walls = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5u32]];
        let faces = walls.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let face = |vertices: [u32; 3]| Face {
            vertices,
            normals: (!normals.is_empty()).then_some(vertices),
            material: 0,
            object: 0,
            state: FaceState::Kept,
        };
        let scene = Scene::new(SceneParts {
            vertices: (0..8).map(cube_corner).collect(),
            normals: normals.to_vec(),
            faces: faces.map(face).collect(),
            materials: vec![Material::lamp("wall", &[0.5], &[1.0])],
            objects: vec!["cube".into()],
            ..Default::default()
        });
        let scene = scene.unwrap();
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.3, Reach::Light);
        SmoothField::new(&tracer, &patches, &from_centres(&patches, |p| p.x)).points().len()
    }

    #[test]
    fn vertex_normals_round_the_edges_of_a_cube() {
        let ball: Vec<DVec3> = (0..8).map(|k| cube_corner(k) - 0.5).collect();
        assert_eq!(points_of_cube(&[]), 6 * 25);
        assert_eq!(points_of_cube(&ball), 98, "5³ points less the 3³ inside");
        for senseless in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert_eq!(points_of_cube(&[senseless; 8]), 6 * 25, "{senseless}");
        }
    }
}
