//! View: a camera for scenes that bring none.
//!
//! Many cameras, inside the scene and around it, cast a few rays each. The best is the one with the highest
//! viewpoint entropy, −Σ p log p over the surfaces in the picture with p each one's share of them (Vázquez et
//! al. 2001), less what spoils a picture: unlit sides, emptiness, and things right before the lens.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::patches::Patches;
use crate::scene::{Camera, FaceState, Side, triangle};
use crate::trace::{Ray, Tracer};

/// Vertical field of view of the cameras tried, degrees; wider inside, where there is no room to step back.
const FOV_OUTSIDE: f64 = 40.0;
const FOV_INSIDE: f64 = 60.0;

/// Width of the picture by its height.
const ASPECT: f64 = 4.0 / 3.0;

/// A picture filled less than this with lit surfaces is called empty.
const ENOUGH: f64 = 0.4;

/// Rays across and down.
const GRID: [usize; 2] = [32, 24];

/// A camera that sees much of what light reaches; the same for the same scene and patches.
///
/// Up is y, or z in a scene whose lamps point down z or that lies flat in the xy plane.
pub fn default_camera(tracer: &Tracer, patches: &Patches) -> Camera {
    let extent = Extent::of(tracer);
    let up = up_axis(tracer, &extent);
    let detail = detail(tracer, patches);
    let interest = detail.iter().sum::<DVec3>() / detail.len().max(1) as f64;
    let candidates = candidates(&extent, if detail.is_empty() { extent.centre } else { interest }, up);
    let score =
        |camera: &Camera| score(tracer, patches, camera) * (0.4 + 0.6 * share_in_frame(camera, &detail));
    let scores: Vec<f64> = candidates.par_iter().map(score).collect();
    let best = (0..candidates.len()).max_by(|&i, &j| scores[i].total_cmp(&scores[j]).then(j.cmp(&i)));
    let camera = candidates[best.unwrap_or(0)];
    let to_world = |p| tracer.frame().to_world(p);
    Camera { position: to_world(camera.position), target: to_world(camera.target), ..camera }
}

/// The box around the scene, normalised frame.
struct Extent {
    centre: DVec3,
    half: DVec3,
}

impl Extent {
    fn of(tracer: &Tracer) -> Self {
        let faces = tracer.scene().faces().iter().enumerate();
        let kept = faces.filter(|(_, face)| face.state == FaceState::Kept);
        let points = kept.flat_map(|(f, _)| *tracer.corners(f));
        let everything = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.fold(everything, |(low, high), p| (low.min(p), high.max(p)));
        Self { centre: 0.5 * (low + high), half: 0.5 * (high - low) }
    }

    fn corners(&self) -> impl Iterator<Item = DVec3> {
        let sign = |k: usize, bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
        (0..8).map(move |k| self.centre + self.half * DVec3::new(sign(k, 0), sign(k, 1), sign(k, 2)))
    }
}

/// y, unless lamps or the shape of the scene speak for z.
fn up_axis(tracer: &Tracer, extent: &Extent) -> DVec3 {
    let scene = tracer.scene();
    let power = |f: usize| -> DVec3 {
        triangle::across(tracer.corners(f)) * scene.mean_emission(f).iter().sum::<f64>()
    };
    let kept = (0..scene.faces().len()).filter(|&f| scene.faces()[f].state == FaceState::Kept);
    let down = kept.map(power).sum::<DVec3>().normalize_or_zero();
    let flat = extent.half.z < 0.5 * extent.half.x.min(extent.half.y);
    if down.z < -0.9 || (flat && down.y > -0.9) { DVec3::Z } else { DVec3::Y }
}

/// Some of the patches' centres: more where there is detail. Normalised frame.
fn detail(tracer: &Tracer, patches: &Patches) -> Vec<DVec3> {
    let step = patches.len() / 500 + 1;
    (0..patches.len()).step_by(step).map(|i| tracer.frame().from_world(patches.centre(i))).collect()
}

/// Which share of `places` lies within the frame, seen or hidden.
fn share_in_frame(camera: &Camera, places: &[DVec3]) -> f64 {
    let [right, up, forward] = camera.axes();
    let tangent = (0.5 * camera.fov.to_radians()).tan();
    let is_inside = |&p: &DVec3| {
        let p = p - camera.position;
        let reach = p.dot(forward) * tangent;
        p.dot(right).abs() <= reach * ASPECT && p.dot(up).abs() <= reach
    };
    places.iter().copied().filter(is_inside).count() as f64 / places.len().max(1) as f64
}

