use crate::number::significant;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// What a fit assumed about the sample. [`Display`] gives its words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "id", rename_all = "kebab-case")]
pub enum FitNotice {
    /// Readings without a standard uncertainty, which got a share of their value, and of the mean of their channel.
    AssumedUncertainty {
        readings: usize,
        of: usize,
        relative: f64,
        relative_of_mean: f64,
    },
}

impl Display for FitNotice {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::AssumedUncertainty {
                readings,
                of,
                relative,
                relative_of_mean,
            } => write!(
                f,
                "{readings} of {of} readings state no uncertainty: a standard uncertainty of {} % of the reading and \
                 {} % of \
                 the mean of its channel, added in quadrature, is assumed",
                significant(100.0 * relative, 3),
                significant(100.0 * relative_of_mean, 3)
            ),
        }
    }
}
