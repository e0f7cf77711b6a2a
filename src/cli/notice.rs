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
    /// A sweep goes on after the points of its table.
    ResumedSweep { path: PathBuf, points: usize },
    /// `--max-time` ended a sweep.
    UnfinishedSweep { points: usize, of: usize },
    /// A file of an earlier report that this one does not have.
    Removed { path: PathBuf },
    /// A file of an earlier report that this one does not have, changed since or not on record.
    Left { path: PathBuf },
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
            Self::ResumedSweep { path, points } => write!(f, "{}: goes on after {points} points", path.display()),
            Self::UnfinishedSweep { points, of } => write!(
                f,
                "--max-time: {points} of {of} points are made; the same command with --resume makes the others"
            ),
            Self::Removed { path } => write!(f, "{}: of the earlier report in this folder, removed", in_words(path)),
            Self::Left { path } => write!(
                f,
                "{}: not of this report; it stays, as it was changed or no report has it on record: remove it if it is \
                 not yours",
                in_words(path)
            ),
        }
    }
}

/// Notices as users read them.
pub fn worded<N: Display>(notices: &[N]) -> impl Iterator<Item = String> {
    notices.iter().map(N::to_string)
}

/// The first of the same words about several spectra, and how many more there are.
pub fn first_of(words: &[String]) -> Option<String> {
    match words {
        [] => None,
        [one] => Some(one.clone()),
        [first, others @ ..] => Some(format!("{first} (and {} more of this kind)", others.len())),
    }
}
