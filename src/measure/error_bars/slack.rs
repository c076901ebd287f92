//! Slack: how much irradiance may be missing where rows of form factors could not be closed.
//!
//! Row i lacks s_i of A_i. If what it lacks lies where the rest of the row does, S_ij is too small by the
//! factor 1 + t_i + t_j, to first order, with t = s/(A − s): the irradiance that is missing is that of π F
//! (t∘L) + t∘(π F L), and what is reflected of it. That is as symmetric as S is, and puts back just the light
//! that is missing.

use nalgebra::DMatrix;

use super::constants::{CHANGE_TOLERANCE, CLOSED, SEES_NOTHING, SLACK_AT_MOST};
use crate::measure::MeasureError;
use crate::patches::Patches;
use crate::progress::Progress;
use crate::solve::roughly;
use crate::transport::Transport;

/// What the error by slack does not exceed where it is estimated so large: where the missing light lies is
/// not known.
pub(in crate::measure) fn at_most(estimated: f64) -> f64 {
    SLACK_AT_MOST * estimated
}

/// The irradiance per patch (n × c, W·m⁻²) that may be missing; `None` where rows close. `k` is of
/// constant elements, radiance and irradiance are means over patches. Rows that see nothing may miss the
/// scene's root mean square irradiance.
pub(super) fn missing(
    patches: &Patches,
    k: &Transport,
    [radiance, irradiance]: [&DMatrix<f64>; 2],
) -> Result<Option<DMatrix<f64>>, MeasureError> {
    let lacks =
        |exchange: &crate::transport::Exchange| exchange.ends().slack.sum() > CLOSED * exchange.sums().sum();
    let by_patch = k.factors();
    if !by_patch.exchanges().iter().any(lacks) {
        return Ok(None);
    }
    let share = |i: usize, c: usize| {
        let exchange = by_patch.exchange_of(c);
        exchange.ends().slack[i] / exchange.sums()[i]
    };
    let (n, channels) = radiance.shape();
    let t = DMatrix::from_fn(n, channels, |i, c| {
        let share = share(i, c);
        if share < 1.0 - SEES_NOTHING { share / (1.0 - share) } else { 0.0 }
    });
    let areas = DMatrix::from_column_slice(n, 1, patches.normalised_areas());
    let typical = |c: usize| {
        let squares = irradiance.column(c).component_mul(&irradiance.column(c)).dot(&areas);
        (squares / areas.sum()).sqrt()
    };
    let typical: Vec<f64> = (0..channels).map(typical).collect();
    let blind =
        DMatrix::from_fn(n, channels, |i, c| if share(i, c) < 1.0 - SEES_NOTHING { 0.0 } else { typical[c] });
    let direct = t.component_mul(&k.irradiance(radiance)) + k.irradiance(&t.component_mul(radiance)) + blind;
    let reflected = roughly(k, &k.reflect(&direct), CHANGE_TOLERANCE, Progress::default())?;
    Ok(Some(direct + k.irradiance(&reflected)))
}
