//! Models and classical shadings against samples: curves, errors, colour ratios, each with its standard error, and
//! verdicts.

mod comparison;
mod error;
mod hue;
mod metrics;
mod propagation;
mod result;
mod source;
mod table1;

pub use crate::rig::Geometry;
pub use comparison::model_colour_ratios;
pub use error::CompareError;
pub use hue::{HueComparison, hue};
pub use metrics::reference;
pub use propagation::{Channels, PropagatedEstimate, Propagation};
pub use result::{
    Channel, Coefficient, ColourRatios, Compared, Comparison, CurvePoint, Inputs, Peak, Rmse, RmseRatio, SourceRatios,
    Verdict,
};
pub use source::{Role, Source, SourceId};
pub(crate) use source::{first_sample, is_first_sample};
pub(crate) use table1::known_error;
pub use table1::{RatioRanges, Table1, Table1Name, Table1Row, Table1Source};
