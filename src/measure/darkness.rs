//! Darkness: what light reaches only by leaks of a mesh, or hardly at all.
//!
//! Closed solids are rarely tight: some light leaks in, the less the finer they are cut, and whether a ray
//! finds the leak is chance. What is so dark says nothing about a scene: it is left out of means and extremes
//! of objects and materials, and speaks for no answer's error.

use nalgebra::DMatrix;

use super::words::few;
use crate::patches::Patches;
use crate::transport::Received;

/// Light below this part of its mean over all patches is darkness; a ratio. Chosen: interiors of solids in
/// scenes made by others have 1e-7 and less, and 10 000 lx by this is 0.01 lx, as by starlight.
pub const DARK: f64 = 1e-6;

/// Points that are named one by one, at most.
const MOST_NAMED: usize = 8;

/// Which patches are dark, and which lie on dark sides of faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Darkness {
    /// Per patch.
    pub patches: Vec<bool>,
    /// Per patch, whether the side of the face on which it lies has no light but darkness, on average.
    pub sides: Vec<bool>,
}

impl Darkness {
    /// By light per patch and area, such as illuminance (n × 1).
    ///
    /// # Panics
    /// If `light` has not n rows.
    pub fn of(patches: &Patches, light: &DMatrix<f64>) -> Self {
        let areas = patches.areas();
        let all = light.column(0).iter().zip(&areas).map(|(light, area)| light * area).sum::<f64>();
        let dark = DARK * all / areas.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let mut sides = vec![false; patches.len()];
        for row in patches.average_by_face(light) {
            sides[patches.patches_of(row.face, row.side)].fill(row.mean[0] < dark);
        }
        Self { patches: light.column(0).iter().map(|&light| light < dark).collect(), sides }
    }
}

/// Which points of a receiver get light, more than [`DARK`] of their mean in any channel: one that gets none
/// lies within something. All of them where none does.
pub fn lit_points(received: &Received) -> Vec<bool> {
    let irradiance = &received.irradiance;
    let dark = DARK * irradiance.mean();
    let lit: Vec<bool> = irradiance.row_iter().map(|point| point.amax() > dark).collect();
    if lit.contains(&true) { lit } else { vec![true; lit.len()] }
}

/// What is to be said of points of a receiver that get no light, if there are any.
pub fn unlit_points(received: &Received) -> Option<String> {
    let lit = lit_points(received);
    let unlit: Vec<String> =
        lit.iter().enumerate().filter(|(_, is_lit)| !**is_lit).map(|(point, _)| point.to_string()).collect();
    let say = || {
        format!(
            "receiver {}: {} of its {} points get no light, as if within a solid, and count in no mean, minimum or \
             uniformity: {}",
            received.receiver.name,
            unlit.len(),
            lit.len(),
            few(&unlit, MOST_NAMED)
        )
    };
    (!unlit.is_empty()).then(say)
}
