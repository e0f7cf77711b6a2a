//! What the reader of a text or of a table took in another way than its plain meaning.

use crate::number::count;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// A notice on the text of a file. [`Display`] gives its words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "id", rename_all = "kebab-case")]
pub enum TextNotice {
    /// Neither a mark nor a declaration states the encoding, and the bytes are not UTF-8.
    GuessedEncoding,
    /// Lines before the titles of the columns.
    Preamble { lines: usize },
    /// A first column without a title that counts the rows.
    RowNumbers,
    /// Cells with a decimal comma; the first one and its line.
    DecimalCommas { cells: usize, first: String, line: usize },
    /// Wavelengths that do not ascend in the file; the first and the last, nm.
    SortedWavelengths { first_nm: f64, last_nm: f64 },
    /// Lines that repeat an earlier one.
    RepeatedLines { lines: usize },
}

impl Display for TextNotice {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::GuessedEncoding => f.write_str(
                "the text is not UTF-8 and was read as Windows-1252 (Latin-1): letters beyond ASCII may differ, \
                 numbers do not",
            ),
            Self::Preamble { lines } => write!(
                f,
                "{} before the titles of the columns: passed over as comments",
                count(*lines, "line")
            ),
            Self::RowNumbers => f.write_str("the first column has no title and counts the rows: passed over"),
            Self::DecimalCommas { cells, first, line } => write!(
                f,
                "{cells} numbers have a decimal comma, the first {first} on line {line}: read as {}",
                first.replace(',', ".")
            ),
            Self::SortedWavelengths { first_nm, last_nm } => write!(
                f,
                "wavelengths stand in another order in the file, from {first_nm} to {last_nm} nm: sorted with their \
                 values"
            ),
            Self::RepeatedLines { lines } => {
                let repeat = if *lines == 1 { "line repeats" } else { "lines repeat" };
                write!(f, "{lines} {repeat} a reading with the same value: taken once")
            }
        }
    }
}
