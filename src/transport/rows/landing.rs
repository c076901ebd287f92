//! Landing: where a ray ended; and where one left a patch and met another, for elements that vary over a
//! patch.

use bytemuck::{Pod, Zeroable};

use super::recipe::Setting;
use super::tones::Survivors;
use crate::patches::Barycentrics;
use crate::trace::sampling::Sequence;
use crate::trace::{Destination, Hit, Ray, Tint};

/// What becomes of light that ends elsewhere than on patches, as places in arrays: it escapes, carriers
/// absorb it, or it is given up after too many of them.
pub const ESCAPED: usize = 0;
pub const ABSORBED: usize = 1;
pub const LOST: usize = 2;

/// Where a ray ended, in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct End(u32);

impl End {
    /// Outside of the scene.
    pub const AWAY: Self = Self(u32::MAX);
    /// In a carrier.
    pub const ABSORBED: Self = Self(u32::MAX - 1);
    /// Given up after too many carriers.
    pub const LOST: Self = Self(u32::MAX - 2);
    /// Slots are fewer than 2³¹; this bit is set where a ray came by way of carriers.
    const CARRIED: u32 = 1 << 31;

    /// On a slot, straight.
    #[inline]
    pub fn on(slot: u32) -> Self {
        Self(slot)
    }

    /// On a slot, by way of carriers.
    #[inline]
    pub fn carried_to(slot: u32) -> Self {
        Self(slot | Self::CARRIED)
    }

    /// The slot, if it is on one.
    #[inline]
    pub fn slot(self) -> Option<u32> {
        (self.0 < Self::LOST.0).then_some(self.0 & !Self::CARRIED)
    }

    /// Whether it is on a slot, by way of carriers.
    pub fn is_carried(self) -> bool {
        self.0 < Self::LOST.0 && self.0 & Self::CARRIED != 0
    }
}

/// A place in a patch, to 1/256 of its legs: far less than what separates a patch's rays from each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Spot([u8; 2]);

impl Spot {
    /// Steps along a leg.
    pub const STEPS: f64 = 256.0;

    /// The place with these weights of the second and third corner, none negative and their sum 1 at most.
    pub fn at([u, v]: Barycentrics) -> Self {
        let u = (u * Self::STEPS).min(Self::STEPS - 1.0) as u8;
        // Rounding must not carry it over the third side.
        let v = (v * Self::STEPS).min(Self::STEPS - 1.0 - f64::from(u)) as u8;
        Self([u, v])
    }

    /// Steps from the first corner towards the second and the third.
    #[inline]
    pub fn steps(self) -> [f64; 2] {
        self.0.map(f64::from)
    }

    /// Weights of the three corners, none negative.
    #[inline]
    pub fn weights(self) -> [f64; 3] {
        Self::weights_of(self.steps(), 1.0)
    }

    /// The weights of corners summed over places: linear in the places' steps, and in their number.
    #[inline]
    pub fn weights_of(steps: [f64; 2], places: f64) -> [f64; 3] {
        // A place stands for the middle of the steps it was rounded down from.
        let [u, v] = steps.map(|steps| (steps + 0.5 * places) / Self::STEPS);
        [places - u - v, u, v]
    }
}

/// A ray between a patch and another, seen from the first of them; which of the two sent it does not matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Landing {
    /// The other patch.
    pub partner: u32,
    /// The ray's end in this patch.
    pub here: Spot,
    /// The ray's end in the other.
    pub there: Spot,
}

impl Landing {
    /// φ_a φ_b with a here and b there, at 3a + b.
    pub fn moments(self) -> [f64; 9] {
        let (here, there) = (self.here.weights(), self.there.weights());
        std::array::from_fn(|entry| here[entry / 3] * there[entry % 3])
    }

    /// The same ray seen from its other end; `patch` is this one.
    pub fn seen_from_there(self, patch: u32) -> Self {
        Self { partner: patch, here: self.there, there: self.here }
    }
}

/// Where a ray ends, and in which tones, carriers passed by the random numbers that follow those it was sent
/// by. Whether a carrier absorbs it is decided by chance, the same for all tones, so that what lands has all
/// its weight.
#[inline]
pub fn end_of(
    &Setting { tracer, patches, tones, .. }: &Setting,
    ray: &Ray,
    (sequence, point): (Sequence, u32),
) -> (End, Survivors, Option<Hit>) {
    let mut alive = Survivors::ALL;
    let numbers = |k: u32| sequence.dimensions(point, k + 1);
    let survives = |tint: Tint, chance: f64| alive.meet(tones, tint, chance);
    let (end, hit) = match tracer.destination(ray, numbers, survives) {
        Destination::Diffuse { hit, carried } => {
            let slot = patches.slot_at(hit.face as usize, hit.side, hit.barycentrics);
            (if carried { End::carried_to(slot) } else { End::on(slot) }, Some(hit))
        }
        Destination::Away(_) => (End::AWAY, None),
        Destination::Absorbed => (End::ABSORBED, None),
        Destination::Lost => (End::LOST, None),
    };
    (end, alive, hit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spot_is_where_it_was_put_and_never_outside() {
        let at = |u: f64, v: f64| Spot::at([u, v]).weights();
        for (u, v) in
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (1.0 / 3.0, 1.0 / 3.0), (0.999999, 1e-6)]
        {
            let [a, b, c] = at(u, v);
            assert!(a >= 0.0 && b > 0.0 && c > 0.0 && a + b + c == 1.0, "{a} {b} {c}");
            assert!((b - u).abs() <= 1.0 / 256.0 && (c - v).abs() <= 1.0 / 256.0, "{u} {v}: {b} {c}");
        }
    }
}
