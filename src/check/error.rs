use crate::colour::ColourError;
use crate::optics::{OpticsError, PhaseError};
use crate::run::RunError;
use crate::sample::SampleError;
use crate::spectrum::SpectrumError;
use crate::transport::TransportError;
use crate::yarn::YarnError;
use std::path::PathBuf;

/// Why a check cannot run.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    #[error(transparent)]
    Run(Box<RunError>),
    #[error(transparent)]
    Yarn(#[from] YarnError),
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error(transparent)]
    Optics(#[from] OpticsError),
    #[error(transparent)]
    Phase(#[from] PhaseError),
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    #[error(transparent)]
    Colour(#[from] ColourError),
    #[error(transparent)]
    Sample(#[from] SampleError),
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    #[error("the study cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error("the JUnit file cannot be written: {0}")]
    Xml(#[from] std::io::Error),
    #[error("--paths: expected at least {least}, found {found}; with fewer the spread of the batches means nothing")]
    TooFewPaths { least: u64, found: u64 },
}

impl From<RunError> for CheckError {
    fn from(error: RunError) -> Self {
        Self::Run(Box::new(error))
    }
}

/// Why an earlier result cannot be compared with.
#[derive(Debug, thiserror::Error)]
pub enum BaselineError {
    #[error("{}: the baseline cannot be read; `specval check --json` writes one", path.display())]
    Read {
        path: PathBuf,
        #[source]
        cause: std::io::Error,
    },
    #[error("{}: expected the document of `specval check --json`, found something else: {cause}; name the file that \
             `specval check --json > FILE` wrote", path.display())]
    NotACheck { path: PathBuf, cause: serde_json::Error },
    #[error(
        "{}: expected a baseline with the quantities of this check, found none of {missing}; make a new one with the \
         same wavelengths and incidences", path.display()
    )]
    OtherQuantities { path: PathBuf, missing: String },
}
