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

/// What a pane does with unpolarised light, all reflections between its two surfaces included.
#[derive(Clone, Copy, Debug)]
pub struct Pane {
    /// The part that goes through, but for what the glass absorbs on one way across.
    pub through: f64,
    /// The part that comes back.
    pub back: f64,
}

/// What a pane of this index of refraction does with light that meets it at an angle of this cosine and of
/// which its glass lets a part `clear` through on each way across: each polarization goes its own way, T = f
/// (1 − R)²/(1 − f²R²), and R + fRT comes back.
pub fn pane(cosine: f64, index: f64, clear: f64) -> Pane {
    let ways = polarized(cosine, index).map(|once| {
        // Of clear glass at a grazing angle all comes back.
        let rest = 1.0 - (clear * once).powi(2);
        let through = if rest > 0.0 { (1.0 - once).powi(2) / rest } else { 0.0 };
        Pane { through, back: once + clear * clear * once * through }
    });
    let [across, along] = ways;
    Pane { through: 0.5 * (across.through + along.through), back: 0.5 * (across.back + along.back) }
}
