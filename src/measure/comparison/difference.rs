//! Difference: how far a field is from a noisy estimate of it, with the noise taken off and its own
//! uncertainty.

use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};

use super::constants::{ROUNDING, TRUSTED_FREEDOM};
use crate::patches::Patches;
use crate::reference::PathTraced;

/// Of a field, its reference and that reference's noise over all places, area-weighted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Relative root mean square, the reference's noise taken off: √((ΣA d² − ΣA se²) / (ΣA H² − ΣA se²))
    /// over all channels; 0 where noise is all there is.
    pub rms: f64,
    /// Standard error of `rms`.
    pub uncertainty: f64,
    /// Root mean square of d/se: 1 if there is nothing but noise.
    pub z_rms: f64,
    /// ΣA d / ΣA H.
    pub bias: f64,
    /// Standard error of `bias`.
    pub bias_error: f64,
    /// Where d is largest beside its noise.
    pub worst: Worst,
    /// The chance that noise alone would make the differences so large: by their mean square, by their means
    /// per channel, and by the worst of them, each corrected for the number of chances it had.
    pub chance: [f64; 3],
}

/// The place where a field is farthest from its reference, in standard errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// Its number.
    pub place: usize,
    /// Its channel.
    pub channel: usize,
    /// d, W·m⁻².
    pub difference: f64,
    /// d relative to the root mean square of irradiance.
    pub relative: f64,
    /// d/se.
    pub z: f64,
}

/// One place of a comparison: a patch, or a side of a face.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub area: f64,
    /// Per channel: the field, its reference, and the reference's standard error.
    pub channels: Vec<[f64; 3]>,
    /// Of the standard errors.
    pub degrees_of_freedom: f64,
}

/// The patches of a field (n × c, W·m⁻²) as places.
pub(super) fn patches(field: &DMatrix<f64>, reference: &PathTraced) -> Vec<Place> {
    let place = |i: usize| Place {
        area: reference.area(i),
        channels: (0..field.ncols())
            .map(|c| {
                let known = reference.irradiance(i, c);
                [field[(i, c)], known.mean, known.standard_error]
            })
            .collect(),
        degrees_of_freedom: reference.degrees_of_freedom(i),
    };
    (0..reference.len()).map(place).collect()
}

/// The sides of faces as places, by the averages over their patches.
pub(super) fn faces(patches: &Patches, field: &DMatrix<f64>, reference: &PathTraced) -> Vec<Place> {
    let rows = patches.average_by_face(field).into_iter().zip(reference.by_face(patches));
    rows.map(|(face, known)| Place {
        area: face.area,
        channels: (0..face.mean.len())
            .map(|c| [face.mean[c], known.mean[c], known.standard_error[c]])
            .collect(),
        degrees_of_freedom: patches
            .patches_of(face.face, face.side)
            .map(|i| reference.degrees_of_freedom(i))
            .sum(),
    })
    .collect()
}

impl Difference {
    /// Of a field (n × c, W·m⁻²) from a path-traced reference, patch by patch.
    ///
    /// # Panics
    /// If the field has not one row per patch of the reference.
    pub fn new(field: &DMatrix<f64>, reference: &PathTraced) -> Self {
        assert_eq!(field.nrows(), reference.len(), "one row per patch");
        Self::over(&patches(field, reference))
    }

    /// Sums up over places.
    pub(super) fn over(places: &[Place]) -> Self {
        let channels = places.first().map_or(0, |place| place.channels.len());
        // Of the sum of A(d² − se²), its variance; channels of one path rise and fall together.
        let (mut excess, mut noise, mut whole, mut variance, mut noise_variance) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let (mut z_squares, mut count) = (0.0, 0.0);
        let mut bias = vec![[0.0; 2]; channels];
        for Place { area, channels, degrees_of_freedom } in places {
            let (mut here, mut own, mut along) = (0.0, 0.0, 0.0);
            for (&[value, mean, error], bias) in channels.iter().zip(&mut bias) {
                let d = value - mean;
                here += d * d;
                own += error * error;
                along += (d * d - error * error).max(0.0).sqrt() * error;
                whole += area * (mean * mean - error * error);
                bias[0] += area * d;
                bias[1] += (area * error).powi(2);
                if error > 0.0 {
                    z_squares += (d / error).powi(2);
                    count += 1.0;
                }
            }
            excess += area * (here - own);
            noise += area * own;
            let of_noise = 2.0 * (area * own).powi(2) * (1.0 + 1.0 / degrees_of_freedom.max(1.0));
            noise_variance += of_noise;
            variance += of_noise + 4.0 * (area * along).powi(2);
        }
        let root = |x: f64| if whole > 0.0 { (x.max(0.0) / whole).sqrt() } else { 0.0 };
        let sigma = variance.sqrt();
        let total: f64 = places.iter().flat_map(|p| p.channels.iter().map(|c| p.area * c[1])).sum();
        let relative = |x: f64| if total > 0.0 { x / total } else { 0.0 };
        let area: f64 = places.iter().map(|place| place.area * channels as f64).sum();
        let worst = worst(places);
        let worst =
            Worst { relative: worst.difference / (whole / area).max(f64::MIN_POSITIVE).sqrt(), ..worst };
        Self {
            rms: root(excess),
            uncertainty: 0.5 * (root(excess + sigma) - root(excess - sigma)),
            z_rms: (z_squares / f64::max(count, 1.0)).sqrt(),
            bias: relative(bias.iter().map(|b| b[0]).sum()),
            bias_error: relative(bias.iter().map(|b| b[1].sqrt()).sum()),
            worst,
            chance: [
                chance_of_mean_square(excess + noise, noise, noise_variance.max(spread(places, excess))),
                chance_of_means(&bias),
                places.get(worst.place).map_or(1.0, |place| {
                    chance_of_one(worst.z, place.degrees_of_freedom, places.len() * channels)
                }),
            ],
        }
    }
}

