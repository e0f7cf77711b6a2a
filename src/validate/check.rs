use crate::optics::{OpticsError, PhaseError};
use crate::spectrum::SpectrumError;
use crate::transport::TransportError;
use serde::Serialize;

/// Number of batches of a problem: the relative error of a standard error is then 7 %.
pub(super) const BATCHES: usize = 100;
/// Smallest number of paths: with fewer, batch means are too far from normal for a z-score.
pub const MIN_PATHS: u64 = 100 * BATCHES as u64;

/// One quantity of one problem, compared with its reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    pub problem: String,
    pub quantity: String,
    pub value: f64,
    /// Standard error of `value`; 0 for deterministic results.
    pub se: f64,
    pub reference: f64,
    /// Standard error of the reference; 0 if it is exact.
    pub reference_se: f64,
    /// Difference from the reference divided by the root sum of squares of both standard errors and the rounding of the
    /// reference; standard normal if the program is correct. Exceptions: for a sphere, which has no statistics, it is
    /// the relative difference over the tolerance (1e-10 up to size parameter 1e4, 1e-8 above), so 1 is the limit. For
    /// a histogram `value` is the χ² of all bins, `reference` their number, and `z` the normal deviate of that χ² by
    /// Wilson & Hilferty (1931).
    pub z: f64,
}

/// Failure to run the validation.
#[derive(Debug, thiserror::Error)]
pub enum ValidateError {
    #[error(
        "paths: expected at least {MIN_PATHS} a problem, found {found}; with fewer the standard errors mean nothing"
    )]
    TooFewPaths { found: u64 },
    #[error("reference table {table}: {source}")]
    Table { table: &'static str, source: csv::Error },
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error(transparent)]
    Optics(#[from] OpticsError),
    #[error(transparent)]
    Phase(#[from] PhaseError),
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}
