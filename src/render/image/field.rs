//! Field: the solution itself as red, green and blue, patch by patch or smoothed.

use glam::DVec3;
use nalgebra::DMatrix;

use crate::patches::{Barycentrics, Basis, Patches};
use crate::render::smooth::SmoothField;
use crate::render::tone::to_rgb;
use crate::scene::triangle;
use crate::trace::{Tint, Tracer};

/// Radiance wherever there are patches.
pub(super) enum Field<'a, 's> {
    Flat(Elements<'a, 's>),
    Smooth(SmoothField),
}

impl<'a, 's> Field<'a, 's> {
    /// As it is over each patch.
    pub fn flat(patches: &'a Patches<'s>, radiance: &DMatrix<f64>) -> Self {
        Self::Flat(Elements::new(patches, radiance))
    }

    /// Continuous within each smooth surface.
    pub fn smooth(tracer: &Tracer, patches: &Patches, radiance: &DMatrix<f64>) -> Self {
        let flat: Vec<DVec3> = rgb_rows(radiance).collect();
        let field = DMatrix::from_fn(flat.len(), 3, |i, c| flat[i][c]);
        Self::Smooth(SmoothField::new(tracer, patches, &field))
    }

    pub fn at(&self, patch: usize, point: Barycentrics) -> DVec3 {
        match self {
            Self::Flat(elements) => elements.at(patch, point),
            Self::Smooth(field) => {
                let mut rgb = [0.0; 3];
                rgb.iter_mut().zip(field.at(patch, point)).for_each(|(x, value)| *x = value);
                rgb.into()
            }
        }
    }
}

/// Radiance as it was solved, which may jump from patch to patch.
pub(super) struct Elements<'a, 's> {
    patches: &'a Patches<'s>,
    basis: Basis,
    /// Per coefficient.
    rgb: Vec<DVec3>,
}

impl<'a, 's> Elements<'a, 's> {
    pub fn new(patches: &'a Patches<'s>, radiance: &DMatrix<f64>) -> Self {
        Self { patches, basis: Basis::of(patches, radiance), rgb: rgb_rows(radiance).collect() }
    }

    /// The radiance at a point of a patch, given as a point of the patch's face.
    #[inline]
    pub fn at(&self, patch: usize, point: Barycentrics) -> DVec3 {
        match self.basis {
            Basis::Constant => self.rgb[patch],
            Basis::Linear => {
                let within = self.patches.weights_in(self.patches.slot_of_patch(patch), point);
                let [u, v, w] = triangle::weights(within);
                self.rgb[3 * patch] * u + self.rgb[3 * patch + 1] * v + self.rgb[3 * patch + 2] * w
            }
        }
    }
}

/// Each coefficient of the radiance as red, green and blue.
pub(super) fn rgb_rows(radiance: &DMatrix<f64>) -> impl Iterator<Item = DVec3> {
    radiance.row_iter().map(|row| to_rgb(row.transpose().as_slice()).into())
}

/// A tint as red, green and blue.
pub(super) fn rgb_of(tint: Tint) -> DVec3 {
    match tint.channels() {
        3 => to_rgb(&[0, 1, 2].map(|channel| tint.part(channel))).into(),
        _ => DVec3::splat(tint.mean()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::Reach;
    use crate::render::test_scenes::{by_corners, cut, quad, triangles};
    use crate::scene::Material;
    use crate::trace::sampling::{Stream, uniform_triangle};

    #[test]
    fn a_linear_field_over_a_wall_is_shown_as_it_is_flat_and_smooth() {
        // The second face is smaller and cut into fewer rows, so that corners of one lie within edges of the
        // other.
        let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let faces = [[[0.0; 3], x, y], [x, [0.7, 0.6, 0.0], y]];
        let scene = triangles(&faces, &[0, 0], vec![Material::lamp("wall", &[0.5; 3], &[1.0; 3])]);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.07, Reach::Light);
        let exact = |p: DVec3| DVec3::new(2.0 + p.x, 3.0 - p.y, 4.0 + p.x - 2.0 * p.y);
        let radiance = by_corners(&patches, 3, |_, p| exact(p));
        for field in [Field::flat(&patches, &radiance), Field::smooth(&tracer, &patches, &radiance)] {
            for patch in 0..patches.len() {
                let [a, b, c] = patches.corners(patch).map(glam::DVec2::from);
                for k in 0..8 {
                    let [s, t, ..] = Stream::Callers.sequence(1, 2, patch as u64).point(k);
                    let [v, w] = uniform_triangle([s, t]);
                    let point = (a + (b - a) * v + (c - a) * w).to_array();
                    let missed =
                        field.at(patch, point) - exact(patches.point(patches.place(patch).face, point));
                    assert!(missed.abs().max_element() < 1e-9, "{patch} {point:?}: {missed}");
                }
            }
        }
    }

    #[test]
    fn linear_elements_that_jump_are_joined_where_they_meet_and_only_there() {
        let wall = quad([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let scene = triangles(&wall, &[0, 0], vec![Material::lamp("wall", &[0.5], &[1.0])]);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 2.0, Reach::Light);
        assert_eq!(patches.len(), 2);
        // The second patch is brighter by 2 than the first wherever they meet.
        let linear = |patch: usize, p: DVec3| 1.0 + p.x + 2.0 * p.y + 2.0 * patch as f64;
        let radiance = by_corners(&patches, 1, |patch, p| DVec3::splat(linear(patch, p)));
        let (flat, smooth) = (Field::flat(&patches, &radiance), Field::smooth(&tracer, &patches, &radiance));
        for (patch, corner) in (0..2).flat_map(|i| patches.corners(i).map(|corner| (i, corner))) {
            let p = patches.point(patches.place(patch).face, corner);
            let shared = (p.x - p.y).abs() < 1e-9;
            let joined = if shared { 1.0 - 2.0 * patch as f64 } else { 0.0 };
            assert!((flat.at(patch, corner).x - linear(patch, p)).abs() < 1e-9);
            assert!((smooth.at(patch, corner).x - linear(patch, p) - joined).abs() < 1e-9, "{patch} {p}");
        }
    }
}
