//! Places: power by face, and how it is told.

use std::collections::HashMap;

use nalgebra::DMatrix;

use super::{Answer, Cause, Level, Reason};

/// Power, W, that something concerns: by channel, and by face.
pub(super) struct Places {
    by_channel: Vec<f64>,
    by_face: HashMap<usize, f64>,
}

impl Places {
    pub fn new(channels: usize) -> Self {
        Self { by_channel: vec![0.0; channels], by_face: HashMap::new() }
    }

    /// Adds a power to a face.
    pub fn add(&mut self, face: usize, channel: usize, power: f64) {
        self.by_channel[channel] += power;
        *self.by_face.entry(face).or_insert(0.0) += power;
    }

    /// Whether nothing is concerned.
    pub fn is_empty(&self) -> bool {
        self.by_face.is_empty()
    }

    /// By channel, of all faces.
    pub fn by_channel(&self) -> &[f64] {
        &self.by_channel
    }

    /// The part of a whole by channel, such as the emitted power, in the channel where it is largest.
    pub fn share(&self, whole: &[f64]) -> f64 {
        let share = |(power, &whole): (&f64, &f64)| if whole > 0.0 { power / whole } else { 0.0 };
        self.by_channel.iter().zip(whole).map(share).fold(0.0, f64::max)
    }

    /// The faces, those with the most power first.
    pub fn faces(&self) -> Vec<usize> {
        let mut faces: Vec<(usize, f64)> = self.by_face.iter().map(|(&face, &power)| (face, power)).collect();
        faces.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        faces.into_iter().map(|(face, _)| face).collect()
    }

    pub fn reason(&self, answer: &Answer, cause: Cause, level: Level) -> Reason {
        let share = self.share(&answer.energy.emitted);
        Reason::new(cause, level, Some(share), self.faces(), answer.tracer.scene())
    }
}

/// π A |x| of a field of radiance, or A |x| of irradiance with `factor` 1, W, for the coefficients that
/// `is_wrong` picks.
pub(super) fn power(
    answer: &Answer,
    field: &DMatrix<f64>,
    factor: f64,
    is_wrong: impl Fn(usize, usize) -> bool,
) -> Places {
    let (patches, mass) = (answer.patches, answer.problem.operator().mass());
    let unit = mass.unit();
    let each = answer.problem.basis().coefficients();
    let mut places = Places::new(field.ncols());
    for (i, area) in mass.sums().iter().enumerate() {
        for c in (0..field.ncols()).filter(|&c| is_wrong(i, c)) {
            let power = factor * unit * area * field[(i, c)].abs();
            places.add(patches.place(i / each).face, c, power);
        }
    }
    places
}

/// A share with two digits.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        0.0 => "0 %".into(),
        x if x < 1e-3 => format!("{x:.1e} %"),
        x => format!("{x:.*} %", (1.0 - x.log10().floor()).clamp(0.0, 4.0) as usize),
    }
}
