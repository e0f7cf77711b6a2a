//! The charts of a report.

mod canvas;
mod list;
mod picture;
mod view_angle;

pub use canvas::chart_font;
pub(crate) use list::CHARTS;
pub use picture::Outline;
pub(crate) use picture::file_names;
pub use view_angle::{Graph, graphs};
