//! Wavelength grids, spectra (functions of wavelength), samples (values on a grid) and the tables they come from.

mod error;
mod file;
mod function;
mod grid;
mod layout;
mod naming;
mod observer;
pub mod plausibility;
mod samples;
pub mod tables;

pub use error::SpectrumError;
pub(crate) use file::bytes_of;
pub use file::{SpectraFile, parse_observer, parse_spectra, parse_spectrum, read_spectra, read_spectrum};
pub use function::Spectrum;
pub use grid::WavelengthGrid;
pub use naming::UnknownName;
pub use plausibility::Doubt;
pub use samples::Samples;

pub(crate) use crate::text::CsvTable;
pub use crate::text::{CsvError, TextNotice};
