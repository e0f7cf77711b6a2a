/// What is wrong with a study file, or with a study changed after it was read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// Not TOML.
    #[error("{place}: {message}")]
    Syntax { place: Box<FileLine>, message: String },
    /// A key or a section that means nothing.
    #[error("{place}: unknown key `{key}` {section}{} {known}", did_you_mean(.suggestion))]
    UnknownKey {
        place: Box<FileLine>,
        key: String,
        /// `in [medium]`, or `at the top level`.
        section: String,
        known: String,
        suggestion: Option<String>,
    },
    /// A value of another type than the key takes.
    #[error("{place}: `{key}`: expected {expected}, found {found}")]
    Type {
        place: Box<FileLine>,
        key: String,
        expected: String,
        found: String,
    },
    /// A value out of its range, or at odds with another.
    #[error("{}`{key}`: expected {expected}, found {found}; {remedy}", prefix(.place))]
    Value {
        /// None for a study that was not read from a file, or a default.
        place: Option<Box<FileLine>>,
        key: String,
        expected: String,
        found: String,
        remedy: String,
    },
}

/// A line of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileLine {
    pub file: String,
    /// From 1; 0 for a default of what the file leaves out.
    pub line: usize,
}

impl std::fmt::Display for FileLine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.line {
            0 => f.write_str(&self.file),
            line => write!(f, "{}, line {line}", self.file),
        }
    }
}

fn did_you_mean(suggestion: &Option<String>) -> String {
    match suggestion {
        Some(suggestion) => format!(": did you mean {suggestion}? Known keys:"),
        None => "; known keys:".into(),
    }
}

fn prefix(place: &Option<Box<FileLine>>) -> String {
    place.as_ref().map_or(String::new(), |p| format!("{p}: "))
}

/// The error of a study that TOML cannot hold.
pub(super) fn unwritable(error: &toml::ser::Error) -> StudyError {
    StudyError::Value {
        place: None,
        key: "study".into(),
        expected: "values TOML can hold".into(),
        found: error.to_string(),
        remedy: "change the value".into(),
    }
}
