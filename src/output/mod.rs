//! Output: the files made of a solution.
//!
//! [`write_ply`] puts the colours of [pictures](crate::render) on the patches themselves, [`write_faces`] and
//! [`write_patches`] make tables. [`write_comparison`], [`write_bounces`] and [`write_orders_plot`] make
//! figures with words. [`Outputs`] replaces the files of a run together: all of them whole, or none. How a
//! picture becomes PNG stands here too: `save_png`.

mod comparison;
mod figure;
mod file;
mod form_factors;
mod mesh;
mod npz;
mod photometry;
mod png;
mod study;
mod summary;
mod table;

use std::path::PathBuf;

pub use comparison::{
    ComparisonSummary, DirectSummary, OrderSummary, ReferenceSummary, write_comparison_summary,
    write_comparison_table,
};
pub use figure::{
    BouncePictures, ComparisonOptions, OrdersPlot, Quantity, SmallPlot, write_bounces, write_comparison,
    write_false_colours, write_knobs_plot, write_orders_plot, write_small_plots, write_study_plot,
};
pub use file::{Outputs, check_file, check_folder, replace, spare};
pub use form_factors::{FactorEntry, FactorFormat, FactorTable, write_form_factors};
pub use mesh::write_ply;
pub use photometry::{
    LevelErrors, Levels, Photometry, luminous, write_luminous_faces, write_luminous_patches,
    write_photometry, write_receivers,
};
pub use study::{StudySummary, read_study, write_study_reference, write_study_report, write_study_table};
pub use summary::{BounceSummary, EnergySummary, SeriesSummary, Stage, Summary, write_summary};
pub use table::{write_faces, write_lamp_groups, write_patches};

/// Why a file could not be written.
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
    /// A folder can't be made, or no file in it.
    #[error(
        "cannot make the folder {}, or files in it: {source}; choose another with --out",
        path.display()
    )]
    Folder {
        /// The folder.
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
}
