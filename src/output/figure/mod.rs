//! Figures: pictures and plots with words, to be read without the program.
//!
//! [`write_comparison`] holds an answer against a reference, [`write_bounces`] shows how light builds up
//! bounce by bounce, [`write_orders_plot`] how the error of the series falls with its order, and
//! [`write_false_colours`] how much light falls or leaves where. [`write_study_plot`] shows what accuracy
//! costs in time, [`write_knobs_plot`] what each knob of it does alone.

mod axes;
mod bounces;
mod canvas;
mod comparison;
mod diverging;
mod false_colours;
mod knobs;
mod loglog;
mod multiples;
mod orders;
mod panel;
mod study;
mod text;

pub use bounces::{BouncePictures, write_bounces};
pub use comparison::{ComparisonOptions, write_comparison};
pub use false_colours::{Quantity, write_false_colours};
pub use knobs::write_knobs_plot;
pub use multiples::{SmallPlot, write_small_plots};
pub use orders::{OrdersPlot, write_orders_plot};
pub use study::write_study_plot;

/// The number of the form 1, 2 or 5 · 10ᵏ at or next above `x`, to six digits; 1 where `x` is not positive
/// and finite.
fn round_up(x: f64) -> f64 {
    if !(x.is_finite() && x > 0.0) {
        return 1.0;
    }
    let power = 10f64.powi(x.log10().floor() as i32);
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    let next = steps.into_iter().find(|&step| step >= x * (1.0 - 1e-6)).unwrap_or(x);
    if next > 0.0 { next } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers_are_round_and_no_less() {
        for (x, above) in [(1.0, 1.0), (3.0, 5.0), (0.07, 0.1), (5.01, 10.0)] {
            assert!((round_up(x) / above - 1.0).abs() < 1e-9, "{x}");
        }
        for x in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(round_up(x), 1.0);
        }
        assert!(round_up(1e-320) > 0.0);
    }
}