/// The largest |d/se|. Where the reference saw no spread at all, its typical noise stands in.
fn worst(places: &[Place]) -> Worst {
    let typical = typical_error(places);
    let mut worst = Worst::default();
    for (place, Place { channels, .. }) in places.iter().enumerate() {
        for (channel, &[value, mean, error]) in channels.iter().enumerate() {
            let difference = value - mean;
            let z = match if error > 0.0 { error } else { typical } {
                error if error > 0.0 => difference / error,
                // Nothing is known to be noisy: any difference is one.
                _ if difference.abs() > ROUNDING * mean.abs() => f64::INFINITY.copysign(difference),
                _ => 0.0,
            };
            if z.abs() > worst.z.abs() {
                worst = Worst { place, channel, difference, z, relative: 0.0 };
            }
        }
    }
    worst
}

/// √(ΣA se² / ΣA) over all channels.
pub(super) fn typical_error(places: &[Place]) -> f64 {
    let sum = |value: &dyn Fn(&Place) -> f64| places.iter().map(value).sum::<f64>();
    let squares = sum(&|p| p.area * p.channels.iter().map(|c| c[2] * c[2]).sum::<f64>());
    (squares / sum(&|p| p.area * p.channels.len() as f64).max(f64::MIN_POSITIVE)).sqrt()
}

/// Variance of ΣA(d² − se²) = `excess` as its own terms show it, as far as they come from few batches: noise
/// may have longer tails than the normal distribution, and a standard error from few batches may be far too
/// small.
fn spread(places: &[Place], excess: f64) -> f64 {
    let mean = excess / places.iter().map(|place| place.area).sum::<f64>().max(f64::MIN_POSITIVE);
    let variance = |place: &Place| {
        let here: f64 =
            place.channels.iter().map(|&[value, mean, error]| (value - mean).powi(2) - error * error).sum();
        (place.area * (here - mean)).powi(2) * (TRUSTED_FREEDOM / place.degrees_of_freedom.max(1.0)).min(1.0)
    };
    places.iter().map(variance).sum()
}

/// Of ΣA d² to be so large if its mean is ΣA se² and its variance known: a scaled χ² of as many degrees of
/// freedom as these two ask for (Satterthwaite 1946).
fn chance_of_mean_square(squares: f64, mean: f64, variance: f64) -> f64 {
    if mean == 0.0 {
        return if squares > 0.0 { 0.0 } else { 1.0 };
    }
    let freedom = 2.0 * mean * mean / variance;
    ChiSquared::new(freedom).map_or(1.0, |chi| chi.sf(squares / mean * freedom))
}

/// Of any channel's ΣA d to be so large.
fn chance_of_means(bias: &[[f64; 2]]) -> f64 {
    let z = bias.iter().filter(|b| b[1] > 0.0).map(|b| b[0].abs() / b[1].sqrt()).fold(0.0, f64::max);
    let single = 2.0 * Normal::standard().sf(z);
    one_of(single, bias.len())
}

/// Of the worst of `count` values to lie z standard errors off, if that one has so many degrees of freedom.
pub(super) fn chance_of_one(z: f64, degrees_of_freedom: f64, count: usize) -> f64 {
    let single = StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0)).map_or(1.0, |t| 2.0 * t.sf(z.abs()));
    one_of(single, count)
}

/// The chance that at least one of `count` happens, each with chance `single` (Šidák 1967).
fn one_of(single: f64, count: usize) -> f64 {
    -f64::exp_m1(count as f64 * f64::ln_1p(-single.min(1.0)))
}
