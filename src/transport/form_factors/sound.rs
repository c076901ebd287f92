//! Soundness: what a file says of form factors, held against the geometry and against itself.
//!
//! A checksum tells what a disk has done to a file, not what somebody has. Whatever the numbers are, exchange
//! areas are finite, symmetric and close each row to the area of its patch, and rows name slots that the cut
//! has; so no entry can be other than it was and still pass.

use nalgebra::DMatrix;

use super::constants::{MOST_RAYS, OPEN, UNEVEN};
use crate::patches::Patches;
use crate::transport::exchange::Exchange;
use crate::transport::rows::{BATCHES, Recipe, Row, Rows};

/// Whether patches can have sent so many rays.
pub fn is_recipe(recipe: &Recipe) -> bool {
    let [rays, lamp_rays] = [recipe.count.rays, recipe.count.lamp_rays];
    (1..=MOST_RAYS).contains(&rays)
        && lamp_rays <= MOST_RAYS
        && rays.is_multiple_of(BATCHES)
        && lamp_rays.is_multiple_of(BATCHES)
}

/// Whether exchange areas are those of the patches whose mass they have.
pub fn is_exchange(exchange: &Exchange) -> bool {
    let is_share = |x: &f64| (0.0..=1.0).contains(x);
    let is_amount = |x: &f64| x.is_finite() && *x >= 0.0;
    let (_, scale) = exchange.raw();
    let sound = scale.iter().all(is_amount)
        && exchange.ends().leaving.iter().all(is_amount)
        && exchange.ends().slack.iter().all(is_amount)
        && exchange.ends().in_carriers.iter().flatten().all(|shares| shares.iter().all(is_share))
        && is_share(&exchange.shrinkage())
        && exchange.closure().before.is_finite();
    // Not "more than": what is no number fails too.
    sound && exchange.closure_error() <= OPEN && unevenness(exchange) <= UNEVEN
}

/// |xᵀSy − yᵀSx| by its size, for two vectors without order.
fn unevenness(exchange: &Exchange) -> f64 {
    let n = exchange.len();
    let vector = |step: f64| DMatrix::from_fn(n, 1, |i, _| 0.5 + (step * i as f64).fract());
    let [x, y] = [vector(0.618_033_988_749_895), vector(0.414_213_562_373_095)];
    let product_with = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
        let mut product = DMatrix::zeros(n, 1);
        exchange.apply(b, &mut product);
        a.dot(&product)
    };
    let [here, there] = [product_with(&x, &y), product_with(&y, &x)];
    let size = here.abs() + there.abs();
    if size > 0.0 { (here - there).abs() / size } else { here - there }
}

/// Whether there is a row for each patch.
pub fn has_all(rows: &Rows, patches: &Patches) -> bool {
    (0..patches.len()).all(|i| rows.of(patches.slot_of_patch(i)).is_some())
}

/// Whether rows are those of slots that there are.
pub fn is_rows(rows: &Rows, patches: &Patches) -> bool {
    let is_slot = |slot: u32| (slot as usize) < patches.slots();
    let all = rows.all();
    let ascending = all.windows(2).all(|pair| pair[0].slot < pair[1].slot);
    let is_sound = |row: &Row| {
        let shares = row.lamps.shares.iter();
        let mut moments = row.lamps.moments.iter().flatten().chain(&row.lamps.excess);
        is_slot(row.slot)
            && row.landings.iter().all(|end| end.slot().is_none_or(is_slot))
            && row.spots.iter().all(|spot| spot.weights().iter().all(|weight| *weight >= 0.0))
            && shares.clone().all(|share| is_slot(share.slot) && share.batch < BATCHES)
            && shares.clone().all(|share| (0.0..=1.0).contains(&share.share))
            && moments.all(|x| x.is_finite())
    };
    ascending && all.iter().all(is_sound) && rows.caustics.are_of(is_slot)
}
