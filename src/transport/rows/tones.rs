//! Tones: channels that all carriers treat alike. They share their exchange areas; coloured carriers make
//! more tones than one.

use bytemuck::{Pod, Zeroable};

use crate::scene::Scene;
use crate::trace::Tint;
use crate::transport::TransportError;

/// The tones of a scene's carriers.
#[derive(Clone, Debug, PartialEq)]
pub struct Tones {
    /// The first channel of each tone; at least one.
    firsts: Vec<usize>,
    /// The tone of every channel.
    of_channel: Vec<usize>,
}

impl Tones {
    /// The most tones that a ray can tell apart.
    const MOST: usize = 16;

    /// One tone for all channels.
    pub fn one() -> Self {
        Self { firsts: vec![0], of_channel: Vec::new() }
    }

    /// Those of a scene.
    pub fn of(scene: &Scene) -> Self {
        let carriers = (0..scene.faces().len()).filter(|&face| scene.is_carrier(face));
        let mut numbers: Vec<u32> = carriers.map(|face| scene.faces()[face].material).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let colours: Vec<&[f64]> =
            numbers.iter().filter_map(|&m| scene.materials()[m as usize].surface.colour()).collect();
        let alike = |a: usize, b: usize| colours.iter().all(|colour| colour[a] == colour[b]);
        let mut firsts: Vec<usize> = Vec::new();
        let tone_of = |channel: usize| {
            firsts.iter().position(|&first| alike(first, channel)).unwrap_or_else(|| {
                firsts.push(channel);
                firsts.len() - 1
            })
        };
        let of_channel = (0..scene.channels()).map(tone_of).collect();
        Self { firsts, of_channel }
    }

    /// Makes sure that a ray can tell them apart.
    ///
    /// # Errors
    /// `Tones` if there are more than 16.
    pub fn check(&self) -> Result<(), TransportError> {
        let (tones, most) = (self.len(), Self::MOST);
        if tones > most { Err(TransportError::Tones { tones, most }) } else { Ok(()) }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.firsts.len()
    }

    /// The tone of a channel.
    pub fn of_channel(&self, channel: usize) -> usize {
        self.of_channel.get(channel).copied().unwrap_or(0)
    }

    /// The part of light that goes on in a tone.
    #[inline]
    pub fn part(&self, tone: usize, tint: Tint) -> f64 {
        tint.part(self.firsts[tone])
    }
}

/// The tones in which a ray goes on; the others have been absorbed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Survivors(u16);

impl Survivors {
    /// All tones.
    pub const ALL: Self = Self(u16::MAX);

    /// Whether the ray goes on in this tone.
    #[inline]
    pub fn contain(self, tone: usize) -> bool {
        self.0 >> tone & 1 == 1
    }

    /// Keeps those tones in which a carrier passes on more than `chance`; answers whether any is left.
    #[inline]
    pub fn meet(&mut self, tones: &Tones, tint: Tint, chance: f64) -> bool {
        let passed = |tone: &usize| chance < tones.part(*tone, tint);
        let kept = (0..tones.len()).filter(passed).fold(0, |kept, tone| kept | 1 << tone);
        self.0 &= kept;
        self.0 != 0
    }
}
