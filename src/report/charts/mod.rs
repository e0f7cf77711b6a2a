//! The charts of a report. One more is its own file and a row of [`CHARTS`].

mod canvas;
mod look;
mod parameter;
mod picture;
mod view_angle;

pub use canvas::chart_font;
pub(crate) use parameter::name as sweep_name;
pub use parameter::sweep_charts;
pub use picture::Outline;
pub(crate) use picture::file_names;
pub use view_angle::{Graph, graphs};

/// In the order of their files.
pub(crate) const CHARTS: &[picture::Chart] = &[view_angle::CHART];
