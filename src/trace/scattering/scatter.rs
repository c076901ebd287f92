//! Scatter: what mirrors, glass, rough conductors and coats do with a ray.
//!
//! A mirror sends it on in one direction, r = d − 2(d·n)n. Smooth glass reflects the part F of its power and
//! refracts the rest (Snell 1621, Fresnel 1823); beyond the critical angle F = 1. Which of the two a random
//! ray takes is chosen with their own probabilities F and 1 − F, so that the ray keeps its weight. A sheet of
//! thin glass does the same but lets rays go straight on. A rough conductor spreads it over a lobe, of which
//! a random ray takes one direction; so does a coat with the part that it reflects, while the rest gets under
//! it and ends.

use glam::DVec3;

use super::coat::Coat;
use super::fresnel::{Pane, fresnel, pane};
use super::gloss::Gloss;
use super::tint::Tint;
use crate::scene::{Side, Surface};
use crate::trace::limits::MOST_CARRIERS;
use crate::trace::sampling::frame_around;
use crate::trace::{Finish, Hit, Ray, SKIN, Tracer};

/// One way on from a carrier.
#[derive(Clone, Copy, Debug)]
pub struct Scattered<'t> {
    /// The ray that goes on.
    pub ray: Ray,
    /// Which part of the power goes this way, before `colour`; of rough conductors, which send it everywhere,
    /// all; of coats, which do too, all that is not to get under them.
    pub share: f64,
    /// Which part of that goes on; none where all of it does.
    pub colour: Option<Tint<'t>>,
}

/// Facets, of a rough conductor or of a coat, where a ray meets them.
#[derive(Clone, Copy, Debug)]
pub struct Glossy<'t> {
    facets: Facets<'t>,
    /// The point, normalised frame.
    point: DVec3,
    face: u32,
    /// The normal of the side that was met.
    normal: DVec3,
    /// The direction the light comes from.
    from: DVec3,
}

#[derive(Clone, Copy, Debug)]
enum Facets<'t> {
    Metal(&'t Gloss<'t>),
    Coat(&'t Coat),
}

impl<'t> Glossy<'t> {
    /// The point, normalised frame.
    pub fn point(&self) -> DVec3 {
        self.point
    }

    /// Which part of the light gets under it, to a diffuse base: 1 − E(μ) of a coat, nothing of a conductor.
    pub fn passed(&self) -> Option<f64> {
        match self.facets {
            Facets::Metal(_) => None,
            Facets::Coat(coat) => Some(coat.passed(self.normal.dot(self.from))),
        }
    }

    /// The way on by random numbers; `more` gives further numbers. Directions have density
    /// [`Glossy::density`], those of coats where they are taken with their share.
    pub fn sample(&self, random: [f64; 3], more: impl FnOnce() -> [f64; 4]) -> Scattered<'t> {
        let frame = frame_around(self.normal);
        let from = frame.transpose() * self.from;
        let (towards, share, colour) = match self.facets {
            Facets::Metal(gloss) => {
                let (towards, tint) = gloss.sample(from, random, more);
                (towards, 1.0, Some(tint))
            }
            Facets::Coat(coat) => {
                let (towards, share) = coat.reflect(from, [random[1], random[2]]);
                (towards, share, None)
            }
        };
        let direction = (frame * towards).normalize();
        Scattered { ray: Ray { origin: self.point, direction, from: self.face }, share, colour }
    }

    /// Density of [`Glossy::sample`] in a direction, per unit solid angle.
    pub fn density(&self, direction: DVec3) -> f64 {
        let inverse = frame_around(self.normal).transpose();
        let (o, i) = (inverse * self.from, inverse * direction);
        match self.facets {
            Facets::Metal(gloss) => gloss.density(o, i),
            Facets::Coat(coat) => coat.lobe(o, i),
        }
    }

    /// BSDF times cosine towards a direction, as two parts: what a white conductor or coat would have, and
    /// which part of that goes on.
    pub fn reflected(&self, direction: DVec3) -> [(f64, Tint<'t>); 2] {
        let inverse = frame_around(self.normal).transpose();
        let (o, i) = (inverse * self.from, inverse * direction);
        match self.facets {
            Facets::Metal(gloss) => gloss.parts(o, i),
            Facets::Coat(coat) => [coat.lobe(o, i), 0.0].map(|value| (value, Tint::of(&coat.white))),
        }
    }
}

