//! Fields: numbers on patches, by other elements, averaged over faces, in groups and clusters, and across
//! sheets.

mod aggregate;
mod basis;
mod clusters;
mod groups;
mod sheets;

pub use aggregate::FaceRow;
pub use basis::Basis;
pub use clusters::Clusters;
pub use groups::{Group, GroupBy, Groups};
pub use sheets::Sheets;
