use std::fmt;

/// Where a file departs from its format: what was expected there, what was found, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}{place}: expected {expected}, found {found}; {remedy}")]
pub struct FormatError {
    /// File, as it was named.
    pub path: String,
    pub place: Location,
    /// With its unit.
    pub expected: String,
    pub found: Box<str>,
    /// What the user can do about it.
    pub remedy: Box<str>,
}

/// A place in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Location {
    /// The file as a whole.
    File,
    /// Of a text file; both from 1, the column in characters.
    Line { line: usize, column: usize },
    /// A row of a table: its line, from 1, and the title of its column, where one cell is meant.
    Row { line: usize, column: Option<Box<str>> },
    /// Of a binary file, from 0.
    Byte(u64),
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line { line, column } => write!(f, ", line {line}, column {column}"),
            Self::Row { line, column: None } => write!(f, ", line {line}"),
            Self::Row {
                line,
                column: Some(column),
            } => write!(f, ", line {line}, column {column}"),
            Self::Byte(offset) => write!(f, ", byte {offset}"),
        }
    }
}

impl FormatError {
    pub(crate) fn file(
        path: &str,
        expected: impl Into<String>,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::at(path, Location::File, expected, found, remedy)
    }

    pub(crate) fn byte(
        path: &str,
        offset: usize,
        expected: impl Into<String>,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::at(path, Location::Byte(offset as u64), expected, found, remedy)
    }

    pub(crate) fn at(
        path: &str,
        place: Location,
        expected: impl Into<String>,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            path: path.into(),
            place,
            expected: expected.into(),
            found: found.into().into_boxed_str(),
            remedy: remedy.into().into_boxed_str(),
        }
    }
}

/// Remedies that several readers name.
pub(crate) mod remedy {
    pub(crate) const CUT_SHORT: &str = "the file is cut short: copy or export it again";
    pub(crate) const DAMAGED: &str = "the file is damaged or was changed as text: copy it again in binary mode";
    pub(crate) const SPELLING: &str = "check the spelling there, or export the file again";
    pub(crate) const SPELLING_OR_COUNT: &str =
        "check the spelling there, and the counts before it: with a wrong count, numbers stand where words are due";
    pub(crate) const MORE_BEHIND: &str =
        "remove what follows the last block, or check the counts in the header: they promise less";
    pub(crate) const ONE_OF_TWO: &str = "remove one of the two";
    pub(crate) const ONE_PER_FILE: &str = "write the others into files of their own";
    pub(crate) const LISTS: &str = "compare the lists of angles in the header with the rows of data";
    pub(crate) const ANGLE_BASES: &str = "check that the angle bases are those of the data, and that the file is whole";
    pub(crate) const LISTS_OR_CUT: &str =
        "compare the lists of angles with the rows of data; where they agree the file is cut short: export it again";
    pub(crate) const BINARY_BEHIND: &str = "remove the bytes behind the last block; where binary values stand there, \
                                            the lists of angles in the header promise too few";
    pub(crate) const PROPERTY: &str = "check its spelling, in capitals; behind data it may be a value too many, that \
                                       the lists of angles do not promise";
    pub(crate) const SORT: &str = "sort the angles together with their values, and check that they are in degrees";
    pub(crate) const WAVELENGTHS: &str = "sort the wavelengths together with their values, and give them in nm";
    pub(crate) const NOT_FINITE: &str =
        "replace the value by a reading, or leave its direction out: no value may be infinite or undefined";
}
