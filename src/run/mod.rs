//! A whole study: every stage in turn, from the study's values to the report's data.

mod camera;
mod curves;
mod plan;
mod report;
mod simulate;

pub use camera::CameraBatch;
pub use curves::SpectralCurves;
pub use plan::{Plan, RunError, medium};
pub use report::report;
pub use simulate::{Simulation, energy_rows, simulate};

/// Told of finished work, in shares of the whole that sum to 1.
pub type Progress<'a> = &'a (dyn Fn(f64) + Sync);
