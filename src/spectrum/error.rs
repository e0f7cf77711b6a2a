use super::naming::UnknownName;
use crate::text::CsvError;

/// What is wrong with a grid, a spectrum or a table of them.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    #[error(
        "wavelengths must be finite, positive and strictly ascending in nm; entry {index} is {found}; sort them, each \
         once, and give them in nm"
    )]
    NotAscending { index: usize, found: f64 },
    #[error("expected at least one wavelength, found none; give one in nm")]
    Empty,
    #[error(
        "{name} is tabulated for {low}..{high} nm and has no value at {found} nm; give a table that reaches so far, or \
         fewer wavelengths"
    )]
    OutsideTable {
        name: String,
        low: f64,
        high: f64,
        found: f64,
    },
    #[error("{name}: expected {expected} values, one a wavelength, found {found}; give a value for each wavelength")]
    Length {
        name: String,
        expected: usize,
        found: usize,
    },
    #[error(
        "{name}: value at {wavelength_nm} nm is {found}, expected a finite number; replace it by a reading, or leave \
         its wavelength out"
    )]
    NotFinite {
        name: String,
        wavelength_nm: f64,
        found: f64,
    },
    #[error(transparent)]
    UnknownTable(#[from] UnknownName),
    #[error(transparent)]
    Csv(#[from] Box<CsvError>),
    #[error("{path}: cannot be read: {reason}; check its name, its size and the right to read it")]
    Read { path: String, reason: String },
}
