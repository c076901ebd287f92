//! Output: pictures and meshes of a solution.
//!
//! [`render`] looks at a radiance field through a camera and gives a [`Picture`] of linear radiance; an
//! [`Exposure`] makes it fit for a screen. [`write_ply`] puts the same colours on the patches themselves,
//! [`write_faces`] and [`write_patches`] make tables. [`write_comparison`], [`write_bounces`] and
//! [`write_orders_plot`] make figures with words. [`Outputs`] replaces the files of a run together: all of
//! them whole, or none.

mod comparison;
mod figure;
mod file;
mod form_factors;
mod image;
mod limiter;
mod mesh;
mod npz;
mod photometry;
mod picture;
mod smooth;
mod study;
mod summary;
mod table;
mod tone;
mod view;

use std::path::PathBuf;

use crate::progress::Cancelled;

pub use comparison::{
    ComparisonSummary, DirectSummary, OrderSummary, ReferenceSummary, write_comparison_summary,
    write_comparison_table,
};
pub use figure::{
    BouncePictures, ComparisonOptions, OrdersPlot, Quantity, SmallPlot, write_bounces, write_comparison,
    write_false_colours, write_knobs_plot, write_orders_plot, write_small_plots, write_study_plot,
};
pub use file::{Outputs, replace, spare};
pub use form_factors::{FactorEntry, FactorFormat, FactorTable, write_form_factors};
pub use image::{Outlines, RenderOptions, Shading, Surfaces, render};
pub use mesh::write_ply;
pub use photometry::{
    Levels, Photometry, luminous, write_luminous_faces, write_luminous_patches, write_photometry,
    write_receivers,
};
pub use picture::{LampPart, Picture};
pub use smooth::SmoothField;
pub use study::{StudySummary, read_study, write_study_reference, write_study_report, write_study_table};
pub use summary::{BounceSummary, EnergySummary, SeriesSummary, Stage, Summary, write_summary};
pub use table::{write_faces, write_lamp_groups, write_patches};
pub use tone::{Exposure, srgb, to_rgb};
pub use view::default_camera;

/// Why a picture or mesh could not be made or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The file can't be written.
    #[error(
        "cannot write {}: {source}; check that the folder exists, may be written to and has room",
        path.display()
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file that the run has read would be overwritten.
    #[error("{} belongs to the scene and would be overwritten; choose another place for the results", path.display())]
    Input {
        /// The file.
        path: PathBuf,
    },
    /// A file's name does not tell how to write form factors.
    #[error("{}: form factors are written as .csv, .mtx or .npz; end the name of the file in one of these", path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// A picture of this size can't be made.
    #[error(
        "a picture can't be {width} x {height}; both must be at least 1 and at most 32768, and pixels at most 2²⁷ in all"
    )]
    Size {
        /// Pixels across.
        width: usize,
        /// Pixels down.
        height: usize,
    },
    /// So many random samples can't be taken.
    #[error("a pixel can't have {samples} samples; take 1 to 1048576")]
    Samples {
        /// Samples per pixel.
        samples: u32,
    },
    /// The camera can't make a picture.
    #[error(
        "camera: position and target must differ, up must not be zero, fov must lie between 0 and 180 degrees, and no number may be beyond 1e30"
    )]
    Camera,
    /// The observer asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

#[cfg(test)]
mod tests {
    //! What the tests of this module look at.

    use glam::DVec3;
    use nalgebra::DMatrix;

    use crate::patches::{PatchSize, Patches, Reach, Tessellation};
    use crate::scene::{Face, FaceState, Material, Scene, SceneParts};
    use crate::trace::Tracer;

    /// A scene of triangles (three vertices each) with a material each.
    pub(super) fn triangles(corners: &[[[f64; 3]; 3]], of: &[u32], materials: Vec<Material>) -> Scene {
        let face = |k: u32| Face {
            vertices: [3 * k, 3 * k + 1, 3 * k + 2],
            normals: None,
            material: of[k as usize],
            object: 0,
            state: FaceState::Kept,
        };
        let parts = SceneParts {
            name: "test".into(),
            vertices: corners.iter().flatten().copied().map(DVec3::from).collect(),
            faces: (0..corners.len() as u32).map(face).collect(),
            materials,
            objects: vec!["object".into()],
            ..SceneParts::default()
        };
        Scene::new(parts).expect("a valid test scene")
    }

    /// Two triangles for the parallelogram from `p` along `u` and `v`.
    pub(super) fn quad(p: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [[[f64; 3]; 3]; 2] {
        let add = |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let far = add(add(p, u), v);
        [[p, add(p, u), far], [p, far, add(p, v)]]
    }

    /// The box [0, 1]³ seen from inside, all of one material.
    pub(super) fn room(material: Material) -> Scene {
        let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let o = [0.0; 3];
        let walls =
            [quad(o, z, x), quad(o, x, y), quad(o, y, z), quad(y, x, z), quad(z, y, x), quad(x, z, y)];
        triangles(&walls.concat(), &[0; 12], vec![material])
    }

    /// Linear elements with these values at the corners of every patch, in the first `channels`.
    pub(super) fn by_corners(
        patches: &Patches,
        channels: usize,
        value: impl Fn(usize, DVec3) -> DVec3,
    ) -> DMatrix<f64> {
        let corner = |k: usize| patches.point(patches.place(k / 3).face, patches.corners(k / 3)[k % 3]);
        DMatrix::from_fn(3 * patches.len(), channels, |k, c| value(k / 3, corner(k))[c])
    }

    /// Cuts for legs up to `edge` metres.
    pub(super) fn cut<'s>(tracer: &Tracer<'s>, edge: f64, reach: Reach) -> Patches<'s> {
        let options = Tessellation { size: PatchSize::Edge(edge), reach, ..Default::default() };
        Patches::new(tracer, &options).expect("a valid patch size")
    }
}
