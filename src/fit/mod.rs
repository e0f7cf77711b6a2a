//! Fits to a sample: readings, bounded least squares, and what the data tell of each parameter.

mod assessment;
mod emulator;
mod error;
mod forward;
mod free_dye;
mod least_squares;
mod notice;
mod parameter;
mod physical;
mod readings;
mod residuals;
mod search;
mod tables;

pub use assessment::{Assessment, Bound, Indistinct, assess};
pub use emulator::{Batches, Emulator};
pub use error::FitError;
pub use forward::{ForwardModel, ForwardRun};
pub use free_dye::FreeDye;
pub use least_squares::{Progress, Settings, Solution, StartOutcome, minimise};
pub use notice::FitNotice;
pub use parameter::{FreeParameter, Prior, Scale};
pub use physical::{FittedParameter, ParameterReport, PhysicalModel, PhysicalParameters, PhysicalProblem};
pub use readings::{Channel, FitReadings, rms};
pub use residuals::{Differences, Residuals};
pub use search::{ForwardPool, PhysicalFit, SearchProgress, SearchSettings};
pub use tables::{BetaTables, ScatteringNode, TableEffort};
