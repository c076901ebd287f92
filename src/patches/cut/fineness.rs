//! Fineness: how long the legs of patches may be, everywhere alike or longer on surroundings.

/// How many times their distance from all else legs on surroundings may be long, and as much more as these
/// are coarser next to it than all else is; a ratio. Chosen: what is seen of a patch from elsewhere is then
/// nearly all the same.
const GROWTH: f64 = 0.5;

/// How long the legs of patches may be; normalised lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fineness {
    /// On all but the surroundings.
    pub edge: f64,
    /// On the surroundings: next to all else, and how many times the distance from it more.
    pub around: [f64; 2],
    /// Longer faces fall into parts along contacts.
    whole: f64,
}

impl Fineness {
    /// Legs up to `edge`, and on surroundings as `around` says.
    pub fn new(edge: f64, around: [f64; 2]) -> Self {
        Self { edge, around, whole: edge }
    }

    /// The same everywhere.
    pub fn even(edge: f64) -> Self {
        Self::new(edge, [edge, 0.0])
    }

    /// On surroundings so many times as long next to all else, and the longer the farther away.
    pub fn growing(edge: f64, coarser: f64) -> Self {
        Self::new(edge, [coarser * edge, coarser * GROWTH])
    }

    /// Whether the numbers make sense.
    pub fn is_sound(self) -> bool {
        let [near, growth] = self.around;
        [self.edge, near].into_iter().all(|length| length.is_finite() && length > 0.0)
            && growth.is_finite()
            && growth >= 0.0
    }

    /// All legs so many times as long.
    pub fn scaled(self, factor: f64) -> Self {
        Self::new(self.edge * factor, self.around.map(|length| length * factor))
    }

    /// Legs so many times as long within the same parts.
    pub fn coarser(self, factor: f64) -> Self {
        Self { whole: self.whole, ..self.scaled(factor) }
    }

    /// Whether a face that is so long falls into parts along contacts.
    pub fn parts(self, longest: f64) -> bool {
        longest > self.whole
    }

    /// Whether surroundings are cut by their distance.
    pub fn grows(self) -> bool {
        self.around[1] > 0.0
    }

    /// On the surroundings at some distance from all else.
    pub fn at(self, distance: f64) -> f64 {
        self.around[0] + self.around[1] * distance
    }
}
