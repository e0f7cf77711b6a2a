use crate::colour::ColourError;
use crate::formats::FormatError;
use crate::spectrum::{CsvError, SpectrumError, UnknownName};

/// What is wrong with a sample.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SampleError {
    #[error("{0}; nor is there a file or folder of that name: take one of these names, or the path of a sample")]
    Unknown(UnknownName),
    #[error("{path}: cannot be read: {reason}; check its name, its size and the right to read it")]
    Read { path: String, reason: String },
    #[error(
        "{folder}: a sample's folder holds sample.toml and data.csv, or the file that sample.toml names with data = \"...\"; \
         there is no {missing}; write it, or name the file of readings itself"
    )]
    Incomplete { folder: String, missing: String },
    #[error("{path}: {message}")]
    Description { path: String, message: String },
    #[error(transparent)]
    Format(#[from] FormatError),
    #[error("{path}: expected {expected}, found {found}; {remedy}")]
    NotComparable {
        path: String,
        expected: String,
        found: String,
        remedy: String,
    },
    #[error(transparent)]
    Csv(#[from] Box<CsvError>),
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    #[error(transparent)]
    Colour(#[from] ColourError),
}
