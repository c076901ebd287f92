//! Receivers: what they measure, with as many rays as the accuracy takes that was asked for.

use nalgebra::DMatrix;

use super::goal::Tolerated;
use crate::measure::error_bars::{BOUND_95, ReceiverBars};
use crate::patches::Patches;
use crate::progress::Cancelled;
use crate::trace::Tracer;
use crate::transport::{LightOptions, Received};

/// The most rays of a receiver's point for an accuracy that is asked for; a number. Chosen, not fitted.
const MOST_RAYS: u32 = 1 << 18;

/// How many times as many rays each try has; a number. Chosen: its noise is half that of the one before.
const MORE_RAYS: u32 = 4;

/// How many times the error that is asked for a point of a receiver may have; by the definition of what is
/// asked for.
const POINT: f64 = 3.0;

/// The part of the error that is asked for which the noise of a receiver's own rays may take; chosen.
const QUIET: f64 = 0.7;

/// What the scene's receivers measure where surfaces send out this radiance (N × c, W·sr⁻¹·m⁻²); with more
/// rays until their noise leaves room for the error that is asked for, if one is.
///
/// # Errors
/// `Cancelled`.
///
/// # Panics
/// If `radiance` is no field over the patches.
pub fn receive<'a>(
    tracer: &'a Tracer,
    patches: &Patches,
    radiance: &DMatrix<f64>,
    light: &LightOptions,
    tolerated: Option<Tolerated>,
) -> Result<Vec<Received<'a>>, Cancelled> {
    let trace = |receiver| {
        let mut options = *light;
        loop {
            let received = Received::trace(tracer, patches, radiance, receiver, &options)?;
            options.rays = MORE_RAYS * received.rows.rays();
            if options.rays > MOST_RAYS || tolerated.is_none_or(|tolerated| is_quiet(&received, tolerated)) {
                return Ok(received);
            }
        }
    };
    tracer.scene().receivers().iter().map(trace).collect()
}

/// Whether the noise of a receiver's own rays leaves room for the error that is asked for, all over and at
/// every point.
fn is_quiet(received: &Received, tolerated: Tolerated) -> bool {
    let noise = received.rows.noise();
    let bars = DMatrix::from_fn(received.irradiance.nrows(), received.irradiance.ncols(), |i, c| {
        BOUND_95 * noise.variance(|field| field[(i, c)]).sqrt()
    });
    exceeds(&received.irradiance, &bars, (tolerated, QUIET)).is_none()
}

/// By which part of what it measures a receiver's error is larger than what is tolerated, over all of its
/// points or else at the point where it is the largest; none if it is no larger.
pub fn missed(bars: &ReceiverBars, tolerated: Tolerated) -> Option<f64> {
    exceeds(bars.irradiance(), &(BOUND_95 * &bars.points), (tolerated, 1.0))
}

/// The share of a receiver's irradiance by which its error (both m × c) is larger than a part of what is
/// tolerated: that over all points, or else at the point where it is the largest.
fn exceeds(irradiance: &DMatrix<f64>, bars: &DMatrix<f64>, (goal, part): (Tolerated, f64)) -> Option<f64> {
    let points = (irradiance.len() as f64).sqrt();
    let typical = irradiance.norm() / points;
    let most = part
        * match goal {
            Tolerated::Relative(share) => share * typical,
            Tolerated::Irradiance(h) => h,
        };
    let all = bars.norm() / points;
    if all > most {
        return Some(all / typical);
    }
    let at_point = |goal: Tolerated, h: f64| match goal {
        Tolerated::Relative(share) => part * POINT * share * h,
        Tolerated::Irradiance(wanted) => part * POINT * wanted,
    };
    let beyond = irradiance.iter().zip(bars).filter(|&(&h, &bar)| bar > at_point(goal, h));
    beyond.map(|(h, bar)| bar / h).max_by(f64::total_cmp)
}
