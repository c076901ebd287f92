//! Texels: how much of their pictures the patches of textured faces cover, for the mean over each is found
//! exactly.

use super::constants::MOST_TEXELS;
use crate::patches::Outlook;
use crate::scene::{FaceTexture, triangle};
use crate::trace::Tracer;

/// Texels of all patches together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texels {
    /// Those on the border of a patch, which it covers in part.
    pub partly: f64,
    /// All others.
    pub wholly: f64,
}

impl Texels {
    pub fn new(tracer: &Tracer, outlook: &Outlook) -> Self {
        let scene = tracer.scene();
        let mut all = Self::default();
        if !scene.has_textures() {
            return all;
        }
        let mut cells = vec![0.0; scene.faces().len()];
        outlook.stretches.iter().for_each(|stretch| cells[stretch.face] += stretch.cells);
        for stretch in &outlook.stretches {
            let patches =
                stretch.cells / cells[stretch.face] * outlook.patches_of[stretch.face].iter().sum::<f64>();
            let share = triangle::area(&stretch.corners)
                / (stretch.cells * triangle::area(tracer.corners(stretch.face)));
            let textures = [scene.reflectance_texture(stretch.face), scene.emission_texture(stretch.face)];
            for texture in textures.into_iter().flatten() {
                let Self { partly, wholly } = Self::of_patch(&texture, share);
                all.partly += patches * partly;
                all.wholly += patches * wholly;
            }
        }
        all
    }

    /// Those of a patch that is this part of a face.
    fn of_patch(FaceTexture { texture, corners }: &FaceTexture, share: f64) -> Self {
        let Some(corners) = corners else { return Self::default() };
        let [width, height] = texture.pixels.size().map(|count| count as f64);
        let [a, b, c] = corners.map(|at| at * texture.scale * glam::DVec2::new(width, height));
        let crossed: f64 = [b - a, c - b, a - c].map(|edge| edge.abs().element_sum()).iter().sum();
        let covered = 0.5 * (b - a).perp_dot(c - a).abs() * share;
        // What covers more is averaged on a coarser picture.
        let coarser = (MOST_TEXELS / covered).min(1.0);
        Self { partly: crossed * (share * coarser).sqrt(), wholly: covered * coarser }
    }
}
