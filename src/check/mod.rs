//! The laws that a study's physics obeys, each tested: gates for a CI. Equations and tolerances: `docs/checks.md`.
//!
//! [`study`] tests a study, [`sample`](fn@sample) a measurement, [`Baseline`] against what an earlier check found; a
//! [`Checked`] is rendered by [`table`], [`junit`], [`annotations`] and serde.

mod attenuation;
mod baseline;
mod bounces;
mod camera;
mod cells;
mod checked;
mod cloth;
mod context;
mod cylinder;
mod departure;
mod error;
mod estimates;
mod gate;
mod judge;
mod ledger;
mod medium;
mod output;
mod particles;
mod reabsorption;
mod rig;
mod sample;
mod study;
mod symmetry;
mod tables;
mod weave;
mod woven;

pub use baseline::Baseline;
pub use checked::{CheckEffort, Checked, CheckedQuantity, Drift, Moved, Subject};
pub use context::Context;
pub use error::{BaselineError, CheckError};
pub use gate::{Gate, GateVerdict, Law, Where};
pub use judge::Judge;
pub use output::{annotations, junit, table};
pub use sample::sample;
pub use study::study;
