//! Fits to a sample: readings, bounded least squares, what the data tell of each parameter, classical models as rivals,
//! predictions of incidences left out, and verdicts.

mod assessment;
mod candidate;
mod colour_difference;
mod design;
mod error;
mod least_squares;
mod left_out;
mod notice;
mod parameter;
mod readings;
mod residuals;
mod rivals;
mod verdict;

pub use assessment::{Assessment, Bound, Indistinct, assess};
pub use candidate::{Candidate, Fitted, FittedParameter};
pub use colour_difference::{ColourDifference, colour_differences};
pub use design::{Axis, Design};
pub use error::FitError;
pub use least_squares::{Progress, Settings, Solution, StartOutcome, Watch, minimise};
pub use left_out::{LeftOut, Predictions, left_out};
pub use notice::FitNotice;
pub use parameter::{FreeParameter, Prior, Scale};
pub use readings::{Channel, FitReadings, rms};
pub use residuals::{Differences, Residuals};
pub use rivals::Rival;
pub use verdict::{FitVerdict, MisfitRatio, Modelled, misfit_ratio};
