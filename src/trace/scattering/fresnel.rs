//! Fresnel: how much a smooth surface reflects.

/// The part of unpolarised light that a smooth surface reflects, met at an angle of this cosine; `ratio` is
/// the index of refraction behind the surface by that before it (Fresnel 1823). 1 beyond the critical angle.
pub fn fresnel(cosine: f64, ratio: f64) -> f64 {
    let inside = 1.0 - (1.0 - cosine * cosine) / (ratio * ratio);
    if inside <= 0.0 {
        return 1.0;
    }
    let inner = inside.sqrt();
    let across = (cosine - ratio * inner) / (cosine + ratio * inner);
    let along = (ratio * cosine - inner) / (ratio * cosine + inner);
    0.5 * (across * across + along * along)
}
