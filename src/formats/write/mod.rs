//! Writers of single formats. What a format cannot hold is resampled in the source's own interpolation, and said so.

mod balance;
pub(super) mod columns;
mod error;
pub(super) mod integra;
pub(super) mod merl;
mod nodes;
mod notice;
pub(super) mod radiance;
pub(super) mod rgl;
mod sampling;
pub(super) mod ssdd;

pub use error::WriteError;
pub(crate) use integra::resampled_nodes;
pub use notice::WriteNotice;
