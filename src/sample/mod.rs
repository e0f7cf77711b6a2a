//! Measured samples: brightness factors β of a cloth over incidence and view, spectral or RGB, with their
//! uncertainty and where they come from.

mod columns;
mod curves;
mod description;
mod error;
mod geometries;
mod goniometric;
mod load;
mod measured;
mod nominal;
mod notice;
mod ratios;
mod reading;
mod row;

pub use description::{Chosen, Description, OneChannel, SampleKind, Uncertainty};
pub use error::SampleError;
pub use load::published_ratios;
pub use measured::{RawReading, Sample};
pub use nominal::{ANGLE_TOLERANCE_DEG, AnglesRead};
pub use notice::SampleNotice;
pub use ratios::{PublishedRatios, RatioRange};
pub use reading::Reading;