/// Cameras to try, normalised frame.
fn candidates(extent: &Extent, interest: DVec3, up: DVec3) -> Vec<Camera> {
    let mut cameras = Vec::new();
    let side = if up == DVec3::Y { DVec3::Z } else { -DVec3::Y };
    let right = up.cross(side);
    let Extent { centre, half } = *extent;
    let at = |x: f64, y: f64, z: f64| centre + half * (right * x + up * y + side * z);
    // Inside: from places at two heights, near the walls and in the middle, towards
    // the middle, the detail and along the axes.
    for height in [0.1, 0.45] {
        for [x, z] in
            [-0.85, -0.4, 0.0, 0.4, 0.85].into_iter().flat_map(|x| [-0.85, 0.0, 0.85].map(|z| [x, z]))
        {
            let targets =
                [interest, at(0.0, -0.1, 0.0), at(-0.3 * x, height - 0.25, -z), at(-x, height - 0.25, z)];
            for target in targets {
                let position = at(x, height, z);
                if position.distance(target) > 0.2 * half.length() {
                    cameras.push(Camera { position, target, up, fov: FOV_INSIDE });
                }
            }
        }
    }
    // Outside: around the scene, looking down on it more or less, with all of it or its detail in the
    // picture.
    for turn in 0..16 {
        let azimuth = std::f64::consts::TAU * turn as f64 / 16.0;
        for elevation in [2.0f64, 18.0, 38.0].map(f64::to_radians) {
            let flat = right * azimuth.sin() + side * azimuth.cos();
            let towards = flat * elevation.cos() + up * elevation.sin();
            let all = fitting(extent, towards, up);
            cameras.push(all);
            for closer in [0.6, 0.35] {
                let position = interest + (all.position - all.target) * closer;
                cameras.push(Camera { position, target: interest, ..all });
            }
        }
    }
    cameras
}

/// The camera in direction `towards` of the scene's centre that has the whole box in the picture.
fn fitting(extent: &Extent, towards: DVec3, up: DVec3) -> Camera {
    let camera = Camera { position: extent.centre + towards, target: extent.centre, up, fov: FOV_OUTSIDE };
    let [right, top, forward] = camera.axes();
    let tangent = (0.5 * FOV_OUTSIDE.to_radians()).tan();
    // Each corner must lie within the frame: far enough away for its sideways distance.
    let needed = |p: DVec3| {
        let p = p - extent.centre;
        let sideways = (p.dot(right).abs() / ASPECT).max(p.dot(top).abs());
        1.06 * sideways / tangent - p.dot(forward)
    };
    let distance = extent.corners().map(needed).fold(1e-3, f64::max);
    Camera { position: extent.centre + towards * distance, ..camera }
}

/// How good a picture a camera makes; higher is better.
fn score(tracer: &Tracer, patches: &Patches, camera: &Camera) -> f64 {
    let [columns, rows] = GRID;
    let [right, up, forward] = camera.axes();
    let tangent = (0.5 * camera.fov.to_radians()).tan();
    let mut surfaces: HashMap<u64, f64> = HashMap::new();
    let (mut dark, mut near, mut backs) = (0.0, 0.0, 0.0);
    let lit = tracer.scene().require_light().is_ok() && !patches.is_empty();
    let one = 1.0 / (columns * rows) as f64;
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let x = ((column as f64 + 0.5) / columns as f64 * 2.0 - 1.0) * tangent * ASPECT;
        let y = (1.0 - (row as f64 + 0.5) / rows as f64 * 2.0) * tangent;
        let direction = (forward + right * x + up * y).normalize();
        let Some(hit) = tracer.closest_hit(&Ray { origin: camera.position, direction, from: Ray::FREE })
        else {
            continue;
        };
        let face = hit.face as usize;
        if lit && !tracer.is_carrier(hit.face) && patches.patch_at(face, hit.side, hit.barycentrics).is_none()
        {
            dark += one;
            continue;
        }
        near += if hit.distance < 0.25 { one * (1.0 - hit.distance / 0.25) } else { 0.0 };
        backs += if hit.side == Side::Back { one } else { 0.0 };
        *surfaces
            .entry(surface(tracer, face, hit.side, camera.position + direction * hit.distance))
            .or_default() += one;
    }
    // Sum in a fixed order: the map has none.
    let mut shares: Vec<f64> = surfaces.into_values().collect();
    shares.sort_by(f64::total_cmp);
    let filled: f64 = shares.iter().sum();
    let entropy: f64 = shares.iter().map(|p| -p / filled * (p / filled).ln()).sum();
    let spoilt = (1.0f64 - 1.5 * dark).max(0.0) * (1.0 - near).max(0.0) * (1.0 - 0.7 * backs);
    if filled > 0.0 { entropy * spoilt * (filled / ENOUGH).min(1.0).sqrt() } else { 0.0 }
}

