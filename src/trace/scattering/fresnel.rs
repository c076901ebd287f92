//! Fresnel: how much a smooth surface reflects.

/// The part of unpolarised light that a smooth surface reflects, met at an angle of this cosine; `ratio` is
/// the index of refraction behind the surface by that before it (Fresnel 1823). 1 beyond the critical angle.
pub fn fresnel(cosine: f64, ratio: f64) -> f64 {
    let [across, along] = polarized(cosine, ratio);
    0.5 * (across + along)
}

/// The same of light that is polarized across the plane of incidence, and along it.
fn polarized(cosine: f64, ratio: f64) -> [f64; 2] {
    let inside = 1.0 - (1.0 - cosine * cosine) / (ratio * ratio);
    if inside <= 0.0 {
        return [1.0; 2];
    }
    let inner = inside.sqrt();
    let across = (cosine - ratio * inner) / (cosine + ratio * inner);
    let along = (ratio * cosine - inner) / (ratio * cosine + inner);
    [across * across, along * along]
}

/// The part of unpolarised light that goes through both surfaces of a pane, all reflections between them
/// included, met at an angle of this cosine: each polarization goes its own way, (1 − R)/(1 + R).
pub fn through_pane(cosine: f64, index: f64) -> f64 {
    let [across, along] = polarized(cosine, index).map(|once| (1.0 - once) / (1.0 + once));
    0.5 * (across + along)
}
