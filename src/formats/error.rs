use std::fmt;

/// Where a file departs from its format: what was expected there and what was found.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}{place}: expected {expected}, found {found}")]
pub struct FormatError {
    /// File, as it was named.
    pub path: String,
    pub place: Place,
    /// With its unit, and what to do where that is not plain.
    pub expected: String,
    pub found: String,
}

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// Of a text file; both from 1, the column in characters.
    Line { line: usize, column: usize },
    /// Of a binary file, from 0.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line { line, column } => write!(f, ", line {line}, column {column}"),
            Self::Byte(offset) => write!(f, ", byte {offset}"),
        }
    }
}

impl FormatError {
    pub(crate) fn file(path: &str, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self::at(path, Place::File, expected, found)
    }

    pub(crate) fn byte(path: &str, offset: usize, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self::at(path, Place::Byte(offset as u64), expected, found)
    }

    pub(crate) fn at(path: &str, place: Place, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            place,
            expected: expected.into(),
            found: found.into(),
        }
    }
}
