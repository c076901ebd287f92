//! Photometry: between watts and lumens.

/// Luminous efficacy of radiation that scenes use where they set none, lm·W⁻¹.
pub const EFFICACY: f64 = 683.0;

/// What eyes make of red, green and blue: 0.2126 R + 0.7152 G + 0.0722 B (Rec. 709); a single channel stands
/// for itself.
pub fn luminance(channels: &[f64]) -> f64 {
    match channels {
        [r, g, b] => 0.2126 * r + 0.7152 * g + 0.0722 * b,
        _ => channels.iter().sum::<f64>() / channels.len().max(1) as f64,
    }
}
