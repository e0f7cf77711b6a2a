//! Fits to a sample: readings, bounded least squares, and what the data tell of each parameter.

mod assessment;
mod error;
mod least_squares;
mod notice;
mod parameter;
mod readings;
mod residuals;

pub use assessment::{Assessment, Bound, Indistinct, assess};
pub use error::FitError;
pub use least_squares::{Progress, Settings, Solution, StartOutcome, minimise};
pub use notice::FitNotice;
pub use parameter::{FreeParameter, Prior, Scale};
pub use readings::{Channel, FitReadings, rms};
pub use residuals::{Differences, Residuals};