/// A name for what is seen: material, object, which way it faces, and roughly where it is.
fn surface(tracer: &Tracer, face: usize, side: Side, place: DVec3) -> u64 {
    let &crate::scene::Face { material, object, .. } = &tracer.scene().faces()[face];
    let normal = tracer.normal(face, side);
    let bins = |v: DVec3, per_unit: f64| v.to_array().map(|x| (x * per_unit).round() as i64 + 8);
    let [a, b, c] = bins(normal, 1.0);
    let [x, y, z] = bins(place, 1.5);
    [material as i64, object as i64, a, b, c, x, y, z]
        .iter()
        .fold(0u64, |name, &part| name.wrapping_mul(1_000_003).wrapping_add(part as u64))
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{cut, quad, room, triangles};
    use super::*;
    use crate::patches::Reach;
    use crate::scene::{Material, Scene};

    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    fn camera_for(scene: &Scene) -> Camera {
        let tracer = Tracer::new(scene);
        let camera = default_camera(&tracer, &cut(&tracer, 0.2, Reach::Light));
        assert!(camera.is_valid());
        camera
    }

    /// The unit cube seen from outside, moved up by `height`.
    fn block(height: f64) -> Vec<[[f64; 3]; 3]> {
        let o = [0.0, height, 0.0];
        let (x, y, z) = ([1.0, height, 0.0], [0.0, height + 1.0, 0.0], [0.0, height, 1.0]);
        [quad(o, X, Z), quad(o, Y, X), quad(o, Z, Y), quad(y, Z, X), quad(z, X, Y), quad(x, Y, Z)].concat()
    }

    #[test]
    fn a_view_stands_inside_a_closed_room() {
        let position = camera_for(&room(Material::lamp("wall", &[0.5], &[1.0]))).position;
        assert!(position.min_element() > 0.0 && position.max_element() < 1.0, "{position}");
    }

    #[test]
    fn a_view_looks_into_an_open_box_from_outside() {
        let walls =
            [quad([0.0; 3], Z, X), quad([0.0; 3], X, Y), quad([0.0; 3], Y, Z), quad(Y, X, Z), quad(X, Z, Y)];
        // There is no wall at z = 1.
        let scene = triangles(&walls.concat(), &[0; 10], vec![Material::lamp("wall", &[0.5], &[1.0])]);
        assert!(camera_for(&scene).position.z > 1.0);
    }

    #[test]
    fn a_view_stands_away_from_a_lone_object() {
        let scene = triangles(&block(0.0), &[0; 12], vec![Material::lamp("block", &[0.5], &[1.0])]);
        let position = camera_for(&scene).position - DVec3::splat(0.5);
        assert!(position.abs().max_element() > 0.7, "{position}");
    }

    #[test]
    fn a_view_stands_above_the_ground_an_object_stands_on() {
        let mut faces = block(1e-3);
        faces.extend(quad([-4.0, 0.0, -4.0], [0.0, 0.0, 9.0], [9.0, 0.0, 0.0]));
        let of: Vec<u32> = (0..14).map(|f| u32::from(f < 12)).collect();
        let materials = vec![Material::diffuse("ground", &[0.5]), Material::lamp("block", &[0.5], &[1.0])];
        let camera = camera_for(&triangles(&faces, &of, materials));
        assert!(camera.position.y > 0.1, "{camera:?}");
    }

    #[test]
    fn a_view_stays_valid_where_there_is_almost_nothing() {
        let speck = [[[0.0; 3], [1e-9, 0.0, 0.0], [0.0, 1e-9, 0.0]]];
        camera_for(&triangles(&speck, &[0], vec![Material::diffuse("speck", &[0.5])]));
    }
}
