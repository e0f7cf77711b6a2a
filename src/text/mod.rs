//! Text files: encodings, and the grammars of tables, CSV and CGATS. What the columns of a table mean is for the stages above.

mod cgats;
mod csv_table;
mod decimals;
pub(crate) mod encoding;
mod table;
mod titles;

pub(crate) use cgats::{Cgats, is_cgats};
pub(crate) use csv_table::lines_of;
pub use table::CsvError;
pub(crate) use table::{CsvTable, shortened};
pub(crate) use titles::{Heading, band_nm, heading};

/// Whether a text is a path and no mistyped name.
pub(crate) fn is_path(text: &str) -> bool {
    text.contains(['.', '/', '\\'])
}
