//! Specular path: a ray followed over mirrors, metals, glass and coats, by one way at each, to where it ends.

use crate::trace::limits::MOST_CARRIERS;
use crate::trace::{Hit, Ray, RayHit, Tint, Tracer};

/// Where a ray ends once carriers have passed it on.
#[derive(Clone, Copy, Debug)]
pub enum Destination {
    /// On a diffuse surface.
    Diffuse {
        /// Where.
        hit: Hit,
        /// Whether it came by way of carriers or coats.
        carried: bool,
    },
    /// Outside of the scene, by this last ray.
    Away(Ray),
    /// In a carrier.
    Absorbed,
    /// Nowhere: it was given up after as many carriers and coats as a path may meet.
    Lost,
}

/// What decides where a path goes, and watches it go.
pub(crate) trait SpecularPath {
    /// It is given up as lost after so many surfaces.
    const MOST: u32 = MOST_CARRIERS;

    /// Random numbers, uniform: four for every surface that is met, and sometimes four more.
    fn numbers(&mut self) -> [f64; 4];

    /// Called where a ray has met a surface.
    fn meets(&mut self, _ray: &Ray, _hit: &Hit) {}

    /// Whether the path goes on where this part of its power does, by another random number.
    fn survives(&mut self, colour: Tint, chance: f64) -> bool;

    /// Called with the ray before and after a surface that passes it on.
    fn goes_on(&mut self, _before: &Ray, _hit: &Hit, _after: &Ray) {}
}

impl Tracer<'_> {
    /// Follows a path on from the first carrier or coat that it has met, until it meets a diffuse surface,
    /// gets under a coat or ends elsewhere.
    #[inline]
    pub(crate) fn follow_path<P: SpecularPath>(
        &self,
        RayHit { mut ray, mut hit }: RayHit,
        path: &mut P,
    ) -> Destination {
        for count in 0..P::MOST {
            path.meets(&ray, &hit);
            let [way, life, u, v] = path.numbers();
            let Some(scattered) = self.scatter(&ray, &hit, [way, u, v], || path.numbers()) else {
                return Destination::Diffuse { hit, carried: count > 0 };
            };
            if scattered.colour.is_some_and(|colour| !path.survives(colour, life)) {
                return Destination::Absorbed;
            }
            path.goes_on(&ray, &hit, &scattered.ray);
            ray = scattered.ray;
            match self.closest_hit(&ray) {
                None => return Destination::Away(ray),
                Some(next) if !self.may_go_on(next.face) => {
                    return Destination::Diffuse { hit: next, carried: true };
                }
                Some(next) => hit = next,
            }
        }
        Destination::Lost
    }

    /// Follows a ray, by one way at every carrier and coat, until it meets a diffuse surface, gets under a
    /// coat or ends elsewhere.
    ///
    /// `numbers(k)` gives random numbers, k counting from 0: four for every carrier, and sometimes four more.
    /// `survives(colour, chance)` decides, by another of them, whether the ray goes on where that part of its
    /// power does.
    #[inline]
    pub fn destination(
        &self,
        ray: &Ray,
        numbers: impl FnMut(u32) -> [f64; 4],
        survives: impl FnMut(Tint, f64) -> bool,
    ) -> Destination {
        match self.closest_hit(ray) {
            None => Destination::Away(*ray),
            Some(hit) if !self.may_go_on(hit.face) => Destination::Diffuse { hit, carried: false },
            Some(hit) => self.follow(RayHit { ray: *ray, hit }, numbers, survives, |_, _, _| {}),
        }
    }

    /// Follows a ray on from the carrier that it has met, as [`Tracer::destination`] does; calls
    /// `goes_on(before, hit, after)` with the ray before and after each carrier.
    #[inline]
    pub fn follow(
        &self,
        met: RayHit,
        numbers: impl FnMut(u32) -> [f64; 4],
        survives: impl FnMut(Tint, f64) -> bool,
        goes_on: impl FnMut(&Ray, &Hit, &Ray),
    ) -> Destination {
        self.follow_path(met, &mut PathByFunctions { taken: 0, numbers, survives, goes_on })
    }
}

/// A path that functions decide.
struct PathByFunctions<N, S, G> {
    taken: u32,
    numbers: N,
    survives: S,
    goes_on: G,
}

impl<N, S, G> SpecularPath for PathByFunctions<N, S, G>
where
    N: FnMut(u32) -> [f64; 4],
    S: FnMut(Tint, f64) -> bool,
    G: FnMut(&Ray, &Hit, &Ray),
{
    #[inline]
    fn numbers(&mut self) -> [f64; 4] {
        self.taken += 1;
        (self.numbers)(self.taken - 1)
    }

    #[inline]
    fn survives(&mut self, colour: Tint, chance: f64) -> bool {
        (self.survives)(colour, chance)
    }

    #[inline]
    fn goes_on(&mut self, before: &Ray, hit: &Hit, after: &Ray) {
        (self.goes_on)(before, hit, after);
    }
}
