//! Notices of a command on its own run; those on the result are [`specval::report::Notice`].

use super::in_words;
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

/// A notice of a run.
pub enum RunNotice {
    /// `measure --full` was typed.
    OldCommand,
    /// The run goes on from the state of an earlier one.
    Resumed { state: PathBuf, batches: usize },
    /// `--resume` without a state.
    NoState { state: PathBuf },
    /// A file of an earlier report that this one does not have.
    Removed { path: PathBuf },
}

impl Display for RunNotice {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::OldCommand => f.write_str("`measure --full` is now the command `bsdf`"),
            Self::Resumed { state, batches } => write!(f, "{}: goes on after {batches} batches", state.display()),
            Self::NoState { state } => {
                write!(
                    f,
                    "{}: no state to go on from; the run starts from its beginning",
                    state.display()
                )
            }
            Self::Removed { path } => write!(f, "{}: of the earlier report in this folder, removed", in_words(path)),
        }
    }
}
