//! Text files: encodings, and the grammars of tables, CSV and CGATS. What the columns of a table mean is for the stages
//! above.

mod aliases;
mod bands;
mod cgats;
mod csv_table;
mod decimals;
pub(crate) mod encoding;
mod foreign;
mod notice;
mod records;
mod table;
mod titles;
mod units;

pub(crate) use aliases::remedy_for_brdf;
pub(crate) use bands::band_nm;
pub(crate) use cgats::{Cgats, is_cgats};
pub(crate) use csv_table::lines_of;
pub use foreign::Foreign;
pub(crate) use foreign::foreign;
pub use notice::TextNotice;
pub use table::CsvError;
pub(crate) use table::{CsvTable, shortened};
pub(crate) use titles::{Heading, heading};

/// Whether a text is a path and no mistyped name.
pub(crate) fn is_path(text: &str) -> bool {
    text.contains(['.', '/', '\\'])
}
