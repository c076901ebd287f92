//! Tint: the colour that a carrier gives to light.

/// Which part of light a carrier passes on, per channel: c + (1 − c)·w of a colour c, where w leads from c to
/// white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tint<'t> {
    colour: &'t [f64],
    white: f64,
}

impl<'t> Tint<'t> {
    /// The colour itself.
    pub fn of(colour: &'t [f64]) -> Self {
        Self { colour, white: 0.0 }
    }

    /// A colour, the part `white` of the way to white.
    pub fn towards_white(colour: &'t [f64], white: f64) -> Self {
        Self { colour, white }
    }

    /// Number of channels.
    #[inline]
    pub fn channels(self) -> usize {
        self.colour.len()
    }

    /// The part of one channel, 0 to 1.
    #[inline]
    pub fn part(self, channel: usize) -> f64 {
        let colour = self.colour[channel];
        colour + (1.0 - colour) * self.white
    }

    /// The part of every channel.
    #[inline]
    pub fn parts(self) -> impl Iterator<Item = f64> + 't {
        self.colour.iter().map(move |colour| colour + (1.0 - colour) * self.white)
    }

    /// The mean of all channels.
    #[inline]
    pub fn mean(self) -> f64 {
        self.parts().sum::<f64>() / self.colour.len() as f64
    }
}
