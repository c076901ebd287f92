//! Lit share: which part of the sides that light may reach it does reach, told by light paths backwards from
//! a few of them.
//!
//! Shape tells which side of a closed surface is lit. Of surfaces with a rim, such as furniture in a mesh of
//! loose parts, both sides may be, and some are not: the insides of closed cupboards, or what is sealed in
//! walls.

use rayon::prelude::*;

use crate::patches::Facet;
use crate::scene::{Side, triangle};
use crate::trace::sampling::{Discrete, Stream};
use crate::trace::{Arrival, Destination, Hit, Interaction, Lamps, Lights, Tint, Tracer};

/// Sides from which paths start; a number. Chosen, not fitted: the share is known to some 2 %.
const SIDES: u32 = 512;

/// Paths from each side, and surfaces that a path meets, at most; numbers. Chosen, not fitted: a side that
/// none of these lead from to light is dark, or gets little.
const PATHS: u32 = 16;
const BOUNCES: u32 = 16;

/// What light there is.
struct Light<'t> {
    tracer: &'t Tracer<'t>,
    lamps: Lamps,
    lights: Option<Lights>,
    has_sky: bool,
}

/// The part of these sides that light reaches: of fronts, and of backs; 1 where there are none. Sides count
/// by about as many patches as they would have.
pub(super) fn lit_share(tracer: &Tracer, sides: &[(usize, Side)]) -> [f64; 2] {
    let light = Light {
        tracer,
        lamps: Lamps::new(tracer),
        lights: Lights::new(tracer),
        has_sky: tracer.scene().sky().is_some(),
    };
    let area = |&(face, _): &(usize, Side)| triangle::area(tracer.corners(face));
    let mean = sides.iter().map(area).sum::<f64>() / sides.len().max(1) as f64;
    let by_patches = Discrete::new(sides.iter().map(|side| area(side) + mean));
    let drawn = if sides.is_empty() { 0 } else { SIDES };
    let found: Vec<(Side, bool)> = (0..drawn)
        .into_par_iter()
        .map(|k| {
            let [which, ..] = Stream::ForecastRows.sequence(0, 0, 0).point(k);
            let (face, side) = sides[by_patches.draw(which).0];
            (side, light.reaches(k, face, side))
        })
        .collect();
    Side::BOTH.map(|side| {
        let of_side = found.iter().filter(|found| found.0 == side);
        let (all, lit) =
            of_side.fold((0.0, 0.0), |(all, lit), found| (all + 1.0, lit + f64::from(u8::from(found.1))));
        if all > 0.0 { lit / all } else { 1.0 }
    })
}

impl Light<'_> {
    /// Whether any path backwards from a side leads to light; `k` is the number of the side among those
    /// drawn.
    fn reaches(&self, k: u32, face: usize, side: Side) -> bool {
        let facet = Facet::new(self.tracer, (face, side), *self.tracer.corners(face));
        (0..PATHS).any(|path| self.is_found(k, path, &facet))
    }

    /// Whether one path backwards from a side leads to light.
    fn is_found(&self, k: u32, path: u32, facet: &Facet) -> bool {
        let sequence = Stream::ForecastRows.sequence(0, 1 + path, 0);
        // Three sets of numbers for each surface, then those of carriers.
        let numbers = |bounce: u32, what: u32| sequence.dimensions(k, 3 * bounce + what);
        let [s, t, ..] = numbers(0, 0);
        let mut here = facet.interaction([s, t]);
        for bounce in 0..BOUNCES {
            if self.shines_on(&here, numbers(bounce, 1)) {
                return true;
            }
            let [.., x, y] = numbers(bounce, 2);
            let ray = here.ray(here.direction([x, y]));
            let of_carriers = |n: u32| sequence.dimensions(k, 3 * BOUNCES + n);
            let passes = |colour: Tint, _: f64| colour.parts().any(|part| part > 0.0);
            match self.tracer.destination(&ray, of_carriers, passes) {
                Destination::Away(_) => return self.has_sky,
                Destination::Diffuse { hit, .. } if self.emits(&hit) => return true,
                Destination::Diffuse { hit, .. } if self.sends_on(&hit) => {
                    here = Interaction::of(self.tracer, &hit)
                }
                _ => return false,
            }
        }
        false
    }

    fn emits(&self, hit: &Hit) -> bool {
        hit.side == Side::Front && self.tracer.scene().material_of(hit.face as usize).emits()
    }

    fn sends_on(&self, hit: &Hit) -> bool {
        self.tracer.scene().material_of(hit.face as usize).highest_albedo(hit.side) > 0.0
    }

    /// Whether lamps or lights without area shine straight on a point, by one look each.
    fn shines_on(&self, here: &Interaction, [u, v, x, y]: [f64; 4]) -> bool {
        let view = self.lamps.view_from(here.point, (&[here.point], here.normal));
        let by_lamp = self.lamps.sample(&view, [u, v]).is_some_and(|to| {
            here.geometry_term((to.point, to.normal)) > 0.0
                && self.tracer.unoccluded((here.point, here.face), (to.point, to.face))
        });
        by_lamp
            || self.lights.as_ref().is_some_and(|lights| {
                let [mut arrived, mut scratch] = [0, 1].map(|_| vec![0.0; self.tracer.scene().channels()]);
                let here = Arrival { place: *here, sky: None };
                lights.add_irradiance(self.tracer, &here, || [x, y], [&mut arrived, &mut scratch]);
                arrived.iter().any(|&x| x > 0.0)
            })
    }
}
