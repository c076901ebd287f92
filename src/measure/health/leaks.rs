//! Leaks: light that leaves a place which is all but closed.
//!
//! Light is followed from the lamps until it is absorbed or escapes. An open scene loses much of it, a closed
//! one none. Where a little escapes, the last rays of its paths are tilted more and more until they meet what
//! is beside the opening, which tells a narrow gap from a window. Without lamps every patch glows.

use glam::DVec3;
use rayon::prelude::*;

use super::constants::{LEAK_BOUNCES, MEASURED, NARROW, OPEN, OVERSIGHT, TILT_AXES, TILTS};
use super::{Finding, Grade, shape};
use crate::patches::{Facet, Patches};
use crate::scene::Side;
use crate::scene::triangle;
use crate::trace::sampling::{Discrete, SEQUENCE_END, Stream};
use crate::trace::{Destination, Ray, Tint, Tracer, sampling};

/// Paths of light that are followed: all points of a sequence.
const PATHS: u32 = SEQUENCE_END;

/// Which share of the light of lamps escapes.
///
/// Without lamps the insides and outsides of all things glow, and a leak shows only in a scene that has
/// hardly an outside.
pub(super) fn leaks(tracer: &Tracer, patches: &Patches, seed: u64) -> Finding {
    let starts = Starts::new(tracer, patches);
    if starts.by_power.total() == 0.0 {
        let finding = Finding::good("leaks", f64::NAN, None);
        return finding.but(
            Grade::Note,
            [],
            "nothing emits and no face sees another: there is no light to follow",
        );
    }
    let follow = |path| last_ray(tracer, starts.of(path), seed, path);
    let escaping: Vec<Ray> = (0..PATHS).into_par_iter().filter_map(follow).collect();
    let share = escaping.len() as f64 / f64::from(PATHS);
    let finding = Finding::good("leaks", share, Some("of light escapes"));
    if share == 0.0 || share >= OPEN {
        return finding;
    }
    let (width, beside) = openings(tracer, &escaping);
    let wide = match width.is_finite() {
        true => format!("about {} m wide", short(width * tracer.frame().scale())),
        false => "too wide to be measured".to_owned(),
    };
    match (width < 2.0 * NARROW, share < OVERSIGHT) {
        (true, true) => finding.but(
            Grade::Bad,
            beside,
            format!(
                "light is lost through gaps {wide} beside these faces: weld vertices that should coincide, or move one \
                 surface until it overlaps the other"
            ),
        ),
        (true, false) => finding.but(
            Grade::Note,
            beside,
            format!("much through gaps {wide} beside these faces: fine for blinds and grilles, else close them"),
        ),
        (false, _) => finding.but(
            Grade::Note,
            beside,
            format!(
                "through openings {wide} beside these faces: fine for doors and windows, else a face is missing there"
            ),
        ),
    }
}

/// A length with one significant digit.
fn short(metres: f64) -> String {
    let magnitude = metres.max(1e-12).log10().floor() as i32;
    format!("{metres:.*}", -magnitude.min(0) as usize)
}

/// Where light comes from.
struct Starts<'t> {
    facets: Vec<Facet<'t>>,
    by_power: Discrete,
}

impl<'t> Starts<'t> {
    /// The fronts of lamps; without lamps, all patches.
    fn new(tracer: &'t Tracer, patches: &Patches) -> Self {
        let scene = tracer.scene();
        let emission = |face: usize| scene.mean_emission(face).iter().sum::<f64>();
        let lamps = shape::kept(scene).filter(|&face| emission(face) > 0.0).map(|face| {
            let facet = Facet {
                face: face as u32,
                side: Side::Front,
                corners: *tracer.corners(face),
                normal: tracer.normal(face, Side::Front),
                coat: None,
            };
            (facet, emission(face))
        });
        let mut glowing: Vec<(Facet<'t>, f64)> = lamps.collect();
        if glowing.is_empty() {
            let slots = (0..patches.len()).map(|i| patches.slot_of_patch(i));
            glowing = slots.map(|slot| (patches.facet(tracer, slot), 1.0)).collect();
        }
        let power = |(facet, radiance): &(Facet, f64)| radiance * triangle::across(&facet.corners).length();
        let by_power = Discrete::new(glowing.iter().map(power));
        Self { by_power, facets: glowing.into_iter().map(|(facet, _)| facet).collect() }
    }

    /// Where a path starts; each facet has as many as is its share of the power.
    fn of(&self, path: u32) -> Facet<'t> {
        self.facets[self.by_power.draw((f64::from(path) + 0.5) / f64::from(PATHS)).0]
    }
}

