use super::picture::Chart;
use super::view_angle;

/// The charts of a report, in the order of their files. One more is its own file and a row here.
pub(crate) const CHARTS: &[Chart] = &[view_angle::CHART];