impl<'s> Tracer<'s> {
    /// The facets that `ray` meets at `hit`, if a rough conductor or a coat is there.
    #[inline]
    pub fn glossy(&self, ray: &Ray, hit: &Hit) -> Option<Glossy<'_>> {
        let face = hit.face as usize;
        let material = self.scene.faces()[face].material as usize;
        let facets = match self.finishes.get(material)? {
            Finish::Plain => return None,
            Finish::Metal(gloss) => Facets::Metal(gloss),
            Finish::Coated(coat) => Facets::Coat(coat),
        };
        let normal = self.normal(face, hit.side);
        Some(Glossy { facets, point: self.point(hit), face: hit.face, normal, from: -ray.direction })
    }

    /// The way on from a mirror or glass that `ray` meets at `hit`, reflected, and the one refracted where
    /// there is one; their shares sum to 1.
    ///
    /// # Panics
    /// If the face is neither.
    pub fn ways_on(&self, ray: &Ray, hit: &Hit) -> (Scattered<'s>, Option<Scattered<'s>>) {
        let face = hit.face as usize;
        let origin = self.point(hit);
        let normal = self.normal(face, hit.side);
        let cosine = -ray.direction.dot(normal);
        let way = |direction: DVec3, share, colour| {
            let ray = Ray { origin, direction: direction.normalize(), from: hit.face };
            Scattered { ray, share, colour }
        };
        let reflected = ray.direction + normal * (2.0 * cosine);
        match &self.scene.material_of(face).surface {
            Surface::Mirror { reflectance } => (way(reflected, 1.0, Some(Tint::of(reflectance))), None),
            Surface::Dielectric { index, filter } => {
                let index = self.media.relative(face, *index);
                let ratio = if hit.side == Side::Front { index } else { 1.0 / index };
                // Snell: sin θ = ratio · sin θ′.
                let inside = 1.0 - (1.0 - cosine * cosine) / (ratio * ratio);
                if inside <= 0.0 {
                    return (way(reflected, 1.0, None), None);
                }
                let share = fresnel(cosine, ratio);
                let refracted = (ray.direction + normal * cosine) / ratio - normal * inside.sqrt();
                (way(reflected, share, None), Some(way(refracted, 1.0 - share, Some(Tint::of(filter)))))
            }
            Surface::Pane { index, filter } => {
                // What goes in is dimmed by the filter on each way across. What reflections between the
                // surfaces do is told for the mean of all channels.
                let clear = Tint::of(filter).mean();
                let Pane { through, back } = pane(cosine, *index, clear);
                let share = 1.0 - through;
                let white = if clear < 1.0 { (back / share - clear) / (1.0 - clear) } else { 0.0 };
                let back = Tint::towards_white(filter, white.clamp(0.0, 1.0));
                let second = way(ray.direction, through, Some(Tint::of(filter)));
                (way(reflected, share, Some(back)), Some(second))
            }
            Surface::Diffuse | Surface::Conductor { .. } | Surface::Plastic { .. } => {
                panic!("face {face} is neither mirror nor glass")
            }
        }
    }

    /// One of the ways on from a carrier, drawn with its share, or from a coat; nothing where it gets under
    /// the coat. The first random number chooses among the ways of mirrors and glass; facets use all three,
    /// and `more` where these do not suffice.
    #[inline]
    pub fn scatter(
        &self,
        ray: &Ray,
        hit: &Hit,
        random: [f64; 3],
        more: impl FnOnce() -> [f64; 4],
    ) -> Option<Scattered<'_>> {
        if let Some(glossy) = self.glossy(ray, hit) {
            let way = glossy.sample(random, more);
            return (random[0] < way.share).then_some(Scattered { share: 1.0, ..way });
        }
        let (first, second) = self.ways_on(ray, hit);
        Some(second.filter(|_| random[0] >= first.share).unwrap_or(first))
    }

    /// Whether light gets along a ray to this distance (normalised, or infinite) straight, through thin glass
    /// where it stands in the way; `parts` is multiplied by what that leaves of it, per channel.
    #[inline]
    pub fn passes(&self, ray: &Ray, distance: f64, parts: &mut [f64]) -> bool {
        if self.has_panes { self.passes_panes(ray, distance, parts) } else { self.is_clear(ray, distance) }
    }

    fn passes_panes(&self, ray: &Ray, mut distance: f64, parts: &mut [f64]) -> bool {
        let mut ray = *ray;
        for _ in 0..MOST_CARRIERS {
            let Some(hit) = self.closest_hit(&ray).filter(|hit| hit.distance < distance - SKIN) else {
                return true;
            };
            if !matches!(self.scene.material_of(hit.face as usize).surface, Surface::Pane { .. }) {
                return false;
            }
            let Some(through) = self.ways_on(&ray, &hit).1 else { return false };
            let tints = through.colour.into_iter().flat_map(Tint::parts);
            parts.iter_mut().zip(tints).for_each(|(part, tint)| *part *= through.share * tint);
            distance -= hit.distance;
            ray = through.ray;
        }
        false
    }

    /// Whether a ray that meets a carrier at `hit` goes straight on through it: thin glass lets it do so, as
    /// [`Tracer::passes`] knows.
    #[inline]
    pub fn goes_straight(&self, before: &Ray, hit: &Hit, after: &Ray) -> bool {
        let face = hit.face as usize;
        let normal = self.normal(face, hit.side);
        let is_pane = matches!(self.scene.material_of(face).surface, Surface::Pane { .. });
        is_pane && before.direction.dot(normal) * after.direction.dot(normal) > 0.0
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::{Face, FaceState, Material, Scene, SceneParts};
    use crate::trace::sampling::{Stream, cosine_hemisphere};

    /// A triangle in the plane z = 0 that fronts towards +z.
    fn sheet(material: Material) -> Scene {
        Scene::new(SceneParts {
            vertices: vec![
                DVec3::new(-9.0, -9.0, 0.0),
                DVec3::new(9.0, -9.0, 0.0),
                DVec3::new(0.0, 9.0, 0.0),
            ],
            faces: vec![Face {
                vertices: [0, 1, 2],
                normals: None,
                material: 0,
                object: 0,
                state: FaceState::Kept,
            }],
            materials: vec![material],
            objects: vec!["sheet".into()],
            ..Default::default()
        })
        .unwrap()
    }

    /// A ray in direction d that meets the sheet.
    fn towards(tracer: &Tracer, d: DVec3) -> (Ray, Hit) {
        let ray = Ray { origin: -0.1 * d, direction: d, from: Ray::FREE };
        (ray, tracer.closest_hit(&ray).expect("the sheet is met"))
    }

    #[test]
    fn fresnel_knows_normal_incidence_brewsters_angle_and_total_reflection() {
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-15);
        assert!((fresnel(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-15);
        // At tan θ = n nothing is reflected of one polarisation, and sin²(θ − θ′) of the other.
        let theta = 1.5f64.atan();
        let other = (theta.sin() / 1.5).asin();
        assert!((fresnel(theta.cos(), 1.5) - 0.5 * (theta - other).sin().powi(2)).abs() < 1e-15);
        assert_eq!(fresnel(0.7, 1.0 / 1.5), 1.0);
        assert!(fresnel(0.75, 1.0 / 1.5) < 1.0);
        assert!(fresnel(0.0, 1.5) == 1.0 && fresnel(0.3, 1.0) < 1e-30);
    }

    #[test]
    fn a_mirror_turns_a_ray_and_turns_it_back() {
        let scene = sheet(Material::mirror("mirror", &[0.8]));
        let tracer = Tracer::new(&scene);
        for d in [DVec3::new(0.6, 0.0, -0.8), DVec3::new(0.2, -0.3, 0.5).normalize()] {
            let (ray, hit) = towards(&tracer, d);
            let way = tracer.scatter(&ray, &hit, [0.5; 3], || [0.5; 4]).expect("a mirror sends all on");
            assert!((way.ray.direction - DVec3::new(d.x, d.y, -d.z)).length() < 1e-15);
            assert_eq!((way.share, way.colour), (1.0, Some(Tint::of(&[0.8]))));
            let (ray, hit) = towards(&tracer, -way.ray.direction);
            let back = tracer.scatter(&ray, &hit, [0.5; 3], || [0.5; 4]).expect("a mirror sends all on");
            assert!((back.ray.direction + d).length() < 1e-15);
        }
    }

    #[test]
    fn refraction_obeys_snell_and_is_reversible() {
        let scene = sheet(Material::dielectric("glass", 1.5, &[1.0]));
        let tracer = Tracer::new(&scene);
        for k in 0..100 {
            let [u, v, ..] = Stream::Callers.sequence(2, 0, 0).point(k);
            let d = -cosine_hemisphere([u, v]);
            let (ray, hit) = towards(&tracer, d);
            let (reflected, refracted) = tracer.ways_on(&ray, &hit);
            let refracted = refracted.expect("two ways");
            assert!((reflected.share + refracted.share - 1.0).abs() < 1e-15);
            let t = refracted.ray.direction;
            assert!((t.length() - 1.0).abs() < 1e-14 && t.z < 0.0);
            let across = |d: DVec3| DVec3::new(d.x, d.y, 0.0);
            assert!((across(d) - 1.5 * across(t)).length() < 1e-14);
            // Back the same way, as much is refracted.
            let (ray, hit) = towards(&tracer, -t);
            let back = tracer.ways_on(&ray, &hit).1.expect("two ways");
            assert!((back.ray.direction + d).length() < 1e-7 && (back.share - refracted.share).abs() < 1e-12);
        }
    }

    #[test]
    fn ways_are_drawn_with_their_shares() {
        let scene = sheet(Material::dielectric("glass", 1.5, &[1.0]));
        let tracer = Tracer::new(&scene);
        let (ray, hit) = towards(&tracer, DVec3::new(0.95, 0.0, -0.4).normalize());
        let share = tracer.ways_on(&ray, &hit).0.share;
        let n = 10_000;
        let reflected = (0..n).filter(|&k| {
            let chance = (f64::from(k) + 0.5) / f64::from(n);
            let way = tracer.scatter(&ray, &hit, [chance; 3], || [0.5; 4]);
            way.is_some_and(|way| way.ray.direction.z > 0.0)
        });
        assert!((reflected.count() as f64 / f64::from(n) - share).abs() < 1e-4);
    }
}