/// The ray by which a path escapes, if it does.
fn last_ray(tracer: &Tracer, start: Facet, seed: u64, path: u32) -> Option<Ray> {
    let sequence = |bounce: u32| Stream::Leaks.sequence(seed, bounce, 0);
    let mut ray = start.rays(sequence(0), path..path + 1).next()?;
    if tracer.is_covered_towards((ray.origin, start.face), start.normal) {
        return None;
    }
    for bounce in 1..=LEAK_BOUNCES {
        let numbers = |k: u32| sequence(bounce).dimensions(path, k + 1);
        let survives = |colour: Tint, chance: f64| chance < colour.mean();
        let hit = match tracer.destination(&ray, numbers, survives) {
            Destination::Diffuse { hit, .. } => hit,
            Destination::Away(last) => return Some(last),
            Destination::Absorbed | Destination::Lost => return None,
        };
        let face = hit.face as usize;
        let [x, y, lives, _] = sequence(bounce).point(path);
        let material = tracer.scene().material_of(face);
        let reflectance = material.reflectance_of(hit.side);
        let texture = tracer.scene().reflectance_texture(face);
        let factors = texture.map_or([1.0; 3], |texture| texture.at(hit.barycentrics));
        let channels = reflectance.len() as f64;
        let reflected =
            reflectance.iter().zip(factors).map(|(rho, factor)| rho * factor).sum::<f64>() / channels;
        let through = material.transmittance().map_or(0.0, |tau| tau.iter().sum::<f64>() / channels);
        if lives >= reflected + through {
            break;
        }
        let side = if lives < reflected { hit.side } else { hit.side.other() };
        let frame = sampling::frame_around(tracer.normal(face, side));
        let direction = frame * sampling::cosine_hemisphere([x, y]);
        ray = Ray { origin: tracer.point(&hit), direction, from: hit.face };
    }
    None
}

/// The median width of the openings through which rays escape, normalised, and the faces beside the narrower
/// half of them, the most often met first.
fn openings(tracer: &Tracer, escaping: &[Ray]) -> (f64, Vec<usize>) {
    let step = escaping.len().div_ceil(MEASURED).max(1);
    let chosen = escaping.par_iter().step_by(step);
    let mut openings: Vec<Opening> = chosen.map(|ray| opening(tracer, ray)).collect();
    openings.sort_by(|a, b| a.width.total_cmp(&b.width));
    let width = openings.get(openings.len() / 2).map_or(f64::INFINITY, |opening| opening.width);
    let mut faces: Vec<u32> =
        openings.iter().take(openings.len() / 2 + 1).flat_map(|opening| opening.beside).flatten().collect();
    faces.sort_unstable();
    let mut votes: Vec<&[u32]> = faces.chunk_by(|a, b| a == b).collect();
    votes.sort_by_key(|votes| std::cmp::Reverse(votes.len()));
    (width, votes.into_iter().map(|votes| votes[0] as usize).collect())
}

/// What a ray escapes through: how wide it is where it is narrowest, and the faces on either side there.
struct Opening {
    width: f64,
    beside: [Option<u32>; 2],
}

fn opening(tracer: &Tracer, ray: &Ray) -> Opening {
    let along = |axis: usize| {
        let (sine, cosine) = (std::f64::consts::PI * axis as f64 / TILT_AXES as f64).sin_cos();
        let ways = [1.0, -1.0].map(|sign| edge_of(tracer, ray, [sign * cosine, sign * sine]));
        let half = |way: usize| ways[way].map_or(f64::INFINITY, |edge| edge.0);
        Opening { width: half(0) + half(1), beside: ways.map(|edge| edge.map(|edge| edge.1)) }
    };
    let widest = Opening { width: f64::INFINITY, beside: [None; 2] };
    (0..TILT_AXES).map(along).fold(widest, |best, next| if next.width < best.width { next } else { best })
}

/// How far beside a ray, in direction [x, y] across it, it would first be stopped, and by which face.
fn edge_of(tracer: &Tracer, ray: &Ray, [x, y]: [f64; 2]) -> Option<(f64, u32)> {
    let frame = sampling::frame_around(ray.direction);
    let normal = tracer.normal(ray.from as usize, Side::Front);
    TILTS.iter().find_map(|tilt| {
        let direction = (frame * DVec3::new(tilt * x, tilt * y, 1.0)).normalize();
        if normal.dot(direction) * normal.dot(ray.direction) <= 0.0 {
            // It would start into the face that it leaves: that face is the side of the opening.
            return Some((0.0, ray.from));
        }
        let hit = tracer.closest_hit(&Ray { direction, ..*ray })?;
        Some((hit.distance * tilt / (1.0 + tilt * tilt).sqrt(), hit.face))
    })
}
