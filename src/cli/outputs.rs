//! Outputs of a command, checked before any work.

use super::{Failure, Options, Terminal};
use specval::output::{Destination, Lock, beside, expect_scratch, prepare};
use specval::run::input_files;
use specval::study::Study;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Replace {
    /// Replace files that exist. Never an input of the run.
    #[arg(long)]
    pub force: bool,
}

#[derive(Debug, thiserror::Error)]
pub enum StdoutError {
    #[error("--json and an output on stdout: expected one document there; give the output a file, or leave --json out")]
    TwoDocuments,
    #[error(
        "--resume: expected an output with a file, beside which a state is kept, found a stream; name a file with --out"
    )]
    NoState,
}

/// The study's file and every file that it names.
pub fn inputs_of(path: Option<&Path>, study: &Study) -> Vec<PathBuf> {
    let mut files = input_files(study);
    files.extend(path.map(Path::to_owned));
    files
}

/// The places of outputs, in order, and where the summary goes: not to stdout where one of them does.
pub fn claim(
    outputs: &[&Path],
    inputs: &[PathBuf],
    replace: &Replace,
    options: &Options,
) -> Result<(Vec<Destination>, Terminal), Failure> {
    let places = prepare(outputs, inputs, &|_| replace.force)?;
    let on_stdout = places.iter().any(Destination::is_stdout);
    if on_stdout && options.json {
        return Err(StdoutError::TwoDocuments.into());
    }
    Ok((places, Terminal::new(options).beside_output(on_stdout)))
}

/// What a long run leaves beside its output while it lasts: its state, kept from other runs by a lock. Neither is there
/// for an output that is no file.
pub struct Scratch {
    pub state: Option<PathBuf>,
    _lock: Option<Lock>,
}

impl Scratch {
    pub fn take(output: &Path, inputs: &[PathBuf], resume: bool) -> Result<Self, Failure> {
        if !Destination::find(output)?.is_file() {
            return match resume {
                true => Err(StdoutError::NoState.into()),
                false => Ok(Self {
                    state: None,
                    _lock: None,
                }),
            };
        }
        let state = beside(output, ".state");
        let lock = beside(&state, ".lock");
        // What a killed run left is taken over; a file of someone else is not, whatever --force says.
        prepare(&[&state, &lock], inputs, &|_| true)?;
        expect_scratch(&state)?;
        expect_scratch(&lock)?;
        let taken = Lock::take(&lock, &[output.to_owned(), state.clone()])?;
        Ok(Self {
            state: Some(state),
            _lock: Some(taken),
        })
    }
}

/// A path or an argument in words: bytes that are no UTF-8 as `\xNN`, the way `$'...'` of a shell takes them.
pub fn in_words(text: impl AsRef<OsStr>) -> String {
    let mut words = String::new();
    for chunk in text.as_ref().as_encoded_bytes().utf8_chunks() {
        words += chunk.valid();
        for byte in chunk.invalid() {
            words += &format!("\\x{byte:02x}");
        }
    }
    words
}
