//! Axes: what all plots share: colours, strokes, numbers in words, and names that keep apart.

use plotters::prelude::*;

/// Colours that stay apart with any kind of colour blindness (Okabe & Ito 2008).
pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(super) const VERMILION: RGBColor = RGBColor(213, 94, 0);
pub(super) const GREEN: RGBColor = RGBColor(0, 140, 103);
pub(super) const DARK: RGBColor = RGBColor(60, 60, 60);
pub(super) const GREY: RGBColor = RGBColor(120, 120, 120);

/// Lines of names are so far apart, at least.
pub(super) const LINE: i32 = 19;

/// How a line is drawn.
#[derive(Clone, Copy)]
pub(super) enum Stroke {
    Solid,
    Dashed,
    Dotted,
}

/// Whether a logarithmic axis has a place for a value.
pub(super) fn is_shown(value: f64) -> bool {
    (1e-100..1e100).contains(&value)
}

/// Ascending places moved so that none is nearer than a line to the next, and the last is not below `end`.
pub(super) fn apart(places: &[i32], end: i32) -> Vec<i32> {
    let mut moved = Vec::with_capacity(places.len());
    let mut next = i32::MIN;
    for &place in places {
        let at = place.max(next);
        moved.push(at);
        next = at + LINE;
    }
    let mut limit = end;
    for at in moved.iter_mut().rev() {
        *at = (*at).min(limit);
        limit = *at - LINE;
    }
    moved
}

/// A power of ten as per cent.
pub(super) fn percent(share: f64) -> String {
    let digits = (-(100.0 * share).log10().round()).clamp(0.0, 12.0) as usize;
    format!("{:.digits$} %", 100.0 * share)
}

/// As per cent with two digits that count.
pub(super) fn short_percent(share: f64) -> String {
    let digits = (1.0 - (100.0 * share).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{:.digits$} %", 100.0 * share)
}

/// 10ᵏ.
pub(super) fn power_of_ten(y: f64) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32('⁰' as u32 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    };
    format!("10{}", format!("{:.0}", y.log10()).chars().map(raised).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_apart_and_stay_in_the_plot() {
        assert_eq!(apart(&[10, 100, 200], 400), [10, 100, 200]);
        assert_eq!(apart(&[10, 12, 14], 400), [10, 29, 48]);
        assert_eq!(apart(&[390, 395, 400], 400), [362, 381, 400]);
    }
}
