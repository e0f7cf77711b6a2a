//! Model and classical shading against the measurement: curves, errors, colour ratios, each with its standard error,
//! and a verdict.

mod comparison;
mod error;
mod hue;
mod metrics;
mod propagation;
mod result;

pub use crate::rig::Geometry;
pub use comparison::model_colour_ratios;
pub use error::CompareError;
pub use hue::{HueComparison, hue};
pub use metrics::reference;
pub use propagation::{Channels, Estimate, Propagation};
pub use result::{
    Channel, ColourRatios, Comparison, CurvePoint, Inputs, Normalisation, Peak, Rmse, RmseRatio, Source, SourceRatios,
    Verdict,
};
