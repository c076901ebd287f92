//! Bright light: what few patches on which much light falls send straight to others.
//!
//! Rays of rows find a sunlit spot seldom, and what it sends is noise: where many patches are bright, they
//! send many rays by themselves, but not where few are. So what these reflect of the light without area is
//! brought by points drawn on them, H_b = E\[π E_b V g/p\], as lamps are looked for, and the operator carries
//! the rest: H = H₀ + H_b + πF(L − E_b). That is the operator's own answer and a correction, H_b − πF E_b,
//! which is known before any solve and counts from order 1 on. H_b is scaled to deliver the flux that the
//! operator delivers of E_b: the correction brings no power.

use nalgebra::{DMatrix, DVector};

use super::pairs::Pairs;
use super::{LightOptions, RAYS_PER_LIGHT_RAY, Sources};
use crate::patches::{Basis, Patches};
use crate::progress::Cancelled;
use crate::scene::{Side, triangle};
use crate::trace::sampling::Stream;
use crate::trace::{LampPoint, Lamps, Tracer};
use crate::transport::Transport;

/// Patches are bright that reflect so many times as much light without area as all do on average; a number.
/// Chosen, not fitted.
const BRIGHT: f64 = 4.0;

/// The least part of Σ A E² that bright patches have where they are looked for: the noise of rows goes by it.
/// Chosen, not fitted.
const LEAST_PART: f64 = 0.5;

/// The most bright patches that are looked for; a number. Measured: with 18 of 8000 patches the noise of the
/// others falls seven times, with some hundreds it is no less at equal time.
const MOST: usize = 256;

/// What bright patches send straight to others.
#[derive(Clone, Debug, PartialEq)]
pub struct BrightLight {
    /// E_b = ρH₀/π of bright patches, N × c, W·sr⁻¹·m⁻²; 0 elsewhere.
    pub radiance: DMatrix<f64>,
    /// H_b − πF E_b, N × c, W·m⁻². Its flux is 0.
    pub correction: DMatrix<f64>,
}

impl BrightLight {
    /// The same after a linear map, such as means over clusters.
    pub(crate) fn map(&self, map: impl Fn(&DMatrix<f64>) -> DMatrix<f64>) -> Self {
        Self { radiance: map(&self.radiance), correction: map(&self.correction) }
    }
}

impl Sources {
    /// The same with what bright patches send straight to others, where there are a few such and form factors
    /// were found by rays. Not where light goes on from mirrors, metals, glass and plastic: rows find what
    /// comes that way of bright patches, too.
    ///
    /// # Errors
    /// `Cancelled`.
    ///
    /// # Panics
    /// If the operator is not of these coefficients.
    pub fn with_bright_light(
        mut self,
        tracer: &Tracer,
        patches: &Patches,
        k: &Transport,
        options: &LightOptions,
    ) -> Result<Self, Cancelled> {
        let is_of_use = k.factors().rays() > 0 && !tracer.has_carriers();
        let Some(direct) = self.direct.as_ref().filter(|_| is_of_use) else { return Ok(self) };
        let mut radiance = k.reflect(direct);
        let bright = brightest(patches, k, &k.basis().means(&radiance), &Lamps::new(tracer));
        if bright.is_empty() {
            return Ok(self);
        }
        let each = k.basis().coefficients();
        keep(&mut radiance, &bright, each);
        let part = |&i: &usize| {
            let place = patches.place(i);
            let corners = patches.corners(i).map(|at| triangle::point(tracer.corners(place.face), at));
            let brightness = radiance.rows(each * i, each).mean();
            ((place.face, place.side), corners, brightness.max(0.0))
        };
        let pairs = Pairs {
            tracer,
            patches,
            lamps: Lamps::of_parts(tracer, bright.iter().map(part)),
            radiance: |to: &LampPoint, sent: &mut [f64]| {
                let patch = bright[to.lamp];
                // Corners are wound as the side is seen.
                let [u, v] = to.barycentrics;
                let at = if patches.place(patch).side == Side::Back { [v, u] } else { [u, v] };
                let of_patch = radiance.rows(each * patch, each);
                let weights = triangle::weights(at);
                for (sent, column) in sent.iter_mut().zip(of_patch.column_iter()) {
                    *sent = match k.basis() {
                        Basis::Constant => column[0],
                        Basis::Linear => column.iter().zip(weights).map(|(sent, weight)| weight * sent).sum(),
                    };
                }
            },
            channels: radiance.ncols(),
            count: options.rays.div_ceil(RAYS_PER_LIGHT_RAY),
            stream: Stream::BrightLight,
            seed: options.seed,
        };
        let mut parts = pairs.irradiance(k.basis(), options.progress)?;
        let by_operator = k.irradiance(&radiance);
        let flux = |field: &DMatrix<f64>| field.tr_mul(k.mass().sums());
        let (wanted, found) = (flux(&by_operator), parts.iter().map(flux).sum::<DVector<f64>>());
        // What only rays have found can't be scaled.
        if wanted.iter().zip(&found).any(|(&wanted, &found)| wanted > 0.0 && found <= 0.0) {
            return Ok(self);
        }
        let factors = wanted.zip_map(&found, |wanted, found| if found > 0.0 { wanted / found } else { 0.0 });
        for part in &mut parts {
            part.column_iter_mut().zip(&factors).for_each(|(mut column, factor)| column *= *factor);
        }
        let correction = self.add_noise(parts) - by_operator;
        self.bright = Some(BrightLight { radiance, correction });
        Ok(self)
    }
}

/// The patches that reflect much more light than most, if they are few and make most of the noise.
fn brightest(patches: &Patches, k: &Transport, radiance: &DMatrix<f64>, lamps: &Lamps) -> Vec<usize> {
    // What leaves the scene makes no noise.
    let seen = k.basis().means(&k.irradiance(&DMatrix::from_element(k.len(), k.channels(), 1.0)));
    let areas = patches.normalised_areas().iter().zip(seen.row_iter());
    let areas: Vec<f64> = areas.map(|(area, seen)| area * seen.mean()).collect();
    let light: Vec<f64> = radiance.row_iter().map(|row| row.mean()).collect();
    let sum = |of: &dyn Fn(usize) -> f64| (0..patches.len()).map(|i| areas[i] * of(i)).sum::<f64>();
    let mean = sum(&|i| light[i]) / sum(&|_| 1.0);
    let is_lamp = |i: usize| lamps.contains(patches.place(i).face, patches.place(i).side);
    let bright: Vec<usize> =
        (0..patches.len()).filter(|&i| light[i] > BRIGHT * mean && !is_lamp(i)).collect();
    let noise = |i: usize| areas[i] * light[i] * light[i];
    let part = bright.iter().map(|&i| noise(i)).sum::<f64>() / (0..patches.len()).map(noise).sum::<f64>();
    if part > LEAST_PART && bright.len() <= MOST { bright } else { Vec::new() }
}

/// Leaves only the rows of some patches, `each` of one patch.
fn keep(field: &mut DMatrix<f64>, patches: &[usize], each: usize) {
    let mut kept = DMatrix::zeros(field.nrows(), field.ncols());
    for i in patches {
        kept.rows_mut(each * i, each).copy_from(&field.rows(each * i, each));
    }
    *field = kept;
}
