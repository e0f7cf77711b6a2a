//! Fits to a sample: readings, bounded least squares, what the data tell of each parameter, physical models by traced
//! light and an emulator of it, classical models as rivals, predictions of incidences left out, and verdicts.

mod assessment;
mod candidate;
mod colour_difference;
mod design;
mod emulator;
mod error;
mod forward;
mod free_dye;
mod least_squares;
mod left_out;
mod notice;
mod parameter;
mod physical;
mod physical_candidate;
mod readings;
mod residuals;
mod rivals;
mod search;
mod tables;
mod verdict;

pub use assessment::{Assessment, Bound, Indistinct, assess};
pub use candidate::{Candidate, Fitted, FittedParameter};
pub use colour_difference::{ColourDifference, colour_differences};
pub use design::{Axis, Design};
pub use emulator::{Batches, Emulator};
pub use error::FitError;
pub use forward::{ForwardModel, ForwardRun};
pub use free_dye::FreeDye;
pub use least_squares::{Progress, Settings, Solution, StartOutcome, Watch, minimise};
pub use left_out::{LeftOut, Predictions, left_out};
pub use notice::FitNotice;
pub use parameter::{FreeParameter, Prior, Scale};
pub use physical::{ParameterReport, PhysicalModel, PhysicalParameters, PhysicalProblem};
pub use physical_candidate::PhysicalCandidate;
pub use readings::{Channel, FitReadings, rms};
pub use residuals::{Differences, Residuals};
pub use rivals::Rival;
pub use search::{ForwardPool, PhysicalFit, SearchProgress};
pub use tables::{BetaTables, ScatteringNode, TableEffort};
pub use verdict::{FitVerdict, MisfitRatio, Modelled, misfit_ratio};
