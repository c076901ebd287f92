//! Streams: the one register of what random numbers are drawn for.
//!
//! A scrambling belongs to a seed, a stream number and an index. A stream owns the 2³² stream numbers s·2³²
//! to s·2³² + 2³² − 1, with s the number of its variant; its users tell their slots, faces or lights apart by
//! an *offset* into them. Offsets are of 32 bits and the compiler refuses two variants of one number, so no
//! two streams can share a number. Nothing else makes a [`Sequence`].

use std::ops::{Range, RangeInclusive};

use super::{SEQUENCE_END, Sequence};

macro_rules! streams {
    ($($(#[$doc:meta])* $name:ident = $number:literal,)*) => {
        /// What random numbers are drawn for.
        ///
        /// After each colon: what the offset is, and what the index is where it is not 0. Numbers are never
        /// given to another purpose: other numbers are other results under the same seed, and files of form
        /// factors rely on that of `Rays`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub enum Stream {
            $($(#[$doc])* $name = $number,)*
        }

        impl Stream {
            /// Every stream.
            pub const ALL: &[Self] = &[$(Self::$name,)*];
        }
    };
}

streams! {
    /// Rays of rows: stretches by slot; the batch.
    Rays = 0,
    /// Points on a patch and on lamps for lamp columns: stretches by slot; the batch.
    LampPairs = 1,
    /// Shots from lamps at carriers: stretches by slot; the batch.
    LampShots = 2,
    /// Points on a patch and on lights without area: stretches by slot; the light.
    Lights = 3,
    /// Directions from a patch into the sky: stretches by slot; 0, or 1 where there are more of them.
    Sky = 4,
    /// Shots from lights without area at carriers: the light; block and part.
    LightShots = 5,
    /// Shots from the sky at carriers: 0; block and part.
    SkyShots = 6,
    /// Rays from a patch into the sky by way of carriers: stretches by slot; the part.
    CarriedSky = 7,
    /// Points on a patch and on lamps for direct light alone: stretches by slot.
    DirectLight = 8,
    /// Rays from lamps that tell what of their light does not arrive straight: 0; the part.
    LampRays = 9,
    /// Rays from receivers and points on lamps: stretches by point; the batch.
    Receivers = 10,
    /// Lights without area seen from receivers: stretches by point; the batch.
    ReceiverLights = 11,
    /// Shots from lights without area through receivers: the light; the sequence.
    Crossings = 12,
    /// Directions in which a slot looks for what light reaches: the slot.
    Looks = 13,
    /// Points on a slot and on lamps by which light is found to reach it: the slot.
    LampLooks = 14,
    /// Points on a slot by which lights without area are found to reach it: the slot.
    LightLooks = 15,
    /// Directions in which a slot looks for the sky by way of carriers: the slot.
    SkyLooks = 16,
    /// Shots from lights without area by which they are found to reach slots: the light; the block.
    ReachingShots = 17,
    /// Points of a patch at which the field of another cut is read: stretches by slot.
    Resampling = 18,
    /// Places that stand for rows where cost is predicted: 0.
    ForecastRows = 19,
    /// Places that stand for columns where cost is predicted: 0.
    ForecastColumns = 20,
    /// Places on carriers where cost is predicted: 0.
    ForecastCarriers = 21,
    /// Directions in which a place looks for the medium around it: 0.
    Media = 22,
    /// Light paths of the path tracer: twice the slot, plus the half; the batch.
    Paths = 23,
    /// Photons of the path tracer: the light; the batch.
    Photons = 24,
    /// Rays from lamps by which their views are judged: the face; the side.
    LampViews = 25,
    /// Paths by which leaks are found: the bounce.
    Leaks = 26,
    /// Samples of pixels: the batch; the square of pixels.
    Pixels = 27,
    /// Lobes of rough conductors and coats in pictures: the sequence; the pixel.
    Lobes = 28,
    /// Photons of lights that stand right in front of a face: the light; the batch.
    NearPhotons = 30,
    /// Directions in which lights and receivers look around: their number; 0 for lights and 1 for receivers.
    Placement = 31,
    /// Points on bright parts of faces seen from receivers: stretches by point; the batch.
    ReceiverBright = 33,
    /// Rays from suns and the sky by which they are found to reach slots: the aperture; twice the light, plus
    /// 1 for those on all of the scene.
    ReachingRays = 35,
    /// Points on a patch and on apertures through which sun may come: 0; the light.
    SunThrough = 34,
    /// Rays by which faces are found to have nothing over or under them: the face; the side.
    Surroundings = 36,
    /// Points on a patch and on bright patches: stretches by slot.
    BrightLight = 37,
    /// Rays from lights with a place by which they are found to reach slots: the light.
    PlacedRays = 38,
    /// Directions from narrow spots to what they shine on: 0; the light.
    Narrow = 39,
    /// Lines by which apertures are judged: the candidate; the side.
    Apertures = 32,
    /// What callers of this library draw for purposes of their own, tests among them: anything; anything.
    Callers = 29,
}

impl Stream {
    /// The stream numbers that only this stream uses.
    pub const fn numbers(self) -> RangeInclusive<u64> {
        let first = (self as u64) << u32::BITS;
        first..=first + u32::MAX as u64
    }

    /// The scrambling of an offset and an index under a user's seed.
    pub fn sequence(self, seed: u64, offset: u32, index: u64) -> Sequence {
        Sequence::of(seed, self.numbers().start() + u64::from(offset), index)
    }

    /// Where place `place` finds its `count` points under an index: a sequence and a stretch of it.
    ///
    /// Neighbouring places take neighbouring stretches of one sequence, so that their points complement each
    /// other: what is averaged over many places converges faster than each place by itself.
    pub fn stretch(self, seed: u64, place: u32, index: u64, count: u32) -> (Sequence, Range<u32>) {
        let places = SEQUENCE_END / count.max(1);
        let first = place % places * count;
        (self.sequence(seed, place / places, index), first..first + count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_streams_share_a_number() {
        let mut ranges: Vec<_> = Stream::ALL.iter().map(|stream| stream.numbers()).collect();
        ranges.sort_by_key(|range| *range.start());
        for pair in ranges.windows(2) {
            assert!(pair[0].end() < pair[1].start(), "{pair:?}");
        }
        assert!(ranges.iter().all(|range| range.end() - range.start() == u64::from(u32::MAX)));
    }

    #[test]
    fn whatever_the_offset_a_sequence_is_of_its_own_stream() {
        let places = [0, 1, (1 << 31) - 1, u32::MAX];
        for &stream in Stream::ALL {
            let own = |number: u64| stream.numbers().contains(&number);
            for offset in places {
                let number = stream.numbers().start() + u64::from(offset);
                assert!(own(number), "{stream:?} {offset}");
                assert_eq!(stream.sequence(3, offset, 5), Sequence::of(3, number, 5));
            }
            for (place, count) in places.into_iter().flat_map(|place| [0, 1, 3, 1 << 16].map(|n| (place, n)))
            {
                let (sequence, points) = stream.stretch(3, place, 5, count);
                let number = stream.numbers().start() + u64::from(place / (SEQUENCE_END / count.max(1)));
                assert!(own(number) && sequence == Sequence::of(3, number, 5), "{stream:?} {place} {count}");
                assert!(points.len() == count as usize && points.end <= SEQUENCE_END, "{place} {count}");
            }
        }
    }
}
