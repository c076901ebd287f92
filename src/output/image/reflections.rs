//! Reflections: what is seen in mirrors and through glass.

use glam::DVec3;

use super::super::to_rgb;
use crate::trace::{Hit, Ray, Tracer};

/// Ways that bring less than this part of what is seen are left out, and so are all after so many carriers.
const LEAST: f64 = 1e-3;
const DEEPEST: u32 = 32;

/// The radiance that comes along `ray` by all ways over carriers, and what the ray met first; `radiance` tells that of diffuse surfaces.
pub(super) fn seen_along(
    tracer: &Tracer,
    ray: &Ray,
    radiance: &impl Fn(&Hit) -> Option<DVec3>,
) -> Option<(Hit, DVec3)> {
    let hit = tracer.closest_hit(ray)?;
    match tracer.is_carrier(hit.face) {
        false => Some((hit, radiance(&hit)?)),
        true => Some((hit, over_carriers(tracer, ray, &hit, radiance, DVec3::ONE, 0))),
    }
}

/// The part of what is seen that comes by way of a carrier.
fn over_carriers(
    tracer: &Tracer,
    ray: &Ray,
    hit: &Hit,
    radiance: &impl Fn(&Hit) -> Option<DVec3>,
    part: DVec3,
    depth: u32,
) -> DVec3 {
    let mut sum = DVec3::ZERO;
    let (first, second) = tracer.ways_on(ray, hit);
    for way in std::iter::once(first).chain(second) {
        let colour = way.colour.map_or(DVec3::ONE, |colour| to_rgb(colour).into());
        let part = part * colour * way.share;
        if part.max_element() < LEAST || depth == DEEPEST {
            continue;
        }
        let Some(next) = tracer.closest_hit(&way.ray) else { continue };
        sum += match tracer.is_carrier(next.face) {
            true => over_carriers(tracer, &way.ray, &next, radiance, part, depth + 1),
            false => part * radiance(&next).unwrap_or_default(),
        };
    }
    sum
}
