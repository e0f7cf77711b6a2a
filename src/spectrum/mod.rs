//! Wavelength grids, spectra (functions of wavelength) and samples (values on a grid).

mod function;
mod grid;
mod samples;

pub use function::Spectrum;
pub use grid::WavelengthGrid;
pub use samples::Samples;

/// What is wrong with a grid, a spectrum or a table of them.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    #[error("wavelengths must be finite, positive and strictly ascending in nm; entry {index} is {found}")]
    NotAscending { index: usize, found: f64 },
    #[error("a wavelength grid needs at least one wavelength")]
    Empty,
    #[error("{name} is tabulated for {low}..{high} nm and has no value at {found} nm")]
    OutsideTable {
        name: String,
        low: f64,
        high: f64,
        found: f64,
    },
    #[error("{name}: expected {expected} values, one a wavelength, found {found}")]
    Length {
        name: String,
        expected: usize,
        found: usize,
    },
    #[error("{name}: value at {wavelength_nm} nm is {found}, expected a finite number")]
    NotFinite {
        name: String,
        wavelength_nm: f64,
        found: f64,
    },
    #[error("{name}: there is no such table; known: {known}")]
    UnknownTable { name: String, known: String },
    #[error("{name}, line {line}: expected {expected}, found {found}")]
    Table {
        name: String,
        line: u64,
        expected: String,
        found: String,
    },
}
